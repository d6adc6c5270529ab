# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors by an interaction integral around a contact edge.

The edge of a stuck contact is the tip of an external interface crack: the contact is the ligament,
the open surfaces are the crack faces, and with traction ~ K/sqrt(s) on the ligament the stress
intensity factors are sqrt(2 pi) K (Rice 1968; Yau, Wang and Corten 1980 for the interaction
integral). With q = 1 at the tip and 0 outside a circle, X the inward direction, u the displacement
and (v, s) displacement and stress of the pure crack-tip field in mode I or II,

    I = int (sigma_ij v_i,X + s_ij u_i,X - sigma:eps(v) delta_Xj) q,j dA
        - int_faces (s_ij n_j u_i,X - sigma:eps(v) n_X) q ds  =  K_I,II/E*

summed over both bodies, each in the frame of its own surface at the edge. The second integral is
that over the open surfaces, which are curved; on the closed ones the two bodies cancel. For
elastically similar bodies (Dundurs' beta = 0). Body forces are left out: over the radius of the
circle they are small against the edge's stresses.
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
from fretfe.fem._compat import PETSc, assemble_vector, form_on
from fretfe.fem.elasticity import ElasticBody
from fretfe.fem.form_cache import compiled

# The weight q is 1 up to this fraction of the radius: the singular elements do not count.
INNER = 0.3
# Products of the crack-tip field with polynomials.
QUADRATURE_DEGREE = 8
# The faces are left out this close to the tip, in radii: they are straight there, and a quadrature
# point next to the tip would see an angle that is not that of the surface.
BLUNT = 0.02
# Distances below this fraction of the radius are zero.
SMALLEST = 1e-9
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
# Amplitudes of modes I and II for each `Factor` of the plane.
MODES = ((1.0, 0.0), (0.0, 1.0))


@dataclass(frozen=True)
class Tip:
    """A station as a body sees it.

    Attributes:
        point: (2,) the station on the body's surface.
        inward: (2,) unit tangent of the surface, from the front into the contact.
        across: (2,) unit normal of the surface, from body 2 to body 1.
    """

    point: Array
    inward: Array
    across: Array


class _Places:
    """Places of some entities of a mesh.

    Args:
        mesh: mesh.
        dim: dimension of the entities.
        entities: their numbers on this rank.
    """

    def __init__(self, mesh: Any, dim: int, entities: npt.NDArray[np.int32]) -> None:
        self._entities = entities
        self._middles = dolfinx.mesh.compute_midpoints(mesh, dim, entities)[:, :2]
        self._sizes = mesh.h(dim, entities)

    def within(self, centre: Array, inner: float, outer: float) -> npt.NDArray[np.int32]:
        """Entities that may have points between two circles."""
        distance = np.linalg.norm(self._middles - centre, axis=1)
        near = (distance > inner - self._sizes) & (distance < outer + self._sizes)
        return self._entities[near]


class InteractionForm:
    """The interaction integral of one body as a linear functional of its displacement. Collective.

    Args:
        elastic: the body.
        surfaces: names of its contact surfaces.
        upper: whether it is body 1 of the contact.
    """

    def __init__(self, elastic: ElasticBody, surfaces: list[str], upper: bool) -> None:
        mesh = elastic.mesh
        self._space = elastic.space
        self._point, self._inward, self._across = (
            fem.Constant(mesh, np.zeros(2)) for _ in range(3)
        )
        self._reach = fem.Constant(mesh, 1.0)
        self._mode = fem.Constant(mesh, np.zeros(2))
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

    def functionals(self, tip: Tip, reach: float) -> list[PETSc.Vec]:
        """Vectors for each of MODES, whose products with a displacement are this body's part of I.

        Args:
            tip: the station.
            reach: radius of the circle.
        """
        self._point.value[:] = tip.point
        self._inward.value[:] = tip.inward
        self._across.value[:] = tip.across
        self._reach.value = reach
        cells = self._cells.within(tip.point, INNER * reach, reach)
        facets = self._facets.within(tip.point, 0.0, reach)
        form = form_on(self._compiled, self._space, self._constants, cells, facets)
        vectors = []
        for mode in MODES:
            self._mode.value[:] = mode
            vectors.append(assemble_vector(form))
        return vectors

    def _integral(self, elastic: ElasticBody) -> Any:
        metadata = {"quadrature_degree": QUADRATURE_DEGREE}
        dx, ds = (
            ufl.Measure(kind, elastic.mesh, subdomain_id=1, metadata=metadata)
            for kind in ("dx", "ds")
        )
        test = ufl.TestFunction(elastic.space)
        place = ufl.SpatialCoordinate(elastic.mesh) - self._point
        ahead, above = ufl.dot(place, self._inward), ufl.dot(place, self._across)
        # A quadrature point may fall on the tip, where the field has no gradient.
        nothing = SMALLEST * self._reach
        radius = ufl.sqrt(ahead**2 + above**2 + nothing**2)
        field = self._crack_tip_field(elastic, ahead, above, radius)
        weight = self._weight(radius)
        stress, tip_stress = elastic.stress(test), elastic.stress(field)
        slope = ufl.dot(ufl.grad(test), self._inward)
        tip_slope = ufl.dot(ufl.grad(field), self._inward)
        energy = ufl.inner(stress, ufl.sym(ufl.grad(field)))
        inside = ufl.conditional(ufl.lt(radius, self._reach), 1.0, 0.0)
        flux = ufl.dot(stress, tip_slope) + ufl.dot(tip_stress, slope) - energy * self._inward
        normal = ufl.FacetNormal(elastic.mesh)
        leak = ufl.dot(ufl.dot(tip_stress, normal), slope)
        leak -= energy * ufl.dot(normal, self._inward)
        opened = inside * ufl.conditional(ufl.lt(ahead, -BLUNT * self._reach), 1.0, 0.0)
        return inside * ufl.dot(flux, ufl.grad(weight)) * dx - opened * weight * leak * ds

    def _weight(self, radius: Any) -> Any:
        """From 1 to 0 between the inner radius and the reach, twice differentiable."""
        t = (radius / self._reach - INNER) / (1 - INNER)
        t = ufl.max_value(0.0, ufl.min_value(1.0, t))
        return 1 - t**3 * (10 - 15 * t + 6 * t**2)

    def _crack_tip_field(self, elastic: ElasticBody, ahead: Any, above: Any, radius: Any) -> Any:
        """Displacement with a unit stress intensity factor of the chosen mode (Williams 1957)."""
        # The branch of the angle is cut through the other body: surfaces are never quite straight.
        nothing = SMALLEST * self._reach
        angle = self._side * (ufl.pi / 2 + ufl.atan2(-ahead, self._side * above + nothing))
        sine, cosine = ufl.sin(angle / 2), ufl.cos(angle / 2)
        kolosov = fem.Constant(elastic.mesh, elastic.material.kolosov)
        modulus = fem.Constant(elastic.mesh, elastic.material.shear_modulus)
        opening = (cosine * (kolosov - 1 + 2 * sine**2), sine * (kolosov + 1 - 2 * cosine**2))
        shear = (sine * (kolosov + 1 + 2 * cosine**2), cosine * (1 - kolosov + 2 * sine**2))
        ahead_part, above_part = (
            self._mode[0] * opening[i] + self._mode[1] * shear[i] for i in range(2)
        )
        size = ufl.sqrt(radius / (2 * ufl.pi)) / (2 * modulus)
        return size * (ahead_part * self._inward + above_part * self._across)
