# SPDX-License-Identifier: LGPL-3.0-or-later
"""Definition of the model: materials, constrained boundaries, loads and contact surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe.bodies.body import Constraint, DistributedLoad, Material
from fretfe.case import Case, unit_vector
from fretfe.case.channels import (
    DisplacementLoad,
    PlatenLoad,
    RotationLoad,
    TiltLoad,
    TractionLoad,
)
from fretfe.contact.interface import Coordinate
from fretfe.errors import ModelError
from fretfe.mesh.mesh import Mesh
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import Surface, build_surface

AXES = "xyz"
# What a coordinate calls the moment and the rotation of a tilt.
TILT_CONTROLS = {"moment": "force", "rotation": "displacement"}


@dataclass(frozen=True)
class BodyDefinition:
    """Definition of one body.

    Attributes:
        name: physical group of the body.
        material: elastic constants.
        constraints: constrained boundaries, in order of precedence.
        coordinates: one for each constraint.
        surfaces: contact surfaces of the body, in the order of the contacts.
    """

    name: str
    material: Material
    constraints: tuple[Constraint, ...]
    coordinates: tuple[Coordinate, ...]
    surfaces: tuple[str, ...]


@dataclass(frozen=True)
class ModelDefinition:
    """Definition of all bodies, and of the loads on whichever body has their boundary."""

    bodies: tuple[BodyDefinition, ...]
    loads: tuple[DistributedLoad, ...]


def define_model(case: Case, mesh: Mesh) -> ModelDefinition:
    """Translate a case into bodies, coordinates and loads.

    Raises:
        ModelError: if a body has no contact surface.
    """
    gdim = next(iter(mesh.bodies.values())).points.shape[1]
    return ModelDefinition(
        bodies=tuple(_define_body(case, mesh, name, gdim) for name in case.bodies),
        loads=distributed_loads(case, gdim),
    )


def _define_body(case: Case, mesh: Mesh, name: str, gdim: int) -> BodyDefinition:
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
    constrained = [
        entry
        for entry in _platens(case, gdim) + _displacements(case, gdim) + _supports(case, gdim)
        if entry[0].boundary in own
    ]
    return BodyDefinition(
        name=name,
        material=_material(case, name),
        constraints=tuple(constraint for constraint, _, _ in constrained),
        coordinates=tuple(
            Coordinate(constraint.label, name, control, channel)
            for constraint, control, channel in constrained
        ),
        surfaces=tuple(surfaces),
    )


def _material(case: Case, name: str) -> Material:
    body = case.bodies[name]
    return Material(body.young, body.poisson, body.density or 0.0, case.model.plane)


def _platens(case: Case, gdim: int) -> list[tuple[Constraint, str, str]]:
    """Loaded directions of each platen, then the guided ones, then its tilts."""
    platens: dict[str, list[str]] = {}
    for name, load in case.loads.items():
        if isinstance(load, PlatenLoad | TiltLoad):
            platens.setdefault(load.boundary, []).append(name)
    constrained: list[tuple[Constraint, str, str]] = []
    for boundary, names in platens.items():
        directions: list[tuple[float, ...]] = []
        tilts: list[tuple[Constraint, str, str]] = []
        for name in names:
            load = case.loads[name]
            if isinstance(load, TiltLoad):
                tilts.append(_tilt(name, load, gdim))
                continue
            assert isinstance(load, PlatenLoad)
            directions.append(unit_vector(load.direction, gdim))
            constrained.append((Constraint(name, boundary, directions[-1]), load.control, name))
        for direction in _complement(directions, gdim):
            label = f"{boundary} guide {_direction_name(direction)}"
            constrained.append((Constraint(label, boundary, direction), "fixed", ""))
        constrained += tilts
    return constrained


def _tilt(name: str, load: TiltLoad, gdim: int) -> tuple[Constraint, str, str]:
    """A rotation and its moment are the displacement and the force of their coordinate."""
    axis, control = unit_vector(load.axis, 3), TILT_CONTROLS[load.control]
    constraint = Constraint(
        name, load.boundary, (0.0,) * gdim, axis=axis, centre=load.centre[:gdim]
    )
    return constraint, control, name


def _displacements(case: Case, gdim: int) -> list[tuple[Constraint, str, str]]:
    return [
        (Constraint(name, load.boundary, unit_vector(load.direction, gdim)), "displacement", name)
        for name, load in case.loads.items()
        if isinstance(load, DisplacementLoad)
    ]


def _supports(case: Case, gdim: int) -> list[tuple[Constraint, str, str]]:
    """Components that are held, then the inclined rollers: those go last at a common node."""
    fixed = [
        (Constraint(f"{name} {axis}", support.boundary, unit_vector(axis, gdim)), "fixed", "")
        for name, support in case.supports.items()
        for axis in support.fix
    ]
    rollers = [
        (Constraint(name, support.boundary, support.direction, roller=True), "fixed", "")
        for name, support in case.supports.items()
        if support.direction is not None
    ]
    return fixed + rollers


def _complement(directions: list[tuple[float, ...]], gdim: int) -> list[tuple[float, ...]]:
    """Unit vectors normal to the given orthogonal ones, along the axes where possible."""
    basis = [np.array(direction) for direction in directions]
    added: list[tuple[float, ...]] = []
    for axis in np.eye(gdim):
        rest = axis - sum((axis @ b) * b for b in basis)
        length = np.linalg.norm(rest)
        if length > 1e-6 and len(basis) < gdim:
            basis.append(rest / length)
            added.append(tuple(float(v) for v in rest / length))
    return added


def _direction_name(direction: tuple[float, ...]) -> str:
    components = np.flatnonzero(np.abs(direction) > 1e-12)
    if len(components) == 1:
        return AXES[components[0]]
    return "(" + ", ".join(f"{v:.4g}" for v in direction) + ")"


def distributed_loads(case: Case, gdim: int) -> tuple[DistributedLoad, ...]:
    """Tractions and rotations of a case, in its order."""
    loads = []
    for name, load in case.loads.items():
        if isinstance(load, RotationLoad):
            axis = unit_vector(load.axis, 3)
            loads.append(DistributedLoad(name, "rotation", "", axis, load.centre))
        elif isinstance(load, TractionLoad) and load.direction == "normal":
            loads.append(DistributedLoad(name, "normal", load.boundary))
        elif isinstance(load, TractionLoad):
            direction = unit_vector(load.direction, gdim)
            loads.append(DistributedLoad(name, "traction", load.boundary, direction))
    return tuple(loads)


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


def couple_contacts(case: Case, surfaces: dict[str, Surface]) -> tuple[Pair, ...]:
    """The contact pairs of a case, in its order."""
    pairs = []
    for name, contact in case.contacts.items():
        first, second = surfaces[contact.surface1], surfaces[contact.surface2]
        coupling = couple(name, first, second, contact.multipliers, case.model.degree)
        pairs.append(Pair(name, first.body, second.body, coupling))
    return tuple(pairs)
