# SPDX-License-Identifier: LGPL-3.0-or-later
"""Convergence of a mesh that refines itself.

Each pass solves the whole history on one mesh. From two passes follows how much the results still
change; `resolution` tells where the next mesh has to be finer. A station of a plane contact is an
edge, which has a name; the stations of solids are compared by their places.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.partners import contact_partners, front_partners, nearest_places
from fretfe.history.solution import Solution

# Reads one number of a station.
Measure = Callable[[Station], float]
# Slip zones shorter than this fraction of the rise do not matter; they are not resolved.
SHORTEST_SLIP = 1e-3
# Changes shrink at least by this factor from pass to pass where values are extrapolated.
SHRINKING = 0.7
# A range of (K_T, K_S) below this part of the largest one along its front need not converge.
LEAST_RANGE = 0.2


@dataclass(frozen=True)
class StationValues:
    """Values that must converge at one station.

    Attributes:
        contact: name of the contact.
        front: name of its front.
        k_n: K_N in the state that decides.
        k_t: range of K_T over the cycle; without one that of the worst counted cycle if loads are
            irregular, else its largest value.
        slip: lengths of the longest slip zones, that first; NaN where unknown.
        rise: distance from the front in which the pressure rises to its largest value.
        friction: coefficient.
        number: of the station along its front.
        k_t_scale: least value that changes of K_T are compared with; infinite where it need not
            converge.
        spreads: error bars of `values` on this mesh; NaN where unknown, none of solids.
    """

    contact: str
    front: str
    k_n: float
    k_t: float
    slip: tuple[float, ...]
    rise: float
    friction: float
    number: int = 0
    k_t_scale: float = 0.0
    spreads: tuple[float, ...] = ()

    @property
    def key(self) -> tuple[str, str, int]:
        """Key that is the same for values that can be compared."""
        return self.contact, self.front, len(self.slip)

    @property
    def values(self) -> tuple[float, ...]:
        """K_N, K_T and the slip lengths."""
        return (self.k_n, self.k_t, *self.slip)

    @property
    def scales(self) -> tuple[float, ...]:
        """Scales that errors are compared with; values that are negligible need not converge.

        K_T and slip length d belong together by d = K_T/(f K_N).
        """
        shortest = SHORTEST_SLIP * self.rise
        return (
            abs(self.k_n),
            # The scale first: K_T need not be known where it is infinite.
            max(self.k_t_scale, abs(self.k_t), shortest * self.friction * self.k_n),
            *(max(length, shortest) for length in self.slip),
        )


@dataclass(frozen=True)
class Change:
    """Largest change of a number along a front from one mesh to the next.

    Attributes:
        contact: name of the contact.
        front: name of its front.
        quantity: one of `KINDS`.
        station: number of the station where it changed most, along the front of the finer mesh.
        value: there on the finer mesh.
        change: relative to its scale; NaN if it is not known on both meshes.
    """

    contact: str
    front: str
    quantity: str
    station: int
    value: float
    change: float

    @property
    def size(self) -> float:
        """The change; infinite if it is not known."""
        return self.change if math.isfinite(self.change) else math.inf

    @property
    def text(self) -> str:
        """The change in words."""
        changed = f"{self.change:.2%}" if math.isfinite(self.change) else "not known twice"
        return f"{self.quantity} at {self.contact}, {self.front}, station {self.station}: {changed}"


KINDS = ("K_N", "ΔK", "d")


@dataclass(frozen=True)
class Pass:
    """One mesh and what it gave.

    Attributes:
        unknowns: displacements of all bodies.
        smallest_element: at the contacts, along the surface.
        stations: values at each station.
        resolved: whether the mesh resolved rise and slip zones at all stations.
        changes: of each kind of value along each front, from the pass before; none if there is
            nothing to compare with.
    """

    unknowns: int
    smallest_element: float
    stations: tuple[StationValues, ...]
    resolved: bool
    changes: tuple[Change, ...]

    @property
    def worst(self) -> Change | None:
        """The largest of all changes; None without any."""
        return max(self.changes, key=lambda each: each.size, default=None)

    @property
    def change(self) -> float:
        """Largest change of any value; infinite if there is nothing to compare with."""
        return self.worst.size if self.worst else math.inf

    def of_kind(self, quantity: str) -> float:
        """Largest change of a kind of value; infinite if there is nothing to compare with."""
        sizes = [each.size for each in self.changes if each.quantity == quantity]
        return max(sizes, default=math.inf)


class Limit(NamedTuple):
    """The value that a sequence of meshes tends to, and its error bar, NaN if unknown."""

    value: float
    spread: float


@dataclass(frozen=True)
class Refinement:
    """History of a mesh that refined itself.

    Attributes:
        tolerance: wanted relative accuracy.
        passes: in time order; the last one is that of the results.
        converged: whether the last change is below the tolerance.
        reason: why it ended, in words.
    """

    tolerance: float
    passes: tuple[Pass, ...]
    converged: bool
    reason: str

    @property
    def limits(self) -> tuple[tuple[StationValues, tuple[Limit, ...]], ...]:
        """The edges of the last pass, and the limit of each of their values.

        Stations of solids scatter: their values have no limits that could be told.
        """
        last = self.passes[-1].stations if self.passes else ()
        return tuple((each, self._limits(each)) for each in last if each.spreads)

    def _limits(self, station: StationValues) -> tuple[Limit, ...]:
        """Limits of the values of an edge: off by their bars, and by what is added to them."""
        known = enumerate(zip(station.values, station.spreads, strict=True))
        limits = [
            (extrapolate(self.history(station, place)), last, own) for place, (last, own) in known
        ]
        return tuple(Limit(limit, own + abs(limit - last)) for limit, last, own in limits)

    def history(self, station: StationValues, value: int) -> tuple[float, ...]:
        """One value of a station in all passes that have it."""
        return tuple(
            found.values[value]
            for done in self.passes
            for found in done.stations
            if found.key == station.key
        )


def extrapolate(values: Sequence[float]) -> float:
    """Limit of a sequence whose changes shrink by a constant factor; else its last value.

    Aitken's formula for the last three: exact if the error of each pass is the same fraction of
    that of the one before, as for errors that go with a power of the element size.
    """
    if len(values) < 3:
        return values[-1] if values else math.nan
    first, second, last = values[-3:]
    before, after = second - first, last - second
    if not 0 < abs(after) < SHRINKING * abs(before):
        return last
    return last - after**2 / (after - before)


def edge_changes(
    before: Sequence[StationValues], after: Sequence[StationValues], names: Mapping[str, str]
) -> tuple[Change, ...]:
    """Changes at edges of plane contacts; none unless both passes have the same ones.

    Args:
        before: values on the coarser mesh.
        after: on the finer one.
        names: of the contacts after, that each had before.
    """
    known = {each.key: each.values for each in before}
    keys = [(names.get(name), front, zones) for name, front, zones in (x.key for x in after)]
    if len(known) != len(keys) or any(key not in known for key in keys):
        return ()
    return _largest(after, [known[key] for key in keys if key in known])


def names_before(before: Sequence[Contact], after: Sequence[Contact]) -> dict[str, str]:
    """Names on the coarser mesh of the contacts in the same place: patches may be counted anew."""
    twins = zip(after, contact_partners(after, before), strict=True)
    return {contact.name: twin.name for contact, twin in twins if twin is not None}


def station_changes(
    before: Sequence[Contact],
    contacts: Sequence[Contact],
    solution: Solution,
    after: Sequence[StationValues],
) -> tuple[Change, ...]:
    """Changes at the stations of solids, from the values before in the same places.

    Places that were too near an end before are not compared.

    Args:
        before: contacts on the coarser mesh.
        contacts: those on the finer one.
        solution: on the finer one.
        after: its values, as of `solid_values`.
    """
    references: list[tuple[float, ...] | None] = []
    for contact in contacts:
        fronts = [front for old in before if old.pair == contact.pair for front in old.fronts]
        twins = front_partners(contact.fronts, fronts)
        for front, twin in zip(contact.fronts, twins, strict=True):
            count = len(front.defined)
            if twin is None or not count:
                references += [(math.nan, math.nan)] * count
                continue
            places = np.array([station.point for station in front.defined])
            measures = (*_measures(solution, contact), lambda _: 0.0)
            *values, judged = at_places(twin, places, measures)
            references += [
                tuple(float(value[place]) for value in values) if judged[place] == 0 else None
                for place in range(count)
            ]
    known = any(front.defined for contact in before for front in contact.fronts)
    return _largest(after, references) if known else ()


def _largest(
    after: Sequence[StationValues], references: Sequence[Sequence[float] | None]
) -> tuple[Change, ...]:
    """For each front and kind of value the largest change from the references, if there are any."""
    worst: dict[tuple[str, str, str], Change] = {}
    for new, old in zip(after, references, strict=True):
        if old is None:
            continue
        for place, (value, was, scale) in enumerate(zip(new.values, old, new.scales, strict=True)):
            difference = abs(value - was)
            # Without a scale, as K_N is unknown and K_T vanishes, nothing tells how much it is.
            settled = not difference or math.isinf(scale)
            change = 0.0 if settled else difference / scale if scale else math.nan
            quantity = KINDS[min(place, 2)]
            found = Change(new.contact, new.front, quantity, new.number, value, change)
            key = new.contact, new.front, quantity
            if key not in worst or found.size > worst[key].size:
                worst[key] = found
    return tuple(worst.values())


def _measures(solution: Solution, contact: Contact) -> tuple[Measure, Measure]:
    """K_N and the range of (K_T, K_S) of stations of solids; zero without friction or cycle."""
    (history,) = (each for each in solution.contacts if each.name == contact.pair)
    if history.friction.largest > 0 and solution.cycle is not None:
        return (lambda each: each.reported_k_n), (lambda each: each.reported_range)
    return (lambda each: each.reported_k_n), (lambda _: 0.0)


def solid_values(contacts: Sequence[Contact], solution: Solution) -> tuple[StationValues, ...]:
    """Values that must converge at all stations of solids that have factors of their own.

    Slip zones follow from K_N and the range of (K_T, K_S) by the plane problem of each station.
    """
    found = []
    for contact in contacts:
        k_n, k_range = _measures(solution, contact)
        for front in contact.fronts:
            largest = np.nanmax(numbers(front.defined, k_range), initial=0.0)
            found += [
                StationValues(
                    contact=contact.name,
                    front=front.name,
                    k_n=k_n(station),
                    k_t=k_range(station),
                    slip=(),
                    rise=float(np.fmin(station.depth, station.length)),
                    friction=station.friction,
                    number=station.number,
                    k_t_scale=LEAST_RANGE * float(largest),
                )
                for station in front.defined
            ]
    return tuple(found)


def numbers(stations: Sequence[Station], measure: Measure) -> Array:
    """(n,) a number of stations."""
    return np.array([float(measure(station)) for station in stations])


def at_places(front: Front, points: Array, measures: Sequence[Measure]) -> Iterator[Array]:
    """Numbers (n,) of a front at the places of its line that are nearest to points (n, 3).

    Linear between the stations; NaN where a neighbour has none.
    """
    first, second, part, _ = nearest_places(front, points)
    for measure in measures:
        values = numbers(front.stations, measure)
        values[np.logical_not(front.along("defined"))] = np.nan
        # A place on a station needs no neighbour.
        terms = (part < 1, (1 - part) * values[first]), (part > 0, part * values[second])
        yield np.sum([np.where(used, term, 0.0) for used, term in terms], axis=0)
