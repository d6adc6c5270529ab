# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sweeps with finite elements: the rows of single runs, from bodies that are condensed once."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HOLD, cylinder, pad, pad_text, press, shear, wave
from harness.launch import fretfe, python
from harness.told import Told

from fretfe.backends import RunOptions
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case, changed, parse_case
from fretfe.contact.march import Division
from fretfe.errors import MeshError
from fretfe.fem import backend, condensation
from fretfe.fem._compat import MPI
from fretfe.fem.backend import BACKEND
from fretfe.sweeps import Sweep, make_variants, run_sweep

FRICTION, AMPLITUDE = "contacts.main.friction", "loads.shear.amplitude"
RADIUS = "geometry.parameters.upper_radius"
# Another operator may have been kept for a contact area: round-off, which the fits of the edges
# and of the slip zones multiply by some hundred.
ROUND_OFF = 1e-10


# Order 1; friction from the start.
COARSE = {
    "geometry": {**cylinder(size=0.04, growth=0.3), "order": 1},
    "model": {"degree": 1},
    "contacts": {"main": {**pad()["contacts"]["main"], "friction_from": 0.0}},
}


def case(**tables: Any) -> Case:
    """About 30 nodes in contact; friction from the start, which holds the pad sideways."""
    return parse_case(pad(**COARSE, loads={"press": press(), "shear": shear(steps=8)}) | tables)


@pytest.fixture
def factorised(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Grows by one number with each body that is factorised."""
    sizes: list[int] = []
    original = condensation.BorderedFactor

    def counted(matrix: Any, border: Any, dimension: int, **options: Any) -> Any:
        sizes.append(border.shape[0])
        return original(matrix, border, dimension, **options)

    monkeypatch.setattr(condensation, "BorderedFactor", counted)
    return sizes


def swept(start: Case, ranges: Mapping[str, Any], options: RunOptions = DEFAULTS) -> Sweep:
    return run_sweep(make_variants(start, ranges), BACKEND, options)


def test_the_size_of_the_mesh_is_told_before_it_is_condensed(factorised: list[int]) -> None:
    whether = []

    class Asking(Told):
        def announce(self, text: str) -> None:
            super().announce(text)
            whether.append(bool(factorised))

    observer = Asking()
    swept(case(), {FRICTION: (0.5, 0.6)}, RunOptions(observer=observer))
    told = observer.announced
    assert re.fullmatch(r"mesh: \d{4} unknowns; the bodies are condensed .*", told[0])
    assert whether == [False, True, True]
    assert [text.split(":")[0] for text in told] == ["mesh", "1/2", "2/2"]


@cache
def single(**values: float) -> list[dict[str, Any]]:
    named = {"friction": FRICTION, "amplitude": AMPLITUDE, "radius": RADIUS}
    other = changed(case(), {named[name]: value for name, value in values.items()})
    return BACKEND.solve(other).edges()


def compare(found: Mapping[str, Any], expected: Mapping[str, Any]) -> None:
    for name, value in expected.items():
        if isinstance(value, float):
            # what is zero by symmetry or balance is compared with the half-width
            scale = max(float(np.nan_to_num(abs(value))), 1e-3 * expected["half_width"])
            assert np.isclose(found[name], value, rtol=0, atol=ROUND_OFF * scale, equal_nan=True), (
                name
            )
        else:
            assert found[name] == value


@pytest.mark.mpi
def test_rows_are_those_of_single_runs_and_bodies_are_factorised_once(
    factorised: list[int],
) -> None:
    sweep = swept(case(), {FRICTION: (0.4, 0.7), AMPLITUDE: (60.0, 30.0)})
    assert len(factorised) == (2 if MPI.COMM_WORLD.size == 1 else 1)  # on this rank
    assert [each.failure for each in sweep.variants] == [""] * 4
    for each in sweep.variants:
        expected = single(friction=each.values[FRICTION], amplitude=each.values[AMPLITUDE])
        for edge, reference in zip(each.edges, expected, strict=True):
            compare(edge, reference)


def test_other_bodies_are_factorised_again_once_each(factorised: list[int]) -> None:
    sweep = swept(case(), {FRICTION: (0.4, 0.7), RADIUS: (50.0, 40.0)})
    assert len(factorised) == 4
    last = sweep.variants[-1]
    assert last.values == {FRICTION: 0.7, RADIUS: 40.0}
    for edge, reference in zip(last.edges, single(friction=0.7, radius=40.0), strict=True):
        compare(edge, reference)


@pytest.mark.parametrize(
    ("key", "value", "count"),
    [
        ("loads.shear.history.1.until", 1.0, 2),
        ("output.fields", "none", 2),
        ("title", "Another", 2),
        ("contacts.main.friction_from", 1.0, 2),
        ("contacts.main.multipliers", "surface2", 4),
        ("bodies.upper.young", 200e3, 4),
        ("model.thickness", 2.0, 4),
        ("supports.side", {"boundary": "lower_left", "fix": ["x"]}, 4),
        ("loads.shear.control", "displacement", 4),
        ("geometry.order", 2, 4),
    ],
)
def test_what_needs_another_model(factorised: list[int], key: str, value: Any, count: int) -> None:
    short = {"press": press(), "shear": shear(0.01, steps=4, cycles=1)}
    start = case(loads=short)
    session = BACKEND.session()
    session.solve(start)
    session.solve(changed(start, {key: value}))
    assert len(factorised) == count
    session.close()


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """All cases are solved in this process."""
    monkeypatch.setattr(backend, "idle_cores", lambda: 0)


@pytest.fixture
def solved_steps(monkeypatch: pytest.MonkeyPatch, alone: None) -> list[int]:
    """Grows by the number of each step that is solved."""
    numbers: list[int] = []
    original = Division.solve

    def counted(self: Division, number: int, *state: Any) -> Any:
        numbers.append(number)
        return original(self, number, *state)

    monkeypatch.setattr(Division, "solve", counted)
    return numbers


def test_steps_before_the_loads_differ_are_solved_once(solved_steps: list[int]) -> None:
    pressed, count = 4, 12
    start = case(loads={"press": press(steps=pressed), "shear": shear(steps=8, cycles=1)})
    sweep = swept(start, {FRICTION: (0.4, 0.7), AMPLITUDE: (60.0, 30.0)})
    every, later = list(range(1, count + 1)), list(range(pressed + 1, count + 1))
    assert solved_steps == (every + later) * 2
    assert [each.failure for each in sweep.variants] == [""] * 4


def test_the_same_loads_in_other_parts_of_steps_are_solved_again(solved_steps: list[int]) -> None:
    """Into how many parts a step is divided depends on the range of the loads in all of them."""
    turning = {**wave(60.0, phase=90.0, cycles=1, steps=8), "mean": -660.0}
    pressed = {**press(), "history": [*press()["history"], turning]}
    waves = [HOLD, wave(40.0, cycles=1, steps=8), wave(40.0, cycles=1, steps=8)]
    start = case(loads={"press": pressed, "shear": {**shear(), "history": waves}})
    key, count = "loads.shear.history.2.amplitude", 20
    second = swept(start, {key: (40.0, 120.0)}).variants[1]
    assert solved_steps == [*range(1, count + 1), *range(5, count + 1)]
    alone = BACKEND.solve(changed(start, {key: 120.0})).edges()
    for edge, reference in zip(second.edges, alone, strict=True):
        compare(edge, reference)


def test_cases_on_idle_cores_are_those_of_one_process(
    monkeypatch: pytest.MonkeyPatch, solved_steps: list[int]
) -> None:
    """Each copy goes on from the case that was solved before: with its friction, from its loads."""
    ranges = {FRICTION: (0.4, 0.7), AMPLITUDE: (60.0, 30.0)}
    alone = swept(case(), ranges)
    every = len(solved_steps)
    monkeypatch.setattr(backend, "idle_cores", lambda: 2)
    monkeypatch.setattr(backend, "threads_asked_for", lambda: None)
    # That of the tests of this process before, which copies do not need.
    monkeypatch.setattr(backend, "peak_memory", lambda: 5e8)
    told = Told()
    beside = swept(case(), ranges, RunOptions(observer=told))
    # Only the steps of the first case are solved in this process.
    assert len(solved_steps) - every == len(BACKEND.solve(case()).loads.times) - 1
    assert "3 cases, 3 at a time" in told.done
    assert [text.split(":")[0] for text in told.announced[1:]] == ["1/4", "2/4", "3/4", "4/4"]
    for one, other in zip(beside.variants, alone.variants, strict=True):
        assert one.values == other.values and not one.failure
        for edge, reference in zip(one.edges, other.edges, strict=True):
            compare(edge, reference)


@pytest.mark.mpi
def test_a_case_without_a_solution_does_not_spoil_the_others() -> None:
    """A shear force of 300 is more than f P = 240."""
    sweep = swept(case(), {AMPLITUDE: (300.0, 60.0)})
    first, second = sweep.variants
    assert "did not converge" in first.failure or "slides" in first.failure
    assert not first.edges
    for edge, reference in zip(second.edges, single(friction=0.4, amplitude=60.0), strict=True):
        compare(edge, reference)


def test_meshes_that_refine_themselves_do_so_for_each_case(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    refined = []

    def recorded(comm: Any, case: Case, *_: Any) -> Any:
        refined.append(case.contacts["main"].friction)
        raise MeshError("recorded")

    monkeypatch.setattr(backend, "refine", recorded)
    sweep = swept(case(geometry=cylinder(), edges={"tolerance": 0.05}), {FRICTION: (0.4, 0.8)})
    assert refined == [0.4, 0.8]
    assert [each.failure for each in sweep.variants] == ["recorded"] * 2


TEXT = pad_text(**COARSE, loads={"press": press(steps=2)}, output={})


def test_two_processes_write_one_table(tmp_path: Path) -> None:
    (tmp_path / "pad.toml").write_text(TEXT)
    arguments = ("sweep", tmp_path / "pad.toml", "--vary", "loads.press.ramp=-600,-300,100")
    for ranks in (1, 2):
        options = (*arguments, "-o", tmp_path / str(ranks))
        done = fretfe(*options) if ranks == 1 else python("-m", "fretfe", *options, ranks=ranks)
        assert done.returncode == 0, done.stderr
        # Cases that are solved beside one another end in any order.
        assert len(re.findall(r"[23]/3: loads.press.ramp = 100: failed: ", done.stdout)) == 1
        assert done.stdout.count("3 variants, 1 failed") == 1
        assert (tmp_path / str(ranks) / "sweep.png").exists()
    one, two = (rows(tmp_path / name / "sweep.csv") for name in ("1", "2"))
    assert len(one) == len(two) == 5
    for row, other in zip(one, two, strict=True):
        assert row["failure"] == other["failure"]
        if row["k_n"]:
            assert float(row["k_n"]) == pytest.approx(float(other["k_n"]), rel=1e-8)


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


SCRIPT = """
import sys
import fretfe
from pathlib import Path
folder = Path(sys.argv[1])
case = fretfe.load_case(folder / "pad.toml", {"output.fields": "none"})
result = fretfe.run(case, output=folder / "run")
from fretfe.fem._compat import MPI
sweep = fretfe.sweep(case, {"loads.press.ramp": [-600.0, -300.0]}, output=folder / "sweep")
gathered = MPI.COMM_WORLD.gather(repr((result.edges(), sweep.records()[0]["k_n"])))
if MPI.COMM_WORLD.rank == 0:
    print(len(gathered), gathered[0] == gathered[-1], result.root_solution is not None)
"""


def test_scripts_on_two_processes(tmp_path: Path) -> None:
    (tmp_path / "pad.toml").write_text(TEXT)
    done = python("-c", SCRIPT, tmp_path, ranks=2)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["2", "True", "True"]
    assert (tmp_path / "run" / "results.json").exists()
    assert (tmp_path / "sweep" / "sweep.csv").exists()
