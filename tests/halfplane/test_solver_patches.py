# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two bumps on one surface: patches that merge and part, against closed forms.

The gap C (x^2 - c^2)^2 / 2 presses p = C E* |x| sqrt((a^2 - x^2) (x^2 - b^2)) while there are two
patches b < |x| < a, with a^2 + b^2 = 2 c^2 and P = pi C E* (a^2 - b^2)^2 / 8, and
p = C E* (x^2 + d) sqrt(a^2 - x^2) with d = a^2/2 - c^2 and P = pi C E* (a^4/8 + d a^2/2) after they
have merged: the Cauchy integrals of both have the slope of the gap as polynomial part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from cases.halfplane_problems import problem
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.plane.patches_in_time import separate_patches
from fretfe.evaluate.step_ends import at_step_ends
from fretfe.halfplane import solver
from fretfe.history.solution import Solution
from fretfe.reason import Kind

E_STAR, CURVATURE = 100.0, 0.01
# The patches of bumps at -1 and 1 merge at this load.
MERGING = np.pi * CURVATURE * E_STAR / 2
APART, JOINED = 0.6 * MERGING, 1.5 * MERGING
NODES = np.linspace(-1.9, 1.9, 601)


@dataclass(frozen=True)
class Bumps:
    """The profile, as far as the solver asks for it."""

    e_star: float = E_STAR

    def gap(self, x: ArrayLike) -> Array:
        return np.asarray(CURVATURE / 2 * (np.square(x) - 1.0) ** 2)


def edges(load: float) -> tuple[float, float]:
    """Inner and outer edge, b and a; b is 0 after the patches have merged."""
    ratio = load / MERGING
    if ratio <= 1.0:
        return np.sqrt(1 - np.sqrt(ratio)), np.sqrt(1 + np.sqrt(ratio))
    # pi C E* (3 a^4/8 - a^2/2) = P
    return 0.0, np.sqrt((1 + np.sqrt(1 + 3 * ratio)) * 2 / 3)


def outer_k_n(load: float) -> float:
    inner, outer = edges(load)
    if inner:
        return CURVATURE * E_STAR * outer * np.sqrt(2 * outer * (outer**2 - inner**2))
    return CURVATURE * E_STAR * (1.5 * outer**2 - 1) * np.sqrt(2 * outer)


def inner_k_n(load: float) -> float:
    inner, outer = edges(load)
    return CURVATURE * E_STAR * inner * np.sqrt(2 * inner * (outer**2 - inner**2))


def solve(
    loads: Sequence[float],
    shear: ArrayLike = 0.0,
    moment: ArrayLike = 0.0,
    nodes: Array = NODES,
    **options: float,
) -> tuple[Solution, tuple[Contact, ...]]:
    given = problem(loads, shear, moment, profile=Bumps(), **options)  # type: ignore[arg-type]
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(solver, "contact_grid", lambda *_: nodes)
        # Their edges are known in closed form for one patch only.
        changed.setattr(solver, "_neighbours", lambda *_: None)
        outcome = solver.solve_half_planes(given)
    assert outcome.failure is None
    solution = separate_patches(outcome.solution)
    return at_step_ends(solution, evaluate(solution, outcome.unit_factors))


@cache
def up_and_down() -> tuple[Solution, tuple[Contact, ...]]:
    """Apart in states 0 to 6, merged in 7 and 8, apart in 9 and 10, merged in 11, then apart."""
    return solve([APART, JOINED, JOINED, APART, APART, JOINED, APART], friction=0.0)


def test_each_patch_is_a_contact_and_so_is_the_merged_one() -> None:
    solution, contacts = up_and_down()
    assert [each.name for each in contacts] == ["main[1]", "main[2]", "main[3]"]
    assert {each.pair for each in contacts} == {"main"}
    left, right, merged = (each.intervals for each in solution.contacts)
    assert left == right == ((0, 6), (9, 10), (12, 12))
    assert merged == ((7, 8), (11, 11))
    total = np.sum([each.normal_force for each in contacts], axis=0)
    assert total[[6, 7, 12]] == pytest.approx([APART, JOINED, APART], rel=1e-9)
    assert contacts[0].normal_force[[6, 10, 12]] == pytest.approx(APART / 2, rel=1e-6)
    assert contacts[0].normal_force[[7, 8, 11]] == pytest.approx(0.0)


def test_edges_and_factors_of_all_patches() -> None:
    _, (left, right, merged) = up_and_down()
    inner, outer = edges(APART)
    places = [(-outer, -inner), (inner, outer)]
    for patch, expected in zip((left, right), places, strict=True):
        for state in (6, 9, 12):
            found = [each.position[state] for each in patch.stations]
            assert found == pytest.approx(expected, abs=5e-4)
        assert all(np.isnan(each.position[[7, 8, 11]]).all() for each in patch.stations)
    factors = [each.k_n[-1] for patch in (left, right) for each in patch.stations]
    far, near = outer_k_n(APART), inner_k_n(APART)
    assert factors == pytest.approx([far, near, near, far], rel=0.01)
    for each in merged.stations:
        assert abs(each.position[8]) == pytest.approx(edges(JOINED)[1], abs=5e-4)
        assert each.k_n[8] == pytest.approx(outer_k_n(JOINED), rel=0.01)
        assert np.isnan(each.k_n[[6, 9, 12]]).all()


def events(patch: Contact) -> str:
    (found,) = (each.text for each in patch.warnings if each.kind is Kind.PATCH_EVENTS)
    return found


def test_merging_and_parting_are_told() -> None:
    _, (left, right, merged) = up_and_down()
    for patch, other, place in ((left, right, "-0."), (right, left, "0.")):
        text = events(patch)
        assert f"merges with {other.name} into main[3] in step 7 (time 7, x = {place}" in text
        assert f"arises where main[3] parts in step 9 (time 9, x = {place}" in text
        assert text.count(") and 1 time later") == 2
    text = events(merged)
    assert (
        "arises where main[1] and main[2] merge in step 7 (time 7, x = 0) and 1 time later" in text
    )
    assert "parts into main[1] and main[2] in step 9 (time 9, x = 0) and 1 time later" in text


def test_an_edge_that_did_not_exist_has_no_range() -> None:
    """Shear cycles while the patches merge and part: only what was there all the time is known."""
    steps = np.linspace(0, 4 * np.pi, 25)
    load = MERGING * (1.0 + 0.4 * np.sin(steps))
    _, contacts = solve(load.tolist(), 0.02 * np.cos(steps), cycle=12)
    for each in contacts:
        existing = each.normal_force > 0
        assert not existing[-13:].all()
        for station in each.stations:
            assert np.isnan(station.k_t_range)
            assert np.isnan(station.k_i_range)
            assert station.slip_zones == ()
            assert np.isnan(station.k_t[1:][~existing[1:]]).all()
        assert {station.lack.kind for station in each.stations} == {Kind.ABSENT}
        unknown = [one for one in each.warnings if one.kind is Kind.FACTORS_UNKNOWN]
        assert unknown and all("the patch exists in " in one.text for one in unknown)
    known = [each for each in contacts if np.isfinite(each.stations[0].k_n[-1])]
    assert known


@pytest.mark.parametrize("lowest", [0.1, 0.9])
def test_a_patch_that_is_there_but_for_little_load_has_its_range(lowest: float) -> None:
    """P and Q rise and fall together; the bar has what the patches do before they merge.

    Truth is the sum of all increments of full stick at the outer edge, of two patches and of one.
    """
    rising = MERGING * np.geomspace(lowest, 30.0, 25)
    load = np.concatenate([rising, rising[-2::-1], rising[1:], rising[-2::-1]])
    nodes = 2.9 / 1.9 * NODES
    _, contacts = solve(load.tolist(), 0.1 * load, nodes=nodes, cycle=48)
    forces = np.linspace(lowest, 30.0, 3001) * MERGING
    inner, outer = np.transpose([edges(force) for force in forces])
    factors = np.sqrt(outer / 2) / (np.pi * np.sqrt(outer**2 - inner**2))
    truth = 0.1 * np.trapezoid(factors, forces)
    *apart, merged = contacts
    for station in merged.stations:
        parts = station.k_range_parts
        bar = math.hypot(parts.discretisation, parts.beside)
        assert abs(station.k_t_range - truth) < bar < 0.1 * truth
        assert not station.lack.text
    kinds = {station.lack.kind for each in apart for station in each.stations}
    assert kinds == {Kind.ABSENT}


def test_shear_at_all_four_edges() -> None:
    """Full stick at constant P: q = |x| Q / (pi sqrt((a^2 - x^2) (x^2 - b^2)))."""
    steps = np.linspace(0, 4 * np.pi, 41)
    amplitude = 0.05 * APART
    _, contacts = solve([APART] * len(steps), amplitude * np.sin(steps), cycle=20)
    assert len(contacts) == 2
    inner, outer = edges(APART)
    far, near = (
        2 * amplitude * np.sqrt(edge / (2 * (outer**2 - inner**2))) / np.pi
        for edge in (outer, inner)
    )
    ranges = [each.k_t_range for contact in contacts for each in contact.stations]
    assert ranges == pytest.approx([far, near, near, far], rel=2e-3)
    for contact in contacts:
        # Without a closed form of their factors half-planes pass for linear finite elements here,
        # and ranges have nothing to compare with.
        uncertain = (Kind.K_N_UNCERTAIN, Kind.K_N_LINEAR, Kind.FACTORS_UNKNOWN)
        assert [each for each in contact.warnings if each.kind not in uncertain] == []
        assert contact.steady
        assert np.ptp(contact.shear_force[-21:]) == pytest.approx(amplitude, rel=1e-3)
        for station in contact.stations:
            zones = station.slip_zones[-2:]
            assert all(each.length == pytest.approx(each.prediction, rel=0.1) for each in zones)


Rock = Callable[[Array], Array]


@pytest.mark.parametrize("rock", [np.sin, np.cos], ids=["from the middle", "from one side"])
def test_tracks_do_not_jump_where_the_load_goes_from_one_to_the_other(rock: Rock) -> None:
    moment = 0.6 * APART * rock(np.linspace(0, 2 * np.pi, 13))
    _, (left, right) = solve([APART] * len(moment), moment=moment)
    shares = left.normal_force / (left.normal_force + right.normal_force).clip(1e-9)
    assert shares[1:].min() < 0.3
    assert shares[1:].max() > 0.7
    assert (left.stations[1].position[5:] < 0).all()
    assert (right.stations[0].position[5:] > 0).all()
    kinds = {one.kind for each in (left, right) for one in each.warnings}
    assert Kind.PATCH_EVENTS not in kinds


def test_a_patch_that_lifts_off_and_touches_again_is_the_same() -> None:
    moment = 1.2 * APART * np.sin(np.linspace(0, 4 * np.pi, 21))
    solution, (left, right) = solve([APART] * len(moment), moment=moment)
    assert len(solution.contacts[0].intervals) > 1
    assert (left.centre[np.isfinite(left.centre)] < 0).all()
    for each in (left, right):
        text = events(each)
        assert "lifts off in step" in text
        assert "touches in step" in text
        assert "and 1 time later" in text


@pytest.fixture(scope="module")
def pressed() -> Solution:
    """Two patches under the same load in all states but the first one, not yet told apart."""
    given = problem([APART] * 5, profile=Bumps(), friction=0.0)  # type: ignore[arg-type]
    with pytest.MonkeyPatch.context() as changed:
        changed.setattr(solver, "contact_grid", lambda *_: NODES[::3])
        changed.setattr(solver, "_neighbours", lambda *_: None)
        return solver.solve_half_planes(given).solution


@pytest.mark.parametrize("gone", [[-3], [-1], [-5, -3, -1]], ids=str)
def test_two_patches_may_both_be_gone_for_a_while(pressed: Solution, gone: list[int]) -> None:
    """Without any load, as of a blade that stands still, nothing touches; the numbers stay."""
    (pair,) = pressed.contacts
    fields = {name: np.array(getattr(pair, name)[:]) for name in ("traction", "mean_traction")}
    status, area = np.array(pair.status[:]), pair.full_stick.area.copy()
    for values in (*fields.values(), status):
        values[gone] = 0
    area[gone] = -1
    units = replace(pair.full_stick, area=area)
    pair = replace(pair, **fields, status=status, full_stick=units)  # type: ignore[arg-type]
    solution = separate_patches(replace(pressed, contacts=(pair,), repeats=()))
    assert [each.name for each in solution.contacts] == ["main[1]", "main[2]"]
    states = np.arange(len(pressed.times))
    there = np.isin(states[-5:], states[gone], invert=True)
    for each in solution.contacts:
        assert each.exists[-5:].tolist() == there.tolist()
    left = evaluate(solution)[0].stations[0]
    assert np.isnan(left.k_n[-5:][~there]).all()
    # An element of .02 beside a patch of .6: 2 %.
    assert left.k_n[-5:][there] == pytest.approx(outer_k_n(APART), rel=0.02)
