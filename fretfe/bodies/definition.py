# SPDX-License-Identifier: LGPL-3.0-or-later
"""Definition of the model: bodies with their materials, supports, loads and contact surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case, unit_vector
from fretfe.case.loads import DisplacementLoad, PlatenLoad, RotationLoad, TiltLoad, TractionLoad
from fretfe.contact.interface import Coordinate
from fretfe.errors import ModelError
from fretfe.mesh.mesh import Mesh
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import Surface, build_surface


@dataclass(frozen=True)
class Material:
    """Isotropic linear elasticity.

    Attributes:
        young: Young's modulus (stress).
        poisson: Poisson's ratio.
        density: mass per volume, zero if no load needs it.
        plane: "strain" or "stress"; without meaning in three dimensions.
    """

    young: float
    poisson: float
    density: float
    plane: str

    @property
    def shear_modulus(self) -> float:
        """Second Lamé parameter (stress)."""
        return self.young / (2 * (1 + self.poisson))

    @property
    def first_lame(self) -> float:
        """First Lamé parameter (stress), the effective one in plane stress."""
        nu = self.poisson
        if self.plane == "stress":
            return self.young * nu / (1 - nu**2)
        return self.young * nu / ((1 + nu) * (1 - 2 * nu))

    @property
    def kolosov(self) -> float:
        """Kolosov's constant: 3 - 4 nu in plane strain, (3 - nu)/(1 + nu) in plane stress."""
        mu, lame = self.shear_modulus, self.first_lame
        return (lame + 3 * mu) / (lame + mu)


@dataclass(frozen=True)
class DistributedLoad:
    """A load per unit of its channel that is spread over a boundary or the volume.

    Attributes:
        channel: name of the load in the case file.
        kind: "traction" (along `direction`), "normal" (outward traction), or "rotation".
        boundary: physical group of a traction, "" for a rotation.
        direction: unit vector of a traction; axis of a rotation.
        centre: a point on the axis of a rotation.
    """

    channel: str
    kind: str
    boundary: str = ""
    direction: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()


@dataclass(frozen=True)
class Constraint:
    """A boundary that moves by one amplitude: along a direction, or about an axis.

    Attributes:
        label: name used in results and messages.
        boundary: physical group.
        direction: unit vector (gdim,); (0, ...) of a tilt.
        roller: true if only the displacement along `direction` is constrained, false if each of its
            non-zero components is.
        axis: unit vector (3,) of the axis of a tilt; empty otherwise.
        centre: (gdim,) a point on that axis.
    """

    label: str
    boundary: str
    direction: tuple[float, ...]
    roller: bool = False
    axis: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()

    @property
    def components(self) -> Indices:
        """Components of the displacement that it constrains, unless it is a roller."""
        if self.axis:
            return np.arange(len(self.direction))
        return np.flatnonzero(self.direction)

    def displacement(self, points: Array) -> Array:
        """(n, gdim) displacement of points (n, gdim) by a unit amplitude."""
        if not self.axis:
            return np.tile(np.array(self.direction), (len(points), 1))
        arms = points - np.array(self.centre)
        if points.shape[1] == 2:
            return self.axis[2] * np.column_stack([-arms[:, 1], arms[:, 0]])
        return np.cross(self.axis, arms)


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
    body = case.bodies[name]
    return BodyDefinition(
        name=name,
        material=Material(body.young, body.poisson, body.density or 0.0, case.model.plane),
        constraints=tuple(constraint for constraint, _, _ in constrained),
        coordinates=tuple(
            Coordinate(constraint.label, name, control, channel)
            for constraint, control, channel in constrained
        ),
        surfaces=tuple(surfaces),
    )


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
