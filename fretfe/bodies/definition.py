# SPDX-License-Identifier: LGPL-3.0-or-later
"""Definition of the model: bodies with their materials, supports, loads and contact surfaces."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.crystals import isotropic as isotropic_stiffness
from fretfe.analytic.crystals import plane_stress, tensor
from fretfe.bodies.cut import Asked, Cut, read_cuts, read_temperatures
from fretfe.bodies.cyclic import Tie, tie_sides
from fretfe.bodies.load_files import STRAINS, values_at_points
from fretfe.bodies.point_values import OUTSIDE, NodalValues, PointValues
from fretfe.case import (
    AnyBody,
    Case,
    Plane,
    complaint,
    isotropic,
    stiffness,
    unit_vector,
)
from fretfe.case.base import ABSOLUTE_ZERO, AXES
from fretfe.case.loads import (
    AccelerationLoad,
    DisplacementLoad,
    EigenstrainLoad,
    FieldLoad,
    ForceLoad,
    InterferenceLoad,
    PlatenLoad,
    RotationLoad,
    ShapeLoad,
    TemperatureFieldLoad,
    TemperatureLoad,
    TiltLoad,
    TractionLoad,
)
from fretfe.contact.interface import Coordinate, Course
from fretfe.errors import CaseError, MeshError, ModelError
from fretfe.loads import History
from fretfe.mesh.elements import CORNERS
from fretfe.mesh.mesh import BodyMesh, Mesh, place_text
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import Surface, boundary_surface, build_surface


@dataclass(frozen=True)
class Material:
    """Linear elasticity of a body.

    Attributes:
        young: Young's modulus (stress); NaN of a crystal.
        poisson: Poisson's ratio; NaN of a crystal.
        density: mass per volume, zero if no load needs it.
        plane: "strain" or "stress"; without meaning in three dimensions.
        expansion: coefficient of thermal expansion, zero if no load needs it.
        reference_temperature: without thermal strain.
        crystal: (6, 6) stiffness of a crystal in the axes of the model, in Voigt's order as in
            `analytic.crystals`, in plane stress that of strains in the plane; None if isotropic.
    """

    young: float
    poisson: float
    density: float
    plane: str
    expansion: float = 0.0
    reference_temperature: float = 0.0
    crystal: tuple[tuple[float, ...], ...] | None = None

    @classmethod
    def of(cls, body: AnyBody, plane: Plane) -> Material:
        """The material of a body of a case."""
        known = isotropic(body)
        young, poisson = (known.young, known.poisson) if known else (np.nan, np.nan)
        rest = body.density or 0.0, plane, body.expansion or 0.0, body.reference_temperature or 0.0
        crystal = None if known else tuple(map(tuple, stiffness(body, plane).tolist()))
        return cls(young, poisson, *rest, crystal)

    @property
    def text(self) -> str:
        """The elastic constants, for people."""
        if self.crystal is None:
            return f"E = {self.young:g}, ν = {self.poisson:g}"
        matrix = np.array(self.crystal)
        return "crystal, in the axes of the model " + ", ".join(
            f"C{i + 1}{j + 1} = {matrix[i, j]:.5g}"
            for i, j in zip(*np.triu_indices(6), strict=True)
            if abs(matrix[i, j]) > SHOWN * np.abs(matrix).max()
        )

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

    @property
    def stiffness(self) -> Array:
        """(6, 6) in the axes of the model, in plane stress that of strains in the plane."""
        if self.crystal is not None:
            return np.array(self.crystal)
        whole = isotropic_stiffness(self.young, self.poisson)
        return plane_stress(whole) if self.plane == "stress" else whole

    @property
    def tensor(self) -> Array:
        """(3, 3, 3, 3) stiffness."""
        return tensor(self.stiffness)

    @property
    def across(self) -> Array:
        """(3,) stress zz of plane bodies by a unit of xx, yy and xy; nothing in plane stress."""
        if self.plane == "stress":
            return np.zeros(3)
        matrix, own = self.stiffness, [0, 1, 5]
        return np.asarray(np.linalg.solve(matrix[np.ix_(own, own)], matrix[2, own]))

    def initial_stress(self, strain: Array) -> Array:
        """(m, 3, 3) stress without which initial strains (m, 3, 3) would deform a body.

        In plane strain nothing moves along z, in plane stress nothing holds it there.
        """
        return np.einsum("ijkl,mkl->mij", self.tensor, strain)


@dataclass(frozen=True)
class Layer:
    """Initial strain below some surfaces of a body, equal in all directions of the surface.

    Attributes:
        surfaces: of the body.
        depths: (n,) below them, increasing from 0.
        values: (n,) strains there.
    """

    surfaces: tuple[Surface, ...]
    depths: Array
    values: Array

    def strain(self, places: Array) -> Array:
        """(m, 3, 3) strain at places (m, d) of the body."""
        depth, normals = self._depth(places)
        size = np.interp(depth, self.depths, self.values)
        across = np.zeros((len(places), 3))
        across[:, : places.shape[1]] = normals
        directions = np.eye(3) - across[:, :, None] * across[:, None, :]
        return np.asarray(size[:, None, None] * directions)

    def _depth(self, places: Array) -> tuple[Array, Array]:
        """(m,) distance from the nearest surface, and (m, d) its outward normal there."""
        depth, normals = np.full(len(places), np.inf), np.zeros(places.shape)
        for surface in self.surfaces:
            nearest, own = surface.nearest(places)
            away = places - nearest
            height = np.sum(away * own, axis=1)
            # Places of a surface are samples: it is their tangent plane, as far as the next one.
            spacing = np.ptp(surface.nodes, axis=1).max() / FEWEST_SAMPLES
            beside = np.linalg.norm(away - height[:, None] * own, axis=1) - spacing
            found = np.hypot(height, np.maximum(beside, 0.0))
            nearer = found < depth
            depth, normals = np.where(nearer, found, depth), np.where(nearer[:, None], own, normals)
        return depth, normals

    def largest_depth(self, mesh: BodyMesh) -> float:
        """Distance of the node of a body that is farthest below the surfaces."""
        return float(self._depth(mesh.points)[0].max())

    def height_of_elements(self, mesh: BodyMesh) -> float:
        """Largest depth to which an element with a facet on the surfaces reaches."""
        corners = mesh.cells[:, : CORNERS[mesh.cell]]
        depth, _ = self._depth(mesh.points)
        below = depth[corners]
        at_surface = below < FLAT * np.ptp(mesh.points, axis=0).max()
        touching = at_surface.sum(axis=1) >= mesh.points.shape[1]
        return float(below[touching].max())


@dataclass(frozen=True)
class DistributedLoad:
    """A load per unit of its channel that is spread over a boundary or the volume.

    Attributes:
        channel: name of the load in the case file.
        kind: "traction" (along `direction`), "normal" (outward traction), "force" (a traction whose
            resultant is one), "rotation", "acceleration", "temperature", "eigenstrain" or
            "interference".
        boundary: physical group of a traction, "" for what acts in the volume.
        direction: unit vector of a traction or an acceleration; axis of a rotation.
        centre: a point on the axis of a rotation; of the part of its boundary that a force acts on.
        radius: of that part; 0 for all of the boundary.
        at_points: temperatures, strains in the order of `STRAINS`, or factors of a traction.
        bodies: that a temperature or strains at points act on; () for all.
        layers: of an eigenstrain, by body.
        contact: of an interference.
        changes: of the temperature from that of reference, by body: a shape of that of another run.
        number: of that shape, from 1.
        cut: all of them.
    """

    channel: str
    kind: str
    boundary: str = ""
    direction: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()
    at_points: PointValues | None = None
    bodies: tuple[str, ...] = ()
    layers: Mapping[str, Layer] = field(default_factory=dict)
    contact: str = ""
    radius: float = 0.0
    changes: Mapping[str, NodalValues] = field(default_factory=dict)
    number: int = 0
    cut: Cut | None = None

    @property
    def label(self) -> str:
        """Name of its own: that of its channel, with a number where this has several."""
        return f"{self.channel} {self.number}" if self.number else self.channel

    def amplitudes(self, values: Array) -> Array:
        """(T,) amplitudes by values (T,) of its channel."""
        if self.cut is not None:
            return self.cut.courses[self.number - 1].at(values)
        # The body force goes with the square of the angular speed.
        return values**2 if self.kind == "rotation" else values

    @property
    def pushes(self) -> bool:
        """True if it is a body force."""
        return self.kind in ("rotation", "acceleration")

    def strains(self, body: str) -> bool:
        """True if it causes an initial strain of a body."""
        at_points = self.at_points is not None and self.kind in ("temperature", "eigenstrain")
        return (
            body in self.layers
            or body in self.changes
            or (at_points and body in (self.bodies or (body,)))
        )

    def body_force(self, material: Material, places: Array) -> Array:
        """(m, d) force per volume at places (m, d) by a unit of the amplitude of one that pushes.

        (m, 3) of an acceleration that plane bodies feel along z. A rotation's amplitude is the
        square of the angular speed.
        """
        size = places.shape[1]
        if self.kind == "acceleration":
            return np.tile(material.density * np.array(self.direction), (len(places), 1))
        arms = places - np.array(self.centre[:size])
        if size == 3:  # in the plane the axis is normal to it
            axis = np.array(self.direction)
            arms = arms - np.outer(arms @ axis, axis)
        return np.asarray(material.density * arms)

    def initial_strain(self, body: str, material: Material, places: Array) -> Array:
        """(m, 3, 3) initial strain at places (m, d) of a body that it strains, for a unit."""
        if body in self.layers:
            return self.layers[body].strain(places)
        if body in self.changes:
            grown = material.expansion * self.changes[body].at(places)
            return np.asarray(grown[:, None, None] * np.eye(3))
        assert self.at_points is not None
        given = self.at_points.at(places)
        if self.kind == "eigenstrain":
            strain = np.zeros((len(places), 3, 3))
            for component, (i, j) in zip(given.T, STRAINS.values(), strict=False):
                strain[:, i, j] = strain[:, j, i] = component
            return strain
        change = given - material.reference_temperature
        return np.asarray(material.expansion * change[:, None, None] * np.eye(3))


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
        resultant: whether it is there to tell a force or moment, and holds what moves by a shape.
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
    resultant: bool = False

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


# Stiffnesses below this part of the largest one are not listed.
SHOWN = 1e-6
# A place is on a surface if it is nearer to it than this part of the extent of the body.
FLAT = 1e-6
# Of a facet along each of its edges there are more samples than this.
FEWEST_SAMPLES = 8
# From a node to the nearest point of integration of a part of a boundary, over the extent of its
# facet: at most .03 along a line, .06 in a triangle.
POINTS_BESIDE = 0.06
# Part of an initial strain that may differ at the sides of a sector: values at points are
# interpolated, and constant across a line of points.
LARGEST_STEP = 0.02
# Height of an element over the distance of two depths from which it does not see both.
FINEST = 1.01
# What a coordinate calls the moment and the rotation of a tilt.
TILT_CONTROLS = {"moment": "force", "rotation": "displacement"}


class Driven(NamedTuple):
    """A constraint and what its coordinate has to know."""

    constraint: Constraint
    control: str = "fixed"
    channel: str = ""
    course: Course | None = None


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
        _require_values_around(case, load, mesh)
    cuts = _read_cuts(case, mesh)
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
    shapes = _shapes(case, mesh.bodies[name])
    own_cuts = [each for each in cuts.values() if each[0].body == name]
    cut = [driven for each in own_cuts for driven in _driven(*each)]
    moved = _displacements(case, size) + shapes + cut
    constrained = [
        each
        for each in _platens(case, size) + moved + _supports(case, size)
        if each.constraint.boundary in own
    ]
    return BodyDefinition(
        name=name,
        material=Material.of(case.bodies[name], case.model.plane),
        constraints=tuple(each.constraint for each in constrained),
        coordinates=tuple(
            Coordinate(each.constraint.label, name, each.control, each.channel, each.course)
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


def _platens(case: Case, size: int) -> list[Driven]:
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


def _displacements(case: Case, size: int) -> list[Driven]:
    return [
        Driven(
            Constraint(name, load.boundary, unit_vector(load.direction, size)), "displacement", name
        )
        for name, load in case.loads.items()
        if isinstance(load, DisplacementLoad)
    ]


def _shapes(case: Case, body: BodyMesh) -> list[Driven]:
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
        _require_points_beside(case, name, given, places, what)
        _require_points_around(case, name, given, places, what)
        shape = NodalShape(places, given.at(places))
        if not shape.values.any():
            text = f"expected a shape that moves {what}, found no displacement at its nodes"
            raise CaseError(complaint(case.source, ("loads", name), text))
        moved = Constraint(name, load.boundary, (0.0,) * gdim, shape=shape)
        constrained.append(Driven(moved, "displacement", name))
        constrained += _resultant(name, load.boundary, places)
    return constrained


def _nodes(case: Case, body: BodyMesh, boundary: str) -> Array:
    """(n, d) nodes of the displacement on a boundary."""
    return boundary_surface(body, boundary).displacement_points(case.model.degree)


def _read_cuts(case: Case, mesh: Mesh) -> dict[str, tuple[Asked, Cut]]:
    """Cuts, with what their loads ask for, by the names of these.

    Raises:
        CaseError: if the field of a run is not as expected.
    """
    files: dict[Path, list[Asked]] = {}
    for name, load in case.loads.items():
        if isinstance(load, FieldLoad):
            (body,) = (each for each in mesh.bodies.values() if load.boundary in each.boundaries)
            asked = Asked(name, load, body.name, _nodes(case, body, load.boundary))
            files.setdefault(case.resolve(load.file), []).append(asked)
    cuts = {name: cut for path, every in files.items()
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


def _driven(asked: Asked, cut: Cut) -> list[Driven]:
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


def _resultant(name: str, boundary: str, places: Array) -> list[Driven]:
    """Rigid motions of a boundary that are held, about the middle of its extent; nodes (n, d)."""
    gdim = places.shape[1]
    centre = tuple(((places.min(axis=0) + places.max(axis=0)) / 2).tolist())
    axes = {axis: unit_vector(axis, 3) for axis in AXES}
    moves = [
        Constraint(f"{name} force {axis}", boundary, unit_vector(axis, gdim), resultant=True)
        for axis in AXES[:gdim]
    ]
    turns = [
        Constraint(f"{name} moment {axis}", boundary, (0.0,) * gdim, axis=vector, centre=centre,
                   resultant=True)
        for axis, vector in axes.items()
        if gdim == 3 or axis == "z"
    ]  # fmt: skip
    return [Driven(each) for each in (*moves, *turns)]


def _supports(case: Case, size: int) -> list[Driven]:
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


def distributed_loads(case: Case, mesh: Mesh) -> tuple[DistributedLoad, ...]:
    """All loads of a case that are spread over boundaries or bodies, in its order.

    Raises:
        CaseError: if a file with values at points is not as expected.
    """
    loads, gdim, size = [], mesh.dimension, case.components(mesh.dimension)
    for name, load in case.loads.items():
        if isinstance(load, EigenstrainLoad):
            loads.append(_eigenstrain(case, name, load, mesh))
        elif isinstance(load, TemperatureLoad):
            given = (
                values_at_points(case, name, load, gdim)
                if load.value is None
                else PointValues(np.zeros((1, gdim)), np.array([load.value]))
            )
            own = load.bodies or ()
            loads.append(DistributedLoad(name, "temperature", at_points=given, bodies=own))
        elif isinstance(load, TemperatureFieldLoad):
            loads += _temperatures(case, name, load, mesh)
        elif isinstance(load, InterferenceLoad):
            loads.append(DistributedLoad(name, "interference", contact=load.contact))
        elif isinstance(load, AccelerationLoad):
            direction = unit_vector(load.direction, size)
            loads.append(DistributedLoad(name, "acceleration", direction=direction))
        elif isinstance(load, RotationLoad):
            axis = unit_vector(load.axis, 3)
            loads.append(DistributedLoad(name, "rotation", "", axis, load.centre))
        elif isinstance(load, ForceLoad):
            direction = unit_vector(load.direction, size)
            centre, radius = load.centre or (), load.radius or 0.0
            force = DistributedLoad(name, "force", load.boundary, direction, centre, radius=radius)
            _require_part(case, force, mesh)
            loads.append(force)
        elif isinstance(load, TractionLoad):
            kind, direction = "normal", ()
            if load.direction != "normal":
                kind, direction = "traction", unit_vector(load.direction, size)
            factors = values_at_points(case, name, load, gdim) if load.at_points else None
            loads.append(DistributedLoad(name, kind, load.boundary, direction, at_points=factors))
    return tuple(loads)


def _temperatures(
    case: Case, name: str, load: TemperatureFieldLoad, mesh: Mesh
) -> list[DistributedLoad]:
    """A load for each shape of the temperatures of another run."""
    places = {body: mesh.bodies[body].points for body in load.bodies or case.bodies}
    starts = [case.bodies[body].reference_temperature or 0.0 for body in places]
    start = np.repeat(starts, [len(each) for each in places.values()])
    try:
        cut = read_temperatures(case.resolve(load.file), load, name, places, start)
    except (CaseError, MeshError) as error:
        raise CaseError(complaint(case.source, ("loads", name, "file"), str(error))) from None
    ends = np.cumsum([len(each) for each in places.values()])[:-1]
    found = []
    for number, shape in enumerate(cut.shapes, 1):
        values = dict(zip(places, np.split(shape[:, 0], ends), strict=True))
        changes = {body: NodalValues(places[body], values[body]) for body in places}
        found.append(DistributedLoad(name, "temperature", changes=changes, number=number, cut=cut))
    return found


def _eigenstrain(case: Case, name: str, load: EigenstrainLoad, mesh: Mesh) -> DistributedLoad:
    if load.file is None:
        return DistributedLoad(name, "eigenstrain", layers=_layers(load, mesh))
    given = values_at_points(case, name, load, mesh.dimension)
    return DistributedLoad(name, "eigenstrain", at_points=given, bodies=load.bodies or ())


def _layers(load: EigenstrainLoad, mesh: Mesh) -> dict[str, Layer]:
    """Layers of the bodies that have some of the surfaces."""
    assert load.surfaces is not None and load.depths is not None and load.values is not None
    layers = {}
    for name, body in mesh.bodies.items():
        own = [surface for surface in load.surfaces if surface in body.boundaries]
        if own:
            surfaces = tuple(boundary_surface(body, surface) for surface in own)
            layers[name] = Layer(surfaces, np.array(load.depths), np.array(load.values))
    return layers


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


def _require_part(case: Case, load: DistributedLoad, mesh: Mesh) -> None:
    """Check that a force acts on some elements, not only within one of them.

    Raises:
        CaseError: says how far the boundary is from the centre.
    """
    for body in mesh.bodies.values():
        if load.radius and load.boundary in body.boundaries:
            surface = boundary_surface(body, load.boundary)
            places, facets = surface.displacement_points(2), surface.displacement_facets(2)
            away = np.linalg.norm(places - np.array(load.centre), axis=1)
            nearest = int(np.argmin(away))
            around = places[facets[(facets == nearest).any(axis=1)]]
            size = np.linalg.norm(np.ptp(around, axis=1), axis=1).max()
            # Points of integration lie next to nodes, not on them.
            least = float(away[nearest] + POINTS_BESIDE * size)
            if least > load.radius:
                raise CaseError(
                    f"{case.source}: loads.{load.channel}.radius: expected at least {least:.4g}, "
                    f"so that nodes or middles of elements of the boundary {load.boundary!r} are "
                    f"well within it, found {load.radius:g}"
                )


def _require_values_around(case: Case, load: DistributedLoad, mesh: Mesh) -> None:
    """Check that values at points reach as far as what they are for.

    Raises:
        CaseError: names the place that is farthest outside.
    """
    if load.at_points is None:
        return
    for name in load.bodies or case.bodies:
        body, what = mesh.bodies[name], f"the body {name!r}"
        places = body.points
        if load.boundary:
            facets = body.boundaries.get(load.boundary, np.zeros(0, dtype=np.int64))
            places = places[np.unique(facets)]
            what = f"the boundary {load.boundary!r}"
        if len(places):
            _require_points_around(case, load.channel, load.at_points, places, what)


def _require_points_around(
    case: Case, channel: str, given: PointValues, places: Array, what: str
) -> None:
    if pair := given.same():
        one, other = (place_text(given.points[each]) for each in sorted(pair))
        raise CaseError(
            f"{case.source}: loads.{channel}: expected points of their own, found "
            f"{one if one == other else f'{one} and {other}'} twice, up to round-off"
        )
    farthest, excess = given.outside(places)
    if excess > OUTSIDE:
        raise CaseError(
            f"{case.source}: loads.{channel}: expected points that reach as far as {what}, whose "
            f"node at {place_text(places[farthest])} is farther from their middle by "
            f"{100 * excess:.3g} % than their outermost ones"
        )


def _require_points_beside(
    case: Case, channel: str, given: PointValues, places: Array, what: str
) -> None:
    farthest, distance = given.beside(places)
    if distance > OUTSIDE:
        raise CaseError(
            f"{case.source}: loads.{channel}: expected points on both sides of {what}, or on it, "
            f"found all of them on one line or plane, from which its node at "
            f"{place_text(places[farthest])} is away by {100 * distance:.3g} % of their extent"
        )


def require_possible(case: Case, definition: ModelDefinition, history: History) -> None:
    """Check that loads are possible in a history, as far as its values and the loads tell.

    Raises:
        CaseError: names the first load that is not.
    """
    _require_above_absolute_zero(case, definition, history)
    for cut in definition.cuts:
        cut.require_steps(case, history)


def cut_notes(definition: ModelDefinition) -> tuple[str, ...]:
    """Fate of the fields of other runs, in words."""
    return tuple(note for cut in definition.cuts for note in cut.notes)


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
