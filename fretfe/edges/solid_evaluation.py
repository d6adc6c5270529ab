# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of the fronts of a solid contact: factors, error bars and slip zones of stations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.edges.between import LoadPath, excess, load_path
from fretfe.edges.closure import closure
from fretfe.edges.evaluate import last_known
from fretfe.edges.factors import add_up, one_sided_share
from fretfe.edges.front import LARGEST_SPREAD, Frame, RangeSpread, SlipZone, StationHistory
from fretfe.edges.missions import count_cycles, worst_cycle
from fretfe.edges.moved_fronts import MovedStation, moved_stations
from fretfe.edges.range_spread import cycle_range
from fretfe.edges.sector_fits import FrontFit
from fretfe.edges.slip_zones import cycle_states, slip_zones
from fretfe.edges.solid_fronts import SolidFront, SolidStation
from fretfe.edges.solid_slip import SlipBetween
from fretfe.edges.space_fronts import SpaceFront
from fretfe.edges.tracks_in_space import FrontTrack
from fretfe.results.solution import ContactHistory, Factor, Solution

# How far the border of an averaged area may be from the front, in elements: bonded spheres with
# elements of a/12 and a/20 are off by 2.8 and 1.6 % at most, .8 and .5 % rms.
WITHIN_ELEMENT = 0.35


def evaluate_fronts(
    solution: Solution, contact: ContactHistory, tracks: tuple[FrontTrack, ...]
) -> tuple[SolidFront, ...]:
    """Evaluate the fronts of a solid contact, followed through the history."""
    slip, path = SlipBetween(contact), load_path(solution.values, solution.between, solution.cycle)
    fronts, first = [], 0
    for number, track in enumerate(tracks):
        count = len(track.front.sectors)
        own = slice(first, first + count)
        first += count
        front = _Front(
            f"front {number + 1}",
            solution,
            contact,
            track,
            _Factors.of(solution, contact, track, own),
            moved_stations(contact, track.front, own),
            slip,
            path,
        )
        stations = tuple(front.station(each) for each in range(count))
        frames = track.front.frames
        sums = closure(solution, contact, track, alone=len(tracks) == 1)
        fronts.append(SolidFront(front.name, frames.closed, frames.length, sums, stations))
    return tuple(fronts)


class _Factors:
    """Singular factors of the n stations of a front.

    Attributes:
        ways: (R, n, T, 3) histories in R ways.
        one_sided: (n,) what steps of the cycle may be wrong by of which one end only is known.
    """

    def __init__(self, ways: Array, one_sided: Array) -> None:
        self.ways, self.one_sided = ways, one_sided

    @classmethod
    def of(
        cls, solution: Solution, contact: ContactHistory, track: FrontTrack, stations: slice
    ) -> _Factors:
        count, states = len(track.front.sectors), len(solution.times)
        integrals = contact.integrals
        if integrals is None:
            return cls(np.full((1, count, states, 3), np.nan), np.full(count, np.nan))
        touching = contact.pressed_nodes > 0
        drivers, friction = solution.driver_values, contact.friction
        ways = []
        one_sided = np.zeros(count)
        for way in range(len(integrals.reaches)):
            units = _interpolate(
                track.fit.place,
                integrals.positions[:, stations],
                integrals.factors[:, way, stations],
            )
            # Each station by itself: where one is unknown others are not.
            ways.append(
                [
                    add_up(units[:, [row]], drivers, friction, touching, solution.cycle)[0]
                    for row in range(count)
                ]
            )
            if way == 0:
                shares = [
                    one_sided_share(units[:, [row]], drivers, solution.cycle)[0]
                    for row in range(count)
                ]
                one_sided = np.array(shares)
        return cls(np.array(ways), one_sided)


def _interpolate(places: Array, known: Array, values: Array) -> Array:
    """(T, n, ...) values (S, n, ...) known at places (S, n), at the places (T, n) of all states.

    Linear between and constant outside; NaN where the place is.
    """
    result = np.full((len(places), *values.shape[1:]), np.nan)
    for station, (at, x) in enumerate(zip(places.T, known.T, strict=True)):
        found, there = np.isfinite(at), np.isfinite(x)
        if not there.any():
            continue
        order = np.flatnonzero(there)[np.argsort(x[there])]
        flat = values[order, station].reshape(len(order), -1)
        columns = [np.interp(at[found], x[order], column) for column in flat.T]
        result[found, station] = np.array(columns).T.reshape(-1, *values.shape[2:])
    return result


@dataclass(frozen=True)
class _Front:
    """One front, and what the numbers of its stations are made of."""

    name: str
    solution: Solution
    contact: ContactHistory
    track: FrontTrack
    factors: _Factors
    moved: Sequence[MovedStation]
    slip: SlipBetween
    path: LoadPath | None

    def station(self, number: int) -> SolidStation:
        """All that is known of a station."""
        front, fit, moved = self.track.front, self.track.fit, self.moved[number]
        frames, sector = front.frames, front.sectors[number]
        cycle = cycle_states(self.solution.cycle)
        history = self._history(number)
        vectors = np.column_stack([history.k_t, history.k_s])
        direction, turning = _direction(vectors, cycle)
        along = replace(history, k_t=vectors @ direction)
        spread = _spread(self.factors, front, fit, number, direction, cycle, self.path)
        length = float(last_known(fit.length[:, number], cycle))
        depth, to_end = float(front.depth[number]), float(frames.to_end[number])
        return SolidStation(
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
            slip_zones=self._zones(number, along),
        )

    def _history(self, number: int) -> StationHistory:
        fit, mean = self.track.fit, self.factors.ways[:, number].mean(axis=0)
        return StationHistory(
            front=self.name,
            number=number,
            position=fit.place[:, number],
            position_spread=fit.place_spread[:, number],
            k_n=fit.k_n[:, number],
            k_n_spread=_k_n_spread(fit, number, self.moved[number]),
            k_t=mean[:, Factor.K_T],
            k_s=mean[:, Factor.K_S],
            k_i=mean[:, Factor.K_I],
        )

    def _zones(self, number: int, along: StationHistory) -> tuple[SlipZone, ...]:
        """Slip zones, predicted with K along the direction in which it varies most."""
        front, friction = self.track.front, self.contact.friction
        cycle = cycle_states(self.solution.cycle)
        worst = worst_cycle(count_cycles(cycle, friction, along), cycle, friction, along)
        border = self.slip.border_of(
            front.sectors[number],
            along.position,
            float(front.depth[number]),
            worst.outer if worst else None,
        )
        return slip_zones(
            cycle,
            friction,
            along,
            border,
            self.path,
            lambda position, border: position + border,
            worst,
        )


def _k_n_spread(fit: FrontFit, station: int, moved: MovedStation) -> Array:
    """(T,) error bars of K_N: where the fits of the last state disagree, so may all of them.

    K_N by the movement of the front does not depend on them.
    """
    spread, k_n = fit.k_n_spread[:, station].copy(), fit.k_n[-1, station]
    if spread[-1] > LARGEST_SPREAD * k_n and np.isfinite(moved.k_n):
        spread[-1] = max(spread[-1], abs(k_n - moved.k_n))
    return spread


def _direction(history: Array, cycle: Indices) -> tuple[Array, float]:
    """(2,) unit vector along which (K_T, K_S) (T, 2) varies most, and how much it turns.

    Its first component is positive: K along it has the sign of K_T.
    """
    vectors = history[cycle] if len(cycle) else history
    vectors = vectors[np.isfinite(vectors).all(axis=1)]
    if len(vectors) < 2 or not np.ptp(vectors, axis=0).any():
        return np.array([1.0, 0.0]), 0.0
    axes = np.linalg.svd(vectors - vectors.mean(axis=0), full_matrices=False)[2]
    along, across = (np.ptp(vectors @ axis) for axis in axes)
    direction = axes[0] * (1.0 if axes[0, 0] >= 0 else -1.0)
    return np.asarray(direction), float(across / along)


def _spread(
    factors: _Factors,
    front: SpaceFront,
    fit: FrontFit,
    station: int,
    direction: Array,
    cycle: Indices,
    path: LoadPath | None,
) -> RangeSpread:
    """Error bar of the range of (K_T, K_S) along a direction.

    The parts are those of the plane: what the ways to integrate differ by; that a discrete contact
    area ends somewhere within an element, by the largest range along the front, since that of one
    station may be a small difference; extremes between steps. And one more: elements that are long
    along the front cannot follow how factors vary there.
    """
    histories = factors.ways[..., Factor.K_T :]
    own = histories[:, station] @ direction
    bent = _bent(histories.mean(axis=0), front, station, direction, cycle)
    ranges = [cycle_range(way, cycle) for way in own]
    # At the ends of an open front factors grow out of all proportion.
    inner = front.frames.to_end > front.depth
    mean = histories.mean(axis=0)[inner if inner.any() else slice(None)]
    known = [size for each in mean if np.isfinite(size := _largest(each, cycle))]
    largest = max(known, default=np.nan)
    place = fit.place_spread[cycle, station] if len(cycle) else np.array([np.nan])
    error = np.hypot(WITHIN_ELEMENT * front.sectors[station].size, place).max()
    # Where a contact is long the rest of its border counts too; elements are coarse at sharp ends.
    radius = 1 / max(abs(float(front.frames.curvature[station])), 1e-300)
    misplaced = error / min(front.depth[station], np.median(front.depth), radius) * largest
    return RangeSpread(
        extraction=float(np.ptp(ranges)) / 2 if len(ranges) > 1 else np.nan,
        discretisation=float(np.linalg.norm([misplaced, factors.one_sided[station], bent])),
        steps=excess(own.mean(axis=0), cycle, path),
    )


def _bent(
    histories: Array, front: SpaceFront, station: int, direction: Array, cycle: Indices
) -> float:
    """Largest difference of the range from a straight line over one element along the front.

    Half of its second difference over the element, from the stations: h^2 / 8 times the second
    derivative. Next to stations that are not known it is taken from those that are.

    Args:
        histories: (n, T, 2) K_T and K_S of all stations.
        front: with the length of the elements along it.
        station: one of the stations.
        direction: (2,) unit vector of the range.
        cycle: states of the cycle.
    """
    if not len(cycle) or not np.isfinite(own := histories[station, cycle] @ direction).all():
        return 0.0
    swing = histories[:, cycle[np.argmax(own)]] - histories[:, cycle[np.argmin(own)]]
    size, frames = front.sectors[station].along_size, front.frames
    step = max(size / 2, frames.length / len(frames.arc))
    known = np.isfinite(swing).all(axis=1)
    at = frames.arc[station] + step * np.array([-1.0, 0.0, 1.0])
    period = frames.length if frames.closed else None
    if not frames.closed:
        first, last = frames.arc[known][[0, -1]]
        at += max(first - at[0], 0.0) - max(at[-1] - last, 0.0)
    values = np.interp(at, frames.arc[known], swing[known] @ direction, period=period)
    return float(abs(np.diff(values, 2)[0]) / 2 * (size / 2 / step) ** 2)


def _largest(history: Array, cycle: Indices) -> float:
    """Size of the range of a vector (T, 2) over the cycle."""
    direction = _direction(history, cycle)[0]
    return cycle_range(history @ direction, cycle)
