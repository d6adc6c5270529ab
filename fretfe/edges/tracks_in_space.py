# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts of solids followed through a history: place and K_N of every station in every state."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from fretfe._typing import Array, Bools, Indices
from fretfe.edges.curve import Frames
from fretfe.edges.sector_fits import FrontFit
from fretfe.edges.space_fronts import FrontFinder, SpaceFront
from fretfe.results.solution import ContactHistory, Solution
from fretfe.results.states import blocks

# Distance of a front from the stations' reference, in elements, up to which the same sectors serve.
NEAR = 0.75
# Share of the stations that must be known.
KNOWN = 0.5
# Points of a curve between which it is straight, for each of its stations.
FINER = 8
# Known stations that a curve through them takes.
FEWEST = 4
# Attributes of a fit that there is none of.
UNKNOWN = np.array([np.nan, np.inf, np.nan, np.inf, np.nan])
# Curves found anew, at most, for a front that moves far.
MOST_CURVES = 12


@dataclass(frozen=True)
class FrontTrack:
    """One front in T states, at the n stations that it has in the reference state.

    Attributes:
        front: in the reference state.
        fit: (T, n) places are distances inward from there along each station's `inward`.
    """

    front: SpaceFront
    fit: FrontFit


def follow_fronts(
    solution: Solution, contact: ContactHistory, count: int
) -> tuple[FrontTrack, ...]:
    """The fronts of the last state of the cycle, or of all, followed through the history.

    Longest first. They are searched for again where they have moved in the cycle, or anywhere
    without one; in states outside of it they are known as far as they stay where they are in it.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        count: number of stations of each front.
    """
    finder, found, source = FrontFinder(contact, count), {}, solution.source
    first, reference = solution.cycle or (0, len(source) - 1)

    def fronts(state: int) -> tuple[SpaceFront, ...]:
        if state not in found:
            pressed = np.asarray(contact.traction[state][:, 0] > 0)
            found[state] = finder.fronts(pressed, contact.mean_traction[state][:, 0])
        return found[state]

    states = np.unique(source)
    states = states[contact.nodes_pressed_in(states) > 0]
    wanted = np.isin(states, source[first : reference + 1])
    tracks = []
    for front in fronts(int(source[reference])):
        fit = _follow(contact, front, states, wanted, fronts)
        rows = np.full(len(source), -1)
        inside = np.isin(source, states)
        rows[inside] = np.searchsorted(states, source[inside])
        tracks.append(FrontTrack(front, FrontFit(*(each[rows] for each in vars(fit).values()))))
    return tuple(tracks)


def _follow(
    contact: ContactHistory,
    front: SpaceFront,
    states: Indices,
    wanted: Bools,
    fronts: Callable[[int], tuple[SpaceFront, ...]],
) -> FrontFit:
    """Fits in some states (n,), and a last row of unknown ones."""
    shape = len(states) + 1, len(front.sectors)
    values = np.tile(UNKNOWN[:, None, None], shape)
    todo, own, curve = np.arange(len(states)), -1, front
    for _ in range(MOST_CURVES):
        fits = _fit(contact, curve, states[todo])
        off = np.abs(fits[0]) / curve.sizes
        known = np.isfinite(off)
        near = np.where(known, off, 0.0).max(axis=1) <= NEAR
        near &= known.mean(axis=1) >= KNOWN
        for row, fit in zip(todo[near], fits[:, near].swapaxes(0, 1), strict=True):
            values[:, row] = fit if curve is front else at_stations(curve.frames, fit, front.frames)
        # A state whose own curve does not fit it stays unknown, like one without such a front.
        todo = todo[~near & (todo != own)]
        last_first = todo[wanted[todo]][::-1]
        curves = ((row, _same(front, fronts(int(states[row])))) for row in last_first)
        own, other = next((each for each in curves if each[1] is not None), (-1, None))
        if other is None:
            break
        curve = other
    return FrontFit(*values)


def _fit(contact: ContactHistory, curve: SpaceFront, states: Indices) -> Array:
    """(5, n, stations) fits in some states."""
    parts = []
    for block in blocks(len(states), contact.traction[0].size):
        pressure = contact.mean_traction[states[block]][..., 0]
        parts.append(np.array([*vars(curve.fits.fit(pressure)).values()]))
    return np.concatenate(parts, axis=1)


def _same(front: SpaceFront, others: tuple[SpaceFront, ...]) -> SpaceFront | None:
    """The front among others that crosses the stations' lines of a front, the nearest to them."""
    best, distance = None, np.inf
    for other in others:
        flat = np.zeros((5, len(other.frames.points)))
        place = at_stations(other.frames, flat, front.frames)[0]
        crossed = np.isfinite(place)
        if crossed.mean() >= KNOWN and np.mean(np.abs(place[crossed])) < distance:
            best, distance = other, float(np.mean(np.abs(place[crossed])))
    return best


def at_stations(frames: Frames, fit: Array, stations: Frames) -> Array:
    """(5, n) attributes of a fit (5, m) of one front at the n stations of another one.

    NaN, with infinite bars, where the front does not cross the line along a station's `inward`.
    """
    if np.count_nonzero(np.isfinite(fit[0])) < FEWEST:
        return np.tile(UNKNOWN[:, None], len(stations.arc))
    points, values = finer(frames, fit[0], fit.T)
    result = np.tile(UNKNOWN, (len(stations.arc), 1))
    for station in range(len(stations.arc)):
        place = points - stations.points[station]
        x, y = place @ stations.along[station], place @ stations.inward[station]
        # The contact lies on the right of both: they run the same way.
        crossed = np.flatnonzero((x[:-1] <= 0) & (x[1:] > 0))
        if not len(crossed):
            continue
        share = -x[crossed] / (x[crossed + 1] - x[crossed])
        at = (1 - share) * y[crossed] + share * y[crossed + 1]
        best = int(np.argmin(np.abs(at)))
        row, part = crossed[best], share[best]
        result[station] = (1 - part) * values[row] + part * values[row + 1]
        result[station, 0] = at[best]
    return result.T


def finer(frames: Frames, place: Array, values: Array) -> tuple[Array, Array]:
    """Many points of a front, in order.

    Args:
        frames: n stations of a reference front.
        place: (n,) distances of the front inward from there, NaN where it is not known.
        values: (n, k) of the stations.

    Returns:
        (m, 3) points, and (m, k) values between those of the stations.
    """
    known = np.isfinite(place)
    points = (frames.points + place[:, None] * frames.inward)[known]
    values = values[known]
    if frames.closed:
        points, values = np.vstack([points, points[:1]]), np.vstack([values, values[:1]])
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    curve = CubicSpline(arc, points, bc_type="periodic" if frames.closed else "not-a-knot")
    fine = np.unique(np.concatenate([arc, np.linspace(0.0, arc[-1], FINER * len(arc))]))
    columns = [np.interp(fine, arc, column) for column in values.T]
    return np.asarray(curve(fine)), np.array(columns).T
