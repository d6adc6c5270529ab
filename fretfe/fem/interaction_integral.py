# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors by an interaction integral around a station of a contact front.

The front of a stuck contact is that of an external interface crack: the contact is the ligament,
the open surfaces are the crack faces, and with traction ~ K/sqrt(s) on the ligament the stress
intensity factors are sqrt(2 pi) K (Rice 1968; Yau, Wang and Corten 1980 for the interaction
integral). With a vector field w = q X, X the inward direction and q a weight that is 1 at the tip
and 0 outside a circle, u the displacement and (v, s) displacement and stress of the pure crack-tip
field of one mode,

    I = int (sigma_ij v_i,k + s_ij u_i,k - sigma:eps(v) delta_jk) w_k,j + s_ij,j u_i,k w_k dV
        - int_faces (s_ij n_j u_i,k - sigma:eps(v) n_k) w_k dS

summed over both bodies, each in the frame of its own surface at the station: K_I,II/E* in the
plane. The second integral is that over the open surfaces, which are curved; on the closed ones the
two bodies cancel. In space w follows the circle that osculates the front and q has a factor along
it, by whose integral I is divided: K_I,II/E* and K_III (1/G1 + 1/G2)/2 of the modes. The crack-tip
field turns with the circle and is differentiated as a field in space, so that it is not in
equilibrium (Gosz and Moran 1998 for curved fronts).

For elastically similar bodies (Dundurs' beta = 0), between others mode III alone. Body forces are
left out: over the radius of the circle they are small against the stresses at the front.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import dolfinx.mesh
import numpy as np
import numpy.typing as npt
import ufl
from dolfinx import fem
from ufl.algorithms.analysis import extract_constants

from fretfe._typing import Array
from fretfe.fem._compat import form_on
from fretfe.fem.elasticity import ElasticBody, Elasticity
from fretfe.fem.form_cache import compiled
from fretfe.fem.tip_field import (
    SMALLEST,
    FrontPlace,
    TipField,
    front_place,
    tip_fields,
)

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

    def within(self, tip: Tip, tube: Tube, inner: float) -> npt.NDArray[np.int32]:
        """Entities that may have points in a tube, not nearer to the front than `inner`."""
        height, ahead, *sides = ((self._middles - tip.point) @ tip.frame.T).T
        near = np.ones(len(height), dtype=bool)
        for side in sides:  # in space
            turned, left = tip.curvature * side, 1 - tip.curvature * ahead
            squared = ahead**2 + side**2
            ahead = (2 * ahead - tip.curvature * squared) / (1 + np.hypot(turned, left))
            arc = np.arctan2(turned, left) / tip.curvature if tip.curvature else side
            near = np.abs(arc) < tube.half_length + self._sizes
        distance = np.hypot(height, ahead)
        near &= (distance > inner - self._sizes) & (distance < tube.reach + self._sizes)
        return self._entities[near]


class InteractionForm:
    """The interaction integral of one body as a linear functional of its displacement.

    Construction is collective.

    Args:
        elastic: the body.
        surfaces: names of its contact surfaces.
        upper: whether it is body 1 of the contact.
    """

    def __init__(self, elastic: ElasticBody, surfaces: list[str], upper: bool) -> None:
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
        dim = mesh.topology.dim
        cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
        facets = np.concatenate([elastic.facet_tags.find(elastic.groups[s]) for s in surfaces])
        self._cells, self._facets = _Places(mesh, dim, cells), _Places(mesh, dim - 1, facets)
        integral = self._integral(elastic)
        self._constants = extract_constants(integral)
        self._compiled = compiled(
            mesh.comm, fem.compile_form, mesh.comm, integral, flags=COMPILER_FLAGS
        )

    def products(self, tip: Tip, tube: Tube, displacements: Array) -> Array:
        """(d, n) what this rank adds to this body's part of I, for each mode and displacement.

        Args:
            tip: the station.
            tube: what to integrate over.
            displacements: (m, d, n) of the body's nodes on this rank, owned and ghosted.
        """
        self._point.value[:] = tip.point
        self._frame.value[:] = tip.frame
        self._curvature.value = tip.curvature
        self._reach.value = tube.reach
        self._half_length.value = tube.half_length
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

    def _integral(self, elastic: ElasticBody) -> Any:
        mesh = elastic.mesh
        metadata = {"quadrature_degree": QUADRATURE_DEGREE[mesh.topology.cell_name()]}
        dx, ds = (
            ufl.Measure(kind, mesh, subdomain_id=1, metadata=metadata) for kind in ("dx", "ds")
        )
        # A quadrature point may fall on the tip, where the field has no gradient.
        nothing = SMALLEST * self._reach
        offset = ufl.SpatialCoordinate(mesh) - self._point
        place = front_place(offset, self._frame, self._curvature, nothing)
        material = Elasticity.of(mesh, elastic.material)
        weight, slopes = self._weight(place)
        normal = place.axes * ufl.FacetNormal(mesh)
        opened = ufl.conditional(ufl.lt(place.ahead, -BLUNT * self._reach), weight, 0.0)
        slope = ufl.grad(ufl.TestFunction(self._space))
        inside, leak = [], []
        for field in tip_fields(place, self._side, material, nothing):
            inside.append(_volume_flux(place, field, material, weight, slopes))
            leak.append(_face_flux(field, normal))
        whole, lost = (
            sum(
                ufl.inner(place.axes.T * flux * place.axes, slope[mode, :, :])
                for mode, flux in enumerate(fluxes)
            )
            for fluxes in (inside, leak)
        )
        return whole * dx - opened * lost * ds

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


def _volume_flux(
    place: FrontPlace, field: TipField, material: Elasticity, weight: Any, slopes: list[Any]
) -> Any:
    """(d, d) what the gradient of the displacement is multiplied with, in the axes of the front.

    Args:
        place: where.
        field: of the crack tip.
        material: of the body.
        weight: q.
        slopes: (d,) of q.
    """
    size = len(slopes)
    spread = np.full((size, size), 0, dtype=object)
    spread[1] = slopes
    if size == 3:
        spread[2, 2] = -place.bend * weight
    spread = ufl.as_matrix(spread.tolist())
    flux = material.stress(ufl.sym(field.gradient * spread)) + field.stress * spread.T
    flux -= ufl.tr(spread) * field.stress
    ahead = ufl.as_vector([weight if axis == 1 else 0 for axis in range(size)])
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
