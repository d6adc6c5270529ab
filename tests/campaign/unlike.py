# SPDX-License-Identifier: LGPL-3.0-or-later
"""Random pairs of unlike bodies: half-planes with the coupling beside ones three times as fine."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from campaign.extent import by_extent
from campaign.judge import Judged
from campaign.unlike_draw import UnlikeDraw, draw_unlike
from cases.halfplane_problems import LOAD, loop, problem, solved, started

from fretfe.evaluate.contacts import Station
from fretfe.evaluate.verdicts import judge
from fretfe.idealise import HalfPlaneProblem
from fretfe.verdict import Verdict

# d by the slip of the nodes, and d as the factors predict it.
UNLIKE_QUANTITIES = ("K_N", "ΔK_T", "d", "predicted")
# In elements and steps; the error of the finer ones is allowed for.
FINER = by_extent(3, 4)
STEPS, CYCLES = 16, 2
# Steps in which the normal load grows against friction.
GRIPPING_STEPS = 10
# Steps a period of loads that move the edges, of which some meet the peaks; so many have a limit.
MOVING_STEPS, FINE_STEPS = (12, 24, 48), 144


def judge_unlike(number: int) -> list[Judged]:
    """All numbers of the pair of a number."""
    one = draw_unlike(number)
    return list(_judge(one, *(_stations(one, times) for times in (1, FINER))))


def judge_moving_unlike(number: int) -> list[Judged]:
    """Longest slip zones under waves of P and Q out of phase, with few steps beside many."""
    one = draw_unlike(number)
    random = np.random.default_rng(19000 + number)
    swing, phase = random.choice([0.1, 0.25, 0.5, 0.75]), random.choice(np.arange(7)) * np.pi / 6
    share = one.friction * (1 - swing) * random.uniform(0.3, 0.85)

    def longest(steps: int) -> list[tuple[str, float, float]]:
        angle = loop(steps, CYCLES)
        shear = started(LOAD * share * np.sin(angle + phase))
        normal = np.full_like(shear, LOAD)
        normal[-len(angle) :] *= 1 + swing * np.sin(angle)
        given = problem(normal, shear, friction=one.friction, cycle=steps)
        told = [(each.front, each.longest_zone) for each in _solved(one, given, one.elements)]
        return [
            (front, zone.length, zone.spread) if zone and zone.resolved else (front, math.nan, 0.0)
            for front, zone in told
        ]

    truth = longest(FINE_STEPS)
    return [
        Judged(one, f"{name}, {steps} steps", "d", length, spread, exact, allowance, remark="")
        for steps in MOVING_STEPS
        for (name, length, spread), (_, exact, allowance) in zip(longest(steps), truth, strict=True)
        if not math.isnan(exact)
    ]


def _solved(one: UnlikeDraw, given: HalfPlaneProblem, elements: int) -> tuple[Station, ...]:
    return solved(replace(given, dundurs=one.beta, guided=one.guided), elements).stations


def _stations(one: UnlikeDraw, times: int) -> tuple[Station, ...]:
    """Both edges of a pair, by so many times its elements and steps of pressing."""
    wave = np.cos(loop(STEPS, CYCLES))
    shear = started(one.friction * LOAD * (one.mean + one.amplitude * wave))
    tension = started(one.friction * one.tension * wave)
    normal = np.full_like(shear, LOAD)
    if one.gripping:
        growing = LOAD * np.linspace(0.0, 1.0, times * GRIPPING_STEPS + 1)[1:]
        normal, shear, tension = (
            np.concatenate([first, rest])
            for first, rest in zip(
                (growing, 0 * growing, 0 * growing), (normal, shear, tension), strict=True
            )
        )
    loads = (normal, shear, 0.0, tension)
    given = problem(*loads, friction=one.friction, cycle=STEPS, frictional_press=one.gripping)
    return _solved(one, given, times * one.elements)


def _judge(
    one: UnlikeDraw, found: tuple[Station, ...], finer: tuple[Station, ...]
) -> Iterator[Judged]:
    for station, truth in zip(found, finer, strict=True):
        values = (
            (*station.decisive_k_n, *truth.decisive_k_n),
            (station.k_range, station.k_range_spread, truth.k_range, truth.k_range_spread),
        )
        for quantity, numbers in zip(UNLIKE_QUANTITIES, values, strict=False):
            yield Judged(one, station.front, quantity, *numbers, remark="")
        zones = zip(station.slip_zones[-2:], truth.slip_zones[-2:], strict=True)
        for zone, exact in zones:
            if exact.gross or not exact.resolved:
                continue
            known = (exact.length, exact.spread)
            yield Judged(one, station.front, "d", zone.reported_length, zone.spread, *known, "")
            verdict = judge(station, zone)
            # Without a verdict there is no bar to hold.
            remark = "" if verdict.verdict == Verdict.AGREES else verdict.verdict
            bar = verdict.tolerance if math.isfinite(verdict.tolerance) else 0.0
            yield Judged(one, station.front, "predicted", zone.prediction, bar, *known, remark)
