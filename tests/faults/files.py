# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes, drawings and tables that are damaged or hostile."""

from __future__ import annotations

import base64
import os
import shutil
import struct
import zlib
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import h5py
import numpy as np
from faults.fault import CHECK, HALFPLANE, Fault, Prepare, damaged
from faults.originals import (
    DRAWINGS,
    GRIDS,
    MATERIAL,
    MESHES,
    case_text,
    csv_case,
    factors_case,
    field_case,
    heat_case,
    material_case,
    points_case,
    shape_case,
    strain_case,
)

# Result files of CalculiX.
DATA = Path(__file__).parent.parent / "data"

Change = Callable[[bytes], bytes]


def faults() -> Iterator[Fault]:
    """All of them, and the files as they should be."""
    for file in (*MESHES, *GRIDS, *DRAWINGS):
        yield Fault(f"{file}/whole", CHECK, _with(file, lambda data: data), False)
    whole = _with("loads.csv", lambda data: data, csv_case())
    yield Fault("loads.csv/whole", HALFPLANE, whole, False)
    yield from _meshes()
    yield from _drawings()
    whole = _with("points.csv", lambda data: data, points_case())
    yield Fault("points.csv/whole", CHECK, whole, False)
    yield from _load_tables()
    yield from _point_tables()
    yield from _shape_tables()
    yield from _factor_tables()
    yield from _strain_tables()
    yield from _materials()
    yield from _fields()
    yield from _traction_tables()


def _with(file: str, change: Change, text: str | None = None) -> Prepare:
    """A case with a changed file."""

    def write(good: Path, here: Path) -> None:
        (here / "case.toml").write_text(case_text(file) if text is None else text)
        (here / file).write_bytes(change((good / file).read_bytes()))
        if file in GRIDS and not (here / "pad.h5").exists():
            shutil.copy(good / "pad.h5", here)

    return write


def _pipe(file: str, text: str | None = None) -> Prepare:
    def write(good: Path, here: Path) -> None:
        (here / "case.toml").write_text(case_text(file) if text is None else text)
        os.mkfifo(here / file)

    return write


def _damaging(seed: int) -> Change:
    return lambda data: damaged(data, seed)


def _constant(content: bytes) -> Change:
    return lambda data: content


def _seeded(file: str, seeds: range) -> Iterator[Fault]:
    for seed in seeds:
        change = _damaging(seed)
        yield Fault(f"{file}/damaged/{seed}", CHECK, _with(file, change))


def _replaced(old: bytes, new: bytes) -> Change:
    def change(data: bytes) -> bytes:
        assert old in data, old
        return data.replace(old, new, 1)

    return change


def _node(text: bytes, data: bytes, marker: bytes = b"$Nodes\n") -> bytes:
    """A mesh of format 2.2 whose third node has other coordinates."""
    start = data.index(marker) + len(marker)
    lines = data[start:].split(b"\n")
    number = lines[3].split()[0]
    lines[3] = number + b" " + text
    return data[:start] + b"\n".join(lines)


def with_places(move: Callable[[list[float]], list[float]]) -> Change:
    """A change of the coordinates of every node in a mesh of format 2.2."""

    def change(data: bytes) -> bytes:
        head, rest = data.split(b"$Nodes\n")
        nodes, tail = rest.split(b"$EndNodes")
        count, *rows = nodes.strip().split(b"\n")
        lines = [count]
        for row in rows:
            number, *values = row.split()
            places = move([float(value) for value in values])
            lines.append(b" ".join([number, *(repr(place).encode() for place in places)]))
        return head + b"$Nodes\n" + b"\n".join(lines) + b"\n$EndNodes" + tail

    return change


def _scaled(factor: float) -> Change:
    return with_places(lambda places: [factor * place for place in places])


def _meshes() -> Iterator[Fault]:
    for place, file in enumerate(MESHES):
        yield from _seeded(file, range(100 * place, 100 * place + 14))
        yield Fault(f"{file}/pipe", CHECK, _pipe(file), True)
        yield Fault(f"{file}/empty", CHECK, _with(file, lambda data: b""), True)
    for name, text in {
        "nan": b"nan 1 0", "inf": b"inf 1 0", "huge": b"1e200 1 0", "words": b"a b c",
        "missing": b"", "out of the plane": b"0 0 5",
    }.items():  # fmt: skip
        change: Change = partial(_node, text)
        yield Fault(f"pad22.msh/node: {name}", CHECK, _with("pad22.msh", change), True)
    for factor in (1e-200, 1e-60, 1e60, 1e200, 0.0):
        change = _scaled(factor)
        yield Fault(f"pad22.msh/scaled by {factor:g}", CHECK, _with("pad22.msh", change), True)
    script = b'SystemCall "touch ../escaped";\nSave "escaped.msh";\n'
    options = b"$Options\nMesh.SaveAll = 1;\n$EndOptions\n" + script
    for name, change in {
        "same names": _replaced(b'"upper_top"', b'"lower_bottom"'),
        "bodies of the same name": _replaced(b'"upper"', b'"lower"'),
        "a name that is a path": _replaced(b'"upper"', b'"../../escaped"'),
        "a name of 5000": _replaced(b'"upper"', b'"' + b"x" * 5000 + b'"'),
        "script behind": lambda data: data + script,
        "options before": lambda data: data.replace(b"$PhysicalNames", options + b"$PhysicalNames"),
        "script in comments": lambda data: b"$Comments\n$EndComments\n" + script + data,
        "a script": lambda data: script,
        "many nodes": lambda data: data.replace(b"$Nodes\n", b"$Nodes\n999999999999", 1),
        "many elements": lambda data: data.replace(b"$Elements\n", b"$Elements\n99999999999", 1),
        "negative nodes": lambda data: data.replace(b"$Nodes\n", b"$Nodes\n-", 1),
        "another mesh": lambda data: b"# vtk DataFile Version 2.0\n" + data,
    }.items():
        loose = name in ("script behind", "options before", "script in comments", "same names")
        loose |= name.startswith("many") or name.startswith("negative")
        refused = None if loose else True
        yield Fault(f"pad22.msh/{name}", CHECK, _with("pad22.msh", change), refused)
    yield from _decks()
    yield from _grids()


INSTANCE = b"*INSTANCE, NAME=I, PART=P\n"
# A row of rotation but for its angle; a turn about x.
TURN, OUT = b"0, 0, 0\n0, 0, 0, 0, 0, 1, ", b"0, 0, 0\n0, 0, 0, 1, 0, 0, 30\n"


def _placed(data: bytes, instance: bytes) -> bytes:
    """A deck as a part that an assembly places."""
    tail = b"*END INSTANCE\n*END ASSEMBLY\n"
    return b"*PART, NAME=P\n" + data + b"\n*END PART\n*ASSEMBLY\n" + instance + tail


def _decks() -> Iterator[Fault]:
    for name, change in {
        "nan": lambda data: data.replace(b"*NODE\n1,", b"*NODE\n1, nan, 0, 0\n999999,", 1),
        "includes itself": lambda data: data + b"\n*INCLUDE, INPUT=pad.inp\n",
        "includes a pipe": lambda data: data + b"\n*INCLUDE, INPUT=pipe\n",
        "includes a device": lambda data: data + b"\n*INCLUDE, INPUT=/dev/zero\n",
        "includes nothing": lambda data: data + b"\n*INCLUDE, INPUT=\n",
        "a set of billions": lambda data: (
            data + b"\n*ELSET, ELSET=big, GENERATE\n1, 999999999999, 1\n"
        ),
        "a step of zero": lambda data: data + b"\n*ELSET, ELSET=big, GENERATE\n1, 9, 0\n",
        "400 digits": lambda data: data + b"\n*NSET, NSET=a\n" + b"9" * 4500 + b"\n",
        "superscripts": lambda data: data + "\n*NSET, NSET=a\n²\n".encode(),
        "includes a file above": lambda data: data + b"\n*INCLUDE, INPUT=../pad.inp\n",
        "includes a loop": lambda data: data + b"\n*INCLUDE, INPUT=loop.inp\n",
        "a part without end": lambda data: b"*PART, NAME=P\n" + data,
        "an instance of nothing": lambda data: _placed(data, b"*INSTANCE, NAME=I, PART=Q\n"),
        "an instance without a part": lambda data: _placed(data, b"*INSTANCE, NAME=I\n"),
        "an instance outside": lambda data: _placed(data, INSTANCE).replace(b"*ASSEMBLY", b"*STEP"),
        "an instance twice": lambda data: _placed(data, INSTANCE + b"*END INSTANCE\n" + INSTANCE),
        "moved to nan": lambda data: _placed(data, INSTANCE + b"nan, 0, 0\n"),
        "moved by words": lambda data: _placed(data, INSTANCE + b"one, 0, 0\n"),
        "moved by 1e300": lambda data: _placed(data, INSTANCE + b"1e300, 0, 0\n"),
        "turned by words": lambda data: _placed(data, INSTANCE + TURN + b"a quarter\n"),
        "turned by inf": lambda data: _placed(data, INSTANCE + TURN + b"inf\n"),
        "turned about nothing": lambda data: _placed(data, INSTANCE + b"0,0,0\n0,0,0,0,0,0,9\n"),
        "turned out of the plane": lambda data: _placed(data, INSTANCE + OUT),
        "a number of another instance": lambda data: _placed(data, INSTANCE).replace(
            b"*NODE\n1,", b"*NODE\n2000000001, 0, 0, 0\n1,", 1
        ),
    }.items():

        def write(good: Path, here: Path, change: Change = change) -> None:
            _with("pad.inp", change)(good, here)
            os.mkfifo(here / "pipe")
            (here / "loop.inp").write_text("*INCLUDE, INPUT=pad.inp\n")

        yield Fault(f"pad.inp/{name}", CHECK, write, True)
    placed = _with("pad.inp", lambda data: _placed(data, INSTANCE))
    yield Fault("pad.inp/placed", CHECK, placed, False)
    for seed in range(14):
        change = partial(_damaged_instance, seed)
        yield Fault(f"pad.inp/placed and damaged/{seed}", CHECK, _with("pad.inp", change))


def _damaged_instance(seed: int, data: bytes) -> bytes:
    """Mistakes in what is around the mesh."""
    head, tail = _placed(data, INSTANCE + TURN + b"360\n").split(data)
    return head + data + damaged(tail, seed)


def _grids() -> Iterator[Fault]:
    for file in GRIDS:
        yield from _seeded(file, range(800, 812))
    bomb = b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">' + b"".join(
        b'<!ENTITY %c "%s">' % (98 + i, b"&%c;" % (97 + i) * 10) for i in range(12)
    )
    entity = b'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
    for name, change in {
        "entity bomb": lambda data: bomb + b"]><Xdmf>&m;</Xdmf>",
        "external entity": lambda data: entity + b"<Xdmf>&a;</Xdmf>",
        "inclusion": lambda data: b'<Xdmf><include href="/etc/passwd"/></Xdmf>',
        "another file": lambda data: data.replace(b"pad.h5:", b"/etc/passwd:"),
        "a pipe": lambda data: data.replace(b"pad.h5:", b"pipe:"),
        "deep": lambda data: b"<Xdmf>" + b"<Grid>" * 100000 + b"</Grid>" * 100000 + b"</Xdmf>",
        "dimensions": lambda data: data.replace(b'Dimensions="', b'Dimensions="99999999999 '),
        "nan": lambda data: data.replace(b'Dimensions="', b'Dimensions="nan '),
    }.items():

        def write(good: Path, here: Path, change: Change = change) -> None:
            _with("pad.xdmf", change)(good, here)
            os.mkfifo(here / "pipe")

        # Dimensions of what is in HDF5 are those that it has.
        refused = None if name in ("dimensions", "nan") else True
        yield Fault(f"pad.xdmf/{name}", CHECK, write, refused)
    yield from _arrays()


def _arrays() -> Iterator[Fault]:
    """The numbers of a grid in HDF5."""
    for seed in range(14):

        def write_h5(good: Path, here: Path, seed: int = seed) -> None:
            (here / "pad.h5").write_bytes(damaged((good / "pad.h5").read_bytes(), seed))
            _with("pad.xdmf", lambda data: data)(good, here)

        yield Fault(f"pad.h5/damaged/{seed}", CHECK, write_h5)
    for name, value in (("nan", np.nan), ("inf", np.inf), ("link", None), ("text", "a")):

        def write_value(good: Path, here: Path, value: object = value) -> None:
            _with("pad.xdmf", lambda data: data)(good, here)
            with h5py.File(here / "pad.h5", "r+") as file:
                first = next(iter(file))
                if value is None:
                    del file[first]
                    file[first] = h5py.ExternalLink("/etc/passwd", "/x")
                elif isinstance(value, str):
                    del file[first]
                    file[first] = value
                else:
                    file[first][0] = value

        yield Fault(f"pad.h5/{name}", CHECK, write_value, True)


def _drawings() -> Iterator[Fault]:
    for place, file in enumerate(DRAWINGS):
        count = 30 if file.startswith("pad") else 12
        yield from _seeded(file, range(2000 + 100 * place, 2000 + 100 * place + count))
        # Whole at both ends, wrong in between.
        for seed in range(14 if file.startswith("pad") else 6):

            def inside(data: bytes, seed: int = seed) -> bytes:
                third = len(data) // 3
                return data[:third] + damaged(data[third:-third], seed) + data[-third:]

            yield Fault(f"{file}/inside/{seed}", CHECK, _with(file, inside))
        yield Fault(f"{file}/pipe", CHECK, _pipe(file), True)
        for name, content in (("empty", b""), ("random", bytes(range(256)) * 40)):
            change = _constant(content)
            yield Fault(f"{file}/{name}", CHECK, _with(file, change), True)


def _load_tables() -> Iterator[Fault]:
    file, text = "loads.csv", csv_case()
    for seed in range(24):
        change = _damaging(seed)
        yield Fault(f"loads.csv/damaged/{seed}", HALFPLANE, _with(file, change, text))
    yield Fault("loads.csv/pipe", HALFPLANE, _pipe(file, text), True)
    contents: dict[str, str | bytes] = {
        "decimal commas": "t,q\n0,0\n0,5,1,5\n1,0,20,5\n",
        "longer rows": "t,q\n0,0\n1,20,7\n",
        "shorter rows": "t,q\n0,0\n1\n",
        "one column": "t\n0\n1\n",
        "names twice": "t,q,q\n0,0,0\n1,1,1\n",
        "nan": "t,q\n0,0\n1,nan\n",
        "inf": "t,q\n0,0\n1,1e999\n",
        "huge": "t,q\n0,0\n1,1e300\n",
        "back in time": "t,q\n0,0\n2,1\n1,2\n",
        "same time": "t,q\n0,0\n1,1\n1,2\n",
        "formula": "t,q\n0,0\n1,=1+1\n",
        "quote": 't,q\n0,0\n1,"2\n',
        "NUL": b"t,q\n0,0\n1,2\0\n",
        "latin 1": "t,q\n0,0\n1,2 §\n".encode("latin-1"),
        "UTF-16": "t,q\n0,0\n1,2\n".encode("utf-16"),
        "long field": "t,q\n0,0\n1," + "9" * 200_000 + "\n",
        "underscores": "t,q\n0,0\n1,1_000\n",
        "Arabic digits": "t,q\n0,0\n1,٣\n",
        "hex": "t,q\n0,0\n1,0x10\n",
        "Fortran": "t,q\n0,0\n1,1D3\n",
        "header alone": "t,q\n",
        "mixed separators": "t;q\n0;0\n1,5;2.5\n",
        "thousands": "t;q\n0;0\n1;1.000,5\n",
    }
    for name, content in contents.items():
        data = content if isinstance(content, bytes) else content.encode()
        change = _constant(data)
        yield Fault(f"loads.csv/{name}", HALFPLANE, _with(file, change, text), True)


def _point_tables() -> Iterator[Fault]:
    file, text = "points.csv", points_case()
    for seed in range(12):
        yield Fault(f"{file}/damaged/{seed}", CHECK, _with(file, _damaging(seed), text))
    yield Fault(f"{file}/pipe", CHECK, _pipe(file, text), True)
    square = "x,y,T\n-30,-40,1\n30,-40,1\n-30,40,1\n30,40,{}\n"
    contents = {
        "empty": "",
        "header alone": "x,y,T\n",
        "one point": "x,y,T\n0,0,20\n",
        "no column T": "x,y,t\n0,0,20\n",
        "no column y": "x,T\n0,20\n",
        "nan": square.format("nan"),
        "huge": square.format("1e300"),
        "below absolute zero": square.format("-274"),
        "a point twice": square.format("1\n30,40,2"),
        "a point nearly twice": square.format("1\n30,40.0000000000001,2"),
        "elsewhere": square.replace("30", "300").replace("-300", "200").format("1"),
        "on a line through the middle of bodies": "x,y,T\n-1,0,1\n0,0,1\n1,0,1\n",
    }
    for name, content in contents.items():
        change = _constant(content.encode())
        yield Fault(f"{file}/{name}", CHECK, _with(file, change, text), True)


def _materials() -> Iterator[Fault]:
    file, text = "own.toml", material_case()
    yield Fault(f"{file}/whole", CHECK, _table(file, MATERIAL, text), False)
    for seed in range(24):

        def damage(good: Path, here: Path, seed: int = seed) -> None:
            (here / "case.toml").write_text(text)
            (here / file).write_bytes(damaged(MATERIAL.encode(), seed))

        yield Fault(f"{file}/damaged/{seed}", CHECK, damage)
    yield Fault(f"{file}/pipe", CHECK, _pipe(file, text), True)
    contents = {
        "empty": "",
        "no source": MATERIAL.replace("source", "title"),
        "no units": MATERIAL.replace("units", "title"),
        "units of nothing": MATERIAL.replace("GPa", ""),
        "units that are not known": MATERIAL.replace("kg/m^3", "stone"),
        "nan": MATERIAL.replace("0.3", "nan"),
        "huge": MATERIAL.replace("7850.0", "1e300"),
        "rubber": MATERIAL.replace("0.3", "0.5"),
        "falling": MATERIAL.replace("[0, 100]", "[100, 0]"),
        "frozen": MATERIAL.replace("[0, 100]", "[-280, 100]"),
        "deep": MATERIAL + "elastic = " + "[" * 20000 + "]" * 20000,
        "a case": text,
        "long": MATERIAL + "#" * 2_000_000,
        "itself": MATERIAL + 'material = "own.toml"\n',
    }
    for name, content in contents.items():
        yield Fault(f"{file}/{name}", CHECK, _table(file, content, text), True)


def _strain_tables() -> Iterator[Fault]:
    file, text = "strain.csv", strain_case()
    square = "x,y,exx,eyy,ezz,exy\n-30,-40,0,0,0,0\n30,-40,0,0,0,0\n-30,40,0,0,0,0\n30,40,{},0,0\n"
    yield Fault(f"{file}/whole", CHECK, _table(file, square.format("0,0"), text), False)
    for seed in range(12):

        def damage(good: Path, here: Path, seed: int = seed) -> None:
            _table(file, square.format("1e-4,0"), text)(good, here)
            (here / file).write_bytes(damaged((here / file).read_bytes(), seed))

        yield Fault(f"{file}/damaged/{seed}", CHECK, damage)
    yield Fault(f"{file}/pipe", CHECK, _pipe(file, text), True)
    contents = {
        "header alone": "x,y,exx,eyy,ezz,exy\n",
        "no column ezz": square.replace("ezz", "szz").format("0,0"),
        "shear angle": square.replace("exy", "gxy").format("0,0"),
        "a column twice": square.replace("eyy", "exx").format("0,0"),
        "nan": square.format("nan,0"),
        "huge": square.format("1e300,0"),
        "missing": square.format("1"),
        "a point twice": square.format("0,0,0,0\n30,40,0,0"),
        "elsewhere": square.replace("30", "1").format("0,0"),
        "metres": square.replace("30", ".03").replace("40", ".04").format("0,0"),
    }
    for name, content in contents.items():
        yield Fault(f"{file}/{name}", CHECK, _table(file, content, text), True)


def _shape_tables() -> Iterator[Fault]:
    file, text = "shape.csv", shape_case()
    yield Fault(f"{file}/whole", CHECK, _with(file, lambda data: data, text), False)
    for seed in range(12):
        yield Fault(f"{file}/damaged/{seed}", CHECK, _with(file, _damaging(seed), text))
    yield Fault(f"{file}/pipe", CHECK, _pipe(file, text), True)
    square = "x,y,ux,uy\n-30,-40,1,0\n30,-40,1,0\n-30,40,1,0\n30,40,{}\n"
    contents = {
        "header alone": "# x\nx,y,ux,uy\n",
        "comments alone": "# x,y,ux,uy\n#1,1,1,1\n",
        "no column uy": "x,y,ux,v\n0,0,20,1\n1,1,1,1\n",
        "nan": square.format("nan,0"),
        "huge": square.format("1e300,0"),
        "missing": square.format("1"),
        "a point twice": square.format("1,0\n30,40,2,0"),
        "elsewhere": square.replace("30", "1").format("1,0"),
        "metres": square.replace("30", ".03").replace("40", ".04").format("1,0"),
        "at rest": square.replace("1,0", "0,0").format("0,0"),
        "on another line": "x,y,ux,uy\n0,-40,1,1\n0,40,1,1\n",
    }
    for name, content in contents.items():
        change = _constant(content.encode())
        yield Fault(f"{file}/{name}", CHECK, _with(file, change, text), True)


def _factor_tables() -> Iterator[Fault]:
    """Tractions that vary over their boundary."""
    file, text = "factors.csv", factors_case()
    line = "x,y,value\n12,0,1\n12,-12,{}\n"
    yield Fault(f"{file}/whole", CHECK, _table(file, line.format("2"), text), False)
    for seed in range(12):

        def damage(good: Path, here: Path, seed: int = seed) -> None:
            _table(file, line.format("2"), text)(good, here)
            (here / file).write_bytes(damaged((here / file).read_bytes(), seed))

        yield Fault(f"{file}/damaged/{seed}", CHECK, damage)
    yield Fault(f"{file}/pipe", CHECK, _pipe(file, text), True)
    contents = {
        "empty": "",
        "header alone": "x,y,value\n",
        "one point": "x,y,value\n12,0,1\n",
        "no column value": line.replace("value", "p").format("2"),
        "a column twice": line.replace("y", "value").format("2"),
        "nan": line.format("nan"),
        "inf": line.format("inf"),
        "huge": line.format("1e200"),
        "missing": line.format(""),
        "a point twice": line.format("2\n12,-12,3"),
        "a point nearly twice": line.format("2\n12,-12.0000000000001,3"),
        "a half": line.replace("-12", "-6").format("2"),
        "metres": line.replace("12", ".012").format("2"),
    }
    for name, content in contents.items():
        yield Fault(f"{file}/{name}", CHECK, _table(file, content, text), True)


def _fields() -> Iterator[Fault]:
    """Displacements of another run: as a grid of VTK, and as a table."""
    grid, table = "run.vtu", "run.csv"
    text = field_case(grid)
    yield Fault(f"{grid}/whole", CHECK, _with(grid, lambda data: data, text), False)
    for seed in range(16):
        yield Fault(f"{grid}/damaged/{seed}", CHECK, _with(grid, _damaging(seed), text))
    yield Fault(f"{grid}/pipe", CHECK, _pipe(grid, text), True)
    replaced = {
        "no displacement": (b'"U"', b'"V"'),
        "many points": (b'NumberOfPoints="9"', b'NumberOfPoints="999999999999"'),
        "many cells": (b'NumberOfCells="4"', b'NumberOfCells="999999999999"'),
        "negative": (b'NumberOfPoints="9"', b'NumberOfPoints="-9"'),
        "entity": (b"<VTKFile", b'<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><VTKFile'),
    }
    for name, (old, new) in replaced.items():
        yield Fault(f"{grid}/{name}", CHECK, _with(grid, _replacing(old, new), text))
    text = field_case(table)
    square = "x,y,ux,uy,time\n-40,-50,1e-4,0,1\n40,-50,1e-4,0,1\n-40,50,1e-4,0,1\n40,50,{},1\n"
    contents = {
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
    }
    for name, content in contents.items():
        content = content if content.endswith("\n") else content + "\n"
        yield Fault(f"{table}/{name}", CHECK, _table(table, content, text), True)
    yield from _temperature_fields()
    yield Fault(f"{grid}/bomb", CHECK, _table(grid, _bomb(), field_case(grid)), True)


def _temperature_fields() -> Iterator[Fault]:
    """Temperatures of another run, as a table and as a result file of CalculiX."""
    table, results = "heat.csv", "heat.frd"
    text = heat_case(table)
    square = "x,y,T,time\n-40,-50,20,1\n40,-50,20,1\n-40,50,90,1\n40,50,{}\n"
    yield Fault(f"{table}/whole", CHECK, _table(table, square.format("90,1"), text), False)
    contents = {
        "nan": square.format("nan,1"),
        "too cold": square.replace("20", "-400").replace("90", "-400").format("-400,1"),
        "a point twice": square.format("90,1\n40,50,80,1"),
        "elsewhere": square.replace("40", "1").format("90,1"),
        "missing step": square.format("90,1").replace(",1\n", ",0.4\n"),
        "hot at 0": square.format("90,0").replace(",1\n", ",0\n"),
        "displacements": square.format("90,1").replace("T", "ux"),
        "cold": square.replace("90", "20").format("20,1"),
    }
    for name, content in contents.items():
        yield Fault(f"{table}/{name}", CHECK, _table(table, content, text), True)
    text, whole = heat_case(results), (DATA / "solids.frd").read_text()
    frd = {
        "solids": whole,
        "half": whole[: len(whole) // 2],
        "many nodes": whole.replace("    2C", "    2C   9999999999", 1),
        "no temperatures": whole.replace("NDTEMP", "NDTIME"),
        "nan": whole.replace("1.20000E+02", "        nan"),
    }
    for name, content in frd.items():
        yield Fault(f"{results}/{name}", CHECK, _table(results, content, text), True)


def _bomb() -> str:
    """A grid of 10^9 points in 30 MB: blocks of zeros that are compressed."""
    block, count = 1 << 26, 357
    packed = zlib.compress(bytes(block), 9)
    head = struct.pack(f"<{3 + count}I", count, block, 0, *[len(packed)] * count)
    data = (base64.b64encode(head) + base64.b64encode(packed * count)).decode()
    points = f'NumberOfPoints="{count * block // 24}" NumberOfCells="1"'
    array = '<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="{}">{}</DataArray>'
    return (
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1" '
        'byte_order="LittleEndian" header_type="UInt32" compressor="vtkZLibDataCompressor">'
        f"<UnstructuredGrid><Piece {points}><PointData>"
        f"{array.format('Float64', 'U', 3, 'ascii', '0 0 0')}</PointData>"
        f"<Points>{array.format('Float64', 'p', 3, 'binary', data)}</Points><Cells>"
        f"{array.format('Int64', 'connectivity', 1, 'ascii', '0 1 2')}"
        f"{array.format('Int64', 'offsets', 1, 'ascii', '3')}"
        f"{array.format('UInt8', 'types', 1, 'ascii', '5')}"
        "</Cells></Piece></UnstructuredGrid></VTKFile>"
    )


def _replacing(old: bytes, new: bytes) -> Change:
    return lambda data: data.replace(old, new)


def _table(file: str, content: str, text: str) -> Prepare:
    def prepare(good: Path, here: Path) -> None:
        (here / "case.toml").write_text(text)
        (here / file).write_text(content)

    return prepare


def _traction_tables() -> Iterator[Fault]:
    command = ("edges", "tractions.csv", "--friction", "0.3", "--json")
    for seed in range(24):
        change = _damaging(seed)
        yield Fault(f"tractions.csv/damaged/{seed}", command, _with("tractions.csv", change, ""))
    yield Fault("tractions.csv/pipe", command, _pipe("tractions.csv", ""), True)
    contents = {
        "no pressure": "x,p\n0,0\n1,0\n2,0\n",
        "negative": "x,p\n0,-1\n1,-2\n2,-1\n",
        "one row": "x,p\n0,1\n",
        "back": "x,p\n0,1\n-1,1\n",
        "longer": "x,p\n0,1,1,1\n1,1,1,1\n",
        "overflow": "x,p\n0,1e308\n1,1e308\n2,1e308\n3,0\n",
        "far": "x,p\n1e300,1\n1.1e300,2\n1.2e300,1\n",
        "tiny": "".join(["x,p\n", *(f"{i}e-320,{i % 5}\n" for i in range(1, 20))]),
    }
    for name, content in contents.items():
        change = _constant(content.encode())
        yield Fault(f"tractions.csv/{name}", command, _with("tractions.csv", change, ""), True)
    for words in (("--friction", "nan"), ("--friction", "-1"), ("--friction", "0"), ("--x", "")):
        prepare = _with("tractions.csv", lambda data: data, "")
        yield Fault(f"tractions.csv {words}", ("edges", "tractions.csv", *words), prepare, True)
