# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rig files, edges and tests of `fretfe match` that are damaged, hostile or of something else."""

from __future__ import annotations

import copy
import os
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import tomli_w
from faults.fault import Fault, Prepare, damaged
from faults.originals import RIG_TEXT, leaves
from faults.results_of import OUTPUTS, RUNS, blocked, damage, with_runs

RIG = tomllib.loads(RIG_TEXT)
Edit = Callable[[dict[str, Any]], object]
# In place of a value; none is one that a rig can have.
VALUES: dict[str, Any] = {
    "text": "a",
    "nan": float("nan"),
    "inf": float("inf"),
    "huge": 1e31,
    "tiny": 1e-31,
    "list": [],
    "table": {"a": 1},
    "true": True,
    "400 digits": 10**400,
    "date": tomllib.loads("a = 2020-01-01")["a"],
}
BOUNDS = {
    "one": [1.0],
    "three": [1.0, 2.0, 3.0],
    "number": 5.0,
    "the larger first": [7.0, 6.0],
    "nan": [1.0, float("nan")],
    "inf": [1.0, float("inf")],
    "minus": [-5.0, 5.0],
    "texts": ["1", "2"],
    "nested": [[1.0, 2.0]],
}
# Of a rig, but of none that is made.
EXTREME: dict[str, dict[str, Any]] = {
    "radii of all sizes": {"pad": {"radius": [1e-30, 1e30]}},
    "flats of all sizes": {"pad": {"flat_half_width": [1e-30, 1e30]}},
    "tiny radii": {"pad": {"radius": [1e-30, 1e-29]}},
    "huge radii": {"pad": {"radius": [1e29, 1e30]}},
    "tiny flats": {"pad": {"flat_half_width": [1e-30, 1e-29]}},
    "huge flats": {"pad": {"flat_half_width": [1e29, 1e30]}},
    "soft": {"pad": {"young": 1e-30}, "specimen": {"young": 1e-30}},
    "stiff": {"pad": {"young": 1e30}, "specimen": {"young": 1e30}},
    "soft on stiff": {"pad": {"young": 1e-30}, "specimen": {"young": 1e30}},
    "incompressible": {"pad": {"poisson": 0.4999999999}, "specimen": {"poisson": 0.4999999999}},
    "auxetic": {"pad": {"poisson": -0.9999999999}, "specimen": {"poisson": -0.9999999999}},
    "tiny pad": {"pad": {"half_width": 1e-30, "height": 1e-30}},
    "huge pad": {"pad": {"half_width": 1e30, "height": 1e30}},
    "tiny specimen": {"specimen": {"half_width": 1e-30, "thickness": 1e-30}},
    "huge specimen": {"specimen": {"half_width": 1e30, "thickness": 1e30}},
    "weak": {"specimen": {"yield_stress": 1e-30}},
    "strong": {"specimen": {"yield_stress": 1e30}},
    "forces of all sizes": {"forces": {"normal": [1e-30, 1e30], "shear": [0.0, 1e30]}},
    "no shear": {"forces": {"shear": [0.0, 0.0]}},
    "huge forces": {"forces": {"normal": [1e29, 1e30]}},
    "normal amplitudes of all sizes": {"forces": {"normal_amplitude": [0.0, 1e30]}},
    "normal amplitudes that are not needed": {"forces": {"normal_amplitude": [50.0, 60.0]}},
    "huge bulk range": {"forces": {"bulk_range": 1e30}},
    "tiny bulk range": {"forces": {"bulk_range": 1e-30}},
    "bulk range that does all": {"forces": {"bulk_range": 200.0}},
    "turned bulk stress": {"forces": {"bulk_range": 50.0, "bulk_phase": 1e30}},
    "opposite bulk stress": {"forces": {"bulk_range": 50.0, "bulk_phase": 180.0}},
}
# No rigs at all, or of other units or friction.
REFUSED: dict[str, Edit] = {
    "unknown table": lambda rig: rig.update(machine={}),
    "unknown key": lambda rig: rig["pad"].update(radios=[1.0, 2.0]),
    "no pad": lambda rig: rig.pop("pad"),
    "no forces": lambda rig: rig.pop("forces"),
    "no radius": lambda rig: rig["pad"].pop("radius"),
    "no flat": lambda rig: rig["pad"].pop("flat_half_width"),
    "no angle": lambda rig: rig["pad"].pop("angle"),
    "no shapes": lambda rig: rig["pad"].update(shapes=[]),
    "unknown shape": lambda rig: rig["pad"].update(shapes=["sphere"]),
    "shape is a path": lambda rig: rig["pad"].update(shapes=["../../escaped"]),
    "metres": lambda rig: rig.update(units={"length": "m"}),
    "kilonewtons": lambda rig: rig.update(units={"force": "kN"}),
    "pascals": lambda rig: rig.update(units={"stress": "Pa"}),
    "unknown unit": lambda rig: rig.update(units={"mass": "kg"}),
    "other friction": lambda rig: rig.update(friction=0.5),
    "cycles and bulk stress": lambda rig: rig["forces"].update(
        normal_amplitude=[0.0, 9.0], bulk_range=9.0
    ),
    "wedge of 90 degrees": lambda rig: rig["pad"].update(shapes=["wedge"], angle=[90.0, 90.0]),
    "wedge of 1000 degrees": lambda rig: rig["pad"].update(
        shapes=["wedge"], angle=[1000.0, 1000.0]
    ),
}
TEXTS: dict[str, str | bytes] = {
    "empty": "",
    "one line": "title = 'rig'\n",
    "no TOML": "pad: 5\n",
    "a case": "[geometry]\ntemplate = 'cylinder'\n",
    "byte order mark, twice": b"\xef\xbb\xbf\xef\xbb\xbf" + RIG_TEXT.encode(),
    "UTF-16": RIG_TEXT.encode("utf-16"),
    "latin 1": RIG_TEXT.replace('"rig"', '"Prüfstand"').encode("latin-1"),
    "NUL": RIG_TEXT.encode() + b"\0",
    "nested": "a = " + "[" * 20000,
    "pad twice": RIG_TEXT + "\n[pad]\nyoung = 1.0\n",
}
EDGES = (
    "", ".", "main.", ".left", "main.up", "MAIN.LEFT", "main.left ", "main.left.right",
    "other.left", "../main.left", "[red]main.left[/red]", "main.left\nmain.right", "x" * 5000,
    "main.0", "0", "nan", "main left", "main/left", "maın.left",
)  # fmt: skip


def faults() -> Iterator[Fault]:
    """All of them."""
    yield Fault("rig.toml/whole", _match(), with_runs(_text(RIG_TEXT)), False)
    for seed in range(40):
        data = damaged(RIG_TEXT.encode(), seed)
        yield Fault(f"rig.toml/damaged/{seed}", _match(), with_runs(_text(data)))
    for name, text in TEXTS.items():
        yield Fault(f"rig.toml/{name}", _match(), with_runs(_text(text)), True)
    yield Fault(
        "rig.toml/pipe", _match(), with_runs(lambda here: os.mkfifo(here / "rig.toml")), True
    )
    yield Fault(
        "rig.toml/folder", _match(), with_runs(lambda here: (here / "rig.toml").mkdir()), True
    )
    yield Fault("rig.toml/missing", _match(), with_runs(), True)
    yield from _values()
    for name, edit in REFUSED.items():
        yield Fault(f"rig.toml/{name}", _match(), with_runs(_edited(edit)), True)
    for name, tables in EXTREME.items():
        yield Fault(f"rig.toml/{name}", _match(), with_runs(_merged(tables)))
    for edge in EDGES:
        yield Fault(
            f"match/edge {edge[:40]!r}", _match(edge=edge), with_runs(_text(RIG_TEXT)), True
        )
    yield from _components()
    yield from _tests()
    for name, output, prepare in OUTPUTS:
        words = _match(output=output)
        yield Fault(f"match/into {name}", words, with_runs(_text(RIG_TEXT), prepare), True)
    for name in ("match.json", "match.png", "cylinder.toml"):
        yield Fault(
            f"match/{name} is a folder", _match(), with_runs(_text(RIG_TEXT), blocked(name)), True
        )


def _match(
    component: str = "run",
    edge: str = "main.left",
    output: str = "out",
    tests: tuple[str, ...] = (),
) -> tuple[str, ...]:
    words = ("match", component, "--edge", edge, "--rig", "rig.toml", "-o", output)
    return words + tuple(word for each in tests for word in ("--against", each))


def _text(content: str | bytes) -> Callable[[Path], object]:
    data = content if isinstance(content, bytes) else content.encode()
    return lambda here: (here / "rig.toml").write_bytes(data)


def _edited(edit: Edit) -> Callable[[Path], object]:
    rig = copy.deepcopy(RIG)
    edit(rig)
    return _text(tomli_w.dumps(rig))


def _merged(tables: dict[str, Any]) -> Callable[[Path], object]:
    def edit(rig: dict[str, Any]) -> None:
        for name, values in tables.items():
            rig[name].update(values)

    return _edited(edit)


def _replaced(path: tuple[Any, ...], value: Any) -> Prepare:
    def edit(rig: dict[str, Any]) -> None:
        table: Any = rig
        for key in path[:-1]:
            table = table[key]
        table[path[-1]] = value

    return with_runs(_edited(edit))


def _values() -> Iterator[Fault]:
    """Another value for a key; all kinds for one key, and for one pair of bounds."""
    for path in leaves(RIG)[1:]:
        key = ".".join(map(str, path))
        names = VALUES if path == ("pad", "height") else ("text", "nan", "huge")
        for name in names:
            prepare = _replaced(path, VALUES[name])
            yield Fault(f"rig.toml/{key}: {name}", _match(), prepare, True)
    for name, value in BOUNDS.items():
        prepare = _replaced(("pad", "radius"), value)
        yield Fault(f"rig.toml/pad.radius: {name}", _match(), prepare, True)
    for key in ("young", "thickness", "half_width", "yield_stress"):
        for number in (0.0, -1.0):
            prepare = _replaced(("specimen", key), number)
            yield Fault(f"rig.toml/specimen.{key}: {number:g}", _match(), prepare, True)
    for number in (-1.0, 0.5, 7.0):
        prepare = _replaced(("specimen", "poisson"), number)
        yield Fault(f"rig.toml/specimen.poisson: {number:g}", _match(), prepare, True)


def _components() -> Iterator[Fault]:
    """Components that have nothing to match, or are none."""
    for name in ("solid", "incomplete", "no_cycle", "metres", "nothing"):
        words = _match(name)
        yield Fault(f"match/component {name}", words, with_runs(_text(RIG_TEXT)), True)
    yield Fault("match/component is a file", _match("rig.toml"), with_runs(_text(RIG_TEXT)), True)


def _tests() -> Iterator[Fault]:
    """Tests that are none, or of something else."""
    good = with_runs(_text(RIG_TEXT))
    for name in RUNS:
        refused = name not in ("run", "other_load")
        yield Fault(f"match/against {name}", _match(tests=(name,)), good, refused)
    for name in ("nothing", "rig.toml", "", ".", "/dev/null"):
        yield Fault(f"match/against {name!r}", _match(tests=(name,)), good, True)
    yield Fault("match/against itself, twice", _match(tests=("run", "run")), good, None)
    yield Fault("match/against it by two paths", _match(tests=("run", "./run/../run")), good, None)
    for seed in range(12):
        prepare = with_runs(_text(RIG_TEXT), damage("other_load", seed))
        yield Fault(f"match/against damaged/{seed}", _match(tests=("other_load",)), prepare)
