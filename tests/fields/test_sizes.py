# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields whose arrays are not as long as stated, or in other files, and steps that are there twice.

What VTK and HDF5 do not find they take from memory, or from any file that they may open.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from fretfe.errors import CaseError
from fretfe.fields.field import read_field
from fretfe.fields.sizes import require_sizes

POINTS = np.array([[x, y, 0.0] for y in range(3) for x in range(3)])
CELLS = np.array([[k, k + 1, k + 4, k + 3] for k in (0, 1, 3, 4)])
MOVED = 0.5 * POINTS + [1.0, 2.0, 0.0]


def words(values: Any) -> str:
    return " ".join(f"{each:.17g}" for each in np.ravel(values))


def in_xml() -> str:
    """Nine points and four squares, as text."""
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">{}</DataArray>'
    parts = {
        "PointData": [("Float64", "U", 3, words(MOVED))],
        "Points": [("Float64", "Points", 3, words(POINTS))],
        "Cells": [
            ("Int64", "connectivity", 1, words(CELLS)),
            ("Int64", "offsets", 1, "4 8 12 16"),
            ("UInt8", "types", 1, "9 9 9 9"),
        ],
    }
    inner = "".join(
        f"<{name}>{''.join(array.format(*each) for each in arrays)}</{name}>"
        for name, arrays in parts.items()
    )
    return (
        '<VTKFile type="UnstructuredGrid" version="0.1"><UnstructuredGrid>'
        f'<Piece NumberOfPoints="9" NumberOfCells="4">{inner}</Piece></UnstructuredGrid></VTKFile>'
    )


OLDER = "\n".join(
    [
        "# vtk DataFile Version 3.0\na run\nASCII\nDATASET UNSTRUCTURED_GRID",
        f"POINTS 9 double\n{words(POINTS)}",
        f"CELLS 4 20\n{words(np.insert(CELLS, 0, 4, axis=1))}",
        "CELL_TYPES 4\n9 9 9 9",
        f"POINT_DATA 9\nSCALARS T float\nLOOKUP_TABLE default\n{words(range(9))}",
        f"VECTORS U double\n{words(MOVED)}\nFIELD more 1\nids 1 9 int\n{words(range(9))}\n",
    ]
)


def in_hdf(path: Path, change: Callable[[Any], object] = lambda root: None) -> None:
    """Two steps of the same points."""
    tables = {
        "NumberOfPoints": [9], "NumberOfCells": [4], "NumberOfConnectivityIds": [16],
        "Points": POINTS, "Connectivity": CELLS.ravel(), "Offsets": [0, 4, 8, 12, 16],
        "Types": np.full(4, 9, np.uint8), "PointData/U": np.concatenate([MOVED, 2 * MOVED]),
        "Steps/Values": [1.0, 2.0], "Steps/PartOffsets": [0, 0], "Steps/PointOffsets": [0, 0],
        "Steps/NumberOfParts": [1, 1], "Steps/CellOffsets": [[0], [0]],
        "Steps/ConnectivityIdOffsets": [[0], [0]], "Steps/PointDataOffsets/U": [0, 9],
    }  # fmt: skip
    with h5py.File(path, "w") as file:
        root = file.create_group("VTKHDF")
        for name, table in tables.items():
            root[name] = np.asarray(table)
        change(root)


def refused(path: Path, expected: str) -> None:
    with pytest.raises(CaseError, match=expected) as caught:
        require_sizes(path)
    assert str(caught.value).startswith(f"{path}: ")


def replaced(root: Any, name: str, table: Any) -> None:
    del root[name]
    root[name] = np.asarray(table)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('NumberOfPoints="9"', 'NumberOfPoints="10"', "PointData U: expected 30 values, found 27"),
        (">9 9 9 9<", ">9 9 9<", "Cells types: expected 4 values, found 3"),
        (">4 8 12 16<", ">4 8 12 16 20<", "Cells offsets: expected 4 values, found 5"),
        ("</VTKFile>", "", "no element found|not whole"),
    ],
)
def test_arrays_in_xml(tmp_path: Path, old: str, new: str, expected: str) -> None:
    path, text = tmp_path / "run.vtu", in_xml()
    path.write_text(text)
    require_sizes(path)
    assert old in text
    path.write_text(text.replace(old, new))
    refused(path, expected)


@pytest.mark.parametrize("mode", ["Binary", "Appended", "Raw"])
@pytest.mark.parametrize("packed", [False, True])
def test_binary_arrays_in_xml(tmp_path: Path, mode: str, *, packed: bool) -> None:
    """As VTK writes them: whole, and with another number of points."""
    pyvista = pytest.importorskip("pyvista")
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

    path = tmp_path / "run.vtu"
    grid = pyvista.UnstructuredGrid(np.insert(CELLS, 0, 4, axis=1).ravel(), np.full(4, 9), POINTS)
    grid.point_data["U"] = MOVED
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(str(path))
    (writer.SetDataModeToBinary if mode == "Binary" else writer.SetDataModeToAppended)()
    if mode == "Raw":
        writer.EncodeAppendedDataOff()
    if not packed:
        writer.SetCompressorTypeToNone()
    writer.Write()
    require_sizes(path)
    data = path.read_bytes()
    path.write_bytes(re.sub(rb'NumberOfPoints="9"', b'NumberOfPoints="8"', data))
    refused(path, "expected 24 values, found 27")
    path.write_bytes(data[:-60])
    refused(path, "run.vtu")


LONG = "expected arrays with as many values as their heads state"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("POINTS 9", "POINTS 8", LONG),
        ("POINT_DATA 9", "POINT_DATA 12", LONG),
        ("CELL_TYPES 4", "CELL_TYPES 5", LONG),
        ("CELLS 4 20", "CELLS 4 21", "expected elements between its 9 points"),
        ("ids 1 9", "ids 1 10", LONG),
        ("ids 1 9 int", "ids 1 9 int\nx", LONG),
        ("T float", "T half", "Unsupported data type: half"),
        ("ASCII", "TEXT", "line 3: expected ASCII or BINARY, found b'text'"),
    ],
)
def test_arrays_of_the_older_format(tmp_path: Path, old: str, new: str, expected: str) -> None:
    pytest.importorskip("pyvista")
    path = tmp_path / "run.vtk"
    path.write_text(OLDER)
    np.testing.assert_array_equal(read_field(path).values(0), MOVED)
    path.write_text(OLDER.replace(old, new))
    with pytest.raises(CaseError, match=expected):
        read_field(path)


@pytest.mark.parametrize("binary", [False, True])
def test_files_of_the_older_format_that_are_cut_off(tmp_path: Path, *, binary: bool) -> None:
    """Wherever within an array: of the last one a byte more than the line's end is enough."""
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "run.vtk"
    grid = pyvista.UnstructuredGrid(np.insert(CELLS, 0, 4, axis=1).ravel(), np.full(4, 9), POINTS)
    grid.point_data["U"] = MOVED
    grid.point_data["T"] = MOVED[:, 0]
    grid.save(path, binary=binary)
    whole = path.read_bytes()
    require_sizes(path)
    begin, size = whole.index(b"POINT_DATA"), len(whole.rstrip(b" \n" if not binary else b""))
    ends = [*range(size - 1 - binary, size - 12, -1), *range(begin + 40, size - 12, 7)]
    for end in ends:
        path.write_bytes(whole[:end])
        refused(path, f"{LONG}|it may be cut off")


HDF: dict[str, tuple[Callable[[Any], object], str]] = {
    "offset beyond": (
        lambda root: replaced(root, "Steps/PointDataOffsets/U", [0, 10]),
        "VTKHDF/PointData/U: expected 19 rows by the counts of step 2, found 18",
    ),
    "offset before": (
        lambda root: replaced(root, "Steps/PointOffsets", [0, -1]),
        "VTKHDF/Points: expected 8 rows by the counts of step 2",
    ),
    "few types": (
        lambda root: replaced(root, "Types", np.full(3, 9, np.uint8)),
        "VTKHDF/Types: expected 4 rows by the counts of step 1, found 3",
    ),
    "part beyond": (
        lambda root: replaced(root, "Steps/PartOffsets", [0, 1]), "by the counts of step 2",
    ),
    "no offsets": (
        lambda root: root.__delitem__("Steps/PointDataOffsets/U"),
        "VTKHDF/PointData/U: expected 9 rows by the counts of step 1, found 18",
    ),
    "few steps": (
        lambda root: replaced(root, "Steps/PointOffsets", [0]),
        "PointOffsets: expected 2 steps, found 1",
    ),
    "external": (
        lambda root: root.__setitem__("PointData/T", h5py.ExternalLink("other.h5", "/big")),
        "VTKHDF/PointData/T: expected numbers, found a link to another file",
    ),
    "in a circle": (
        lambda root: root.__setitem__("again", h5py.SoftLink("/VTKHDF")),
        "expected groups in at most 20 others",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("change", "expected"), HDF.values(), ids=HDF)
def test_tables_of_hdf(tmp_path: Path, change: Callable[[Any], object], expected: str) -> None:
    path = tmp_path / "run.vtkhdf"
    in_hdf(path)
    require_sizes(path)
    in_hdf(path, change)
    refused(path, expected)


def test_links_within_a_file_are_followed(tmp_path: Path) -> None:
    """As to a table that is too wide elsewhere in it."""
    path = tmp_path / "run.vtkhdf"

    def change(root: Any) -> None:
        replaced(root, "Points", POINTS[:8])
        root.file["points"] = root["Points"][()]
        del root["Points"]
        root["Points"] = h5py.SoftLink("/points")

    in_hdf(path, change)
    refused(path, "VTKHDF/Points: expected 9 rows")


def test_steps_of_a_series_that_are_there_twice(tmp_path: Path) -> None:
    for name in ("one.vtu", "two.vtu"):
        (tmp_path / name).write_text(in_xml())
    path = tmp_path / "run.pvd"

    def write(first: str, second: str) -> None:
        path.write_text(
            '<VTKFile type="Collection"><Collection>'
            f'<DataSet timestep="{first}" file="one.vtu"/>'
            f'<DataSet timestep="{second}" file="two.vtu"/></Collection></VTKFile>'
        )

    write("1", "2")
    require_sizes(path)
    write("1", '1" part="1')
    require_sizes(path)
    write("1", "1.0")
    refused(path, r"one file of each time \(timestep\) and part, found 'one.vtu', 'two.vtu' at 1$")
    write("1", "soon")
    refused(path, "timestep: expected a number, found 'soon'")
