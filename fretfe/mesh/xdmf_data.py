# SPDX-License-Identifier: LGPL-3.0-or-later
"""The arrays in an XDMF file: points, cells and numbers, in the file itself or in HDF5 (XDMF 3)."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import MeshError
from fretfe.files import require_file
from fretfe.geometry.gmsh_elements import (
    ELEMENTS,
    SERENDIPITY_HEXAHEDRON,
    SERENDIPITY_QUADRILATERAL,
    SHAPE_DIMENSIONS,
)
from fretfe.geometry.gmsh_model import ElementBlock
from fretfe.mesh.node_order import in_gmsh_order

# Gmsh type and number of nodes, by the name of a topology and by its number among mixed cells.
NAMES = {
    "polyvertex": (15, 1),
    "polyline": (1, 2),
    "edge_3": (8, 3),
    "triangle": (2, 3),
    "triangle_6": (9, 6),
    "tri_6": (9, 6),
    "quadrilateral": (3, 4),
    "quadrilateral_8": (16, 8),
    "quad_8": (16, 8),
    "quadrilateral_9": (10, 9),
    "quad_9": (10, 9),
    "tetrahedron": (4, 4),
    "tetrahedron_10": (11, 10),
    "tet_10": (11, 10),
    "hexahedron": (5, 8),
    "hexahedron_20": (17, 20),
    "hex_20": (17, 20),
    "hexahedron_27": (12, 27),
    "hex_27": (12, 27),
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
DIMENSIONS = {15: 0, SERENDIPITY_QUADRILATERAL: 2, SERENDIPITY_HEXAHEDRON: 3} | {
    number: SHAPE_DIMENSIONS[shape] for number, (shape, _) in ELEMENTS.items()
}


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
