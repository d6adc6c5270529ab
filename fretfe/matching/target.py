# SPDX-License-Identifier: LGPL-3.0-or-later
"""The edge of a component that a test is to match, or the reason why it cannot be matched."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.errors import CaseError, ModelError, OutputError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.results.model import Result

# Correlation of K_T and K_I below which they do not vary in step.
IN_STEP = 0.99
# Range of f K_I over that of K_T from which it changes slip zones.
NORMAL_COUNTS = 0.02
# Nodes next to an edge whose tractions alternate about the field.
FIRST_NODES = 3


@dataclass(frozen=True)
class Profile:
    """Tractions over the distance s inward from an edge, (m,) each.

    Attributes:
        s: increasing, from the third node on.
        pressure: p in the last state of the cycle.
        shear_change: change of q between the states of largest and smallest K_T, inward positive.
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
    """Edge factors of a cycle, per unit thickness, with error bars of 95 %.

    Attributes:
        contact, edge: which it is.
        k_n, k_n_spread: in the last state of the cycle.
        k_t_range, k_t_range_spread: of the evaluated cycle, or of the worst counted one.
        k_i_range: between the same states.
        in_step: 1 if K_T rises with K_I, -1 if it falls, 0 if they do not vary in step.
        friction: coefficient.
        slip: (2,) found lengths of the last two slip zones, NaN where not known.
        slip_spread: (2,) error bars.
        half_width: of the contact.
        stiffening: relative growth of dP/da with the half-width; half of it times the slip length
            is the relative error to expect of the formula. NaN where not known.
        profile: tractions; None if the backend has none.
        warnings: in words.
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
    warnings: tuple[str, ...]

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
    """Read the factors of an edge.

    Args:
        result: a complete run of plane bodies.
        edge: "CONTACT.left" or "CONTACT.right".

    Raises:
        CaseError: if there is no such edge.
        OutputError: if the run is not complete.
        ModelError: if its factors are not known well enough to match them, with the reason.
    """
    contact, station = _find(result, edge)
    begin, end = _cycle(result, station, edge)
    k_t_range, spread, k_i_range = _ranges(result, station, begin, end)
    k_n, k_n_spread = float(station.k_n[end]), float(station.k_n_spread[end])
    _require_known(edge, "K_N", k_n, k_n_spread)
    _require_known(edge, "the range of K_T", k_t_range, spread)
    _require_partial(edge, station)
    zones = station.slip_zones[-2:]
    lengths = [zone.reported_length for zone in zones] + [math.nan] * (2 - len(zones))
    spreads = [float(zone.spread) for zone in zones] + [math.nan] * (2 - len(zones))
    friction = result.case.contacts[contact.pair].friction
    in_step = _in_step(station, begin, end)
    return Target(
        contact=contact.name,
        edge=station.front,
        k_n=k_n,
        k_n_spread=k_n_spread,
        k_t_range=k_t_range,
        k_t_range_spread=spread,
        k_i_range=k_i_range,
        in_step=in_step,
        friction=friction,
        slip=(lengths[0], lengths[1]),
        slip_spread=(spreads[0], spreads[1]),
        half_width=float(contact.half_width[end]),
        stiffening=float(station.stiffening),
        profile=_profile(result, contact, station, (begin, end)),
        warnings=_warnings(contact, station, in_step, k_i_range * friction / k_t_range),
    )


def _find(result: Result, edge: str) -> tuple[Contact, Station]:
    where = result.directory or result.case.source
    if result.solid:
        raise CaseError(
            f"{where}: expected results of plane bodies, found solids; `fretfe station` makes the "
            "plane problem of one of their stations"
        )
    if result.failure is not None:
        raise OutputError(f"{where}: expected complete results, found: {result.failure}")
    edges = {f"{one.name}.{each.front}": (one, each) for one in result.contacts
             for each in one.stations}  # fmt: skip
    if edge not in edges:
        raise CaseError(f"{where}: expected one of the edges {', '.join(edges)}, found {edge!r}")
    return edges[edge]


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
        return station.k_t_range, station.k_range_spread, station.k_i_range
    k_t, k_i = station.k_t[[begin, end]], station.k_i[[begin, end]]
    size = float(np.ptp(k_t))
    relative = station.k_range_spread / station.k_t_range if station.k_t_range > 0 else math.nan
    return size, relative * size, float(np.ptp(k_i))


def _require_known(edge: str, what: str, value: float, spread: float) -> None:
    if not math.isfinite(value):
        raise ModelError(f"edge {edge}: expected {what} to be known, found that it is not")
    if not spread <= 0.5 * value:
        found = f"{value:.4g} ± {spread:.2g}" if math.isfinite(spread) else "no error bar"
        raise ModelError(
            f"edge {edge}: expected {what} with an error bar of less than half of it, found {found}"
        )


def _require_partial(edge: str, station: Station) -> None:
    if any(zone.gross for zone in station.slip_zones[-2:]):
        raise ModelError(
            f"edge {edge}: expected slip next to the edge only, found that the whole contact slips "
            "in the cycle: there are no edge factors that a test could match"
        )


def _in_step(station: Station, begin: int, end: int) -> int:
    k_t, k_i = station.k_t[begin : end + 1], station.k_i[begin : end + 1]
    if not np.ptp(k_t) > 0 or not np.ptp(k_i) > 1e-6 * np.ptp(k_t):
        return 1
    correlation = float(np.corrcoef(k_t, k_i)[0, 1])
    return round(correlation) if abs(correlation) >= IN_STEP else 0


def _warnings(contact: Contact, station: Station, in_step: int, normal: float) -> tuple[str, ...]:
    found = list(contact.warnings)
    if not contact.steady:
        found.append("the cycle is not steady; the test will be")
    if station.uncertain or station.uncertain_range:
        found.append("K_N or the range of K_T is known to less than a twentieth")
    if in_step == 0 and normal > NORMAL_COUNTS:
        found.append("K_I does not vary in step with K_T; no test here follows that")
    return tuple(found)


def _profile(
    result: Result, contact: Contact, station: Station, cycle: tuple[int, int]
) -> Profile | None:
    """Tractions next to an edge, up to the centre of the contact."""
    begin, end = cycle
    if result.solution is None or not result.solution.keeps(begin, end):
        return None
    history = result.contact_history(contact.name)
    k_t = station.k_t[begin : end + 1]
    high, low = begin + int(np.nanargmax(k_t)), begin + int(np.nanargmin(k_t))
    sign = 1.0 if station.front == "left" else -1.0
    s = sign * (history.arc - station.position[end])
    inside = np.flatnonzero((s > 0) & (s <= contact.half_width[end]))
    inside = inside[np.argsort(s[inside])][FIRST_NODES - 1 :]
    p, p_high, p_low = (history.mean_traction[state][inside, 0] for state in (end, high, low))
    change = history.mean_traction[high][inside, 1] - history.mean_traction[low][inside, 1]
    return Profile(
        s=s[inside],
        pressure=p,
        shear_change=sign * change,
        limit=float(history.friction[end]) * (p_high + p_low),
        peak=float(s[inside][int(np.argmax(p))]),
    )
