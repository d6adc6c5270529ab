# SPDX-License-Identifier: LGPL-3.0-or-later
"""Definition of the model: bodies with their materials, supports, loads and contact surfaces."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from fretfe.bodies.constraints import (
    Constraint,
    NodalShape,
    cut_constraints,
    displacement_constraints,
    platen_constraints,
    read_all_cuts,
    shape_constraints,
    support_constraints,
)
from fretfe.bodies.cut import Asked, Cut
from fretfe.bodies.cyclic import Tie, tie_sides
from fretfe.bodies.material import Material
from fretfe.bodies.point_values import FLAT, NodalValues, PointValues
from fretfe.bodies.spread_loads import DistributedLoad, distributed_loads, require_values_around
from fretfe.case import Case
from fretfe.case.base import ABSOLUTE_ZERO
from fretfe.contact.interface import Coordinate
from fretfe.errors import CaseError, ModelError
from fretfe.loads import History
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import Surface, build_surface

# Part of an initial strain that may differ at the sides of a sector: values at points are
# interpolated, and constant across a line of points.
LARGEST_STEP = 0.02
# Height of an element over the distance of two depths from which it does not see both.
FINEST = 1.01


@dataclass(frozen=True)
class BodyDefinition:
    """Definition of one body.

    Attributes:
        name: physical group of the body.
        material: elastic constants.
        constraints: constrained boundaries, in order of precedence.
        coordinates: one for each constraint.
        surfaces: contact surfaces of the body, in the order of the contacts.
        tie: of its sides, if it is a part of a sector.
        cuts: boundaries of the body that another run moves.
        components: of the displacement, 3 in space; in the plane 2, or 3 with u_z(x, y).
    """

    name: str
    material: Material
    constraints: tuple[Constraint, ...]
    coordinates: tuple[Coordinate, ...]
    surfaces: tuple[str, ...]
    tie: Tie | None = None
    cuts: tuple[Cut, ...] = ()
    components: int = 2


@dataclass(frozen=True)
class ModelDefinition:
    """Definition of all bodies, and of the loads on whichever body has their boundary."""

    bodies: tuple[BodyDefinition, ...]
    loads: tuple[DistributedLoad, ...]

    @property
    def components(self) -> int:
        """Components of the displacement: 3 in space, in the plane 2, or 3 with u_z(x, y)."""
        return self.bodies[0].components

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """All fields of other runs."""
        heated = {load.channel: load.cut for load in self.loads if load.cut is not None}
        return (*(cut for body in self.bodies for cut in body.cuts), *heated.values())

    @property
    def digest(self) -> str:
        """Text that is equal for loads with the same values at points."""
        given: list[PointValues | NodalShape | NodalValues | None]
        given = [load.at_points for load in self.loads]
        given += [each for load in self.loads for each in load.changes.values()]
        given += [each.shape for body in self.bodies for each in body.constraints]
        found = hashlib.sha256()
        for each in given:
            if each is not None:
                found.update(each.points.tobytes() + each.values.tobytes())
        return found.hexdigest()


def define_model(case: Case, mesh: Mesh) -> ModelDefinition:
    """Translate a case into bodies, coordinates and loads.

    Raises:
        ModelError: if a body has no contact surface.
        CaseError: if values at points cannot be read, or do not reach as far as the bodies, or
            sides of a sector are not images of one another.
    """
    size = case.components(mesh.dimension)
    loads = distributed_loads(case, mesh)
    for load in loads:
        require_values_around(case, load, mesh)
    cuts = read_all_cuts(case, mesh)
    return ModelDefinition(
        bodies=tuple(_define_body(case, mesh, name, size, cuts) for name in case.bodies),
        loads=loads,
    )


def _define_body(
    case: Case, mesh: Mesh, name: str, size: int, cuts: Mapping[str, tuple[Asked, Cut]]
) -> BodyDefinition:
    own = mesh.bodies[name].boundaries
    surfaces = [
        surface
        for contact in case.contacts.values()
        for surface in (contact.surface1, contact.surface2)
        if surface in own
    ]
    if not surfaces:
        raise ModelError(
            f"body {name!r} has no contact surface: expected one of its boundaries "
            f"({', '.join(sorted(own)) or 'none'}) in a contact of the case."
        )
    shapes = shape_constraints(case, mesh.bodies[name])
    own_cuts = [each for each in cuts.values() if each[0].body == name]
    cut = [driven for each in own_cuts for driven in cut_constraints(*each)]
    moved = displacement_constraints(case, size) + shapes + cut
    constrained = [
        each
        for each in platen_constraints(case, size) + moved + support_constraints(case, size)
        if each.constraint.boundary in own
    ]
    return BodyDefinition(
        name=name,
        material=Material.of(case.bodies[name], case.model.plane),
        constraints=tuple(each.constraint for each in constrained),
        coordinates=tuple(
            Coordinate(
                each.constraint.label,
                name,
                each.control,
                each.channel,
                each.course,
                each.constraint.resultant,
            )
            for each in constrained
        ),
        surfaces=tuple(surfaces),
        tie=_tie(case, mesh.bodies[name]),
        cuts=tuple(cut for _, cut in own_cuts),
        components=size,
    )


def _tie(case: Case, body: BodyMesh) -> Tie | None:
    """Tie of the sides of a body; None if it has none."""
    for name, symmetry in case.symmetry.items():
        if symmetry.boundary1 in body.boundaries:
            key = ("symmetry", name)
            tie = tie_sides(symmetry, key, case.source, body, case.model.degree)
            return tie.moving(case.components(body.points.shape[1]))
    return None


def across_notes(case: Case, dimension: int) -> tuple[str, ...]:
    """Tell that plane bodies move along z, and what in the case makes them do so, in words."""
    if dimension == 3:
        return ()
    keys = [".".join(map(str, key)) for key in case.moving_across()]
    if not keys:
        return ()
    return (
        f"plane bodies move along z, too: displacements u_z(x, y) are part of the model by "
        f"{', '.join(keys)}",
    )


def layer_notes(case: Case, definition: ModelDefinition, mesh: Mesh) -> tuple[str, ...]:
    """Layers of initial strain that elements do not resolve or bodies do not contain, in words."""
    notes = []
    for load in definition.loads:
        for name, layer in load.layers.items():
            height, changes = layer.height_of_elements(mesh.bodies[name]), np.diff(layer.depths)
            if len(changes) and height > FINEST * changes.min():
                unit = case.units.length
                notes.append(
                    f"loads.{load.channel}: elements below the surfaces of {name} are up to "
                    f"{height:.3g} {unit} high, next to depths that differ by {changes.min():.3g} "
                    f"{unit}: there the mesh does not follow the strain, which is linear in an "
                    "element, and the layer stretches and bends the body by a wrong amount"
                )
            deepest = layer.largest_depth(mesh.bodies[name])
            if layer.depths[-1] > (1 + FLAT) * deepest:
                notes.append(
                    f"loads.{load.channel}: the depths go down to {layer.depths[-1]:.4g} "
                    f"{case.units.length}, but nothing of {name} is deeper below the surfaces than "
                    f"{deepest:.4g} {case.units.length}: check their unit"
                )
    return tuple(notes)


def side_notes(definition: ModelDefinition) -> tuple[str, ...]:
    """Initial strains that neighbour sectors do not continue, in words."""
    notes = []
    for body in definition.bodies:
        tie = body.tie
        for load in definition.loads:
            if tie is None or not load.strains(body.name):
                continue
            found = tie.mismatch(partial(load.initial_strain, body.name, body.material))
            if found > LARGEST_STEP:
                notes.append(
                    f"loads.{load.channel}: from one sector to the next the strain of "
                    f"{body.name} jumps by {100 * found:.3g} % of the largest at its sides: every "
                    "sector has the load of this one, turned"
                )
    return tuple(notes)


def cut_notes(definition: ModelDefinition) -> tuple[str, ...]:
    """Fate of the fields of other runs, in words."""
    return tuple(note for cut in definition.cuts for note in cut.notes)


def require_possible(case: Case, definition: ModelDefinition, history: History) -> None:
    """Check that loads are possible in a history, as far as its values and the loads tell.

    Raises:
        CaseError: names the first load that is not.
    """
    _require_above_absolute_zero(case, definition, history)
    _require_one_rotation(case, definition, history)
    for cut in definition.cuts:
        cut.require_steps(case, history)


def _require_one_rotation(case: Case, definition: ModelDefinition, history: History) -> None:
    """Check that speeds are not to be added: the force goes with the square of their sum.

    Raises:
        CaseError: names the loads, and when they turn the bodies together.
    """
    names = [load.channel for load in definition.loads if load.kind == "rotation"]
    speeds = history.values[:, [history.channels.index(name) for name in names]]
    both = np.flatnonzero((speeds != 0).sum(axis=1) > 1)
    if both.size:
        raise CaseError(
            f"{case.source}: loads: expected one load of the type rotation at a time, found "
            f"{' and '.join(names)} at time {history.times[both[0]]:g}: the force goes with the "
            "square of the whole speed, so give that by one of them"
        )


def _require_above_absolute_zero(case: Case, definition: ModelDefinition, history: History) -> None:
    """Check that no temperature of a history is below absolute zero.

    Raises:
        CaseError: names the first load that would be.
    """
    for load in definition.loads:
        if load.kind != "temperature" or load.at_points is None:
            continue
        parts = history.values[:, history.channels.index(load.channel)]
        for name in load.bodies or case.bodies:
            start = case.bodies[name].reference_temperature or 0.0
            coldest = float((start + np.outer(parts, load.at_points.values - start)).min())
            if coldest < ABSOLUTE_ZERO:
                raise CaseError(
                    f"{case.source}: loads.{load.channel}.history: expected temperatures >= "
                    f"{ABSOLUTE_ZERO:g} (absolute zero, in degrees Celsius), found {coldest:g} in "
                    f"the body {name!r}, whose reference temperature is {start:g}"
                )
    for name in case.bodies:
        _require_sum_above_absolute_zero(case, definition, history, name)


def _require_sum_above_absolute_zero(
    case: Case, definition: ModelDefinition, history: History, body: str
) -> None:
    """Check loads that change the temperature of a body together, at the points that they have."""
    heats = [load for load in definition.loads if load.kind == "temperature" and load.strains(body)]
    names = list(dict.fromkeys(load.channel for load in heats))
    if len(names) < 2:
        return
    start = case.bodies[body].reference_temperature or 0.0
    nodes = [load.changes[body].points for load in heats if body in load.changes]
    given = [load.at_points.points for load in heats if load.at_points is not None]
    places = nodes[0] if nodes else np.unique(np.concatenate(given), axis=0)
    changes = np.stack([load.temperature_change(body, start, places) for load in heats])
    columns = [history.values[:, history.channels.index(load.channel)] for load in heats]
    parts = np.stack([load.amplitudes(each) for load, each in zip(heats, columns, strict=True)])
    coldest = min(
        (start + float((state @ changes).min()), time)
        for state, time in zip(parts.T, history.times, strict=True)
    )
    if coldest[0] < ABSOLUTE_ZERO:
        raise CaseError(
            f"{case.source}: loads: expected temperatures >= {ABSOLUTE_ZERO:g} (absolute zero, in "
            f"degrees Celsius), found {coldest[0]:g} in the body {body!r} at time {coldest[1]:g} "
            f"by {' and '.join(names)} together, which each change its temperature from "
            f"{start:g}"
        )


@dataclass(frozen=True)
class Pair:
    """One contact: its name, its bodies and its coupling."""

    name: str
    body1: str
    body2: str
    coupling: Coupling


def contact_surfaces(definition: ModelDefinition, mesh: Mesh) -> dict[str, Surface]:
    """All contact surfaces, oriented, by name."""
    return {
        name: build_surface(mesh.bodies[body.name], name)
        for body in definition.bodies
        for name in body.surfaces
    }


def couple_contacts(case: Case, surfaces: dict[str, Surface], components: int) -> tuple[Pair, ...]:
    """The contact pairs of a case, in its order, for so many components of the displacement."""
    pairs = []
    for name, contact in case.contacts.items():
        first, second = surfaces[contact.surface1], surfaces[contact.surface2]
        coupling = couple(name, first, second, contact.multipliers, case.model.degree, components)
        pairs.append(Pair(name, first.body, second.body, coupling))
    return tuple(pairs)
