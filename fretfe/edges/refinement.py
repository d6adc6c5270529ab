# SPDX-License-Identifier: LGPL-3.0-or-later
"""A mesh that refines itself: where it must be how fine, and when it is fine enough.

Each pass solves the whole history on one mesh. From its solution follow the places where contact
edges and the inner ends of slip zones are during the cycle, and the element sizes that these need;
from two passes follows how much the results still change.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.edges import main_patch
from fretfe.edges.evaluate import ContactSummary, Edge
from fretfe.edges.slip_zones import SlipZone, cycle_states
from fretfe.results.solution import ContactHistory, Solution

# Elements over the length in which the pressure rises, and over a slip zone, in the first mesh that
# resolves an edge; each further level halves the elements.
PER_RISE, PER_SLIP_ZONE = 16, 8
# Elements may be larger than asked for by this factor: a mesh follows sizes only roughly.
MISSED = 1.3
# So much smaller are the next elements where these are too large to tell K_N.
BLIND = 4
# Slip zones shorter than this fraction of the rise do not matter; they are not resolved.
SHORTEST_SLIP = 1e-3
# Slip lengths that are reported and must converge: those of the last loading and unloading.
ZONES = 2
# Changes shrink at least by this factor from pass to pass where values are extrapolated.
SHRINKING = 0.7


@dataclass(frozen=True)
class EdgeValues:
    """What must converge at one edge.

    Attributes:
        contact: name of the contact.
        side: "left" or "right".
        k_n: K_N in the last state.
        k_t: range of K_T over the cycle, or its last value without a cycle.
        slip: lengths of the last slip zones in time order; NaN where unknown.
        rise: distance from the edge in which the pressure rises to its largest value.
        friction: coefficient.
    """

    contact: str
    side: str
    k_n: float
    k_t: float
    slip: tuple[float, ...]
    rise: float
    friction: float

    @property
    def key(self) -> tuple[str, str, int]:
        """The same for values that can be compared."""
        return self.contact, self.side, len(self.slip)

    @property
    def values(self) -> tuple[float, ...]:
        """K_N, K_T and the slip lengths."""
        return (self.k_n, self.k_t, *self.slip)

    @property
    def scales(self) -> tuple[float, ...]:
        """What errors are compared with; values that are negligible need not converge.

        K_T and slip length d belong together by d = K_T/(f K_N).
        """
        shortest = SHORTEST_SLIP * self.rise
        return (
            abs(self.k_n),
            max(abs(self.k_t), shortest * self.friction * self.k_n),
            *(max(length, shortest) for length in self.slip),
        )


@dataclass(frozen=True)
class Interval:
    """Places low to high along the arc of a contact that need elements of a size."""

    contact: str
    low: float
    high: float
    size: float


@dataclass(frozen=True)
class Pass:
    """One mesh and what it gave.

    Attributes:
        unknowns: displacements of all bodies.
        smallest_element: at the contacts, along the surface.
        edges: values at each edge.
        resolved: whether the mesh resolved rise and slip zones at all edges.
        change: largest change of any value from the pass before, relative to its scale; infinite if
            there is nothing to compare with.
    """

    unknowns: int
    smallest_element: float
    edges: tuple[EdgeValues, ...]
    resolved: bool
    change: float


@dataclass(frozen=True)
class Refinement:
    """How the mesh refined itself.

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
    def limits(self) -> tuple[tuple[EdgeValues, tuple[float, ...]], ...]:
        """The edges of the last pass, and what each of their values tends to."""
        last = self.passes[-1].edges if self.passes else ()
        return tuple(
            (edge, tuple(extrapolate(self.history(edge, v)) for v in range(len(edge.values))))
            for edge in last
        )

    def history(self, edge: EdgeValues, value: int) -> tuple[float, ...]:
        """One value of an edge in all passes that have it."""
        return tuple(
            found.values[value]
            for done in self.passes
            for found in done.edges
            if found.key == edge.key
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


def edge_values(solution: Solution, contacts: Sequence[ContactSummary]) -> tuple[EdgeValues, ...]:
    """What must converge, for both edges of each contact that carries something at the end."""
    return tuple(
        EdgeValues(
            contact=contact.name,
            side=edge.side,
            k_n=float(edge.k_n[-1]),
            k_t=edge.k_t_range if solution.cycle is not None else float(edge.k_t[-1]),
            slip=tuple(zone.length for zone in _last_zones(edge)),
            rise=_rise(history, contact, edge),
            friction=float(history.friction.max()),
        )
        for history, contact, edge in _edges(solution, contacts)
    )


def _edges(
    solution: Solution, contacts: Sequence[ContactSummary]
) -> Iterator[tuple[ContactHistory, ContactSummary, Edge]]:
    for history, contact in zip(solution.contacts, contacts, strict=True):
        if np.any(history.traction[-1, :, 0] > 0):
            for edge in contact.edges:
                yield history, contact, edge


def changes_by_kind(
    before: Sequence[EdgeValues], after: Sequence[EdgeValues]
) -> tuple[float, float, float]:
    """Largest relative change of K_N, of K_T and of slip lengths; infinite if one is unknown."""
    if [edge.key for edge in before] != [edge.key for edge in after]:
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


def _last_zones(edge: Edge) -> tuple[SlipZone, ...]:
    """The last slip zones; those of a contact that slides as a whole have no length."""
    return tuple(zone for zone in edge.slip_zones[-ZONES:] if not zone.gross)


def _rise(history: ContactHistory, contact: ContactSummary, edge: Edge) -> float:
    """Distance in which p = K_N sqrt(s) would rise to the largest pressure on this side.

    Half of the half-width for Hertz; about the length of the rounding in contact for a flat and
    rounded punch. At most the half-width; that of the closed elements while K_N is unknown.
    """
    pressure = history.traction[-1, :, 0]
    patch = main_patch(history.arc, pressure)
    half_width = float(contact.half_width[-1])
    if not np.isfinite(edge.k_n[-1]) or not np.isfinite(half_width):
        low, high = max(patch.first - 1, 0), min(patch.last + 1, len(pressure) - 1)
        return float(history.arc[high] - history.arc[low]) / 2
    inside = slice(patch.first, patch.last + 1)
    arc, pressure = history.arc[inside], pressure[inside]
    near = arc <= contact.centre[-1] if edge.side == "left" else arc >= contact.centre[-1]
    return float(min((pressure[near].max() / edge.k_n[-1]) ** 2, half_width))


def needed_sizes(
    solution: Solution, contacts: Sequence[ContactSummary], level: int
) -> tuple[Interval, ...]:
    """Where elements must be how small; each level halves them."""
    intervals: list[Interval] = []
    for values, (history, contact, edge) in zip(
        edge_values(solution, contacts), _edges(solution, contacts), strict=True
    ):
        intervals += _edge_intervals(solution, history, contact, edge, values, 2.0**-level)
    return tuple(intervals)


def resolves(solution: Solution, intervals: Sequence[Interval]) -> bool:
    """Whether the elements of the surfaces that carry the tractions are as small as needed."""
    contacts = {contact.name: contact for contact in solution.contacts}
    return all(
        _largest_element(contacts[each.contact].arc, each.low, each.high) <= MISSED * each.size
        for each in intervals
    )


def _largest_element(arc: Array, low: float, high: float) -> float:
    first = max(int(np.searchsorted(arc, low, side="right")) - 1, 0)
    last = min(int(np.searchsorted(arc, high, side="left")), len(arc) - 1)
    return float(np.diff(arc[first : max(last, first + 1) + 1]).max())


def _edge_intervals(
    solution: Solution,
    history: ContactHistory,
    contact: ContactSummary,
    edge: Edge,
    values: EdgeValues,
    refinement: float,
) -> list[Interval]:
    """The range of an edge in the cycle and its slip zones; finer where numbers are taken.

    Those places are the edge at the end of the history and of half cycles, and the inner ends of
    slip zones; only there do the elements shrink with the level.
    """
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    low, high = _edge_range(history, edge, states)
    size = values.rise / PER_RISE
    if not np.isfinite(edge.k_n[-1]) or edge.uncertain:
        size = min(size, _largest_element(history.arc, low, high) / BLIND)
    inward = 1.0 if edge.side == "left" else -1.0
    places, intervals = [(float(edge.position[-1]), size)], []
    for zone in _last_zones(edge):
        length = _length(zone)
        if length > SHORTEST_SLIP * values.rise:
            position, zone_size = float(edge.position[zone.end]), length / PER_SLIP_ZONE
            ends = (position, position + inward * length)
            intervals.append(Interval(contact.name, min(ends), max(ends), zone_size))
            size = min(size, zone_size)
            places += [(end, min(size, zone_size)) for end in ends]
    intervals.append(Interval(contact.name, low, high, size))
    intervals += [
        Interval(contact.name, place, place, refinement * min(size, own))
        for place, own in places
        if math.isfinite(place)
    ]
    return intervals


def _length(zone: SlipZone) -> float:
    """Length of a slip zone, or what is predicted while the mesh does not resolve it."""
    if zone.resolved and zone.length > 0:
        return zone.length
    return zone.prediction if math.isfinite(zone.prediction) else 0.0


def _edge_range(history: ContactHistory, edge: Edge, states: Indices) -> tuple[float, float]:
    """Where an edge is in some states: fitted, or else between the last closed and open nodes."""
    positions = edge.position[states]
    if np.isfinite(positions).all():
        return float(positions.min()), float(positions.max())
    arc, last = history.arc, len(history.arc) - 1
    places = []
    for state in states:
        if not np.any(history.traction[state, :, 0] > 0):
            continue
        patch = main_patch(arc, history.traction[state, :, 0])
        if edge.side == "left":
            places += [arc[max(patch.first - 1, 0)], arc[patch.first]]
        else:
            places += [arc[patch.last], arc[min(patch.last + 1, last)]]
    return float(min(places)), float(max(places))
