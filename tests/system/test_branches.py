# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that go on from a state of another run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import BASE, HOLD, PAD, TOP, cylinder, pad, press

import fretfe
from fretfe.case import Case, parse_case
from fretfe.errors import FretfeError
from fretfe.results.model import Result

UP, DOWN = {"ramp": 100.0, "until": 2.0, "steps": 2}, {"ramp": -100.0, "until": 4.0, "steps": 3}
RUNNING_IN = {"times": [0.0, 2.0, 2.001, 4.0], "values": [0.3, 0.3, 0.6, 0.6]}


def tables(folder: Path | None = None, size: float = 0.06, **main: Any) -> dict[str, Any]:
    """A pad that is pressed on, pushed and pulled; from a folder on it goes on from time 2."""
    shear = {**TOP, "direction": "x", "control": "force", "history": [HOLD, UP, DOWN]}
    known = pad(
        geometry=cylinder(size=size),
        contacts={"main": {**PAD["contacts"]["main"], "friction": 0.3, **main}},
        loads={"press": press(), "shear": shear},
        supports=BASE,
    )
    return known if folder is None else known | {"start": {"from": str(folder), "time": 2.0}}


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("first")
    fretfe.run(parse_case(tables()), output=folder)
    return folder


def largest_difference(one: Result, other: Result) -> float:
    """That of tractions, over the largest, and of slip, over the largest."""
    pairs = zip(one.solution.contacts, other.solution.contacts, strict=True)
    arrays = ((getattr(a, n), getattr(b, n)) for a, b in pairs for n in ("traction", "slip"))
    return max(float(np.abs(x[:] - y[:]).max() / np.abs(x[:]).max()) for x, y in arrays)


def test_a_branch_is_the_run_that_was_not_interrupted(first: Path) -> None:
    branch = fretfe.run(parse_case(tables(first, friction=0.6)))
    whole = fretfe.run(parse_case(tables(friction=RUNNING_IN)))
    assert largest_difference(whole, branch) < 1e-11
    for mine, theirs in zip(whole.contacts[0].stations, branch.contacts[0].stations, strict=True):
        zones = zip(mine.slip_zones, theirs.slip_zones, strict=True)
        for one, other in zones:
            assert one.length == pytest.approx(other.length, rel=1e-9, nan_ok=True)
    assert np.allclose(whole.contacts[0].work, branch.contacts[0].work, rtol=1e-9)


def test_slip_stays_when_a_layer_comes(first: Path) -> None:
    stiff = fretfe.run(parse_case(tables(first, layer={"normal": 1e9, "tangential": 1e9})))
    bare = fretfe.run(parse_case(tables(first)))
    assert largest_difference(bare, stiff) < 1e-3
    soft = fretfe.run(parse_case(tables(first, layer={"normal": 1e4, "tangential": 1e4})))
    assert largest_difference(bare, soft) > 0.02
    one, other = (np.asarray(each.solution.contacts[0].slip[:4]) for each in (bare, soft))
    assert np.array_equal(one, other)


WRONG = {
    "other nodes": ({"size": 0.05}, "expected the mesh of that run"),
    "no run": ({"folder": Path("nowhere")}, "start.from"),
}


@pytest.mark.parametrize(("changes", "expected"), WRONG.values(), ids=WRONG)
def test_what_is_no_branch_is_refused(first: Path, changes: dict[str, Any], expected: str) -> None:
    with pytest.raises(FretfeError, match=expected):
        fretfe.run(parse_case(tables(**{"folder": first, **changes})))


def changed(first: Path, key: str, value: Any) -> Case:
    known = tables(first)
    *path, last = key.split(".")
    table: Any = known
    for name in path:
        table = table[int(name)] if name.isdigit() else table[name]
    table[last] = value
    return parse_case(known)


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("bodies.upper.young", 100e3, "expected bodies.upper.young of that run, 210000"),
        (
            "loads.shear.history.1.ramp",
            90.0,
            "loads.shear.history: expected the loads of start.from",
        ),
        ("loads.shear.history.1.steps", 4, "found steps at other times"),
        ("loads.shear.direction", "y", "loads.shear.direction"),
        ("start.time", 2.1, "start.time: expected the time of a step"),
        ("edges", {"tolerance": 0.05}, "expected no edges.tolerance"),
    ],
)
def test_other_models_and_loads_are_refused(
    first: Path, key: str, value: Any, expected: str
) -> None:
    with pytest.raises(FretfeError, match=expected):
        fretfe.run(changed(first, key, value))
