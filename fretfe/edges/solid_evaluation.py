# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of the fronts of a solid contact: factors, error bars and slip zones of stations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.edges.between import LoadPath, excess, load_path
from fretfe.edges.evaluate import last_known
from fretfe.edges.factors import add_up, one_sided_share
from fretfe.edges.front import Frame, RangeSpread, StationHistory
from fretfe.edges.range_spread import cycle_range
from fretfe.edges.sector_fits import FrontFit
from fretfe.edges.slip_zones import cycle_states, slip_zones
from fretfe.edges.solid_fronts import SolidFront, SolidStation
from fretfe.edges.solid_slip import SlipBetween
from fretfe.edges.space_fronts import SpaceFront
from fretfe.edges.tracks_in_space import FrontTrack
from fretfe.results.solution import ContactHistory, Factor, Solution

# A ragged border changes factors as if the whole contact were narrower by so many elements: .66 of
# them at the worst of some 200 stations of random spheres and ellipsoids.
RAGGED = 0.7


def evaluate_fronts(
    solution: Solution, contact: ContactHistory, tracks: tuple[FrontTrack, ...]
) -> tuple[SolidFront, ...]:
    """Evaluate the fronts of a solid contact, followed through the history."""
    slip, path = SlipBetween(contact), load_path(solution.values, solution.between, solution.cycle)
    fronts, first = [], 0
    for number, track in enumerate(tracks):
        count = len(track.front.sectors)
        factors = _Factors.of(solution, contact, track, slice(first, first + count))
        first += count
        name = f"front {number + 1}"
        stations = tuple(
            _station(solution, contact, track, factors, station, name, slip, path)
            for station in range(count)
        )
        frames = track.front.frames
        fronts.append(SolidFront(name, frames.closed, frames.length, stations))
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


def _station(
    solution: Solution,
    contact: ContactHistory,
    track: FrontTrack,
    factors: _Factors,
    station: int,
    name: str,
    slip: SlipBetween,
    path: LoadPath | None,
) -> SolidStation:
    front, fit = track.front, track.fit
    frames, sector = front.frames, front.sectors[station]
    cycle = cycle_states(solution.cycle)
    mean = factors.ways[:, station].mean(axis=0)
    history = StationHistory(
        front=name,
        number=station,
        position=fit.place[:, station],
        position_spread=fit.place_spread[:, station],
        k_n=fit.k_n[:, station],
        k_n_spread=fit.k_n_spread[:, station],
        k_t=mean[:, Factor.K_T],
        k_s=mean[:, Factor.K_S],
        k_i=mean[:, Factor.K_I],
    )
    direction, turning = _direction(mean[:, Factor.K_T :], cycle)
    along = replace(history, k_t=mean[:, Factor.K_T :] @ direction)
    spread = _spread(factors, front, fit, station, direction, cycle, path)
    length = float(last_known(fit.length[:, station], cycle))
    depth, to_end = float(front.depth[station]), float(frames.to_end[station])
    zones = slip_zones(
        cycle,
        contact.friction,
        along,
        slip.border_of(sector, history.position, depth),
        path,
        lambda position, border: position + border,
    )
    return SolidStation(
        **vars(history),
        point=frames.points[station],
        frame=Frame(frames.inward[station], frames.along[station], frames.across[station]),
        arc=float(frames.arc[station]),
        curvature=float(frames.curvature[station]),
        to_end=to_end,
        size=sector.size,
        depth=depth,
        length=length,
        # Within a local length of a free end fields are those of a vertex.
        end=not to_end > max(min(depth, length), sector.along_size),
        k_t_range=cycle_range(history.k_t, cycle),
        k_s_range=cycle_range(history.k_s, cycle),
        k_range=cycle_range(along.k_t, cycle),
        k_angle=float(np.degrees(np.arctan2(direction[1], direction[0]))),
        turning=turning,
        k_range_spread=spread.total,
        k_range_parts=spread,
        k_i_range=cycle_range(history.k_i, cycle),
        slip_zones=zones,
    )


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
    station may be a small difference; extremes between steps. A ragged border changes factors twice
    as much as one that is misplaced as a whole, which they follow as roots of the half-width:
    bonded spheres with elements of a/12 and a/20 are off by up to 5 and 2.5 %.
    """
    histories = factors.ways[..., Factor.K_T :]
    own = histories[:, station] @ direction
    ranges = [cycle_range(way, cycle) for way in own]
    # At the ends of an open front factors grow out of all proportion.
    inner = front.frames.to_end > front.depth
    mean = histories.mean(axis=0)[inner if inner.any() else slice(None)]
    known = [size for each in mean if np.isfinite(size := _largest(each, cycle))]
    largest = max(known, default=np.nan)
    place = fit.place_spread[cycle, station] if len(cycle) else np.array([np.nan])
    error = np.hypot(RAGGED * front.sectors[station].size, place).max()
    # Where a contact is long the rest of its border counts too.
    misplaced = error / min(front.depth[station], np.median(front.depth)) * largest
    return RangeSpread(
        extraction=float(np.ptp(ranges)) / 2 if len(ranges) > 1 else np.nan,
        discretisation=float(np.hypot(misplaced, factors.one_sided[station])),
        steps=excess(own.mean(axis=0), cycle, path),
    )


def _largest(history: Array, cycle: Indices) -> float:
    """Size of the range of a vector (T, 2) over the cycle."""
    direction = _direction(history, cycle)[0]
    return cycle_range(history @ direction, cycle)
