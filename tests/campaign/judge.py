# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of the campaign against what they should be: right, flagged or silently wrong."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from campaign.draw import (
    BODY,
    MISSION,
    Draw,
    case_of,
    draw,
    draw_moving,
    edge_slope,
    with_mission,
    with_quadrilaterals,
)
from campaign.irregular_draw import IrregularDraw
from campaign.known_zones import KnownZone, Zones, known_zones, zone_ending_at
from campaign.solids import SolidDraw
from campaign.unlike_draw import UnlikeDraw
from reference.closed_forms import closed_contact

import fretfe
from fretfe.case import parse_case
from fretfe.errors import FretfeError
from fretfe.evaluate.contacts import Contact, Station, reported
from fretfe.results.model import Result

Verdict = Literal["right", "flagged", "wrong"]
QUANTITIES = ("K_N", "ΔK_T", "d")
# Steps in a cycle of the closed forms that give the answers.
CLOSED_FORM_STEPS = 360
# Bodies BODY half-widths high differ from half-planes by about this multiple of 1/BODY²: measured
# on fine meshes of all profiles and three heights.
FINITE_BODY = 4.0
# Pressing alone makes K_T between such bodies, whose sides are held differently and whose surfaces
# are inclined: this over BODY, and this times the slope at the edge, of K_I. Measured at Q = 0.
PRESSED_BODY, PRESSED_SLOPE = 0.06, 0.2
# The half-plane answers locate a slip border to this fraction of the half-width.
HALF_PLANE_BORDER = 0.004
EDGES = ("left", "right")


@dataclass(frozen=True)
class Judged:
    """One number of one edge.

    Attributes:
        draw: its case.
        edge: "left" or "right"; of solids front and station.
        quantity: "K_N", "ΔK_T", of solids also "ΔK_S", or "d".
        value: what was computed, NaN if unknown.
        bar: its error bar.
        truth: what it should be.
        allowance: error of the truth itself.
        remark: the warnings about it.
        whole: what errors are relative to where that is not the number itself.
    """

    draw: Draw | SolidDraw | UnlikeDraw | IrregularDraw
    edge: str
    quantity: str
    value: float
    bar: float
    truth: float
    allowance: float
    remark: str
    whole: float | None = None

    @property
    def size(self) -> float:
        """What errors are relative to."""
        return abs(self.truth if self.whole is None else self.whole)

    @property
    def error(self) -> float:
        """|value - truth| beyond the error of the truth."""
        return max(abs(self.value - self.truth) - self.allowance, 0.0)

    @property
    def verdict(self) -> Verdict:
        """Right within the bar; else flagged if it is unknown or was warned of."""
        if self.error <= self.bar:
            return "right"
        return "flagged" if math.isnan(self.value) or self.remark else "wrong"

    @property
    def text(self) -> str:
        """The number and what it should be, in one line."""
        return (
            f"{self.verdict}: case {self.draw.number}, {self.edge}, {self.quantity} = "
            f"{self.value:.5g} ± {self.bar:.2g}, should be {self.truth:.5g} ± {self.allowance:.2g}"
        )


@dataclass(frozen=True)
class Answers:
    """A case solved three ways; `found` is an error if finite elements gave no result."""

    draw: Draw
    found: Result | FretfeError
    exact: Contact
    zones: Zones


def judge_case(number: int) -> list[Judged]:
    """All numbers of the case of a number."""
    return list(judge(solve(draw(number))))


def judge_moving(number: int) -> list[Judged]:
    """All numbers of the case of a number with loads that move much."""
    return list(judge(solve(draw_moving(number))))


def solve(one: Draw) -> Answers:
    """Solve a case by finite elements, in closed form and by half-planes, with finer steps."""
    with tempfile.TemporaryDirectory() as folder:
        tables = case_of(one)
        if one.quadrilaterals:
            tables = with_quadrilaterals(tables, Path(folder))
        if one.kind == MISSION:
            tables = with_mission(tables, one, Path(folder))
        found: Result | FretfeError
        try:
            found = fretfe.run(parse_case(tables, trust_geo=True))
        except FretfeError as error:
            found = error
    exact = closed_contact(parse_case(case_of(one, CLOSED_FORM_STEPS)))
    return Answers(one, found, exact, known_zones(one))


def judge(answers: Answers) -> Iterator[Judged]:
    """Compare the numbers of a case, solved by finite elements, with the exact ones."""
    for number, edge in enumerate(EDGES):
        exact = answers.exact.stations
        known = answers.zones[number]
        if isinstance(answers.found, FretfeError):
            nothing = (answers.draw, edge)
            for quantity, truth in zip(QUANTITIES, _truths(exact[number], known), strict=True):
                yield Judged(*nothing, quantity, math.nan, math.nan, truth, 0.0, "no result")
            continue
        station = answers.found.contacts[0].stations[number]
        remark = _remarks(answers.found, edge)
        yield from _judge_factors(answers.draw, station, exact, number, remark)
        yield from _judge_zone(answers, station, known, remark)


def _truths(exact: Station, zones: tuple[KnownZone, ...]) -> tuple[float, float, float]:
    return exact.decisive_k_n[0], exact.k_t_range, zones[-1].length if zones else math.nan


def _remarks(found: Result, edge: str) -> str:
    """The warnings but for those that name the other edge alone, and why steps are missing."""
    warnings = [each.text for each in found.warnings if each.subject.front in ("", edge)]
    return "; ".join([*warnings, *([str(found.failure)] if found.failure else [])])


def _judge_factors(
    one: Draw, station: Station, exact: tuple[Station, ...], number: int, remark: str
) -> Iterator[Judged]:
    finite = FINITE_BODY / BODY**2
    edge, truth = EDGES[number], exact[number]
    k_n, k_t = truth.decisive_k_n[0], truth.k_t_range
    value, bar = station.reported_k_n, station.decisive_k_n[1]
    yield Judged(one, edge, "K_N", value, bar, k_n, finite * k_n, remark)
    if k_t > 0:
        # What the finite body adds does not vanish where shear and tension cancel.
        pressed = PRESSED_BODY / BODY + PRESSED_SLOPE * edge_slope(one)
        allowance = finite * max(each.k_t_range for each in exact) + pressed * truth.k_i_range
        bar = station.k_range_spread
        value = reported(station.k_range, bar)
        yield Judged(one, edge, "ΔK_T", value, bar, k_t, allowance, remark)


def _judge_zone(
    answers: Answers, station: Station, known: tuple[KnownZone, ...], remark: str
) -> Iterator[Judged]:
    """The last slip zone, if half-planes have one that ends at the same time."""
    assert isinstance(answers.found, Result)
    if not station.slip_zones:
        zone, end = None, math.nan
    else:
        zone = station.slip_zones[-1]
        end = float(answers.found.loads.times[zone.end])
    counterpart = zone_ending_at(known, end, 1 / answers.draw.steps)
    if counterpart is None or not counterpart.counts:
        return
    if zone is not None and zone.gross:
        return
    value, bar = (zone.reported_length, zone.spread) if zone is not None else (math.nan, math.nan)
    allowance = counterpart.spread + HALF_PLANE_BORDER * answers.draw.a
    truth = counterpart.length
    yield Judged(answers.draw, station.front, "d", value, bar, truth, allowance, remark)
