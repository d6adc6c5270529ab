# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions and histories of two results, laid over each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import trapezoid

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.resultants import load_extremes
from fretfe.results.model import Result
from fretfe.results.tables import unit

Pairs = Sequence[tuple[Contact, Contact]]
# Times that differ by less than this fraction of the clock are the same.
SAME_TIME = 1e-9
LAST = "last state"


@dataclass(frozen=True)
class Curve:
    """Tractions of one result along a contact in one state; n nodes.

    Attributes:
        time: of the state.
        friction: coefficient in the step to the state.
        x: (n,) place along the contact.
        pressure, shear: (n,) means around the nodes.
    """

    time: float
    friction: float
    x: Array
    pressure: Array
    shear: Array


@dataclass(frozen=True)
class TractionPair:
    """Tractions of both results along a contact at a load extreme.

    Attributes:
        contact: its name in the first result.
        extreme: which one, in words.
        first, second: the two.
        pressure_difference: root of the integral of the squared difference of p, over that of p of
            the first one; NaN where the two do not overlap.
        shear_difference: the same of q, over that of f p of the first one; NaN without friction.
    """

    contact: str
    extreme: str
    first: Curve
    second: Curve
    pressure_difference: float
    shear_difference: float


@dataclass(frozen=True)
class HistoryPair:
    """A history in both results.

    Attributes:
        contact, edge, quantity, unit: as of a pair of numbers.
        first_times, second_times: (T,) of each result.
        first, second: (T,) of each result.
    """

    contact: str
    edge: str
    quantity: str
    unit: str
    first_times: Array
    second_times: Array
    first: Array
    second: Array

    @property
    def common(self) -> int:
        """Number of times that both results have, where both values are known."""
        return len(self._at_equal_times[0])

    @property
    def difference(self) -> float:
        """Largest difference at these times, over the largest value of the first one there.

        NaN without any.
        """
        first, second = self._at_equal_times
        size = float(np.abs(first).max(initial=0.0))
        return float(np.abs(second - first).max(initial=0.0)) / size if size > 0 else math.nan

    @cached_property
    def _at_equal_times(self) -> tuple[Array, Array]:
        """Both values, each (n,), at the times that both have and where both are known."""
        places = _equal_times(self.first_times, self.second_times)
        first, second = self.first[places[0]], self.second[places[1]]
        known = np.isfinite(first) & np.isfinite(second)
        return first[known], second[known]


def traction_pairs(
    first: Result, second: Result, pairs: Pairs
) -> tuple[tuple[TractionPair, ...], list[str]]:
    """Tractions at the two load extremes of each result, and why there are none."""
    if first.solid:
        return (), [
            "tractions of solids are not compared: their nodes have no common places; "
            "fretfe export writes them"
        ]
    for result in (first, second):
        if result.solution is None:
            return (), [f"no tractions are compared: backend {result.backend!r} has none"]
    found: list[TractionPair] = []
    notes: list[str] = []
    for one, two in pairs:
        try:
            compared = list(_contact_tractions(first, second, one, two))
            if not compared:
                notes.append(
                    f"tractions of contact {one.name} are not compared: its load extremes are of "
                    "other kinds in the two (K_T, K_I, or a constant load)"
                )
            found += compared
        except OutputError as error:  # not all states are kept
            notes.append(f"tractions of contact {one.name} are not compared: {error}")
    notes += [
        f"contact {each.contact} has other places x in the two: p and q are not subtracted"
        for each in found[::2]
        if math.isnan(each.pressure_difference)
    ]
    return tuple(found), notes


def _contact_tractions(
    first: Result, second: Result, one: Contact, two: Contact
) -> Iterator[TractionPair]:
    states = [_extremes(result, each) for result, each in ((first, one), (second, two))]
    for extreme in states[0]:
        if extreme in states[1]:
            curves = [
                _curve(result, each.name, chosen[extreme])
                for result, each, chosen in zip((first, second), (one, two), states, strict=True)
            ]
            yield TractionPair(one.name, extreme, curves[0], curves[1], *_differences(*curves))


def _extremes(result: Result, contact: Contact) -> dict[str, int]:
    """States of largest and smallest load of a contact by what they are, and the last state.

    Extremes are told apart by K_T, not by time: equal loads come back, and which of the states is
    the extreme one is a matter of round-off.
    """
    edges = contact.stations
    found = load_extremes([contact], result.loads.cycle)
    last = len(result.loads.times) - 1
    if len(found) < 2:
        return {LAST: found[0]}
    left = edges[0]
    load = left.k_t if np.ptp(left.k_t[found]) > 0 else left.k_i
    if not np.isfinite(load[found]).all():
        return {LAST: last}
    low, high = sorted(found, key=lambda state: float(load[state]))
    name = "K_T" if load is left.k_t else "K_I"
    return {f"largest {name} at the left edge": high, f"smallest {name} at the left edge": low}


def _curve(result: Result, name: str, state: int) -> Curve:
    history = result.contact_history(name)
    pressure, shear = history.mean_traction[state].T
    return Curve(
        time=float(result.loads.times[state]),
        friction=float(history.friction[state]),
        x=history.arc,
        pressure=pressure,
        shear=shear,
    )


def _differences(first: Curve, second: Curve) -> tuple[float, float]:
    """Of pressure and shear, as of `TractionPair`, over both contacts."""
    pressed = [each.x[each.pressure > 0] for each in (first, second)]
    if not all(map(len, pressed)) or max(x[0] for x in pressed) >= min(x[-1] for x in pressed):
        return math.nan, math.nan
    x = np.union1d(first.x, second.x)
    values = {
        name: [_between(x, each, name) for each in (first, second)]
        for name in ("pressure", "shear")
    }
    pressure = _norm(x, values["pressure"][0])
    change = {name: _norm(x, two - one) for name, (one, two) in values.items()}
    bound = first.friction * pressure
    return (
        change["pressure"] / pressure if pressure > 0 else math.nan,
        change["shear"] / bound if bound > 0 else math.nan,
    )


def _between(x: Array, curve: Curve, name: str) -> Array:
    """(n,) values at places x: linear between nodes, zero beyond the ends of the surface."""
    return np.asarray(np.interp(x, curve.x, getattr(curve, name), left=0.0, right=0.0))


def _norm(x: Array, values: Array) -> float:
    """Root of the integral of the square."""
    return float(np.sqrt(trapezoid(values**2, x)))


def history_pairs(first: Result, second: Result, pairs: Pairs) -> Iterator[HistoryPair]:
    """Histories of all contacts that belong together."""
    force, area, factor = (
        unit(kind, first.case.units, solid=first.solid) for kind in ("force", "area", "k_t")
    )
    times = first.loads.times, second.loads.times
    for one, two in pairs:
        name, loads = one.name, (one.normal_force, two.normal_force)
        yield HistoryPair(name, "", "P", force, *times, *loads)
        if one.solid:
            areas = one.contact_area, two.contact_area
            yield HistoryPair(name, "", "area", area, *times, *areas)
            continue
        yield HistoryPair(name, "", "Q", force, *times, one.shear_force, two.shear_force)
        for edge, partner in zip(one.stations, two.stations, strict=True):
            yield HistoryPair(name, edge.front, "K_T", factor, *times, edge.k_t, partner.k_t)


def _equal_times(first: Array, second: Array) -> tuple[Indices, Indices]:
    """(n,) places of equal times in both, which increase."""
    nearest = np.clip(np.searchsorted(second, first), 1, max(len(second) - 1, 1))
    nearest = np.minimum(nearest, len(second) - 1)
    before = np.abs(second[nearest - 1] - first) < np.abs(second[nearest] - first)
    nearest = nearest - before
    same = np.abs(second[nearest] - first) <= SAME_TIME * max(first[-1], second[-1])
    return np.flatnonzero(same), nearest[same]
