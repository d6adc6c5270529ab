# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error bars that limits of the model add to."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import cycled_sphere
from cases.solid_runs import FRICTION, stationed_sphere

from fretfe.case import parse_case
from fretfe.evaluate.limits import ModelLimit, with_crossed_spreads
from fretfe.reason import Kind

NICKEL = {"elastic": {"cubic": [252e3, 161e3, 131e3]}}
OCTAHEDRAL = {**NICKEL, "orientation": {"y": [1, 1, 1], "x": [1, -1, 0]}}


@pytest.mark.parametrize(("body", "cross"), [(NICKEL, 0.0), (OCTAHEDRAL, 0.144)])
def test_k_n_of_crystals_holds_what_shear_does_to_the_pressure(
    body: dict[str, object], cross: float
) -> None:
    """Normal <111>, .7 f P, f = .5: 2.4 % by half-spaces, fits find 5.3: .4 f times .144."""
    result = stationed_sphere()
    case = parse_case(cycled_sphere.tables(0.5) | {"bodies": {"upper": body, "lower": body}})
    (found,) = with_crossed_spreads(
        result.contacts, result.solution.contacts, case.bodies, case.model.plane
    )
    for before, after in zip(result.contacts[0].stations, found.stations, strict=True):
        (k_n, bar), (same, wider) = before.decisive_k_n, after.decisive_k_n
        assert same == k_n
        added = 0.5 * cross * FRICTION * k_n
        assert np.sqrt(wider**2 - bar**2) == pytest.approx(added, rel=0.01, abs=1e-6)


@pytest.mark.parametrize(
    ("found", "limit", "used"), [(0.1, 0.2, 0.5), (0.0, 0.0, 0.0), (0.1, 0.0, math.inf)]
)
def test_limits_may_be_zero(found: float, limit: float, used: float) -> None:
    """The temperature beyond a table, for one."""
    assert ModelLimit("main", Kind.TEMPERATURE_TABLE, "", found, limit).used == used
