# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors of the ranges of factors at stations of solids by their elements."""

from __future__ import annotations

import math

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.evaluate.contacts import NEAR_FREE_END
from fretfe.evaluate.factors import FactorHistories, cycle_range, main_direction, misplaced_range
from fretfe.evaluate.space.fronts import SpaceFront
from fretfe.evaluate.space.pressure_fit import FrontFit
from fretfe.history.solution import Factor

# How far the border of an averaged area may be from the front, in elements: bonded spheres with
# elements of a/12 and a/20 are off by 2.8 and 1.6 % at most, .8 and .5 % rms.
WITHIN_ELEMENT = 0.35
# Integrals reach no farther from the front than this part of the half of the width of the contact,
# and of the radius of curvature of the front.
FARTHEST = 0.4
# Elements as far as integrals reach, by the shortest of the ways that are compared. Where there is
# less room all ways are alike, and their difference tells nothing. Error over the elements that
# are missing, as inverse numbers: at the tips of an ellipse with 2.3 elements ranges are 4.4 % too
# small where the other parts of the bar are 3.9 %.
SHORTEST_WAY = 4.0
CRAMPED = 0.15


def farthest(depth: float, radius: float) -> float:
    """Distance from a front as far as integrals reach at most.

    Args:
        depth: half of the width of the contact.
        radius: of curvature of the front.
    """
    return FARTHEST * min(depth, radius)


def unresolved(
    factors: FactorHistories,
    front: SpaceFront,
    fit: FrontFit,
    station: int,
    direction: Array,
    cycle: Indices,
) -> list[float]:
    """Errors of the range of (K_T, K_S) along a direction by elements.

    As in the plane a discrete contact area ends somewhere within an element, which counts by the
    largest range along the front, since that of one station may be a small difference. And more:
    elements that are long along the front cannot follow how factors vary there, less so next to a
    free end, next to its other end the factors are those of a place beside the station, and in a
    narrow place integrals have few elements.

    Args:
        factors: of all stations.
        front: in the reference state.
        fit: of all states.
        station: of the front.
        direction: (2,) of (K_T, K_S).
        cycle: states of the cycle.
    """
    histories = factors.ways[..., Factor.K_T :].mean(axis=0)
    swing = _swing(histories, station, direction, cycle)
    # At the ends of an open front factors grow out of all proportion.
    inner = front.frames.to_free_end > front.depth
    mean = histories[inner if inner.any() else slice(None)]
    sizes = [_largest(each, cycle) for each in mean]
    known = [size for size in sizes if np.isfinite(size)]
    largest = max(known, default=np.nan)
    # Where a contact is long the rest of its border counts too; elements are coarse at sharp ends.
    radius = 1 / max(abs(float(front.frames.curvature[station])), 1e-300)
    room = farthest(float(front.depth[station]), radius) / front.sectors[station].size
    cramped = CRAMPED * max(1 / room - 1 / SHORTEST_WAY, 0.0) * largest
    width = min(front.depth[station], np.median(front.depth), radius)
    growing = mean[int(np.argmax(np.nan_to_num(sizes)))]
    growing = growing @ main_direction(growing, cycle)[0]
    shares = _misplaced(front, fit, station, width)
    layers = front.sectors[station].along_size / float(front.frames.to_free_end[station])
    near = NEAR_FREE_END * layers**2 * float(abs(swing[station]))
    along = _bent(swing, front, station), _beside(swing, front, station)
    misplaced = misplaced_range(histories[station] @ direction, growing, shares, cycle)
    return [*misplaced, cramped, near if math.isfinite(near) else 0.0, *along]


def _misplaced(front: SpaceFront, fit: FrontFit, station: int, width: float) -> Array:
    """(T,) error of the place of a front over a width; NaN where the place is not known.

    Args:
        front: in the reference state.
        fit: of all states.
        station: of the front.
        width: in the reference state.
    """
    places, bars = fit.place[:, station], fit.place_spread[:, station]
    error = np.hypot(WITHIN_ELEMENT * front.sectors[station].size, bars)
    return np.asarray(error / np.clip(width - places, 0.1 * width, width))


def _swing(histories: Array, station: int, direction: Array, cycle: Indices) -> Array:
    """(n,) by how much factors of all stations change while those of one go through their range.

    NaN where they are not known; of all where they are not known at that station.

    Args:
        histories: (n, T, 2) K_T and K_S of all stations.
        station: the one.
        direction: (2,) unit vector of its range.
        cycle: states of the cycle.
    """
    if not len(cycle) or not np.isfinite(own := histories[station, cycle] @ direction).all():
        return np.full(len(histories), np.nan)
    ends = cycle[np.argmax(own)], cycle[np.argmin(own)]
    return np.asarray((histories[:, ends[0]] - histories[:, ends[1]]) @ direction)


def _bent(swing: Array, front: SpaceFront, station: int) -> float:
    """Largest difference of the range from a straight line over one element along the front.

    Half of its second difference over the element, from the stations: h^2 / 8 times the second
    derivative. Next to stations that are not known it is taken from those that are.

    Args:
        swing: (n,) of all stations, as of `_swing`.
        front: with the length of the elements along it.
        station: one of the stations.
    """
    known = np.isfinite(swing)
    if not known.any():
        return 0.0
    size, frames = front.sectors[station].along_size, front.frames
    step = max(size / 2, frames.length / len(frames.arc))
    at = frames.arc[station] + step * np.array([-1.0, 0.0, 1.0])
    period = frames.length if frames.closed else None
    if not frames.closed:
        first, last = frames.arc[known][[0, -1]]
        at += max(first - at[0], 0.0) - max(at[-1] - last, 0.0)
    values = np.interp(at, frames.arc[known], swing[known], period=period)
    return float(abs(np.diff(values, 2)[0]) / 2 * (size / 2 / step) ** 2)


def _beside(swing: Array, front: SpaceFront, station: int) -> float:
    """Change of the range between a station next to an end and where its factors are integrated.

    By the slope of the range behind that place; arguments as of `_bent`.
    """
    aside, frames = float(front.aside[station]), front.frames
    known = np.isfinite(swing)
    if not aside or not known.any():
        return 0.0
    step = math.copysign(max(abs(aside), frames.length / len(frames.arc)), aside)
    at = frames.arc[station] + aside + np.array([0.0, step])
    return float(abs(aside / step * np.diff(np.interp(at, frames.arc[known], swing[known]))[0]))


def _largest(history: Array, cycle: Indices) -> float:
    """Size of the range of a vector (T, 2) over the cycle."""
    return cycle_range(history @ main_direction(history, cycle)[0], cycle)
