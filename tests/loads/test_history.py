# SPDX-License-Identifier: LGPL-3.0-or-later
"""Load histories: values in closed form, the clock, the cycle, messages for mistakes."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretfe.case import Case, parse_case
from fretfe.errors import CaseError
from fretfe.loads import History, build_history, most_added

DOCS = Path(__file__).parents[2] / "docs" / "case-file.md"
# Times and values are sums and products of a few numbers of order one.
ROUND_OFF = 1e-14


def case_of(source: Path | str = "c.toml", extra: str = "", **histories: Any) -> Case:
    """A case with one traction load for each history."""
    data = tomllib.loads("""
        geometry.file = "m.msh"
        bodies.a = { young = 1.0, poisson = 0.3 }
        bodies.b = { young = 1.0, poisson = 0.3 }
        contacts.c = { surface1 = "s1", surface2 = "s2", friction = 0.3 }
        """)
    data["loads"] = {
        name: {"type": "traction", "boundary": name, "direction": "x", "history": history}
        for name, history in histories.items()
    }
    more = tomllib.loads(extra)
    data["contacts"]["c"] |= more.pop("contact", {})
    return parse_case(data | more, source)


def history_of(*segments: dict[str, Any], extra: str = "") -> History:
    """The history of a single load."""
    return build_history(case_of(extra=extra, a=list(segments)))


def message(extra: str = "", source: Path | str = "c.toml", **histories: Any) -> str:
    """What is wrong with these histories."""
    with pytest.raises(CaseError) as caught:
        build_history(case_of(source, extra, **histories))
    return str(caught.value)


def ramp(value: float, until: float, steps: int = 1) -> dict[str, Any]:
    """A ramp."""
    return {"ramp": value, "until": until, "steps": steps}


def hold(until: float, **more: int) -> dict[str, Any]:
    """A hold."""
    return {"hold": True, "until": until, **more}


def wave(shape: str = "sine", **more: float) -> dict[str, Any]:
    """A wave of unit amplitude and period, one cycle of eight steps."""
    return {
        "wave": shape,
        "amplitude": 1.0,
        "period": 1.0,
        "cycles": 1,
        "steps_per_cycle": 8,
        **more,
    }


def test_ramp_and_hold() -> None:
    history = history_of(ramp(-4, 1, 4), hold(2), hold(4, steps=2), ramp(8, 5, 3))
    assert history.channels == ("a",)
    assert history.times == pytest.approx(
        [0, 0.25, 0.5, 0.75, 1, 2, 3, 4, 13 / 3, 14 / 3, 5], abs=ROUND_OFF
    )
    assert history.values[:, 0] == pytest.approx(
        [0, -1, -2, -3, -4, -4, -4, -4, 0, 4, 8], abs=10 * ROUND_OFF
    )
    assert history.cycle is None


@pytest.mark.parametrize(
    ("shape", "eighths"),
    [
        ("sine", [0, 0.5**0.5, 1, 0.5**0.5, 0, -(0.5**0.5), -1, -(0.5**0.5)]),
        ("triangle", [0, 0.5, 1, 0.5, 0, -0.5, -1, -0.5]),
    ],
)
@pytest.mark.parametrize("phase", [0, 45, 90, -135], ids=lambda phase: f"phase{phase}")
def test_wave_follows_its_formula(shape: str, eighths: list[float], phase: float) -> None:
    expected = 3 + 2 * np.roll(eighths, -round(phase / 45))
    segment = wave(shape, mean=3, amplitude=2, phase=phase, period=4, cycles=3)
    history = history_of(ramp(expected[0], 1), segment)
    assert history.times == pytest.approx([0, *(1 + 0.5 * np.arange(25))], abs=ROUND_OFF)
    values = history.values[1:, 0]
    assert values[:-1] == pytest.approx(np.tile(expected, 3), abs=10 * ROUND_OFF)
    assert values[-1] == pytest.approx(expected[0], abs=10 * ROUND_OFF)


@pytest.mark.parametrize("shape", ["sine", "triangle"])
@pytest.mark.parametrize("phase", [0, 10, 100, -60, 179.5], ids=lambda phase: f"phase{phase}")
@pytest.mark.parametrize("per_cycle", [4, 5, 10])
def test_waves_turn_at_steps(shape: str, phase: float, per_cycle: int) -> None:
    degrees = np.radians(phase)
    start = np.sin(degrees) if shape == "sine" else 2 / np.pi * np.arcsin(np.sin(degrees))
    segment = wave(shape, phase=phase, cycles=3, steps_per_cycle=per_cycle)
    history = history_of(ramp(start, 1), segment)
    values = history.values[:, 0]
    assert values.max() == pytest.approx(1, abs=ROUND_OFF)
    assert values.min() == pytest.approx(-1, abs=ROUND_OFF)
    assert np.sum(values > 1 - 1e-9) == np.sum(values < -1 + 1e-9) == 3
    # The equal steps are all there, and at most two more a cycle.
    equal = 1 + np.arange(3 * per_cycle + 1) / per_cycle
    assert np.abs(history.times[:, None] - equal).min(axis=0).max() < 1e-9
    assert len(history.times) <= 2 + 3 * (per_cycle + 2)


def test_cycles_of_a_wave_repeat() -> None:
    history = history_of(wave(cycles=50, period=0.1, steps_per_cycle=40))
    first, last = history.values[1:41, 0], history.values[-40:, 0]
    # The phase is (t - t0)/period, whose error grows with t: 50 periods, 2 pi, machine epsilon.
    assert last == pytest.approx(first, abs=50 * 2 * np.pi * 2.3e-16 * 2)


def test_points_are_joined_to_where_the_load_stands() -> None:
    history = history_of(ramp(2, 1), {"times": [3, 4], "values": [6, 0]})
    assert history.times.tolist() == [0, 1, 3, 4]
    assert history.values[:, 0].tolist() == [0, 2, 6, 0]
    assert history.at(2) == pytest.approx([4], abs=ROUND_OFF)


def test_points_may_start_where_the_segment_before_ends() -> None:
    history = history_of({"times": [0, 1], "values": [0, 5]}, {"times": [1, 2], "values": [5, 7]})
    assert history.times.tolist() == [0, 1, 2]
    assert history.values[:, 0].tolist() == [0, 5, 7]


def test_clock_is_the_union_of_all_channels() -> None:
    history = build_history(
        case_of(
            a=[ramp(1, 0.3)],
            b=[ramp(3, 0.6, 3), wave("triangle", mean=3, amplitude=4, period=0.4)],
            c=[{"times": [0.25], "values": [-1]}],
        )
    )
    assert history.channels == ("a", "b", "c")
    steps = [0, 0.2, 0.25, 0.3, 0.4, *(0.6 + 0.05 * np.arange(9))]
    assert history.times == pytest.approx(steps, abs=ROUND_OFF)
    assert history.values[0].tolist() == [0, 0, 0]
    assert history.values[2] == pytest.approx([0.25 / 0.3, 1.25, -1], abs=ROUND_OFF)
    assert history.values[-3] == pytest.approx([1, -1, -1], abs=10 * ROUND_OFF)  # b at 3/4 period


def test_times_that_differ_by_round_off_are_one() -> None:
    loads: dict[str, Any] = {"a": [ramp(1, 3, 10)], "b": [wave(period=0.1, cycles=30)]}
    history = build_history(case_of(extra="cycle = { start = 2.9, end = 3 }", **loads))
    # 10 steps of 0.3 and 240 of 0.1/8, which contain them but for round-off: 3 * 0.1 > 0.3.
    assert len(history.times) == 241
    assert np.diff(history.times).min() > 0.012


def test_a_wave_is_evaluated_exactly_at_the_steps_of_others() -> None:
    loads: dict[str, Any] = {"a": [wave(steps_per_cycle=4)], "b": [ramp(1, 1, 12)]}
    history = build_history(case_of(extra="cycle = { start = 0, end = 1 }", **loads))
    # Twelve steps contain the four of the wave: 1/12 of a turn is 30 degrees.
    assert history.values[:, 0] == pytest.approx(
        np.sin(np.radians(30 * np.arange(13))), abs=ROUND_OFF
    )


def test_a_load_keeps_its_value_after_its_last_segment() -> None:
    loads: dict[str, Any] = {"a": [ramp(2, 1)], "b": [wave(cycles=2)], "d": [ramp(0, 4, 32)]}
    history = build_history(case_of(**loads))
    after = history.values[history.times > 2]
    assert len(after) == 16
    assert after == pytest.approx(np.tile([2, 0, 0], (16, 1)), abs=ROUND_OFF)


def test_history_between_and_after_steps() -> None:
    history = build_history(case_of(a=[ramp(2, 2, 2)], b=[hold(1), ramp(-3, 2)]))
    assert history.at(1.5) == pytest.approx([1.5, -1.5], abs=ROUND_OFF)
    assert history.at(99).tolist() == [2, -3]
    assert [history.step(time) for time in (0, 1, 1.9, 99)] == [0, 1, 2, 2]


def test_documented_example() -> None:
    example = re.findall(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)[0]
    history = build_history(parse_case(tomllib.loads(example)))
    first, last = history.cycle or (0, 0)
    assert history.times[[first, last]] == pytest.approx([3, 4], abs=ROUND_OFF)
    # Five preload steps; both waves have 40 steps a cycle; only the tension turns between them.
    assert len(history.times) == 1 + 5 + 3 * 42
    assert history.at(1) == pytest.approx([-2000, 0, 0], abs=1e-5)  # mean typed to 1e-5
    assert np.ptp(history.values[first : last + 1], axis=0) == pytest.approx(
        [0, 600, 100], abs=1e-9
    )


def test_documented_segments() -> None:
    page = DOCS.with_name("histories.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    first = next(block for block in blocks if block.startswith("history"))
    history = history_of(*tomllib.loads(first)["history"])
    assert history.times[-1] == 44
    assert history.values[-3:, 0] == pytest.approx([500, 300, 0], abs=1e-9)


DISCONTINUOUS = {
    "points-at-0": (
        [{"times": [0, 1], "values": [5, 6]}],
        "loads.a.history[segment 1].times: expected the value 0 at time 0, where the load stands "
        "(at time 0 every load is 0: the unloaded state), found 5: put a ramp to 5 before",
    ),
    "wave-at-0": (
        [wave(mean=1.5)],
        "loads.a.history[segment 1].wave: expected the value 0 at time 0",
    ),
    "wave-phase": (
        [ramp(3, 1), wave(mean=3, phase=90)],
        "loads.a.history[segment 2].wave: expected the value 3 at time 1, where the load stands, "
        "found 4: put a ramp to 4 before this segment",
    ),
    "points-jump": (
        [ramp(3, 1), {"times": [1, 2], "values": [2, 0]}],
        "loads.a.history[segment 2].times: expected the value 3 at time 1, where the load stands",
    ),
}


@pytest.mark.parametrize(("segments", "expected"), DISCONTINUOUS.values(), ids=DISCONTINUOUS)
def test_jumps_are_refused_with_the_remedy(segments: list[Any], expected: str) -> None:
    assert message(a=segments).startswith(f"c.toml: {expected}")


def test_a_start_typed_with_seven_digits_is_continuous() -> None:
    history = history_of(ramp(0.8660254, 1), wave(phase=60))
    assert history.values[1, 0] == 0.8660254


BACKWARDS = {
    "ramp": ([ramp(1, 2), ramp(3, 1)], "2].until: expected a time after 2, where the segment"),
    "hold": ([ramp(1, 2), hold(2)], "2].until: expected a time after 2, where the segment starts"),
    "wave-end": ([wave(cycles=3), hold(2.5)], "2].until: expected a time after 3, where the"),
    "points": (
        [ramp(1, 2), {"times": [1, 3], "values": [1, 0]}],
        "2].times: expected times from 2 on, where the segment starts, found 1",
    ),
}


@pytest.mark.parametrize(("segments", "expected"), BACKWARDS.values(), ids=BACKWARDS)
def test_segments_that_end_before_they_start_are_refused(
    segments: list[Any], expected: str
) -> None:
    text = message(a=segments)
    assert text.startswith("c.toml: loads.a.history[segment ")
    assert expected in text


def test_problems_of_all_loads_are_listed() -> None:
    lines = message(a=[wave(mean=1)], b=[ramp(1, 1)], d=[ramp(1, 2), hold(1)]).splitlines()
    assert [line.split(": ")[1] for line in lines] == [
        "loads.a.history[segment 1].wave",
        "loads.d.history[segment 2].until",
    ]


@pytest.mark.parametrize(
    ("segments", "where"),
    [([hold(2.0**63), wave()], "[segment 2]"), ([wave(), hold(1e12)], "[segment 1]")],
    ids=["after", "before"],
)
def test_steps_that_vanish_in_a_long_history_are_refused(
    segments: list[dict[str, Any]], where: str
) -> None:
    text = message(a=segments)
    assert text.startswith(f"c.toml: loads.a.history{where}: expected steps more than 1e-09 of the")
    assert "they would be one time" in text


@pytest.mark.parametrize(
    "histories", [{}, {"a": [{"times": [0], "values": [0]}]}], ids=["no-load", "no-step"]
)
def test_a_clock_without_a_step_is_refused(histories: dict[str, Any]) -> None:
    assert message(**histories).startswith("c.toml: loads: expected a load with at least one step")


def csv_case(folder: Path, content: str | bytes) -> Case:
    """A case in a folder with a CSV file of this content."""
    data = content.encode() if isinstance(content, str) else content
    (folder / "table.csv").write_bytes(data)
    segment = {"csv": "table.csv", "time": "t", "value": "Q"}
    return case_of(folder / "c.toml", a=[segment])


@pytest.mark.parametrize(
    "content",
    [
        "t,Q\n1,2\n3,-4\n",
        "Q,other,t\r\n2,x,1\r\n\r\n-4,,3\r\n",
        '\ufeff t , "Q"\n 1 , 2e0\n3,-4',
        "t;Q;note\n1;2,0;a,b\n3;-4;\n",
        "t\tQ\n1,0\t2\n3\t-4\n",
        "t   Q\n1.0 2\n 3   -4 \n",
        "t [sec],Q [N/mm²]\n1,2\n3,-4\n",
    ],
    ids=["plain", "other-columns", "mark-and-spaces", "semicolons", "tabs", "spaces", "unit"],
)
def test_csv_files_are_read_next_to_the_case(tmp_path: Path, content: str) -> None:
    history = build_history(csv_case(tmp_path, content))
    assert history.times.tolist() == [0, 1, 3]
    assert history.values[:, 0].tolist() == [0, 2, -4]


CSV = {
    "text": ("t,Q\n1,2\n2,abc\n", "line 3, column 'Q': expected a finite number, found 'abc'"),
    "nan": ("t,Q\n1,nan\n", "line 2, column 'Q': expected a finite number, found 'nan'"),
    "short": ("t,Q\n\n1\n", "line 3, column 'Q': expected a finite number, found an empty cell"),
    "no-column": ("t,P\n1,2\n", "line 1: expected one column 'Q', found 't', 'P'"),
    "bars": ("t|Q\n1|2\n", "line 1: expected one column 't', found 't|Q'"),
    "two-separators": ("t,Q,a;t;Q\n", "found ',' and ';': name it"),
    "both-marks": (
        "t;Q\n1;2.5\n2;2,5\n",
        "column 'Q': expected decimal points or decimal commas, found both: '2.5' in line 2",
    ),
    "thousands": ("t;Q\n1;1.234,5\n", "line 2, column 'Q': expected a finite number, found"),
    "comma-with-commas": ('t,Q\n1,"2,5"\n', "line 2, column 'Q': expected a finite number"),
    "twice": ("t,Q,Q\n1,2,3\n", "line 1: expected one column 'Q', found 't', 'Q', 'Q'"),
    "empty": ("", "expected a header row with the column names, found an empty file"),
    "header": ("t,Q\n", "expected rows of numbers below the header, found none"),
    "backwards": ("t,Q\n1,0\n2,0\n2,1\n", "line 4, column 't': expected a time after 2, found 2"),
    "negative": ("t,Q\n-1,0\n", "line 2, column 't': expected a time >= 0, found -1"),
    "latin-1": (b"t,Q\n1,\xff\n", "line 2: expected UTF-8 text, found the byte 0xff"),
    "seconds": ("t [h],Q\n1,2\n", "expected t in s, found t in h"),
    "force": ("t,Q [kN]\n1,2\n", "expected Q in MPa, found Q in kN"),
    "row of units": ("t;Q\n(s);(kN)\n1;2\n", "expected Q in MPa, found Q in (kN)"),
    "jump": ("t,Q\n0,5\n", "expected the value 0 at time 0"),
}


@pytest.mark.parametrize(("content", "expected"), CSV.values(), ids=CSV)
def test_csv_mistakes_are_located(tmp_path: Path, content: str | bytes, expected: str) -> None:
    with pytest.raises(CaseError) as caught:
        build_history(csv_case(tmp_path, content))
    text = str(caught.value)
    assert text.startswith(f"{tmp_path / 'c.toml'}: loads.a.history[segment 1].csv: ")
    assert expected in text
    assert "table.csv" in text or "time 0" in expected


@pytest.mark.parametrize("name", ["Q (kN)", "Q / kN", "Q in kN", "Q[kN]"])
def test_units_in_names_of_columns_count_unless_values_are_scaled(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / "table.csv").write_text(f"time [s],{name}\n1,2\n", "utf-8")
    segment = {"csv": "table.csv", "time": "time [s]", "value": name}
    with pytest.raises(CaseError, match=rf"found {re.escape(name)} in kN"):
        build_history(case_of(tmp_path / "c.toml", a=[segment]))
    scaled = build_history(case_of(tmp_path / "c.toml", a=[{**segment, "scale": 1e3}]))
    assert scaled.values[-1].tolist() == [2e3]


def test_a_missing_csv_file_is_named(tmp_path: Path) -> None:
    segment = {"csv": "none.csv", "time": "t", "value": "Q"}
    text = message(source=tmp_path / "c.toml", a=[segment])
    assert f"{tmp_path / 'none.csv'}: expected a CSV file, found nothing at" in text


CYCLES = {
    "one-wave": ({"a": [wave(cycles=3)]}, "", (2, 3)),
    "then-hold": ({"a": [wave(cycles=3), hold(7)]}, "", (2, 3)),
    "slowest": ({"a": [wave(cycles=6)], "b": [wave(period=3, cycles=2)]}, "", (3, 6)),
    "latest": ({"a": [wave(cycles=2), hold(5), wave(cycles=3)]}, "", (7, 8)),
    "given": ({"a": [ramp(1, 5, 5)]}, "cycle = { start = 2, end = 4 }", (2, 4)),
    "given-multiple": (
        {"a": [wave(period=2, cycles=3)], "b": [wave(period=3, cycles=2)]},
        "cycle = { start = 0, end = 6 }",
        (0, 6),
    ),
    "flight": ({"a": [hold(1), ramp(4, 2, 4), ramp(0, 3, 4)]}, "", (1, 3)),
    "flight-then-less": ({"a": [ramp(4, 1, 4), ramp(0, 2, 4), ramp(3, 3, 3)]}, "", (0, 2)),
    "other-wave-is-over": (
        {"a": [wave(cycles=1)], "b": [wave(period=1.5, cycles=2)]},
        "",
        (1.5, 3),
    ),
}


@pytest.mark.parametrize(("histories", "extra", "expected"), CYCLES.values(), ids=CYCLES)
def test_the_cycle_is_found(
    histories: dict[str, Any], extra: str, expected: tuple[float, float]
) -> None:
    history = build_history(case_of(extra=extra, **histories))
    assert history.cycle is not None
    first, last = history.cycle
    assert history.times[[first, last]] == pytest.approx(expected, abs=ROUND_OFF * 10)


def test_a_flight_before_a_larger_load_is_not_the_cycle() -> None:
    assert history_of(ramp(3, 1, 4), ramp(0, 2, 4), ramp(4, 3, 3)).cycle is None


def test_a_prolonged_history_is_one_with_more_cycles() -> None:
    written = history_of(ramp(1, 1, 2), wave(phase=90, cycles=2))
    longer = history_of(ramp(1, 1, 2), wave(phase=90, cycles=5))
    found = written.prolonged(3)
    assert found.cycle == written.cycle == (10, 18)
    np.testing.assert_allclose(found.times, longer.times, rtol=ROUND_OFF)
    np.testing.assert_allclose(found.values, longer.values, atol=10 * ROUND_OFF)
    assert found.between is not None and longer.between is not None
    np.testing.assert_allclose(found.between, longer.between, atol=10 * ROUND_OFF)
    assert written.prolonged(0) is written


@pytest.mark.parametrize(
    ("step", "later", "cycle"),
    [(18, 0, (10, 18)), (25, 0, (10, 18)), (26, 1, (18, 26)), (40, 0, (10, 18)), (40, 2, (26, 34))],
)
def test_loads_until_a_step(step: int, later: int, cycle: tuple[int, int]) -> None:
    longest = history_of(ramp(1, 1, 2), wave(phase=90, cycles=2)).prolonged(3)
    found = longest.until(step, later)
    assert found.cycle == cycle and len(found.times) == step + 1
    assert found.between is not None and len(found.between) == step
    np.testing.assert_array_equal(found.values, longest.values[: step + 1])


GO_ON: dict[str, tuple[dict[str, Any], str, bool]] = {
    "wave": ({"a": [wave()]}, "", True),
    "two-waves": ({"a": [wave(cycles=2)], "b": [wave(period=2)]}, "", True),
    "hold-behind": ({"a": [wave(), hold(2)]}, "", False),
    "no-wave": ({"a": [ramp(1, 1), ramp(0, 2)]}, "cycle = { start = 0, end = 2 }", False),
    "no-cycle": ({"a": [ramp(1, 1)]}, "", False),
    "given-in-the-middle": ({"a": [wave(cycles=3)]}, "cycle = { start = 0, end = 1 }", False),
    "given-open": (
        {"a": [wave(cycles=2)], "b": [ramp(1, 2, 4)]},
        "cycle = { start = 1, end = 2 }",
        False,
    ),
}


@pytest.mark.parametrize(("histories", "extra", "expected"), GO_ON.values(), ids=GO_ON)
def test_loads_that_may_go_on(histories: dict[str, Any], extra: str, expected: bool) -> None:
    case = case_of(extra=extra, **histories)
    history = build_history(case)
    assert most_added(case, history, 3) == (20 if expected else 0)
    assert most_added(case, history, 2) == 0


WRONG_TIMES = {
    "cycle-start": (
        "cycle = { start = 1.5, end = 4 }",
        "cycle.start: expected the time of a step, found 1.5; the nearest steps are at 1 and 2",
    ),
    "cycle-end": (
        "cycle = { start = 1, end = 6 }",
        "cycle.end: expected a time within the history, which ends at 5, found 6",
    ),
    "friction": (
        "contact.friction_from = 0.5",
        "contacts.c.friction_from: expected the time of a step, found 0.5; the nearest steps are "
        "at 0 and 1",
    ),
    "friction-late": (
        "contact.friction_from = 5.5",
        "contacts.c.friction_from: expected a time within the history, which ends at 5, found 5.5",
    ),
    "fields": (
        "output.fields = [1, 2.25]",
        "output.fields[item 2]: expected the time of a step, found 2.25; the nearest steps are at "
        "2 and 3",
    ),
}


@pytest.mark.parametrize(("extra", "expected"), WRONG_TIMES.values(), ids=WRONG_TIMES)
def test_times_that_are_not_steps_are_refused(extra: str, expected: str) -> None:
    assert message(extra, a=[ramp(1, 5, 5)]) == f"c.toml: {expected}"


def test_periods_must_divide_the_cycle() -> None:
    text = message(a=[wave(period=3, cycles=2)], b=[wave(period=2, cycles=3)])
    assert text.startswith(
        "c.toml: loads.b.history[segment 1].period: expected a period that divides the cycle from "
        "3 to 6 (length 3), found 2"
    )
    assert "[cycle]" in text


def test_a_given_cycle_must_hold_whole_periods() -> None:
    text = message("cycle = { start = 0, end = 0.5 }", a=[wave()])
    assert "loads.a.history[segment 1].period: expected a period that divides the cycle" in text


@pytest.mark.parametrize("cycle", [(2, 3), (4, 5), (1, 3), (3, 6), (2, 6)])
def test_a_given_cycle_within_a_table_that_is_repeated(
    tmp_path: Path, cycle: tuple[float, float]
) -> None:
    """As in the table whose rows are written out."""
    rows, (start, end) = [(1, 2), (2, 1), (3, 0)], cycle
    (tmp_path / "table.csv").write_text("t,Q\n0,0\n" + "".join(f"{t},{q}\n" for t, q in rows))
    segment = {"csv": "table.csv", "time": "t", "value": "Q", "repeat": 2}
    extra = f"cycle = {{ start = {start}, end = {end} }}"
    found = build_history(case_of(tmp_path / "c.toml", extra=extra, a=[segment]))
    both = [*rows, *((t + 3, q) for t, q in rows)]
    points = {"times": [t for t, _ in both], "values": [q for _, q in both]}
    written = build_history(case_of(extra=extra, a=[points]))
    assert found.cycle == written.cycle == cycle
    assert found.returns == written.returns
    np.testing.assert_array_equal(found.values, written.values)


def test_a_load_that_does_not_return_is_not_a_cycle() -> None:
    text = message(a=[wave(cycles=2)], b=[ramp(4, 2, 2)])
    assert text.startswith(
        "c.toml: loads.b: expected every load to return in the cycle, the last period of the "
        "slowest wave, found 2 at time 1 and 4 at time 2"
    )
    given = case_of(extra="cycle = { start = 1, end = 2 }", a=[wave(cycles=2)], b=[ramp(4, 2, 2)])
    assert build_history(given).cycle == (8, 16)


def repeated(folder: Path, content: str, *before: dict[str, Any], **keys: Any) -> History:
    """History of some segments and of a CSV file with these keys."""
    (folder / "table.csv").write_text(content, encoding="utf-8")
    segment = {"csv": "table.csv", "time": "t", "value": "Q", **keys}
    return build_history(case_of(folder / "c.toml", a=[*before, segment]))


def test_a_csv_file_is_scaled_shifted_and_repeated(tmp_path: Path) -> None:
    ramp = {"ramp": 5.0, "until": 2.0, "steps": 1}
    keys = {"scale": -2.0, "offset": 1.0, "repeat": 3}
    history = repeated(tmp_path, "t,Q\n2,-2\n3,1\n5.5,4\n6,-2\n", ramp, **keys)
    assert history.times.tolist() == [0, 2, 3, 5.5, 6, 7, 9.5, 10, 11, 13.5, 14]
    assert history.values[:, 0].tolist() == [0, 5, -1, -7, 5, -1, -7, 5, -1, -7, 5]
    # The last repetition is the cycle.
    assert history.cycle == (7, 10)


REPEATED = {
    "open": (
        "t,Q\n0,0\n1,2\n2,1e-6\n", {}, "expected the same first and last value in the column 'Q'"
    ),
    "values": ("t,Q\n0,0\n1,2\n2,1\n", {"scale": 3.0}, "found 0 and 3"),
    "one row": ("t,Q\n1,2\n", {}, "expected two rows at least to be repeated"),
    "separator": ("t,Q\n0,0\n", {"separator": "tab"}, "expected one column 't', found 't,Q'"),
}  # fmt: skip


@pytest.mark.parametrize(("content", "keys", "expected"), REPEATED.values(), ids=REPEATED)
def test_what_cannot_be_repeated_is_told(
    tmp_path: Path, content: str, keys: dict[str, Any], expected: str
) -> None:
    with pytest.raises(CaseError, match=re.escape(expected)):
        repeated(tmp_path, content, **{"repeat": 2, **keys})
