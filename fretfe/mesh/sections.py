# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane sections of solid CAD bodies, for bodies that sweep them along one direction.

Such bodies have two plane ends; all other faces are parallel to the direction, which the normals of
the contact faces tell, but for what is cut off at the ends. Their mesh is that of the section,
extruded over the length of the contact faces and laid back into space.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np

from fretfe._typing import Array
from fretfe.case import Geometry, Solid
from fretfe.errors import MeshError
from fretfe.mesh.cad import Shape, cad_model, face_distance, shape_text
from fretfe.mesh.contained import Opened
from fretfe.mesh.extrusion import BACK, FRONT, extrude, layer_faces
from fretfe.mesh.gmsh import tags_of_groups
from fretfe.mesh.mesh import Mesh

# Angles up to which normals are alike, and distances over the size of the bodies: STEP files are
# written to 1e-7 of a unit.
SAME_WAY = 1e-5
# Places across a face at which its normal is taken, and along its edges, as parts of parameters.
ACROSS = np.linspace(0.04, 0.96, 7)
ALONG = np.linspace(0.0, 1.0, 9)
# Angle up to which an extrusion may lean.
MOST_SKEW = math.pi / 3
# Layers over the length, and the thickness of those at the ends over it.
LAYERS = 5
AT_ENDS = 1 / 20


@dataclass(frozen=True)
class Sweep:
    """A straight sweep of plane sections in space.

    Attributes:
        origin: (3,) place in space of the origin of the plane.
        axes: (3, 3) rows are the unit vectors of x and y of the plane, and its normal.
        solid: the extrusion along the normal; a skew leans along x.
        ends: names in the case of boundaries at ends, by those of extrusions.
        cut: bodies of whose ends something is cut off.
    """

    origin: Array
    axes: Array
    solid: Solid
    ends: Mapping[str, str]
    cut: Sequence[str] = ()

    @property
    def lean(self) -> float:
        """Way along x of the plane for each unit along its normal."""
        return math.tan(math.radians(self.solid.skew))

    @property
    def direction(self) -> Array:
        """(3,) way of the sweep in space over that along the normal of the plane."""
        return np.array([self.lean, 0.0, 1.0]) @ self.axes

    def in_plane(self, points: Array) -> Array:
        """(n, 3) places at z = 0 that sweep to points (n, 3) in space."""
        local = (points - self.origin) @ self.axes.T
        return np.asarray(local - local[:, 2:] * [self.lean, 0.0, 1.0])

    def swept(self, mesh: Mesh) -> Mesh:
        """The bodies in space of a mesh of their sections."""
        found = extrude(mesh, self.solid)
        bodies = {}
        for name, body in found.bodies.items():
            made = {f"{name}_{FRONT}", f"{name}_{BACK}"}
            boundaries = {
                self.ends.get(each, each): facets
                for each, facets in body.boundaries.items()
                if each not in made or each in self.ends
            }
            points = self.origin + body.points @ self.axes
            bodies[name] = replace(body, points=points, boundaries=boundaries)
        return replace(found, bodies=bodies, notes=(*found.notes, self._text(mesh)))

    def _text(self, mesh: Mesh) -> str:
        """The sweep in words."""
        names, way = tuple(mesh.bodies), ", ".join(f"{x + 0.0:.4g}" for x in self.direction)
        spans = {name: self.solid.span(name) for name in names}
        lengths = ", ".join(
            f"{name} from {low:g} to {high:g}" for name, (low, high) in spans.items()
        )
        layers = len(layer_faces(self.solid, (True, True), names)) - 1
        cut = f"; ends of {', '.join(self.cut)} are taken as plane ones" if self.cut else ""
        return (
            f"the bodies sweep plane sections along ({way}), {lengths}, in {layers} layers; two "
            f"fronts are expected along each contact{cut}"
        )


def sweep_arrays(
    path: Path, geometry: Geometry, length: str, surfaces: Collection[str], opened: Opened
) -> Mapping[str, Array]:
    """The sweep of the bodies of a CAD file as arrays, of which `sweep_of_arrays` makes one.

    Args:
        path: of the file.
        geometry: table of the case.
        length: label of the unit of length.
        surfaces: names of the contact surfaces.
        opened: called when the file has been read.

    Raises:
        MeshError: the bodies are no sweep, with the face that is the reason; or as for `cad_model`.
    """
    with cad_model(path, geometry, length) as gmsh:
        opened()
        return _Solids(gmsh, surfaces).arrays()


def sweep_of_arrays(arrays: Mapping[str, Array]) -> Sweep:
    """The sweep that `sweep_arrays` has found."""
    spans = dict(zip(arrays["bodies"].tolist(), arrays["spans"].tolist(), strict=True))
    length = float(arrays["spans"].max())
    shorter = {name: span for name, span in spans.items() if span != [0.0, length]}
    shared = min(end for _, end in spans.values()) - max(start for start, _ in spans.values())
    solid = Solid(
        length=length,
        skew=float(arrays["skew"]),
        layers=math.ceil(LAYERS * length / shared - SAME_WAY),
        end_size=AT_ENDS * shared,
        spans={name: (start, end) for name, (start, end) in shorter.items()},
    )
    ends = {str(made): str(name) for made, name in arrays["ends"].reshape(-1, 2)}
    return Sweep(arrays["origin"], arrays["axes"], solid, ends, arrays["cut"].tolist())


def _merged(values: Array, close: float) -> Array:
    """Values of which those that are closer to each other than round-off are equal."""
    known, places = np.unique(values, return_inverse=True)
    first = np.diff(known, prepend=-np.inf) > close
    return np.asarray(known[first][np.cumsum(first) - 1][places].reshape(values.shape))


class _Solids:
    """Volumes of a Gmsh model whose bodies and boundaries are named groups.

    Args:
        gmsh: the library.
        surfaces: names of the contact surfaces.
    """

    def __init__(self, gmsh: ModuleType, surfaces: Collection[str]) -> None:
        self._gmsh = gmsh
        if gmsh.model.getDimension() < 3:
            raise MeshError("the bodies are plane")
        self._named = tags_of_groups(gmsh, 2)
        self._contact = [x for name in surfaces for x in self._named.get(name, [])]
        self._cut: list[str] = []
        self._bodies = tags_of_groups(gmsh, 3)
        self._normals = {face: self._normals_of(face) for _, face in gmsh.model.getEntities(2)}
        box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
        self._close = SAME_WAY * float(np.linalg.norm(box[1] - box[0]))
        self._direction = self._along(self._contact)
        self._normal = self._direction

    def arrays(self) -> Mapping[str, Array]:
        """The sweep as arrays: origin, axes, skew, bodies with spans, and names of ends."""
        found = {name: self._ends(name, volumes) for name, volumes in self._bodies.items()}
        ends = {name: own for name, (own, _) in found.items()}
        heights = np.array([own for _, own in found.values()])
        start = float(heights.min())
        axes = self._axes()
        skew = math.atan2(float(self._direction @ axes[0]), float(self._direction @ axes[2]))
        if skew > MOST_SKEW:
            raise MeshError(f"the bodies lean from their ends by {math.degrees(skew):.3g} degrees")
        return {
            "origin": start * axes[2],
            "axes": axes,
            "skew": np.array(math.degrees(skew)),
            "bodies": np.array(list(found)),
            "spans": _merged(heights - start, self._close),
            "ends": np.array(list(self._names_of_ends(ends)), dtype=str),
            "cut": np.array(self._cut),
        }

    def _normals_of(self, face: int) -> Array:
        """(n, 3) unit normals across a face."""
        low, high = self._gmsh.model.getParametrizationBounds(2, face)
        places = [low + (high - low) * np.array(each) for each in product(ACROSS, ACROSS)]
        return np.reshape(self._gmsh.model.getNormal(face, np.ravel(places)), (-1, 3))

    def _along(self, faces: Sequence[int]) -> Array:
        """(3,) unit vector to which all contact faces are parallel, mostly along an axis."""
        together = np.vstack([np.zeros((3, 3)), *(self._normals[face] for face in faces)])
        values, axes = np.linalg.svd(together, full_matrices=False)[1:]
        if values[1] <= SAME_WAY * values[0]:
            raise MeshError("the contact faces are parallel to each other, and tell no direction")
        direction = axes[2] * np.sign(axes[2][np.argmax(np.abs(axes[2]))])
        tilts = [float(np.abs(self._normals[face] @ direction).max()) for face in faces]
        if max(tilts) > SAME_WAY:
            worst = self._text(faces[int(np.argmax(tilts))])
            raise MeshError(f"{worst} is not parallel to one direction with its neighbours")
        return np.asarray(direction)

    def _text(self, face: int) -> str:
        (volume,) = self._gmsh.model.getAdjacencies(2, face)[0]
        body = next(name for name, tags in self._bodies.items() if volume in tags)
        return f"{shape_text(Shape.of(self._gmsh, 2, face))} of body {body!r}"

    def _ends(
        self, name: str, volumes: Sequence[int]
    ) -> tuple[tuple[list[int], list[int]], tuple[float, float]]:
        """Faces at the lower and at the upper end of a body, and the heights between which it is.

        That is as far as its contact faces go if something is cut off them at the ends.
        """
        faces = [int(x) for tag in volumes for x in self._gmsh.model.getAdjacencies(3, tag)[1]]
        across = [x for x in faces if np.abs(self._normals[x] @ self._direction).max() > SAME_WAY]
        flat = [x for x in across if np.ptp(self._normals[x], axis=0).max() < SAME_WAY]
        if self._normal is self._direction and flat:
            normals = np.array([self._normals[x][0] for x in flat])
            areas = [self._gmsh.model.occ.getMass(2, x) for x in flat]
            first = normals[np.argmax((np.abs(normals @ normals.T) > 1 - SAME_WAY) @ areas)]
            self._normal = first * np.sign(first @ self._direction)
        heights = {x: self._heights(x) for x in faces}
        together = np.concatenate([*heights.values()])
        start, end = float(together.min()), float(together.max())
        low = [x for x in flat if heights[x].max() < start + self._close]
        high = [x for x in flat if heights[x].min() > end - self._close]
        beside = [x for x in across if x not in low + high]
        near = (end - start) / (2 * LAYERS)
        for x in beside:
            if heights[x].max() > start + near and heights[x].min() < end - near:
                text = f"{self._text(x)} is no plane end, and not parallel to the contact faces"
                raise MeshError(text)
        own = [heights[x] for x in self._contact if x in faces]
        if beside and own:
            self._cut.append(name)
            first, last = max(float(x.min()) for x in own), min(float(x.max()) for x in own)
            start = first if first < start + near else start
            end = last if last > end - near else end
        return (low, high), (start, end)

    def _heights(self, face: int) -> Array:
        """(n,) heights along the edges of a face, over the normal of the ends."""
        model, points = self._gmsh.model, []
        for _, curve in model.getBoundary([(2, face)], oriented=False):
            low, high = model.getParametrizationBounds(1, curve)
            points.append(model.getValue(1, curve, low + (high - low) * ALONG))
        return np.concatenate(points).reshape(-1, 3) @ self._normal

    def _axes(self) -> Array:
        """(3, 3) unit vectors of the plane, those of space where the sweep is along z."""
        across = self._direction - (self._direction @ self._normal) * self._normal
        if np.linalg.norm(across) < SAME_WAY:
            nearest = np.eye(3)[np.argmin(np.abs(self._normal))]
            across = nearest - (nearest @ self._normal) * self._normal
        first = across / np.linalg.norm(across)
        return np.array([first, np.cross(self._normal, first), self._normal])

    def _names_of_ends(
        self, ends: Mapping[str, tuple[Sequence[int], Sequence[int]]]
    ) -> Iterator[tuple[str, str]]:
        """Names of ends by extrusion and in the case; others are sides from end to end."""
        made = {
            f"{body}_{suffix}": set(end)
            for body, own in ends.items()
            for suffix, end in zip((BACK, FRONT), own, strict=True)
        }
        across = set().union(*made.values())
        for boundary, faces in self._named.items():
            whole = [name for name, end in made.items() if end == set(faces)]
            yield from ((name, boundary) for name in whole)
            if not whole and (boundary in made or across & set(faces)):
                raise MeshError(f"boundary {boundary!r} is no whole end: {self._text(faces[0])}")


@contextlib.contextmanager
def section_model(
    path: Path, geometry: Geometry, length: str, sweep: Sweep
) -> Iterator[ModuleType]:
    """The sections of the bodies of a CAD file in the plane z = 0, with the names of their sides.

    Arguments and errors are those of `sweep_arrays`.
    """
    with cad_model(path, geometry, length) as gmsh:
        bodies, sides = tags_of_groups(gmsh, 3), tags_of_groups(gmsh, 2)
        volumes = gmsh.model.getEntities(3)
        sections, curves = dict[str, list[int]](), dict[str, list[int]]()
        for name, tags in bodies.items():
            height = sum(sweep.solid.span(name)) / 2
            sections[name] = [cut for tag in tags for cut in _cut(gmsh, sweep, tag, height)]
            own = {int(x) for tag in tags for x in gmsh.model.getAdjacencies(3, tag)[1]}
            for side, faces in sides.items():
                found = _on_faces(gmsh, sweep, sections[name], height, own & set(faces))
                curves.setdefault(side, []).extend(found)
        gmsh.model.occ.remove(volumes, recursive=True)
        gmsh.model.occ.synchronize()
        gmsh.model.removePhysicalGroups()
        for dim, groups in ((2, sections), (1, curves)):
            for name, tags in groups.items():
                if tags:
                    gmsh.model.addPhysicalGroup(dim, tags, name=name)
        yield gmsh


def _cut(gmsh: ModuleType, sweep: Sweep, volume: int, height: float) -> list[int]:
    """Faces in the plane z = 0 that a volume sweeps, cut out at a height above it."""
    from scipy.spatial.transform import Rotation

    occ = gmsh.model.occ
    turn = Rotation.from_matrix(sweep.axes.T).as_rotvec()
    angle, to = float(np.linalg.norm(turn)), sweep.origin + height * sweep.direction
    axis = turn / angle if angle else np.array([0.0, 0.0, 1.0])
    low, high = np.reshape(gmsh.model.getBoundingBox(3, volume), (2, 3))
    corners = np.array(list(product(*zip(low, high, strict=True))))
    plane = ((corners - to) @ sweep.axes.T)[:, :2]
    first, size = plane.min(axis=0), np.ptp(plane, axis=0)
    first, size = first - size / 2, 2 * size
    rectangle = occ.addRectangle(*first, 0.0, *size)
    occ.rotate([(2, rectangle)], 0, 0, 0, *axis, angle)
    occ.translate([(2, rectangle)], *to)
    cut, _ = occ.intersect([(3, volume)], [(2, rectangle)], removeObject=False)
    occ.translate(cut, *-to)
    occ.rotate(cut, 0, 0, 0, *axis, -angle)
    occ.synchronize()
    return [tag for _, tag in cut]


def _on_faces(
    gmsh: ModuleType, sweep: Sweep, sections: Sequence[int], height: float, faces: Collection[int]
) -> list[int]:
    """Curves around sections that are cuts through faces at a height."""
    box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
    close = SAME_WAY * float(np.linalg.norm(box[1] - box[0]))
    around = gmsh.model.getBoundary([(2, tag) for tag in sections], oriented=False)
    found = []
    for _, curve in around:
        middle = np.array(Shape.of(gmsh, 1, curve).centre)
        point = sweep.origin + middle @ sweep.axes + height * sweep.direction
        if any(face_distance(gmsh, face, point) < close for face in faces):
            found.append(int(curve))
    return found
