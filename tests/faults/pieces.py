# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies in pieces, keywords that join parts, units, encodings, lost digits, limits of memory."""

from __future__ import annotations

import copy
import json
import shutil
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from cases.pieces_of_cells import KINDS, Cells
from faults.fault import CHECK, HALFPLANE, Fault, Prepare, text_fault
from faults.files import with_places
from faults.originals import PAD, RIG_TEXT, csv_case
from faults.results_of import with_runs

from fretfe.mesh.elements import FACET_SHAPES, directed_facets, exterior_facets
from fretfe.mesh.make import write_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh

RESUME = (*HALFPLANE, "--resume")
STEEL = {"young": 210e3, "poisson": 0.3}


def faults() -> Iterator[Fault]:
    """All of them."""
    yield from _bodies()
    yield from _decks()
    yield from _places()
    yield from _units()
    yield from _tables()
    yield from _values_twice()
    yield from _notes()
    yield from _rigs()


# --- bodies in pieces ---------------------------------------------------------------------------


def _halves(cell: str, order: int, shift: float = 0.0, finer: int = 1) -> Cells:
    n = 2 * finer
    cells = Cells(cell, order).brick((0.0, 0.0, 0.0), (1.0, 1.0, 1.0), 2, 2, 2)
    return cells.brick((1.0 + shift, 0.0, 0.0), (2.0 + shift, 1.0, 1.0), n, n, n)


def _slit(cell: str, order: int) -> Cells:
    cells = _halves(cell, order)
    for z in (0.0, 0.5, 1.0) if cells.dimension == 3 else (0.0,):
        for y in (0.0, 0.5):
            cells.joined((1.0, y, z)[: cells.dimension])
    return cells


def _whole(cell: str, order: int) -> Cells:
    return Cells(cell, order).brick((0.0, 0.0, 0.0), (2.0, 1.0, 1.0), 4, 2, 2)


# Pads, whether they are refused, and whether they are with merging.
PADS: dict[str, tuple[Callable[[str, int], Cells], bool, bool]] = {
    "whole": (_whole, False, False),
    "halves": (_halves, True, False),
    "halves, nearly": (lambda cell, order: _halves(cell, order, 1e-6), True, False),
    "slit": (_slit, True, False),
    "hanging": (lambda cell, order: _halves(cell, order, finer=2), True, True),
    "overlapping": (lambda cell, order: _halves(cell, order, -0.4), True, True),
}


def _case_of_pad(dimension: int, **geometry: Any) -> str:
    press = {"type": "platen", "boundary": "pad_top", "direction": "y", "control": "force",
             "history": [{"ramp": -1.0, "until": 1.0, "steps": 1}]}  # fmt: skip
    contact = {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.3}
    fix = ["x", "y", "z"][:dimension]
    return tomli_w.dumps(
        {
            "geometry": {"file": "pad.msh", **geometry},
            "model": {"degree": 1},
            "bodies": {"pad": STEEL, "block": STEEL},
            "contacts": {"main": contact},
            "supports": {"base": {"boundary": "block_bottom", "fix": fix}},
            "loads": {"press": press},
        }
    )


def _write_case(
    make: Callable[[str, int], Cells],
    cell: str,
    order: int,
    merge: float | None,
    good: Path,
    here: Path,
) -> None:
    pad = make(cell, order)
    _write_pad(pad, here / "pad.msh")
    table = {} if merge is None else {"merge": merge}
    (here / "case.toml").write_text(_case_of_pad(pad.dimension, **table))


def _write_pad(pad: Cells, path: Path) -> None:
    """The pad, whatever is wrong with it, on a whole block, as a Gmsh file."""
    block = Cells(pad.cell, pad.order).brick((0.0, -1.0, 0.0), (2.0, 0.0, 1.0), 3, 2, 2)
    bodies = {"pad": _unchecked(pad, "pad", (0.0, 1.0))}
    bodies["block"] = _unchecked(block, "block", (-1.0, 0.0))
    write_mesh(Mesh(bodies), path)


def _unchecked(cells: Cells, name: str, heights: tuple[float, float]) -> BodyMesh:
    raw = cells.raw(name)
    ((block,),) = raw.bodies.values()
    used, nodes = np.unique(block.nodes, return_inverse=True)
    nodes = nodes.reshape(block.nodes.shape)
    points = raw.points[used][:, : cells.dimension]
    outside, _ = exterior_facets(
        directed_facets(nodes, cells.cell, cells.order), FACET_SHAPES[cells.cell]
    )
    middles = points[outside].mean(axis=1)[:, 1]
    sides = {
        f"{name}_{side}": outside[np.abs(middles - height) < 1e-9]
        for side, height in zip(("bottom", "top"), heights, strict=True)
    }
    return BodyMesh(name, points, nodes, cells.cell, cells.order, sides)


def _bodies() -> Iterator[Fault]:
    for cell, order in KINDS:
        for name, (make, refused, merged) in PADS.items():
            for merge, bad in ((None, refused), (1e-4, merged)):
                prepare = partial(_write_case, make, cell, order, merge)
                what = f"{name}/{cell} {order}" + (", merged" if merge else "")
                yield Fault(f"pieces/{what}", CHECK, prepare, bad)
    for merge in (0.0, -1.0, 0.9, 1e-40, float("nan")):

        def collapse(good: Path, here: Path, merge: float = merge) -> None:
            _write_pad(_halves("triangle", 1), here / "pad.msh")
            (here / "case.toml").write_text(_case_of_pad(2, merge=merge))

        yield Fault(f"pieces/merge = {merge:g}", CHECK, collapse, True)
    tables = {**PAD, "geometry": {**PAD["geometry"], "merge": 1e-6}}
    yield text_fault("pieces/merge of a template", CHECK, tomli_w.dumps(tables), True)


# --- decks --------------------------------------------------------------------------------------

JOINING = (
    "*TIE, NAME=T\nA, B", "*MPC\nTIE, 3, 5", "*EQUATION\n2\n3, 1, 1., 5, 1, -1.",
    "*EMBEDDED ELEMENT\nUPPER", "*EMBEDDEDELEMENT\nUPPER", "*RIGID BODY, REF NODE=1, ELSET=UPPER",
    "*COUPLING, REF NODE=1, SURFACE=S", "*KINEMATIC COUPLING, REF NODE=1\n2", "*tie\na, b",
    "*DISTRIBUTING COUPLING, ELSET=E\n1, 1.", "*SHELL TO SOLID COUPLING\nA, B",
    "*CONTACT PAIR, TIED\nA, B", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED",
    "*PRE-TENSION SECTION, SURFACE=S", "*CYCLIC SYMMETRY MODEL, N=4", "*SPRING, ELSET=E\n\n1",
    "*MODEL CHANGE, REMOVE\nUPPER", "*IMPERFECTION, FILE=F\n1, .1", "*NETWORK MPC\n1, 2",
    "*SUBSTRUCTURE PROPERTY, ELSET=E", "*ELEMENT, TYPE=SPRINGA, ELSET=E\n999999, 1, 2",
    "*ELEMENT, TYPE=COH2D4, ELSET=E\n999999, 1, 2, 3, 4", "*ELEMENT, TYPE=CONN2D2\n999999, 1, 2",
    "*EQUA\n2\n3, 1, 1., 5, 1, -1.", "*TI, NAME=T\nA, B", "*NSET, NSET=N, GENRATE\n1, 2, 1",
    "*ELEMENT, TYPE=CINPE4\n999999, 1, 2, 3, 4", "*ELEMENT, TYPE=GAPUNI\n999999, 1, 2",
)  # fmt: skip
# Of bodies to which the case gives none.
CONSTANTS = (
    ("*ELASTIC\n2e5, .3", False), ("*ELASTIC\n2e5, .3, 20.\n1e5, .3, 99.", False), ("", True),
    ("*ELASTIC\n2e5, .3, 99.\n1e5, .3, 20.", True),
    ("*ELASTIC\n-2e5, .3", True), ("*ELASTIC\n2e5, .5", True), ("*ELASTIC\nnan, .3", True),
    ("*ELASTIC\n2e5", True), ("*ELASTIC, TYPE=LAMINA\n1, 1, .3, 1, 1, 1", True),
    ("*ELASTIC\nsteel", True), ("*ELASTIC\n2e5, .3\n*DENSITY\n-1.", True),
    ("*ELASTIC\n2e5, .3\n*EXPANSION, ZERO=-400.\n1e-5", True), ("*DENSITY\n1.", True),
)  # fmt: skip
PASSED = (
    "*MATERIAL, NAME=M\n*ELASTIC\n1., .3", "*STEP\n*STATIC\n*END STEP", "*BOUNDARY\n1, 1, 2",
    "*CONTACT PAIR, INTERACTION=I\nA, B", "*SOLID SECTION, ELSET=UPPER, MATERIAL=M",
    "*A KEYWORD OF TOMORROW\n1, 2", "*ELEMENT, TYPE=MASS, ELSET=M\n999999, 1",
    "** *TIE in a comment", "*NSET, NSET=N\nNONE", "*SURFACE, NAME=F, TYPE=SEGMENTS\nSTART, 0., 0.",
)  # fmt: skip


def _decks() -> Iterator[Fault]:
    for lines, refused in [
        *((each, True) for each in JOINING),
        *((each, False) for each in PASSED),
    ]:

        def write(good: Path, here: Path, lines: str = lines) -> None:
            (here / "pad.inp").write_bytes((good / "pad.inp").read_bytes() + f"{lines}\n".encode())
            (here / "case.toml").write_text(_with_file("pad.inp"))

        yield Fault(f"deck/{lines.splitlines()[0]}", CHECK, write, refused)

    def latin(good: Path, here: Path) -> None:
        deck = (good / "pad.inp").read_bytes() + b"*NSET, NSET=Fl\xe4che\n1\n"
        (here / "pad.inp").write_bytes(deck)
        (here / "case.toml").write_text(_with_file("pad.inp"))

    yield Fault("deck/latin 1", CHECK, latin, True)
    for constants, refused in CONSTANTS:

        def bare(good: Path, here: Path, constants: str = constants) -> None:
            sections = "".join(
                f"*SOLID SECTION, ELSET={name}, MATERIAL=M\n" for name in ("UPPER", "LOWER")
            )
            text = f"*MATERIAL, NAME=M\n{constants}\n{sections}"
            (here / "pad.inp").write_bytes((good / "pad.inp").read_bytes() + text.encode())
            tables = {**PAD, "model": {"degree": 1}, "geometry": {"file": "pad.inp"}}
            (here / "case.toml").write_text(
                tomli_w.dumps({**tables, "bodies": {"upper": {}, "lower": {}}})
            )

        yield Fault(f"deck/constants: {constants}", CHECK, bare, refused)


def _with_file(file: str, **more: Any) -> str:
    return tomli_w.dumps({**PAD, "model": {"degree": 1}, "geometry": {"file": file, **more}})


# --- places and names ---------------------------------------------------------------------------


def _changed_mesh(change: Callable[[bytes], bytes]) -> Prepare:
    def write(good: Path, here: Path) -> None:
        (here / "pad22.msh").write_bytes(change((good / "pad22.msh").read_bytes()))
        (here / "case.toml").write_text(_with_file("pad22.msh"))

    return write


def _moved(offset: float, axis: int = 0) -> Callable[[bytes], bytes]:
    def move(places: list[float]) -> list[float]:
        return [place + offset * (number == axis) for number, place in enumerate(places)]

    return with_places(move)


def _places() -> Iterator[Fault]:
    for offset in (1e9, 1e12, 1e15, -1e10, 1e29):
        for axis in (0, 1):
            name = f"places/offset {offset:g} in {'xy'[axis]}"
            yield Fault(name, CHECK, _changed_mesh(_moved(offset, axis)), True)
    for offset in (1e3, 1e5):
        yield Fault(f"places/offset {offset:g}", CHECK, _changed_mesh(_moved(offset)), False)
    for group in ("upper", "upper_top", "lower_contact"):

        def rename(data: bytes, group: str = group) -> bytes:
            return data.replace(f'"{group}"'.encode(), f'"{group[:-1]}ü"'.encode("latin-1"))

        yield Fault(f"places/name in latin 1: {group}", CHECK, _changed_mesh(rename), True)
    for cell, order in KINDS:

        def one_facet(good: Path, here: Path, cell: str = cell, order: int = order) -> None:
            pad = Cells(cell, order).brick((0.5, 0.0, 0.0), (1.5, 1.0, 1.0), 1, 2, 1)
            _write_pad(pad, here / "pad.msh")
            (here / "case.toml").write_text(_case_of_pad(pad.dimension))

        yield Fault(f"places/one facet, {cell} {order}", CHECK, one_facet, False)
    for size in (1e-5, 2e-5):
        table = {**PAD["geometry"]["parameters"], "zone": 6.0, "size": size, "growth": 0.03}
        text = tomli_w.dumps({**PAD, "geometry": {**PAD["geometry"], "parameters": table}})
        yield text_fault(f"places/ten million elements of {size:g}", CHECK, text, True)


# --- units --------------------------------------------------------------------------------------

LABELS = {"m": 1e3, "cm": 10.0, "um": 1e-3, "in": 25.4, "ft": 304.8, "mm": 1.0}


def in_unit(tables: dict[str, Any], label: str) -> dict[str, Any]:
    """The pad with its lengths in another unit; a force is one per length."""
    changed: dict[str, Any] = copy.deepcopy(tables)
    parameters = changed["geometry"]["parameters"]
    for name in parameters.keys() - {"growth"}:
        parameters[name] /= LABELS[label]
    changed["units"] = {"length": label}
    for load in changed["loads"].values():
        for segment in load["history"]:
            for key in segment.keys() & {"ramp", "amplitude"}:
                segment[key] /= LABELS[label]
    return changed


def _units() -> Iterator[Fault]:
    for label in LABELS:
        text = tomli_w.dumps(in_unit(PAD, label))
        commands = {"check": CHECK, "half-planes": HALFPLANE}
        for name, command in commands.items():
            yield text_fault(f"units/{label}/{name}", command, text, False)
        if label not in ("mm", "cm"):
            wrong = tomli_w.dumps({**PAD, "units": {"length": label}})
            name = f"units/numbers in mm called {label}"
            yield text_fault(name, HALFPLANE, wrong, None if label == "in" else True)


# --- tables of loads ----------------------------------------------------------------------------


def _tables() -> Iterator[Fault]:
    rows = "".join(f"{i / 2},{i % 5}\n" for i in range(25))
    contents: dict[str, tuple[str | bytes, bool]] = {
        "quoted header": ('"t","q"\n' + rows, False),
        "quoted header and semicolons": ('"t";"q"\n' + rows.replace(",", ";"), False),
        "quoted header and tabs": ('"t"\t"q"\n' + rows.replace(",", "\t"), False),
        "quoted header with a comma": ('"t";"q";"q, N"\n' + rows.replace(",", ";"), False),
        "quoted header with spaces": ('"t", "q", "a b"\n' + rows, False),
        "quote that does not end": ('"t,q\n' + rows, True),
        "quote within a name": ('t"t",q\n' + rows, True),
        "number of 1e-320": ("t,q\n0,0\n1,1e-320\n2,0\n", True),
        "time of 1e-320": ("t,q\n0,0\n1e-320,1\n2,0\n", True),
        "number of 5e-324": ("t,q\n0,0\n1,-5e-324\n2,0\n", True),
        "a million and one rows": ("t,q\n" + "".join(f"{i},0\n" for i in range(1_000_001)), True),
        "latin 1": (b"t,q\n0,0\n1,2\n" + "2,3,ü\n".encode("latin-1"), True),
        "latin 1 in the header": ("t,q,Schlüssel\n0,0,0\n1,2,0\n".encode("latin-1"), True),
        "UTF-16": (("t,q\n" + rows).encode("utf-16"), True),
        "UTF-32": (("t,q\n" + rows).encode("utf-32"), True),
    }
    for name, (content, refused) in contents.items():
        data = content if isinstance(content, bytes) else content.encode()

        def write(good: Path, here: Path, data: bytes = data) -> None:
            (here / "case.toml").write_text(csv_case())
            (here / "loads.csv").write_bytes(data)

        yield Fault(f"tables/{name}", HALFPLANE, write, refused)


# --- values -------------------------------------------------------------------------------------

TINY = ("loads.shear.history.2.amplitude", "loads.press.ramp", "contacts.main.friction",
        "bodies.upper.young", "model.thickness", "loads.shear.history.2.period",
        "geometry.parameters.size", "contacts.main.friction_from")  # fmt: skip
TWICE = (
    ("contacts.main.friction=0.3", "contacts.main.friction=0.3"),
    ("contacts.main.friction=0.3", "contacts.main.friction=0.4"),
    ("bodies.*.young=1e5", "bodies.upper.young=2e5"),
    ("bodies.upper.young=2e5", "bodies.*.young=1e5"),
    ("loads.shear.amplitude=10", "loads.shear.history.2.amplitude=20"),
    ("loads.shear.history.2.amplitude=20", "loads.*.history.*.amplitude=10"),
    ("bodies.upper.young=2e5", "bodies.upper={young=1e5, poisson=0.3}"),
    ("title=a", "title=b"),
)


def _values_twice() -> Iterator[Fault]:
    text = tomli_w.dumps(PAD)
    for key in TINY:
        for value in ("1e-320", "-1e-320"):
            command = (*HALFPLANE, "--set", f"{key}={value}")
            yield text_fault(f"values/{key} = {value}", command, text, True)
    sweep = ("sweep", "case.toml", "-o", "out", "--backend", "halfplane", "-q")
    for first, second in TWICE:
        commands: dict[str, tuple[str, ...]] = {
            f"--set {first} --set {second}": (*HALFPLANE, "--set", first, "--set", second),
            f"--vary {first} --vary {second}": (
                *(*sweep, "--vary", f"{first},{first.partition('=')[2]}"),
                *("--vary", second),
            ),
            f"--set {first} --vary {second}": (*sweep, "--set", first, "--vary", second),
        }
        for name, words in commands.items():
            yield text_fault(f"values/{name}", words, text, True)


# --- notes of runs ------------------------------------------------------------------------------

NOTES: dict[str, str] = {
    "empty": "",
    "50000 brackets": "[" * 50_000,
    "50000 closed brackets": "[" * 50_000 + "]" * 50_000,
    "50000 braces": '{"a":' * 50_000 + "1" + "}" * 50_000,
    "table": "{}",
    "list": "[]",
    "null": "null",
    "schema alone": json.dumps({"schema": {"name": "fretfe-run", "version": 1}}),
    "another schema": json.dumps({"schema": {"name": "fretfe-run", "version": 99}}),
    "brackets in the case": '{"schema": {"name": "fretfe-run", "version": 1}, "doing": "solving", '
    '"complete": false, "case": ' + "[" * 900 + "]" * 900 + "}",
}


def _notes() -> Iterator[Fault]:
    text = tomli_w.dumps(PAD)
    for name, note in NOTES.items():

        def write(good: Path, here: Path, note: str = note) -> None:
            (here / "case.toml").write_text(text)
            (here / "out").mkdir()
            (here / "out" / "run.json").write_text(note)

        yield Fault(f"run.json/{name}/resume", RESUME, write, True)
        yield Fault(f"run.json/{name}/run", HALFPLANE, write, False)

        def spoil(good: Path, here: Path, note: str = note) -> None:
            shutil.copytree(good / "run", here / "run")
            (here / "run" / "run.json").write_text(note)

        yield Fault(f"run.json/{name}/report", ("report", "run"), spoil, True)

    def lock(good: Path, here: Path) -> None:
        (here / "case.toml").write_text(text)
        (here / "out").mkdir()
        (here / "out" / "run.lock").write_text("[" * 50_000)

    yield Fault("run.lock/50000 brackets", HALFPLANE, lock, False)


# --- rigs ---------------------------------------------------------------------------------------


def _rigs() -> Iterator[Fault]:
    words = ("match", "run", "--edge", "main.left", "--rig", "rig.toml", "-o", "out")
    for old, new in (
        ("thickness = 12.0", "thickness = 1e-6"),
        ("thickness = 12.0", "thickness = 1e-320"),
        ("height = 12.0", "height = 1e-6"),
        ("yield_stress = 900.0", "yield_stress = 1e-320"),
    ):
        rig = RIG_TEXT.replace(old, new)

        def write(here: Path, rig: str = rig) -> None:
            (here / "rig.toml").write_text(rig)

        refused = None if new.endswith("1e-6") else True
        yield Fault(f"rigs/{new}", words, with_runs(write), refused)
