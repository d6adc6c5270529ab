# SPDX-License-Identifier: LGPL-3.0-or-later
"""Definition of the model: bodies with their materials, supports, loads and contact surfaces."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.point_values import OUTSIDE, PointValues, read_points
from fretfe.case import Case, unit_vector
from fretfe.case.base import ABSOLUTE_ZERO
from fretfe.case.loads import (
    DisplacementLoad,
    PlatenLoad,
    RotationLoad,
    TemperatureLoad,
    TiltLoad,
    TractionLoad,
)
from fretfe.contact.interface import Coordinate
from fretfe.errors import CaseError, ModelError
from fretfe.loads import History
from fretfe.mesh.mesh import Mesh, place_text
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
        expansion: coefficient of thermal expansion, zero if no load needs it.
        reference_temperature: without thermal strain.
    """

    young: float
    poisson: float
    density: float
    plane: str
    expansion: float = 0.0
    reference_temperature: float = 0.0

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

    def initial_stress(self, strain: Array) -> Array:
        """(m, 3, 3) stress without which initial strains (m, 3, 3) would deform a body.

        In plane strain nothing moves along z, in plane stress nothing holds it there.
        """
        stress = 2 * self.shear_modulus * strain
        strained = strain[:, :2, :2] if self.plane == "stress" else strain
        trace = np.trace(strained, axis1=1, axis2=2)
        stress += self.first_lame * trace[:, None, None] * np.eye(3)
        if self.plane == "stress":
            stress[:, 2, 2] = 0.0
        return stress


@dataclass(frozen=True)
class DistributedLoad:
    """A load per unit of its channel that is spread over a boundary or the volume.

    Attributes:
        channel: name of the load in the case file.
        kind: "traction" (along `direction`), "normal" (outward traction), "rotation" or
            "temperature".
        boundary: physical group of a traction, "" for what acts in the volume.
        direction: unit vector of a traction; axis of a rotation.
        centre: a point on the axis of a rotation.
        field: temperatures.
        bodies: that a temperature acts on; () for all.
    """

    channel: str
    kind: str
    boundary: str = ""
    direction: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()
    field: PointValues | None = None
    bodies: tuple[str, ...] = ()

    def initial_strain(self, body: str, material: Material, places: Array) -> Array | None:
        """(m, 3, 3) initial strain of a body at places (m, d); None if the load causes none."""
        if self.kind != "temperature" or (self.bodies and body not in self.bodies):
            return None
        assert self.field is not None
        change = self.field.at(places) - material.reference_temperature
        return material.expansion * change[:, None, None] * np.eye(3)


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

    @property
    def digest(self) -> str:
        """Text that is equal for loads with the same values at points."""
        found = hashlib.sha256()
        for load in self.loads:
            if load.field is not None:
                found.update(load.field.points.tobytes() + load.field.values.tobytes())
        return found.hexdigest()


def define_model(case: Case, mesh: Mesh) -> ModelDefinition:
    """Translate a case into bodies, coordinates and loads.

    Raises:
        ModelError: if a body has no contact surface.
        CaseError: if values at points cannot be read, or do not reach as far as the bodies.
    """
    gdim = mesh.dimension
    loads = distributed_loads(case, gdim)
    for load in loads:
        _require_points_around(case, load, mesh)
    return ModelDefinition(
        bodies=tuple(_define_body(case, mesh, name, gdim) for name in case.bodies), loads=loads
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
        material=Material(
            body.young,
            body.poisson,
            body.density or 0.0,
            case.model.plane,
            body.expansion or 0.0,
            body.reference_temperature or 0.0,
        ),
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
    """All loads of a case that are spread over boundaries or bodies, in its order.

    Raises:
        CaseError: if a file with values at points is not as expected.
    """
    loads = []
    for name, load in case.loads.items():
        if isinstance(load, TemperatureLoad):
            field = _temperatures(case, load, gdim)
            loads.append(
                DistributedLoad(name, "temperature", field=field, bodies=load.bodies or ())
            )
        elif isinstance(load, RotationLoad):
            axis = unit_vector(load.axis, 3)
            loads.append(DistributedLoad(name, "rotation", "", axis, load.centre))
        elif isinstance(load, TractionLoad) and load.direction == "normal":
            loads.append(DistributedLoad(name, "normal", load.boundary))
        elif isinstance(load, TractionLoad):
            direction = unit_vector(load.direction, gdim)
            loads.append(DistributedLoad(name, "traction", load.boundary, direction))
    return tuple(loads)


def _temperatures(case: Case, load: TemperatureLoad, gdim: int) -> PointValues:
    if load.value is not None:
        return PointValues(np.zeros((1, gdim)), np.array([load.value]))
    if load.file is None:
        return PointValues(np.array(load.points), np.array(load.values))
    found = read_points(case.resolve(load.file), gdim, "T")
    if found.values.min() < ABSOLUTE_ZERO:
        raise CaseError(
            f"{case.resolve(load.file)}: column 'T': expected temperatures >= {ABSOLUTE_ZERO:g} "
            f"(absolute zero, in degrees Celsius), found {found.values.min():g}"
        )
    return found


def _require_points_around(case: Case, load: DistributedLoad, mesh: Mesh) -> None:
    """Check that values at points reach as far as what they are for.

    Raises:
        CaseError: names the place that is farthest outside.
    """
    if load.field is None:
        return
    for name in load.bodies or case.bodies:
        places = mesh.bodies[name].points
        farthest, excess = load.field.outside(places)
        if excess > OUTSIDE:
            raise CaseError(
                f"{case.source}: loads.{load.channel}: expected points that reach as far as the "
                f"body {name!r}, whose node at {place_text(places[farthest])} is farther from "
                f"their middle by {100 * excess:.3g} % than their outermost ones"
            )


def require_above_absolute_zero(case: Case, definition: ModelDefinition, history: History) -> None:
    """Check that no temperature of a history is below absolute zero.

    Raises:
        CaseError: names the first load that would be.
    """
    for load in definition.loads:
        if load.kind != "temperature":
            continue
        assert load.field is not None
        parts = history.values[:, history.channels.index(load.channel)]
        for name in load.bodies or case.bodies:
            start = case.bodies[name].reference_temperature or 0.0
            coldest = float((start + np.outer(parts, load.field.values - start)).min())
            if coldest < ABSOLUTE_ZERO:
                raise CaseError(
                    f"{case.source}: loads.{load.channel}.history: expected temperatures >= "
                    f"{ABSOLUTE_ZERO:g} (absolute zero, in degrees Celsius), found {coldest:g} in "
                    f"the body {name!r}, whose reference temperature is {start:g}"
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


def couple_contacts(case: Case, surfaces: dict[str, Surface]) -> tuple[Pair, ...]:
    """The contact pairs of a case, in its order."""
    pairs = []
    for name, contact in case.contacts.items():
        first, second = surfaces[contact.surface1], surfaces[contact.surface2]
        coupling = couple(name, first, second, contact.multipliers, case.model.degree)
        pairs.append(Pair(name, first.body, second.body, coupling))
    return tuple(pairs)
