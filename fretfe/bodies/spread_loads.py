# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that are spread over boundaries or bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.cut import Cut, read_temperatures
from fretfe.bodies.load_files import STRAINS, values_at_points
from fretfe.bodies.material import Material
from fretfe.bodies.point_values import (
    FLAT,
    NodalValues,
    PointValues,
    require_points_around,
)
from fretfe.case import Case, complaint, unit_vector
from fretfe.case.loads import (
    AccelerationLoad,
    EigenstrainLoad,
    ForceLoad,
    InterferenceLoad,
    RotationLoad,
    TemperatureFieldLoad,
    TemperatureLoad,
    TractionLoad,
)
from fretfe.errors import CaseError, MeshError
from fretfe.mesh.elements import CORNERS
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import Surface, boundary_surface

# Of a facet along each of its edges there are more samples than this.
FEWEST_SAMPLES = 8
# From a node to the nearest point of integration of a part of a boundary, over the extent of its
# facet: at most .03 along a line, .06 in a triangle.
POINTS_BESIDE = 0.06


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
        if self.kind == "eigenstrain":
            assert self.at_points is not None
            given = self.at_points.at(places)
            strain = np.zeros((len(places), 3, 3))
            for component, (i, j) in zip(given.T, STRAINS.values(), strict=False):
                strain[:, i, j] = strain[:, j, i] = component
            return strain
        change = self.temperature_change(body, material.reference_temperature, places)
        return np.asarray(material.expansion * change[:, None, None] * np.eye(3))

    def temperature_change(self, body: str, start: float, places: Array) -> Array:
        """(m,) change from a reference temperature at places (m, d) of a body, for a unit."""
        if body in self.changes:
            return self.changes[body].at(places)
        assert self.at_points is not None
        return np.asarray(self.at_points.at(places) - start)


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


def require_values_around(case: Case, load: DistributedLoad, mesh: Mesh) -> None:
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
            require_points_around(case, load.channel, load.at_points, places, what)
