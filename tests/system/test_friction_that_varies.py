# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction that changes along the surface, against half-planes and statics."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import BASE, HOLD, PAD, TOP, cylinder, pad, press
from reference.half_plane_collocation import compliance, partial_slip

import fretfe
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.history.solution import OPEN, SLIP, STICK
from fretfe.reason import Kind
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results

# A coat that is worn through in the middle.
COATED = {"arc": [-2, -0.48, -0.38, 0.38, 0.48, 2], "values": [0.3, 0.3, 0.6, 0.6, 0.3, 0.3]}


def solved(friction: Any, *, history: list[dict[str, Any]], control: str = "force") -> Result:
    shear = {**TOP, "direction": "x", "control": control, "history": [HOLD, *history]}
    main = {**PAD["contacts"]["main"], "friction": friction}
    tables = {
        "geometry": cylinder(size=0.02),
        "contacts": {"main": main},
        "loads": {"press": press(), "shear": shear},
        "supports": BASE,
    }
    return fretfe.run(parse_case(pad(**tables)))


@pytest.fixture(scope="module")
def coated() -> Result:
    return solved(COATED, history=[{"ramp": 120.0, "until": 2.0, "steps": 2}])


def test_slip_zones_of_a_worn_coat_are_those_of_half_planes(coated: Result) -> None:
    history = coated.contact_history("main")
    half_width = float(coated.contacts[0].half_width[-1])
    x = half_width * (np.arange(400) + 0.5) / 200 - half_width
    pressure = 2 * 600 / (np.pi * half_width) * np.sqrt(1 - (x / half_width) ** 2)
    bound = np.interp(x, COATED["arc"], COATED["values"]) * pressure
    shear, slips = partial_slip(x, compliance(x, 1.0), bound, 120.0)
    border = half_width - float(np.abs(x[~slips]).max())
    assert half_width - 0.48 < border < 0.25  # it reaches to where the coat wears thin

    slipping = history.status[-1] == SLIP
    stuck = np.abs(history.surface.arc[~slipping & (history.status[-1] != OPEN)]).max()
    assert stuck == pytest.approx(half_width - border, abs=0.01 + 0.01 * half_width)
    inside = np.abs(history.surface.arc) < 0.97 * half_width
    found = history.mean_traction[-1][inside, 1]
    away = np.abs(x - history.surface.arc[inside, None])
    around = np.maximum(1 - away / history.surface.weights[inside, None], 0.0)
    exact = around @ shear / around.sum(axis=1)
    assert np.abs(found - exact).max() < 0.02 * bound.max()
    assert np.abs(found - exact).mean() < 0.005 * bound.max()


def test_files_keep_the_coefficients(coated: Result, tmp_path: Path) -> None:
    write_results(tmp_path, coated)
    kept, own = (each.contact_history("main").friction for each in (load_result(tmp_path), coated))
    assert np.array_equal(kept.at(slice(None)), own.at(slice(None)))


def test_what_sticks_may_have_any_friction() -> None:
    history = [{"ramp": 40.0, "until": 2.0, "steps": 2}]
    one, other = solved(0.3, history=history), solved(COATED, history=history)
    for mine, theirs in zip(one.contacts[0].stations, other.contacts[0].stations, strict=True):
        assert mine.slip_zones[-1].length == pytest.approx(theirs.slip_zones[-1].length, rel=1e-9)
        assert np.allclose(mine.k_n, theirs.k_n, rtol=1e-9, equal_nan=True)


def test_sliding_takes_the_sum_of_friction_times_pressure() -> None:
    arc, values = [-2, 0, 2], [0.1, 0.4, 0.2]
    friction = {"arc": arc, "values": values}
    history = [{"ramp": 0.03, "until": 2.0, "steps": 3}]
    result = solved(friction, history=history, control="displacement")
    surface = result.contact_history("main")
    own = np.interp(surface.surface.arc, arc, values)
    nodal = surface.surface.weights * surface.traction[-1][:, 0]
    assert result.contacts[0].shear_force[-1] == pytest.approx(own @ nodal, rel=1e-10)
    kinds = {each.kind for each in result.contacts[0].warnings}
    assert Kind.FRICTION_VARIES in kinds


def test_a_table_of_one_value_is_that_number_bit_for_bit() -> None:
    wave = {"wave": "sine", "amplitude": 60, "period": 1, "cycles": 2, "steps_per_cycle": 8}
    number = solved(0.4, history=[wave])
    for table in ({"times": [0, 3], "values": [0.4, 0.4]}, {"arc": [-9, 9], "values": [0.4, 0.4]}):
        other = solved(table, history=[wave])
        mine, theirs = number.contact_history("main"), other.contact_history("main")
        assert np.array_equal(mine.traction[:], theirs.traction[:])
        pair = zip(number.contacts[0].stations, other.contacts[0].stations, strict=True)
        for one, same in pair:
            assert one.k_t_range == same.k_t_range
            assert one.slip_zones == same.slip_zones


FALLING = {"pressure": [0.0, 800.0], "values": [0.5, 0.3]}


def test_sliding_takes_friction_over_pressure() -> None:
    slide = {"ramp": 0.05, "until": 2.0, "steps": 4}
    history = solved(FALLING, history=[slide], control="displacement").contact_history("main")
    assert (history.status[-1] != OPEN).any() and not (history.status[-1] == STICK).any()
    weights, pressure = history.surface.weights, np.maximum(history.mean_traction[-2][:, 0], 0.0)
    friction = np.interp(pressure, FALLING["pressure"], FALLING["values"])
    assert np.array_equal(history.friction.at(-1), friction)
    shear = float(weights @ history.traction[-1][:, 1])
    assert shear == pytest.approx(weights @ (friction * history.traction[-1][:, 0]), rel=1e-9)
    # Of Hertz: the integral of p is P, that of p^2 is 4/3 a p0^2.
    half_width = np.sqrt(4 * 600 * 50 / (np.pi * 115384.6))
    largest = 2 * 600 / (np.pi * half_width)
    assert largest < 800
    exact = 0.5 * 600 - 0.2 / 800 * 4 / 3 * half_width * largest**2
    assert abs(shear) == pytest.approx(exact, rel=0.01)


def test_the_same_friction_at_all_pressures_is_the_number() -> None:
    history = [{"ramp": 120.0, "until": 2.0, "steps": 2}]
    table = {"pressure": [0.0, 10.0], "values": [0.5, 0.5]}
    one, other = (solved(each, history=history).contact_history("main") for each in (0.5, table))
    for name in ("traction", "slip", "dissipation"):
        assert np.array_equal(getattr(one, name)[:], getattr(other, name)[:])


def test_friction_over_temperature_is_that_of_the_surfaces(tmp_path: Path) -> None:
    tables: dict[str, Any] = {
        "geometry": cylinder(size=0.06),
        "bodies": {
            name: {**body, "expansion": 0.0, "reference_temperature": 20.0}
            for name, body in PAD["bodies"].items()
        },
        "contacts": {
            "main": {
                **PAD["contacts"]["main"],
                "friction": {"temperature": [20.0, 220.0], "values": [0.2, 0.6]},
            }
        },
        "loads": {
            "press": press(),
            "heat": {
                "type": "temperature",
                "bodies": ["upper"],
                "points": [[-13.0, -1.0], [13.0, -1.0], [-13.0, 40.0], [13.0, 40.0]],
                "values": [420.0, 420.0, 420.0, 420.0],
                "history": [HOLD, {"ramp": 0.5, "until": 2.0, "steps": 2}],
            },
            "shear": {
                **TOP,
                "direction": "x",
                "control": "displacement",
                "history": [{"hold": True, "until": 2.0}, {"ramp": 0.05, "until": 3.0, "steps": 2}],
            },
        },
        "supports": BASE,
    }
    history = fretfe.run(parse_case(pad(**tables))).contact_history("main")
    # The upper body is at 220, the lower one at 20 degrees.
    assert np.allclose(history.friction.at(-1), 0.4, atol=1e-12)
    pressure, shear = history.surface.weights @ history.traction[-1]
    assert abs(shear) == pytest.approx(0.4 * pressure, rel=1e-9)
    tables["loads"].pop("heat")
    with pytest.raises(CaseError, match="expected a load that changes the temperature of upper"):
        fretfe.run(parse_case(pad(**tables)))
