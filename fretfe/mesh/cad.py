# SPDX-License-Identifier: LGPL-3.0-or-later
"""STEP and BREP files: parts chosen by point, label and colour, in a Gmsh model."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from fretfe._typing import Array
from fretfe.case import BoundarySelector, Geometry, Selector
from fretfe.errors import CaseError, MeshError
from fretfe.files import require_file
from fretfe.mesh.gmsh import gmsh_model, link_to

# A point may be this far from what it chooses, as a fraction of the size of the geometry.
REACH = 0.01
# Distances that differ by less, on the same scale, are equal.
TIE = 1e-6
# Colours are fractions in a file and whole numbers from 0 to 255 here: they may be rounded.
COLOUR_ROUNDING = 1
KINDS = {1: "curve", 2: "face", 3: "volume"}
# Labels of units of length, and what OpenCASCADE calls the units that it can convert STEP to.
UNITS = {
    "um": "UM",
    "µm": "UM",  # micro sign
    "μm": "UM",  # Greek letter
    "mm": "MM",
    "cm": "CM",
    "m": "M",
    "km": "KM",
    "in": "INCH",
    "inch": "INCH",
    "ft": "FT",
}
# Heights above z = 0 below this fraction of the size of the geometry are round-off of CAD programs;
# OpenCASCADE adds its tolerance of 1e-7, in any unit, to every box.
PLANE_TOLERANCE = 1e-7
BOX_TOLERANCE = 2e-7
HEADS = {
    ".brep": (re.compile(rb"CASCADE Topology V\d"), "'CASCADE Topology' in its first lines"),
    ".step": (re.compile(rb"\AISO-10303-21\s*;"), "ISO-10303-21; at its start"),
}
# How whole files end: the root of the shapes after the end of the last list; the closing keyword.
TAILS = {
    ".brep": re.compile(rb"\*\s+[+-]\d+ \d+\s*\Z"),
    ".step": re.compile(rb"END-ISO-10303-21\s*;\s*\Z"),
}


@dataclass(frozen=True)
class Shape:
    """A curve (dim 1), face (2) or volume (3) of the model; label and colour may be empty.

    Its centre has as many coordinates as the space of the model.
    """

    dim: int
    tag: int
    label: str
    colour: str
    centre: tuple[float, ...]

    @classmethod
    def of(cls, gmsh: ModuleType, dim: int, tag: int) -> Shape:
        """An entity of a Gmsh model, as Gmsh knows it."""
        *rgb, alpha = gmsh.model.getColor(dim, tag)
        # without a colour of its own an entity has a transparent default
        colour = "#" + "".join(f"{value:02x}" for value in rgb) if alpha else ""
        return cls(dim, tag, gmsh.model.getEntityName(dim, tag), colour, _middle(gmsh, dim, tag))


def dimension_of(gmsh: ModuleType) -> int:
    """Number of coordinates of the bodies of the model: 3 where there are volumes, else 2."""
    return 3 if gmsh.model.getEntities(3) else 2


def _middle(gmsh: ModuleType, dim: int, tag: int) -> tuple[float, ...]:
    """A point on a curve half-way in its parameter; the middle of the box around anything else."""
    if dim == 1:
        (low,), (high,) = gmsh.model.getParametrizationBounds(1, tag)
        place = gmsh.model.getValue(1, tag, [(low + high) / 2])
    else:
        place = np.reshape(gmsh.model.getBoundingBox(dim, tag), (2, 3)).mean(axis=0)
    return tuple(float(value) for value in place[: dimension_of(gmsh)])


def shape_text(shape: Shape) -> str:
    """A shape in words, so that a user finds it."""
    # rounded as a coordinate is, so that zero is not shown as 1e-16
    place = ", ".join(f"{round(value, 9) + 0.0:.6g}" for value in shape.centre)
    text = f"{KINDS[shape.dim]} {shape.tag} around ({place})"
    text += f", label '{shape.label}'" if shape.label else ""
    return text + (f", colour {shape.colour}" if shape.colour else "")


class Shapes:
    """All curves, faces or volumes of the model."""

    def __init__(self, gmsh: ModuleType, path: Path, dim: int) -> None:
        self._gmsh = gmsh
        self.path = path
        self.shapes = [Shape.of(gmsh, dim, int(tag)) for _, tag in gmsh.model.getEntities(dim)]
        self._kind = KINDS[dim]
        box = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
        self._dimension = dimension_of(gmsh)
        self._size = float(np.linalg.norm((box[1] - box[0])[: self._dimension]))

    def select(self, key: str, selector: Selector, allowed: Sequence[Shape]) -> list[Shape]:
        """The shapes among those allowed that a selector chooses, at least one.

        Args:
            key: of the selector in the case file, for messages.
            selector: what to choose.
            allowed: shapes to choose from.

        Raises:
            MeshError: it chooses none, or a point cannot choose between several.
        """
        if selector.all_points:
            chosen = [self._nearest(key, point, allowed) for point in selector.all_points]
            return list(dict.fromkeys(chosen))
        if selector.label is not None:
            chosen = [each for each in allowed if _has_label(each, selector.label)]
            what, known = f"label '{selector.label}'", [each.label for each in allowed]
        else:
            assert selector.color is not None
            chosen = [each for each in allowed if _has_colour(each, selector.color)]
            what, known = f"colour {selector.color}", [each.colour for each in allowed]
        if not chosen:
            there = ", ".join(sorted({each for each in known if each})) or "none"
            raise MeshError(
                f"{self.path}: {key}: no {self._kind} has the {what}; {what.split()[0]}s of "
                f"{self._kind}s in the file: {there}"
            )
        return chosen

    def _nearest(self, key: str, point: tuple[float, ...], allowed: Sequence[Shape]) -> Shape:
        place = f"the point ({', '.join(f'{value:.6g}' for value in point)})"
        if len(point) != self._dimension:
            raise MeshError(
                f"{self.path}: {key}: expected {self._dimension} coordinates, as the bodies are "
                f"{'plane' if self._dimension == 2 else 'solid'}, found {place}"
            )
        at = np.array([*point, 0.0][:3])
        distances = np.array([self._distance(shape, at) for shape in allowed])
        nearest = allowed[int(distances.argmin())]
        if distances.min() > REACH * self._size:
            raise MeshError(
                f"{self.path}: {key}: {place} is {distances.min():.3g} away from the nearest "
                f"{self._kind} ({shape_text(nearest)}); expected at most {REACH * self._size:.3g}, "
                f"{REACH:.0%} of the size of the geometry"
            )
        equal = [
            shape
            for shape, distance in zip(allowed, distances, strict=True)
            if distance < distances.min() + TIE * self._size
        ]
        if len(equal) > 1:
            named = nearest.dim == self._dimension
            advice = "" if named else ", or say which with body = NAME"
            raise MeshError(
                f"{self.path}: {key}: {place} does not tell between "
                f"{' and '.join(map(shape_text, equal))}; take one in the middle of the "
                f"{self._kind} and away from others{advice}"
            )
        return nearest

    def _distance(self, shape: Shape, point: Array) -> float:
        """Distance of a point (3,) from a shape; 0 inside a volume or a plane face."""
        if shape.dim == 1:
            return _curve_distance(self._gmsh, shape.tag, point)
        if shape.dim == 2:
            return face_distance(self._gmsh, shape.tag, point)
        if self._gmsh.model.isInside(3, shape.tag, point):
            return 0.0
        border = self._gmsh.model.getAdjacencies(3, shape.tag)[1]
        return min(face_distance(self._gmsh, int(face), point) for face in border)


def face_distance(gmsh: ModuleType, face: int, point: Array) -> float:
    """From the foot of the perpendicular, if it is in the face, or from the border."""
    foot = gmsh.model.getClosestPoint(2, face, point)[0]
    if gmsh.model.isInside(2, face, foot):
        return float(np.linalg.norm(foot - point))
    border = gmsh.model.getAdjacencies(2, face)[1]
    return min(_curve_distance(gmsh, int(curve), point) for curve in border)


def _curve_distance(gmsh: ModuleType, curve: int, point: Array) -> float:
    """From the foot of the perpendicular or from an end, whichever is nearer."""
    low, high = np.ravel(gmsh.model.getParametrizationBounds(1, curve))
    ends = np.reshape(gmsh.model.getValue(1, curve, [low, (low + high) / 2, high]), (-1, 3))
    # At the pole of a revolved face there is a curve of no length, on which nothing is projected.
    if np.ptp(ends, axis=0).max() < TIE * TIE * (high - low):
        return float(np.linalg.norm(ends[0] - point))
    foot = gmsh.model.getClosestPoint(1, curve, point)[0]
    return float(np.linalg.norm(np.vstack([ends, foot]) - point, axis=1).min())


def _has_label(shape: Shape, label: str) -> bool:
    """True if a label is the whole path of a part in the file, or the last name in it."""
    return label in (shape.label, shape.label.rpartition("/")[2])


def _has_colour(shape: Shape, colour: str) -> bool:
    if not shape.colour:
        return False
    pair = (bytes.fromhex(each.removeprefix("#")) for each in (shape.colour, colour))
    return all(abs(a - b) <= COLOUR_ROUNDING for a, b in zip(*pair, strict=True))


@contextlib.contextmanager
def cad_model(path: Path, geometry: Geometry, length: str) -> Iterator[ModuleType]:
    """The shapes of a file as a Gmsh model whose bodies and boundaries are named groups.

    Where there are volumes, they are the bodies, and faces the boundaries; else plane faces and
    curves.

    Args:
        path: STEP or BREP file.
        geometry: table of the case, with the selectors.
        length: label of the unit of length. The lengths of a STEP file, which has a unit, are
            converted to it; BREP files have none.

    Raises:
        CaseError: the unit is none that OpenCASCADE knows.
        MeshError: the file cannot be read, has neither volumes nor plane faces, or the selectors
            do not fit it.
    """
    kind = ".brep" if path.suffix.lower() == ".brep" else ".step"
    _require_whole_file(path, kind)
    unit = "" if kind == ".brep" else _step_unit(path, length)
    with gmsh_model(path) as gmsh:
        _import(gmsh, path, unit)
        dim = dimension_of(gmsh)
        if dim == 2:
            _require_plane_faces(gmsh, path)
        bodies = _bodies(Shapes(gmsh, path, dim), geometry.bodies)
        owners = _owners(gmsh, path, bodies)
        boundaries = _boundaries(Shapes(gmsh, path, dim - 1), geometry.boundaries, owners)
        # groups that the file brings along would give names of their own
        gmsh.model.removePhysicalGroups()
        _name_groups(gmsh, dim, bodies)
        _name_groups(gmsh, dim - 1, boundaries)
        yield gmsh


def _require_whole_file(path: Path, kind: str) -> None:
    """OpenCASCADE reads a BREP file that was cut off for ever: look before it does."""
    require_file(path, "a CAD file", MeshError)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise MeshError(f"{path}: cannot read the CAD file: {error.strerror}") from error
    head, text = HEADS[kind]
    start = content[:400].lstrip()
    if not head.search(start):
        raise MeshError(
            f"{path}: expected a {kind.strip('.').upper()} file with {text}, found {start[:20]!r}"
        )
    if not TAILS[kind].search(content[-400:]):
        raise MeshError(f"{path}: the file is not complete, it ends with {content[-20:]!r}")


def _step_unit(path: Path, length: str) -> str:
    if length not in UNITS:
        raise CaseError(
            f"units.length: expected one of {', '.join(UNITS)}, to which the lengths in {path} are "
            f"converted, found {length!r}"
        )
    return UNITS[length]


def _import(gmsh: ModuleType, path: Path, unit: str) -> None:
    """Import what the file has, bodies apart from each other as they are in it."""
    wanted: dict[str, str | float] = {
        "OCCTargetUnit": unit,
        "OCCImportLabels": 1,
        "OCCSewFaces": 0,
        "OCCMakeSolids": 0,
    }
    before: dict[str, str | float] = {}
    try:
        for name, value in wanted.items():
            before[name] = _set_option(gmsh, name, value)
        with link_to(path) as link:
            gmsh.model.occ.importShapes(str(link))
    finally:
        for name, value in before.items():
            _set_option(gmsh, name, value)
    gmsh.model.occ.synchronize()


def _set_option(gmsh: ModuleType, name: str, value: str | float) -> str | float:
    """Set an option and return what it was."""
    kind = "String" if isinstance(value, str) else "Number"
    option = f"Geometry.{name}"
    before: str | float = getattr(gmsh.option, f"get{kind}")(option)
    getattr(gmsh.option, f"set{kind}")(option, value)
    return before


def _require_plane_faces(gmsh: ModuleType, path: Path) -> None:
    advice = "give volumes, or the plane section of the bodies as faces in the plane z = 0"
    faces = gmsh.model.getEntities(2)
    if not faces:
        raise MeshError(
            f"{path}: expected volumes or faces, found {len(gmsh.model.getEntities(1))} curves; "
            f"{advice}"
        )
    for _, tag in faces:
        low, high = _box(gmsh, 2, tag)
        size = max(b - a for a, b in zip(low, high, strict=True))
        if max(abs(low[2]), abs(high[2])) > PLANE_TOLERANCE * size + BOX_TOLERANCE:
            raise MeshError(
                f"{path}: expected faces in the plane z = 0, but face {tag} reaches from "
                f"z = {low[2]:.6g} to {high[2]:.6g}; {advice}"
            )


def _box(gmsh: ModuleType, dim: int, tag: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    box = gmsh.model.getBoundingBox(dim, tag)
    return box[:3], box[3:]


def _bodies(parts: Shapes, selectors: Mapping[str, Selector]) -> dict[str, list[Shape]]:
    """The faces or volumes of each body: every one in one body."""
    bodies = {
        name: parts.select(f"geometry.bodies.{name}", selector, parts.shapes)
        for name, selector in selectors.items()
    }
    _refuse_twice(parts.path, "bodies", bodies)
    named = [part for chosen in bodies.values() for part in chosen]
    if loose := [part for part in parts.shapes if part not in named]:
        raise MeshError(
            f"{parts.path}: expected every {KINDS[loose[0].dim]} in one of [geometry.bodies], but "
            f"in none is {'; '.join(map(shape_text, loose))}"
        )
    return bodies


def _refuse_twice(path: Path, table: str, chosen: Mapping[str, list[Shape]]) -> None:
    """Refuse a shape with two names."""
    names: dict[int, str] = {}
    for name, shapes in chosen.items():
        for shape in shapes:
            if shape.tag in names:
                raise MeshError(
                    f"{path}: geometry.{table}.{name} and geometry.{table}.{names[shape.tag]} are "
                    f"both {shape_text(shape)}"
                )
            names[shape.tag] = name


def _owners(gmsh: ModuleType, path: Path, bodies: Mapping[str, list[Shape]]) -> dict[int, str]:
    """The body of each curve around plane bodies, or of each face around solid ones.

    Raises:
        MeshError: two bodies have one in common: as one piece they could not slide.
    """
    owners: dict[int, str] = {}
    for name, parts in bodies.items():
        for part in parts:
            for side in map(int, gmsh.model.getAdjacencies(part.dim, part.tag)[1]):
                if owners.setdefault(side, name) != name:
                    raise MeshError(
                        f"{path}: bodies '{owners[side]}' and '{name}' have a "
                        f"{KINDS[part.dim - 1]} in common "
                        f"({shape_text(Shape.of(gmsh, part.dim - 1, side))}); keep them separate: "
                        "export them as parts of their own, without fusing or fragmenting the "
                        f"{KINDS[part.dim]}s"
                    )
    return owners


def _boundaries(
    sides: Shapes, selectors: Mapping[str, BoundarySelector], owners: Mapping[int, str]
) -> dict[str, list[Shape]]:
    boundaries = {}
    for name, selector in selectors.items():
        key = f"geometry.boundaries.{name}"
        if selector.body is not None and selector.body not in owners.values():
            raise MeshError(
                f"{sides.path}: {key}.body: expected one of "
                f"{', '.join(dict.fromkeys(owners.values()))}, found {selector.body!r}"
            )
        allowed = [
            shape
            for shape in sides.shapes
            if selector.body is None or owners.get(shape.tag) == selector.body
        ]
        boundaries[name] = sides.select(key, selector, allowed)
    _refuse_twice(sides.path, "boundaries", boundaries)
    return boundaries


def _name_groups(gmsh: ModuleType, dim: int, groups: Mapping[str, list[Shape]]) -> None:
    for name, shapes in groups.items():
        gmsh.model.addPhysicalGroup(dim, [shape.tag for shape in shapes], name=name)
