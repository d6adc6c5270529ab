# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of the fronts of a solid contact: factors, error bars and slip zones of stations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import oscillation
from fretfe.evaluate.contacts import (
    NO_NUMBER,
    CountedCycles,
    Frame,
    Front,
    SlipZone,
    Station,
    StationHistory,
    unknown_station,
    without_formulas,
)
from fretfe.evaluate.cycles import count_cycles, worst_cycle
from fretfe.evaluate.factors import (
    FactorHistories,
    LoadPath,
    add_up,
    along_line,
    cycle_range,
    load_path,
    main_direction,
    one_sided_share,
    pressed_on,
    reference_length,
    reversed_share,
    rotated,
    sliding_apart,
    uneven_share,
    with_moved,
    within_known,
)
from fretfe.evaluate.growth import Growth, zone_growth
from fretfe.evaluate.numerics import last_known
from fretfe.evaluate.resultants import solid_resultants
from fretfe.evaluate.slip import cycle_states, in_cycle, slip_zones
from fretfe.evaluate.space.front_scatter import with_scatter
from fretfe.evaluate.space.fronts import NEAR, FrontTrack, SpaceFront, why_no_fronts
from fretfe.evaluate.space.half_spaces import half_space_ratios
from fretfe.evaluate.space.patches import follow_patches
from fretfe.evaluate.space.pressure_fit import load_growth
from fretfe.evaluate.space.range_spread import range_spread
from fretfe.evaluate.space.sectors import Frames
from fretfe.evaluate.space.slip import SlipBetween, shear_share
from fretfe.evaluate.verdicts import FLANK
from fretfe.evaluate.withheld import TOLD, failed
from fretfe.faults import Fault, guarded
from fretfe.history.solution import ContactHistory, Factor, Solution

# The front of a discrete contact area may lie anywhere in an element: half of it, and some more for
# what its nodes do.
RAGGED = 0.6

NO_LOADS = "there are no two neighbouring loads, or K_I is not defined between these bodies"
NO_FRONT = "the front or K_I is not known at a neighbouring load"
AWAY = "the front of the neighbouring loads is too far from the station"
STANDS = "the front does not move outward with the loads"
POOR = "the front moves too little for elements of this size"
# P adds nothing to K_T between unlike bodies at the length of a strip's width, and at so much less
# within a circle (Mossakovskii 1954: at half of the radius).
WITHIN_CIRCLE = 4.0
# Power of the width with which factors for a unit of a load fall: around a circle, and by whether
# fronts are closed, where they are straight and long.
GROWTH = {True: 1.5, False: 0.5}


@dataclass(frozen=True)
class MovedStation:
    """K_N of a station by the movement of its front; NaN, with a reason, where it is not known.

    Attributes:
        k_n: 2 dK_I/da; needs no assumption about the shape of the pressure.
        spread: half the width of an interval that is meant to hold it with 95 %.
        reason: why it is not known, in words; empty where it is.
    """

    k_n: float
    spread: float
    reason: str


def moved_stations(
    contact: ContactHistory, front: SpaceFront, stations: slice
) -> tuple[MovedStation, ...]:
    """K_N of the n stations of a front by its movement about the last state.

    Args:
        contact: with its neighbouring loads.
        front: in the reference state.
        stations: which of all stations of the contact they are.
    """
    neighbours, count = contact.nearby_loads, len(front.sectors)
    if neighbours is None:
        return (MovedStation(np.nan, np.nan, NO_LOADS),) * count
    fit = front.fits.fit(neighbours.pressure)
    outward, spread = fit.place[0] - fit.place[1], np.linalg.norm(fit.place_spread, axis=0)
    near = np.abs(fit.place).max(axis=0) <= NEAR * front.sizes
    k_i = neighbours.k_i[:, stations]
    # The border of the nodes in contact is ragged at both loads; see `range_spread`.
    ragged = RAGGED * front.sizes / front.depth
    return tuple(_moved(*each) for each in zip(near, outward, spread, k_i.T, ragged, strict=True))


def _moved(near: bool, outward: float, spread: float, k_i: Array, ragged: float) -> MovedStation:
    """One station.

    Args:
        near: whether its front is close to it at both loads.
        outward: how far it moves from the lower to the higher load.
        spread: error bar of that, as if those of both places had nothing to do with each other.
        k_i: (R,) of the difference of the loads, determined in R ways.
        ragged: error of K_I over it by the border of the nodes in contact.
    """

    def unknown(reason: str) -> MovedStation:
        return MovedStation(np.nan, np.nan, reason)

    if not np.isfinite([outward, *k_i]).all():
        return unknown(NO_FRONT)
    if not near:
        return unknown(AWAY)
    mean = float(k_i.mean())
    if not (outward > 0 and mean > 0):
        return unknown(STANDS)
    k_n = 2 * mean / outward
    relative = math.hypot(spread / outward, float(np.ptp(k_i)) / 2 / mean, ragged)
    return unknown(POOR) if relative > NO_NUMBER else MovedStation(k_n, relative * k_n, "")


def evaluate_solids(
    solution: Solution,
    contact: ContactHistory,
    tracks: tuple[FrontTrack, ...] | None,
    told: float | None,
) -> dict[str, Any]:
    """Fronts, resultants and friction work of a contact of solids, by the names of `Contact`.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        tracks: its fronts, followed through the history; None if nobody looked for them.
        told: reference length of factors between unlike bodies; None for the predicted slip zones.
    """
    found = solid_resultants(contact)
    first, last = solution.cycle or (0, len(solution.times) - 1)
    fronts = evaluate_fronts(solution, contact, tracks or (), told)
    patches, owner = follow_patches(solution, contact)
    if patches:
        fronts = tuple(
            replace(front, patch=int(owner[track.front.node]) + 1)
            for front, track in zip(fronts, tracks or (), strict=True)
        )
    missing = tracks is not None and not any(track.state == last for track in tracks)
    return {
        **found,
        "fronts": fronts,
        "lack": why_no_fronts(contact, last) if missing else TOLD,
        "patches": patches,
        "dissipation": float(found["work"][first + 1 : last + 1].sum()),
    }


def evaluate_fronts(
    solution: Solution,
    contact: ContactHistory,
    tracks: tuple[FrontTrack, ...],
    told: float | None = None,
) -> tuple[Front, ...]:
    """Evaluate the fronts of a solid contact, followed through the history.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        tracks: its fronts.
        told: as of `evaluate_solids`.
    """
    slip = SlipBetween(contact, solution.least_slip)
    path = load_path(solution.values, solution.between, solution.cycle)
    fronts, first = [], 0
    for number, track in enumerate(tracks):
        count = len(track.front.sectors)
        own = slice(first, first + count)
        first += count
        histories = _factor_histories(solution, contact, track, own)
        frictions = _frictions(contact, track)
        front = _Front(
            f"front {number + 1}",
            solution,
            contact,
            track,
            histories,
            moved_stations(contact, track.front, own),
            slip,
            path,
            _pressed(solution, contact, track, histories, frictions),
            frictions,
        )
        frames = track.front.frames
        sums = half_space_ratios(solution, contact, track, alone=len(tracks) == 1)
        widths = [sector.half_width for sector in track.front.sectors]
        stations = with_scatter(front.stations_told(told), frames.closed, widths, frames.length)
        fronts.append(Front(front.name, stations, frames.closed, frames.length, sums))
    return tuple(fronts)


def _pressed(
    solution: Solution,
    contact: ContactHistory,
    track: FrontTrack,
    histories: FactorHistories,
    frictions: list[Array],
) -> tuple[bool, ...]:
    """(n,) whether P alone drives each station of a front."""
    front, cycle = track.front, cycle_states(solution.cycle)
    bent = np.clip(front.frames.curvature * front.depth, 0.0, 1.0)
    lengths = 2 * front.depth * WITHIN_CIRCLE**-bent
    stations = zip(histories.ways.mean(axis=0), lengths.tolist(), frictions, strict=True)
    return tuple(
        pressed_on(factors, contact.surface.dundurs, length, friction, cycle)
        for factors, length, friction in stations
    )


def _frictions(contact: ContactHistory, track: FrontTrack) -> list[Array]:
    """(n, T) coefficient at each station of a front."""
    frames = track.front.frames
    places = frames.points + track.fit.place[..., None] * frames.inward
    return [contact.edge_friction(each) for each in places.swapaxes(0, 1)]


def _factor_histories(
    solution: Solution, contact: ContactHistory, track: FrontTrack, stations: slice
) -> FactorHistories:
    """Singular factors of the n stations of a front; NaN without integrals."""
    count, states = len(track.front.sectors), len(solution.times)
    integrals = contact.integrals
    if integrals is None:
        unknown = np.full(count, np.nan)
        nothing = np.full((1, count, states, 3), np.nan)
        return FactorHistories(nothing, None, exact=False, one_sided=unknown, uneven=unknown)
    touching = contact.pressed_nodes > 0
    drivers, friction, cycle = solution.driver_values, contact.friction.acts, solution.cycle
    ways = []
    one_sided, uneven = np.zeros(count), np.zeros(count)
    for way in range(len(integrals.reaches)):
        units = _interpolate(
            track.fit.place,
            integrals.positions[:, stations],
            integrals.factors[:, way, stations],
            track.front.depth,
            contact.surface.dundurs,
            GROWTH[track.front.frames.closed],
        )
        # Each station by itself: where one is unknown others are not.
        alone = [units[:, [row]] for row in range(count)]
        filled = [within_known(each, solution.step) for each in alone]
        unlike = contact.surface.dundurs != 0
        ways.append(
            [add_up(each, drivers, friction, touching, cycle, unlike)[0] for each in filled]
        )
        if way == 0:
            pairs = zip(alone, filled, strict=True)
            one_sided = np.array([one_sided_share(*each, drivers, cycle)[0] for each in pairs])
            uneven = uneven_share(units, drivers, friction, cycle)
    return FactorHistories(np.array(ways), None, exact=False, one_sided=one_sided, uneven=uneven)


def _interpolate(
    places: Array, known: Array, values: Array, depth: Array, dundurs: float, power: float
) -> Array:
    """(T, n, ...) values (S, n, ...) known at places (S, n), at the places (T, n) of all states.

    Factors for a unit of a load fall with some power of the half of the width of the contact.
    Times that power they are taken linear between known places, and constant outside; NaN where the
    place is. Of unlike bodies that is so of K_I and K_T at a length in proportion to that width.

    Args:
        places: inward from the front of the reference state.
        known: likewise.
        values: factors for a unit of each driver.
        depth: (n,) half of the width in the reference state.
        dundurs: beta.
        power: by which they fall.
    """
    result = np.full((len(places), *values.shape[1:]), np.nan)
    for station, (at, x) in enumerate(zip(places.T, known.T, strict=True)):
        found, there = np.isfinite(at), np.isfinite(x)
        if not there.any():
            continue
        order = np.flatnonzero(there)[np.argsort(x[there])]
        width, widths = (_narrowed(depth[station], each) for each in (at[found], x[order]))
        own = rotated(values[order, station], dundurs, widths)
        flat = widths[:, None] ** power * own.reshape(len(order), -1)
        columns = [np.interp(at[found], x[order], column) for column in flat.T]
        factors = np.array(columns).T / width[:, None] ** power
        factors = factors.reshape(-1, *values.shape[2:])
        result[found, station] = rotated(factors, dundurs, 1 / width)
    return result


def _narrowed(depth: float, place: Array) -> Array:
    """Half of the width where the front is some way inward; a tenth of it at least."""
    return np.asarray(np.maximum(depth - place, 0.1 * depth))


@dataclass(frozen=True)
class _Front:
    """One front, and what the numbers of its stations are made of.

    Attributes:
        pressed: (n,) whether P alone drives each station.
        frictions: (n, T) coefficient at each station.
        lengths: (n,) reference lengths between unlike bodies, at which K_N and factors are; None
            between similar ones, and where they are still at the length 1.
    """

    name: str
    solution: Solution
    contact: ContactHistory
    track: FrontTrack
    factors: FactorHistories
    moved: Sequence[MovedStation]
    slip: SlipBetween
    path: LoadPath | None
    pressed: tuple[bool, ...]
    frictions: list[Array]
    lengths: Array | None = None

    def stations_told(self, told: float | None) -> tuple[Station, ...]:
        """The stations, of unlike bodies at the lengths of their predicted slip zones or another.

        Args:
            told: the other length; None without.
        """
        count = len(self.track.front.sectors)
        if not self.contact.surface.dundurs:
            return tuple(self._evaluated(each) for each in range(count))
        zones = self._reference_lengths()
        own = self._at(zones, zones)
        stations = tuple(own._evaluated(each) for each in range(count))
        if told is None:
            return stations
        other = self._at(np.full(count, told), zones)
        # Formulas for slip zones need the factors at their own lengths.
        return tuple(
            replace(other._evaluated(number), slip_zones=station.slip_zones)
            for number, station in enumerate(stations)
        )

    def _reference_lengths(self) -> Array:
        """(n,) lengths of the slip zones that the stations predict."""
        mean, cycle = self.factors.ways.mean(axis=0), cycle_states(self.solution.cycle)
        depths = self.track.front.depth.tolist()
        stations = zip(mean, self.frictions, depths, self.pressed, strict=True)
        return np.array(
            [
                reference_length(
                    self.contact,
                    self.track.fit.of(number),
                    factors,
                    friction,
                    depth,
                    cycle,
                    pressed,
                )
                for number, (factors, friction, depth, pressed) in enumerate(stations)
            ]
        )

    def _at(self, lengths: Array, zones: Array) -> _Front:
        """The same of unlike bodies at reference lengths (n,), with slip zones (n,)."""
        factors = self.factors.at(self.contact.surface.dundurs, lengths)
        cycle = cycle_states(self.solution.cycle)
        directions = [direction for direction, _ in factors.directions(cycle)]
        along = map(along_line, factors.ways.mean(axis=0), directions)
        shares = np.column_stack([reversed_share(each, cycle) for each in along])
        beta, each = self.contact.surface.dundurs, zip(self.frictions, directions, strict=True)
        sliding = np.array([sliding_apart(beta, f.max(), direction) for f, direction in each])
        fit = self.track.fit.at(lengths, shares * zones / self.track.front.sizes, sliding)
        return replace(
            self,
            track=replace(self.track, fit=fit),
            factors=factors,
            lengths=lengths,
        )

    def _evaluated(self, number: int) -> Station:
        """A station, of which nothing but its place is known where fretfe fails."""
        place = f"contact {self.contact.name}, {self.name}, station {number}"
        return guarded(place, partial(self.station, number), partial(self._unknown, number))

    def _unknown(self, number: int, fault: Fault) -> Station:
        frames = self.track.front.frames
        found = unknown_station(self.name, number, len(self.solution.times), failed(fault))
        return replace(found, point=frames.points[number], arc=float(frames.arc[number]))

    def station(self, number: int) -> Station:
        """All that is known of a station."""
        front, fit, moved = self.track.front, self.track.fit, self.moved[number]
        frames, sector = front.frames, front.sectors[number]
        cycle = cycle_states(self.solution.cycle)
        history = self._history(number)
        history = replace(in_cycle(cycle, history), last=self.track.state)
        vectors = np.column_stack([history.k_t, history.k_s])
        direction, turning = main_direction(vectors, cycle)
        along = replace(history, k_t=vectors @ direction)
        spread = range_spread(self.factors, front, fit, number, direction, cycle, self.path)
        friction = self.frictions[number]
        cycles = count_cycles(cycle, friction, along, self.solution.loads.returns)
        length = float(last_known(fit.length[:, number], cycle))
        depth, to_end = float(front.depth[number]), float(frames.to_free_end[number])
        # Shear along the front knows nothing of beta.
        coupled = abs(self.contact.surface.dundurs * float(direction[0]))
        found = Station(
            **vars(history),
            point=frames.points[number],
            frame=Frame(frames.inward[number], frames.along[number], frames.across[number]),
            arc=float(frames.arc[number]),
            curvature=float(frames.curvature[number]),
            to_end=to_end,
            size=sector.size,
            depth=depth,
            length=length,
            # Within a local length of a free end fields are those of a vertex.
            end=not to_end > max(min(depth, length), sector.along_size),
            k_n_moved=moved.k_n,
            k_n_moved_spread=moved.spread,
            k_n_moved_reason=moved.reason,
            k_t_range=cycle_range(history.k_t, cycle),
            k_s_range=cycle_range(history.k_s, cycle),
            k_range=cycle_range(along.k_t, cycle),
            k_angle=float(np.degrees(np.arctan2(direction[1], direction[0]))),
            turning=turning,
            k_range_spread=spread.total,
            k_range_parts=spread,
            k_i_range=cycle_range(history.k_i, cycle),
            reference_length=np.nan if self.lengths is None else float(self.lengths[number]),
            exponent=float(fit.exponent[history.last, number]),
            oscillation=oscillation(self.contact.surface.dundurs),
            coupling=coupled * float(friction.max()),
            friction=float(friction[history.last]),
            cycles=cycles,
            stiffening=_stiffening(frames, number, length, depth),
            slip_zones=tuple(
                self._with_shear(number, along, zone, direction)
                for zone in self._zones(number, along, cycles)
            ),
        )
        return without_formulas(found)

    def _history(self, number: int) -> StationHistory:
        fit, mean = self.track.fit, self.factors.ways[:, number].mean(axis=0)
        return StationHistory(
            front=self.name,
            number=number,
            position=fit.place[:, number],
            position_spread=fit.place_spread[:, number],
            k_n=fit.k_n[:, number],
            k_n_spread=with_moved(
                fit.k_n[:, number], fit.k_n_spread[:, number], self.moved[number].k_n
            ),
            k_t=mean[:, Factor.K_T],
            k_s=mean[:, Factor.K_S],
            k_i=mean[:, Factor.K_I],
        )

    def _zones(
        self, number: int, along: StationHistory, cycles: CountedCycles
    ) -> tuple[SlipZone, ...]:
        """Slip zones, predicted with K along the direction in which it varies most."""
        front, friction = self.track.front, self.frictions[number]
        cycle = cycle_states(self.solution.cycle)
        worst = worst_cycle(cycles, cycle, friction, along)
        outer = worst.outer if worst else np.ones(len(friction), dtype=bool)

        def growth(start: int, end: int) -> Growth | None:
            return zone_growth(along, friction, start, end, outer)

        border = self.slip.border_of(
            front.sectors[number], along.position, float(front.depth[number]), outer, growth
        )
        return slip_zones(
            cycle,
            friction,
            along,
            border,
            self.path,
            lambda position, border: position + border,
            worst,
            self.pressed[number],
            self.contact.surface.dundurs != 0,
        )

    def _with_shear(
        self, number: int, along: StationHistory, zone: SlipZone, line: Array
    ) -> SlipZone:
        """A slip zone with the share of f p that acts across a line (2,) and along it."""
        front, frames = self.track.front, self.track.front.frames
        predicted, depth = float(np.nan_to_num(zone.prediction)), float(front.depth[number])
        friction = float(self.frictions[number][zone.end])

        def share(state: int, axis: Array, begin: float) -> float:
            reach = along.position[state] + np.array([begin, depth])
            sector = front.sectors[number]
            return shear_share(self.contact, sector, state, friction, axis, tuple(reach))

        inward, tangent = frames.inward[number], frames.along[number]
        across = share(zone.start, line[0] * tangent - line[1] * inward, predicted)
        if zone.resolved or zone.gross:
            return replace(zone, across=across)
        flank = share(zone.end, line[0] * inward + line[1] * tangent, FLANK * predicted)
        return replace(zone, across=across, flank=flank)


def _stiffening(frames: Frames, station: int, length: float, depth: float) -> float:
    """Relative growth of dP/da with the half-width: in the plane, and of the front's length.

    A concave front gets shorter, which takes away half of the former at most.
    """
    growth, curvature = load_growth(length, depth), float(frames.curvature[station])
    round_front = frames.closed and curvature > 0
    return growth + (1 / depth if round_front else max(curvature, -growth / 2))
