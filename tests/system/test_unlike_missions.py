# SPDX-License-Identifier: LGPL-3.0-or-later
"""Unlike bodies whose edge P moves: half cycles as the slip of nodes turns round."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from cases.pad_cases import PAD, pad

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact, SlipZone
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import SLIP, Solution
from fretfe.idealise import idealise

PARAMETERS = {"upper_radius": 50.0, "lower_radius": 0.0, "size": 0.01}
SIZES = {"upper_width": 120.0, "upper_height": 120.0, "lower_width": 120.0, "lower_height": 120.0}
ALUMINIUM, STEEL = {"young": 70e3, "poisson": 0.3}, {"young": 210e3, "poisson": 0.3}
TITANIUM = {"young": 114e3, "poisson": 0.34}
SOFT, HARD = {"young": 20e3, "poisson": 0.1}, {"young": 400e3, "poisson": 0.25}
Ways = list[dict[str, object]]


def solved(
    press: Ways,
    shear: Ways,
    upper: dict[str, float] = ALUMINIUM,
    lower: dict[str, float] = STEEL,
    friction: float = 0.4,
) -> tuple[Solution, Contact]:
    """A cylinder under P and Q; all substates."""
    top = {"type": "platen", "boundary": "upper_top", "control": "force"}
    case = pad(
        geometry={"template": "cylinder", "parameters": PARAMETERS | SIZES},
        bodies={"upper": upper, "lower": lower},
        contacts={"main": PAD["contacts"]["main"] | {"friction": friction, "friction_from": 0.0}},
        loads={
            "press": top | {"direction": "y", "history": press},
            "shear": top | {"direction": "x", "history": shear},
        },
    )
    outcome = solve_half_planes(idealise(parse_case(case)), 600)
    (contact,) = evaluate(outcome.solution, outcome.unit_factors)
    return outcome.solution, contact


def wave(steps: int, mean: float, amplitude: float, phase: float = 0.0) -> Ways:
    """Two periods of a sine, after a ramp to where it begins."""
    turn: dict[str, object] = {"wave": "sine", "mean": mean, "amplitude": amplitude, "phase": phase}
    start = mean + amplitude * np.sin(np.radians(phase))
    ramp: dict[str, object] = {"ramp": float(start), "until": 1.0, "steps": 4}
    return [ramp, turn | {"period": 1.0, "cycles": 2, "steps_per_cycle": steps}]


def out_of_phase(steps: int) -> tuple[Solution, Contact]:
    """Beta of .2, with P and Q a quarter of a period apart."""
    return solved(wave(steps, -600.0, 100.0, -90.0), wave(steps, 20.0, 60.0))


def last_steps(
    solution: Solution, inward: int, position: Array
) -> Iterator[tuple[int, Array, Array]]:
    """States of the last cycle, slip of nodes that slip at an edge in the step to them, and where.

    Places are ways inward of the edge, infinite of other nodes.
    """
    (history,) = solution.contacts
    first, last = solution.cycle or (0, 0)
    for state in range(first + 1, last + 1):
        slip = np.diff(history.slip[state - 1 : state + 1, :, 0], axis=0)[0]
        s = inward * (history.surface.arc - position[state])
        near = (s > 0) & (s < 0.5)
        slips = near & (history.status[state] == SLIP)
        yield state, np.where(slips, slip, 0.0), np.where(near, s, np.inf)


def longest(solution: Solution, inward: int, position: Array) -> float:
    """Longest way from an edge to what has slipped since slip turned round, in the last cycle.

    What slips only where the edge has not been before has no part in that.
    """
    arc = inward * solution.contacts[0].surface.arc
    found, inner, edge, way = 0.0, 0.0, math.inf, 0
    for state, slip, _ in last_steps(solution, inward, position):
        size = np.abs(slip)
        if not size.max() > 1e-6:  # a hundredth of the largest
            continue
        now = int(np.sign(slip[size.argmax()]))
        place = float(arc[size > 1e-2 * size.max()].max())
        inner = max(inner, place) if now == way and place > edge else place
        edge, way = inward * float(position[state]), now
        found = max(found, inner - edge)
    return found


@pytest.fixture(scope="module")
def by_nodes() -> list[float]:
    solution, contact = out_of_phase(30)
    return [longest(solution, each.inward, each.position) for each in contact.stations]


@pytest.mark.parametrize("steps", [6, 20, pytest.param(60, marks=pytest.mark.slow)])
def test_zones_are_told_where_they_are_longest(by_nodes: list[float], steps: int) -> None:
    """As far as nodes show, with any steps: .137 to .139; where K_T turns it is .08 to .09.

    Bars have what steps misplace of a zone as P moves its edge.
    """
    _, contact = out_of_phase(steps)
    for station, truth in zip(contact.stations, by_nodes, strict=True):
        zone = station.longest_zone
        assert zone is not None
        assert zone.resolved
        assert abs(zone.length - truth) < zone.spread + 0.003  # an element there
        assert zone.spread < (0.02 if steps < 60 else 0.01) * zone.length


def last_zones(contact: Contact) -> list[SlipZone]:
    return [each.slip_zones[-1] for each in contact.stations]


def moving(solution: Solution, inward: int, position: Array) -> float:
    """Longest way from an edge to what slips on from it in one step of the last cycle."""
    found = 0.0
    for _, slip, s in last_steps(solution, inward, position):
        order = np.argsort(s)[: np.count_nonzero(np.isfinite(s))]
        size = slip[order] * np.sign(slip[np.abs(slip).argmax()])
        if not size.max() > 1e-6:
            continue
        stuck = np.flatnonzero(size[1:] <= 1e-2 * size.max())
        found = max(found, float(s[order[stuck[0]]]))
    return found


@pytest.mark.slow
def test_a_zone_that_travels_with_the_edge_is_what_slips_at_one_time() -> None:
    """P and Q in proportion: a strip of .025 at the edge slips as it moves by .4.

    All places that it has passed were told, .36. Coarse steps cover more than the strip: that is in
    the bar, up to "not known".
    """
    solution, fine = solved(wave(240, -300.0, 100.0), wave(240, 0.0, 40.0), SOFT, HARD)
    station, zone = fine.stations[0], last_zones(fine)[0]
    truth = moving(solution, station.inward, station.position)
    assert 0.02 < truth < 0.035
    assert abs(zone.length - truth) < zone.spread + 0.003
    assert zone.spread < 0.15 * zone.length
    for steps in (6, 20, 60):
        _, contact = solved(wave(steps, -300.0, 100.0), wave(steps, 0.0, 40.0), SOFT, HARD)
        coarse = last_zones(contact)[0]
        assert abs(coarse.length - zone.length) < coarse.spread + zone.spread
        assert coarse.resolved is (steps == 60)


def test_shear_before_a_last_load_of_p_alone_is_told() -> None:
    """Without a cycle, P down and up again after Q: zones of Q, not the last step alone."""

    def ramps(*ways: tuple[float, float]) -> Ways:
        return [{"ramp": value, "until": until, "steps": 5} for value, until in ways]

    turned = (120.0, 2.0), (-120.0, 2.5), (0.0, 3.0)
    press, shear = ramps((-600.0, 1.0)), ramps((0.0, 1.0), *turned)
    still: Ways = [{"hold": True, "until": 5.0}]
    alone = solved([*press, {"hold": True, "until": 5.0}], [*shear, *still])[1]
    pressed = ramps((-150.0, 4.0), (-600.0, 5.0))
    contact = solved([*press, {"hold": True, "until": 3.0}, *pressed], [*shear, *still])[1]
    for station, other in zip(contact.stations, alone.stations, strict=True):
        zones, others = (
            sorted(each.length for each in one.slip_zones if each.resolved)
            for one in (station, other)
        )
        assert zones[-1] == pytest.approx(others[-1], rel=0.02)
        assert others[-1] > 0.1


def test_zones_of_loads_in_phase_do_not_depend_on_steps() -> None:
    """P and Q in phase: .115 and .152 in first loading, then .046 with 200 steps a period."""
    for steps in (8, 20, 60):
        loads = wave(steps, -600.0, 200.0), wave(steps, 0.0, 100.0, 180.0)
        _, contact = solved(*loads, TITANIUM, STEEL | {"poisson": 0.29}, friction=0.6)
        first = [each.slip_zones[0] for each in contact.stations]
        assert [each.length for each in first] == pytest.approx([0.1148, 0.1516], abs=0.002)
        steady = last_zones(contact)[0]
        assert abs(steady.length - 0.0462) < steady.spread + 0.0011
        assert steady.spread < (0.5 if steps < 20 else 0.25) * steady.length
