# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that move boundaries: platens and their tilts, displacements, shapes and cuts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.constraints import Constraint, Driven, NodalShape
from fretfe.bodies.cyclic import Tie
from fretfe.bodies.loads.cut import Asked, Cut, read_cuts
from fretfe.bodies.loads.files import values_at_points
from fretfe.bodies.point_values import PointValues, require_points_around, require_points_beside
from fretfe.case import Case, complaint, unit_vector
from fretfe.case.base import AXES
from fretfe.case.loads import (
    DisplacementLoad,
    Load,
    PlatenLoad,
    PretensionLoad,
    ShapeLoad,
    TiltLoad,
)
from fretfe.contact.interface import Resultant
from fretfe.errors import CaseError, MeshError
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import boundary_surface

# What a coordinate calls the moment and the rotation of a tilt.
TILT_CONTROLS = {"moment": "force", "rotation": "displacement"}


def moved_boundaries(case: Case, body: BodyMesh, cuts: Sequence[tuple[Asked, Cut]]) -> list[Driven]:
    """Boundaries of a body that loads move, in order of precedence: platens, then what may deform.

    Args:
        case: the case.
        body: with its boundaries.
        cuts: of the body.

    Raises:
        CaseError: if values at points are not as expected.
    """
    size = case.components(body.points.shape[1])
    own = {name: load for name, load in case.loads.items() if load.on in body.boundaries}
    platens: dict[str, dict[str, Load]] = {}
    for name, load in own.items():
        if load.rigid:
            platens.setdefault(load.on, {})[name] = load
    moved = [each for on, loads in platens.items() for each in _platen(on, loads, size)]
    for name, load in own.items():
        if isinstance(load, DisplacementLoad):
            along = Constraint(name, load.boundary, unit_vector(load.direction, size))
            moved.append(Driven(along, "displacement", name))
    shapes = {name: load for name, load in own.items() if isinstance(load, ShapeLoad)}
    moved += [each for name, load in shapes.items() for each in _shape(case, name, load, body)]
    return moved + [each for cut in cuts for each in _cut(*cut)]


def overlaps(case: Case, body: BodyMesh, bond: Tie | None) -> list[Driven]:
    """Overlaps of the tied parts of a body, by which bolts are tightened.

    The parts of a unit amplitude a move by u_s - u_m = a n, n the normal out of the part that
    follows: its conjugate is the force across the cut, positive in tension.

    Raises:
        CaseError: a boundary is not plane.
    """
    found = []
    for name, load in case.loads.items():
        if bond is None or not isinstance(load, PretensionLoad):
            continue
        tie = case.ties[load.tie]
        (boundary,) = {tie.boundary1, tie.boundary2} & {*bond.groups[0]} or {""}
        if not boundary:
            continue
        surface = boundary_surface(body, boundary)
        normal = surface.normals.reshape(-1, surface.dimension).mean(axis=0)
        normal /= np.linalg.norm(normal)
        if (surface.normals @ normal).min() < 1 - 1e-6:
            text = f"expected a plane, across which a bolt is cut, found the bent {boundary!r}"
            raise CaseError(complaint(case.source, ("loads", name, "tie"), text))
        direction = (*map(float, normal), *(case.components(len(normal)) - len(normal)) * (0.0,))
        constraint = Constraint(name, boundary, direction, overlap=True)
        found.append(Driven(constraint, load.control, name))
    return found


def _platen(boundary: str, loads: Mapping[str, Load], size: int) -> Iterator[Driven]:
    """Loaded directions of a platen, then the guided ones, then its tilts."""
    directions: list[tuple[float, ...]] = []
    for name, load in loads.items():
        if isinstance(load, PlatenLoad):
            directions.append(unit_vector(load.direction, size))
            yield Driven(Constraint(name, boundary, directions[-1]), load.control, name)
    for direction in _complement(directions, size):
        label = f"{boundary} guide {_direction_name(direction)}"
        yield Driven(Constraint(label, boundary, direction))
    for name, load in loads.items():
        if isinstance(load, TiltLoad):
            axis, control = unit_vector(load.axis, 3), TILT_CONTROLS[load.control]
            turned = Constraint(name, boundary, (0.0,) * size, axis=axis, centre=load.centre)
            yield Driven(turned, control, name)


def _shape(case: Case, name: str, load: ShapeLoad, body: BodyMesh) -> list[Driven]:
    """A shape, and rigid motions that are held: their forces are the resultant of those on it."""
    gdim = body.points.shape[1]
    given = values_at_points(case, name, load, gdim)
    given = PointValues(load.factor * given.points, load.factor * given.values)
    places = _nodes(case, body, load.boundary)
    what = f"the boundary {load.boundary!r}"
    require_points_beside(case, name, given, places, what)
    require_points_around(case, name, given, places, what)
    shape = NodalShape(places, given.at(places))
    if not shape.values.any():
        text = f"expected a shape that moves {what}, found no displacement at its nodes"
        raise CaseError(complaint(case.source, ("loads", name), text))
    moved = Constraint(name, load.boundary, (0.0,) * gdim, shape=shape)
    return [Driven(moved, "displacement", name), *_resultant(name, load.boundary, places)]


def read_all_cuts(case: Case, mesh: Mesh) -> dict[str, tuple[Asked, Cut]]:
    """Cuts, with what their loads ask for, by the names of these.

    Raises:
        CaseError: if the field of a run is not as expected.
    """
    files: dict[tuple[Path, tuple[str, ...] | None], list[Asked]] = {}
    for name, load in case.cut_loads.items():
        (body,) = (each for each in mesh.bodies.values() if load.boundary in each.boundaries)
        asked = Asked(name, load, body.name, _nodes(case, body, load.boundary))
        files.setdefault((case.resolve(load.file), load.arrays), []).append(asked)
    cuts = {name: cut for (path, _), every in files.items()
            for name, cut in _cuts_in(case, path, every).items()}  # fmt: skip
    return {each.channel: (each, cuts[each.channel]) for every in files.values() for each in every}


def _cuts_in(case: Case, path: Path, asked: Sequence[Asked]) -> dict[str, Cut]:
    try:
        return read_cuts(path, asked)
    except (CaseError, MeshError) as error:
        if len(asked) > 1:  # each alone, to tell whose it is
            return {
                name: cut for each in asked for name, cut in _cuts_in(case, path, [each]).items()
            }
        key = ("loads", asked[0].channel, "file")
        raise CaseError(complaint(case.source, key, str(error))) from None


def _cut(asked: Asked, cut: Cut) -> list[Driven]:
    """The shapes that move a cut boundary, with the motions that give resultants."""
    boundary, places = asked.load.on, asked.places
    rest = (0.0,) * places.shape[1]
    constrained = []
    for number, (shape, course) in enumerate(zip(cut.shapes, cut.courses, strict=True), 1):
        moved = NodalShape(places, shape)
        constraint = Constraint(f"{asked.channel} {number}", boundary, rest, shape=moved)
        constrained.append(Driven(constraint, "displacement", asked.channel, course))
    return constrained + _resultant(asked.channel, boundary, places)


def _nodes(case: Case, body: BodyMesh, boundary: str) -> Array:
    """(n, d) nodes of the displacement on a boundary."""
    return boundary_surface(body, boundary).displacement_points(case.model.degree)


def _resultant(name: str, boundary: str, places: Array) -> list[Driven]:
    """Rigid motions of a boundary that are held, about the middle of its extent; nodes (n, d)."""
    gdim = places.shape[1]
    centre = tuple(((places.min(axis=0) + places.max(axis=0)) / 2).tolist())
    axes = {axis: unit_vector(axis, 3) for axis in AXES}
    moves = [
        Constraint(f"{name} force {axis}", boundary, unit_vector(axis, gdim),
                   resultant=Resultant(name, "force"))
        for axis in AXES[:gdim]
    ]  # fmt: skip
    turns = [
        Constraint(f"{name} moment {axis}", boundary, (0.0,) * gdim, axis=vector, centre=centre,
                   resultant=Resultant(name, "moment"))
        for axis, vector in axes.items()
        if gdim == 3 or axis == "z"
    ]  # fmt: skip
    return [Driven(each) for each in (*moves, *turns)]


def _complement(directions: list[tuple[float, ...]], size: int) -> list[tuple[float, ...]]:
    """Unit vectors normal to the given orthogonal ones, along the axes where possible."""
    basis = [np.array(direction) for direction in directions]
    added: list[tuple[float, ...]] = []
    for axis in np.eye(size):
        rest = axis - sum((axis @ b) * b for b in basis)
        length = np.linalg.norm(rest)
        if length > 1e-6 and len(basis) < size:
            basis.append(rest / length)
            added.append(tuple(float(v) for v in rest / length))
    return added


def _direction_name(direction: tuple[float, ...]) -> str:
    components = np.flatnonzero(np.abs(direction) > 1e-12)
    if len(components) == 1:
        return AXES[components[0]]
    return "(" + ", ".join(f"{v:.4g}" for v in direction) + ")"
