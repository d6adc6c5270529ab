# SPDX-License-Identifier: LGPL-3.0-or-later
"""XDMF meshes with numbers for cells and facets, as DOLFINx and meshio write them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Selector
from fretfe.errors import MeshError
from fretfe.files import require_file
from fretfe.mesh.elements import (
    CORNERS,
    SHAPES,
    TYPES,
    complete,
    in_gmsh_order,
    stacked,
)
from fretfe.mesh.gmsh import ElementBlock, RawMesh

# Gmsh type and number of nodes, by the name of a topology and by its number among mixed cells.
SHORT = {"triangle": "tri", "quadrilateral": "quad", "tetrahedron": "tet", "hexahedron": "hex"}
NAMES = {"polyvertex": (15, 1), "polyline": (1, 2), "edge_3": (8, 3)} | {
    f"{name}_{count}" if count > CORNERS[shape] else shape: (TYPES[dimension, count], count)
    for (dimension, count), shape in SHAPES.items()
    if dimension > 1
    for name in (shape, SHORT[shape])
}
NUMBERS = {
    1: "polyvertex",
    2: "polyline",
    4: "triangle",
    5: "quadrilateral",
    6: "tetrahedron",
    9: "hexahedron",
    34: "edge_3",
    35: "quadrilateral_9",
    36: "triangle_6",
    37: "quadrilateral_8",
    38: "tetrahedron_10",
    48: "hexahedron_20",
    50: "hexahedron_27",
}
# The number of nodes stands before the nodes of these.
COUNTED = (1, 2)
DIMENSIONS = {15: 0} | {kind: dimension for (dimension, _), kind in TYPES.items()}
# Where a cell has several numbers, as in what meshio makes of a Gmsh file, this is its group.
PHYSICAL = "gmsh:physical"


def read_points(path: Path, geometry: ET.Element) -> Array:
    """Points (n, 3) of a grid; plane ones have z = 0."""
    points = data_item(path, geometry).astype(float)
    if points.ndim != 2 or points.shape[1] not in (2, 3) or not np.isfinite(points).all():
        raise MeshError(f"{path}: expected points with 2 or 3 coordinates, found {points.shape}")
    return np.pad(points, ((0, 0), (0, 3 - points.shape[1])))


def topology_name(topology: ET.Element) -> str:
    """The name of the cells of a grid, in small letters."""
    return (topology.get("TopologyType") or topology.get("Type") or "").lower()


def cell_blocks(path: Path, topology: ET.Element) -> list[ElementBlock]:
    """The cells of a grid in their order; blocks of the same type may follow one another.

    Raises:
        MeshError: cells that are not known.
    """
    name = topology_name(topology)
    data = data_item(path, topology).astype(np.int64)
    blocks = _mixed(path, data.ravel()) if name == "mixed" else [_uniform(path, topology, data)]
    return [ElementBlock(b.gmsh_type, in_gmsh_order(b.gmsh_type, b.nodes)) for b in blocks]


def _uniform(path: Path, topology: ET.Element, data: Indices) -> ElementBlock:
    """Cells of one type."""
    name = topology_name(topology)
    kind, count = _type(path, name)
    number = int(topology.get("NumberOfElements", data.size // count))
    if data.size != number * count or (data.ndim == 2 and data.shape[1] != count):
        raise MeshError(
            f"{path}: expected {number} cells with {count} nodes for each {name}, found numbers of "
            f"shape {data.shape}"
        )
    return ElementBlock(kind, data.reshape(-1, count))


def _type(path: Path, name: str) -> tuple[int, int]:
    if name not in NAMES:
        raise MeshError(
            f"{path}: expected triangles or quadrilaterals and lines, or tetrahedra or hexahedra "
            f"and their facets, of order 1 or 2, found cells of type {name!r}"
        )
    return NAMES[name]


def _mixed(path: Path, data: Indices) -> list[ElementBlock]:
    """Cells from one row of numbers: type[, number of nodes], nodes, type, ..."""
    runs: list[tuple[int, list[Indices]]] = []
    place = 0
    while place < len(data):
        number = int(data[place])
        kind, count = _type(path, NUMBERS.get(number, f"number {number}"))
        start = place + 1 + (number in COUNTED)
        place = start + count
        if place > len(data) or (number in COUNTED and data[start - 1] != count):
            raise MeshError(f"{path}: the list of mixed cells is not complete or has long lines")
        if not runs or runs[-1][0] != kind:
            runs.append((kind, []))
        runs[-1][1].append(data[start:place])
    return [ElementBlock(kind, np.stack(nodes)) for kind, nodes in runs]


def data_item(path: Path, parent: ET.Element) -> Array:
    """The numbers under an element of the file, in the shape that they have there.

    Raises:
        MeshError: they are not there, or are written in a way that is not known.
    """
    item = parent.find("DataItem")
    if item is None or not (item.text or "").strip():
        raise MeshError(f"{path}: expected numbers in <{parent.tag}>, found none")
    text, form = (item.text or "").strip(), item.get("Format", "XML")
    try:
        if form.upper() == "HDF":
            return _from_hdf5(path, text)
        if form.upper() == "XML":
            shape = [int(length) for length in item.get("Dimensions", "-1").split()]
            return np.array(text.split(), dtype=float).reshape(shape)
    except (ValueError, TypeError) as error:
        raise MeshError(f"{path}: the numbers in <{parent.tag}> cannot be read: {error}") from error
    raise MeshError(f"{path}: expected data in the format HDF or XML, found {form!r}")


def _from_hdf5(path: Path, text: str) -> Array:
    name, _, place = text.partition(":")
    # Imported where it is needed: meshes of templates do without it.
    import h5py

    source = path.parent / name.strip()
    require_file(source, f"the numbers of {path}", MeshError)
    try:
        with h5py.File(source, "r") as file:
            values = np.asarray(file[place.strip()][()])
    except (OSError, KeyError, RuntimeError) as error:
        raise MeshError(
            f"{path}: cannot read {place.strip()!r} in {source}, where the file"
            f" has its numbers: {error}"
        ) from error
    if values.dtype.kind not in "iuf":
        raise MeshError(
            f"{path}: expected numbers in {place.strip()!r} of {source}, found {values.dtype}"
        )
    return values


@dataclass(frozen=True)
class Grid:
    """One grid of a file.

    Attributes:
        points: (n, 3), or None in a grid that refers to those of another.
        blocks: its cells.
        tags: the number of each cell, in the order of the blocks; None without numbers.
    """

    points: Array | None
    blocks: list[ElementBlock]
    tags: Indices | None


def read_xdmf(
    path: Path,
    facets: Path | None,
    bodies: Mapping[str, Selector],
    boundaries: Mapping[str, Selector],
) -> RawMesh:
    """Cells and facets by the names of the case.

    Args:
        path: file with the cells and their numbers.
        facets: file with facets and their numbers, on the same points; None if `path` has them.
        bodies: numbers of the cells of each body.
        boundaries: numbers of the facets of each boundary.

    Raises:
        MeshError: the files cannot be read, do not fit each other, or lack numbers.
    """
    grids = _grids(path)
    points = _common_points(path, grids, None)
    if facets is not None:
        more = _grids(facets)
        _common_points(facets, more, points)
        grids += more
    blocks = [block for grid in grids for block in grid.blocks]
    dimension = max(2, *(DIMENSIONS[block.gmsh_type] for block in blocks))
    cells, parts = (_by_tag(grids, dim) for dim in (dimension, dimension - 1))
    named = _named(path, "bodies", cells, bodies)
    _require_all_cells(path, grids, dimension, cells, bodies)
    sides = _named(facets or path, "boundaries", parts, boundaries)
    return complete(RawMesh(points, dimension, named, sides))


def _grids(path: Path) -> list[Grid]:
    require_file(path, "a mesh file", MeshError)
    try:
        root = ET.fromstring(path.read_bytes())
    except OSError as error:
        raise MeshError(f"{path}: cannot read the mesh file: {error.strerror}") from error
    except ET.ParseError as error:
        raise MeshError(f"{path}: expected an XDMF file (XML), found no XML: {error}") from error
    if root.tag != "Xdmf":
        raise MeshError(f"{path}: expected an XDMF file, found XML of type <{root.tag}>")
    grids = [_grid(path, each) for each in root.iter("Grid") if each.find("Topology") is not None]
    if not grids:
        raise MeshError(f"{path}: expected a grid with a topology, found none")
    return grids


def _grid(path: Path, element: ET.Element) -> Grid:
    topology, geometry = element.find("Topology"), element.find("Geometry")
    assert topology is not None
    blocks = cell_blocks(path, topology)
    count = sum(len(block.nodes) for block in blocks)
    points = None if geometry is None else read_points(path, geometry)
    return Grid(points, blocks, _tags(path, element, count, topology_name(topology)))


def _tags(path: Path, element: ET.Element, count: int, what: str) -> Indices | None:
    """The whole numbers that each cell has, if it has any."""
    found: dict[str, Indices] = {}
    for attribute in element.iter("Attribute"):
        if attribute.get("Center") != "Cell":
            continue
        values = data_item(path, attribute).ravel()
        if len(values) == count and np.array_equal(values, np.rint(values)):
            found[attribute.get("Name", "")] = values.astype(np.int64)
    if len(found) > 1 and PHYSICAL not in found:
        raise MeshError(
            f"{path}: expected one number for each cell, or one called '{PHYSICAL}', found for the "
            f"{what}s: {', '.join(found)}"
        )
    return found.get(PHYSICAL, next(iter(found.values()), None))


def _common_points(path: Path, grids: list[Grid], known: Array | None) -> Array:
    """The points (n, 3) of all grids, which have to be the same."""
    for grid in grids:
        if known is None:
            known = grid.points
        elif grid.points is not None and not np.array_equal(grid.points, known):
            raise MeshError(
                f"{path}: expected cells and facets on the same points, found different ones; write"
                " both from one mesh"
            )
    if known is None:
        raise MeshError(f"{path}: expected points, found none")
    if any(block.nodes.max(initial=0) >= len(known) for grid in grids for block in grid.blocks):
        raise MeshError(f"{path}: cells refer to points that the file does not have")
    if any(block.nodes.min(initial=0) < 0 for grid in grids for block in grid.blocks):
        raise MeshError(f"{path}: cells refer to points that the file does not have")
    return known


def _by_tag(grids: list[Grid], dim: int) -> dict[int, list[ElementBlock]]:
    """Cells of one dimension by their number."""
    found: dict[int, list[ElementBlock]] = {}
    for grid in grids:
        if grid.tags is None:
            continue
        start = 0
        for block in grid.blocks:
            tags = grid.tags[start : start + len(block.nodes)]
            start += len(block.nodes)
            if DIMENSIONS[block.gmsh_type] != dim:
                continue
            for tag in np.unique(tags):
                part = ElementBlock(block.gmsh_type, block.nodes[tags == tag])
                found.setdefault(int(tag), []).append(part)
    return found


def _named(
    path: Path, table: str, found: dict[int, list[ElementBlock]], selectors: Mapping[str, Selector]
) -> dict[str, list[ElementBlock]]:
    what = {"bodies": "cells", "boundaries": "facets"}[table]
    named = {}
    for name, selector in selectors.items():
        if missing := [tag for tag in selector.all_tags if tag not in found]:
            raise MeshError(
                f"{path}: geometry.{table}.{name}: no {what} have the number {missing[0]}; "
                f"numbers of {what} in the file: {_listed(found)}"
            )
        blocks = [block for tag in dict.fromkeys(selector.all_tags) for block in found[tag]]
        named[name] = stacked(blocks)
    return named


def _require_all_cells(
    path: Path,
    grids: list[Grid],
    dimension: int,
    found: dict[int, list[ElementBlock]],
    bodies: Mapping[str, Selector],
) -> None:
    """Every cell must be in a body."""
    used = {tag for selector in bodies.values() for tag in selector.all_tags}
    if loose := sorted(found.keys() - used):
        raise MeshError(
            f"{path}: expected all cells in one of [geometry.bodies], but in none are those of "
            f"number {_listed(loose)}"
        )
    tagged = sum(len(block.nodes) for blocks in found.values() for block in blocks)
    cells = max(
        sum(len(block.nodes) for block in grid.blocks if DIMENSIONS[block.gmsh_type] == dimension)
        for grid in grids
    )
    if tagged < cells:
        raise MeshError(f"{path}: {cells - tagged} of the {cells} cells have no number")


def _listed(numbers: Iterable[int]) -> str:
    return ", ".join(str(number) for number in sorted(numbers)) or "none"
