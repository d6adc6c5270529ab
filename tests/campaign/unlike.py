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
from fretfe.verdict import Verdict

# d by the slip of the nodes, and d as the factors predict it.
UNLIKE_QUANTITIES = ("K_N", "ΔK_T", "d", "predicted")
# In elements and steps; the error of the finer ones is allowed for.
FINER = by_extent(3, 4)
STEPS, CYCLES = 16, 2
# Steps in which the normal load grows against friction.
GRIPPING_STEPS = 10


def judge_unlike(number: int) -> list[Judged]:
    """All numbers of the pair of a number."""
    one = draw_unlike(number)
    return list(_judge(one, *(_stations(one, times) for times in (1, FINER))))


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
    return solved(
        replace(given, dundurs=one.beta, guided=one.guided), times * one.elements
    ).stations


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
