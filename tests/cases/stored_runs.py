# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of runs on disk, as `fretfe run` leaves them, of backends that need no DOLFINx."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import h5py
from cases.pad_cases import HOLD, TOP, pad, press, shear

from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.case import Case, parse_case
from fretfe.errors import ConvergenceError
from fretfe.loads import History, build_history
from fretfe.results.model import Result
from fretfe.results.run_folder import KEY, with_digest
from fretfe.results.writer import write_results

# Shear that only grows: no cycle.
GROWING = {**TOP, "direction": "x", "history": [HOLD, {"ramp": 60.0, "until": 2.0, "steps": 5}]}
CYCLE = pad(loads={"press": press(), "shear": shear(steps=8)})
NO_CYCLE = pad(loads={"press": press(), "shear": GROWING})
# Name of a run: case, and whether its last steps have no solution.
RUNS: dict[str, tuple[dict[str, Any], bool]] = {
    "halfplane": (CYCLE, False),
    "no cycle": (NO_CYCLE, False),
    "incomplete": (CYCLE, True),
}
REASON = "step 12 of 20 did not converge: <b>for a test</b>"


@cache
def solved(name: str) -> Result:
    """A run."""
    tables, fails = RUNS[name]
    case = parse_case(tables)
    history = build_history(case)
    if fails:
        history = History(history.channels, history.times[:12], history.values[:12], None)
    result = replace(HALFPLANE.solve(case, RunOptions(history=history)), backend="halfplane")
    return replace(result, failure=ConvergenceError(REASON)) if fails else result


def write_run(folder: Path, name: str, case: Case | None = None) -> Path:
    """Write the results of a run into a folder, perhaps as those of another case."""
    folder.mkdir(parents=True, exist_ok=True)
    result = solved(name)
    write_results(folder, replace(result, case=case or result.case))
    return folder


def edit_numbers(folder: Path, edit: Callable[[dict[str, Any]], object]) -> None:
    """Change `results.json` as if a run had written it so."""
    path = folder / "results.json"
    numbers = json.loads(path.read_text("utf-8"))
    edit(numbers)
    del numbers[KEY]
    path.write_text(json.dumps(with_digest(numbers)), "utf-8")


def write_many_contacts(folder: Path, count: int) -> Path:
    """The results of a run with one contact as those of one with several."""
    one = write_run(folder / "one", "halfplane")
    names = [f"tooth_{i}" for i in range(count)]

    def multiply(numbers: dict[str, Any]) -> None:
        case = numbers["case"]["contacts"].pop("main")
        results = numbers["contacts"].pop("main")
        for name in names:
            surfaces = {f"surface{side}": f"{name}_{side}" for side in (1, 2)}
            numbers["case"]["contacts"][name] = {**case, **surfaces}
            numbers["contacts"][name] = {**results, "pair": name}

    for file in ("results.json", "results.h5"):
        shutil.copy(one / file, folder)
    edit_numbers(folder, multiply)
    with h5py.File(folder / "results.h5", "r+") as arrays:
        for name in names:
            arrays.copy("contacts/main", arrays["contacts"], name=name)
            arrays[f"contacts/{name}"].attrs["pair"] = name
    return folder
