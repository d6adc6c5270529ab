# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes from which P goes: what they told before holds, and they touch anew."""

from __future__ import annotations

import numpy as np
import pytest
from cases.halfplane_problems import LIMIT, LOAD, PRESS_STEPS, problem, solved

from fretfe.errors import ConvergenceError, ModelError

HELD = [0.0, 0.3, -0.3, 0.3]


def test_a_contact_that_opens_at_the_end_tells_what_was_before() -> None:
    """Q to and fro at one P; then both go."""
    p, q = LOAD * np.ones(len(HELD)), LIMIT * np.array(HELD)
    whole = solved(problem([*p, 0.5 * LOAD, 0.0], [*q, 0.1 * LIMIT, 0.0]), 150)
    before = solved(problem(p, q), 150)
    last = PRESS_STEPS + len(HELD)
    for one, other in zip(whole.stations, before.stations, strict=True):
        # Elements are graded to another last state: their errors are a ten-thousandth.
        np.testing.assert_allclose(one.k_n[: last + 1], other.k_n, rtol=2e-4)
        assert np.isnan(one.k_n[-1])
        same = [zone for zone in one.slip_zones if zone.end <= last]
        for zone, alone in zip(same, other.slip_zones, strict=True):
            assert zone.length == pytest.approx(alone.length, abs=zone.spread)
    assert whole.normal_force[-1] == whole.shear_force[-1] == 0.0


def test_bodies_that_touch_again_have_forgotten_what_was() -> None:
    """The second time everything is as it was the first time, to round-off."""
    p = LOAD * np.array([0.5, 1.0, 1.0, 1.0, 0.0, 0.5, 1.0, 1.0])
    q = LIMIT * np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0, 0.3])
    for station in solved(problem(p, q, frictional_press=True), 150).stations:
        first, again = station.k_n[PRESS_STEPS + 3], station.k_n[PRESS_STEPS + 8]
        assert again == pytest.approx(first, rel=1e-12)
        assert station.position[-1] == pytest.approx(station.position[PRESS_STEPS + 3], rel=1e-12)
        # 1 - sqrt(1 - Q/(f P)) of a cylinder, the same each time.
        ends = PRESS_STEPS + 3, PRESS_STEPS + 8
        lengths = [each.length for each in station.slip_zones if each.end in ends]
        assert lengths == pytest.approx([1 - np.sqrt(0.7)] * 2, abs=0.005)


@pytest.mark.parametrize(
    ("p", "q", "kind", "message"),
    [
        ([1.0, -0.1], 0.0, ConvergenceError, "P >= 0 in every step, found -0.157"),
        ([1.0, 0.0], [0.1, 0.1], ConvergenceError, "expected |Q| < f P in every step"),
        ([0.0, 0.0], 0.0, ModelError, "expected a normal force P > 0 in some step, found 0"),
    ],
    ids=["pulled", "sheared without P", "never pressed"],
)  # fmt: skip
def test_loads_that_half_planes_cannot_carry(
    p: list[float], q: list[float] | float, kind: type[Exception], message: str
) -> None:
    with pytest.raises(kind) as caught:
        problem(LOAD * np.array(p), LIMIT * np.array(q)).require_partial_slip()
    assert message in str(caught.value)
