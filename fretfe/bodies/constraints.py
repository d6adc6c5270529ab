# SPDX-License-Identifier: LGPL-3.0-or-later
"""Boundaries that move by an amplitude: platens, displacements, cuts and supports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.cut import Asked, Cut, read_cuts
from fretfe.bodies.load_files import values_at_points
from fretfe.bodies.point_values import (
    FLAT,
    PointValues,
    require_points_around,
    require_points_beside,
)
from fretfe.case import Case, complaint, unit_vector
from fretfe.case.base import AXES
from fretfe.case.loads import DisplacementLoad, FieldLoad, PlatenLoad, ShapeLoad, TiltLoad
from fretfe.contact.interface import Course, Resultant
from fretfe.errors import CaseError, MeshError
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import boundary_surface

# What a coordinate calls the moment and the rotation of a tilt.
TILT_CONTROLS = {"moment": "force", "rotation": "displacement"}


@dataclass(frozen=True, eq=False)
class NodalShape:
    """A displacement of the nodes of a boundary.

    Attributes:
        points: (n, d) the nodes.
        values: (n, d) their displacement.
    """

    points: Array
    values: Array

    def at(self, points: Array) -> Array:
        """(m, d) displacement of some of the nodes, given by their places (m, d)."""
        if not len(points):
            return np.zeros_like(points)
        distance, nearest = cKDTree(self.points).query(points)
        assert distance.max() < FLAT * np.ptp(self.points, axis=0).max(), "not one of the nodes"
        return np.asarray(self.values[nearest])


@dataclass(frozen=True)
class Constraint:
    """A boundary that moves by one amplitude: along a direction, about an axis, or by a shape.

    Attributes:
        label: name used in results and messages.
        boundary: physical group.
        direction: unit vector with the components of the displacement; (0, ...) of a tilt or a
            shape.
        roller: true if only the displacement along `direction` is constrained, false if each of its
            non-zero components is.
        axis: unit vector (3,) of the axis of a tilt; empty otherwise.
        centre: (gdim,) a point on that axis.
        shape: displacement of each node of the boundary, if it is no rigid motion.
        at: (gdim,) place of the only node of the boundary that it holds; empty for all of them.
        within: distance up to which a node is at that place.
        resultant: force or moment that it gives where it holds what moves by a shape.
    """

    label: str
    boundary: str
    direction: tuple[float, ...]
    roller: bool = False
    axis: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()
    shape: NodalShape | None = None
    at: tuple[float, ...] = ()
    within: float = 0.0
    resultant: Resultant | None = None

    def holds(self, points: Array) -> Bools:
        """(n,) which nodes of its boundary, at points (n, gdim), it constrains."""
        if not self.at:
            return np.ones(len(points), dtype=bool)
        return np.asarray(np.linalg.norm(points - np.array(self.at), axis=1) < self.within)

    @property
    def components(self) -> Indices:
        """Components of the displacement that it constrains, unless it is a roller."""
        if self.axis or self.shape is not None:
            return np.arange(len(self.direction))
        return np.flatnonzero(self.direction)

    def displacement(self, points: Array) -> Array:
        """(n, c) displacement of points (n, gdim) by a unit amplitude."""
        if self.shape is not None:
            return self.shape.at(points)
        if not self.axis:
            return np.tile(np.array(self.direction), (len(points), 1))
        arms = np.zeros((len(points), 3))
        arms[:, : points.shape[1]] = points - np.array(self.centre)
        return np.cross(self.axis, arms)[:, : len(self.direction)]


class Driven(NamedTuple):
    """A constraint and what its coordinate has to know."""

    constraint: Constraint
    control: str = "fixed"
    channel: str = ""
    course: Course | None = None


def platen_constraints(case: Case, size: int) -> list[Driven]:
    """Loaded directions of each platen, then the guided ones, then its tilts."""
    platens: dict[str, list[str]] = {}
    for name, load in case.loads.items():
        if isinstance(load, PlatenLoad | TiltLoad):
            platens.setdefault(load.boundary, []).append(name)
    constrained: list[Driven] = []
    for boundary, names in platens.items():
        directions: list[tuple[float, ...]] = []
        tilts: list[Driven] = []
        for name in names:
            load = case.loads[name]
            if isinstance(load, TiltLoad):
                tilts.append(_tilt(name, load, size))
                continue
            assert isinstance(load, PlatenLoad)
            directions.append(unit_vector(load.direction, size))
            moved = Constraint(name, boundary, directions[-1])
            constrained.append(Driven(moved, load.control, name))
        for direction in _complement(directions, size):
            label = f"{boundary} guide {_direction_name(direction)}"
            constrained.append(Driven(Constraint(label, boundary, direction)))
        constrained += tilts
    return constrained


def _tilt(name: str, load: TiltLoad, size: int) -> Driven:
    """A rotation and its moment are the displacement and the force of their coordinate."""
    axis, control = unit_vector(load.axis, 3), TILT_CONTROLS[load.control]
    constraint = Constraint(name, load.boundary, (0.0,) * size, axis=axis, centre=load.centre)
    return Driven(constraint, control, name)


def displacement_constraints(case: Case, size: int) -> list[Driven]:
    """Boundaries that are moved along a direction, and may deform across it."""
    return [
        Driven(
            Constraint(name, load.boundary, unit_vector(load.direction, size)), "displacement", name
        )
        for name, load in case.loads.items()
        if isinstance(load, DisplacementLoad)
    ]


def shape_constraints(case: Case, body: BodyMesh) -> list[Driven]:
    """Shapes of the displacement of boundaries of a body, each with rigid motions that are held.

    The forces of those are the resultant of the forces on the boundary.
    """
    constrained = []
    for name, load in case.loads.items():
        if not isinstance(load, ShapeLoad) or load.boundary not in body.boundaries:
            continue
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
        constrained.append(Driven(moved, "displacement", name))
        constrained += _resultant(name, load.boundary, places)
    return constrained


def read_all_cuts(case: Case, mesh: Mesh) -> dict[str, tuple[Asked, Cut]]:
    """Cuts, with what their loads ask for, by the names of these.

    Raises:
        CaseError: if the field of a run is not as expected.
    """
    files: dict[tuple[Path, tuple[str, ...] | None], list[Asked]] = {}
    for name, load in case.loads.items():
        if isinstance(load, FieldLoad):
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


def cut_constraints(asked: Asked, cut: Cut) -> list[Driven]:
    """The shapes that move a cut boundary, with the motions that give resultants."""
    load, places = asked.load, asked.places
    assert isinstance(load, FieldLoad)
    rest = (0.0,) * places.shape[1]
    constrained = []
    for number, (shape, course) in enumerate(zip(cut.shapes, cut.courses, strict=True), 1):
        moved = NodalShape(places, shape)
        constraint = Constraint(f"{asked.channel} {number}", load.boundary, rest, shape=moved)
        constrained.append(Driven(constraint, "displacement", asked.channel, course))
    return constrained + _resultant(asked.channel, load.boundary, places)


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


def support_constraints(case: Case, size: int) -> list[Driven]:
    """Components that are held, then the inclined rollers: those go last at a common node."""
    fixed = [
        Driven(Constraint(f"{name} {axis}", support.boundary, unit_vector(axis, size)))
        for name, support in case.supports.items()
        for axis in support.fix
        if axis in AXES[:size]
    ]
    rollers = [
        Driven(
            Constraint(name, support.boundary, unit_vector(support.direction, size), roller=True)
        )
        for name, support in case.supports.items()
        if support.direction is not None
    ]
    return fixed + rollers


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
