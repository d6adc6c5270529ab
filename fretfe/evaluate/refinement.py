# SPDX-License-Identifier: LGPL-3.0-or-later
"""Convergence of a mesh that refines itself.

Each pass solves the whole history on one mesh. From two passes follows how much the results still
change; `resolution` tells where the next mesh has to be finer. Numbers of single stations of solids
scatter with the ragged border of a discrete contact area; means along their fronts do not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.history.solution import Solution

# Slip zones shorter than this fraction of the rise do not matter; they are not resolved.
SHORTEST_SLIP = 1e-3
# Changes shrink at least by this factor from pass to pass where values are extrapolated.
SHRINKING = 0.7
# Share of the stations of a front that must have a number for its mean.
KNOWN = 0.5


@dataclass(frozen=True)
class StationValues:
    """Values that must converge at one station.

    Attributes:
        contact: name of the contact.
        front: name of its front.
        k_n: K_N in the last state.
        k_t: range of K_T over the cycle; without one that of the worst counted cycle if loads are
            irregular, else its last value.
        slip: lengths of the last slip zones in time order; NaN where unknown.
        rise: distance from the front in which the pressure rises to its largest value.
        friction: coefficient.
    """

    contact: str
    front: str
    k_n: float
    k_t: float
    slip: tuple[float, ...]
    rise: float
    friction: float

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
            max(abs(self.k_t), shortest * self.friction * self.k_n),
            *(max(length, shortest) for length in self.slip),
        )


@dataclass(frozen=True)
class Pass:
    """One mesh and what it gave.

    Attributes:
        unknowns: displacements of all bodies.
        smallest_element: at the contacts, along the surface.
        stations: values at each station.
        resolved: whether the mesh resolved rise and slip zones at all stations.
        change: largest change of any value from the pass before, relative to its scale; infinite if
            there is nothing to compare with.
    """

    unknowns: int
    smallest_element: float
    stations: tuple[StationValues, ...]
    resolved: bool
    change: float


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
    def limits(self) -> tuple[tuple[StationValues, tuple[float, ...]], ...]:
        """The stations of the last pass, and the limit of each of their values."""
        last = self.passes[-1].stations if self.passes else ()
        return tuple(
            (each, tuple(extrapolate(self.history(each, v)) for v in range(len(each.values))))
            for each in last
        )

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


def changes_by_kind(
    before: Sequence[StationValues], after: Sequence[StationValues]
) -> tuple[float, float, float]:
    """Largest relative change of K_N, of K_T and of slip lengths; infinite if one is unknown."""
    if not after or [each.key for each in before] != [each.key for each in after]:
        return math.inf, math.inf, math.inf
    changes = [0.0, 0.0, 0.0]
    for old, new in zip(before, after, strict=True):
        for place, (value, other, scale) in enumerate(
            zip(old.values, new.values, new.scales, strict=True)
        ):
            difference = abs(other - value)
            change = difference / scale if difference else 0.0
            kind = min(place, 2)
            changes[kind] = max(changes[kind], change if math.isfinite(change) else math.inf)
    return changes[0], changes[1], changes[2]


def front_means(contacts: Sequence[Contact], solution: Solution) -> tuple[StationValues, ...]:
    """Means of K_N, of the range of (K_T, K_S) and of the last two slip zones along each front."""
    friction = {each.name: float(each.friction.max()) for each in solution.contacts}
    return tuple(
        _values(each.name, front, friction[each.name], solution.cycle is not None)
        for each in contacts
        for front in each.fronts
        if front.judged
    )


def _values(contact: str, front: Front, friction: float, cyclic: bool) -> StationValues:
    stations = front.judged
    slides = friction > 0 and cyclic
    return StationValues(
        contact=contact,
        front=front.name,
        k_n=_mean([station.reported_k_n for station in stations]),
        k_t=_mean([station.reported_range for station in stations]) if slides else 0.0,
        slip=tuple(_slip(stations, half) for half in (-2, -1)) if slides else (),
        rise=_mean([min(station.depth, station.length) for station in stations]),
        friction=friction,
    )


def _slip(stations: Sequence[Station], half: int) -> float:
    """Mean length of one of the last two slip zones where they are resolved."""
    zones = [each.slip_zones[half] for each in stations if len(each.slip_zones) > 1]
    lengths = [zone.length if zone.resolved and not zone.gross else np.nan for zone in zones]
    return _mean(lengths + [np.nan] * (len(stations) - len(zones)))


def _mean(values: Sequence[float]) -> float:
    """Mean of what is known; NaN if that is less than half."""
    known = np.isfinite(values)
    return float(np.mean(np.asarray(values)[known])) if known.mean() >= KNOWN else np.nan
