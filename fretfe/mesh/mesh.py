# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a model, one per body, plane or solid; its fineness, and the groups of the case."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case
from fretfe.errors import MeshError
from fretfe.mesh.elements import (
    CORNERS,
    MIDDLES,
    SIMPLICES,
    facet_measures,
    jacobian_determinants,
    row_keys,
    smallest_angle,
)
from fretfe.mesh.gmsh import BODY_KINDS, BOUNDARY_KINDS
from fretfe.mesh.templates import did_you_mean

# Elements beneath a surface count from so many times the size of those at it.
BENEATH = 3.0


@dataclass(frozen=True)
class BodyMesh:
    """The mesh of one body, with its own node numbers.

    Attributes:
        name: Physical surface group, or volume group of a solid.
        points: (n, 2) coordinates; (n, 3) of a solid.
        cells: (m, k) node indices in Gmsh node order, with a positive Jacobian determinant: plane
            cells run counter-clockwise.
        cell: "triangle" or "quadrilateral"; "tetrahedron" or "hexahedron" of a solid.
        order: 1, or 2 (elements with 6, 9, 10 or 27 nodes; edges may be curved).
        boundaries: Facets (f, k) by physical group of curves: end, end[, middle]. The body is on
            the left of a facet that is walked from its first to its second end. Of a solid by
            physical group of surfaces, triangles (3 or 6 nodes) or quadrilaterals (4 or 9) that run
            counter-clockwise seen from outside.
        pieces: Number of its pieces, which do not touch each other.
    """

    name: str
    points: Array
    cells: Indices
    cell: str
    order: int
    boundaries: dict[str, Indices]
    pieces: int = 1

    def volumes(self) -> tuple[Array, Array]:
        """Corners of all cells (n, d), and the shares (n,) of the volume that they stand for.

        Linear forces are integrated exactly on cells that are simplices or parallelepipeds.
        """
        corners = self.cells[:, : CORNERS[self.cell]]
        shares = jacobian_determinants(self.points, corners, self.cell, 1) / corners.shape[1]
        simplices = math.factorial(self.points.shape[1]) if self.cell in SIMPLICES else 1
        return self.points[corners.ravel()], shares.ravel() / simplices


@dataclass(frozen=True, eq=False)
class Mesh:
    """Bodies by name; no two of them share a node.

    Attributes:
        bodies: by name.
        notes: what a reader of the results should know of how it was read, in words.
    """

    bodies: dict[str, BodyMesh]
    notes: tuple[str, ...] = ()

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return next(iter(self.bodies.values())).points.shape[1]


def growth_inward(body: BodyMesh, places: Array, sizes: Array) -> float:
    """Growth of the elements of a plane body with the distance from its fine places; 0 without any.

    Root of the mean square over the area, as far inward as half the width of the surface, of what
    an element is longer than the surface's at the nearest fine place, over its distance from that.
    The surface itself is one such place, and where its elements grow along it those that are half,
    a quarter .. as long are others: the largest growth counts.

    Args:
        body: its mesh.
        places: (N, 2) nodes of the surface.
        sizes: (N,) of the elements there.
    """
    # Imported where it is needed: until Gmsh begins SciPy would take a third of the time.
    from scipy.spatial import cKDTree

    corners = body.points[body.cells[:, : CORNERS[body.cell]]]
    lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    middles, growth = corners.mean(axis=1), np.full(len(lengths), -1.0)
    halvings = np.floor(np.log2(sizes.max() / sizes))
    for number in np.unique(halvings):
        fine = halvings >= number
        distances, nearest = cKDTree(places[fine]).query(middles)
        own = sizes[fine][nearest]
        counts = distances > BENEATH * own
        growth[counts] = np.maximum(growth, (lengths - own) / distances)[counts]
    reach = float(np.linalg.norm(np.ptp(places, axis=0))) / 2
    inside = (growth > -1.0) & (cKDTree(places).query(middles)[0] < reach)
    squares = np.maximum(growth[inside], 0.0) ** 2
    return math.sqrt(np.average(squares, weights=lengths[inside] ** 2)) if inside.any() else 0.0


def place_text(point: Array) -> str:
    """A place in words."""
    return f"({', '.join(f'{value:.6g}' for value in point)})"


@dataclass(frozen=True)
class BoundarySummary:
    """Facets of one boundary on one body; lengths, or areas of a solid, in units of the mesh."""

    name: str
    facets: int
    measure: float
    smallest_facet: float
    largest_facet: float


@dataclass(frozen=True)
class BodySummary:
    """Size and quality of the mesh of one body; its smallest angle in degrees."""

    name: str
    nodes: int
    elements: int
    cell: str
    order: int
    smallest_angle: float
    boundaries: tuple[BoundarySummary, ...]


def check_groups(mesh: Mesh, case: Case) -> None:
    """Every group that the case names must be in the mesh, and every body of the mesh in the case.

    Raises:
        MeshError: Groups are missing, bodies are not mentioned, or a contact is not between two
            bodies. Everything found is in the message.
    """
    problems = [*_body_problems(mesh, case), *_boundary_problems(mesh, case)]
    if not problems:
        problems = [
            *_contact_problems(mesh, case),
            *_held_problems(mesh, case),
            *_side_problems(mesh, case),
            *_tie_problems(mesh, case),
        ]
    if problems:
        lines = "".join(f"\n  - {problem}" for problem in problems)
        raise MeshError(
            f"the mesh does not fit the case:{lines}"
            f"\nbodies (physical {BODY_KINDS[mesh.dimension]}s) of the mesh: {_listed(mesh.bodies)}"
            f"\nboundaries (physical {BOUNDARY_KINDS[mesh.dimension]}s) of the mesh:"
            f" {_listed(_bodies_of_boundaries(mesh))}"
        )


def mesh_summary(mesh: Mesh) -> list[BodySummary]:
    """Numbers that say how fine and how good the mesh is, per body and boundary."""
    return [
        BodySummary(
            name=body.name,
            nodes=len(body.points),
            elements=len(body.cells),
            cell=body.cell,
            order=body.order,
            smallest_angle=smallest_angle(body.points, body.cells, body.cell),
            boundaries=tuple(
                _boundary_summary(name, body, facets) for name, facets in body.boundaries.items()
            ),
        )
        for body in mesh.bodies.values()
    ]


def count_unknowns(mesh: Mesh, degree: int, components: int | None = None) -> int:
    """Displacement unknowns of all bodies; arguments as of `body_unknowns`."""
    return sum(body_unknowns(body, degree, components) for body in mesh.bodies.values())


def body_unknowns(body: BodyMesh, degree: int, components: int | None = None) -> int:
    """Displacement unknowns of a body with elements of a degree, 1 or 2.

    A displacement has as many components as the mesh has coordinates without another number.
    """
    count = _distinct(body.cells[:, : CORNERS[body.cell]])
    if degree == 2:
        count += sum(_shared_count(body, size) for size in {len(m) for m in MIDDLES[body.cell]})
    return (components or body.points.shape[1]) * count


def _shared_count(body: BodyMesh, size: int) -> int:
    """Number of edges, faces or cells with `size` corners that have a node of degree 2 inside."""
    places = [around for around in MIDDLES[body.cell] if len(around) == size]
    corners = np.sort(body.cells[:, places].reshape(-1, size), axis=1)
    return _distinct(row_keys(corners))


def _distinct(numbers: Indices) -> int:
    """Number of different numbers; three times as fast as `np.unique`."""
    return 1 + int(np.count_nonzero(np.diff(np.sort(numbers, axis=None))))


def _boundary_summary(name: str, body: BodyMesh, facets: Indices) -> BoundarySummary:
    measures = facet_measures(body.points, facets)
    return BoundarySummary(
        name, len(facets), float(measures.sum()), float(measures.min()), float(measures.max())
    )


def _body_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    for name in case.bodies:
        if name not in mesh.bodies:
            kind = BODY_KINDS[mesh.dimension]
            yield f"bodies.{name}: no physical {kind} '{name}'{did_you_mean(name, mesh.bodies)}"
    for name in mesh.bodies:
        if name not in case.bodies:
            yield f"the mesh has a body '{name}', but the case has no [bodies.{name}]"


def _boundary_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    found = _bodies_of_boundaries(mesh)
    where = " in the part that geometry.part cuts out" if case.geometry.part is not None else ""
    for key, name in named_boundaries(case):
        if name not in found:
            kind = BOUNDARY_KINDS[mesh.dimension]
            yield f"{key}: no physical {kind} '{name}'{where}{did_you_mean(name, found)}"


def named_boundaries(case: Case) -> Iterator[tuple[str, str]]:
    """Key in the case file and name of every boundary that the case mentions."""
    for name, contact in case.contacts.items():
        yield f"contacts.{name}.surface1", contact.surface1
        yield f"contacts.{name}.surface2", contact.surface2
    for name, support in case.supports.items():
        yield f"supports.{name}.boundary", support.boundary
    for name, sector in case.symmetry.items():
        yield f"symmetry.{name}.boundary1", sector.boundary1
        yield f"symmetry.{name}.boundary2", sector.boundary2
    for name, tie in case.ties.items():
        yield f"ties.{name}.boundary1", tie.boundary1
        yield f"ties.{name}.boundary2", tie.boundary2
    for name, load in case.loads.items():
        boundary = getattr(load, "boundary", None)
        if boundary is not None:
            yield f"loads.{name}.boundary", boundary
        for number, surface in enumerate(getattr(load, "surfaces", None) or (), start=1):
            yield f"loads.{name}.surfaces[item {number}]", surface


def _contact_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    bodies = _bodies_of_boundaries(mesh)
    for name, contact in case.contacts.items():
        surfaces = {"surface1": contact.surface1, "surface2": contact.surface2}
        shared = {key: group for key, group in surfaces.items() if len(bodies[group]) > 1}
        for key, group in shared.items():
            yield (
                f"contacts.{name}.{key}: expected a boundary of one body, but '{group}' has facets"
                f" of {_listed(bodies[group])}; name one physical"
                f" {BOUNDARY_KINDS[mesh.dimension]} for each"
            )
        if not shared and bodies[contact.surface1] == bodies[contact.surface2]:
            yield (
                f"contacts.{name}: expected surfaces of two bodies, but '{contact.surface1}' and"
                f" '{contact.surface2}' are both on '{bodies[contact.surface1][0]}'"
            )


def _held_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    """Boundaries that are held, or platens, and have facets of a contact surface."""
    held = [(f"supports.{name}", each.boundary) for name, each in case.supports.items()]
    held += [
        (f"loads.{name}", load.on) for name, load in case.loads.items() if load.moves or load.rigid
    ]
    surfaces = [
        (f"contacts.{name}", surface)
        for name, contact in case.contacts.items()
        for surface in (contact.surface1, contact.surface2)
    ]
    for body in mesh.bodies.values():
        for (key, boundary), (contact, surface) in product(held, surfaces):
            if boundary in body.boundaries and surface in body.boundaries:
                own, other = (
                    set(map(tuple, np.sort(body.boundaries[name], axis=1).tolist()))
                    for name in (boundary, surface)
                )
                if shared := len(own & other):
                    yield (
                        f"{key}: expected a boundary that is no part of a contact surface, but"
                        f" '{boundary}' has {shared} facets of '{surface}' of {contact}"
                    )


def _side_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    """Sides of a sector that are not on the same bodies, or of a body that has others already."""
    bodies = _bodies_of_boundaries(mesh)
    owners: dict[str, str] = {}
    for name, sector in case.symmetry.items():
        first, second = bodies[sector.boundary1], bodies[sector.boundary2]
        if first != second:
            yield (
                f"symmetry.{name}: expected both sides on the same bodies, but"
                f" '{sector.boundary1}' is on {_listed(first)} and '{sector.boundary2}' on"
                f" {_listed(second)}"
            )
        for body in first:
            if body in owners:
                yield (
                    f"symmetry.{name}: expected sides of a body that has no others, but '{body}'"
                    f" has those of symmetry.{owners[body]}; put the facets of a side into one"
                    " group"
                )
            owners.setdefault(body, name)


def _tie_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    """Tied boundaries that are not on one body, or on one that is a sector."""
    bodies = _bodies_of_boundaries(mesh)
    turned = {side for each in case.symmetry.values() for side in (each.boundary1, each.boundary2)}
    for name, tie in case.ties.items():
        first, second = bodies[tie.boundary1], bodies[tie.boundary2]
        if len(first) > 1 or first != second:
            yield (
                f"ties.{name}: expected boundaries of two parts of one body, but '{tie.boundary1}'"
                f" is on {_listed(first)} and '{tie.boundary2}' on {_listed(second)}; put the parts"
                " into one body"
            )
        elif not turned.isdisjoint(mesh.bodies[first[0]].boundaries):
            yield (
                f"ties.{name}: expected a body without sides of a sector, found '{first[0]}': mesh"
                " its parts as one"
            )


def _bodies_of_boundaries(mesh: Mesh) -> dict[str, list[str]]:
    """For each boundary group the bodies that have facets in it."""
    bodies: dict[str, list[str]] = {}
    for body in mesh.bodies.values():
        for name in body.boundaries:
            bodies.setdefault(name, []).append(body.name)
    return bodies


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
