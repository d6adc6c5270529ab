# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fatigue data and command lines of `fretfe assess` that are damaged, hostile or contradictory."""

from __future__ import annotations

import copy
import os
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import tomli_w
from faults.fault import Fault, Prepare, damaged
from faults.originals import TESTS_TEXT
from faults.results_of import OUTPUTS, RUNS, damage, with_runs

TEXT = """source = "tests"
units = { stress = "GPa" }
young = 210.0
poisson = 0.3

[fatigue]
source = "tests"
units = { stress = "MPa", length = "m" }
limit = { range = 496.0, ratio = -1.0 }
torsion = 155.0
threshold = { range = 4.2, ratio = 0.0, walker = 0.5 }

[fatigue.growth]
factor = 1e-11
exponent = 3.0
ranges = [5.0, 50.0]
start = 1e-4
end = 2e-3
"""
GOOD = tomllib.loads(TEXT)
LIFE = {"ratio": -1.0, "cycles": [1e4, 1e5, 1e6], "amplitudes": [420.0, 330.0, 260.0]}
LAW = {
    "strength": 1165.0, "exponent": -0.081, "ductility": 1.14, "ductility_exponent": -0.67,
    "cycles": [1e2, 1e7],
}  # fmt: skip
ASSESS = ("assess", "run", "--material", "alloy.toml", "--json")
# Tables of [fatigue] that must be refused, with what they change.
REFUSED: dict[str, dict[str, Any]] = {
    "no source": {"source": None},
    "empty source": {"source": ""},
    "no units": {"units": None},
    "units of nothing": {"units": {"stress": "", "length": "m"}},
    "units of a stone": {"units": {"stress": "MPa", "length": "stone"}},
    "units without a length": {"units": {"stress": "MPa"}},
    "limit without a ratio": {"limit": {"range": 496.0}},
    "limit of R = 1": {"limit": {"range": 496.0, "ratio": 1.0}},
    "limit of R = -inf": {"limit": {"range": 496.0, "ratio": float("-inf")}},
    "limit of nothing": {"limit": {"range": 0.0, "ratio": -1.0}},
    "limit as a number": {"limit": 496.0},
    "limit with more": {"limit": {"range": 496.0, "ratio": -1.0, "mean": 0.0}},
    "torsion larger than tension": {"torsion": 300.0},
    "torsion of a brittle alloy": {"torsion": 100.0},
    "torsion without a limit": {"limit": None},
    "torsion at another R": {"limit": {"range": 248.0, "ratio": 0.0}},
    "threshold without Walker": {"threshold": {"range": 4.2, "ratio": 0.0}},
    "threshold of both kinds": {
        "threshold": {
            "range": 4.2,
            "ratio": 0.0,
            "walker": 0.5,
            "ratios": [0.0, 0.5],
            "ranges": [4.0, 3.0],
        }
    },
    "threshold of one ratio": {"threshold": {"ratios": [0.0], "ranges": [4.0]}},
    "threshold of falling ratios": {"threshold": {"ratios": [0.5, 0.0], "ranges": [4.0, 3.0]}},
    "threshold of a ratio twice": {"threshold": {"ratios": [0.0, 0.0], "ranges": [4.0, 3.0]}},
    "threshold of other lengths": {"threshold": {"ratios": [0.0, 0.5], "ranges": [4.0, 3.0, 2.0]}},
    "threshold of R = 1": {"threshold": {"ratios": [0.0, 1.0], "ranges": [4.0, 3.0]}},
    "threshold below zero": {"threshold": {"ratios": [0.0, 0.5], "ranges": [4.0, -3.0]}},
    "threshold of nothing": {"threshold": {}},
    "growth of both kinds": {"growth": {**GOOD["fatigue"]["growth"], "rates": [1e-9, 1e-8]}},
    "growth backwards": {"growth": {**GOOD["fatigue"]["growth"], "start": 3e-3}},
    "growth of falling rates": {
        "growth": {"ranges": [5.0, 50.0], "rates": [1e-8, 1e-9], "start": 1e-4, "end": 1e-3}
    },
    "growth of three ranges": {
        "growth": {**GOOD["fatigue"]["growth"], "ranges": [5.0, 10.0, 50.0]}
    },
    "growth from nothing": {"growth": {**GOOD["fatigue"]["growth"], "start": 0.0}},
    "growth of steep law": {"growth": {**GOOD["fatigue"]["growth"], "exponent": 300.0}},
    "life without a ratio": {"life": {"cycles": [1e4, 1e6], "amplitudes": [400.0, 300.0]}},
    "life of rising amplitudes": {"life": {**LIFE, "amplitudes": [300.0, 350.0, 400.0]}},
    "life of equal amplitudes": {"life": {**LIFE, "amplitudes": [300.0, 300.0, 300.0]}},
    "life of falling cycles": {"life": {**LIFE, "cycles": [1e6, 1e5, 1e4]}},
    "life of other lengths": {"life": {**LIFE, "cycles": [1e4, 1e6]}},
    "life of one test": {"life": {"ratio": -1.0, "cycles": [1e5], "amplitudes": [300.0]}},
    "life of no cycles": {"life": {**LIFE, "cycles": [0.0, 1e5, 1e6]}},
    "life of less than a cycle": {"life": {**LIFE, "cycles": [1e-3, 1e5, 1e6]}},
    "life of endless cycles": {"life": {**LIFE, "cycles": [1e4, 1e5, 1e99]}},
    "life of R = 1": {"life": {**LIFE, "ratio": 1.0}},
    "life of nothing": {"life": {}},
    "life of cycles alone": {"life": {"cycles": [1e4, 1e6]}},
    "life of both kinds": {"life": {**LIFE, **LAW}},
    "law without ductility": {"life": {k: v for k, v in LAW.items() if k != "ductility"}},
    "law that rises": {"life": {**LAW, "exponent": 0.1}},
    "law of no slope": {"life": {**LAW, "ductility_exponent": 0.0}},
    "law of three lives": {"life": {**LAW, "cycles": [1e2, 1e4, 1e7]}},
    "law of strength below zero": {"life": {**LAW, "strength": -1000.0}},
    "law of a steep slope": {"life": {**LAW, "exponent": -300.0}},
    "life as a number": {"life": 1e6},
    "limit of R = 0.99": {"limit": {"range": 5.0, "ratio": 0.99}, "torsion": None},
    "tiny limit": {"limit": {"range": 1e-30, "ratio": -1.0}, "torsion": None},
    "huge limit": {"limit": {"range": 1e30, "ratio": -1.0}, "torsion": None},
    "tiny threshold": {"threshold": {"range": 1e-30, "ratio": 0.0, "walker": 0.5}},
    "huge threshold": {"threshold": {"range": 1e30, "ratio": 0.0, "walker": 0.5}},
    "growth of long cracks": {"growth": {**GOOD["fatigue"]["growth"], "end": 1e20}},
    "lives of short tests, below the limit": {"life": {**LIFE, "amplitudes": [3.0, 2.0, 1.0]}},
    "lives of weak tests, below the limit": {"life": {**LIFE, "amplitudes": [3e-30, 2e-30, 1e-30]}},
    "lives of steps, below the limit": {"life": {**LIFE, "amplitudes": [300.0, 299.9999999, 1.0]}},
    "a law of steps, below the limit": {
        "life": {**LAW, "exponent": -5.0, "ductility_exponent": -5.0}
    },
    "another key": {"thresholds": {"range": 4.2}},
}
NO_LIMIT = {"limit": None, "torsion": None}
# Read, with margins or the reasons why there are none; they must not be silent.
ACCEPTED: dict[str, dict[str, Any]] = {
    "whole": {},
    "nothing but a limit": {"torsion": None, "threshold": None, "growth": None},
    "nothing at all": {"limit": None, "torsion": None, "threshold": None, "growth": None},
    "threshold at R = -100": {"threshold": {"range": 4.2, "ratio": -100.0, "walker": 0.5}},
    "threshold near R = 1": {"threshold": {"range": 4.2, "ratio": 0.999999, "walker": 2.0}},
    "threshold without R": {"threshold": {"range": 4.2, "ratio": 0.0, "walker": 0.0}},
    "table of high ratios": {"threshold": {"ratios": [0.7, 0.8], "ranges": [3.0, 2.0]}},
    "limit of R = -100": {"limit": {"range": 500.0, "ratio": -100.0}, "torsion": None},
    "tiny growth": {"growth": {**GOOD["fatigue"]["growth"], "factor": 1e-30}},
    "huge growth": {"growth": {**GOOD["fatigue"]["growth"], "factor": 1e30}},
    "growth elsewhere": {"growth": {**GOOD["fatigue"]["growth"], "ranges": [1e-20, 1e-19]}},
    "growth of atoms": {"growth": {**GOOD["fatigue"]["growth"], "start": 1e-30}},
    "steps of rates": {
        "growth": {"ranges": [5.0, 5.0000001], "rates": [1e-9, 1e-3], "start": 1e-4, "end": 1e-3}
    },
    "life": {"life": LIFE},
    "life by a law": {"life": LAW},
    "lives of short tests": {"life": {**LIFE, "amplitudes": [3.0, 2.0, 1.0]}, **NO_LIMIT},
    "lives of strong tests": {"life": {**LIFE, "amplitudes": [3e29, 2e29, 1e29]}},
    "lives of weak tests": {"life": {**LIFE, "amplitudes": [3e-30, 2e-30, 1e-30]}, **NO_LIMIT},
    "lives of steps": {"life": {**LIFE, "amplitudes": [300.0, 299.9999999, 1.0]}, **NO_LIMIT},
    "lives at R = -100": {"life": {**LIFE, "ratio": -100.0}},
    "a law of steps": {"life": {**LAW, "exponent": -5.0, "ductility_exponent": -5.0}, **NO_LIMIT},
    "life without a limit": {"life": LIFE, "limit": None, "torsion": None},
    "life without a threshold": {"life": LIFE, "threshold": None},
    "life of half a cycle": {"life": {**LAW, "cycles": [0.5, 0.50001]}},
    "units of inches": {"units": {"stress": "ksi", "length": "in"}},
}
# In place of a number of the table; none is one.
VALUES: dict[str, Any] = {
    "text": "a", "nan": float("nan"), "inf": float("inf"), "minus": -1e9, "list": [],
    "true": True, "date": tomllib.loads("a = 2020-01-01")["a"],
}  # fmt: skip
WORDS: dict[str, tuple[str, ...]] = {
    "no material": ("assess", "run"),
    "a material that is not there": ("assess", "run", "--material", "nothing.toml"),
    "a material by its name": ("assess", "run", "--material", "steel"),
    "results as a material": ("assess", "run", "--material", "run/results.json"),
    "a folder as a material": ("assess", "run", "--material", "run"),
    "a device as a material": ("assess", "run", "--material", "/dev/zero"),
    "no results": ("assess", "--material", "alloy.toml"),
    "a file as results": ("assess", "alloy.toml", "--material", "alloy.toml"),
    "nothing as others": ("assess", "run", "nothing", "--material", "alloy.toml"),
    "solids as others": ("assess", "run", "solid", "--material", "alloy.toml"),
    "metres as others": ("assess", "run", "metres", "--material", "alloy.toml"),
    "tests without a life": (*ASSESS, "--tests", "tests.csv"),
    "a life without tests": (*ASSESS, "--life", "1e6"),
    "no tests": (*ASSESS, "--tests", "nothing.csv", "--life", "1e6"),
    "results as tests": (*ASSESS, "--tests", "run/results.json", "--life", "1e6"),
    "a margin of text": (*ASSESS, "--at-least", "many"),
    "a margin of nan": (*ASSESS, "--at-least", "nan"),
    "stress below zero": ("export", "run", "-o", "out", "--depth", "-1"),
    "stress at nan": ("export", "run", "-o", "out", "--depth", "nan"),
    "stress at 90 degrees": ("export", "run", "-o", "out", "--depth", "0.1", "--angle", "90"),
    "angles alone": ("export", "run", "-o", "out", "--angle", "20"),
    "stress in solids": ("export", "solid", "-o", "out", "--depth", "0.1"),
}  # fmt: skip


def faults() -> Iterator[Fault]:
    """All of them."""
    for name, changed in ACCEPTED.items():
        yield Fault(f"fatigue/{name}", ASSESS, _with(changed), False)
    for name, changed in REFUSED.items():
        yield Fault(f"fatigue/{name}", ASSESS, _with(changed), True)
    for path in (("limit", "range"), ("limit", "ratio"), ("torsion",), ("threshold", "range"),
                 ("threshold", "walker"), ("growth", "exponent"), ("growth", "end")):  # fmt: skip
        for kind, value in VALUES.items():
            yield Fault(f"fatigue/{'.'.join(path)}: {kind}", ASSESS, _at(path, value), True)
    for seed in range(30):
        content = damaged(TEXT.encode(), seed)
        yield Fault(f"fatigue/damaged/{seed}", ASSESS, with_runs(_file(content)))
    yield Fault(
        "fatigue/pipe", ASSESS, with_runs(lambda here: os.mkfifo(here / "alloy.toml")), True
    )
    for name in RUNS:
        command = ("assess", name, *ASSESS[2:])
        # Labels of units must be known, and bodies plane.
        yield Fault(f"assess/of {name}", command, _with({}), name in ("metres", "solid"))
    for name, words in WORDS.items():
        yield Fault(f"assess/{name}", words, _with({}), True)
    for name, output, work in OUTPUTS:
        yield Fault(f"assess/into {name}", (*ASSESS, "-o", output), _with({}, work), True)
    for seed in range(8):
        yield Fault(f"assess/of damaged/{seed}", ASSESS, _with({}, damage("run", seed)))


def _with(changed: dict[str, Any], *works: Callable[[Path], object]) -> Prepare:
    """The file with other keys of [fatigue]; None leaves one out."""
    table = {k: v for k, v in {**GOOD["fatigue"], **changed}.items() if v is not None}
    return with_runs(_file(tomli_w.dumps({**GOOD, "fatigue": table}).encode()), *works)


def _at(path: tuple[str, ...], value: Any) -> Prepare:
    tables = copy.deepcopy(GOOD)
    table = tables["fatigue"]
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    return with_runs(_file(tomli_w.dumps(tables).encode()))


def _file(content: bytes) -> Callable[[Path], object]:
    def write(here: Path) -> None:
        (here / "alloy.toml").write_bytes(content)
        (here / "tests.csv").write_text(TESTS_TEXT)

    return write
