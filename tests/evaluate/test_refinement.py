# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a mesh must be fine, and when it is fine enough, on half-planes with known answers."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from cases.halfplane_problems import HERTZ, LIMIT, LOAD, problem

from fretfe.backends.meshes import without_round_off
from fretfe.evaluate.contacts import Contact, Frame, Front, fronts_of, unknown_station
from fretfe.evaluate.edge_zone import WANTED_TO_PEAK
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.refinement import (
    KINDS,
    Pass,
    Refinement,
    StationValues,
    edge_changes,
    extrapolate,
    names_before,
)
from fretfe.evaluate.resolution import (
    BLIND,
    MISSED,
    PER_SLIP_ZONE,
    Interval,
    fine_places,
    hopeless,
    needed_sizes,
    resolves,
    station_values,
)
from fretfe.halfplane import solve_half_planes
from fretfe.history.solution import Solution
from fretfe.idealise import HalfPlaneProblem
from fretfe.reason import TOLD, Kind, Reason

# Amplitude of the shear; the slip zones of the cycle are a (1 - sqrt(1 - Q/(f P))) (Cattaneo and
# Mindlin) with a = 1.
SHEAR = 0.2 * LIMIT
ZONE = 1 - math.sqrt(1 - 0.2)


def solved(given: HalfPlaneProblem) -> tuple[Solution, tuple[Contact, ...]]:
    outcome = solve_half_planes(given)
    return outcome.solution, evaluate(outcome.solution, outcome.unit_factors)


@pytest.fixture(scope="module")
def cycled() -> tuple[Solution, tuple[Contact, ...]]:
    shear = SHEAR * np.sin(np.linspace(0, 4 * np.pi, 65)[1:])
    return solved(problem(np.full(64, LOAD), shear, cycle=32))


def at(intervals: tuple[Interval, ...], place: float) -> float:
    """Smallest size that is asked for within 0.01 of a place."""
    return min(i.size for i in intervals if i.low - 0.01 <= place <= i.high + 0.01)


def test_values_are_those_of_the_edges(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    left, right = station_values(*cycled)
    assert (left.front, right.front) == ("left", "right")
    for values in (left, right):
        # p0 sqrt(2/a); 0.5 % is what 300 elements give
        assert values.k_n == pytest.approx(math.sqrt(2), rel=5e-3)
        # 2 Q/(pi sqrt(2 a))
        assert values.k_t == pytest.approx(2 * SHEAR / (math.pi * math.sqrt(2)), rel=5e-3)
        assert values.slip == pytest.approx((ZONE, ZONE), rel=0.02)
        # (p0/K_N)^2 = a/2
        assert values.rise == pytest.approx(0.5, rel=0.02)


def test_k_t_of_contacts_that_slide_need_not_converge(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    solution, (contact,) = cycled
    zones = [tuple(replace(z, gross=True) for z in each.slip_zones) for each in contact.stations]
    stations = [
        replace(each, slip_zones=own) for each, own in zip(contact.stations, zones, strict=True)
    ]
    before = station_values(solution, (replace(contact, fronts=fronts_of(stations)),))
    after = [replace(each, k_t=0.5 * each.k_t) for each in before]
    changes = edge_changes(before, after, {contact.name: contact.name})
    assert all(each.change < 1e-300 for each in changes)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("level", [0, 2])
def test_edges_and_slip_zones_are_to_be_fine(
    cycled: tuple[Solution, tuple[Contact, ...]], side: int, level: int
) -> None:
    intervals = needed_sizes(*cycled, level)
    needed = min(0.5 / WANTED_TO_PEAK, ZONE / PER_SLIP_ZONE)
    assert at(intervals, side * 1.0) == pytest.approx(needed / 2**level, rel=0.05)
    assert at(intervals, side * (1 - ZONE)) == pytest.approx(needed / 2**level, rel=0.05)
    # within the zone the level makes no difference: only its ends are refined
    assert at(intervals, side * (1 - ZONE / 2)) == pytest.approx(ZONE / PER_SLIP_ZONE, rel=0.05)
    assert not any(i.low < 0 < i.high for i in intervals)


def test_the_range_of_a_moving_edge_is_to_be_fine() -> None:
    normal = LOAD * (1 + 0.3 * np.sin(np.linspace(0, 4 * np.pi, 65)[1:]))
    intervals = needed_sizes(*solved(problem(normal, cycle=32)), 3)
    ends = HERTZ.half_width(LOAD * 0.7), HERTZ.half_width(LOAD * 1.3)
    for sign in (-1, 1):
        for place in np.linspace(*ends, 9):
            # (p0/K_N)^2 = a/2 in the state of the larger load
            assert at(intervals, sign * float(place)) <= 1.05 * ends[1] / 2 / WANTED_TO_PEAK


def test_edges_under_next_to_no_load_are_left_coarse(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    """Of a mission that ends without load: flats tilt there, and an edge may be anywhere."""
    solution, (contact,) = cycled
    last, stations = len(solution.times) - 1, []
    for each in contact.stations:
        tilted = each.position.copy()
        tilted[last] = 0.3 * tilted[last]
        stations.append(replace(each, position=tilted))
    for share, fine in ((0.02, False), (0.2, True)):
        force = contact.normal_force.copy()
        force[last] *= share
        changed = replace(contact, normal_force=force, fronts=fronts_of(stations))
        intervals = needed_sizes(solution, (changed,), 0)
        assert any(each.low < 0.5 < each.high for each in intervals) == fine


def test_elements_shrink_where_they_are_too_large_to_tell_k_n(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    solution, (contact,) = cycled
    nan = np.full_like(solution.times, np.nan)
    stations = (replace(each, k_n=nan, position=nan) for each in contact.stations)
    unknown = replace(contact, fronts=fronts_of(stations))
    intervals = needed_sizes(solution, (unknown,), 0)
    arc = solution.contacts[0].surface.arc
    edge = np.searchsorted(arc, 1.0)
    assert at(intervals, 1.0) == pytest.approx((arc[edge] - arc[edge - 1]) / BLIND, rel=0.5)
    assert at(intervals, -1.0) == pytest.approx(at(intervals, 1.0), rel=1e-6)


def test_round_off_does_not_reach_the_places_of_the_next_mesh() -> None:
    """Else Gmsh makes another mesh of it: a run with LU factors would differ by tenths of 1 %."""
    random = np.random.default_rng(5)
    points, sizes = random.uniform(-20, 20, (200, 3)), random.uniform(1e-3, 1e-2, 200)
    kept, even = without_round_off(points, sizes)
    again = without_round_off(
        points + random.uniform(-1, 1, points.shape) * 1e-13, sizes * (1 + 1e-13)
    )
    assert np.array_equal(again[0], kept)
    assert np.array_equal(again[1], even)
    # Far less than what a mesh makes of sizes and places: half of what is cut off.
    assert np.abs(kept - points).max() <= 0.0051 * sizes.min()
    assert np.abs(even / sizes - 1).max() <= 0.0051


def test_an_open_contact_has_no_values(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    solution, contacts = cycled
    (history,) = solution.contacts
    lifted = replace(history, traction=history.traction * 0)
    assert station_values(replace(solution, contacts=(lifted,)), contacts) == ()


def test_without_a_cycle_k_t_has_to_converge_where_it_is_largest() -> None:
    """What is left of it at the end is the difference of two large numbers."""
    shear = SHEAR * np.append(np.linspace(0, 1, 9), np.linspace(1, 0, 9)[1:])
    for values in station_values(*solved(problem(np.full(17, LOAD), shear))):
        expected = SHEAR / (math.pi * math.sqrt(2))
        assert abs(values.k_t) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("left", [0.0, 1e-6])
def test_a_contact_that_ends_without_load_has_the_values_of_the_state_that_decides(
    cycled: tuple[Solution, tuple[Contact, ...]], left: float
) -> None:
    """With one node far from the centre under what is left, or none; its nodes were too few."""
    solution, (contact,) = cycled
    (history,) = solution.contacts
    traction = np.array(history.traction)
    traction[-1] = 0.0
    traction[-1, np.searchsorted(history.surface.arc, -0.9)] = left
    parted = replace(solution, contacts=(replace(history, traction=traction),))
    stations = [
        replace(
            each,
            position=np.where(solution.times < solution.times[-1], each.position, math.nan),
            decisive=int(solution.ends[-17]),
            lack=Reason(Kind.FEW_NODES, 4, 8),
        )
        for each in contact.stations
    ]
    ended = replace(contact, fronts=fronts_of(stations))
    for values in station_values(parted, (ended,)):
        assert values.rise == pytest.approx(0.5, rel=0.02)
    # Edges cross the contact within steps: twice as many elements over its largest.
    arc = history.surface.arc
    middle = float(np.diff(arc[np.abs(arc) <= 1]).max())
    assert at(needed_sizes(parted, (ended,), 0), 0.0) == pytest.approx(middle / 2 / MISSED)


def test_a_mesh_resolves_what_its_elements_are_small_enough_for(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    solution, _ = cycled
    history = solution.contacts[0]
    arc = history.surface.arc
    size = float(np.diff(arc)[np.searchsorted(arc, 0.5) - 1])
    assert resolves(solution, [Interval(history.name, 0.5, 0.5, size)])
    assert not resolves(solution, [Interval(history.name, 0.5, 0.5, size / 2)])
    assert not resolves(solution, [Interval(history.name, 0.0, 1.0, size / 2)])


def edge(k_n: float = 10.0, k_t: float = 2.0, *slip: float) -> StationValues:
    bars = (0.1, 0.2, *(math.nan for _ in slip))
    return StationValues("main", "left", k_n, k_t, slip, rise=1.0, friction=0.5, spreads=bars)


def changed(before: StationValues, after: StationValues) -> tuple[float, ...]:
    """Change of each kind of value."""
    done = Pass(100, 0.1, (after,), True, edge_changes([before], [after], {"main": "main"}))
    return tuple(done.of_kind(kind) for kind in KINDS)


def test_patches_that_swap_their_numbers_are_compared_by_place() -> None:
    """The wide patch on the left and the narrow one on the right have each other's name before."""
    wide, narrow = edge(10.0, 2.0), edge(5.0, 1.0)
    one, two = "main[1]", "main[2]"
    before = [replace(wide, contact=one), replace(narrow, contact=two)]
    after = [replace(narrow, contact=one), replace(wide, contact=two)]

    def patch(name: str, centre: float, half_width: float) -> Contact:
        station = SimpleNamespace(last=0)
        histories = {"centre": np.array([centre]), "half_width": np.array([half_width])}
        found = SimpleNamespace(name=name, pair="main", stations=(station,), **histories)
        return cast(Contact, found)

    coarse = [patch(one, -3.0, 1.0), patch(two, 3.0, 0.5)]
    fine = [patch(one, 3.01, 0.5), patch(two, -3.02, 1.0)]
    names = names_before(coarse, fine)
    assert names == {one: two, two: one}
    changes = edge_changes(before, after, names)
    assert len(changes) == 4 and all(change.size == 0 for change in changes)
    # A patch that is new has nothing to be compared with.
    assert edge_changes(before, after, names_before(coarse[:1], fine)) == ()


@pytest.mark.parametrize(
    ("after", "changes"),
    [
        (edge(10.1, 2.0, 0.4), (0.1 / 10.1, 0, 0)),
        (edge(10.0, 1.9, 0.4), (0, 0.1 / 1.9, 0)),
        (edge(10.0, 2.0, 0.5), (0, 0, 0.2)),
        (edge(10.0, 2.0), (math.inf,) * 3),  # the zone is gone
        (edge(math.nan, 2.0, 0.4), (math.inf, 0, 0)),
        (edge(math.nan, 0.0, 0.4), (math.inf, math.inf, 0)),  # nothing to compare K_T with
    ],
)
def test_changes(after: StationValues, changes: tuple[float, float, float]) -> None:
    assert changed(edge(10.0, 2.0, 0.4), after) == pytest.approx(changes)


def test_what_is_negligible_need_not_converge() -> None:
    # slip zones of 1e-5 and 2e-5 of the rise: K_T = f K_N d is as negligible
    before, after = edge(10.0, 5e-5, 1e-5), edge(10.0, 1e-4, 2e-5)
    assert max(changed(before, after)) == pytest.approx(0.01)
    assert changed(edge(10.0, 0.0), edge(10.0, 0.0))[:2] == (0, 0)
    parted = replace(edge(10.0, math.nan), k_t_scale=math.inf)
    assert changed(parted, parted)[:2] == (0, 0)


@pytest.mark.parametrize("ratio", [0.5, -0.3])
def test_extrapolation_is_exact_for_errors_that_shrink_by_a_factor(ratio: float) -> None:
    values = [3.0 + 0.2 * ratio**n for n in range(4)]
    assert extrapolate(values) == pytest.approx(3.0, abs=1e-14)


@pytest.mark.parametrize("values", [[1.0], [1.0, 2.0], [1.0, 2.0, 3.0], [1.0, 1.1, 1.1]])
def test_nothing_is_extrapolated_from_changes_that_do_not_shrink(values: list[float]) -> None:
    assert extrapolate(values) == values[-1]


def test_limits_skip_meshes_that_did_not_show_the_edge() -> None:
    first = Pass(100, 0.1, (edge(math.nan, 0.0),), False, ())
    passes = tuple(Pass(100, 0.1, (edge(10 + 2.0**-n, 2.0, 0.4),), True, ()) for n in range(3))
    ((found, limits),) = Refinement(0.01, (first, *passes), True, "").limits
    assert found == passes[-1].stations[0]
    assert [limit.value for limit in limits] == pytest.approx([10.0, 2.0, 0.4])
    # the last mesh was off by its bar, and by 1/4, as the limit says
    assert [limit.spread for limit in limits] == pytest.approx([0.35, 0.2, math.nan], nan_ok=True)


@pytest.mark.parametrize(("size", "stops"), [(1e-3, False), (5e-5, True)])
def test_an_edge_without_a_factor_is_not_refined_for_ever(size: float, stops: bool) -> None:
    """A contact on |x| < 1 that ends with its surface, whose pressure is largest there."""
    x = np.concatenate([[-1.0, -1.0 + size], np.linspace(-0.9, 0.9, 19), [1.0 - size, 1.0]])
    pressure = np.zeros((2, len(x), 2))
    pressure[1, :, 0] = 1 + x**2
    history = SimpleNamespace(surface=SimpleNamespace(arc=x), traction=pressure, name="flat")
    unknown = np.full(2, np.nan)
    station = SimpleNamespace(
        front="left",
        last=1,
        decisive=1,
        decisive_k_n=(math.nan, math.nan),
        uncertain=False,
        position=unknown,
        lack=TOLD,
    )
    contact = SimpleNamespace(
        name="flat", stations=(station,), half_width=unknown, normal_force=np.array([0.0, 8 / 3])
    )
    solution = SimpleNamespace(contacts=(history,), cycle=None, times=np.arange(2.0))
    reason = hopeless(solution, (contact,))  # type: ignore[arg-type]
    assert ("K_N at the left edge of contact flat is not known with" in reason) == stops
    assert ("sharp corner" in reason) == stops
    coarser = Pass(100, 0.1, (replace(edge(), contact="flat"),), True, ())
    known = hopeless(solution, (contact,), (coarser,))  # type: ignore[arg-type]
    assert ("round-off hides it" in known) == stops and "sharp corner" not in known


def test_borders_without_a_front_get_far_smaller_elements(
    cycled: tuple[Solution, tuple[Contact, ...]],
) -> None:
    solution, (contact,) = cycled
    lack = Reason(Kind.LOST, 1, 4, "lost")
    stations = tuple(
        replace(
            unknown_station("front 1", number, len(solution.times), lack),
            frame=Frame(*np.eye(3)),
            point=np.array([0.0, number, 0.0]),
            arc=float(number),
            size=0.1,
        )
        for number in range(5)
    )
    lost = replace(contact, fronts=(Front("front 1", stations, False, 4.0),))
    (places,) = fine_places(solution, solution.contacts[0], lost, 0.1)
    assert places.sizes == pytest.approx(0.1 / BLIND)
    assert (places.points[:, 1].min(), places.points[:, 1].max()) == (0.0, 4.0)
