# SPDX-License-Identifier: LGPL-3.0-or-later
"""XDMF meshes with numbers for cells and facets, as DOLFINx and meshio write them.

Written for what meshio does not read: several grids in one file (DOLFINx writes the mesh and each
set of tags as a grid of its own) and cells of second order next to lines.
"""

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
from fretfe.geometry.gmsh_model import ElementBlock, RawMesh
from fretfe.mesh.serendipity import complete, stacked
from fretfe.mesh.xdmf_data import (
    DIMENSIONS,
    cell_blocks,
    data_item,
    read_points,
    topology_name,
)

# Where a cell has several numbers, as in what meshio makes of a Gmsh file, this is its group.
PHYSICAL = "gmsh:physical"


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
