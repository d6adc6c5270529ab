# SPDX-License-Identifier: LGPL-3.0-or-later
"""The edge or station that a test is to match, or the reason why it cannot be matched."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation
from fretfe.caution import Caution, about
from fretfe.errors import ModelError
from fretfe.evaluate.contacts import NO_NUMBER, Contact, Front, Station
from fretfe.evaluate.edge_tractions import edge_nodes
from fretfe.idealise.bodies import SIMILAR
from fretfe.reason import Kind
from fretfe.results.end_answers import beside_end
from fretfe.results.model import Result

# Correlation of K_T and K_I below which they do not vary in step.
IN_STEP = 0.99
# Range of K_I over that of K_T up to which it is round-off of a constant P.
ROUND_OFF = 1e-6
# Range of f K_I over that of K_T from which it changes slip zones.
NORMAL_COUNTS = 0.02
# Range of (K_T, K_S) across the direction in which it varies most, over the one along it, and sine
# of that direction, from which they are told.
TURNS = 0.05
# Stations of a front are neighbours up to this distance, in their spacing.
NEIGHBOURS = 1.5
# Nodes next to an edge, of solids rows of nodes, whose tractions alternate about the field.
FIRST_NODES = 3
# Nodes behind them between which tractions can be compared.
FEWEST_NODES = 2


@dataclass(frozen=True)
class Profile:
    """Tractions over the distance s inward from an edge, (m,) each.

    Attributes:
        s: increasing, from the third node on.
        pressure: p in the last state of the cycle.
        shear_change: change of q between the states of largest and smallest K_T, inward positive;
            of solids along the direction in which (K_T, K_S) varies most.
        limit: f (p + p') of these two states: how much q can change.
        peak: distance of the largest pressure from the edge, up to the centre of the contact.
    """

    s: Array
    pressure: Array
    shear_change: Array
    limit: Array
    peak: float


@dataclass(frozen=True)
class Target:
    """Edge factors of a cycle, with error bars of 95 %.

    At a station of solids K_T is (K_T, K_S) along the direction in which it varies most.

    Attributes:
        contact, edge: which it is; of solids number of the front, from 1, and of the station.
        k_n, k_n_spread: in the last state of the cycle.
        k_t_range, k_t_range_spread: of the evaluated cycle, or of the worst counted one.
        k_i_range: between the same states.
        in_step: 1 if K_T rises with K_I, -1 if it falls, 0 if they do not vary in step.
        friction: coefficient.
        slip: (2,) found lengths of the last two slip zones, NaN where not known.
        slip_spread: (2,) error bars.
        half_width: of the contact; of solids inward from the station.
        stiffening: relative growth of dP/da with the half-width; half of it times the slip length
            is the relative error to expect of the formula. NaN where not known.
        profile: tractions; None if the backend has none, or the mesh has too few nodes.
        warnings: those of the contact, and why tests may not match it.
        k_angle: direction of K_T from inward towards along, degrees; 0 in the plane.
        turning: range of (K_T, K_S) across that direction over `k_t_range`.
    """

    contact: str
    edge: str
    k_n: float
    k_n_spread: float
    k_t_range: float
    k_t_range_spread: float
    k_i_range: float
    in_step: int
    friction: float
    slip: tuple[float, float]
    slip_spread: tuple[float, float]
    half_width: float
    stiffening: float
    profile: Profile | None
    warnings: tuple[Caution, ...]
    k_angle: float
    turning: float

    @property
    def name(self) -> str:
        """Contact and edge, as given on the command line."""
        return f"{self.contact}.{self.edge}"

    @property
    def longest_slip(self) -> float:
        """The longer one of the slip zones; by the formula where none was found."""
        formula = self.k_t_range + self.friction * self.k_i_range
        found = [length for length in self.slip if math.isfinite(length)]
        return max(found, default=formula / (self.friction * self.k_n))


def read_target(result: Result, edge: str) -> Target:
    """Read the factors of an edge, or of a station of solids.

    Args:
        result: a complete run.
        edge: its name, as for `Result.find`.

    Raises:
        CaseError: if there is no such edge.
        OutputError: if the run is not complete.
        ModelError: if its factors are not known well enough to match them, with the reason.
    """
    contact, front, station = result.find(edge)
    name = contact.name_of(station)
    begin, end = _cycle(result, station, name)
    k_t_range, spread, k_i_range = _ranges(result, station, begin, end)
    k_n, k_n_spread = float(station.k_n[end]), float(station.k_n_spread[end])
    _require_partial(name, station)
    why = f": {station.lack.text}" if station.lack.text else ""
    _require_known(name, "K_N", k_n, k_n_spread, why)
    _require_known(name, "the range of K_T", k_t_range, spread, why)
    _require_similar(name, station)
    zones = station.slip_zones[-2:]
    lengths = [zone.reported_length for zone in zones] + [math.nan] * (2 - len(zones))
    spreads = [float(zone.spread) for zone in zones] + [math.nan] * (2 - len(zones))
    in_step = _in_step(station, begin, end)
    half_width = station.depth if contact.solid else float(contact.half_width[end])
    return Target(
        contact=contact.name,
        edge=name.removeprefix(f"{contact.name}."),
        k_n=k_n,
        k_n_spread=k_n_spread,
        k_t_range=k_t_range,
        k_t_range_spread=spread,
        k_i_range=k_i_range,
        in_step=in_step,
        friction=station.friction,
        slip=(lengths[0], lengths[1]),
        slip_spread=(spreads[0], spreads[1]),
        half_width=half_width,
        stiffening=float(station.stiffening),
        profile=_profile(result, front, station, (begin, end), half_width, contact.name),
        warnings=(
            *contact.warnings,
            *about(
                contact.name,
                station.front,
                (
                    *_warnings(contact, station, in_step, k_i_range * station.friction / k_t_range),
                    *_at_end(result, front, station),
                ),
            ),
        ),
        k_angle=station.k_angle,
        turning=station.turning,
    )


def _cycle(result: Result, station: Station, edge: str) -> tuple[int, int]:
    """First and last state of the cycle that counts."""
    cycles = station.cycles
    if len(cycles.count) and (cycles.irregular or result.loads.cycle is None):
        worst = cycles.worst
        first, last = sorted((int(cycles.start[worst]), int(cycles.end[worst])))
        return first, last
    if result.loads.cycle is None:
        reason = cycles.reason or "the loads do not cycle"
        raise ModelError(f"edge {edge}: expected a cycle of K_T to match, found none: {reason}")
    return result.loads.cycle


def _ranges(result: Result, station: Station, begin: int, end: int) -> tuple[float, float, float]:
    """Ranges of K_T, its error bar, and of K_I."""
    if (begin, end) == result.loads.cycle:
        size, spread, k_i_range = station.k_range, station.k_range_spread, station.k_i_range
    else:
        k_t, k_i = station.k_along[[begin, end]], station.k_i[[begin, end]]
        size, k_i_range = float(np.ptp(k_t)), float(np.ptp(k_i))
        relative = station.k_range_spread / station.k_range if station.k_range > 0 else math.nan
        spread = relative * size
    # A test whose P cycles by round-off would have no Q in proportion to it.
    return size, spread, k_i_range if k_i_range > ROUND_OFF * size else 0.0


def _require_known(edge: str, what: str, value: float, spread: float, why: str) -> None:
    if not math.isfinite(value):
        raise ModelError(f"edge {edge}: expected {what} to be known, found that it is not{why}")
    if not spread <= NO_NUMBER * value:
        found = f"{value:.4g} ± {spread:.2g}" if math.isfinite(spread) else "no error bar"
        raise ModelError(
            f"edge {edge}: expected {what} with an error bar of less than half of it, found {found}"
        )


def _require_partial(edge: str, station: Station) -> None:
    if station.slides:
        raise ModelError(
            f"edge {edge}: expected slip next to the edge only, found that the whole contact "
            "slips: there are no edge factors that a test could match"
        )


def _require_similar(edge: str, station: Station) -> None:
    if abs(station.oscillation) > oscillation(SIMILAR):
        raise ModelError(
            f"edge {edge}: expected elastically similar bodies (Dundurs' beta up to {SIMILAR:g}), "
            f"found unlike ones, epsilon = {station.oscillation:.3g}: shear alone makes K_I vary "
            "there, which tests with pads of similar materials do not follow"
        )


def _in_step(station: Station, begin: int, end: int) -> int:
    k_t, k_i = station.k_along[begin : end + 1], station.k_i[begin : end + 1]
    if not np.ptp(k_t) > 0 or not np.ptp(k_i) > ROUND_OFF * np.ptp(k_t):
        return 1
    correlation = float(np.corrcoef(k_t, k_i)[0, 1])
    return round(correlation) if abs(correlation) >= IN_STEP else 0


def _warnings(
    contact: Contact, station: Station, in_step: int, normal: float
) -> Iterator[tuple[Kind, str]]:
    """Properties of a cycle that tests do not follow, or that are not known well enough."""
    if not contact.steady:
        yield Kind.TARGET_UNSTEADY.found()
    if station.uncertain or station.uncertain_range:
        yield Kind.TARGET_UNCERTAIN.found()
    if in_step == 0 and normal > NORMAL_COUNTS:
        yield Kind.TARGET_OUT_OF_STEP.found()
    if abs(math.sin(math.radians(station.k_angle))) > TURNS:
        yield (
            Kind.TARGET_DIRECTION,
            f"K_T stands for (K_T, K_S) along the direction in which it varies most, "
            f"{station.k_angle:.0f}° from inward",
        )
    if station.turning > TURNS:
        yield (
            Kind.TARGET_TURNS,
            f"(K_T, K_S) turns: its range across that direction is {station.turning:.0%} of the "
            "one along it",
        )


def _at_end(result: Result, front: Front, station: Station) -> Iterator[tuple[Kind, str]]:
    """Range of factors along a front at a free end, for which no plane test stands."""
    beside = beside_end(result, station)
    if not beside:
        return
    places, ranges = front.along("arc"), front.along("reported_range")
    near = np.abs(places - station.arc) < NEIGHBOURS * front.length / len(places)
    reported = ranges[near & np.isfinite(ranges)]
    low, high = (f"{each:.3g}" for each in (reported.min(), reported.max()))
    yield (
        Kind.TARGET_AT_END,
        f"{beside}, and |ΔK| is {low} to {high} at this station and its neighbours: a plane test "
        "has the same along its whole edge, and no corner; it does not stand for slip along the "
        "front, nor for cracks that begin at the corner",
    )


def _profile(
    result: Result, front: Front, station: Station, cycle: tuple[int, int], width: float, name: str
) -> Profile | None:
    """Tractions next to an edge of the contact `name`, up to its centre."""
    begin, end = cycle
    if not result.solution.keeps(begin, end):
        return None
    history = result.contact_history(name)
    k_t = station.k_along[begin : end + 1]
    high, low = begin + int(np.nanargmax(k_t)), begin + int(np.nanargmin(k_t))
    nodes = edge_nodes(history, front, station, end, (0.0, width))
    s, *columns = (
        nodes.by_rows(each)[FIRST_NODES - 1 :]
        for each in (
            nodes.s,
            *(each for state in (end, high, low) for each in nodes.tractions(state)),
        )
    )
    if len(s) < FEWEST_NODES:
        return None
    p, _, p_high, q_high, p_low, q_low = columns
    return Profile(
        s=s,
        pressure=p,
        shear_change=q_high - q_low,
        limit=station.friction * (p_high + p_low),
        peak=float(s[int(np.argmax(p))]),
    )
