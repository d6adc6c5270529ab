# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh as the case sees it: are the groups that it names there, and how fine are they."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case
from fretfe.errors import MeshError
from fretfe.geometry.templates import did_you_mean
from fretfe.mesh.cell_geometry import smallest_angle
from fretfe.mesh.mesh import BodyMesh, Mesh

CORNERS = {"triangle": 3, "quadrilateral": 4}


@dataclass(frozen=True)
class BoundarySummary:
    """Facets of one boundary on one body; lengths along the facets, in the units of the mesh."""

    name: str
    facets: int
    length: float
    smallest_facet: float
    largest_facet: float


@dataclass(frozen=True)
class BodySummary:
    """Size and quality of the mesh of one body; smallest corner angle in degrees."""

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
        problems = list(_contact_problems(mesh, case))
    if problems:
        lines = "".join(f"\n  - {problem}" for problem in problems)
        raise MeshError(
            f"the mesh does not fit the case:{lines}"
            f"\nbodies (physical surfaces) of the mesh: {_listed(mesh.bodies)}"
            f"\nboundaries (physical curves) of the mesh: {_listed(_bodies_of_boundaries(mesh))}"
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


def count_unknowns(mesh: Mesh, degree: int) -> int:
    """Displacement unknowns of all bodies with elements of a degree, 1 or 2."""
    return sum(body_unknowns(body, degree) for body in mesh.bodies.values())


def body_unknowns(body: BodyMesh, degree: int) -> int:
    """Displacement unknowns of a body with elements of a degree, 1 or 2."""
    nodes = body.cells[:, : CORNERS[body.cell]]
    count = _distinct(nodes)
    if degree == 2:
        ends = nodes, np.roll(nodes, -1, axis=1)
        count += _distinct(np.minimum(*ends) * len(body.points) + np.maximum(*ends))
        count += len(nodes) if body.cell == "quadrilateral" else 0
    return 2 * count


def _distinct(numbers: Indices) -> int:
    """How many numbers differ; three times as fast as `np.unique`."""
    return 1 + int(np.count_nonzero(np.diff(np.sort(numbers, axis=None))))


def _boundary_summary(name: str, body: BodyMesh, facets: Indices) -> BoundarySummary:
    lengths = facet_lengths(body.points, facets)
    return BoundarySummary(
        name, len(facets), float(lengths.sum()), float(lengths.min()), float(lengths.max())
    )


def facet_lengths(points: Array, facets: Indices) -> Array:
    """Arc length (f,) of facets (f, 2 or 3) between points (n, 2): end, end[, middle].

    Curved facets by three Gauss points: the error is below 1e-6 for an arc of 30 degrees.
    """
    first, second = points[facets[:, 0]], points[facets[:, 1]]
    chord = second - first
    if facets.shape[1] == 2:
        return np.linalg.norm(chord, axis=1)
    bulge = points[facets[:, 2]] - (first + second) / 2
    places, weights = np.polynomial.legendre.leggauss(3)
    # x(t) on -1 <= t <= 1 is middle of the chord + t chord/2 + (1 - t^2) bulge
    tangents = chord / 2 - 2 * places[:, None, None] * bulge
    return weights @ np.linalg.norm(tangents, axis=2)


def _body_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    for name in case.bodies:
        if name not in mesh.bodies:
            yield f"bodies.{name}: no physical surface '{name}'{did_you_mean(name, mesh.bodies)}"
    for name in mesh.bodies:
        if name not in case.bodies:
            yield f"the mesh has a body '{name}', but the case has no [bodies.{name}]"


def _boundary_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    found = _bodies_of_boundaries(mesh)
    for key, name in named_boundaries(case):
        if name not in found:
            yield f"{key}: no physical curve '{name}'{did_you_mean(name, found)}"


def named_boundaries(case: Case) -> Iterator[tuple[str, str]]:
    """Key in the case file and name of every boundary that the case mentions."""
    for name, contact in case.contacts.items():
        yield f"contacts.{name}.surface1", contact.surface1
        yield f"contacts.{name}.surface2", contact.surface2
    for name, support in case.supports.items():
        yield f"supports.{name}.boundary", support.boundary
    for name, load in case.loads.items():
        boundary = getattr(load, "boundary", None)
        if boundary is not None:
            yield f"loads.{name}.boundary", boundary


def _contact_problems(mesh: Mesh, case: Case) -> Iterator[str]:
    bodies = _bodies_of_boundaries(mesh)
    for name, contact in case.contacts.items():
        surfaces = {"surface1": contact.surface1, "surface2": contact.surface2}
        shared = {key: group for key, group in surfaces.items() if len(bodies[group]) > 1}
        for key, group in shared.items():
            yield (
                f"contacts.{name}.{key}: expected a boundary of one body, but '{group}' has facets"
                f" of {_listed(bodies[group])}; name one physical curve for each"
            )
        if not shared and bodies[contact.surface1] == bodies[contact.surface2]:
            yield (
                f"contacts.{name}: expected surfaces of two bodies, but '{contact.surface1}' and"
                f" '{contact.surface2}' are both on '{bodies[contact.surface1][0]}'"
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
