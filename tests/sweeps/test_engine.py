# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sweeps with backends that need no mesh: order, failures, records, table and pictures."""

from __future__ import annotations

import csv
import math
import os
import signal
import time
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
from cases import pad_cases
from cases.pad_cases import press, shear
from harness.told import Told
from rich.console import Console

from fretfe.backends import Backend, Observer, RunOptions
from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.backends.protocol import DEFAULTS, Session
from fretfe.case import Case, changed, parse_case
from fretfe.errors import ConvergenceError
from fretfe.results.model import Result
from fretfe.sweeps import Sweep, make_variants, run_sweep
from fretfe.sweeps.figures import write_sweep
from fretfe.sweeps.table import sweep_table, write_files

FRICTION, AMPLITUDE = "contacts.main.friction", "loads.shear.amplitude"
RADIUS = "geometry.parameters.upper_radius"


def pad(**changed: Any) -> dict[str, Any]:
    """The pad in few steps and elements: a sweep asks a backend for numbers, good ones or not."""
    loads = {"press": press(steps=1), "shear": shear(steps=4)}
    tables = {"geometry": pad_cases.cylinder(size=0.1), "loads": loads}
    return pad_cases.pad(**{**tables, **changed})


def swept(**ranges: Any) -> Sweep:
    keys = {"friction": FRICTION, "amplitude": AMPLITUDE, "radius": RADIUS, "shape": "title"}
    named = {keys[name]: values for name, values in ranges.items()}
    return run_sweep(make_variants(parse_case(pad()), named), HALFPLANE, DEFAULTS)


def test_rows_are_those_of_single_runs() -> None:
    sweep = swept(friction=(0.4, 0.5), amplitude=(20.0, 60.0))
    assert sweep.keys == (FRICTION, AMPLITUDE)
    expected = []
    for friction in (0.4, 0.5):
        for amplitude in (20.0, 60.0):
            values = {FRICTION: friction, AMPLITUDE: amplitude}
            result = HALFPLANE.solve(changed(parse_case(pad()), values))
            expected += [{**values, **edge, "failure": ""} for edge in result.edges()]
    found = sweep.records()
    assert all(each.pop("seconds") > 0 for each in found)
    assert found == expected
    assert len(found) == 8


def test_what_cannot_be_solved_says_why_and_keeps_nothing_from_being_solved() -> None:
    sweep = swept(friction=(0.05, 0.4))
    failed, solved = sweep.variants
    assert "expected |Q| < f P" in failed.failure and not failed.edges
    assert not solved.failure and len(solved.edges) == 2
    assert sweep.failures == (failed,)
    assert [record.get("edge") for record in sweep.records()] == [None, "left", "right"]


@dataclass
class Recording(Backend, Session):
    """A backend that shares what has the same radius, and cannot finish a radius of 40."""

    summary = "records what it is asked for"
    solved: list[tuple[float, float]] = field(default_factory=list)
    closed: int = 0

    def supports(self, case: Case) -> tuple[str, ...]:
        return ()

    def session(self) -> Recording:
        return self

    def group(self, case: Case) -> str:
        return str(case.geometry.parameters["upper_radius"])

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        radius = case.geometry.parameters["upper_radius"]
        friction = case.contacts["main"].friction
        assert isinstance(friction, float)
        self.solved.append((friction, radius))
        result = HALFPLANE.solve(case, options)
        failure = ConvergenceError("step 3 failed") if radius == 40 else None
        return replace(result, failure=failure)

    def close(self) -> None:
        self.closed += 1


def test_cases_that_share_the_most_are_solved_in_a_row_and_listed_in_order() -> None:
    backend, told = Recording(), Told()
    variants = make_variants(parse_case(pad()), {FRICTION: (0.4, 0.5), RADIUS: (50, 40)})
    sweep = run_sweep(variants, backend, RunOptions(observer=told))
    assert backend.solved == [(0.4, 50), (0.5, 50), (0.4, 40), (0.5, 40)]
    assert backend.closed == 1
    assert [tuple(each.values.values()) for each in sweep.variants] == [
        (0.4, 50), (0.4, 40), (0.5, 50), (0.5, 40)
    ]  # fmt: skip
    # a history that was not finished has no cycle: nothing of it counts
    assert [each.failure for each in sweep.variants] == ["", "step 3 failed"] * 2
    assert [len(each.edges) for each in sweep.variants] == [2, 0, 2, 0]
    assert told.announced[0].startswith(f"1/4: {FRICTION} = 0.4, {RADIUS} = 50: ")
    assert told.announced[2] == f"3/4: {FRICTION} = 0.4, {RADIUS} = 40: failed: step 3 failed"


@dataclass
class Copied(Recording):
    """One of which three copies can be made; some frictions end a copy, or wait for its end."""

    parent: int = field(default_factory=os.getpid)
    deadly: float = math.nan
    endless: float = math.nan

    def copies(self) -> int:
        return 3

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        friction = case.contacts["main"].friction
        if friction == self.deadly and os.getpid() != self.parent:
            os._exit(1)
        while friction == self.endless:
            time.sleep(0.01)
            options.progress(1, 2, "")
        return super().solve(case, options)


FRICTIONS = (0.4, 0.5, 0.6, 0.7, 0.8)


def in_copies(backend: Copied, observer: Observer | None = None) -> Sweep:
    variants = make_variants(parse_case(pad()), {FRICTION: FRICTIONS})
    return run_sweep(variants, backend, RunOptions(observer=observer or Told()))


def test_copies_solve_cases_beside_one_another() -> None:
    backend = Copied()
    sweep = in_copies(backend)
    # The others are solved by copies of the backend.
    assert backend.solved == [(0.4, 50)]
    assert [each.values[FRICTION] for each in sweep.variants] == list(FRICTIONS)
    # Texts, since a length that does not exist is no number.
    assert [str(dict(each.edges[0])) for each in sweep.variants] == [
        str(dict(each.edges[0])) for each in swept(friction=FRICTIONS).variants
    ]


def test_a_copy_that_ends_leaves_its_cases_to_others() -> None:
    backend = Copied(deadly=0.5)
    sweep = in_copies(backend)
    assert [friction for friction, _ in backend.solved][:2] == [0.4, 0.5]
    assert not sweep.failures


def test_a_signal_ends_copies_and_keeps_what_they_have_solved() -> None:
    class Signalled(Told):
        def stop(self) -> signal.Signals | None:
            return signal.SIGTERM if len(self.announced) == 4 else None

    sweep = in_copies(Copied(endless=0.8), Signalled())
    assert sweep.stopped is not None and sweep.stopped.signal is signal.SIGTERM
    assert [bool(each.failure) for each in sweep.variants] == [False] * 4 + [True]
    assert "stopped by SIGTERM" in sweep.variants[-1].failure


def test_csv_holds_all_records(tmp_path: Path) -> None:
    sweep = swept(friction=(0.05, 0.4))
    assert write_files(sweep, tmp_path)
    with (tmp_path / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 3
    assert list(rows[0])[:3] == [FRICTION, "contact", "edge"]
    assert list(rows[0])[-2:] == ["seconds", "failure"]
    assert rows[0]["k_n"] == "" and "expected |Q| < f P" in rows[0]["failure"]
    for row, record in zip(rows[1:], sweep.records()[1:], strict=True):
        for name, value in record.items():
            if isinstance(value, float):
                assert row[name] == "" if math.isnan(value) else float(row[name]) == value
            else:
                assert row[name] == str(value)


def test_numbers_that_do_not_exist_are_empty(tmp_path: Path) -> None:
    case = parse_case(pad(loads={"press": pad()["loads"]["press"], "shear": ramp(30.0)}))
    sweep = run_sweep(make_variants(case, {FRICTION: (0.4,)}), HALFPLANE, DEFAULTS)
    write_files(sweep, tmp_path)
    with (tmp_path / "sweep.csv").open(newline="") as file:
        row = next(csv.DictReader(file))
    # One half cycle and no cycle: no range, one zone.
    assert [row[name] for name in ("k_t_range", "slip_1", "predicted_1")] == [""] * 3
    assert float(row["slip_2"]) > 0 and float(row["predicted_2"]) > 0


def ramp(force: float) -> dict[str, Any]:
    history = [{"hold": True, "until": 1.0}, {"ramp": force, "until": 2.0, "steps": 4}]
    return {**pad()["loads"]["shear"], "history": history}


@pytest.mark.parametrize(
    ("ranges", "drawn"),
    [
        ({"friction": (0.4, 0.5)}, True),
        ({"friction": (0.4,)}, True),
        ({"shape": ("a", "b")}, True),
        ({"friction": (0.05, 0.4, 0.5), "amplitude": (20, 60)}, True),
        ({"friction": (0.4, 0.5), "shape": ("a", "b")}, True),
        ({"friction": (0.4,), "amplitude": (20,), "radius": (50, 60)}, True),
        ({"friction": (0.01, 0.02)}, False),
    ],
    ids=["line", "one value", "text", "two keys", "two keys with text", "three keys", "failed"],
)
def test_picture(tmp_path: Path, ranges: dict[str, Any], drawn: bool) -> None:
    sweep, path = swept(**ranges), tmp_path / "sweep.png"
    assert write_sweep(path, sweep.keys, sweep.records(), sweep.units) == drawn
    assert path.exists() == drawn


def test_old_picture_goes(tmp_path: Path) -> None:
    (tmp_path / "sweep.png").write_text("old")
    assert not write_files(swept(friction=(0.01,)), tmp_path)
    assert not (tmp_path / "sweep.png").exists()


def test_table_shows_what_was_solved_and_what_was_not() -> None:
    console = Console(width=120)
    with console.capture() as capture:
        console.print(sweep_table(swept(friction=(0.05, 0.4))))
    lines = capture.get().splitlines()
    assert any("0.05" in line and "failed" in line for line in lines)
    assert sum("main" in line and "0.4 " in line for line in lines) == 2


@pytest.mark.parametrize(("part", "marks"), [(0.09, 0), (0.11, 2)])
def test_table_marks_vague_slip_zones(
    monkeypatch: pytest.MonkeyPatch, part: float, marks: int
) -> None:
    sweep = swept(friction=(0.4,))
    records = [{**each, "slip_2_spread": part * each["slip_2"]} for each in sweep.records()]
    monkeypatch.setattr(type(sweep), "records", lambda _: records)
    console = Console(width=120)
    with console.capture() as capture:
        console.print(sweep_table(sweep))
    assert capture.get().count("~") == marks
