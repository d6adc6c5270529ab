# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors by an interaction integral with crack-tip fields around a station of a front."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import basix.ufl
import dolfinx.mesh
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from ufl.algorithms.analysis import extract_coefficients, extract_constants

from fretfe._typing import Array, Indices
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.fem._compat import ElementVectors, entity_nodes, exterior_sides
from fretfe.fem.elasticity import (
    CrystalElasticity,
    ElasticBody,
    Elasticity,
    compiled,
    in_space_of,
    padded,
    squared,
)
from fretfe.fem.tip_fields import (
    CrystalTip,
    FrontPlace,
    TipField,
    front_place,
    tip_fields,
)

# Distances below this fraction of the reach are zero.
SMALLEST = 1e-9
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


@dataclass(frozen=True)
class Tip:
    """A station as a body sees it.

    Attributes:
        point: (d,) the station on the body's surface.
        frame: (c, c) unit vectors, in the order of `Factor`: normal of the surface from body 2 to
            body 1, tangent of it from the front into the contact, tangent of the front unless the
            displacement has c = 2 components only.
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
    axes = tip.frame[:, : places.shape[1]]
    height, ahead, *sides = ((places - tip.point) @ axes[: places.shape[1]].T).T
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
        entities: (n,) their numbers on this rank.
    """

    def __init__(self, mesh: Any, dim: int, entities: npt.NDArray[np.int32]) -> None:
        middles = dolfinx.mesh.compute_midpoints(mesh, dim, entities)
        self._middles = middles[:, : mesh.geometry.dim]
        self._sizes = SPAN * mesh.h(dim, entities)
        self._points = mesh.geometry.x[:, : mesh.geometry.dim]
        self._nodes = entity_nodes(mesh, dim, entities)

    def around(self, tip: Tip, tubes: Sequence[Tube]) -> _Nearby:
        """Those that may have points in some tubes around a station."""
        along = max(tube.half_length for tube in tubes) if len(tip.point) == 3 else 0.0
        away = self._middles - tip.point
        ball = max(tube.reach for tube in tubes) + along + self._sizes
        rows = np.flatnonzero(np.einsum("nd,nd->n", away, away) < ball**2)
        height, ahead, arc = _front_coordinates(self._middles[rows], tip)
        distance, sizes = np.hypot(height, ahead), self._sizes[rows]
        nearby = _Nearby(rows, distance - sizes, distance + sizes, np.abs(arc) - sizes)
        if len(tip.point) == 2:
            return nearby
        # Elements may be much longer along a front than across it.
        possible = np.unique(np.concatenate([nearby.within(tube) for tube in tubes]))
        nearby = _Nearby(*(each[possible] for each in vars(nearby).values()))
        return self._boxed(nearby, tip)

    def _boxed(self, nearby: _Nearby, tip: Tip) -> _Nearby:
        """The same by boxes around the nodes of the entities, along the axes of a station."""
        nodes = self._nodes[nearby.rows]
        places = _front_coordinates(self._points[nodes.ravel()], tip)
        low, high = (
            np.array([extreme(each.reshape(nodes.shape), axis=1) for each in places])
            for extreme in (np.min, np.max)
        )
        # Edges are curved a little.
        room = BULGE * (high - low)
        across, ahead, along = np.maximum(np.maximum(low - room, -(high + room)), 0.0)
        return replace(
            nearby,
            nearest=np.maximum(nearby.nearest, np.hypot(across, ahead)),
            along=np.maximum(nearby.along, along),
        )


@dataclass(frozen=True)
class _Nearby:
    """Entities around a station.

    Attributes:
        rows: (n,) of them in `_Places`.
        nearest, farthest: (n,) bounds of the distances of their points from the front.
        along: (n,) lower bound of those along the front from the station.
    """

    rows: Indices
    nearest: Array
    farthest: Array
    along: Array

    def within(self, tube: Tube, inner: float = 0.0) -> Indices:
        """(m,) which of them may have points in a tube, not nearer to the front than `inner`."""
        inside = (self.nearest < tube.reach) & (self.along < tube.half_length)
        return np.flatnonzero(inside & (self.farthest > inner))


@dataclass(frozen=True)
class _Surroundings:
    """Station, tip fields and weight in UFL.

    Attributes:
        place: a place.
        fields: of all modes.
        material: of the body.
        weight: q.
        slopes: (c,) of q.
        normal: (c,) of the surface, in the axes of the front.
        opened: q on open surfaces, 0 elsewhere.
        stuck: q on surfaces in contact, 0 elsewhere.
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
    stuck: Any
    dx: Any
    ds: Any


class InteractionForm:
    """The interaction integral of one body as a linear functional of its displacement and loads.

    Construction is collective.

    Args:
        elastic: the body.
        surfaces: names of its contact surfaces.
        upper: whether it is body 1 of the contact.
        loads: spread loads, whose initial strains and body forces count.
        oscillation: epsilon of full stick with the other body; zero if that is similar.
        excess: of the first Lamé constant of the body over the mean of both; counts in space where
            epsilon is not zero.
    """

    def __init__(
        self,
        elastic: ElasticBody,
        surfaces: list[str],
        upper: bool,
        loads: Sequence[SpreadLoad] = (),
        oscillation: float = 0.0,
        excess: float = 0.0,
    ) -> None:
        mesh, size = elastic.mesh, elastic.components
        self._mesh, self._size, self._dimension = mesh, size, elastic.gdim
        # One test function for each mode: what they have in common is computed once.
        self._test = _test_function(mesh, "Lagrange", elastic.degree, (size, size))
        self._nodes = elastic.space.dofmap.list
        self._point = fem.Constant(mesh, np.zeros(elastic.gdim))
        self._frame = fem.Constant(mesh, np.zeros((size, size)))
        self._curvature, self._reach, self._half_length = (fem.Constant(mesh, 1.0) for _ in "123")
        self._side = fem.Constant(mesh, 1.0 if upper else -1.0)
        # Similar bodies keep their simpler fields.
        self._epsilon = fem.Constant(mesh, oscillation) if oscillation else None
        held = oscillation and elastic.gdim == 3
        self._excess = fem.Constant(mesh, excess) if held else None
        dim = mesh.topology.dim
        cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
        facets = np.concatenate([elastic.boundary_facets(name) for name in surfaces])
        self._sides = exterior_sides(mesh, facets)
        mesh.topology.create_connectivity(dim, dim - 1)
        of_cell = mesh.topology.connectivity(dim, dim - 1)
        facets = of_cell.array[of_cell.offsets[self._sides[:, 0]] + self._sides[:, 1]]
        self._cells, self._facets = _Places(mesh, dim, cells), _Places(mesh, dim - 1, facets)
        self._crystal: CrystalTip | None = None
        around = self._surroundings(elastic)
        integral = self._integral(around)
        self._constants = extract_constants(integral)
        width = self._nodes.shape[1] * size**2
        self._vectors = ElementVectors(self._compiled(integral), mesh, width)
        # Of each load the stress of its initial strain, and its body force.
        self._of_loads = [
            (elastic.initial_stress(load), elastic.body_force(load)) for load in loads
        ]
        if any(each is not None for pair in self._of_loads for each in pair):
            self._held = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (3, 3))))
            self._force = fem.Function(
                fem.functionspace(mesh, ("Lagrange", elastic.order, (size,)))
            )
            integral = self._load_integral(around)
            self._load_constants = extract_constants(integral)
            given = extract_coefficients(integral)
            self._load_vectors = ElementVectors(self._compiled(integral), mesh, size, given)

    def _compiled(self, integral: Any) -> Any:
        comm = self._mesh.comm
        return compiled(comm, fem.compile_form, comm, integral)

    def products(self, tip: Tip, tubes: Sequence[Tube], displacements: Array) -> Array:
        """(R, c, n) what this rank adds to this body's part of I, by mode and displacement.

        Args:
            tip: the station.
            tubes: R of them to integrate over.
            displacements: (m, c, n) of the body's nodes on this rank, owned and ghosted.
        """
        cells, sides = self._cells.around(tip, tubes), self._facets.around(tip, tubes)
        # Where elements are long along the front, some of the tubes are the same.
        distinct = dict.fromkeys(tubes)
        found = np.zeros((len(distinct), self._size, displacements.shape[2]))
        for whole, tube in zip(found, distinct, strict=True):
            self._look_at(tip, tube)
            constants = _values(self._constants)
            # Where the weight is 1 there is nothing to count in the plane; in space it varies along
            # the front.
            inner = INNER * tube.reach if self._dimension == 2 else 0.0
            own = cells.rows[cells.within(tube, inner)]
            whole += self._product(self._vectors.on_cells(constants, own), own, displacements)
            beside = self._sides[sides.rows[sides.within(tube)]]
            lost = self._vectors.on_sides(constants, beside)
            whole += self._product(lost, beside[:, 0], displacements)
        return found[[list(distinct).index(tube) for tube in tubes]]

    def _product(
        self, vectors: Array, cells: npt.NDArray[np.integer[Any]], displacements: Array
    ) -> Array:
        """(c, n) sum over the nodes of cells of their element vectors times displacements."""
        modes = vectors.reshape(-1, self._size, self._size).swapaxes(0, 1).reshape(self._size, -1)
        moved = displacements[self._nodes[cells].ravel()]
        return np.asarray(modes @ moved.reshape(modes.shape[1], displacements.shape[2]))

    def load_products(self, tip: Tip, tubes: Sequence[Tube]) -> Array:
        """(R, c, l) what this rank adds to I for each mode by a unit of each load of the body.

        That is what initial strains and body forces add to the integral over displacements, in
        which the stress is that of the whole strain.
        """
        found = np.zeros((len(tubes), self._size, len(self._of_loads)))
        loading = [
            (number, parts)
            for number, parts in enumerate(self._of_loads)
            if any(part is not None for part in parts)
        ]
        if not loading:
            return found
        cells, sides = self._cells.around(tip, tubes), self._facets.around(tip, tubes)
        for whole, tube in zip(found, tubes, strict=True):
            self._look_at(tip, tube)
            constants = _values(self._load_constants)
            own = cells.rows[cells.within(tube)]
            beside = self._sides[sides.rows[sides.within(tube)]]
            for number, parts in loading:
                for function, part in zip((self._held, self._force), parts, strict=True):
                    function.x.array[:] = 0.0 if part is None else part.x.array
                whole[:, number] += self._load_vectors.on_cells(constants, own).sum(axis=0)
                whole[:, number] += self._load_vectors.on_sides(constants, beside).sum(axis=0)
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
        lift = self._side * SMALLEST * self._reach
        offset = ufl.SpatialCoordinate(mesh) - self._point
        place = front_place(offset, self._frame, self._curvature, lift)
        material: Elasticity | CrystalElasticity
        if elastic.material.crystal is None:
            material = Elasticity.of(mesh, elastic.material)
            tips = tip_fields(place, self._side, material, self._epsilon)
        else:
            self._crystal = CrystalTip(mesh, elastic.material.stiffness, self._size)
            material = self._crystal.elasticity(place)
            tips = self._crystal.fields(place, self._side)
        weight, slopes = self._weight(place)
        return _Surroundings(
            place=place,
            fields=tips,
            material=material,
            weight=weight,
            slopes=slopes,
            normal=place.axes * padded(ufl.FacetNormal(mesh), self._size),
            opened=ufl.conditional(ufl.lt(place.ahead, -BLUNT * self._reach), weight, 0.0),
            stuck=ufl.conditional(ufl.gt(place.ahead, 0.0), weight, 0.0),
            dx=dx,
            ds=ds,
        )

    def _integral(self, around: _Surroundings) -> Any:
        place, slope = around.place, ufl.grad(self._test)
        inside = [_volume_flux(around, field) for field in around.fields]
        leak = [_face_flux(field, around.normal) for field in around.fields]
        whole, lost = (
            sum(
                ufl.inner(place.axes.T * flux * place.axes, squared(slope[mode, :, :]))
                for mode, flux in enumerate(fluxes)
            )
            for fluxes in (inside, leak)
        )
        whole = whole * around.dx - around.opened * lost * around.ds
        if self._excess is None:
            return whole
        held = sum(
            ufl.inner(place.axes.T * self._held_flux(around, field) * place.axes, slope[mode, :, :])
            for mode, field in enumerate(around.fields)
        )
        return whole - around.stuck * held * around.ds

    def _held_flux(self, around: _Surroundings, field: TipField) -> Any:
        """(d, d) what the bend of the front makes of the tractions between unlike bodies.

        The stretch along a bent front presses the two surfaces differently where their first Lamé
        constants differ: the crack-tip fields then have a jump of the traction ahead. Each body
        takes its share of it, as far as that is more than the mean of both.
        """
        stretch = -around.place.bend * field.inward
        ahead = ufl.as_vector([0, 1, 0])
        return ufl.outer(self._excess * stretch * around.normal, ahead)

    def _load_integral(self, around: _Surroundings) -> Any:
        """The part of body forces b and initial strains e0, these by their stress s0 = D e0.

        With the stress s = D (e - e0), the crack-tip field (a) and the extension v = q times the
        direction ahead,

            I = int (s_ij ua_i,k v_k,j + sa_ij u_i,k v_k,j - sa:(e - e0) v_k,k)
                + (sa:e0,k - b_i ua_i,k) v_k dV

        and what is lost through open surfaces; sa:e0 = ea:s0.
        """
        axes = around.place.axes
        test = _test_function(self._mesh, "DG", 0, (self._size,))
        given = in_space_of(self._held, self._size)
        held = axes * given * axes.T
        ahead = ufl.as_vector([float(axis == 1) for axis in range(self._size)])
        along = ufl.dot(axes.T, ahead)
        along = ufl.as_vector([along[i] for i in range(self._dimension)])
        growth = axes * ufl.dot(ufl.grad(given), along) * axes.T
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
        """The weight q and its slopes (c,) in the axes of the front.

        From 1 to 0 between the inner radius and the reach, twice differentiable; in space times a
        weight along the front over its integral.
        """
        width = (1 - INNER) * self._reach
        t = (place.radius - INNER * self._reach) / width
        t = ufl.max_value(0.0, ufl.min_value(1.0, t))
        around, slope = 1 - t**3 * (10 - 15 * t + 6 * t**2), -30 * (t * (1 - t)) ** 2 / width
        slopes = [slope * each / place.radius for each in (place.height, place.ahead)]
        if self._dimension == 2:
            return around, slopes + [0] * (self._size - 2)
        t = place.arc / self._half_length
        t = ufl.max_value(-1.0, ufl.min_value(1.0, t))
        # Without a second moment: the mean of a factor that varies along the front with the square
        # of the distance is that at the station. 105/64 makes the integral 1.
        part = 105 / 64 * (1 - t**2) / self._half_length
        along, fall = part * (1 - t**2) * (1 - 3 * t**2), -2 * part * t * (5 - 9 * t**2)
        slopes = [each * along for each in slopes]
        return around * along, [*slopes, around * fall * place.stretch / self._half_length]


# By body, whether it is body 1, epsilon, and the excess of its first Lamé constant: it may be body
# 1 of one contact and body 2 of another.
Forms = dict[tuple[str, bool, float, float], InteractionForm]


def _spread(around: _Surroundings) -> Any:
    """(c, c) gradient of the extension of the crack, q along the direction ahead."""
    size = len(around.slopes)
    spread = np.full((size, size), 0, dtype=object)
    spread[1] = around.slopes
    if around.place.turn is not None:
        spread[2, 2] = -around.place.bend * around.weight
    return ufl.as_matrix(spread.tolist())


def _volume_flux(around: _Surroundings, field: TipField) -> Any:
    """(c, c) what the gradient of the displacement is multiplied with, in the axes of the front."""
    spread, weight = _spread(around), around.weight
    flux = around.material.stress(ufl.sym(field.gradient * spread)) + field.stress * spread.T
    flux -= ufl.tr(spread) * field.stress
    ahead = ufl.as_vector([weight if axis == 1 else 0 for axis in range(len(around.slopes))])
    return flux + ufl.outer(field.divergence, ahead)


def _face_flux(field: TipField, normal: Any) -> Any:
    """(c, c) the same of an open surface with a normal (c,) in those axes, for a weight of 1."""
    size = normal.ufl_shape[0]
    ahead = ufl.as_vector([1 if axis == 1 else 0 for axis in range(size)])
    return ufl.outer(field.stress * normal, ahead) - normal[1] * field.stress


def _test_function(mesh: Any, family: str, degree: int, shape: tuple[int, ...]) -> Any:
    """A test function of a space that exists in UFL only."""
    element = basix.ufl.element(family, mesh.topology.cell_name(), degree, shape=shape)
    return ufl.TestFunction(ufl.FunctionSpace(mesh.ufl_domain(), element))


def _values(constants: Sequence[fem.Constant]) -> Array:
    """(c,) values of constants, one after the other."""
    return np.concatenate([np.ravel(each.value) for each in constants])
