# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ranges of values and their combinations, and what is refused before any work."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from cases.pad_cases import HERTZ, pad

from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.sweeps import Points, make_variants, parse_ranges, require_apart, sample

FRICTION = "contacts.main.friction"


@pytest.mark.parametrize(
    ("text", "values"),
    [
        # as typed, without the round-off of the steps
        ("0.1:0.6:6", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)),
        ("0.6:0.1:2", (0.6, 0.1)),
        ("1:3:3", (1, 2, 3)),
        ("1:2:3", (1.0, 1.5, 2.0)),
        ("1e3:2e3:2", (1000.0, 2000.0)),
        ("0.4", (0.4,)),
        ("0.4, 0.6", (0.4, 0.6)),
        ("sine,triangle", ("sine", "triangle")),
        ('"a:b","c"', ("a:b", "c")),
        ("[1, 0], [0, 1]", ([1, 0], [0, 1])),
        ("true,2", (True, 2)),
    ],
)
def test_values(text: str, values: tuple[Any, ...]) -> None:
    found = parse_ranges([f"{FRICTION}={text}"])
    assert found == {FRICTION: values}
    assert [type(value) for value in found[FRICTION]] == [type(value) for value in values]


@pytest.mark.parametrize(
    "text", ["0:1", "0:1:2:3", "0:1:1", "0:1:0", "0:1:2.5", "a:b:3", "0:inf:3"]
)
def test_malformed_range(text: str) -> None:
    with pytest.raises(CaseError) as error:
        parse_ranges([f"{FRICTION}={text}"])
    assert str(error.value) == (
        f"--vary {FRICTION}: expected START:STOP:COUNT, two numbers and a count of 2 or more, "
        f"found '{text}'"
    )


@pytest.mark.parametrize("text", ["", "0.4,,0.5", ","])
def test_malformed_list(text: str) -> None:
    with pytest.raises(CaseError, match=rf"--vary {FRICTION}: expected A,B,C or START:STOP:COUNT"):
        parse_ranges([f"{FRICTION}={text}"])


def test_without_a_key() -> None:
    with pytest.raises(CaseError, match="--vary: expected KEY=VALUE"):
        parse_ranges(["0.1:0.6:11"])


def test_a_key_twice() -> None:
    with pytest.raises(CaseError, match=f"expected each key once, found '{FRICTION}' twice"):
        parse_ranges([f"{FRICTION}=1", f"{FRICTION}=2"])


def test_all_combinations_the_last_key_fastest() -> None:
    ranges = {FRICTION: (0.4, 0.5), "loads.shear.amplitude": (20, 30, 40)}
    variants = make_variants(parse_case(pad()), ranges)
    assert [tuple(each.values.values()) for each in variants] == [
        (0.4, 20), (0.4, 30), (0.4, 40), (0.5, 20), (0.5, 30), (0.5, 40)
    ]  # fmt: skip
    for each in variants:
        assert each.case.contacts["main"].friction == each.values[FRICTION]
        segment = each.case.loads["shear"].history[1]
        assert segment.amplitude == each.values["loads.shear.amplitude"]  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({}, "a sweep needs a key that varies"),
        ({FRICTION: ()}, "a sweep needs a key that varies, and a value for each key"),
        ({FRICTION: (0.4, -0.1)}, "contacts.main.friction: expected a number >= 0, found -0.1"),
        (
            {"contacts.mian.friction": (0.4,)},
            "there is no 'mian' in contacts; did you mean 'main'?",
        ),
        # valid keys and values that no history can be made of
        ({"loads.shear.phase": (0, 90)}, "expected the value 0 at time 1, where the load stands"),
        (
            {FRICTION: range(1, 102), "loads.shear.amplitude": range(100)},
            "--vary: expected at most 10000 variants, found 10100",
        ),
    ],
)
def test_refused_before_any_work(ranges: dict[str, Any], message: str) -> None:
    with pytest.raises(CaseError) as error:
        make_variants(parse_case(pad(), Path("pad.toml")), ranges)
    assert message in str(error.value)


def test_long_ranges_are_not_made() -> None:
    with pytest.raises(CaseError, match="expected at most 10000 variants, found 1000000000000"):
        parse_ranges([f"{FRICTION}=0:1:1000000000000"])


@pytest.mark.parametrize("fixed", [FRICTION, "contacts.*.friction"])
def test_what_varies_is_not_set_as_well(tmp_path: Path, fixed: str) -> None:
    path = tmp_path / "pad.toml"
    path.write_text(HERTZ)
    require_apart(path, ["bodies.upper.young=1e5"], {FRICTION: 0.3})
    with pytest.raises(CaseError, match=r"in both|sets the same value"):
        require_apart(path, [f"{fixed}=0.2"], {FRICTION: 0.3})


@pytest.mark.parametrize("method", ["latin", "sobol"])
def test_points_fill_the_space_evenly(method: Literal["latin", "sobol"]) -> None:
    """Each of eight equal parts of either range has one of eight points."""
    bounds = {FRICTION: (0.3, 0.7), "loads.shear.amplitude": (20.0, 60.0)}
    points = sample(bounds, 8, method)
    assert list(points) == list(bounds) and sample(bounds, 8, method) == points
    assert sample(bounds, 8, method, seed=1) != points
    for key, (low, high) in bounds.items():
        parts = np.floor((np.array(points[key]) - low) / (high - low) * 8)
        assert sorted(parts) == list(range(8))
    variants = make_variants(parse_case(pad()), points)
    assert [tuple(each.values.values()) for each in variants] == list(
        zip(*points.values(), strict=True)
    )
    assert variants[3].case.contacts["main"].friction == points[FRICTION][3]


def test_points_that_differ_in_number() -> None:
    points = Points({FRICTION: (0.3, 0.4), "loads.shear.amplitude": (20.0,)})
    with pytest.raises(CaseError, match=r"as many values of each key, found \[2, 1\]"):
        make_variants(parse_case(pad()), points)


@pytest.mark.parametrize(
    ("bounds", "count", "method", "expected"),
    [
        ({}, 3, "latin", "expected keys and points, found 0 and 3"),
        ({FRICTION: (0.3, 0.7)}, 0, "latin", "found 1 and 0"),
        ({FRICTION: (0.7, 0.3)}, 3, "latin", "expected finite bounds that increase"),
        ({FRICTION: (0.3,)}, 3, "latin", "expected finite bounds that increase"),
        ({FRICTION: (0.3, np.inf)}, 3, "latin", "expected finite bounds that increase"),
        ({FRICTION: (0.3, 0.7)}, 3, "foo", "method: expected latin or sobol, found 'foo'"),
    ],
)
def test_points_that_cannot_be(bounds: Any, count: int, method: Any, expected: str) -> None:
    with pytest.raises(CaseError, match=expected):
        sample(bounds, count, method)
