# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers at the stations of random contacts of solids against closed forms."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from campaign.judge import Judged
from campaign.solids import (
    CYLINDER_LENGTH,
    SolidDraw,
    draw_moving_solid,
    draw_solid,
    peak_force,
    peak_pressure,
    shear_force,
    solid_case,
)

import fretfe
from fretfe._typing import Array
from fretfe.analytic.paths import PolygonPath, permanent_stick_load
from fretfe.case import parse_case
from fretfe.caution import Caution
from fretfe.errors import FretfeError
from fretfe.evaluate.contacts import Station, reported
from fretfe.reason import Kind
from fretfe.results.model import Result

SOLID_QUANTITIES = ("K_N", "ΔK_T", "ΔK_S", "d")
# What closed forms are off by because bodies are no half-spaces, relative: bodies that are 20 half
# widths of the contact high, or cylinders of 16 half-widths with free ends, on fine meshes.
FINITE = {"sphere": 0.004, "ellipsoid": 0.006, "cylinder": 0.006}
# Pressing alone makes K_T and K_S between them, of K_I: measured at Q = 0, .0105 to .0114 along the
# middle of cylinders, whose upper body is free at the sides; on spheres it is small beside FINITE.
PRESSED = {"sphere": 0.0, "ellipsoid": 0.0, "cylinder": 0.012}
# Slip zones, over the half-width: the same, and what coupling does to the circle where ν is not 0:
# .015 at ν = .3 against half-spaces.
FINITE_ZONE, COUPLED_ZONE = 0.006, 0.05
# Part of a cylinder's length that is next to plane strain, about the middle.
MIDDLE = 0.3
# Points of a cycle that closed forms are taken at.
FINE = 720


def judge_solid(number: int) -> list[Judged]:
    """All numbers of the case of a number."""
    one = draw_solid(number)
    return list(judge_solid_run(one, solve_solid(one)))


def judge_moving_solid(number: int) -> list[Judged]:
    """All numbers of the case of a number with a normal load that moves much."""
    one = draw_moving_solid(number)
    return list(judge_solid_run(one, solve_solid(one)))


def solve_solid(one: SolidDraw) -> Result | FretfeError:
    """Solve a case; the error if there is no result."""
    try:
        return fretfe.run(parse_case(solid_case(one)))
    except FretfeError as error:
        return error


def judge_solid_run(one: SolidDraw, found: Result | FretfeError) -> Iterator[Judged]:
    """Compare the numbers at all stations with the exact ones."""
    fronts = found.contacts[0].fronts if isinstance(found, Result) else ()
    if not fronts:
        for quantity in SOLID_QUANTITIES:
            yield Judged(one, "any front", quantity, math.nan, math.nan, math.nan, 0.0, "no result")
        return
    assert isinstance(found, Result)
    # That a contact reaches the border of its surface is so where the body ends.
    warnings = [each for each in found.warnings if each.kind is not Kind.SURFACE_BORDER]
    failure = str(found.failure or "")
    for front in fronts:
        for station in front.stations:
            if one.profile == "cylinder" and not _in_the_middle(one, station):
                continue
            make = cylinder_truth if one.profile == "cylinder" else ellipse_truth
            yield from _judge_station(make(one, found, station), station, warnings, failure)


def _in_the_middle(one: SolidDraw, station: Station) -> bool:
    return abs(station.point[2]) < MIDDLE / 2 * CYLINDER_LENGTH * one.a


@dataclass(frozen=True)
class Truth:
    """What the numbers of a station should be.

    Attributes:
        draw: the case.
        k_n: in the last state.
        k_range: of the vector (K_T, K_S) over the cycle.
        shares: of K_T and of K_S in that.
        zone: length of the last slip zone.
    """

    draw: SolidDraw
    k_n: float
    k_range: float
    shares: tuple[float, ...]
    zone: float

    @property
    def finite(self) -> float:
        """Relative error of the factors."""
        return FINITE[self.draw.profile]

    @property
    def zone_error(self) -> float:
        """Error of the length of the zone."""
        coupled = 0.0 if self.draw.profile == "cylinder" else COUPLED_ZONE * self.draw.poisson
        return (FINITE_ZONE + coupled) * self.draw.a


def _judge_station(
    truth: Truth, station: Station, warnings: list[Caution], failure: str
) -> Iterator[Judged]:
    # Factors do not depend on the start of the cycle.
    counting = [each.text for each in warnings if each.kind is not Kind.UNSTEADY]
    remark = "; ".join(filter(None, (*counting, failure)))
    one, where = truth.draw, f"{station.front}, station {station.number}"
    value, bar = station.reported_k_n, station.decisive_k_n[1]
    yield Judged(one, where, "K_N", value, bar, truth.k_n, truth.finite * truth.k_n, remark)
    bar = station.k_range_spread
    told = math.isfinite(reported(station.k_range, bar))
    # What the finite body adds does not vanish where a component does.
    pressed = PRESSED[one.profile] * station.k_i_range
    allowance = truth.finite * truth.k_range + pressed
    for quantity, share, found in zip(
        ("ΔK_T", "ΔK_S"), truth.shares, (station.k_t_range, station.k_s_range), strict=True
    ):
        value = found if told else math.nan
        yield Judged(
            one, where, quantity, value, bar, share * truth.k_range, allowance, remark,
            truth.k_range,
        )  # fmt: skip
    zone = station.slip_zones[-1] if station.slip_zones else None
    value, bar = zone.told if zone is not None else (math.nan, math.nan)
    remark = "; ".join(filter(None, (*(each.text for each in warnings), failure)))
    yield Judged(one, where, "d", value, bar, truth.zone, truth.zone_error, remark)


@dataclass(frozen=True)
class Cycle:
    """Loads of the steady cycle, P relative to the peak that gives the half-width a, Q likewise.

    Attributes:
        normal: (n,) P.
        shear: (n,) Q.
        friction: coefficient.
    """

    normal: Array
    shear: Array
    friction: float

    @classmethod
    def of(cls, one: SolidDraw, share: float = 1.0) -> Cycle:
        """The cycle of a case, its Q times a share."""
        angle = np.linspace(0.0, 2 * np.pi, FINE + 1)
        normal = 1 + one.normal_range * np.sin(angle + math.radians(one.normal_phase))
        shear = share * shear_force(one) / peak_force(one) * np.sin(angle)
        return cls(normal / (1 + one.normal_range), shear, one.friction)

    @property
    def permanent(self) -> float:
        """The load whose contact area never slips."""
        zeros = np.zeros_like(self.normal)
        path = PolygonPath(np.stack([self.normal, zeros, self.shear, zeros], axis=1))
        return float(permanent_stick_load(path, self.friction))

    def range(self, exponent: float) -> float:
        """Range of a factor that grows with Q and with P to an exponent."""
        middle = (self.normal[1:] + self.normal[:-1]) / 2
        factor = np.cumsum(middle**exponent * np.diff(self.shear))
        return float(np.ptp(np.append(0.0, factor)))


def _normal(one: SolidDraw, found: Result, state: int) -> float:
    """P of a state relative to the peak."""
    return -float(found.loads.values[state, 0]) / peak_force(one)


def _end(station: Station) -> int:
    """The state that the last slip zone ends in."""
    return station.slip_zones[-1].end if station.slip_zones else -1


def ellipse_truth(one: SolidDraw, found: Result, station: Station) -> Truth:
    """Hertz, bonded ellipse, and Cattaneo and Mindlin, at a station of a sphere or ellipsoid."""
    axes = np.array([one.a, one.ratio * one.a])
    place = station.point[[0, 2]] / axes
    place /= np.linalg.norm(place)
    slope = float(np.linalg.norm(place / axes))
    inward = -place / axes / slope
    cycle = Cycle.of(one)
    angle = math.radians(one.angle)
    pull = np.array([math.cos(angle), math.sin(angle)])
    # In the frame that comes with the numbers.
    own = [each[[0, 2]] for each in (station.frame.inward, station.frame.along)]
    whole = peak_force(one) / (2 * math.pi * axes.prod() * math.sqrt(2 * slope))
    outer = _normal(one, found, _end(station)) ** (1 / 3)
    return Truth(
        draw=one,
        k_n=peak_pressure(one) * math.sqrt(2 * slope) * _normal(one, found, -1) ** (1 / 6),
        k_range=whole * cycle.range(-1 / 2),
        shares=tuple(abs(float(pull @ each) / np.linalg.norm(each)) for each in own),
        zone=_between(place * outer, inward / axes, cycle.permanent ** (1 / 3)),
    )


def _between(place: Array, inward: Array, radius: float) -> float:
    """Length inward from a place outside of a circle to where it enters it; all but lengths scaled.

    Where the line misses the circle the least distance from its middle counts as inside.
    """
    a, b = float(inward @ inward), float(place @ inward)
    c = float(place @ place) - radius**2
    return (-b - math.sqrt(max(b**2 - a * c, 0.0))) / a


def cylinder_truth(one: SolidDraw, found: Result, station: Station) -> Truth:
    """Plane strain under the line loads at a station of a cylinder."""
    normal, shear = _line_loads(one, found, float(station.point[2]))
    cycle = Cycle.of(one, shear / normal)
    a = one.a * math.sqrt(normal)
    outer = math.sqrt(_normal(one, found, _end(station)))
    last = _normal(one, found, -1) ** (1 / 4)
    line = normal * peak_force(one) / (CYLINDER_LENGTH * one.a)
    return Truth(
        draw=one,
        k_n=peak_pressure(one) * math.sqrt(normal) * math.sqrt(2 / a) * last,
        k_range=line * cycle.range(-1 / 4) / (math.pi * math.sqrt(2 * a)),
        shares=(1.0, 0.0),
        zone=a * (outer - math.sqrt(cycle.permanent)),
    )


def _line_loads(one: SolidDraw, found: Result, z: float) -> tuple[float, float]:
    """P and the range of Q per length at a place, over what they are on average."""
    (contact,) = found.solution.contacts
    cycle = found.solution.cycle
    assert cycle is not None
    rows, of_row = np.unique(np.round(contact.surface.points[:, 2] / one.a, 6), return_inverse=True)
    spans = np.bincount(of_row, contact.surface.weights) / np.ptp(contact.surface.points[:, 0])
    tractions = contact.mean_traction[cycle[0] : cycle[1] + 1]
    vectors = np.einsum("tnc,ncd->tnd", tractions[..., 1:], contact.surface.frames[:, 1:])[..., 0]

    def per_length(traction: Array) -> Array:
        return (
            np.bincount(of_row, contact.surface.weights * traction)
            / spans
            * CYLINDER_LENGTH
            * one.a
        )

    normal = per_length(tractions[-1, :, 0]) / -found.loads.values[-1, 0]
    shears = np.array([per_length(each) for each in vectors])
    shear = np.ptp(shears, axis=0) / (2 * shear_force(one))
    return float(np.interp(z / one.a, rows, normal)), float(np.interp(z / one.a, rows, shear))
