# SPDX-License-Identifier: LGPL-3.0-or-later
"""Long histories: states on disk, cycles that are not solved again, what the results keep."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, loop, problem, started
from cases.pad_cases import HOLD, TOP, pad, press
from cases.stored_runs import RUNS, solved, write_run

from fretfe._typing import Array
from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND
from fretfe.case import parse_case
from fretfe.errors import ConvergenceError, OutputError
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import Repeat, Solution
from fretfe.history.state_array import MOST_STATES, StateArray, blocks, mapped, part
from fretfe.history.stream import StateStream
from fretfe.report.theme import BINS, envelope
from fretfe.results import writer
from fretfe.results.reader import load_result
from fretfe.results.run_folder import with_digest
from fretfe.results.writer import write_results

STEPS = 12
RNG = np.random.default_rng(5)


def test_an_array_on_disk_is_that_in_memory(tmp_path: Path) -> None:
    rows = RNG.normal(size=(1000, 7, 2))
    stream = StateStream(tmp_path)
    for row in rows:
        stream.append({"a": row, "b": row[0, :0]})
    order = RNG.permutation(1000)
    array = stream.rows("a", order, slice(2, 6))
    there = rows[order, 2:6]
    assert (array.shape, len(array), array.dtype) == (there.shape, 1000, there.dtype)
    for key in (3, -1, slice(5, 900, 7), [4, 4, 1], (slice(None), 0), (-2, slice(1, 3), 1), ...):
        np.testing.assert_array_equal(array[key], there[key])
    np.testing.assert_array_equal(array[there[:, 0, 0] > 0, 1:], there[there[:, 0, 0] > 0, 1:])
    np.testing.assert_array_equal(np.asarray(array), there)
    np.testing.assert_array_equal(2 * array > 1, 2 * there > 1)
    np.testing.assert_array_equal(part(array, 1)[5:9], there[5:9, :, 1])
    doubled = mapped(array, lambda values, states: values * states[:, None, None])
    np.testing.assert_array_equal(doubled[[7, 3]], there[[7, 3]] * [[[7]], [[3]]])
    assert stream.rows("b", order, slice(None)).shape == (1000, 0)


def test_the_last_state_is_there_before_it_is_written(tmp_path: Path) -> None:
    """And a change of what was read does not change it."""
    rows = RNG.normal(size=(40, 7, 2))
    stream = StateStream(tmp_path)
    for number, row in enumerate(rows):
        stream.append({"a": row})
        for part_of_row in (slice(None), slice(2, 5)):
            found = stream.read("a", np.array([number]), part_of_row)
            np.testing.assert_array_equal(found, rows[number : number + 1, part_of_row])
            found[:] = 0.0
    assert not next(tmp_path.iterdir()).stat().st_size
    np.testing.assert_array_equal(stream.read("a", np.arange(40)), rows)
    np.testing.assert_array_equal(stream.read("a", np.arange(30, 38)), rows[30:38])


def test_the_files_are_seen_in_a_folder_only(tmp_path: Path) -> None:
    stream = StateStream(tmp_path / "states")
    stream.append({"a": np.arange(3.0)})
    assert stream.flush()["a"].blocks == ((0, 1, zlib.crc32(np.arange(3.0).tobytes())),)
    (path,) = (tmp_path / "states").iterdir()
    assert (path.name, path.stat().st_size) == ("states.rows", 24)
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="expected a place for the states"):
        StateStream(tmp_path / "file" / "states")


@pytest.mark.parametrize("size", [1, 1000, 10**7])
def test_blocks_hold_every_state_once(size: int) -> None:
    parts = list(blocks(777, size))
    assert [state for each in parts for state in range(777)[each]] == list(range(777))
    assert max(each.stop - each.start for each in parts) <= MOST_STATES


def cycles(shear: Array, *, until_steady: bool = True) -> Solution:
    given = problem(LOAD, shear, cycle=STEPS)
    return solve_half_planes(given, 60, until_steady=until_steady).solution


def test_a_steady_cycle_is_not_solved_again() -> None:
    shear = started(0.6 * LIMIT * np.cos(loop(STEPS, 6)))
    known, every = cycles(shear), cycles(shear, until_steady=False)
    # 5 steps press, 7 begin; the first cycle still has the first loading behind it.
    assert every.repeats == ()
    (repeat,) = known.repeats
    assert (repeat.last, repeat.period) == (len(shear) + 5, STEPS)
    assert repeat.first <= 12 + 2 * STEPS
    np.testing.assert_array_equal(known.source[repeat.first :], repeat.source)
    assert set(repeat.source) == set(range(repeat.first - STEPS, repeat.first))
    for mine, other in zip(known.contacts, every.contacts, strict=True):
        for name in ("traction", "mean_traction", "gap", "slip", "dissipation"):
            wanted = np.asarray(getattr(other, name))
            size = 1e-9 * np.abs(wanted).max()
            assert np.asarray(getattr(mine, name)) == pytest.approx(wanted, abs=size)
        np.testing.assert_array_equal(np.asarray(mine.status), np.asarray(other.status))
    (found,), (expected,) = evaluate(known), evaluate(every)
    for one, two in zip(found.stations, expected.stations, strict=True):
        assert one.k_t_range == pytest.approx(two.k_t_range, rel=1e-9)
        zones = [[zone.length for zone in each.slip_zones] for each in (one, two)]
        assert zones[0] == pytest.approx(zones[1], rel=1e-9)
    assert found.dissipation == pytest.approx(expected.dissipation, rel=1e-9)


def test_what_follows_repeated_cycles_is_solved() -> None:
    shear = started(0.6 * LIMIT * np.cos(loop(STEPS, 5)))
    end = 0.6 * LIMIT * np.linspace(1.0, -0.2, 6)[1:]
    known = cycles(np.concatenate([shear, end]))
    every = cycles(np.concatenate([shear, end]), until_steady=False)
    (repeat,) = known.repeats
    assert repeat.last == len(shear) + 5
    np.testing.assert_allclose(
        known.contacts[0].traction[-1], every.contacts[0].traction[-1], atol=1e-9
    )


@pytest.mark.parametrize("growth", [1e-8, -1e-8])
def test_cycles_that_change_are_all_solved(growth: float) -> None:
    angles = loop(STEPS, 4)
    shear = started(0.6 * LIMIT * np.cos(angles) * (1 + growth * angles))
    assert cycles(shear).repeats == ()


def test_a_load_that_is_held_is_solved_twice_at_most() -> None:
    shear = np.concatenate([started(np.array([0.3 * LIMIT])), np.full(9, 0.3 * LIMIT)])
    (repeat,) = cycles(shear).repeats
    assert (repeat.period, repeat.last) == (1, len(shear) + 5)


def wave(cycles: int, **tables: object) -> dict[str, object]:
    """The pad under a sine of eight steps a cycle."""
    segment = {
        "wave": "sine", "amplitude": 60.0, "period": 1.0, "cycles": cycles, "steps_per_cycle": 8
    }  # fmt: skip
    shear = {**TOP, "direction": "x", "history": [HOLD, segment]}
    return {**pad(loads={"press": press(), "shear": shear}), **tables}


def test_repeats_are_told(tmp_path: Path) -> None:
    result = replace(BACKEND.solve(parse_case(wave(4))), backend="halfplane")
    (repeat,) = result.solution.repeats
    assert repeat.text in result.notes
    assert f"steps {repeat.first} to {repeat.last} repeat steps" in repeat.text
    write_results(tmp_path, result)
    found = load_result(tmp_path)
    assert found.solution.repeats == (repeat,)


def test_a_stop_keeps_what_was_solved() -> None:
    class Stopping:
        def step(self, number: int, count: int, text: str) -> None: ...

        def announce(self, text: str) -> None: ...

        def stop(self) -> signal.Signals | None:
            return signal.SIGINT

    result = BACKEND.solve(parse_case(wave(3)), RunOptions(observer=Stopping()))  # type: ignore[arg-type]
    assert isinstance(result.failure, ConvergenceError)
    assert len(result.solution.times) == len(result.solution.contacts[0].traction) == 2


@pytest.mark.parametrize("wanted", ["all", "cycle", "extremes"])
def test_tractions_are_kept_as_wanted(tmp_path: Path, wanted: str) -> None:
    case = parse_case({**RUNS["halfplane"][0], "output": {"tractions": wanted}})
    result = solved("halfplane")
    found = load_result(write_run(tmp_path, "halfplane", case))
    first, last = found.loads.cycle or (0, 0)
    states = found.solution.kept
    assert (states is None) == (wanted == "all")
    states = np.arange(last + 1) if states is None else states
    assert {0, last - 1, last} <= set(states.tolist())
    assert found.solution.keeps(first, last) == (wanted != "extremes")
    mine, other = found.contact_history("main"), result.contact_history("main")
    for name in ("traction", "mean_traction", "gap", "slip", "status", "dissipation"):
        np.testing.assert_array_equal(getattr(mine, name)[states], getattr(other, name)[states])
    for each in ("k_t", "position"):
        mine_left, other_left = (run.history("main", "left") for run in (found, result))
        np.testing.assert_array_equal(mine_left[each], other_left[each])
    if wanted != "all":
        with pytest.raises(OutputError, match=r"traction in state 2, found only .* tractions"):
            mine.traction[2]
        with pytest.raises(OutputError, match="found only"):
            np.asarray(mine.status)
    assert dict(found.to_xarray().sizes).get("kept") == (None if wanted == "all" else len(states))


def test_lists_of_a_long_history_are_arrays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    short = json.loads((write_run(tmp_path / "short", "halfplane") / "results.json").read_text())
    monkeypatch.setattr(writer, "LONG", 10)
    folder = write_run(tmp_path / "long", "halfplane")
    text = (folder / "results.json").read_text("utf-8")
    numbers = json.loads(text)
    assert numbers["times"] == "results.h5:lists/times"
    assert numbers["contacts"]["main"]["fronts"][0]["stations"][0]["k_n"].endswith(
        "/main/fronts/0/stations/0/k_n"
    )
    assert len(text) < len(json.dumps(short, indent=1)) / 2
    found, result = load_result(folder), solved("halfplane")
    assert found.solution.kept is not None
    for mine, other in zip(found.contacts[0].stations, result.contacts[0].stations, strict=True):
        np.testing.assert_array_equal(mine.k_n, other.k_n)
        assert [zone.length for zone in mine.slip_zones] == [z.length for z in other.slip_zones]
    monkeypatch.setattr(writer, "LONG", 1000)
    assert with_digest(writer.as_numbers(found, {})) == short


def test_many_slip_zones_are_columns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writer, "LONG", 1)
    found = load_result(write_run(tmp_path, "halfplane"))
    for mine, other in zip(
        found.contacts[0].stations, solved("halfplane").contacts[0].stations, strict=True
    ):
        assert len(mine.slip_zones) == len(other.slip_zones) > 1
        for one, two in zip(mine.slip_zones, other.slip_zones, strict=True):
            assert type(one.start) is int and type(one.gross) is bool
            np.testing.assert_equal(vars(one), vars(two))


def test_a_replaced_file_is_not_mixed_up(tmp_path: Path) -> None:
    found = load_result(write_run(tmp_path, "halfplane"))
    write_run(tmp_path, "no cycle")
    with pytest.raises(OutputError, match="found another one"):
        found.contact_history("main").traction[3]


def test_an_envelope_has_all_extremes() -> None:
    values = RNG.normal(size=50_000)
    values[[7, 31_000]] = 9.0, -9.0
    seen = envelope(values)
    assert len(seen) <= 2 * BINS + 2
    assert {0, 7, 31_000, 49_999} <= set(seen.tolist())
    assert envelope(values[:BINS]).tolist() == list(range(BINS))


def test_repeats_of_repeats_lead_to_what_was_solved() -> None:
    solution = replace(
        solved("halfplane").solution,
        times=np.arange(12.0),
        repeats=(Repeat(4, 7, 2), Repeat(8, 11, 4)),
    )
    assert isinstance(solution, Solution)
    assert solution.source.tolist() == [0, 1, 2, 3, 2, 3, 2, 3, 2, 3, 2, 3]
    assert isinstance(solved("halfplane").contact_history("main").slip, StateArray)


MEMORY = """
import resource, sys
import numpy as np
sys.path.insert(0, sys.argv[2])
from cases.halfplane_problems import LIMIT, LOAD, problem
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
count = int(sys.argv[1])
times = np.arange(count) * 0.3
shear = 0.5 * LIMIT * (np.sin(times) + 0.3 * np.sin(2.3 * times))
outcome = solve_half_planes(problem(LOAD * (1 + 0.1 * np.sin(0.7 * times)), shear), 100)
assert outcome.failure is None
evaluate(outcome.solution, outcome.unit_factors)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def peak(steps: int) -> int:
    """Largest memory of a process that solves and evaluates an irregular history, in kB."""
    command = [sys.executable, "-c", MEMORY, str(steps), str(Path(__file__).parents[1])]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


@pytest.mark.slow
def test_memory_does_not_grow_with_the_steps() -> None:
    assert peak(4000) < 1.1 * peak(400)
