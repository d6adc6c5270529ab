# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a plane contact: its edges, and what half-planes would need for their factors.

A patch that exists in some of the states only has a history in each interval of contact by itself.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.analytic.edges import (
    effective_bulk_tension,
    oscillation,
    shear_force_from_factors,
)
from fretfe.evaluate.contacts import (
    CountedCycles,
    Frame,
    Front,
    RangeSpread,
    SlipZone,
    Station,
    StationHistory,
    unknown_station,
    without_formulas,
)
from fretfe.evaluate.cycles import count_cycles, worst_cycle
from fretfe.evaluate.factors import (
    K_T_LENGTH,
    FactorHistories,
    LoadPath,
    UnitFactors,
    add_up,
    along_line,
    cycle_range,
    edge_movement,
    factors_at,
    load_path,
    one_sided_share,
    pressed_on,
    range_spreads,
    reference_length,
    reversed_share,
    sliding_apart,
    uneven_share,
    with_moved,
    within_known,
)
from fretfe.evaluate.growth import Growth, zone_growth
from fretfe.evaluate.numerics import count_up, last_known
from fretfe.evaluate.plane.edge_fits import edge_fits
from fretfe.evaluate.plane.lacks import with_lack
from fretfe.evaluate.plane.pressure_fit import EdgeFit
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront, nearest_front
from fretfe.evaluate.plane.slip import slip_border_of
from fretfe.evaluate.resultants import plane_resultants
from fretfe.evaluate.slip import cycle_states, in_cycle, slip_in_steps, slip_zones
from fretfe.evaluate.verdicts import FLANK
from fretfe.evaluate.withheld import failed
from fretfe.faults import Fault, guarded
from fretfe.history.solution import OPEN, ContactHistory, Factor, Solution
from fretfe.history.state_array import blocks

# Degrees from inward beyond which the range of (K_T, K_S) has next to no K_T to be compared.
NEARLY_ALONG_Z = 89.0
Cycle = tuple[int, int] | None
# From the states of an interval of contact, and the cycle as counted in it, to (states, ...)
# histories.
CountInterval = Callable[[slice, Cycle], Array]
# From solution, contact and positions (stations, T) along the arc.
FindUnits = Callable[[Solution, ContactHistory, Array], UnitFactors]
# Linear elements are too stiff: K_N was 1.6 % (cylinder) to 2.8 % (flat with rounded ends) high
# with them where elements grow by a quarter of the distance from the contact, however fine the mesh
# at the edges, and up to 6 % where they grow by .45.
LINEAR_ELEMENTS = 0.06
LINEAR_GROWTH = 0.45
# Elements at the edge within which sizes behind it tell no growth.
BEHIND = 3.0


def evaluate_plane(
    solution: Solution, contact: ContactHistory, find_units: FindUnits, told: float | None
) -> dict[str, Any]:
    """Edges, resultants and friction work of a plane contact, by the names of `Contact`.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        find_units: gives the singular factors for a unit of each driver.
        told: reference length of factors between unlike bodies; None for the predicted slip zones.
    """
    fits = edge_fits(contact, solution.source)
    positions = np.array([fit.position for fit in fits])
    centre, half_width = positions.mean(axis=0), (positions[1] - positions[0]) / 2
    histories = _factor_histories(solution, contact, positions, find_units)
    frictions = [contact.edge_friction(each) for each in positions]
    path = load_path(solution.values, solution.between, solution.cycle)
    # As if the bodies were similar, at the length where shear adds nothing to K_I.
    whole = histories.ways.mean(axis=0)
    cycle = cycle_states(solution.cycle)
    a, own = last_known(half_width, cycle), whole
    if contact.surface.dundurs:
        whole = factors_at(whole, contact.surface.dundurs, 2 * a / K_T_LENGTH)
        whole[..., : Factor.K_S] /= np.cosh(np.pi * oscillation(contact.surface.dundurs))
    pressed = tuple(
        pressed_on(each, contact.surface.dundurs, 2 * a, friction, cycle)
        for each, friction in zip(own, frictions, strict=True)
    )
    works = _friction_work(solution, contact), _work_spread(solution, contact)
    edges = _Edges(solution, contact, centre, fits, histories, path, pressed, frictions, works)
    if contact.surface.dundurs:
        zones = np.array(
            [
                reference_length(contact, fit, factors, friction, a, cycle, alone)
                for fit, factors, friction, alone in zip(fits, own, frictions, pressed, strict=True)
            ]
        )
        stations = edges.at(zones, zones).stations()
        if told is not None:
            # Formulas for slip zones need the factors at their own lengths.
            others = edges.at(np.full_like(zones, told), zones).stations()
            stations = [
                replace(other, slip_zones=station.slip_zones)
                for other, station in zip(others, stations, strict=True)
            ]
    else:
        stations = edges.stations()
    stations = [with_lack(solution, contact, each) for each in stations]
    fronts = [Front(each.front, (each,)) for each in stations]
    k_t = whole[..., Factor.K_T]

    def tension(interval: slice, cycle: Cycle) -> Array:
        return tension_history(k_t[:, interval], half_width[interval], cycle)

    return {
        **plane_resultants(contact, centre),
        "fronts": tuple(fronts),
        "half_width": half_width,
        "effective_tension": by_interval(contact, solution.cycle, tension),
        "shear_mismatch": shear_mismatch(
            k_t, half_width, full_stick_shear_force(solution, contact), solution.cycle
        )
        if all(abs(each.k_angle) < NEARLY_ALONG_Z for each in stations)
        else np.nan,
        "dissipation": float(works[0].sum()),
        "dissipation_spread": float(works[1].sum()),
    }


def tension_history(k_t: Array, half_width: Array, cycle: tuple[int, int] | None) -> Array:
    """(T,) effective bulk tension, counted like K_T.

    Args:
        k_t: (2, T) at the left and the right front.
        half_width: (T,), NaN without contact.
        cycle: its first and last state, or None.
    """
    steps, a = _steps(k_t, half_width)
    return count_up(effective_bulk_tension(steps[0], steps[1], a), cycle)


def shear_mismatch(
    k_t: Array, half_width: Array, shear_force: Array, cycle: tuple[int, int] | None
) -> float:
    """(range of Q that half-planes need for K_T at the two fronts)/(range of Q) - 1; NaN if none.

    Args:
        k_t: (2, T) at the left and the right front.
        half_width: (T,), NaN without contact.
        shear_force: (T,) Q of full stick.
        cycle: its first and last state, or None.
    """
    if cycle is None:
        return np.nan
    states = slice(cycle[0], cycle[1] + 1)
    if np.ptp(shear_force[states]) <= 1e-9 * np.abs(shear_force).max():
        return np.nan
    steps, a = _steps(k_t, half_width)
    needed = count_up(shear_force_from_factors(steps[0], steps[1], a), cycle)
    return float(np.ptp(needed[states]) / np.ptp(shear_force[states]) - 1)


def full_stick_shear_force(solution: Solution, contact: ContactHistory) -> Array:
    """(T,) Q of the increments of full stick, added up over the steps like K_T.

    Where slip changes how the loads divide between several contacts, this is not the Q of the
    contact itself, but the one that belongs to K_T. Without increments it is the Q of the contact.
    """
    increments, weights = contact.full_stick, contact.surface.weights
    if not len(increments.fields):
        parts = blocks(len(contact.traction), contact.traction[0].size)
        return np.concatenate([contact.traction[part, :, 1] @ weights for part in parts])
    # Area -1, the last entry, is that of states without contact.
    parts = blocks(len(increments.fields), increments.fields[0].size)
    units = np.concatenate(
        [np.einsum("n,unj->uj", weights, increments.fields[part, :, 1]) for part in parts]
    )
    units = np.vstack([units, np.zeros(units.shape[1])])[increments.area]
    known = increments.area >= 0
    pairs = known[1:].astype(float) + known[:-1]
    mean = (units[1:] + units[:-1]) / np.maximum(pairs, 1.0)[:, None]
    steps = np.einsum("tj,tj->t", mean, np.diff(solution.driver_values, axis=0))
    return count_up(steps * contact.friction.acts[1:], solution.cycle)


def _steps(k_t: Array, half_width: Array) -> tuple[Array, Array]:
    """(2, T-1) increments of K_T, and (T-1,) half-width in the middle of each step."""
    a = (half_width[1:] + half_width[:-1]) / 2
    # From no contact to the first one: that of the first one.
    a = np.where(np.isfinite(a), a, half_width[1:])
    return np.diff(k_t, axis=1), np.where(np.isfinite(a), a, 1.0)


def by_interval(contact: ContactHistory, cycle: Cycle, count: CountInterval) -> Array:
    """Return (T, ...) histories that begin anew with each interval of contact; NaN between them.

    Args:
        contact: one patch, which exists in a state at least.
        cycle: first and last state of the evaluated cycle, or None.
        count: gives the histories of one interval; it gets no cycle that is not all in it.
    """
    found = {}
    for first, last in contact.intervals:
        inside = cycle is not None and first <= cycle[0] and cycle[1] <= last
        own = (cycle[0] - first, cycle[1] - first) if cycle is not None and inside else None
        found[first] = count(slice(first, last + 1), own)
    shapes = [each.shape[1:] for each in found.values()]
    histories = np.full((len(contact.traction), *shapes[0]), np.nan)
    for first, each in found.items():
        histories[first : first + len(each)] = each
    return histories


def in_evaluated_interval(
    contact: ContactHistory, cycle: Cycle, history: StationHistory
) -> StationHistory:
    """Return a history without what is outside the interval of contact of the evaluated cycle.

    Without a cycle that is the last one; if no interval holds all of the cycle nothing is left.
    """
    first, last = contact.intervals[-1]
    states = np.arange(len(contact.traction))
    known = (states >= first) & (states <= last)
    if cycle is not None:
        known &= first <= cycle[0] < cycle[1] <= last
    return replace(
        history,
        position=_only(history.position, known),
        position_spread=_only(history.position_spread, known),
        k_n=_only(history.k_n, known),
        k_n_spread=_only(history.k_n_spread, known),
        k_t=_only(history.k_t, known),
        k_s=_only(history.k_s, known),
        k_i=_only(history.k_i, known),
    )


def _only(values: Array, known: Bools) -> Array:
    return np.where(known, values, np.nan)


def _factor_histories(
    solution: Solution, contact: ContactHistory, positions: Array, find_units: FindUnits
) -> FactorHistories:
    units = find_units(solution, contact, positions)
    touching = contact.pressed_nodes > 0

    def history(each: Array) -> Array:
        def count(interval: slice, cycle: tuple[int, int] | None) -> Array:
            drivers, friction = solution.driver_values[interval], contact.friction.acts[interval]
            found = add_up(
                each[interval],
                drivers,
                friction,
                touching[interval],
                cycle,
                unlike=contact.surface.dundurs != 0,
            )
            return found.swapaxes(0, 1)

        return by_interval(contact, solution.cycle, count).swapaxes(0, 1)

    fitted, drivers, cycle = units.fitted, solution.driver_values, solution.cycle
    ways, shares = [], None
    for each in units.main:
        filled = within_known(each, solution.step)
        ways.append(history(filled))
        # What steps may be wrong by is the same in all ways, to a part of itself.
        shares = shares or (
            one_sided_share(each, filled, drivers, cycle),
            uneven_share(each, drivers, contact.friction.acts, cycle),
        )
    assert shares is not None
    return FactorHistories(
        ways=np.array(ways),
        fitted=None if fitted is None else history(within_known(fitted, solution.step)),
        exact=units.exact,
        one_sided=shares[0],
        uneven=shares[1],
    )


@dataclass(frozen=True)
class _Edges:
    """Numbers that the stations of both edges of a contact are made of.

    Attributes:
        solution: the solved history.
        contact: the contact.
        centre: (T,) of it.
        fits: of the pressure at both edges.
        histories: of the singular factors of both edges.
        path: loads of the cycle between its steps, unless they are straight lines.
        pressed: (2,) whether P alone drives each edge.
        frictions: (2, T) coefficient at each edge.
        works: (N,) friction work of each node, and its error bar.
        lengths: (2,) reference lengths of both edges between unlike bodies, else NaN.
    """

    solution: Solution
    contact: ContactHistory
    centre: Array
    fits: tuple[EdgeFit, ...]
    histories: FactorHistories
    path: LoadPath | None
    pressed: tuple[bool, ...]
    frictions: Sequence[Array]
    works: tuple[Array, Array]
    lengths: tuple[float, ...] = (np.nan,) * len(PLANE_FRONTS)

    def at(self, lengths: Array, zones: Array) -> _Edges:
        """The same of unlike bodies at reference lengths (2,), with slip zones (2,)."""
        cycle = cycle_states(self.solution.cycle)
        histories = self.histories.at(self.contact.surface.dundurs, lengths)
        fits, factors = [], histories.ways.mean(axis=0)
        for number, (direction, _) in enumerate(histories.directions(cycle)):
            fit = self.fits[number]
            size = _element_size(self.contact.surface.arc, last_known(fit.position, cycle))
            share = reversed_share(along_line(factors[number], direction), cycle)
            friction = self.frictions[number].max()
            sliding = sliding_apart(self.contact.surface.dundurs, friction, direction)
            fits.append(fit.at(lengths[number], share * zones[number] / size, sliding))
        return replace(self, fits=tuple(fits), histories=histories, lengths=tuple(lengths.tolist()))

    def stations(self) -> list[Station]:
        """The stations of both edges."""
        cycle, arc = cycle_states(self.solution.cycle), self.contact.surface.arc
        spreads = range_spreads(self.histories, self.fits, arc, cycle, self.path)
        found = zip(PLANE_FRONTS, self.histories.directions(cycle), spreads, strict=True)
        return [
            guarded(
                f"contact {self.contact.name}, {front.name} edge",
                partial(self._station, front, *line, spread),
                partial(self._unknown, front),
            )
            for front, line, spread in found
        ]

    def _unknown(self, front: PlaneFront, fault: Fault) -> Station:
        return unknown_station(front.name, 0, len(self.solution.times), failed(fault))

    def _station(
        self, front: PlaneFront, direction: Array, turning: float, spread: RangeSpread
    ) -> Station:
        """The station of an edge, with the error bar of its range.

        Args:
            front: whose station it is.
            direction: (2,) in which (K_T, K_S) varies most.
            turning: range across it over that along it.
            spread: error bar of the range along it.
        """
        fit = self.fits[front.number]
        contact, cycle = self.contact, cycle_states(self.solution.cycle)
        exponents = np.broadcast_to(fit.exponent, fit.k_n.shape)
        half_width = abs(float((self.centre - fit.position)[-1]))
        movement = edge_movement(contact, front, half_width, float(exponents[-1]))
        linear = self.solution.degree == 1 and not self.histories.exact
        hidden = _linear_error(front, self.contact.surface.arc, fit.position) if linear else 0.0
        bars = np.hypot(fit.spread_k_n, hidden * fit.k_n)
        k_n_spread = with_moved(fit.k_n, bars, movement.k_n)
        factors = self.histories.ways[:, front.number].mean(axis=0)
        history = front.history(fit.position, fit.spread_position, fit.k_n, k_n_spread, factors)
        history = in_cycle(cycle, history)
        along = replace(history, k_t=np.column_stack([history.k_t, history.k_s]) @ direction)
        evaluated = in_evaluated_interval(contact, self.solution.cycle, along)
        friction = self.frictions[front.number]
        cycles = count_cycles(cycle, friction, evaluated, self.solution.loads.returns)
        point, frame = _place(contact, front, fit.position)
        angle = float(np.degrees(np.arctan2(direction[1], direction[0])))
        here = nearest_front(contact.surface.arc, last_known(self.centre, cycle)) == front.number
        fitted = self.histories.fitted
        found = Station(
            **vars(history),
            frame=frame,
            point=point,
            size=_element_size(contact.surface.arc, float(fit.position[history.last])),
            k_n_moved=movement.k_n,
            k_n_moved_spread=movement.k_n_spread,
            stiffening=movement.stiffening,
            k_t_range=cycle_range(history.k_t, cycle),
            k_s_range=cycle_range(history.k_s, cycle),
            k_range=cycle_range(along.k_t, cycle),
            k_angle=angle,
            turning=turning,
            k_range_spread=spread.total,
            k_range_parts=spread,
            k_t_range_fitted=(
                np.nan
                if fitted is None
                else cycle_range(along_line(fitted[front.number], direction), cycle)
            ),
            k_i_range=cycle_range(history.k_i, cycle),
            reference_length=self.lengths[front.number],
            exponent=float(exponents[history.last]),
            oscillation=oscillation(contact.surface.dundurs),
            coupling=abs(contact.surface.dundurs) * float(friction.max()),
            friction=float(friction[history.last]),
            cycles=cycles,
            slip_zones=self._zones(front, evaluated, angle, cycles),
            dissipation=float(self.works[0][here].sum()),
            dissipation_spread=float(self.works[1][here].sum()),
        )
        return without_formulas(found)

    def _zones(
        self,
        front: PlaneFront,
        evaluated: StationHistory,
        angle: float,
        cycles: CountedCycles,
    ) -> tuple[SlipZone, ...]:
        contact, cycle = self.contact, cycle_states(self.solution.cycle)
        friction = self.frictions[front.number]
        worst = worst_cycle(cycles, cycle, friction, evaluated)
        outer = worst.outer if worst else np.ones(len(self.solution.times), dtype=bool)
        degree = 2 if self.histories.exact else self.solution.degree
        position = evaluated.position

        def growth(start: int, end: int) -> Growth | None:
            # Between unlike bodies shear moves K_I and pressure K_T: what the growth leaves out.
            if contact.surface.dundurs:
                return None
            return zone_growth(evaluated, friction, start, end, outer)

        least = np.where(outer, self.solution.least_slip, np.inf)
        border = slip_border_of(contact, front, position, least, degree, growth)
        pressed = self.pressed[front.number]
        zones = slip_zones(
            cycle,
            friction,
            evaluated,
            border,
            self.path,
            worst=worst,
            pressed=pressed,
            unlike=contact.surface.dundurs != 0,
        )
        return tuple(
            with_shear(contact, front, position, self.centre, zone, angle) for zone in zones
        )


def _linear_error(front: PlaneFront, arc: Array, position: Array) -> float:
    """Relative error of K_N by what linear elements of the bodies do to p, which fits cannot see.

    Elements of the bodies grow as those of the surface do behind the contact.

    Args:
        front: of the edge.
        arc: (N,) nodes of the surface.
        position: (T,) of the edge.
    """
    known = position[np.isfinite(position)]
    if not len(known):
        return LINEAR_ELEMENTS
    sizes, middles = front.from_front(np.diff(arc)), (arc[1:] + arc[:-1]) / 2
    distances = np.min(
        [-front.distances(middles, place) for place in (known.min(), known.max())], axis=0
    )
    at_edge = sizes[np.argmin(np.abs(distances))]
    behind = distances > BEHIND * at_edge
    if not behind.any():
        return LINEAR_ELEMENTS
    growth = float(np.max((sizes[behind] - at_edge) / distances[behind]))
    return LINEAR_ELEMENTS * float(np.clip((growth / LINEAR_GROWTH) ** 1.5, 0.4, 1.0))


def _place(contact: ContactHistory, front: PlaneFront, position: Array) -> tuple[Array, Frame]:
    """(3,) point and frame in the last state in which the position (T,) is known."""
    place = last_known(position, np.array([], dtype=np.int64))
    frames = contact.surface.frames[:, :2, :2].reshape(len(contact.surface.arc), -1)
    rows = np.hstack([contact.surface.points, frames]).T
    point, across, tangent = np.reshape(
        [np.interp(place, contact.surface.arc, row) for row in rows], (3, 2)
    )
    return np.append(point, 0.0 * place), front.frame(across, tangent)


def _element_size(arc: Array, place: float) -> float:
    """Length of the element at a place along the arc."""
    return float(np.diff(arc)[max(int(np.searchsorted(arc[1:-1], place)), 0)])


def with_shear(
    contact: ContactHistory,
    front: PlaneFront,
    position: Array,
    centre: Array,
    zone: SlipZone,
    angle: float,
) -> SlipZone:
    """A slip zone with the share of f p behind it that acts across the angle of K and along it.

    That along it if the mesh does not resolve the zone; that across it between bodies that move
    along z. The angle is that of (K_T, K_S), in degrees.
    """
    predicted = max(float(np.nan_to_num(zone.prediction)), 0.0)

    def share(state: int, angle: float, begin: float) -> float:
        traction = contact.mean_traction[state]
        s = front.inward * (contact.surface.arc - position[state])
        middle = front.inward * (centre[state] - position[state])
        behind = (s > begin) & (s < middle) & (traction[:, 0] > 0)
        weights = contact.surface.weights[behind]
        bound = float((contact.friction.at(zone.end, behind) * weights) @ traction[behind, 0])
        shear = traction[behind, 1:] @ front.axis(angle, traction.shape[1] - 1)
        return abs(float(weights @ shear)) / bound if bound > 0 else np.nan

    if contact.slip.shape[2] > 1:
        zone = replace(zone, across=share(zone.start, angle + 90.0, predicted))
    if zone.resolved or zone.gross:
        return zone
    return replace(zone, flank=share(zone.end, angle, FLANK * predicted))


def _friction_work(solution: Solution, contact: ContactHistory) -> Array:
    """(N,) friction work of each node in the evaluated cycle, or in everything without one."""
    count = len(contact.dissipation)
    in_cycle = np.zeros(len(contact.surface.arc))
    first, last = solution.cycle or (-1, count - 1)
    for states in blocks(count, len(contact.surface.arc)):
        begin, end = max(first + 1 - states.start, 0), max(last + 1 - states.start, 0)
        in_cycle += contact.dissipation[states][begin:end].sum(axis=0)
    return in_cycle


def _work_spread(solution: Solution, contact: ContactHistory) -> Array:
    """(N,) error bar of the friction work of each node; of several nodes they add up.

    When in a step a node slips is not known, so that its work lies between those of the smaller and
    of the larger pressure at the ends of the step. The work next to an edge is known to that of its
    outermost node, within whose element the edge is somewhere.
    """
    first, last = solution.cycle or (0, len(contact.dissipation) - 1)
    spread, least = np.zeros(len(contact.surface.arc)), solution.least_slip
    for part in blocks(last - first, contact.traction[0].size):
        begin, end = first + part.start, first + part.stop
        slip = np.linalg.norm(slip_in_steps(contact, begin, end, least), axis=2)
        pressure = np.maximum(contact.mean_traction[begin : end + 1, :, 0], 0.0)
        friction = contact.friction.at(slice(begin + 1, end + 1))
        changes = friction * np.abs(np.diff(pressure, axis=0))
        spread += (changes * slip).sum(axis=0) * contact.surface.weights / 2
        closed = np.asarray(contact.status[begin + 1 : end + 1]) != OPEN
        works = np.asarray(contact.dissipation[begin + 1 : end + 1])
        for front in PLANE_FRONTS:
            outermost = np.argmax(front.from_front(closed), axis=1)[:, None]
            alone = np.take_along_axis(front.from_front(works), outermost, axis=1)[:, 0]
            nodes = front.from_front(np.arange(len(spread)))[outermost[:, 0]]
            np.add.at(spread, nodes, alone)
    return spread
