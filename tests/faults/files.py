# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes and drawings that are damaged or hostile."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import h5py
import numpy as np
from faults.changed import Change, pipe, replaced, seeded, with_file
from faults.fault import CHECK, Fault, damaged
from faults.originals import DRAWINGS, GRIDS, MESHES


def faults() -> Iterator[Fault]:
    """All of them, and the files as they should be."""
    for file in (*MESHES, *GRIDS, *DRAWINGS):
        yield Fault(f"{file}/whole", CHECK, with_file(file), False)
    yield from _meshes()
    yield from _drawings()


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
        yield from seeded(file, range(100 * place, 100 * place + 14))
        yield Fault(f"{file}/pipe", CHECK, pipe(file), True)
        yield Fault(f"{file}/empty", CHECK, with_file(file, content=b""), True)
    for name, text in {
        "nan": b"nan 1 0", "inf": b"inf 1 0", "huge": b"1e200 1 0", "words": b"a b c",
        "missing": b"", "out of the plane": b"0 0 5",
    }.items():  # fmt: skip
        change: Change = partial(_node, text)
        yield Fault(f"pad22.msh/node: {name}", CHECK, with_file("pad22.msh", change), True)
    for factor in (1e-200, 1e-60, 1e60, 1e200, 0.0):
        change = _scaled(factor)
        yield Fault(f"pad22.msh/scaled by {factor:g}", CHECK, with_file("pad22.msh", change), True)
    script = b'SystemCall "touch ../escaped";\nSave "escaped.msh";\n'
    options = b"$Options\nMesh.SaveAll = 1;\n$EndOptions\n" + script
    for name, change in {
        "same names": replaced(b'"upper_top"', b'"lower_bottom"'),
        "bodies of the same name": replaced(b'"upper"', b'"lower"'),
        "a name that is a path": replaced(b'"upper"', b'"../../escaped"'),
        "a name of 5000": replaced(b'"upper"', b'"' + b"x" * 5000 + b'"'),
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
        yield Fault(f"pad22.msh/{name}", CHECK, with_file("pad22.msh", change), refused)
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
            with_file("pad.inp", change)(good, here)
            os.mkfifo(here / "pipe")
            (here / "loop.inp").write_text("*INCLUDE, INPUT=pad.inp\n")

        yield Fault(f"pad.inp/{name}", CHECK, write, True)
    placed = with_file("pad.inp", lambda data: _placed(data, INSTANCE))
    yield Fault("pad.inp/placed", CHECK, placed, False)
    for seed in range(14):
        change = partial(_damaged_instance, seed)
        yield Fault(f"pad.inp/placed and damaged/{seed}", CHECK, with_file("pad.inp", change))


def _damaged_instance(seed: int, data: bytes) -> bytes:
    """Mistakes in what is around the mesh."""
    head, tail = _placed(data, INSTANCE + TURN + b"360\n").split(data)
    return head + data + damaged(tail, seed)


def _grids() -> Iterator[Fault]:
    for file in GRIDS:
        yield from seeded(file, range(800, 812))
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
            with_file("pad.xdmf", change)(good, here)
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
            with_file("pad.xdmf")(good, here)

        yield Fault(f"pad.h5/damaged/{seed}", CHECK, write_h5)
    for name, value in (("nan", np.nan), ("inf", np.inf), ("link", None), ("text", "a")):

        def write_value(good: Path, here: Path, value: object = value) -> None:
            with_file("pad.xdmf")(good, here)
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
        yield from seeded(file, range(2000 + 100 * place, 2000 + 100 * place + count))
        # Whole at both ends, wrong in between.
        for seed in range(14 if file.startswith("pad") else 6):

            def inside(data: bytes, seed: int = seed) -> bytes:
                third = len(data) // 3
                return data[:third] + damaged(data[third:-third], seed) + data[-third:]

            yield Fault(f"{file}/inside/{seed}", CHECK, with_file(file, inside))
        yield Fault(f"{file}/pipe", CHECK, pipe(file), True)
        for name, content in (("empty", b""), ("random", bytes(range(256)) * 40)):
            yield Fault(f"{file}/{name}", CHECK, with_file(file, content=content), True)
