# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions and histories of two results, laid over each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.integrate import trapezoid
from scipy.spatial import Delaunay

from fretfe._typing import Array, Indices
from fretfe.errors import ModelError, OutputError
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.partners import front_partners
from fretfe.evaluate.resultants import SMALLEST_SHEAR, load_extremes, shear_direction, shear_line
from fretfe.history.solution import ContactHistory
from fretfe.report.pictures.unroll import unroll
from fretfe.results.model import Result
from fretfe.results.quantities import unit

# Times that differ by less than this fraction of the clock are the same.
SAME_TIME = 1e-9
LAST = "last state"
# Points of a line through a contact of solids, and how far it goes on beside it, over its width.
POINTS = 401
BEYOND = 0.1
# Ends of two meshes of a surface lie beside each other by round-off, and bent ones by their chords:
# so far beyond a triangle, over its height, values are linear as in it.
BESIDE = 1e-3
# Share of Q that lies in the plane of the surface, if there is any.
IN_PLANE = 0.1
Results = tuple[Result, Result]
Contacts = tuple[Contact, Contact]
States = tuple[int, int]


@dataclass(frozen=True)
class ContactPair:
    """Contacts of two results that belong together."""

    first: Contact
    second: Contact

    @cached_property
    def fronts(self) -> list[tuple[Front, Front]]:
        """Fronts in the same place."""
        fronts = self.first.fronts
        partners = front_partners(fronts, self.second.fronts)
        return [(one, two) for one, two in zip(fronts, partners, strict=True) if two is not None]

    @property
    def stations(self) -> Iterator[tuple[Station, Station]]:
        """Stations that belong together: edges, of solids the worst of a front and the nearest."""
        if not self.first.solid:
            yield from zip(self.first.stations, self.second.stations, strict=True)
            return
        for front, other in self.fronts:
            if (worst := front.worst) is not None:
                gaps = np.linalg.norm(other.along("point") - worst.point, axis=1)
                yield worst, other.stations[int(gaps.argmin())]


@dataclass(frozen=True)
class Curve:
    """Tractions of one result along a contact in one state; n nodes.

    Of solids they are those along a line on the surface of the first result, through its centre of
    pressure in the direction in which its Q varies most; n points.

    Attributes:
        time: of the state.
        friction: largest coefficient in the step to the state.
        x: (n,) place along the contact; of solids from the centre of pressure.
        pressure, shear: (n,) means around the nodes, of solids linear between them; their shear is
            that along the line.
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
            the first one; of solids over the surface. NaN where the two do not overlap.
        shear_difference: the same of q, of solids a vector, over that of f p of the first one; NaN
            without friction.
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
        counted_from: time at which the second value is set to the first one; None if it is as it
            was found.
    """

    contact: str
    edge: str
    quantity: str
    unit: str
    first_times: Array
    second_times: Array
    first: Array
    second: Array
    counted_from: float | None = None

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

    def counted_alike(self) -> HistoryPair:
        """The same with both values counted from one time.

        Sums of increments start where the first of these is known. If the two know other ones,
        they differ by a constant that means nothing.
        """
        starts = [
            float(times[known][0]) if (known := np.isfinite(values)).any() else math.nan
            for times, values in ((self.first_times, self.first), (self.second_times, self.second))
        ]
        first, second = self._at_equal_times
        if abs(starts[1] - starts[0]) <= SAME_TIME * self.first_times[-1] or not len(first):
            return self
        shifted = self.second + (first[0] - second[0])
        return replace(self, second=shifted, counted_from=max(starts))

    @cached_property
    def _at_equal_times(self) -> tuple[Array, Array]:
        """Both values, each (n,), at the times that both have and where both are known."""
        places = _equal_times(self.first_times, self.second_times)
        first, second = self.first[places[0]], self.second[places[1]]
        known = np.isfinite(first) & np.isfinite(second)
        return first[known], second[known]


def traction_pairs(
    first: Result, second: Result, pairs: Sequence[ContactPair]
) -> tuple[tuple[TractionPair, ...], list[str]]:
    """Tractions at the two load extremes of each result, and why there are none."""
    found: list[TractionPair] = []
    notes: list[str] = []
    for pair in pairs:
        one, two = pair.first, pair.second
        try:
            compared = list(_contact_tractions(first, second, one, two))
            if not compared:
                notes.append(
                    f"tractions of contact {one.name} are not compared: its load extremes are of "
                    "other kinds in the two (K_T, K_I, of solids Q, P, or a constant load)"
                )
            found += compared
        except (ModelError, OutputError) as error:  # not all states are kept
            notes.append(f"tractions of contact {one.name} are not compared: {error}")
    notes += [
        f"contact {each.contact} has other places in the two: p and q are not subtracted"
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
            chosen = states[0][extreme], states[1][extreme]
            lay = _solid_curves if one.solid else _plane_curves
            yield TractionPair(one.name, extreme, *lay((first, second), (one, two), chosen))


def _extremes(result: Result, contact: Contact) -> dict[str, int]:
    """States of largest and smallest load of a contact by what they are, and the last state.

    Extremes are told apart by K_T, of solids by Q, not by time: equal loads come back, and which of
    the states is the extreme one is a matter of round-off.
    """
    found = load_extremes([contact], result.loads.cycle)
    last = len(result.loads.times) - 1
    if len(found) < 2:
        return {LAST: found[0]}
    if contact.solid:
        shear, normal = contact.shear_force @ _line(result, contact), contact.normal_force
        sheared = np.ptp(shear[found]) > SMALLEST_SHEAR * np.abs(normal).max()
        load, name = (shear, "Q") if sheared else (normal, "P")
    else:
        left = contact.stations[0]
        sheared = np.ptp(left.k_along[found]) > 0
        load = left.k_along if sheared else left.k_i
        name = f"{'K_T' if sheared else 'K_I'} at the left edge"
    if not np.isfinite(load[found]).all():
        return {LAST: last}
    low, high = sorted(found, key=lambda state: float(load[state]))
    return {f"largest {name}": high, f"smallest {name}": low}


def _line(result: Result, contact: Contact) -> Array:
    """(3,) direction in which Q of solids varies most."""
    first, last = result.loads.evaluated
    return shear_direction(contact.shear_force[first : last + 1])


def _plane_curves(
    results: Results, contacts: Contacts, states: States
) -> tuple[Curve, Curve, float, float]:
    begin, end = results[0].loads.evaluated
    line = shear_line(contacts[0], slice(begin, end + 1))
    first, second = (
        _curve(result, each.name, state, line)
        for result, each, state in zip(results, contacts, states, strict=True)
    )
    return first, second, *_differences(first, second)


def _curve(result: Result, name: str, state: int, line: Array) -> Curve:
    """Tractions of a plane contact, with the shear along a line (d - 1,), by arc and z."""
    history = result.contact_history(name)
    mean = history.mean_traction[state]
    pressure, size = mean[:, 0], mean.shape[1] - 1
    shear = mean[:, 1:] @ np.pad(line, (0, max(size - len(line), 0)))[:size]
    return Curve(
        time=float(result.loads.times[state]),
        friction=float(history.friction.at(state).max()),
        x=history.surface.arc,
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


class _Field:
    """Tractions of a contact of solids in one state, linear between the nodes.

    Args:
        result: of the contact.
        contact: its tractions.
        state: one in which they are kept.
        places: (N, 2) of the nodes in the plane of a surface.
    """

    def __init__(self, result: Result, contact: ContactHistory, state: int, places: Array) -> None:
        mean = contact.mean_traction[state]
        shear = np.einsum("nt,ntd->nd", mean[:, 1:], contact.surface.frames[:, 1:])
        self.values = np.column_stack([mean[:, 0], shear])
        self.time = float(result.loads.times[state])
        self.friction = float(contact.friction.at(state).max())
        self.pressed = places[mean[:, 0] > 0]
        self._triangles = Delaunay(places)

    def at(self, places: Array) -> Array:
        """(n, 4) p and q, zero beyond the ends of the surface."""
        cell = self._triangles.find_simplex(places, tol=BESIDE)
        linear = self._triangles.transform[cell]
        first_two = np.einsum("nij,nj->ni", linear[:, :2], places - linear[:, 2])
        weights = np.column_stack([first_two, 1 - first_two.sum(axis=1)])
        values = np.einsum("nk,nkc->nc", weights, self.values[self._triangles.simplices[cell]])
        return np.where(cell[:, None] >= 0, values, 0.0)

    def along(self, x: Array, places: Array, direction: Array) -> Curve:
        """The curve at places (n, 2), with the shear along a direction (3,)."""
        values = self.at(places)
        return Curve(self.time, self.friction, x, values[:, 0], values[:, 1:] @ direction)


def _solid_curves(
    results: Results, contacts: Contacts, states: States
) -> tuple[Curve, Curve, float, float]:
    """Tractions of solids in the plane into which the first surface is laid, and differences.

    Raises:
        ModelError: if there is no such plane.
    """
    one, two = (
        result.contact_history(each.name) for result, each in zip(results, contacts, strict=True)
    )
    if (one.surface.frames[:, 0] @ (one.surface.weights @ one.surface.frames[:, 0]) <= 0).any():
        raise ModelError("expected a surface within 90° of its mean direction, found more")
    plane = unroll(one)
    first = _Field(results[0], one, states[0], plane.places)
    second = _Field(results[1], two, states[1], plane.at(one, two.surface.points))
    centre = contacts[0].centre[states[0]]
    # Where nothing presses in the first result there is no centre.
    middle = plane.at(one, centre[None])[0] if np.isfinite(centre).all() else np.zeros(2)
    line = plane.directions @ _line(results[0], contacts[0])
    # Without shear the direction is any, across the surface too.
    line = line / np.linalg.norm(line) if np.linalg.norm(line) > IN_PLANE else np.array([1.0, 0.0])
    ends = np.concatenate([[0.0], *((each.pressed - middle) @ line for each in (first, second))])
    margin = BEYOND * np.ptp(ends)
    x = np.linspace(ends.min() - margin, ends.max() + margin, POINTS)
    places, direction = middle + x[:, None] * line, line @ plane.directions
    curves = first.along(x, places, direction), second.along(x, places, direction)
    return *curves, *_surface_differences(one.surface.weights, first, second.at(plane.places))


def _surface_differences(weights: Array, first: _Field, other: Array) -> tuple[float, float]:
    """Of pressure and shear, as of `TractionPair`, by the other tractions at the same nodes."""
    own, change = first.values, other - first.values
    if not ((own[:, 0] > 0) & (other[:, 0] > 0)).any():
        return math.nan, math.nan
    pressure, of_p, of_q = (
        math.sqrt(weights @ (each**2).sum(axis=1))
        for each in (own[:, :1], change[:, :1], change[:, 1:])
    )
    bound = first.friction * pressure
    return of_p / pressure, of_q / bound if bound > 0 else math.nan


def _between(x: Array, curve: Curve, name: str) -> Array:
    """(n,) values at places x: linear between nodes, zero beyond the ends of the surface."""
    return np.asarray(np.interp(x, curve.x, getattr(curve, name), left=0.0, right=0.0))


def _norm(x: Array, values: Array) -> float:
    """Root of the integral of the square."""
    return float(np.sqrt(trapezoid(values**2, x)))


def history_pairs(
    first: Result, second: Result, pairs: Sequence[ContactPair]
) -> Iterator[HistoryPair]:
    """Histories of all contacts that belong together.

    Q of solids is that along the direction in which it varies most in the first result.
    """
    force, area, factor = (
        unit(kind, first.case.units, solid=first.solid) for kind in ("force", "area", "k_t")
    )
    times = first.loads.times, second.loads.times
    for pair in pairs:
        one, two = pair.first, pair.second
        name, loads = one.name, (one.normal_force, two.normal_force)
        yield HistoryPair(name, "", "P", force, *times, *loads)
        if one.solid:
            line = _line(first, one)
            shears = one.shear_force @ line, two.shear_force @ line
            areas = one.contact_area, two.contact_area
            yield HistoryPair(name, "", "Q", force, *times, *shears)
            yield HistoryPair(name, "", "area", area, *times, *areas)
        else:
            yield HistoryPair(name, "", "Q", force, *times, one.shear_force, two.shear_force)
        for station, partner in pair.stations:
            along = station.k_along, replace(partner, k_angle=station.k_angle).k_along
            label = "K" if one.solid else "K_T"
            found = HistoryPair(name, station.front, label, factor, *times, *along)
            yield found.counted_alike()


def _equal_times(first: Array, second: Array) -> tuple[Indices, Indices]:
    """(n,) places of equal times in both, which increase."""
    nearest = np.clip(np.searchsorted(second, first), 1, max(len(second) - 1, 1))
    nearest = np.minimum(nearest, len(second) - 1)
    before = np.abs(second[nearest - 1] - first) < np.abs(second[nearest] - first)
    nearest = nearest - before
    same = np.abs(second[nearest] - first) <= SAME_TIME * max(first[-1], second[-1])
    return np.flatnonzero(same), nearest[same]
