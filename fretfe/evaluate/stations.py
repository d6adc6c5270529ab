# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stations of fronts, from what is known at their edges, in the plane and between solids."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import oscillation
from fretfe.evaluate.contacts import (
    LARGEST_SPREAD,
    CountedCycles,
    Frame,
    SlipZone,
    Station,
    StationHistory,
    unknown_station,
    without_formulas,
)
from fretfe.evaluate.cycles import count_cycles
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.edge_loads import EdgeLoads, edge_loads, returned, unlike_loads, without_traces
from fretfe.evaluate.edge_memory import EdgeMemory, FindPath
from fretfe.evaluate.edge_slip import HalfCycle
from fretfe.evaluate.factors import (
    FactorHistories,
    along_line,
    cycle_range,
    main_direction,
    reference_length,
    reversed_share,
    sliding_apart,
)
from fretfe.evaluate.friction_behind import FrictionBehind
from fretfe.evaluate.growth import FindGrowth, zone_growth
from fretfe.evaluate.increments import ContactSteps
from fretfe.evaluate.layers import LayerAtEdge
from fretfe.evaluate.load_path import load_path
from fretfe.evaluate.loaded import decisive_state
from fretfe.evaluate.numerics import most_loaded
from fretfe.evaluate.seen_slip import SeenEdge
from fretfe.evaluate.slip import FindBorder, cycle_states, half_cycles, last_state, zones_of
from fretfe.evaluate.verdicts import FLANK
from fretfe.faults import Fault, guarded
from fretfe.history.solution import Factor
from fretfe.reason import Kind, Reason


@dataclass(frozen=True)
class MovedEdge:
    """K_N of an edge by its movement between two loads; NaN where it is not known.

    Attributes:
        k_n: 2 dK_I/da; needs no assumption about the shape of the pressure. Exact for a small step
            (central difference).
        spread: half the width of an interval that is meant to hold it with 95 %.
        reason: why it is not known, in words, of solids; empty where it is.
        stiffening: in the plane (d2P/da2)/(dP/da) = d ln K_N/da + 1/(2a), by
            K_N = (1/pi) sqrt(2/a) dP/da.
        stiffening_spread: as `spread`, by the bars of K_N at both loads.
        state: around which the loads were changed.
    """

    k_n: float = math.nan
    spread: float = math.nan
    reason: str = ""
    stiffening: float = math.nan
    stiffening_spread: float = 0.0
    state: int = -1


@dataclass(frozen=True, kw_only=True)
class EdgeData(ABC):
    """Edges that are evaluated together, and all that their n stations are made of.

    In the plane they are the two of a contact, of solids those of a front.

    Attributes:
        steps: of the contact.
        fits: (n,) position and K_N.
        factors: of the increments.
        frictions: (n,) coefficient (T,) in the step that ends at each state.
        half_widths: (n,) half of the width of the contact, as last known.
        pressed: (n,) whether P alone drives each of them.
        last: last state of the evaluated cycle, or of all.
        force: (T,) P of the contact.
        lengths: (n,) reference lengths of unlike bodies, at which K_N and factors are; None between
            similar ones, and where they are still at the length 1.
    """

    steps: ContactSteps
    fits: Sequence[EdgeFit]
    factors: FactorHistories
    frictions: Sequence[Array]
    half_widths: Array
    pressed: Sequence[bool]
    last: int
    force: Array
    lengths: Array | None = field(default=None)

    @abstractmethod
    def front(self, number: int) -> tuple[str, int]:
        """Front of an edge, and number of the edge along it."""

    @abstractmethod
    def label(self, number: int) -> str:
        """An edge in words, for messages."""

    @abstractmethod
    def place(self, number: int, state: int) -> tuple[Array, Frame]:
        """Point (3,) and frame of the station in a state."""

    @abstractmethod
    def size(self, number: int) -> float:
        """Length of an element at an edge."""

    def closed(self, number: int) -> bool:
        """True if the front of an edge closes around the contact."""
        return False

    @abstractmethod
    def friction_behind(self, number: int) -> FrictionBehind:
        """Coefficient behind an edge in the state `last`."""

    @abstractmethod
    def moved(self, number: int) -> MovedEdge:
        """K_N by the movement of an edge."""

    @abstractmethod
    def unresolved(self, number: int, direction: Array) -> list[float]:
        """Errors of the range along a direction (2,) by the elements."""

    def beside(self, number: int, along: Array, states: Indices) -> float:
        """Range of a factor (T,) over states that may lie in others, in which there is no edge."""
        return 0.0

    @abstractmethod
    def border(self, number: int, position: Array, outer: Bools, growth: FindGrowth) -> FindBorder:
        """Slip zones by the slip of the nodes.

        Args:
            number: of the edge.
            position: (T,) of it.
            outer: (T,) whether the slip in the step to each state counts.
            growth: gives the growth of the zone of a half cycle.
        """

    @abstractmethod
    def seen(self, number: int, direction: Array) -> tuple[Array, Array]:
        """(T,) largest slip of nodes in the step to a state, and how far from the edge it reaches.

        Along a direction (2,), on the way from the edge to the middle.
        """

    @abstractmethod
    def slid(self, number: int, direction: Array) -> Array:
        """(T,) way in which all of the contact slips in the step to a state, or 0.

        1 where its shear next to the edge has a part along a direction (2,), -1 where against it.
        """

    @abstractmethod
    def shear_share(
        self, number: int, state: int, zone: SlipZone, line: Array, begin: float
    ) -> float:
        """Mean shear along a line over that of f p, from a distance from the edge to the middle.

        Args:
            number: of the edge.
            state: of the tractions.
            zone: with whose friction.
            line: (2,) by `inward` and `along`.
            begin: the distance.
        """

    @abstractmethod
    def completed(self, number: int, station: Station) -> Station:
        """The station with what only the plane, or only solids, know of it."""

    def unknown(self, number: int, fault: Fault) -> Station:
        """The station of which nothing is known, since fretfe failed."""
        return unknown_station(
            *self.front(number), len(self.steps.touching), Reason(Kind.FAULT, words=fault.reason)
        )

    def layer(self, number: int) -> LayerAtEdge:
        """The layer of the contact at an edge."""
        across, along = self.steps.layer
        half_width = float(self.half_widths[number]) if across else 1.0
        return LayerAtEdge(across / half_width, along / half_width, across / self.size(number))

    def moved_inward(self, number: int) -> Array | float:
        """(T,) lengths by which fits of roots may find an edge that a layer rounds off inward.

        As far as that on half-planes, .05 of the half-width.
        """
        half_width = float(np.nan_to_num(self.half_widths[number]))
        return min(float(self.steps.layer[0]), 0.05 * half_width)

    @property
    def cycle(self) -> Indices:
        """States of the evaluated cycle."""
        return cycle_states(self.steps.solution.cycle)

    def ranged(self, along: Array) -> Indices:
        """States over which a factor (T,) has its range: also those beside the cycle if known."""
        swing = cycle_states(self.steps.swing)
        return swing if np.isfinite(along[swing]).all() else self.cycle

    @cached_property
    def path_of(self) -> FindPath:
        """Gives the loads between the steps from a state to another, unless straight lines."""
        return cache(partial(load_path, self.steps.solution.values, self.steps.solution.between))

    def stations(self, told: float | None) -> tuple[Station, ...]:
        """The stations, of unlike bodies at the lengths of their predicted slip zones or another.

        Args:
            told: the other length; None without.
        """
        if not self.steps.dundurs:
            return self._evaluated()
        zones = self._reference_lengths()
        stations = self.at(zones, zones)._evaluated()
        if told is None:
            return stations
        # Formulas for slip zones need the factors at their own lengths.
        others = self.at(np.full_like(zones, told), zones)._evaluated()
        return tuple(
            replace(other, slip_zones=station.slip_zones)
            for other, station in zip(others, stations, strict=True)
        )

    def _reference_lengths(self) -> Array:
        """(n,) lengths of the slip zones that the edges predict."""
        factors = self.factors.ways.mean(axis=0)
        edges = zip(self.fits, factors, self.frictions, self.half_widths, self.pressed, strict=True)
        beta, cycle = self.steps.dundurs, self.cycle
        return np.array(
            [
                reference_length(beta, fit, own, friction, float(half_width), cycle, pressed)
                for fit, own, friction, half_width, pressed in edges
            ]
        )

    def at(self, lengths: Array, zones: Array) -> EdgeData:
        """The same of unlike bodies at reference lengths (n,), with slip zones (n,)."""
        beta, factors = self.steps.dundurs, self.factors.at(self.steps.dundurs, lengths)
        mean, fits = factors.ways.mean(axis=0), []
        for number, (direction, _) in enumerate(factors.directions(self.cycle)):
            share = reversed_share(along_line(mean[number], direction), self.cycle)
            sliding = sliding_apart(beta, self.frictions[number].max(), direction)
            elements = share * zones[number] / self.size(number)
            fits.append(self.fits[number].at(lengths[number], elements, sliding))
        return replace(self, fits=tuple(fits), factors=factors, lengths=lengths)

    def _evaluated(self) -> tuple[Station, ...]:
        """All stations; of one at which fretfe fails hardly anything is known."""
        return tuple(
            guarded(self.label(each), partial(self.station, each), partial(self.unknown, each))
            for each in range(len(self.fits))
        )

    def station(self, number: int) -> Station:
        """All that is known of a station."""
        beta, friction = self.steps.dundurs, self.frictions[number]
        cycle, moved = self.cycle, self.moved(number)
        history = self._history(number, moved)
        vectors = np.column_stack([history.k_t, history.k_s])
        direction, turning = main_direction(vectors, cycle)
        loads = self._loads(number, history, vectors @ direction, direction)
        history = replace(history, slid=self.slid(number, direction), **vars(loads))
        along = replace(history, k_t=vectors @ direction)
        states = self.ranged(along.k_t)
        decisive = decisive_state(self.force, along.k_t, cycle, self.steps.solution.ends)
        history = replace(history, decisive=decisive)
        swing = cycle_range(along.k_t, states)
        last, end = last_state(cycle, along), len(along.k_t) - 1
        remember = partial(
            EdgeMemory.of,
            along,
            friction,
            stiffening=math.nan if beta else moved.stiffening,
            half_width=float(self.half_widths[number]),
            exact=bool(self.factors.exact),
            path=self.path_of,
        )
        memory = remember(last)
        whole = memory if end == last else remember(end)
        cycles = count_cycles(cycle, friction, along, memory, self.steps.whole.loads.returns)
        unresolved = self.unresolved(number, direction)
        path = self.path_of(self.steps.solution.cycle)
        spread = self.factors.range_spread(number, direction, unresolved, states, path)
        beside = self.beside(number, along.k_t, states)
        spread = replace(spread, layer=self.layer(number).range_error * swing, beside=beside)
        point, frame = self.place(number, history.decisive)
        fits, fitted = self.factors.fitted, math.nan
        if fits is not None:
            fitted = cycle_range(along_line(fits[number], direction), states)
        exponents = np.broadcast_to(self.fits[number].exponent, history.k_n.shape)
        found = Station(
            **vars(history),
            point=point,
            frame=frame,
            size=self.size(number),
            k_n_moved=moved.k_n,
            k_n_moved_spread=moved.spread,
            k_n_moved_reason=moved.reason,
            stiffening=moved.stiffening,
            stiffening_spread=moved.stiffening_spread,
            k_t_range=cycle_range(history.k_t, states),
            k_s_range=cycle_range(history.k_s, states),
            k_range=swing,
            k_angle=float(np.degrees(np.arctan2(direction[1], direction[0]))),
            turning=turning,
            k_range_spread=spread.total,
            k_range_parts=spread,
            k_t_range_fitted=fitted,
            k_i_range=cycle_range(history.k_i, states),
            reference_length=math.nan if self.lengths is None else float(self.lengths[number]),
            exponent=float(exponents[history.decisive]),
            oscillation=oscillation(beta),
            # Pressure is coupled with shear across the front alone.
            coupling=abs(beta * float(direction[0])) * float(friction.max()),
            friction=_acting(friction, history.decisive),
            **self._largest(memory, whole),
            cycles=cycles,
            slip_zones=self._zones(number, memory, cycles, direction),
        )
        return without_formulas(self.completed(number, found))

    def _history(self, number: int, moved: MovedEdge) -> StationHistory:
        """Position and factors; without displacements along z K_S is zero."""
        fit, cycle = self.fits[number], self.cycle
        factors = self.factors.ways[:, number].mean(axis=0)
        *_, k_s = np.pad(factors, ((0, 0), (0, 3 - factors.shape[1]))).T
        front, along = self.front(number)
        spread, at = fit.spread_k_n.copy(), moved.state
        # Where fits disagree, all of them may be wrong, but K_N by the movement does not use them.
        if spread[at] > LARGEST_SPREAD * fit.k_n[at] and math.isfinite(moved.k_n):
            spread[at] = max(spread[at], abs(fit.k_n[at] - moved.k_n))
        around = moved.k_n, moved.spread, moved.state
        k_n, spread = self.layer(number).k_n(fit.k_n, spread, around, self.force)
        unknown = np.full(len(k_n), math.nan)
        return StationHistory(
            front=front,
            number=along,
            position=fit.position,
            position_spread=np.hypot(fit.spread_position, self.moved_inward(number)),
            k_n=k_n,
            k_n_spread=spread,
            k_t=factors[:, Factor.K_T],
            k_s=k_s,
            k_i=factors[:, Factor.K_I],
            hold=unknown,
            shear=unknown,
            unit=unknown,
            slid=unknown,
            friction_behind=self.friction_behind(number),
            last=self.last,
            first=int(cycle[0]) if len(cycle) else -1,
        )

    def _loads(
        self, number: int, history: StationHistory, along: Array, direction: Array
    ) -> EdgeLoads:
        """Loads of an edge, with its K (T,) along a direction (2,)."""
        width = float(self.half_widths[number])
        moved = history.inward * (history.position - history.position[self.last])
        # That of a cylinder, or a sphere, whose contact is as wide as this one.
        least = history.k_n * (width - np.nan_to_num(moved)) / (6 if self.closed(number) else 4)
        if self.steps.dundurs:
            most = 4 * float(np.nanmax(least, initial=0.0))
            return unlike_loads(history.k_i, along, self.steps.touching, most)
        units, drivers = self.factors.units[:, number], self.steps.solution.driver_values
        friction, touching = self.steps.friction, self.steps.touching
        found = edge_loads(units, drivers, friction, self.force, direction, self.last)
        found = returned(found, drivers, friction & touching, self.steps.cycles)
        if self.factors.exact:
            return without_traces(found, exact=True)
        # While a contact slides its edge moves by what slides: increments of full stick miss that.
        short = np.where(np.isfinite(least), least / found.unit - found.hold, 0.0)
        lift = max(float(short[most_loaded(self.force, np.arange(self.last + 1))]), 0.0)
        hold = np.where(touching, found.hold + lift, found.hold)
        return without_traces(replace(found, hold=hold), exact=False)

    def _largest(self, memory: EdgeMemory | None, whole: EdgeMemory | None) -> dict[str, Any]:
        """Largest half cycles of the evaluated cycle, and of the whole history."""
        found: dict[str, Any] = {}
        if memory is not None and len(self.cycle) and not self.steps.dundurs:
            fine = memory.fine
            first = int(np.searchsorted(fine.times, self.cycle[0]))
            if (largest := fine.largest(first)) is not None:
                size = found["equivalent_range"] = fine.equivalent_range(largest)
                misheld = fine.misheld(largest), fine.doubt(largest) * size
                found["equivalent_misheld"] = math.hypot(*misheld)
                found["equivalent_end"] = math.ceil(fine.times[largest.end])
            elif not any(each.turn > first for each in fine.half_cycles):
                found["equivalent_range"] = 0.0
        if whole is None or not whole.sure:
            return found
        whole = whole if self.steps.dundurs else whole.fine
        largest = whole.largest()
        if self.steps.dundurs and largest and not whole.station.at_rest(largest.start, largest.end):
            return found  # P makes slip between unlike bodies, too
        if largest is not None:
            found["largest_start"] = math.floor(whole.times[largest.start])
            found["largest_end"] = math.ceil(whole.times[largest.end])
            found["largest_range"] = whole.equivalent_range(largest)
            found["largest_slip"] = math.nan if self.steps.dundurs else largest.length
        return found

    def _zones(
        self, number: int, memory: EdgeMemory | None, cycles: CountedCycles, direction: Array
    ) -> tuple[SlipZone, ...]:
        """Slip zones, predicted with K along the direction in which it varies most."""
        if memory is None or not self.steps.known[self.cycle].all():
            return ()
        alone, irregular = self.pressed[number] and self.steps.dundurs != 0, cycles.irregular
        if self.steps.dundurs:
            place, seen = memory.station.position, self.seen(number, direction)
            find = cache(self.border(number, place, memory.outer(()), lambda *_: None))
            width, size = float(self.half_widths[number]), self.size(number)
            memory = SeenEdge.by(memory, width, *seen, find, size)
        halves = half_cycles(self.cycle, memory, irregular, alone)
        zones = [
            self.with_shear(number, zone, direction)
            for part in ([[half] for half in halves] if irregular else [halves])
            for zone in self._zones_of(number, memory, part, irregular)
        ]
        return tuple(sorted(zones, key=lambda each: each.end))

    def _zones_of(
        self, number: int, memory: EdgeMemory, halves: Sequence[HalfCycle], irregular: bool
    ) -> tuple[SlipZone, ...]:
        """Those of some half cycles; under irregular loads of one, without the loops in it."""
        if isinstance(memory, SeenEdge):
            border, pressed = memory.border, self.pressed[number]
            return zones_of(self.cycle, memory, halves, border, pressed, unlike=True)
        outer = memory.outer(halves if irregular else ())
        growth = cache(partial(zone_growth, memory, outer=outer))
        find = self.border(number, memory.station.position, outer, growth)
        return zones_of(self.cycle, memory, halves, find)

    def with_shear(self, number: int, zone: SlipZone, direction: Array) -> SlipZone:
        """A slip zone with the share of f p that acts across (K_T, K_S) and along it.

        That across it between bodies that move along the front; that along it if the mesh does not
        resolve the zone.
        """
        predicted = max(float(np.nan_to_num(zone.prediction)), 0.0)
        if self.factors.ways.shape[-1] > Factor.K_S:
            normal = np.array([-direction[1], direction[0]])
            across = self.shear_share(number, zone.start, zone, normal, predicted)
            zone = replace(zone, across=across)
        if zone.resolved or zone.gross:
            return zone
        flank = self.shear_share(number, zone.end, zone, direction, FLANK * predicted)
        return replace(zone, flank=flank)


def _acting(friction: Array, state: int) -> float:
    """Coefficient in a state, after pressing without friction that of the last state with it."""
    acting = friction[friction > 0]
    return float(friction[state] or (acting[-1] if len(acting) else 0.0))
