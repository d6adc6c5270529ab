# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that strain bodies: temperatures, and strains that treatments have left."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.loads.cut import Cut, read_temperatures
from fretfe.bodies.loads.files import values_at_points
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.bodies.point_values import FLAT, NodalValues, PointValues, require_points_around
from fretfe.case import Case, complaint
from fretfe.case.base import ABSOLUTE_ZERO
from fretfe.case.loads import STRAINS, EigenstrainLoad, TemperatureFieldLoad, TemperatureLoad
from fretfe.errors import CaseError, MeshError
from fretfe.loads import History
from fretfe.materials.material import Material
from fretfe.mesh.elements import CORNERS
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import Surface, boundary_surface

# Of a facet along each of its edges there are more samples than this.
FEWEST_SAMPLES = 8
# Height of an element over the distance of two depths from which it does not see both.
FINEST = 1.01


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
class AtPoints(SpreadLoad):
    """A load with values at points, in some bodies, or in all for ()."""

    values: PointValues
    bodies: tuple[str, ...] = ()

    @property
    def given(self) -> tuple[PointValues, ...]:
        """The values."""
        return (self.values,)

    def strains(self, body: str) -> bool:
        """True if it acts on a body."""
        return body in (self.bodies or (body,))

    def require_mesh(self, case: Case, mesh: Mesh) -> None:
        """Check that the values reach as far as the bodies."""
        for name in self.bodies or case.bodies:
            what, places = f"the body {name!r}", mesh.bodies[name].points
            require_points_around(case, self.channel, self.values, places, what)


class Heating(SpreadLoad):
    """A change of temperature, by which bodies expand."""

    def temperature_change(self, body: str, start: float, places: Array) -> Array:
        """(m,) change from a reference temperature at places (m, d) of a body, for a unit."""
        raise NotImplementedError

    def initial_strain(self, body: str, material: Material, places: Array) -> Array:
        """(m, 3, 3) thermal strain at places (m, d) of a body."""
        change = self.temperature_change(body, material.reference_temperature, places)
        return np.asarray(material.expansion * change[:, None, None] * np.eye(3))


@dataclass(frozen=True)
class Temperature(Heating, AtPoints):
    """Temperatures; the amplitude is the part of the way to them."""

    @classmethod
    def of(cls, case: Case, name: str, load: TemperatureLoad, mesh: Mesh) -> tuple[Self]:
        """That of a load of a case."""
        values = (
            values_at_points(case, name, load, mesh.dimension)
            if load.value is None
            else PointValues(np.zeros((1, mesh.dimension)), np.array([load.value]))
        )
        return (cls(name, values, load.bodies or ()),)

    def temperature_change(self, body: str, start: float, places: Array) -> Array:
        """(m,) change at places (m, d)."""
        return np.asarray(self.values.at(places) - start)


@dataclass(frozen=True)
class TemperatureShape(Heating):
    """A shape of the changes of temperature of another run.

    Attributes:
        changes: by body.
        number: of the shape, from 1.
        cut: all of them.
    """

    changes: Mapping[str, NodalValues]
    number: int
    cut: Cut

    @classmethod
    def of(cls, case: Case, name: str, load: TemperatureFieldLoad, mesh: Mesh) -> list[Self]:
        """Those of a load of a case."""
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
            found.append(cls(name, changes, number, cut))
        return found

    @property
    def label(self) -> str:
        """Name of the load, and number of the shape."""
        return f"{self.channel} {self.number}"

    @property
    def run(self) -> Cut:
        """All shapes."""
        return self.cut

    @property
    def given(self) -> tuple[NodalValues, ...]:
        """The changes."""
        return tuple(self.changes.values())

    def amplitudes(self, values: Array) -> Array:
        """(T,) amplitudes of the shape at positions (T,) in the run."""
        return self.cut.courses[self.number - 1].at(values)

    def strains(self, body: str) -> bool:
        """True if it acts on a body."""
        return body in self.changes

    def temperature_change(self, body: str, start: float, places: Array) -> Array:
        """(m,) change at places (m, d)."""
        return self.changes[body].at(places)


@dataclass(frozen=True)
class StrainAtPoints(AtPoints):
    """Strains at points, in the order of `STRAINS`."""

    def initial_strain(self, body: str, material: Material, places: Array) -> Array:
        """(m, 3, 3) strain at places (m, d)."""
        strain = np.zeros((len(places), 3, 3))
        for component, (i, j) in zip(self.values.at(places).T, STRAINS.values(), strict=False):
            strain[:, i, j] = strain[:, j, i] = component
        return strain


@dataclass(frozen=True)
class StrainBelow(SpreadLoad):
    """Strain of layers below surfaces, by body."""

    layers: Mapping[str, Layer]

    def strains(self, body: str) -> bool:
        """True if a body has some of the surfaces."""
        return body in self.layers

    def initial_strain(self, body: str, material: Material, places: Array) -> Array:
        """(m, 3, 3) strain at places (m, d)."""
        return self.layers[body].strain(places)

    def notes(self, case: Case, mesh: Mesh) -> Iterator[str]:
        """Layers that elements do not resolve or bodies do not contain."""
        unit = case.units.length
        for name, layer in self.layers.items():
            height, changes = layer.height_of_elements(mesh.bodies[name]), np.diff(layer.depths)
            if len(changes) and height > FINEST * changes.min():
                yield (
                    f"loads.{self.channel}: elements below the surfaces of {name} are up to "
                    f"{height:.3g} {unit} high, next to depths that differ by {changes.min():.3g} "
                    f"{unit}: there the mesh does not follow the strain, which is linear in an "
                    "element, and the layer stretches and bends the body by a wrong amount"
                )
            deepest = layer.largest_depth(mesh.bodies[name])
            if layer.depths[-1] > (1 + FLAT) * deepest:
                yield (
                    f"loads.{self.channel}: the depths go down to {layer.depths[-1]:.4g} {unit}, "
                    f"but nothing of {name} is deeper below the surfaces than {deepest:.4g} "
                    f"{unit}: check their unit"
                )


def eigenstrain(case: Case, name: str, load: EigenstrainLoad, mesh: Mesh) -> Sequence[SpreadLoad]:
    """That of a load of a case: from its file, or below the surfaces that bodies have of it."""
    if load.file is not None:
        values = values_at_points(case, name, load, mesh.dimension)
        return (StrainAtPoints(name, values, load.bodies or ()),)
    assert load.surfaces is not None and load.depths is not None and load.values is not None
    layers = {}
    for each, body in mesh.bodies.items():
        own = [surface for surface in load.surfaces if surface in body.boundaries]
        if own:
            surfaces = tuple(boundary_surface(body, surface) for surface in own)
            layers[each] = Layer(surfaces, np.array(load.depths), np.array(load.values))
    return (StrainBelow(name, layers),)


def heatings(loads: Sequence[SpreadLoad], body: str) -> list[Heating]:
    """Those of some loads that change the temperature of a body."""
    return [load for load in loads if isinstance(load, Heating) and load.strains(body)]


def surface_temperatures(
    case: Case, loads: Sequence[SpreadLoad], bodies: Sequence[str], points: Array, history: History
) -> Array:
    """(T, N) mean temperature of bodies at places (N, d) of both in the states of a history."""
    found = np.zeros((len(history.times), len(points)))
    for body in bodies:
        start = case.bodies[body].reference_temperature or 0.0
        found += start
        for load in heatings(loads, body):
            parts = load.amplitudes(history.values[:, history.channels.index(load.channel)])
            found += np.outer(parts, load.temperature_change(body, start, points))
    return found / len(bodies)


def require_temperatures(case: Case, loads: Sequence[SpreadLoad], history: History) -> None:
    """Check that no temperature of a history is below absolute zero.

    Raises:
        CaseError: names the first load that would be.
    """
    for load in loads:
        if not isinstance(load, Temperature):
            continue
        parts = history.values[:, history.channels.index(load.channel)]
        for name in load.bodies or case.bodies:
            start = case.bodies[name].reference_temperature or 0.0
            coldest = float((start + np.outer(parts, load.values.values - start)).min())
            if coldest < ABSOLUTE_ZERO:
                raise CaseError(
                    f"{case.source}: loads.{load.channel}.history: expected temperatures >= "
                    f"{ABSOLUTE_ZERO:g} (absolute zero, in degrees Celsius), found {coldest:g} in "
                    f"the body {name!r}, whose reference temperature is {start:g}"
                )
    for name in case.bodies:
        _require_sum(case, heatings(loads, name), history, name)


def _require_sum(case: Case, heats: Sequence[Heating], history: History, body: str) -> None:
    """Check loads that change the temperature of a body together, at the points that they have."""
    names = list(dict.fromkeys(load.channel for load in heats))
    if len(names) < 2:
        return
    start = case.bodies[body].reference_temperature or 0.0
    nodes = [load.changes[body].points for load in heats if isinstance(load, TemperatureShape)]
    given = [load.values.points for load in heats if isinstance(load, Temperature)]
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
