# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random irregular histories, solved by half-planes and by finite elements, beside exact numbers.

K_N is that of the profile, and ΔK_T the sum of exact increments of full stick. Without tension the
slip zones are exact too: with Q spread over the loads L from 0 to P, as the pressure is over flat
punches of half-width a(L), each of them carries f dL at most (Jäger 1998). With tension they are
those of half-planes with FINER times as many elements and steps.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from campaign.irregular_draw import (
    BODY,
    IrregularDraw,
    draw_irregular,
    irregular_case,
    loads_of,
)
from campaign.judge import Judged
from cases.halfplane_problems import PRESS_STEPS, problem

import fretfe
from fretfe._typing import Array
from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import tangential_factor
from fretfe.analytic.profiles import edge_factor_k_n
from fretfe.case import parse_case
from fretfe.errors import FretfeError
from fretfe.evaluate.contacts import SlipZone, Station
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
from fretfe.halfplane.solver import ELEMENTS

FINER, PARTS = 2, 8
LEVELS = 4_000
# Exact numbers know the edge between half-planes; bodies of 200 half-widths differ by about this.
FINITE_BODY = 4.0 / BODY**2
# K_T by pressing alone between bodies that are held differently, over K_I, as of `judge`.
PRESSED = 0.06 / BODY + 0.2e-3


@dataclass(frozen=True)
class Found:
    """Both edges as they were found, and the time of each of their states."""

    stations: tuple[Station, ...]
    times: Array


def judge_irregular(number: int, seed: int) -> list[Judged]:
    """All numbers of a history by half-planes."""
    one = draw_irregular(number, seed)
    return list(_judge(one, by_half_planes(one), 0.0))


def judge_irregular_elements(number: int, seed: int) -> list[Judged]:
    """All numbers of a history by finite elements."""
    one = draw_irregular(number, seed)
    try:
        result = fretfe.run(parse_case(irregular_case(one)))
    except FretfeError:
        return []
    if result.failure is not None:
        return []
    found = Found(result.contacts[0].stations, result.loads.times)
    return list(_judge(one, found, 1.0))


def by_half_planes(one: IrregularDraw, finer: int = 1) -> Found:
    """The history by half-planes, with so many times the elements and steps."""
    times, loads, cycle = loads_of(one, finer)
    p, q, tension = loads.T
    given = problem(p, q, 0.0, tension, profile=one.form, friction=one.friction, cycle=cycle)
    outcome = solve_half_planes(given, finer * ELEMENTS)
    assert outcome.failure is None
    (contact,) = evaluate(outcome.solution, outcome.unit_factors)
    pressing = times[0] * np.linspace(0.0, 1.0, PRESS_STEPS + 1)
    steps = np.concatenate([pressing, times])
    # Of states within steps, too: zones may end there.
    states = np.interp(outcome.solution.times, np.arange(len(steps)), steps)
    return Found(contact.stations, states)


def _judge(one: IrregularDraw, found: Found, finite: float) -> Iterator[Judged]:
    """Compare; `finite` is 1 between finite bodies, whose own effect is allowed for."""
    times, loads, cycle = loads_of(one, PARTS)
    if finite and np.any(loads[:, 2]):  # a block held at one side
        loads[:, 2] += loads[:, 1] / (2 * BODY)
    pulled = bool(np.any(loads[:, 2]))
    finer = by_half_planes(one, FINER) if pulled else None
    a = one.form.half_width(loads[:, 0])
    for number, station in enumerate(found.stations):
        # Bodies that lean move both edges alike.
        decisive = int(np.argmin(np.abs(times - found.times[station.decisive])))
        places = [float(each.position[station.decisive]) for each in found.stations]
        half, bar = (places[1] - places[0]) / 2, float(station.position_spread[station.decisive])
        width = a[decisive]
        yield Judged(one, station.front, "edge", half, bar, width, finite * FINITE_BODY * width, "")
        k_n = float(edge_factor_k_n(one.form, width))
        value, bar = station.reported_k_n, station.decisive_k_n[1]
        yield Judged(one, station.front, "K_N", value, bar, k_n, finite * FINITE_BODY * k_n, "")
        if cycle:
            k_t, k_i = _ranges(loads[-1 - cycle :], a[-1 - cycle :], station)
            allowance = finite * (FINITE_BODY * k_t + PRESSED * k_i)
            value, bar = station.told_range
            if station.moves:
                k_t = _equivalent(one, times, loads, finer or found, number == 0)
                allowance += one.friction * one.peak / LEVELS
            yield Judged(one, station.front, "ΔK_T", value, bar, k_t, allowance, "")
        for zone in station.slip_zones:
            if finer is not None:
                other = _counterpart(zone, found.times, finer.stations[number], finer.times)
                if other is None:
                    continue
                truth, own = other.length, other.spread
            else:
                truth, own = _exact(one, times, loads, found.times[[zone.start, zone.end]]), 0.0
            if not 0 < truth < 0.9:
                continue
            value, bar = zone.reported_length, zone.spread
            own += finite * FINITE_BODY
            yield Judged(one, station.front, "d", value, bar, truth, own, "")


def _ranges(loads: Array, a: Array, station: Station) -> tuple[float, float]:
    """Ranges of K_T and K_I over the evaluated cycle, by exact increments."""
    middle, steps = (a[1:] + a[:-1]) / 2, np.diff(loads, axis=0)
    side: Side = "left" if station.front == "left" else "right"
    k_t = tangential_factor(steps[:, 1], steps[:, 2], middle, side)
    k_i = steps[:, 0] / (np.pi * np.sqrt(2 * middle))
    k_t_range, k_i_range = (float(np.ptp(np.append(0.0, np.cumsum(each)))) for each in (k_t, k_i))
    return k_t_range, k_i_range


def _equivalent(one: IrregularDraw, times: Array, loads: Array, found: Found, left: bool) -> float:
    """Largest f K_N d of the evaluated cycle, by both ends of d; exact without tension."""
    ranges = [0.0]
    for zone in found.stations[0 if left else 1].evaluated_zones:
        length = zone.length
        if not np.any(loads[:, 2]):
            length = _exact(one, times, loads, found.times[[zone.start, zone.end]])
        p = float(loads[np.argmin(np.abs(times - found.times[zone.end])), 0])
        a = float(one.form.half_width(p))
        stands = p - float(one.form.load(a - length))
        ranges.append(2 * one.friction * stands / (np.pi * np.sqrt(2 * a)))
    return max(ranges)


def _counterpart(zone: SlipZone, times: Array, station: Station, finer: Array) -> SlipZone | None:
    """The zone of finer steps that has the same end, if it is known there."""
    for other in station.slip_zones:
        if abs(finer[other.end] - times[zone.end]) < 1e-6:
            return other if other.resolved and not other.gross else None
    return None


def _exact(one: IrregularDraw, times: Array, loads: Array, ends: Array) -> float:
    """Slip-zone length between two times, from the edge at the second one."""
    # Zones may end at instants within steps: loads are straight lines there.
    ends = np.round(ends, 9)
    finer = np.unique(np.append(np.round(times, 9), ends))
    times, loads = finer, np.array([np.interp(finer, times, each) for each in loads.T]).T
    f, top = one.friction, one.peak * (1 + 1e-9)
    level = (np.arange(LEVELS) + 0.5) * top / LEVELS
    share, d_level = np.zeros(LEVELS), top / LEVELS
    inside = loads[0, 0] > level
    farthest, latest = {1: np.inf, -1: np.inf}, 1
    for state in range(1, len(times)):
        p, q = loads[state, :2]
        pressed = p > level
        new = pressed & ~inside
        step = loads[state] - loads[state - 1]
        if new.any():
            share[new] = np.clip(step[1] / step[0], -f, f)
        share[~pressed] = 0.0
        inside = pressed
        missing = q - share.sum() * d_level
        way = 1 if missing > 0 else -1
        # From the edge inward all of f, as far as it takes.
        gain = np.cumsum(np.where(pressed, f * way - share, 0.0)[::-1])[::-1] * d_level
        # What a level that P passes leaves open is no slip.
        least = 1e-7 * f * p + (1.01 * f * d_level if step[0] else 0.0)
        slipping = pressed & (np.abs(gain) < (1 - 1e-6) * abs(missing)) & (abs(missing) > least)
        if slipping.any():
            border = int(np.flatnonzero(slipping)[0])
            share[slipping] = f * way
            rest = missing - gain[border]
            share[max(border - 1, 0)] += rest / d_level
            if ends[0] + 1e-9 < times[state] <= ends[1] + 1e-9:
                inner = (
                    level[border] - d_level / 2 - d_level * min(abs(rest / d_level) / (2 * f), 1)
                )
                farthest[way], latest = min(farthest[way], inner), way
    last = loads[np.searchsorted(times, ends[1]), 0]
    stick = farthest[latest]  # slip the other way is that of loops in between
    if not np.isfinite(stick):
        return 0.0
    return float(one.form.half_width(last) - one.form.half_width(max(stick, 0.0)))
