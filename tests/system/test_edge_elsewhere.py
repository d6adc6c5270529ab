# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes that refine themselves tell where an edge is in every state that decides a slip zone.

Slip is deepest while P is least: a mesh that is fine at the edge of the largest P alone then knows
neither the place of the edge nor what it holds. Half-planes tell the range, however they step.
"""

from __future__ import annotations

from typing import Any

import pytest
from cases.pad_cases import SLIDING, TOP, cylinder, pad, ramps

import fretfe
from fretfe.case import parse_case
from fretfe.results.model import Result

PRESSURES = [600.0, 200.0, 600.0, 200.0, 600.0]
# By half-planes with 1 and with 15 steps a ramp.
RANGE = {25.0: 5.094, 100.0: 20.38}


def data(tensions: list[float], steps: int, pressures: list[float] = PRESSURES) -> dict[str, Any]:
    hold = [{"hold": True, "until": float(len(pressures))}]
    pull = {"type": "traction", "boundary": "lower_right", "direction": "normal"}
    size = dict.fromkeys(("upper_width", "upper_height"), 16.0)
    block = dict.fromkeys(("lower_width", "lower_height"), 20.0)
    return pad(
        geometry=cylinder(**size, **block, zone=2.0),
        edges={"tolerance": 0.02},
        contacts={"main": {**pad()["contacts"]["main"], "friction": 0.5, "friction_from": 0.0}},
        supports=SLIDING,
        loads={
            "press": {**TOP, "direction": "y", "history": ramps(pressures, steps, -1.0)},
            "shear": {**TOP, "direction": "x", "history": hold},
            "bulk": {**pull, "history": ramps(tensions, steps)},
        },
    )


def solved(tension: float, steps: int) -> Result:
    turns = [0.0, tension, -tension, tension, -tension]
    return fretfe.run(parse_case(data(turns, steps)))


@pytest.mark.fem
@pytest.mark.parametrize(
    ("tension", "steps", "within"),
    [(25.0, 1, 0.05), (25.0, 2, 0.02), (100.0, 1, 0.02), (100.0, 2, 0.01)],
)
def test_a_zone_begins_where_the_edge_is_while_p_is_least(
    tension: float, steps: int, within: float
) -> None:
    result = solved(tension, steps)
    assert result.refinement is not None
    assert result.refinement.converged
    assert len(result.refinement.passes) <= 6
    for station in result.contacts[0].stations:
        assert station.largest_range == pytest.approx(RANGE[tension], rel=within)
        zone = station.longest_zone
        assert zone is not None
        assert zone.resolved
        assert zone.told[0] == pytest.approx(station.largest_slip, rel=0.1)
    assert result.headline.trust == "trusted"


@pytest.mark.fem
@pytest.mark.parametrize(
    ("pressures", "tensions", "steps"),
    [
        ([600.0, 600.0, 300.0, 600.0, 300.0, 600.0], [0.0, 40.0, 0.0, 40.0, 0.0, 40.0], 2),
        ([600.0, 600.0, 200.0, 600.0, 200.0, 600.0], [0.0, 100.0, 30.0, 100.0, 30.0, 100.0], 1),
    ],
)
def test_elements_do_not_chase_zones_beside_a_longer_one(
    pressures: list[float], tensions: list[float], steps: int
) -> None:
    """The pull is held by the pad; after first loading hardly anything slips."""
    tables = data(tensions, steps, pressures)
    del tables["loads"]["shear"]
    result = fretfe.run(parse_case(tables))
    assert not result.faults
    assert result.refinement is not None
    assert result.refinement.converged
    assert len(result.refinement.passes) <= 5
    assert result.headline.trust == "trusted"


@pytest.mark.fem
def test_a_zone_may_begin_as_bodies_part() -> None:
    """From and to zero with one step a ramp: no edge is left as the last half cycle ends."""
    tables = data([0.0, 40.0, 10.0, 40.0, 0.0], 1, [200.0, 800.0, 200.0, 800.0, 0.0])
    tables["loads"]["shear"]["history"] = ramps([0.0, 120.0, -20.0, 120.0, 0.0], 1)
    result = fretfe.run(parse_case({**tables, "edges": {"tolerance": 0.05}}))
    assert not result.faults
    assert result.refinement is not None
    for station in result.contacts[0].stations:
        # That of half-planes under 600, with the half-width to the power 1/2.
        assert station.reported_k_n == pytest.approx(1237.8 * (800 / 600) ** 0.25, rel=0.01)
