# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields of other runs that are damaged or hostile."""

from __future__ import annotations

import base64
import os
import struct
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path

import h5py
import numpy as np
from faults.changed import file_faults, replaced, with_file
from faults.fault import CHECK, Fault
from faults.originals import field_case, heat_case

# Result files of CalculiX.
DATA = Path(__file__).parent.parent / "data"


def faults() -> Iterator[Fault]:
    """All of them, and the files as they should be."""
    yield from _grids()
    yield from _collections()
    yield from _older_grids()
    yield from _runs()
    yield from _tables()
    yield from _temperature_tables()
    yield from _calculix()


def _changed(
    file: str, text: str, changes: Mapping[str, tuple[bytes, bytes]], content: bytes | None = None
) -> Iterator[Fault]:
    """A file in which one text is replaced, so that it must be refused."""
    for name, (old, new) in changes.items():
        yield Fault(
            f"{file}/{name}", CHECK, with_file(file, replaced(old, new), text, content), True
        )


def _grids() -> Iterator[Fault]:
    """Displacements as a grid of VTK."""
    file, count = "run.vtu", b"999999999999"
    text = field_case(file)
    wrong = {"bomb": _bomb(), "a block of 10 GB": _bomb(1, 10 << 30), "empty": ""}
    yield from file_faults(file, text, wrong, 16)
    points, cells = b'NumberOfPoints="9"', b'NumberOfCells="4"'
    entity = b'<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><VTKFile'
    bomb = b"".join(b'<!ENTITY %c "%s">' % (98 + i, b"&%c;" % (97 + i) * 10) for i in range(12))
    changes = {
        "no displacement": (b'Name="U"', b'Name="V"'),
        "many points": (points, b'NumberOfPoints="' + count + b'"'),
        "too many points": (points, b'NumberOfPoints="100000000"'),
        "many cells": (cells, b'NumberOfCells="' + count + b'"'),
        "too many cells": (cells, b'NumberOfCells="100000000"'),
        "negative": (points, b'NumberOfPoints="-9"'),
        "points of words": (points, b'NumberOfPoints="nine"'),
        "many components": (b'NumberOfComponents="3"', b'NumberOfComponents="300000000"'),
        "entity": (b"<VTKFile", entity),
        "entity bomb": (b"<VTKFile", b'<!DOCTYPE x [<!ENTITY a "aaaa">' + bomb + b"]><VTKFile"),
        "half": (b"</Points>", b""),
    }
    yield from _changed(file, text, changes)


def _collections() -> Iterator[Fault]:
    """A file that names those of its steps."""
    file, text = "run.pvd", field_case("run.pvd")
    step = '<DataSet timestep="{}" file="{}"/>'
    head, tail = (
        '<?xml version="1.0"?><VTKFile type="Collection"><Collection>',
        "</Collection></VTKFile>",
    )
    contents = {
        "whole": step.format(1, "run.vtu"),
        "no step": "",
        "a file that is not there": step.format(1, "none.vtu"),
        "a pipe": step.format(1, "pipe.vtu"),
        "a device": step.format(1, "/dev/zero"),
        "a file of others": step.format(1, "/etc/passwd"),
        "itself": step.format(1, "run.pvd"),
        "time of words": step.format("one", "run.vtu"),
        "time of nan": step.format("nan", "run.vtu"),
        "before 0": step.format(-1, "run.vtu"),
        "no file": '<DataSet timestep="1"/>',
        "a bomb": step.format(1, "bomb.vtu"),
    }
    for name, content in contents.items():

        def write(good: Path, here: Path, content: str = content) -> None:
            with_file(file, text=text, content=f"{head}{content}{tail}".encode())(good, here)
            (here / "run.vtu").write_bytes((good / "run.vtu").read_bytes())
            (here / "bomb.vtu").write_text(_bomb())
            os.mkfifo(here / "pipe.vtu")

        yield Fault(f"{file}/{name}", CHECK, write, name != "whole")


def _older_grids() -> Iterator[Fault]:
    """The older format of VTK."""
    file, text = "run.vtk", field_case("run.vtk")
    grid = (
        "# vtk DataFile Version 3.0\nrun\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n"
        "-40 -50 0 40 -50 0 40 50 0 -40 50 0\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n9\n"
        "POINT_DATA 4\nVECTORS U double\n" + "1e-4 0 0\n" * 4
    )
    wrong = {
        "empty": "",
        "many points": grid.replace("POINTS 4", "POINTS 4000000000"),
        "too many points": grid.replace("POINTS 4", "POINTS 40000000"),
        "negative points": grid.replace("POINTS 4", "POINTS -4"),
        "many cells": grid.replace("CELLS 1 5", "CELLS 1000000000 5000000000"),
        "many values": grid.replace("POINT_DATA 4", "POINT_DATA 4000000000"),
        "another node": grid.replace("4 0 1 2 3", "4 0 1 2 999"),
        "a negative node": grid.replace("4 0 1 2 3", "4 0 1 2 -3"),
        "fewer nodes": grid.replace("4 0 1 2 3", "3 0 1 2").replace("CELLS 1 5", "CELLS 1 4"),
        "another kind": grid.replace("\n9\n", "\n25\n"),
        "nan": grid.replace("1e-4", "nan"),
        "half": grid[: len(grid) // 2],
        "no displacement": grid.replace("U double", "V double"),
        "a number": grid.replace("VECTORS U double", "SCALARS U double 1\nLOOKUP_TABLE default"),
    }
    yield from file_faults(file, text, wrong, 24, grid)


def _runs() -> Iterator[Fault]:
    """The fields of a run of this program, in another file."""
    file = "run.hdf"
    text = field_case(file)
    yield from file_faults(file, text, {"empty": "", "text": text}, 24)
    changes: dict[str, Callable[[h5py.Group], object]] = {
        "many rows": partial(_stretched, "Points", (10**12, 3)),
        "many bodies": partial(_stretched, "CellData/body", (10**11,)),
        "many times": partial(_stretched, "Steps/Values", (10**11,)),
        "many components": partial(_stretched, "PointData/displacement", (8, 10**9)),
        "many points": partial(_filled, "NumberOfPoints", 10**12),
        "a body beyond": partial(_filled, "CellData/body", 2**30),
        "a negative body": partial(_filled, "CellData/body", -1),
        "an offset beyond": partial(_filled, "Offsets", 10**12),
        "nan": partial(_filled, "PointData/displacement", np.nan),
        "places of nan": partial(_filled, "Points", np.nan),
        "times of nan": partial(_filled, "Steps/Values", np.nan),
        "a start beyond": partial(_filled, "Steps/PointDataOffsets/displacement", 10**12),
        "a negative start": partial(_filled, "Steps/PointDataOffsets/displacement", -8),
        "no displacement": lambda root: root.__delitem__("PointData/displacement"),
        "no points": lambda root: root.__delitem__("Points"),
        "other names": lambda root: root["CellData/body"].attrs.__setitem__("names", ["other"]),
        "a link out": _linked,
        "another file's numbers": _external,
    }
    for name, change in changes.items():

        def write(good: Path, here: Path, change: Callable[[h5py.Group], object] = change) -> None:
            with_file(file, text=text)(good, here)
            with h5py.File(here / file, "r+") as opened:
                change(opened["VTKHDF"])

        yield Fault(f"{file}/{name}", CHECK, write, True)


def _stretched(name: str, shape: tuple[int, ...], root: h5py.Group) -> None:
    """A table of this shape in place of another one, which takes no room in the file."""
    kind, words = root[name].dtype, dict(root[name].attrs)
    del root[name]
    chunks = tuple(min(size, 1000) for size in shape)
    root.create_dataset(name, shape, kind, chunks=chunks, compression="gzip").attrs.update(words)


def _filled(name: str, value: float, root: h5py.Group) -> None:
    root[name][...] = value


def _linked(root: h5py.Group) -> None:
    del root["Points"]
    root["Points"] = h5py.ExternalLink("/etc/passwd", "/x")


def _external(root: h5py.Group) -> None:
    shape = root["Points"].shape
    del root["Points"]
    size = 8 * shape[0] * shape[1]
    root.create_dataset("Points", shape, float, external=[("/etc/passwd", 0, size)])


def _tables() -> Iterator[Fault]:
    """Displacements as a table."""
    file = "run.csv"
    square = "x,y,ux,uy,time\n-40,-50,1e-4,0,1\n40,-50,1e-4,0,1\n-40,50,1e-4,0,1\n40,50,{},1\n"
    wrong = {
        "nan": square.format("nan,0"),
        "huge": square.format("1e300,0"),
        "missing": square.format("1"),
        "a point twice": square.format("0,0,1\n40,50,1e-4,0"),
        "elsewhere": square.replace("40", "1").format("0,0"),
        "metres": square.replace("40", ".04").replace("50", ".05").format("0,0"),
        "missing step": square.format("0,0").replace(",1\n", ",0.4\n"),
        "before 0": square.format("0,0").replace(",1\n", ",-1\n"),
        "other points": square.format("0,0") + "0,0,0,0,2\n",
        "no points": "x,y,ux,uy,time\n",
        "at rest": square.replace("1e-4", "0").format("0,0"),
        "moved at 0": square.format("1e-4,0").replace(",1\n", ",0\n"),
        "time and step": square.replace("time", "time,step")
        .replace(",1\n", ",1,1\n")
        .format("0,0"),
        "not in the plane": square.replace("x,y", "x,y,z").replace("uy", "uy,uz"),
    }
    yield from file_faults(file, field_case(file), wrong, 24, square.format("1e-4,0"))


def _temperature_tables() -> Iterator[Fault]:
    """Temperatures of another run, as a table."""
    file = "heat.csv"
    square = "x,y,T,time\n-40,-50,20,1\n40,-50,20,1\n-40,50,90,1\n40,50,{}\n"
    wrong = {
        "nan": square.format("nan,1"),
        "too cold": square.replace("20", "-400").replace("90", "-400").format("-400,1"),
        "a point twice": square.format("90,1\n40,50,80,1"),
        "elsewhere": square.replace("40", "1").format("90,1"),
        "missing step": square.format("90,1").replace(",1\n", ",0.4\n"),
        "hot at 0": square.format("90,0").replace(",1\n", ",0\n"),
        "displacements": square.format("90,1").replace("T", "ux"),
        "cold": square.replace("90", "20").format("20,1"),
        "huge": square.format("1e300,1"),
        "empty": "",
    }
    yield from file_faults(file, heat_case(file), wrong, 24, square.format("90,1"))


def _calculix() -> Iterator[Fault]:
    """Displacements and temperatures of another run, as a result file of CalculiX."""
    good, solids = _frd(), (DATA / "solids.frd").read_text()
    nodes, elements, results = (
        f"{key:<24}" for key in ("    2C", "    3C", "  100CL  101 1.000000000")
    )
    wrong = {
        "solids": solids,
        "half": good[: len(good) // 2],
        "empty": "",
        "many nodes": good.replace(f"{nodes}{4:12}", f"{nodes}{'9' * 12}"),
        "too many nodes": good.replace(f"{nodes}{4:12}", f"{nodes}{60_000_000:12}"),
        "more nodes": good.replace(f"{nodes}{4:12}", f"{nodes}{5:12}"),
        "too many elements": good.replace(f"{elements}{1:12}", f"{elements}{60_000_000:12}"),
        "more values": good.replace(f"{results}{4:12}", f"{results}{5:12}"),
        "no results": good.replace("DISP  ", "DISK  ").replace("NDTEMP", "NDTIME"),
        "nan": good.replace(" 1.00000E-04", "         nan").replace(" 9.00000E+01", "         nan"),
        "inf": good.replace(" 1.00000E-04", "         inf").replace(" 9.00000E+01", "         inf"),
        "no nodes": good.replace("    2C", "    1C"),
        "a node twice": good.replace(" -1         2 4", " -1         1 4"),
        "an element of another node": good.replace(" -2         1", " -2         9"),
        "an element of no kind": good.replace(" -1         1    9", " -1         1   99"),
        "another step": good.replace(" 1.000000000", " 0.500000000"),
        "time of words": good.replace(" 1.000000000", " one        "),
        "a vibration": good.replace(f"{0:22}{1:5}", f"{2:22}{1:5}"),
        "not whole": good.replace(" 9999", ""),
    }
    for file, text in (("run.frd", field_case("run.frd")), ("heat.frd", heat_case("heat.frd"))):
        yield from file_faults(file, text, wrong, 24, good)


def _frd() -> str:
    """A rectangle around the bodies that is stretched, and warm above."""
    corners = [(-40, -50), (40, -50), (40, 50), (-40, 50)]

    def rows(values: Iterable[tuple[float, ...]]) -> str:
        return "".join(
            f" -1{node:10}{''.join(f'{value:12.5E}' for value in row)}\n"
            for node, row in enumerate(values, 1)
        )

    def count(key: str, number: int) -> str:
        return f"{key:<24}{number:>12}{'':37} 1\n"

    head = f"{'  100CL  101 1.000000000':<24}{4:12}{0:22}{1:5}{1:12}\n"
    moved = rows((1e-4 * x / 40, 0.0, 0.0) for x, _ in corners)
    warm = rows((55 + 0.7 * y,) for _, y in corners)
    return (
        "    1C\n" + count("    2C", 4) + rows((x, y, 0.0) for x, y in corners) + " -3\n"
        + count("    3C", 1) + " -1         1    9    0    1\n"
        + f" -2{''.join(f'{node:10}' for node in range(1, 5))}\n -3\n"
        + head + " -4  DISP        4    1\n"
        + "".join(f" -5  D{i}          1    2    {i}    0\n" for i in (1, 2, 3))
        + " -5  ALL         1    2    0    0    1ALL\n" + moved + " -3\n"
        + head + " -4  NDTEMP      1    1\n -5  T           1    1    0    0\n" + warm + " -3\n"
        + " 9999\n"
    )  # fmt: skip


def _bomb(count: int = 357, block: int = 1 << 26) -> str:
    """A grid of blocks of zeros that are compressed: of 10^9 points, in 30 MB."""
    packed = zlib.compress(bytes(min(block, 1 << 26)), 9)
    head = struct.pack(f"<{3 + count}Q", count, block, 0, *[len(packed)] * count)
    data = (base64.b64encode(head) + base64.b64encode(packed * count)).decode()
    points = f'NumberOfPoints="{count * block // 24}" NumberOfCells="1"'
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="{}">{}</DataArray>'
    return (
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" '
        'byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">'
        f"<UnstructuredGrid><Piece {points}><PointData>"
        f"{array.format('Float64', 'U', 3, 'ascii', '0 0 0')}</PointData>"
        f"<Points>{array.format('Float64', 'p', 3, 'binary', data)}</Points><Cells>"
        f"{array.format('Int64', 'connectivity', 1, 'ascii', '0 1 2')}"
        f"{array.format('Int64', 'offsets', 1, 'ascii', '3')}"
        f"{array.format('UInt8', 'types', 1, 'ascii', '5')}"
        "</Cells></Piece></UnstructuredGrid></VTKFile>"
    )
