# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damage of counted cycles: lives by hand, a uniaxial history, a mission of half-planes."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HOLD, TOP, pad, press
from cases.stored_runs import solved
from decision.test_field import field_of
from decision.test_material import WALKER, write
from scipy.optimize import brentq

from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND as HALFPLANE
from fretfe.case import isotropic, parse_case
from fretfe.decision.assess import assess
from fretfe.decision.damage import SmoothLife, counted_damage
from fretfe.decision.near_field import NearField
from fretfe.decision.texts import details
from fretfe.results.model import Result

# Amplitudes of reversed stress [MPa] and lives: N = 1e5 (300/S)^5.
CYCLES = np.array([1e4, 1e5, 1e7])
AMPLITUDES = 300 * (CYCLES / 1e5) ** -0.2
TABLE = {"ratio": -1.0, "cycles": CYCLES.tolist(), "amplitudes": AMPLITUDES.tolist()}


def test_lives_between_those_of_the_table_are_powers() -> None:
    life = SmoothLife.of_amplitudes(CYCLES, AMPLITUDES, -1.0)
    for amplitude in (200.0, 300.0, 400.0):
        low, high = life.damage(np.array(amplitude**2 / 210e3), 210e3)
        assert low == high == pytest.approx((amplitude / 300) ** 5 / 1e5)
    # A pulsating stress of the same σ_max ε_a: σ_max = 2 S.
    pulsating = SmoothLife.of_amplitudes(CYCLES, AMPLITUDES / math.sqrt(2), 0.0)
    assert pulsating.elastic == pytest.approx(life.elastic)
    low, high = life.damage(np.array([100.0, 600.0, 0.0]) ** 2 / 210e3, 210e3)
    assert low[0] == low[2] == 0 and high[[0, 2]] == pytest.approx(1e-7) and np.isnan(high[1])


def test_the_law_of_coffin_and_manson() -> None:
    """Solved for the life by another way, in other units."""
    life = SmoothLife.coffin_manson((1e2, 1e7), (1165.0, -0.081), (1.14, -0.67))

    def known(product: float) -> float:
        return float(
            brentq(
                lambda n: (1165 * (2 * n) ** -0.081) ** 2 / 206e3
                + 1165 * 1.14 * (2 * n) ** (-0.081 - 0.67) - product,
                1e2, 1e7,
            )
        )  # fmt: skip

    for product in (1.0, 2.0, 5.0):
        assert life.damage(np.array(product), 206e3)[1] == pytest.approx(
            1 / known(product), rel=1e-3
        )


def test_a_uniaxial_history_by_hand() -> None:
    """Two cycles, one from 200 to -200 with a smaller one from 50 to 150 on its way."""
    field, station = field_of(solved("halfplane"), 0, 1), solved("halfplane").contacts[0].edges[0]
    tension = np.array([0.0, 200.0, 50.0, 150.0, -200.0, 200.0])
    values = np.zeros((6, 1, 4))
    values[:, 0, 0] = tension
    states, none = 10 + np.arange(6), np.zeros((6, 3))
    field = replace(
        field, states=states, near=NearField(np.array([-1.0, 0.0, 1.0]), none, none, 0.3),
        smooth=replace(field.smooth, values=values),
    )  # fmt: skip
    numbers = np.zeros(2)
    station = replace(
        station,
        cycles=replace(
            station.cycles, start=np.array([12, 11]), end=np.array([13, 14]),
            count=np.array([1.0, 0.5]), k_t_range=numbers, k_t_mean=numbers,
            slip=numbers,
        ),
    )  # fmt: skip
    body = isotropic(solved("halfplane").case.bodies["lower"])
    assert body is not None
    life = SmoothLife.of_amplitudes(CYCLES, AMPLITUDES, -1.0)
    found = counted_damage(field, station, life, body, 0.0913)
    # 150 MPa with an amplitude of 50 is less than what has the longest life.
    assert found.low == pytest.approx(0.5 * (200 / 300) ** 5 / 1e5, rel=2e-3)
    assert found.high == pytest.approx(found.low + 1e-7, rel=1e-6)
    assert found.cycles == 1.5
    # A start that is later than the end goes on in the next repetition: all but the middle.
    turned = replace(station, cycles=replace(station.cycles, start=np.array([12, 14]),
                                             end=np.array([13, 11])))  # fmt: skip
    assert counted_damage(field, turned, life, body, 0.0913).low == pytest.approx(found.low)
    lost = replace(station, cycles=replace(station.cycles, reason="K_T is unknown"))
    assert "K_T is unknown" in counted_damage(field, lost, life, body, 0.0913).reason
    short = SmoothLife.of_amplitudes(CYCLES, AMPLITUDES / 4, -1.0)
    assert "shorter life" in counted_damage(field, station, short, body, 0.0913).reason


def mission(turns: list[float]) -> Result:
    """Shear forces that are reached one after another."""
    ramps: list[dict[str, Any]] = [
        {"ramp": force, "until": 2.0 + place, "steps": 4} for place, force in enumerate(turns)
    ]
    shear = {**TOP, "direction": "x", "history": [HOLD, *ramps]}
    case = parse_case(pad(loads={"press": press(), "shear": shear}))
    return replace(HALFPLANE.solve(case, RunOptions()), backend="halfplane")


def test_a_mission_of_half_planes(tmp_path: Path) -> None:
    """Smaller cycles, which the states through the worst one leave out, once and again."""
    low = {**TABLE, "amplitudes": (AMPLITUDES / 3).tolist()}
    # The limit of the other data is beyond this table; the critical distance stays that of them.
    limit, threshold = {"range": 60.0, "ratio": -1.0}, {**WALKER, "range": 0.5}
    path = write(tmp_path, life=low, limit=limit, threshold=threshold, torsion=None)
    forces = [120.0, -120.0, 120.0, 40.0, 110.0, 0.0, 120.0]
    one, more = (assess(mission(each), path) for each in (forces, [*forces, *forces[-4:]]))
    for edge, other in zip(one.edges, more.edges, strict=True):
        assert edge.damage is not None and other.damage is not None
        assert not edge.damage.reason and not other.damage.reason
        assert 0 < edge.damage.high < other.damage.high
        assert other.damage.cycles == edge.damage.cycles + 2
    assert any("damage by Miner" in each for each in details(more))
    assert assess(mission([120.0, -120.0]), write(tmp_path)).edges[0].damage is None
