# SPDX-License-Identifier: LGPL-3.0-or-later
"""STEP and BREP files: their parts by the names of the case, in a Gmsh model to be meshed."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import ModuleType

from fretfe.case import BoundarySelector, Geometry, Selector
from fretfe.errors import CaseError, MeshError
from fretfe.files import require_file
from fretfe.geometry.gmsh_model import gmsh_model
from fretfe.geometry.shapes import KINDS, Shape, Shapes, dimension_of, shape_text

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
PLANE_TOLERANCE, BOX_TOLERANCE = 1e-7, 2e-7
HEADS = {
    ".brep": (re.compile(rb"CASCADE Topology V\d"), "'CASCADE Topology' in its first lines"),
    ".step": (re.compile(rb"\AISO-10303-21\s*;"), "ISO-10303-21; at its start"),
}
# How whole files end: the root of the shapes after the end of the last list; the closing keyword.
TAILS = {
    ".brep": re.compile(rb"\*\s+[+-]\d+ \d+\s*\Z"),
    ".step": re.compile(rb"END-ISO-10303-21\s*;\s*\Z"),
}


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
        gmsh.model.occ.importShapes(str(path))
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
