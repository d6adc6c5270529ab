# SPDX-License-Identifier: LGPL-3.0-or-later
"""Constants at one temperature in a run: the same as numbers, and judged where bodies are hot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import as_field, cylinder, pad, press, shear

from fretfe.caution import Caution
from fretfe.reason import Kind
from fretfe.results.model import Result

Solve = Callable[[dict[str, Any]], Result]
CURVE = {"temperatures": [20.0, 420.0], "values": [220e3, 180e3]}
STEEL = {"young": 200e3, "poisson": 0.3}


def heated(lower: dict[str, Any], hot: float, size: float = 0.2) -> dict[str, Any]:
    """A pad on a body that is as hot at its surface."""
    points = {"points": [[0, -50], [0, 0]], "values": [20.0, hot], "bodies": ["lower"]}
    warm = {"expansion": 0.0, "reference_temperature": 20.0, "poisson": 0.3, **lower}
    heat = {"type": "temperature", "history": [{"ramp": 1.0, "until": 1.0, "steps": 1}], **points}
    return pad(
        geometry=cylinder(size=size, growth=0.5),
        bodies={"upper": STEEL, "lower": warm},
        loads={"heat": heat, "press": press(steps=1), "shear": shear(steps=4, cycles=1)},
        output={"fields": "none"},
    )


def softening(result: Result) -> float:
    (found,) = (each.found for each in result.limits if "change of Young's" in each.quantity)
    return found


def of_temperature(result: Result) -> list[Caution]:
    kinds = (Kind.TEMPERATURE, Kind.TEMPERATURE_TABLE)
    return [each for each in result.warnings if each.kind in kinds]


def test_constants_at_a_temperature(solved: Solve) -> None:
    over = solved(heated({"young": CURVE, "temperature": 220.0}, 220.0, 0.04))
    plain = solved(heated({"young": 200e3}, 220.0, 0.04))
    for one, other in zip(over.contacts[0].stations, plain.contacts[0].stations, strict=True):
        np.testing.assert_array_equal(one.k_n, other.k_n)
        assert one.k_t_range == other.k_t_range
        assert np.isfinite(one.k_n[-1])
    note = "bodies.lower: constants at 220 °C: young = 200000, poisson = 0.3, expansion = 0"
    assert note in over.notes
    assert not any("Young" in each.quantity for each in plain.limits)
    # The surface is as hot; the bottom is colder, which is far away.
    assert softening(over) < 1e-12
    assert not of_temperature(over)


@pytest.mark.parametrize("field", [False, True], ids=["points", "field"])
@pytest.mark.parametrize(("hot", "change"), [(250.0, 0.015), (300.0, 0.04), (430.0, np.nan)])
def test_another_temperature_at_the_surface_is_judged(
    hot: float, change: float, field: bool, solved: Solve, tmp_path: Path
) -> None:
    case = heated({"young": CURVE, "temperature": 220.0}, hot)
    if field:
        slope = (hot - 20.0) / 50.0
        heat = as_field(case["loads"]["heat"], tmp_path, 60.0, lambda x, y: hot + slope * y)
        case["loads"]["heat"] = heat
    result = solved(case)
    assert softening(result) == pytest.approx(change, rel=1e-9, nan_ok=True)
    warned = of_temperature(result)
    if np.isnan(change):
        assert (
            "beyond the table of Young's modulus of lower, over its extent is 0.025"
            in warned[0].text
        )
    assert len(warned) == (np.isnan(change) or change > 0.03)
