# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts, K_N and slip zones of solids from exact pressures and slips on surfaces of triangles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from cases import solid_runs

from fretfe._typing import Array, Indices
from fretfe.evaluate.contacts import Contact, Front, RangeSpread, SlipZone
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.slip import SlipBorder
from fretfe.evaluate.space import fronts as nested
from fretfe.evaluate.space.evaluate import evaluate_fronts, evaluate_solids
from fretfe.evaluate.space.fronts import AREAS, follow_fronts, nested_areas
from fretfe.evaluate.space.sectors import outlines
from fretfe.evaluate.space.slip import SlipBetween, shear_share
from fretfe.evaluate.step_ends import StepEnds
from fretfe.evaluate.verdicts import beside_nodes, judge, longest_verdict
from fretfe.evaluate.withheld import withheld
from fretfe.history.solution import SLIP, STICK, ContactHistory, Solution
from fretfe.reason import Kind
from fretfe.surface.friction import Friction
from fretfe.verdict import Verdict

Field = Callable[[Array, Array], Array]
# Element size over the radius of the contact.
SIZE = 1 / 14
STATIONS = 24


def grid(half: float = 1.5, across: float = 1.5, warp: float = 0.2) -> tuple[Array, Indices]:
    """Points (N, 3) in y = 0 and facets of a rectangle, the nodes inside moved off the lines."""
    shape = solid_runs.surface(half=1.0, count=round(2 * half / SIZE))
    points = shape.points * [half, 1.0, across]
    inside = (np.abs(shape.points[:, [0, 2]]) < 0.999).all(axis=1)
    waves = np.sin(37 * points[:, [2, 0]] + [1.0, 2.0])
    points[:, [0, 2]] += warp * SIZE * inside[:, None] * waves
    return points, shape.facets


def means(points: Array, facets: Indices, field: Field, parts: int = 6) -> tuple[Array, Array]:
    """(N,) means of a field around the nodes, weighted by hats, and (N,) areas of the nodes."""
    # Middles of the small triangles that each facet is cut into.
    i, j = (each.ravel() for each in np.meshgrid(*[np.arange(parts)] * 2))
    below, above = i + j < parts, i + j < parts - 1
    first = np.concatenate([i[below] + 1 / 3, i[above] + 2 / 3]) / parts
    second = np.concatenate([j[below] + 1 / 3, j[above] + 2 / 3]) / parts
    hats = np.stack([1 - first - second, first, second])
    corners = points[facets]
    places = np.einsum("kq,fkd->fqd", hats, corners)
    values = field(places[..., 0], places[..., 2])
    sides = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    areas = np.linalg.norm(np.cross(*sides), axis=1) / 2 / hats.shape[1]
    count = len(points)
    sums = np.zeros((2, count))
    for corner in range(3):
        for row, part in enumerate((values, np.ones_like(values))):
            amounts = areas * (part * hats[corner]).sum(axis=1)
            sums[row] += np.bincount(facets[:, corner], amounts, minlength=count)
    return sums[0] / sums[1], sums[1]


def solved(
    points: Array, facets: Indices, pressures: list[Field], slip: Field | None = None
) -> tuple[Solution, ContactHistory]:
    """States with these pressures behind the unloaded one; slip along x in the last one."""
    result = solid_runs.solid_result()
    old = result.solution.contacts[0]
    parts = [means(points, facets, field) for field in pressures]
    area = parts[0][1]
    count, states = len(points), len(pressures) + 1
    traction = np.zeros((states, count, 3))
    traction[1:, :, 0] = [part[0] for part in parts]
    closed = traction[..., 0] > 0
    moved = np.zeros((states, count, 2))
    status = np.where(closed, STICK, 0).astype(np.int8)
    if slip is not None:
        amount = means(points, facets, slip)[0]
        moved[-1, :, 0] = amount
        status[-1][closed[-1] & (amount > 0)] = SLIP
    # Outward normal of body 2 is y; tangents x and -z.
    frame = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    contact = replace(
        old,
        surface=replace(
            old.surface, points=points, facets=facets, free=np.zeros(count, dtype=bool),
            weights=area, frames=np.tile(frame, (count, 1, 1)),
        ),
        traction=traction, mean_traction=traction, status=status, slip=moved,
        friction=Friction.uniform(np.full(states, 0.5), count), gap=np.zeros((states, count)),
        dissipation=np.zeros((states, count)),
        full_stick=replace(old.full_stick, area=np.full(states, -1)),
    )  # fmt: skip
    times = np.arange(states, dtype=float)
    solution = replace(
        result.solution, times=times, cycle=None, between=None, contacts=(contact,),
        values=times[:, None] * [1.0, 0.0], driver_values=times[:, None] * [1.0, 0.0],
    )  # fmt: skip
    return solution, contact


def fronts(*arguments: object, **keywords: object) -> tuple[Front, ...]:
    solution, contact = solved(*arguments, **keywords)  # type: ignore[arg-type]
    tracks = follow_fronts(solution, contact, STATIONS)
    return evaluate_fronts(solution, contact, tracks)


def hertz(a: float, b: float, peak: float = 1.0) -> Field:
    return lambda x, z: peak * np.sqrt(np.clip(1 - (x / a) ** 2 - (z / b) ** 2, 0.0, None))


def test_outline_runs_with_the_contact_on_its_right() -> None:
    points, facets = grid()
    inside = np.hypot(points[:, 0], points[:, 2]) < 1
    (line,) = outlines(facets, inside)
    assert line.closed
    middles = line.middles(points)
    steps = np.roll(middles, -1, axis=0) - middles
    outward = points[line.outside] - points[line.inside]
    # Seen against y, the outward normal of body 2.
    assert np.all(np.cross(outward, steps)[:, 1] < 1e-12)
    length = np.linalg.norm(steps, axis=1).sum()
    assert 2 * np.pi < length < 8.2  # it zigzags


def test_circle_has_hertz_pressure_factor() -> None:
    (front,) = fronts(*grid(), [hertz(1.0, 1.0)])
    assert front.closed and len(front.stations) == STATIONS
    assert front.length == pytest.approx(2 * np.pi, rel=1e-3)
    k_n = np.array([station.k_n[-1] for station in front.stations])
    exact = np.sqrt(2.0)
    assert np.abs(k_n / exact - 1).max() < 0.02
    # -.8 % here, where means of the exact pressure take the place of a solution's; that has -.1 %.
    assert np.abs(k_n.mean() / exact - 1) < 0.012
    spread = np.array([station.k_n_spread[-1] for station in front.stations])
    assert np.mean(np.abs(k_n - exact) < spread) > 0.9
    assert np.median(spread) < 0.04 * exact
    radii = np.array([np.linalg.norm(station.point) for station in front.stations])
    np.testing.assert_allclose(radii, 1.0, atol=0.05 * SIZE)
    for station in front.stations:
        frame, radial = station.frame, station.point / np.linalg.norm(station.point)
        np.testing.assert_allclose(frame.inward, -radial, atol=0.03)
        np.testing.assert_allclose(frame.across, [0, 1, 0], atol=1e-12)
        np.testing.assert_allclose(frame.along, np.cross(frame.across, frame.inward), atol=1e-12)
        assert station.curvature == pytest.approx(1.0, abs=0.15)
        assert not station.end
    assert front.along("length") == pytest.approx(1.0, abs=0.35)


def test_ellipse_has_hertz_pressure_factor_everywhere() -> None:
    a, b = 1.0, 1.5
    (front,) = fronts(*grid(half=1.3, across=1.8), [hertz(a, b)])
    known = [station for station in front.stations if np.isfinite(station.k_n[-1])]
    assert len(known) >= 20  # elements are few over the radius of curvature of the sharp ends
    for station in known:
        angle = np.arctan2(station.point[2] / b, station.point[0] / a)
        exact = np.sqrt(2 * np.hypot(np.cos(angle) / a, np.sin(angle) / b))
        found, spread = station.k_n[-1], station.k_n_spread[-1]
        assert abs(found - exact) < max(spread, 0.03 * exact)


def test_strip_has_two_open_fronts_with_ends() -> None:
    """A cylinder whose contact runs out at both borders of the surface."""
    found = fronts(*grid(), [lambda x, z: np.sqrt(np.clip(1 - x**2, 0.0, None))])
    assert [front.closed for front in found] == [False, False]
    for front in found:
        assert front.length == pytest.approx(3.0, rel=0.01)
        k_n = np.array([station.k_n[-1] for station in front.stations])
        assert np.abs(k_n / np.sqrt(2) - 1).max() < 0.03
        assert np.abs(front.along("curvature")).max() < 0.1
        sign = np.sign(front.stations[0].point[0])
        inward = np.array([station.frame.inward for station in front.stations])
        np.testing.assert_allclose(inward[:, 0], -sign, atol=0.01)
    ends = np.array([station.end for station in found[0].stations])
    assert ends[0] and ends[-1] and not ends[STATIONS // 2]


def test_front_of_half_a_sphere_ends_at_a_plane_of_symmetry() -> None:
    """K_N and places hold up to the cut, in all states, and no station is near a free end."""
    points, facets = grid(across=0.75)
    points[:, 2] += 0.75
    radii = (0.9, 1.0)
    solution, contact = solved(points, facets, [hertz(radius, radius, radius) for radius in radii])
    cut, told = points[:, 2] < 1e-9, []
    for continued in (np.where(cut[:, None], [0.0, 0.0, 1.0], np.nan), None):
        own = replace(contact, surface=replace(contact.surface, continued=continued))
        (track,) = follow_fronts(solution, own, STATIONS)
        (front,) = evaluate_fronts(solution, own, (track,))
        assert not front.closed and front.length == pytest.approx(np.pi, rel=0.01)
        told.append(front)
    symmetric, free = told
    assert not symmetric.along("end").any() and np.isinf(symmetric.along("to_end")).all()
    assert free.along("end")[[0, -1]].all() and not free.along("end")[STATIONS // 2]
    for state, radius in enumerate(radii, start=1):
        place, k_n = (
            np.array([getattr(each, name)[state] for each in symmetric.stations])
            for name in ("position", "k_n")
        )
        np.testing.assert_allclose(place, 1.0 - radius, atol=0.15 * SIZE)
        np.testing.assert_allclose(k_n, np.sqrt(2 * radius), rtol=0.04)


def test_an_open_front_that_moves_is_known_up_to_its_ends() -> None:
    """Where it is found anew, stations at its ends have no station beyond them on either side."""
    widths = (0.8, 1.0)
    fields = [lambda x, _, w=width: np.sqrt(np.clip(w**2 - x**2, 0.0, None)) for width in widths]
    for front in fronts(*grid(), fields):
        place, spread = (
            np.array([getattr(each, name)[1] for each in front.stations])
            for name in ("position", "position_spread")
        )
        np.testing.assert_allclose(place, 0.2, atol=0.1 * SIZE)
        assert spread.max() < 0.5 * SIZE


def test_factors_next_to_an_end_are_those_an_element_from_it() -> None:
    """At the even spacing of 60 stations three of either end are nearer than an element."""
    solution, contact = solved(*grid(), [lambda x, _: np.sqrt(np.clip(1 - x**2, 0.0, None))])
    (track, _) = follow_fronts(solution, contact, 60)
    front = track.front
    sizes = np.array([sector.along_size for sector in front.sectors])
    at = front.frames.arc + front.aside
    assert np.all(np.minimum(at, front.frames.length - at) > 0.99 * sizes)
    assert np.all(front.aside[4:-4] == 0) and front.aside[0] > 0 > front.aside[-1]


def test_stations_slide_along_a_circle() -> None:
    solution, contact = solved(*grid(), [hertz(1.0, 1.0)])
    (track,) = follow_fronts(solution, contact, STATIONS)
    frames = track.front.frames
    slid = frames.slid(np.full(STATIONS, frames.length / STATIONS))
    for name in ("points", "inward", "along"):
        following = np.roll(getattr(frames, name), -1, axis=0)
        np.testing.assert_allclose(getattr(slid, name), following, atol=0.02)
    radii = np.linalg.norm(slid.points, axis=1)
    np.testing.assert_allclose(radii, np.linalg.norm(frames.points, axis=1), atol=2e-3)
    np.testing.assert_array_equal(track.front.aside, np.zeros(STATIONS))


def test_ring_has_two_fronts() -> None:
    """Contact between radii .5 and 1.3: the inner front is a hole, its inward points outward."""

    def ring(x: Array, z: Array) -> Array:
        radius = np.hypot(x, z)
        return np.sqrt(np.clip((radius - 0.5) * (1.3 - radius), 0.0, None))

    outer, inner = fronts(*grid(half=1.6, across=1.6), [ring])
    assert outer.length > inner.length and outer.closed and inner.closed
    for front, radius, sign in ((outer, 1.3, -1.0), (inner, 0.5, 1.0)):
        for station in front.stations:
            radial = station.point / np.linalg.norm(station.point)
            assert sign * station.frame.inward @ radial > 0.95
            assert station.curvature == pytest.approx(-sign / radius, abs=0.5)


def sum_of(*fields: Field) -> Field:
    return lambda x, z: np.sum([field(x, z) for field in fields], axis=0)


def bump(x: float, radius: float) -> Field:
    return lambda at, z: radius * hertz(radius, radius)(at - x, z)


def patches_of(points: Array, facets: Indices, pressures: list[Field]) -> tuple[Contact, Solution]:
    solution, contact = solved(points, facets, pressures)
    tracks = {contact.name: follow_fronts(solution, contact, STATIONS)}
    (found,) = evaluate(solution, tracks=tracks)
    return found, solution


def test_patches_are_told_apart_and_followed() -> None:
    """One bump, a wide contact over both, a third one for a while, two bumps."""
    left, right = bump(-1.3, 0.8), bump(1.3, 0.6)
    third = sum_of(left, right, bump(0.0, 0.3))
    pressures = [left, hertz(2.4, 0.8), third, sum_of(left, right)]
    found, solution = patches_of(*grid(half=2.6, across=1.2), pressures)
    name = found.name
    assert [each.name for each in found.patches] == [f"{name}[1]", f"{name}[2]", f"{name}[3]"]
    # p = R sqrt(1 - (r/R)²): P = 2 π R³/3.
    large, small, least = (2 * np.pi * radius**3 / 3 for radius in (0.8, 0.6, 0.3))
    nan = np.nan
    one, two, three = (each.normal_force for each in found.patches)
    np.testing.assert_allclose(one, [0, large, nan, large, large], rtol=0.01)
    np.testing.assert_allclose(two, [0, 0, nan, small, small], rtol=0.01)
    np.testing.assert_allclose(three, [0, 0, nan, least, 0], rtol=0.05)
    known = [1, 3, 4]
    np.testing.assert_allclose((one + two + three)[known], found.normal_force[known], rtol=1e-12)
    area = np.sum([each.contact_area for each in found.patches], axis=0)
    np.testing.assert_allclose(area[known], found.contact_area[known], rtol=1e-12)
    assert [front.patch for front in found.fronts] == [1, 2]
    assert [np.sign(front.stations[0].point[0]) for front in found.fronts] == [-1, 1]
    others = f"{name}[2] and {name}[3]"
    assert found.patches[0].reason == (
        f"it is one with {others} in 1 state, first in step 2 (time 2): P, Q and area are not "
        "known there"
    )
    assert "no fronts" in found.patches[2].reason
    assert sum(each.kind is Kind.PATCH_FORCES for each in found.warnings) == 3
    (steps,) = StepEnds(solution.times, np.array([0, 2, 4])).contacts(solution, [found])
    np.testing.assert_array_equal(steps.patches[0].normal_force, one[[0, 2, 4]])


def test_shear_of_a_patch_is_its_own() -> None:
    solution, contact = solved(*grid(half=2.6), [sum_of(bump(-1.3, 0.8), bump(1.3, 0.6))])
    traction = np.array(contact.traction)
    place = contact.surface.points[:, 0]
    # Along x on the left, along z, which is the second tangent backwards, on the right.
    traction[1, :, 1] = np.where(place < 0, 0.3, 0.0) * traction[1, :, 0]
    traction[1, :, 2] = np.where(place > 0, -0.2, 0.0) * traction[1, :, 0]
    sheared = replace(contact, traction=traction, mean_traction=traction)
    (found,) = evaluate(replace(solution, contacts=(sheared,)))
    one, two = found.patches
    np.testing.assert_allclose(one.shear_force[1], 0.3 * one.normal_force[1] * np.eye(3)[0])
    np.testing.assert_allclose(two.shear_force[1], 0.2 * two.normal_force[1] * np.eye(3)[2])
    np.testing.assert_allclose(one.shear_force + two.shear_force, found.shear_force, atol=1e-14)


def test_fronts_of_a_ring_around_an_island() -> None:
    def ring(x: Array, z: Array) -> Array:
        radius = np.hypot(x, z)
        return np.sqrt(np.clip((radius - 1.1) * (1.9 - radius), 0.0, None))

    found, _ = patches_of(*grid(half=2.2, across=2.2), [sum_of(ring, bump(0.0, 0.7))])
    assert [(front.closed, front.patch) for front in found.fronts] == [
        (True, 1), (True, 1), (True, 2),
    ]  # fmt: skip
    alone, _ = patches_of(*grid(half=2.2, across=2.2), [ring])
    assert alone.patches == () and [front.patch for front in alone.fronts] == [0, 0]


def test_front_that_moves_is_followed() -> None:
    radii = (0.8, 0.9, 1.0)
    pressures = [hertz(radius, radius, radius) for radius in radii]
    (front,) = fronts(*grid(), pressures)
    for state, radius in enumerate(radii, start=1):
        place = np.array([station.position[state] for station in front.stations])
        np.testing.assert_allclose(place, 1.0 - radius, atol=0.08 * SIZE)
        k_n = np.array([station.k_n[state] for station in front.stations])
        assert k_n.mean() == pytest.approx(radius * np.sqrt(2 / radius), rel=0.015)
    assert np.isnan(front.stations[0].k_n[0])


def test_slip_zone_is_located_below_an_element() -> None:
    width = 0.3

    def slid(x: Array, z: Array) -> Array:
        return np.clip(np.hypot(x, z) - 1 + width, 0.0, None) ** 1.5

    solution, contact = solved(*grid(), [hertz(1.0, 1.0)] * 2, slid)
    (front,) = evaluate_fronts(solution, contact, follow_fronts(solution, contact, STATIONS))
    # Without factors there are no half cycles: asked for directly.
    (track,) = follow_fronts(solution, contact, STATIONS)
    slip = SlipBetween(contact, np.zeros(len(contact.traction)))
    borders = [
        slip.border_of(
            sector,
            track.front.chord(contact.surface.points, row),
            track.fit.place[:, row],
            float(track.front.depth[row]),
        )(1, 2)
        for row, sector in enumerate(track.front.sectors)
    ]
    lengths = np.array([border.length for border in borders])
    assert all(border.resolved and not border.gross for border in borders)
    assert np.abs(lengths - width).max() < 0.3 * SIZE
    assert abs(lengths.mean() - width) < 0.1 * SIZE
    assert front.stations[0].slip_zones == ()


@pytest.mark.parametrize(("border", "gross"), [(0.25, False), (2.0, True)], ids=["one side", "all"])
def test_a_zone_beyond_the_middle_is_gross_only_where_the_other_side_slips(
    border: float, gross: bool
) -> None:
    points, facets = grid()

    def slid(x: Array, z: Array) -> Array:
        return np.asarray(np.clip(border - x, 0.0, None) ** 1.5 + 0 * z)

    solution, contact = solved(points, facets, [hertz(1.0, 1e6)] * 2, slid)
    tracks = follow_fronts(solution, contact, STATIONS)
    (track,) = (each for each in tracks if each.front.frames.points[0, 0] < 0)
    slip, front = SlipBetween(contact, np.zeros(3)), track.front
    found = [
        slip.border_of(sector, front.chord(points, row), track.fit.place[:, row], front.depth[row])(
            1, 2
        )
        for row, sector in enumerate(front.sectors)
    ]
    assert all(each.gross is gross for each in found)
    if not gross:
        lengths = np.array([each.length for each in found])
        np.testing.assert_allclose(lengths, 1 + border, atol=0.6 * SIZE)


def test_nothing_is_told_of_a_contact_of_few_nodes_or_of_a_flat_end() -> None:
    points, facets = grid()
    assert fronts(points, facets, [hertz(0.15, 0.15)]) == ()
    flat = lambda x, z: 1.0 / np.sqrt(np.clip(1.02 - x**2 - z**2, 1e-2, None)) * (x**2 + z**2 < 1)  # noqa: E731
    for front in fronts(points, facets, [flat]):
        for station in front.stations:
            assert np.isnan(station.reported_k_n) or station.uncertain


def zone(**values: float) -> SlipZone:
    numbers: dict[str, Any] = {"length": 0.05, "spread": 0.002, "predicted": 0.05}
    numbers |= {"predicted_loop": 0.05, **values}
    return SlipZone(start=0, end=1, border=0.0, resolved=True, gross=False, **numbers)


def test_verdicts() -> None:
    (front,) = fronts(*grid(), [hertz(1.0, 1.0)])
    station = replace(
        front.stations[0], k_range=100.0, k_range_spread=2.0, length=1.0, stiffening=2.0, size=0.02,
        turning=0.0,
    )  # fmt: skip
    assert judge(station, zone()).verdict == Verdict.AGREES
    coarse = judge(replace(station, size=0.2), zone())
    assert coarse.verdict == "unknown" and "of the length open, more than 30%" in coarse.reason
    assert judge(station, zone(predicted_loop=0.1)).verdict == Verdict.DIFFERS
    assert judge(station, zone(length=0.2)).verdict == Verdict.OUTSIDE
    assert judge(replace(station, end=True), zone()).verdict == Verdict.END
    nothing = zone(predicted=np.nan, predicted_loop=np.nan)
    rests = replace(station, hold=np.ones_like(station.k_n))
    assert judge(rests, nothing).verdict == "no verdict"
    moves = judge(replace(rests, hold=np.linspace(0.5, 1.0, len(rests.hold))), nothing)
    assert moves.verdict == "unknown" and "several loads move with P" in moves.reason
    assert judge(replace(station, k_n=station.k_n * np.nan), nothing).verdict == "unknown"
    assert judge(replace(station, turning=0.5), zone()).verdict == "no verdict"
    assert judge(replace(station, k_range_spread=np.nan), zone()).verdict == "unknown"
    few, many = (
        judge(replace(station, size=size), replace(zone(length=0.6, spread=0.4), resolved=False))
        for size in (0.3, 0.05)
    )
    assert few.reason == "too few elements over the slip zone: 2.0 of 0.3, 4 are wanted"
    assert "known to ± 0.4 only, of 0.6 or 12 elements" in many.reason
    after_a_slide = judge(
        station, replace(zone(length=0.6, spread=0.11), across=0.9, resolved=False)
    )
    assert after_a_slide.verdict == "no verdict"
    assert after_a_slide.reason.startswith("90% of f p acts across the direction of K_T and K_S")


def turning_slip(border: float, steps: int, turn: float) -> SlipBorder:
    """The zone at a station of a circle; slip linear from a border on, in steps that turn."""
    points, facets = grid()
    solution, contact = solved(points, facets, [hertz(1.0, 1.0)] * steps)
    # A tenth of the radius behind the front it is as large as anywhere.
    amount = means(points, facets, lambda x, z: np.clip(np.hypot(x, z) - border, 0.0, None))[0]
    angles = np.radians(np.linspace(0.0, turn, steps))
    moved = np.cumsum(np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)
    slip = np.concatenate([np.zeros((1, 2)), moved])[:, None] * amount[:, None]
    status = np.where((amount > 0) & (contact.traction[..., 0] > 0), SLIP, contact.status)
    sheared = replace(contact, slip=slip, status=status.astype(np.int8))
    (track,) = follow_fronts(solution, contact, STATIONS)
    front = track.front
    find = SlipBetween(sheared, np.zeros(steps + 1)).border_of(
        front.sectors[0],
        front.chord(points, 0),
        track.fit.place[:, 0],
        float(front.depth[0]),
    )
    return find(0, steps)


@pytest.mark.parametrize("border", [0.6, 0.75, 0.8])
def test_slip_that_turns_is_located_by_its_area_alone(border: float) -> None:
    """A fit for an onset of the power 3/2 ends beyond a linear one, with a small bar."""
    found = turning_slip(border, 6, 180.0)
    assert not found.resolved and not found.gross
    assert abs(found.length - (1 - border)) < found.spread == pytest.approx(SIZE, rel=0.5)
    assert turning_slip(border, 6, 10.0).resolved


def creeping_slip(back: float, cycle: tuple[int, int] | None) -> SlipBorder:
    """The zone at a station of a circle all of which creeps by a tenth of the largest slip.

    Args:
        back: part of the slip of the zone that goes back in the rest of the cycle.
        cycle: that is evaluated.
    """
    points, facets = grid()
    _, contact = solved(points, facets, [hertz(1.0, 1.0)] * 3)
    amount = means(points, facets, lambda x, z: np.clip(np.hypot(x, z) - 0.6, 0.0, None) ** 1.5)[0]
    steps = np.stack([0 * amount, 0 * amount, amount + 0.1 * amount.max(), -back * amount])
    slip = np.cumsum(steps, axis=0)[..., None] * [1.0, 0.0]
    status = np.where((steps != 0) & (contact.traction[..., 0] > 0), SLIP, contact.status)
    sheared = replace(contact, slip=slip, status=status.astype(np.int8))
    (track,) = follow_fronts(*solved(points, facets, [hertz(1.0, 1.0)] * 3), STATIONS)
    front = track.front
    find = SlipBetween(sheared, np.zeros(4), cycle).border_of(
        front.sectors[0],
        front.chord(points, 0),
        track.fit.place[:, 0],
        float(front.depth[0]),
    )
    return find(1, 2)


def test_what_creeps_from_cycle_to_cycle_is_no_slip_of_the_whole_contact() -> None:
    found = creeping_slip(1.0, (1, 3))
    assert not found.gross
    assert found.length == pytest.approx(0.4, abs=0.3 * SIZE)
    # Nobody knows that without a cycle, and what mostly goes one way slides.
    assert creeping_slip(1.0, None).gross
    assert creeping_slip(0.2, (1, 3)).gross


def test_nodes_whose_slip_turns_deny_no_plane_problem() -> None:
    """A zone of .222 by fits beside .170, which is right, was said to be the factors' fault."""
    (front,) = fronts(*grid(), [hertz(1.0, 1.0)])
    station = replace(front.stations[0], k_range=100.0, k_range_spread=2.0, size=0.08, turning=1.0)
    seen = replace(zone(length=0.222, spread=0.08, local=0.170, local_spread=0.01), resolved=False)
    verdict = judge(station, seen)
    assert verdict.verdict == Verdict.NO_VERDICT
    assert "0.17 ± 0.01 by the plane problem next to the front, by that alone" in verdict.reason
    assert "the direction of slip turns" in beside_nodes(station, seen).reason


def test_what_is_missing_has_a_reason() -> None:
    (front,) = fronts(*grid(), [hertz(1.0, 1.0)])
    station = replace(front.stations[0], k_range=100.0, k_range_spread=2.0, slip_zones=())
    assert withheld(station).text == ""
    assert longest_verdict(station).verdict == Verdict.UNKNOWN
    idle = replace(station, k_range=0.0, k_range_spread=0.0)
    assert longest_verdict(idle).verdict == Verdict.NO_ZONE
    parts = RangeSpread(extraction=1.0, discretisation=70.0, steps=20.0)
    wide = replace(station, k_range_spread=parts.total, k_range_parts=parts)
    assert "100 ± 73, an error bar of more than half of it: the front is" in withheld(wide).text
    assert longest_verdict(wide).verdict == "unknown"
    assert longest_verdict(wide).reason == withheld(wide).text
    lost = replace(station, k_range=np.nan, k_t=np.array([0.0, np.nan]), k_s=np.zeros(2))
    assert "unknown in 1 of 2 states, last in state 1" in withheld(lost).text
    blind = replace(station, k_n=np.full(2, np.nan))
    assert withheld(blind).text == "K_N unknown, because the pressure next to the front has no fit"
    unsure = replace(station, k_range_spread=np.nan, k_range_parts=replace(parts, steps=np.nan))
    assert "has no error bar (steps)" in withheld(unsure).text


def test_a_contact_that_nearly_slides_says_why_factors_are_missing() -> None:
    solution, contact = solved(*grid(), [hertz(1.0, 1.0)] * 2, lambda x, _: 0 * x + 1.0)
    tracks = {contact.name: follow_fronts(solution, contact, STATIONS)}
    (area,) = evaluate(replace(solution, cycle=(1, 2)), tracks=tracks)
    (text,) = [each.text for each in area.warnings if each.subject.front == "front 1"]
    assert f"not told at {STATIONS} of {STATIONS} stations, as " in text
    assert "The contact nearly slides: of 3.61 in contact 0 sticks in state 2" in text


@pytest.mark.parametrize("inner", [0.5, 0.9])
def test_a_front_beside_the_fine_mesh_is_told(inner: float) -> None:
    """Long contacts -1 < x < 1; elements of a quarter of the size from `inner` to `inner` + .3."""
    points, facets = grid(warp=0.0)
    lines = np.unique(points[:, 0])
    stretched = np.abs(lines) * (1.5 + 0.9) / 1.5
    fine = np.interp(stretched, [0.0, inner, inner + 1.2, 2.4], [0.0, inner, inner + 0.3, 1.5])
    points[:, 0] = np.interp(points[:, 0], lines, np.sign(lines) * fine)
    field = lambda x, z: np.sqrt(np.clip(1 - x**2, 0.0, None)) + 0 * z  # noqa: E731
    solution, contact = solved(points, facets, [field] * 2)
    tracks = {contact.name: follow_fronts(solution, contact, STATIONS)}
    (area,) = evaluate(solution, tracks=tracks)
    told = [each.text for each in area.warnings if each.kind is Kind.BESIDE_FINE_MESH]
    assert len(told) == (2 if inner == 0.5 else 0)
    if told:
        assert "elements are 0.11 long there, and 0.029 from 0.18 further in" in told[0]


@pytest.mark.parametrize("rise", [0.05, 0.3])
def test_elements_that_a_front_needs_are_told(rise: float) -> None:
    """Elements of .071; behind the front p = sqrt(s) (1 - s/(4 rise) + ...)."""
    field = lambda x, z: np.sqrt(1 - np.exp(-np.clip(1 - np.abs(x), 0, None) / rise)) + 0 * z  # noqa: E731
    solution, contact = solved(*grid(warp=0.0), [field] * 2)
    tracks = {contact.name: follow_fronts(solution, contact, STATIONS)}
    (area,) = evaluate(solution, tracks=tracks)
    told = [each for each in area.warnings if each.kind is Kind.K_N_UNCERTAIN]
    assert len(told) == (2 if rise == 0.05 else 0)
    for each in told:
        assert "to 40% only with elements of 0.071 across the front: 0.036 would" in each.text


@pytest.mark.parametrize(("angle", "share"), [(0.0, 0.9), (90.0, 0.0)])
def test_shear_across_after_a_slide(angle: float, share: float) -> None:
    """.9 f p along x everywhere, and an axis at an angle to it."""
    solution, contact = solved(*grid(), [hertz(1.0, 1.0)])
    traction = np.array(contact.traction)
    traction[1, :, 1] = 0.9 * 0.5 * traction[1, :, 0]
    contact = replace(contact, traction=traction)
    (track,) = follow_fronts(solution, contact, STATIONS)
    axis = np.array([np.cos(np.radians(angle)), 0.0, np.sin(np.radians(angle))])
    found = shear_share(contact, track.front.sectors[3], 1, 0.5, axis, (0.1, 0.6))
    assert found == pytest.approx(share, abs=1e-12)
    assert np.isnan(shear_share(contact, track.front.sectors[3], 1, 0.0, axis, (0.1, 0.6)))


def test_nested_areas_around_a_circle() -> None:
    """Their borders are within an element of the front; where it is not known nothing changes."""
    points, facets = grid()
    solution, contact = solved(points, facets, [hertz(1.0, 1.0)])
    (track,) = follow_fronts(solution, contact, STATIONS)
    radius = np.hypot(points[:, 0], points[:, 2])
    place = track.fit.place[-1].copy()
    none = np.zeros(len(points), dtype=bool)
    for own in (none, radius < 1.0):
        areas = nested_areas(points, own, [track], [place])
        for smaller, larger in pairwise(areas):
            assert (smaller <= larger).all()
        reach = [radius[area].max() for area in areas]
        assert np.ptp(reach) == pytest.approx(SIZE * (1 - 1 / AREAS), abs=0.4 * SIZE)
        assert np.mean(reach) == pytest.approx(1 - nested.OUTSIDE * SIZE, abs=0.4 * SIZE)
    right = track.front.frames.points[:, 0] > 0.5
    place[right] = np.nan
    areas = nested_areas(points, none, [track], [place])
    assert not any(area[points[:, 0] > 0.7].any() for area in areas)
    assert all(area[points[:, 0] < 0.0].any() for area in areas)


def test_friction_work_is_unknown_where_no_node_slips() -> None:
    """A slip zone may be shorter than an element; what never touches does no work."""
    points, facets = grid()
    for peak, bar in ((1.0, np.inf), (0.0, 0.0)):
        solution, contact = solved(points, facets, [hertz(1.0, 1.0, peak)] * 2)
        found = evaluate_solids(solution, contact, (), None)
        assert (found["dissipation"], found["dissipation_spread"]) == (0.0, bar)
