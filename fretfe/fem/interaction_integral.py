# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors by an interaction integral with crack-tip fields around a station of a front."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import dolfinx.mesh
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from ufl.algorithms.analysis import extract_constants

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.crystals import CrackTip, turned
from fretfe.bodies.definition import DistributedLoad
from fretfe.fem._compat import form_on
from fretfe.fem.elasticity import (
    CrystalElasticity,
    ElasticBody,
    Elasticity,
    compiled,
    in_space_of,
    of_dimension,
)

# Distances below this fraction of the reach are zero.
SMALLEST = 1e-9
# Angles below this are equal to their tangents to round-off.
SMALL_ANGLE = 1e-4
# The weight q is 1 up to this fraction of the radius: the singular elements do not count.
INNER = 0.3
# Products of the crack-tip field with polynomials. Tetrahedra are as exact with 24 points as with
# the 46 of degree 8; hexahedra have as many in a plane as the quadrilaterals of a plane mesh.
QUADRATURE_DEGREE = {"triangle": 8, "quadrilateral": 8, "tetrahedron": 6, "hexahedron": 8}
# The faces are left out this close to the tip, in radii: they are straight there, and a quadrature
# point next to the tip would see an angle that is not that of the surface.
BLUNT = 0.02
# No point of a cell or facet is farther from its middle, over its largest extent: 3/4 of a straight
# tetrahedron.
SPAN = 0.8
# How far curved edges leave the box around the nodes of an element, over its size.
BULGE = 0.05
# Sums are reordered and there are no error numbers: a third faster, 1e-11 from the result without.
# Not -ffast-math itself, by which older compilers make a whole process flush small numbers to zero.
COMPILER_FLAGS = (
    "-O3",
    "-g0",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-signed-zeros",
    "-fassociative-math",
    "-freciprocal-math",
)


@dataclass(frozen=True)
class FrontPlace:
    """A place in UFL as seen from the front; all lengths 0 along the front in the plane.

    Attributes:
        axes: rows across, inward, along of the nearest point of the osculating circle.
        turn: the same in the axes of the station; None in the plane.
        height: over the tangent plane.
        ahead: distance from the circle in that plane, positive in the contact.
        arc: along the circle, from the station.
        bend: curvature of the circle through the place.
        stretch: arc of the station's circle per length along that through the place.
        radius: distance from the front, not quite zero.
    """

    axes: Any
    turn: Any
    height: Any
    ahead: Any
    arc: Any
    bend: Any
    stretch: Any
    radius: Any


def front_place(offset: Any, frame: Any, curvature: Any, nothing: Any) -> FrontPlace:
    """Coordinates of a place around a front.

    Args:
        offset: (d,) place less station.
        frame: (d, d) rows across, inward, along of the station.
        curvature: of the front, positive where the contact is convex; of no use in the plane.
        nothing: a length that is zero.
    """
    local = frame * offset
    if len(offset) == 2:
        radius = ufl.sqrt(local[0] ** 2 + local[1] ** 2 + nothing**2)
        return FrontPlace(frame, None, local[0], local[1], 0.0, 0.0, 1.0, radius)
    height, deep, side = local[0], local[1], local[2]
    turned, left = curvature * side, 1 - curvature * deep
    # Distance from the centre of the circle over its radius.
    root = ufl.sqrt(turned**2 + left**2)
    ahead = (2 * deep - curvature * (deep**2 + side**2)) / (1 + root)
    # Half the angle: its tangent is finite but behind the centre.
    tangent = turned / (root + left)
    small = ufl.lt(abs(tangent), SMALL_ANGLE)
    ratio = ufl.conditional(
        small, 1 - tangent**2 / 3, ufl.atan(tangent) / ufl.conditional(small, 1.0, tangent)
    )
    cosine, sine = left / root, turned / root
    turn = ufl.as_matrix([[1, 0, 0], [0, cosine, -sine], [0, sine, cosine]])
    return FrontPlace(
        axes=turn * frame,
        turn=turn,
        height=height,
        ahead=ahead,
        arc=2 * side / (root + left) * ratio,
        bend=curvature / root,
        stretch=1 / root,
        radius=ufl.sqrt(height**2 + ahead**2 + nothing**2),
    )


@dataclass(frozen=True)
class TipField:
    """Field of a unit stress intensity factor in one mode, in the axes of `FrontPlace`.

    Attributes:
        gradient: (d, d) of the displacement.
        stress: (d, d).
        divergence: (d,) of the stress.
    """

    gradient: Any
    stress: Any
    divergence: Any


def tip_fields(
    place: FrontPlace, side: Any, material: Elasticity, nothing: Any, epsilon: Any = None
) -> list[TipField]:
    """Fields of all modes: opening, shear along `inward` and, in space, shear along `along`.

    Args:
        place: where.
        side: 1 in the body above the interface, -1 below.
        material: of the body.
        nothing: a length that is zero.
        epsilon: of full stick between unlike bodies, in the plane; None between similar ones.
    """
    # The branch of the angle is cut through the other body: surfaces are never quite straight.
    lifted = side * place.height + nothing
    angle = ufl.variable(side * (ufl.pi / 2 + ufl.atan2(-place.ahead, lifted)))
    squared = place.ahead**2 + lifted**2
    turns = place.ahead / squared, -side * lifted / squared
    if epsilon is not None:
        return _bimaterial_fields(place, side, angle, turns, material, epsilon)
    sine, cosine, k = ufl.sin(angle / 2), ufl.cos(angle / 2), material.kolosov
    shapes = [
        [sine * (k + 1 - 2 * cosine**2), cosine * (k - 1 + 2 * sine**2), ufl.as_ufl(0)],
        [cosine * (1 - k + 2 * sine**2), sine * (k + 1 + 2 * cosine**2), ufl.as_ufl(0)],
        [ufl.as_ufl(0), ufl.as_ufl(0), 4 * sine],
    ]
    size = place.axes.ufl_shape[0]
    fields = []
    for shape in shapes[:size]:
        slopes = [
            _slopes(place, each, ufl.diff(each, angle), turns, material) for each in shape[:size]
        ]
        values = [_size(place, material) * each for each in shape]
        fields.append(
            _plane(slopes, material) if size == 2 else _bent(place, values, slopes, material)
        )
    return fields


def _bimaterial_fields(
    place: FrontPlace,
    side: Any,
    angle: Any,
    turns: tuple[Any, Any],
    material: Elasticity,
    epsilon: Any,
) -> list[TipField]:
    """Fields of both modes at the edge of a bonded interface of unlike bodies, in the plane.

    With z = x + i y inward and across, 2 mu (u_x + i u_y) = kappa phi(z) - omega(conj z)
    - (z - conj z) conj(phi'(z)), phi' = c e^(s pi epsilon) z^(-1/2 + i epsilon) and omega' =
    c e^(-s pi epsilon) z^(-1/2 + i epsilon), s the side and c = (K_I - i K_II)/(sqrt(8 pi)
    cosh(pi epsilon)): ahead s_yy - i s_xy = (K_I - i K_II) x^(-1/2 + i epsilon)/sqrt(2 pi)
    (Rice and Sih 1965), free of tractions behind.
    """
    logarithm = ufl.variable(ufl.ln(place.radius))
    k, grown = material.kolosov, ufl.exp(epsilon * (side * ufl.pi - angle))
    real = (k * grown - 1 / grown) * ufl.cos(angle / 2)
    imaginary = (k * grown + 1 / grown) * ufl.sin(angle / 2)
    c, s = ufl.cos(epsilon * logarithm), ufl.sin(epsilon * logarithm)
    over = 0.25 + epsilon**2
    # e^(i epsilon ln r)/(1/2 + i epsilon) times both.
    g, h = (c / 2 + epsilon * s) / over, (s / 2 - epsilon * c) / over
    straight, across = g * real - h * imaginary, g * imaginary + h * real
    lag, apart = angle / 2 - epsilon * logarithm, 2 * ufl.sin(angle) * grown
    m, n = apart * ufl.sin(lag), -apart * ufl.cos(lag)
    scale = 2 * ufl.cosh(ufl.pi * epsilon)
    shapes = [[across + n, straight + m], [m - straight, across - n]]
    fields = []
    for shape in shapes:
        slopes = [
            _slopes(
                place,
                each / scale,
                ufl.diff(each, angle) / scale,
                turns,
                material,
                ufl.diff(each, logarithm) / scale,
            )
            for each in shape
        ]
        fields.append(_plane(slopes, material))
    return fields


def _size(place: FrontPlace, material: Elasticity) -> Any:
    return ufl.sqrt(place.radius / (2 * ufl.pi)) / (2 * material.shear_modulus)


def _slopes(
    place: FrontPlace,
    shape: Any,
    turning: Any,
    turns: tuple[Any, Any],
    material: Elasticity,
    growing: Any = 0,
) -> list[Any]:
    """Slopes across and inward of a component sqrt(r/2 pi)/(2 mu) times a function of the angle.

    Args:
        place: where.
        shape: the function.
        turning: its derivative.
        turns: slopes of the angle.
        material: of the body.
        growing: derivative of the function by ln r.
    """
    growth = place.height, place.ahead
    return [
        _size(place, material)
        * ((shape / 2 + growing) * grown / place.radius**2 + turning * turned)
        for grown, turned in zip(growth, turns, strict=True)
    ]


def _plane(slopes: list[list[Any]], material: Elasticity | CrystalElasticity) -> TipField:
    """The field of a straight front in the plane."""
    gradient = ufl.as_matrix(slopes)
    return TipField(gradient, material.stress(ufl.sym(gradient)), ufl.as_vector([0, 0]))


def _bent(
    place: FrontPlace, values: list[Any], slopes: list[list[Any]], material: Elasticity
) -> TipField:
    """The field along a front in space; values (3,) and slopes (3, 2) of its components."""
    bend, inward, along = place.bend, values[1], values[2]
    turned = (0, bend * along, -bend * inward)
    gradient = ufl.as_matrix([[*row, last] for row, last in zip(slopes, turned, strict=True)])
    stress = material.stress(ufl.sym(gradient))
    # Slopes of what the bend adds to the strain: a stretch along the front, and a shear.
    stretch_across = -bend * slopes[1][0]
    stretch_inward = -bend * (bend * inward + slopes[1][1])
    shear_inward = bend * (bend * along + slopes[2][1])
    divergence = ufl.as_vector(
        [
            material.first_lame * stretch_across - bend * stress[0, 1],
            material.first_lame * stretch_inward + bend * (stress[2, 2] - stress[1, 1]),
            material.shear_modulus * shear_inward - 2 * bend * stress[1, 2],
        ]
    )
    return TipField(gradient, stress, divergence)


# A complex number in UFL, or of constants: real and imaginary part.
Complex = tuple[Any, Any]


class CrystalTip:
    """Constants of `CrackTip` at the station that is looked at, in UFL.

    Args:
        mesh: of the body.
        stiffness: (6, 6) of the body in the axes of the model.
    """

    def __init__(self, mesh: Any, stiffness: Array) -> None:
        size = mesh.geometry.dim
        self._given, self._size = stiffness, size
        # In the axes of the station.
        self._stiffness = fem.Constant(mesh, of_dimension(stiffness, size))
        self._roots = fem.Constant(mesh, np.zeros((2, size)))
        # With powers 0, 1 and 2 of the roots: slopes along the normal bring one each.
        self._shapes = fem.Constant(mesh, np.zeros((3, 2, size, size, size)))

    def look_at(self, frame: Array) -> None:
        """Take the constants of a station with a frame (d, d)."""
        whole = np.eye(3)
        whole[: self._size, : self._size] = frame
        own = turned(self._given, whole)
        self._stiffness.value[:] = of_dimension(own, self._size)
        tip = CrackTip.of(own, self._size)
        powers = np.array([tip.shapes * tip.roots**power for power in range(3)])
        self._roots.value[:] = tip.roots.real, tip.roots.imag
        self._shapes.value[:] = np.stack([powers.real, powers.imag], axis=1)

    def elasticity(self, place: FrontPlace) -> CrystalElasticity:
        """Hooke's law in the axes of a place."""
        return CrystalElasticity(self._stiffness, place.turn)

    def fields(self, place: FrontPlace, side: Any, nothing: Any) -> list[TipField]:
        """Fields of all modes; arguments as of `tip_fields`."""
        material = self.elasticity(place)
        height = place.height + side * nothing
        roots = [self._square_root(place.ahead, height, side, a) for a in range(self._size)]
        inverses = [_inverse(root) for root in roots]
        cubes = [_product(each, _product(each, each)) for each in inverses]
        fields = []
        for mode in range(self._size):
            slopes = [
                [self._component(mode, i, power, inverses) / 2 for power in (1, 0)]
                for i in range(self._size)
            ]
            if self._size == 2:
                fields.append(_plane(slopes, material))
                continue
            values = [self._component(mode, i, 0, roots) for i in range(3)]
            curved = [
                [-self._component(mode, i, power, cubes) / 4 for power in (2, 1, 0)]
                for i in range(3)
            ]
            fields.append(_bent_crystal(place, values, slopes, curved, material))
        return fields

    def _square_root(self, ahead: Any, height: Any, side: Any, root: int) -> Complex:
        """Root of x + p y, cut through the other body."""
        real, imaginary = ahead + self._roots[0, root] * height, self._roots[1, root] * height
        size = ufl.sqrt(real**2 + imaginary**2)
        first = ufl.sqrt((size + side * imaginary) / 2)
        second = -side * real / (2 * first)
        return (first - side * second) / np.sqrt(2), (side * first + second) / np.sqrt(2)

    def _component(self, mode: int, component: int, power: int, values: list[Complex]) -> Any:
        """sqrt(2/pi) Re sum of c p^power times values of each root."""
        shapes = self._shapes
        return np.sqrt(2 / np.pi) * sum(
            shapes[power, 0, mode, component, a] * real - shapes[power, 1, mode, component, a] * im
            for a, (real, im) in enumerate(values)
        )


def _inverse(number: Complex) -> Complex:
    squared = number[0] ** 2 + number[1] ** 2
    return number[0] / squared, -number[1] / squared


def _product(one: Complex, other: Complex) -> Complex:
    return one[0] * other[0] - one[1] * other[1], one[0] * other[1] + one[1] * other[0]


def _bent_crystal(
    place: FrontPlace,
    values: list[Any],
    slopes: list[list[Any]],
    curved: list[list[Any]],
    material: CrystalElasticity,
) -> TipField:
    """The field along a front in space of a crystal, which does not turn with the front.

    Args:
        place: where.
        values: (3,) components of the displacement, the same all along the front.
        slopes: (3, 2) their slopes across and inward.
        curved: (3, 3) their second derivatives: twice across, across and inward, twice inward.
        material: of the body, in the axes of the place.
    """
    bend, (_, inward, along) = place.bend, values
    by_turning = [0, bend * along, -bend * inward]
    gradient = ufl.as_matrix([[*row, last] for row, last in zip(slopes, by_turning, strict=True)])
    strain = ufl.sym(gradient)
    stress = material.stress(strain)
    by_across = [0, bend * slopes[2][0], -bend * slopes[1][0]]
    by_inward = [
        0,
        bend * (bend * along + slopes[2][1]),
        -bend * (bend * inward + slopes[1][1]),
    ]
    across, ahead = (
        material.stress(ufl.sym(ufl.as_matrix(rows)))
        for rows in (
            [[two, mixed, last] for (two, mixed, _), last in zip(curved, by_across, strict=True)],
            [[mixed, two, last] for (_, mixed, two), last in zip(curved, by_inward, strict=True)],
        )
    )
    turn = bend * ufl.as_matrix([[0, 0, 0], [0, 0, 1], [0, -1, 0]])
    beside = material.stress(2 * ufl.sym(turn * strain))
    divergence = ufl.as_vector([across[i, 0] + ahead[i, 1] + beside[i, 2] for i in range(3)])
    return TipField(gradient, stress, divergence)


@dataclass(frozen=True)
class Tip:
    """A station as a body sees it.

    Attributes:
        point: (d,) the station on the body's surface.
        frame: (d, d) unit vectors, in the order of `Factor`: normal of the surface from body 2 to
            body 1, tangent of it from the front into the contact, in space tangent of the front.
        curvature: of the front in the tangent plane, positive where the contact is convex; 0 in the
            plane.
    """

    point: Array
    frame: Array
    curvature: float = 0.0


@dataclass(frozen=True)
class Tube:
    """Surroundings of a station over which is integrated.

    Attributes:
        reach: largest distance from the front.
        half_length: largest distance along the front from the station; without meaning in the
            plane.
    """

    reach: float
    half_length: float = np.inf


def _front_coordinates(places: Array, tip: Tip) -> tuple[Array, Array, Array]:
    """(m,) heights of places (m, d), distances inward from the front, and along it; 0 in plane."""
    height, ahead, *sides = ((places - tip.point) @ tip.frame.T).T
    if not sides:
        return height, ahead, np.zeros_like(ahead)
    (side,) = sides
    turned, left = tip.curvature * side, 1 - tip.curvature * ahead
    squared = ahead**2 + side**2
    inward = (2 * ahead - tip.curvature * squared) / (1 + np.hypot(turned, left))
    arc = np.arctan2(turned, left) / tip.curvature if tip.curvature else side
    return height, inward, np.asarray(arc)


class _Places:
    """Places of some entities of a mesh.

    Args:
        mesh: mesh.
        dim: dimension of the entities.
        entities: their numbers on this rank.
    """

    def __init__(self, mesh: Any, dim: int, entities: npt.NDArray[np.int32]) -> None:
        self._entities = entities
        middles = dolfinx.mesh.compute_midpoints(mesh, dim, entities)
        self._middles = middles[:, : mesh.geometry.dim]
        self._sizes = SPAN * mesh.h(dim, entities)
        self._points = mesh.geometry.x[:, : mesh.geometry.dim]
        self._nodes = dolfinx.mesh.entities_to_geometry(mesh, dim, entities)

    def within(self, tip: Tip, tube: Tube, inner: float) -> npt.NDArray[np.int32]:
        """Entities that may have points in a tube, not nearer to the front than `inner`."""
        height, ahead, arc = _front_coordinates(self._middles, tip)
        distance = np.hypot(height, ahead)
        near = (distance > inner - self._sizes) & (distance < tube.reach + self._sizes)
        near &= np.abs(arc) < tube.half_length + self._sizes
        rows = np.flatnonzero(near)
        if len(tip.point) == 3:
            # Elements may be much longer along a front than across it.
            rows = rows[self._reached(rows, tip, tube)]
        return self._entities[rows]

    def _reached(self, rows: Indices, tip: Tip, tube: Tube) -> Bools:
        """(m,) whether the boxes around some entities, along the axes of a tube, reach into it."""
        nodes = self._nodes[rows]
        places = _front_coordinates(self._points[nodes.ravel()], tip)
        low, high = (
            np.array([extreme(each.reshape(nodes.shape), axis=1) for each in places])
            for extreme in (np.min, np.max)
        )
        # Edges are curved a little.
        room = BULGE * (high - low)
        nearest = np.maximum(np.maximum(low - room, -(high + room)), 0.0)
        return np.asarray(
            (np.hypot(nearest[0], nearest[1]) < tube.reach) & (nearest[2] < tube.half_length)
        )


@dataclass(frozen=True)
class _Surroundings:
    """Station, tip fields and weight in UFL.

    Attributes:
        place: a place.
        fields: of all modes.
        material: of the body.
        weight: q.
        slopes: (d,) of q.
        normal: (d,) of the surface, in the axes of the front.
        opened: q on open surfaces, 0 elsewhere.
        dx: over the volume.
        ds: over the surface.
    """

    place: FrontPlace
    fields: list[TipField]
    material: Elasticity | CrystalElasticity
    weight: Any
    slopes: list[Any]
    normal: Any
    opened: Any
    dx: Any
    ds: Any


class InteractionForm:
    """The interaction integral of one body as a linear functional of its displacement and loads.

    Construction is collective.

    Args:
        elastic: the body.
        surfaces: names of its contact surfaces.
        upper: whether it is body 1 of the contact.
        loads: distributed loads, whose initial strains and body forces count.
        oscillation: epsilon of full stick with the other body; zero if that is similar.
    """

    def __init__(
        self,
        elastic: ElasticBody,
        surfaces: list[str],
        upper: bool,
        loads: Sequence[DistributedLoad] = (),
        oscillation: float = 0.0,
    ) -> None:
        mesh, size = elastic.mesh, elastic.gdim
        self._size = size
        # One test function for each mode: what they have in common is computed once.
        self._space = fem.functionspace(mesh, ("Lagrange", elastic.degree, (size, size)))
        self._numbers = _numbers(self._space, elastic.space)
        self._point, self._frame = (
            fem.Constant(mesh, np.zeros((size,) * order)) for order in (1, 2)
        )
        self._curvature, self._reach, self._half_length = (fem.Constant(mesh, 1.0) for _ in "123")
        self._side = fem.Constant(mesh, 1.0 if upper else -1.0)
        # Similar bodies keep their simpler fields.
        self._epsilon = fem.Constant(mesh, oscillation) if oscillation else None
        dim = mesh.topology.dim
        cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
        facets = np.concatenate([elastic.boundary_facets(name) for name in surfaces])
        self._cells, self._facets = _Places(mesh, dim, cells), _Places(mesh, dim - 1, facets)
        self._crystal: CrystalTip | None = None
        around = self._surroundings(elastic)
        integral = self._integral(around)
        self._constants = extract_constants(integral)
        self._compiled = compiled(
            mesh.comm, fem.compile_form, mesh.comm, integral, flags=COMPILER_FLAGS
        )
        # Of each load the stress of its initial strain, and its body force.
        self._of_loads = [
            (elastic.initial_stress(load), elastic.body_force(load)) for load in loads
        ]
        if any(each is not None for pair in self._of_loads for each in pair):
            self._whole = fem.functionspace(mesh, ("DG", 0, (size,)))
            self._held = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (3, 3))))
            self._force = fem.Function(
                fem.functionspace(mesh, ("Lagrange", elastic.order, (size,)))
            )
            integral = self._load_integral(around)
            self._load_constants = extract_constants(integral)
            self._compiled_loads = compiled(
                mesh.comm, fem.compile_form, mesh.comm, integral, flags=COMPILER_FLAGS
            )

    def products(self, tip: Tip, tube: Tube, displacements: Array) -> Array:
        """(d, n) what this rank adds to this body's part of I, for each mode and displacement.

        Args:
            tip: the station.
            tube: what to integrate over.
            displacements: (m, d, n) of the body's nodes on this rank, owned and ghosted.
        """
        self._look_at(tip, tube)
        # Where the weight is 1 there is nothing to count in the plane; in space it varies along the
        # front.
        inner = INNER * tube.reach if self._size == 2 else 0.0
        cells = self._cells.within(tip, tube, inner)
        facets = self._facets.within(tip, tube, 0.0)
        form = form_on(self._compiled, self._space, self._constants, cells, facets)
        vector = np.zeros(len(self._numbers) * self._size**2)
        fem.assemble_vector(vector, form)
        links = self._space.mesh.topology.connectivity(self._size - 1, self._size)
        beside = links.array[links.offsets[facets]]
        nodes = np.unique(self._space.dofmap.list[np.concatenate([cells, beside])])
        functionals = vector.reshape(-1, self._size, self._size)[nodes]
        return np.einsum("nmk,nkj->mj", functionals, displacements[self._numbers[nodes]])

    def load_products(self, tip: Tip, tube: Tube) -> Array:
        """(d, l) what this rank adds to I for each mode by a unit of each load of the body.

        That is what initial strains and body forces add to the integral over displacements, in
        which the stress is that of the whole strain.
        """
        found = np.zeros((self._size, len(self._of_loads)))
        self._look_at(tip, tube)
        for number, parts in enumerate(self._of_loads):
            if all(part is None for part in parts):
                continue
            given = self._held, self._force
            for function, part in zip(given, parts, strict=True):
                function.x.array[:] = 0.0 if part is None else part.x.array
            cells = self._cells.within(tip, tube, 0.0)
            facets = self._facets.within(tip, tube, 0.0)
            form = form_on(
                self._compiled_loads, self._whole, self._load_constants, cells, facets, given
            )
            vector = np.zeros(len(self._whole.dofmap.list) * self._size)
            fem.assemble_vector(vector, form)
            found[:, number] = vector.reshape(-1, self._size).sum(axis=0)
        return found

    def _look_at(self, tip: Tip, tube: Tube) -> None:
        self._point.value[:] = tip.point
        if self._crystal is not None and not np.array_equal(self._frame.value, tip.frame):
            self._crystal.look_at(tip.frame)
        self._frame.value[:] = tip.frame
        self._curvature.value = tip.curvature
        self._reach.value = tube.reach
        self._half_length.value = tube.half_length

    def _surroundings(self, elastic: ElasticBody) -> _Surroundings:
        mesh = elastic.mesh
        metadata = {"quadrature_degree": QUADRATURE_DEGREE[mesh.topology.cell_name()]}
        dx, ds = (
            ufl.Measure(kind, mesh, subdomain_id=1, metadata=metadata) for kind in ("dx", "ds")
        )
        # A quadrature point may fall on the tip, where the field has no gradient.
        nothing = SMALLEST * self._reach
        offset = ufl.SpatialCoordinate(mesh) - self._point
        place = front_place(offset, self._frame, self._curvature, nothing)
        material: Elasticity | CrystalElasticity
        if elastic.material.crystal is None:
            material = Elasticity.of(mesh, elastic.material)
            tips = tip_fields(place, self._side, material, nothing, self._epsilon)
        else:
            self._crystal = CrystalTip(mesh, elastic.material.stiffness)
            material = self._crystal.elasticity(place)
            tips = self._crystal.fields(place, self._side, nothing)
        weight, slopes = self._weight(place)
        return _Surroundings(
            place=place,
            fields=tips,
            material=material,
            weight=weight,
            slopes=slopes,
            normal=place.axes * ufl.FacetNormal(mesh),
            opened=ufl.conditional(ufl.lt(place.ahead, -BLUNT * self._reach), weight, 0.0),
            dx=dx,
            ds=ds,
        )

    def _integral(self, around: _Surroundings) -> Any:
        place, slope = around.place, ufl.grad(ufl.TestFunction(self._space))
        inside = [_volume_flux(around, field) for field in around.fields]
        leak = [_face_flux(field, around.normal) for field in around.fields]
        whole, lost = (
            sum(
                ufl.inner(place.axes.T * flux * place.axes, slope[mode, :, :])
                for mode, flux in enumerate(fluxes)
            )
            for fluxes in (inside, leak)
        )
        return whole * around.dx - around.opened * lost * around.ds

    def _load_integral(self, around: _Surroundings) -> Any:
        """The part of body forces b and initial strains e0, these by their stress s0 = D e0.

        With the stress s = D (e - e0), the crack-tip field (a) and the extension v = q times the
        direction ahead,

            I = int (s_ij ua_i,k v_k,j + sa_ij u_i,k v_k,j - sa:(e - e0) v_k,k)
                + (sa:e0,k - b_i ua_i,k) v_k dV

        and what is lost through open surfaces; sa:e0 = ea:s0.
        """
        axes, test = around.place.axes, ufl.TestFunction(self._whole)
        given = in_space_of(self._held, self._size)
        held = axes * given * axes.T
        ahead = ufl.as_vector([float(axis == 1) for axis in range(self._size)])
        growth = axes * ufl.dot(ufl.grad(given), axes.T * ahead) * axes.T
        spread = _spread(around)
        inside, leak = [], []
        for field in around.fields:
            strain = ufl.sym(field.gradient)
            inside.append(
                ufl.inner(strain, ufl.tr(spread) * held + around.weight * growth)
                - ufl.inner(held, field.gradient * spread)
                - around.weight * ufl.inner(axes * self._force, field.gradient * ahead)
            )
            leak.append(around.normal[1] * ufl.inner(strain, held))
        whole, lost = (
            sum(test[m] * each for m, each in enumerate(parts)) for parts in (inside, leak)
        )
        return whole * around.dx - around.opened * lost * around.ds

    def _weight(self, place: FrontPlace) -> tuple[Any, list[Any]]:
        """The weight q and its slopes (d,) in the axes of the front.

        From 1 to 0 between the inner radius and the reach, twice differentiable; in space times a
        weight along the front over its integral.
        """
        width = (1 - INNER) * self._reach
        t = (place.radius - INNER * self._reach) / width
        t = ufl.max_value(0.0, ufl.min_value(1.0, t))
        around, slope = 1 - t**3 * (10 - 15 * t + 6 * t**2), -30 * (t * (1 - t)) ** 2 / width
        slopes = [slope * each / place.radius for each in (place.height, place.ahead)]
        if self._size == 2:
            return around, slopes
        t = place.arc / self._half_length
        t = ufl.max_value(-1.0, ufl.min_value(1.0, t))
        # Without a second moment: the mean of a factor that varies along the front with the square
        # of the distance is that at the station. 105/64 makes the integral 1.
        part = 105 / 64 * (1 - t**2) / self._half_length
        along, fall = part * (1 - t**2) * (1 - 3 * t**2), -2 * part * t * (5 - 9 * t**2)
        slopes = [each * along for each in slopes]
        return around * along, [*slopes, around * fall * place.stretch / self._half_length]


# By body, whether it is body 1, and epsilon: it may be body 1 of one contact and body 2 of another.
Forms = dict[tuple[str, bool, float], InteractionForm]


def _spread(around: _Surroundings) -> Any:
    """(d, d) gradient of the extension of the crack, q along the direction ahead."""
    size = len(around.slopes)
    spread = np.full((size, size), 0, dtype=object)
    spread[1] = around.slopes
    if size == 3:
        spread[2, 2] = -around.place.bend * around.weight
    return ufl.as_matrix(spread.tolist())


def _volume_flux(around: _Surroundings, field: TipField) -> Any:
    """(d, d) what the gradient of the displacement is multiplied with, in the axes of the front."""
    spread, weight = _spread(around), around.weight
    flux = around.material.stress(ufl.sym(field.gradient * spread)) + field.stress * spread.T
    flux -= ufl.tr(spread) * field.stress
    ahead = ufl.as_vector([weight if axis == 1 else 0 for axis in range(len(around.slopes))])
    return flux + ufl.outer(field.divergence, ahead)


def _face_flux(field: TipField, normal: Any) -> Any:
    """(d, d) the same of an open surface with a normal (d,) in those axes, for a weight of 1."""
    size = normal.ufl_shape[0]
    ahead = ufl.as_vector([1 if axis == 1 else 0 for axis in range(size)])
    return ufl.outer(field.stress * normal, ahead) - normal[1] * field.stress


def _numbers(tested: fem.FunctionSpace, space: fem.FunctionSpace) -> npt.NDArray[np.int32]:
    """(m,) number in `space` of each node of `tested`, which has more components."""
    numbers = np.empty(
        tested.dofmap.index_map.size_local + tested.dofmap.index_map.num_ghosts, dtype=np.int32
    )
    numbers[tested.dofmap.list.ravel()] = space.dofmap.list.ravel()
    return numbers
