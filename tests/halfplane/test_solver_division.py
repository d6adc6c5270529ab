# SPDX-License-Identifier: LGPL-3.0-or-later
"""Steps within which the normal load moves the edges far, or loads out of phase turn."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, LIMIT, LOAD, problem
from reference.closed_forms import divide, solve_closed_form

from fretfe.contact.march import LARGEST_MOVE, LEAST_SHEAR, MOST_PARTS, TOLERATED
from fretfe.errors import ConvergenceError
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.step_ends import at_step_ends, division_notes
from fretfe.halfplane import solve_half_planes
from fretfe.halfplane.solver import HalfPlaneOutcome
from fretfe.history.stream import Storage
from fretfe.idealise import HalfPlaneProblem
from fretfe.loads.history import PARTS, within_steps

# P between a hundredth and all of LOAD, with Q from 0 to a fifth of f LOAD, on a line and back.
LOW, SHEAR = 0.05, 0.2 * LIMIT


def ramps(steps: int) -> HalfPlaneProblem:
    """Pressed without friction, then up and down twice in some steps each way."""
    rise = np.linspace(0.0, 1.0, steps + 1)[1:]
    share = np.concatenate([[0.0], *(2 * [rise, rise[::-1] - 1 / steps])])
    return problem(LOAD * (LOW + (1 - LOW) * share), SHEAR * share, cycle=2 * steps)


@cache
def solved(steps: int) -> tuple[HalfPlaneOutcome, Contact]:
    outcome = solve_half_planes(ramps(steps), 120)
    assert outcome.failure is None
    contacts = evaluate(outcome.solution, outcome.unit_factors)
    return outcome, at_step_ends(outcome.solution, contacts)[1][0]


def exact_range() -> float:
    """Integral of dQ/(pi sqrt(2 a)) along the line, a = sqrt(P/LOAD): sampled finely."""
    share = np.linspace(0.0, 1.0, 200001)
    a = np.sqrt(LOW + (1 - LOW) * share)
    return float(np.trapezoid(SHEAR / (np.pi * np.sqrt(2 * a)), share))


@pytest.mark.parametrize("steps", [1, 3])
def test_the_range_is_that_of_the_way_of_the_loads(steps: int) -> None:
    """The mean of both ends would be 20 % too large in ramps of one step."""
    _, contact = solved(steps)
    for station in contact.stations:
        assert station.k_t_range == pytest.approx(exact_range(), rel=3e-3)
        assert station.k_range_parts.steps < 3e-3 * exact_range()


def test_an_edge_that_moves_more_than_its_shear_does_not_slip_in_the_steady_cycle() -> None:
    """dK_T < f dK_I: friction work is that of what is left of the first loading, next to none."""
    _, once = solved(1)
    _, often = solved(24)
    scale = FRICTION * LOAD * 1e-3
    assert once.dissipation < 1e-3 * scale
    assert often.dissipation < 1e-3 * scale


def test_only_the_ends_of_steps_are_reported() -> None:
    outcome, contact = solved(1)
    count = len(ramps(1).history.times)
    assert len(outcome.solution.times) > count
    assert contact.stations[0].last == count - 1
    assert contact.half_width.shape == contact.stations[0].k_t.shape == (count,)
    solution, _ = at_step_ends(outcome.solution, ())
    np.testing.assert_array_equal(solution.times, ramps(1).history.times)
    assert solution.cycle == (count - 3, count - 1)
    assert solution.contacts[0].traction.shape[0] == count
    all_states = np.asarray(outcome.solution.contacts[0].dissipation)
    reported = np.asarray(solution.contacts[0].dissipation)
    assert reported.sum() == pytest.approx(all_states.sum(), rel=1e-12)
    assert solution.parts.sum() == len(outcome.solution.times) - 1
    (note,) = division_notes(outcome.solution)
    assert note.startswith(
        f"2 of {count - 1} steps, the first one step {count - 2}, were solved in"
    )
    assert all(
        zone.end < count and zone.start < zone.end for zone in contact.stations[0].slip_zones
    )


def test_edges_move_little_within_the_parts() -> None:
    """By the part of the half-width that is aimed at, or from one node to the next one."""
    outcome, _ = solved(1)
    solution, (contact,) = outcome.solution, outcome.solution.contacts
    normal, shear = np.moveaxis(np.asarray(contact.traction), 2, 0) @ contact.surface.weights
    pressed = np.asarray(contact.traction[:, :, 0] > 0)
    half_width = pressed @ contact.surface.weights / 2
    mean = (half_width[1:] + half_width[:-1]) / 2
    moved, nodes = np.abs(np.diff(half_width)) / mean, np.abs(np.diff(pressed.sum(axis=1)))
    sheared = np.abs(shear[1:]) > LEAST_SHEAR * FRICTION * normal[1:]
    sheared[: solution.ends[-5]] = False
    assert sheared.sum() > 50
    far = moved > TOLERATED * LARGEST_MOVE
    assert nodes[far & sheared].max(initial=0) <= 2
    assert np.diff(solution.ends).max() < MOST_PARTS


def test_steps_at_constant_load_are_not_divided() -> None:
    given = problem(LOAD, np.linspace(0.0, SHEAR, 4))
    assert solve_half_planes(given, 60).solution.step is None


def test_steps_without_friction_are_not_divided() -> None:
    given = problem([LOW * LOAD, LOAD], 0.0, friction=0.0)
    assert solve_half_planes(given, 60).solution.step is None


def test_closed_forms_take_the_same_way() -> None:
    steps, shares = divide(ramps(1))
    summary, _ = solve_closed_form(ramps(1).divided(steps, shares))
    for station in summary.stations:
        assert station.k_t_range == pytest.approx(exact_range(), rel=1e-3)


def test_a_bar_holds_what_undivided_steps_miss(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("fretfe.contact.march.LARGEST_MOVE", 1e9)
    outcome = solve_half_planes(ramps(1), 120)
    assert outcome.solution.step is None
    (contact,) = evaluate(outcome.solution, outcome.unit_factors)
    for station in contact.stations:
        error = abs(station.k_t_range - exact_range())
        assert 0.1 * exact_range() < error < station.k_range_spread


def test_loads_within_a_step_of_a_wave() -> None:
    """Seven steps a cycle: the polynomial through nine places of a step is the sine."""
    times = np.linspace(0.0, 1.0, 8)
    fine = np.linspace(0.0, 1.0, 7 * PARTS + 1)
    between = np.sin(2 * np.pi * fine)[:-1].reshape(7, PARTS, 1)[:, 1:]
    steps, shares = np.array([1, 1, 4, 7]), np.array([0.03, 0.77, 0.5, 1.0])
    found = within_steps(np.sin(2 * np.pi * times)[:, None], between, steps, shares)
    wanted = np.sin(2 * np.pi * (steps - 1 + shares) / 7)
    assert found[:, 0] == pytest.approx(wanted, abs=1e-9)


def waves(steps: int) -> HalfPlaneProblem:
    """Shear and tension a quarter of a cycle apart, the normal load in between."""

    def loads(angle: np.ndarray) -> np.ndarray:
        normal = LOAD * (1 + 0.1 * np.cos(angle - np.pi / 4))
        shear, tension = 0.2 * LIMIT * np.cos(angle), 0.2 * FRICTION * np.sin(angle)
        return np.column_stack([normal, shear, 0 * angle, tension])

    cycles = 3
    angle = 2 * np.pi * np.arange(cycles * steps + 1) / steps
    normal, shear, _, tension = loads(angle).T
    given = problem(
        np.append(np.full(4, normal[0]), normal),
        np.append(np.linspace(0, shear[0], 5)[:-1], shear),
        0.0,
        np.append(np.zeros(4), tension),
        cycle=steps,
    )
    times = len(given.history.times)
    begin = times - 1 - cycles * steps
    table = np.column_stack(
        [given.normal_force, given.shear_force, given.moment, given.bulk_tension]
    )
    shares = np.arange(1, PARTS) / PARTS
    between = table[:-1, None] + shares[:, None] * np.diff(table, axis=0)[:, None]
    instants = angle[:-1, None] + 2 * np.pi / steps * shares
    between[begin:] = loads(instants.ravel()).reshape(-1, PARTS - 1, 4)
    return replace(given, between=between)


def test_slip_zones_out_of_phase_in_few_steps() -> None:
    few, many = (solve_half_planes(waves(steps), 160) for steps in (10, 40))
    assert few.solution.step is not None
    assert many.solution.step is None
    zones = []
    for outcome in (few, many):
        (contact,) = evaluate(outcome.solution, outcome.unit_factors)
        contact = at_step_ends(outcome.solution, (contact,))[1][0]
        zones.append([max(z.length for z in s.slip_zones[-2:]) for s in contact.stations])
    assert zones[0] == pytest.approx(zones[1], rel=0.03)


def test_a_run_goes_on_among_divided_steps(tmp_path: Path) -> None:
    def stop(step: int, *_: object) -> None:
        if step == 8:
            raise ConvergenceError("enough")

    given, states = ramps(1), Storage(tmp_path)
    stopped = solve_half_planes(given, 120, stop, storage=states)
    assert stopped.failure is not None
    assert at_step_ends(stopped.solution, ())[0].times[-1] == given.history.times[8]
    steps: list[int] = []
    again = solve_half_planes(
        given, 120, lambda step, *_: steps.append(step), storage=replace(states, resume=True)
    )
    assert steps[0] == 9
    wanted, _ = solved(1)
    np.testing.assert_array_equal(again.solution.times, wanted.solution.times)
    np.testing.assert_array_equal(again.solution.ends, wanted.solution.ends)
    for name in ("traction", "slip", "dissipation"):
        one, other = (
            np.asarray(getattr(each.solution.contacts[0], name)) for each in (again, wanted)
        )
        np.testing.assert_array_equal(one, other)


def test_repeated_steps_are_repeated_with_their_parts() -> None:
    """Four cycles more: the steady one is not solved again, and gives what solving gives."""
    share = np.tile([1.0, 0.0], 6)
    given = problem(LOAD * (LOW + (1 - LOW) * share), SHEAR * share, cycle=2)
    known, every = (
        solve_half_planes(given, 80, until_steady=each).solution for each in (True, False)
    )
    (repeat,) = known.repeats
    assert len(known.times) - repeat.first > 50
    np.testing.assert_array_equal(known.ends, every.ends)
    for name in ("traction", "slip"):
        one, other = (np.asarray(getattr(each.contacts[0], name)) for each in (known, every))
        assert one == pytest.approx(other, abs=1e-9 * np.abs(other).max())
    (told,) = at_step_ends(known, ())[0].repeats
    assert (told.last, told.period) == (len(given.history.times) - 1, 2)
