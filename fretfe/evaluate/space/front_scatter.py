# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error bars of numbers along a front that scatter by more than their bars say.

K_N and the range of (K_T, K_S) of a smooth front are smooth along it. What neighbouring stations
differ by beyond that is error, whatever it comes from: a ragged border, elements, a crystal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from math import comb

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Station

# Standard deviation of normal errors over half the width of their 95 % interval.
DEVIATION = 1 / 1.96
# Orders of the differences along a front: polynomials of lower orders have none. Each order shows
# the scatter and some of the true change; the least of them shows the least of that.
ORDERS = (2, 3, 4, 5, 6)
# Stations below which a front tells nothing about its scatter: around an ellipse of 2 to 1 they
# truly differ by more.
FEWEST = 16
# Stations that a front keeps where only every second, third, ... is compared with the next.
AROUND = 20
# Angle that a front turns by from one of those to the next, from which they tell no scatter: along
# ellipses numbers then truly differ by more than polynomials of these orders follow.
SHARPEST = 0.45


def scatter_ratio(values: Array, bars: Array, closed: bool, stride: int = 1) -> Array:
    """(T, n) by what factor bars must grow to hold the scatter along a front; 1 at least.

    The ratio of R. T. Birge (Phys. Rev. 40, 1932), root of chi^2 over its expectation, of the
    differences of order m of neighbours: their weights are binomial coefficients of alternating
    signs, and their variance the sum of the squares times those of the bars. The order is that
    which shows least along the whole front. At a station differences count by its share in their
    variance, so that one that is off by itself tells, or all alike where those show more. Errors
    that vary as slowly as the numbers do not show.

    Args:
        values: (T, n) at evenly spaced stations; NaN where not known.
        bars: (T, n) half-widths of their 95 % intervals.
        closed: the last station is a neighbour of the first.
        stride: stations from one to the next that is compared with it.
    """
    states, count = values.shape
    least, found = np.full((states, 1), np.inf), np.ones_like(values)
    if count < FEWEST:
        return found
    for order in ORDERS:
        starts = np.arange(count if closed else max(count - order * stride, 0))
        members = (starts[:, None] + stride * np.arange(order + 1)) % count
        squares = _squares(values[:, members], bars[:, members])
        whole = _means(squares, np.ones((len(starts), 1)))
        takes_part = np.zeros((len(starts), count))
        shares = np.broadcast_to(_weights(order) ** 2, members.shape)
        np.put_along_axis(takes_part, members, shares, axis=1)
        near = _means(squares, takes_part)
        found = np.where(whole < least, np.fmax(near, whole), found)
        least = np.fmin(least, whole)
    return np.sqrt(np.maximum(np.where(np.isfinite(found), found, 1.0), 1.0))


def _weights(order: int) -> Array:
    """(order + 1,) weights of the members of a difference."""
    return np.array([(-1) ** k * comb(order, k) for k in range(order + 1)], dtype=float)


def _squares(values: Array, bars: Array) -> Array:
    """(T, d) squares of d differences of values (T, d, m) over their variances; NaN if unknown."""
    weights = _weights(values.shape[-1] - 1)
    variances = (DEVIATION * bars) ** 2 @ weights**2
    known = np.isfinite(variances) & (variances > 0)
    squares = (values @ weights) ** 2
    return np.divide(squares, variances, where=known, out=np.full_like(squares, np.nan))


def _means(squares: Array, takes_part: Array) -> Array:
    """(T, k) means of the known ones of squares (T, d) over k groups (d, k); NaN of none."""
    known = np.isfinite(squares)
    number = known.astype(float) @ takes_part
    total = np.where(known, squares, 0.0) @ takes_part
    return np.divide(total, number, where=number > 0, out=np.full_like(total, np.nan))


def with_scatter(
    stations: tuple[Station, ...], closed: bool, widths: Sequence[float], length: float
) -> tuple[Station, ...]:
    """The n stations of a front with bars of K_N and of ranges that hold their scatter.

    Args:
        stations: as far as each of them knows by itself.
        closed: the front runs back into itself.
        widths: (n,) half-widths along the front of what each station takes its numbers from.
        length: of the front.
    """
    count = len(stations)
    if count < FEWEST:
        return stations
    turn = np.array([abs(each.curvature) for each in stations]) * length / count
    inner = ~np.array([each.end for each in stations])
    k_n = np.array([(each.k_n, each.k_n_spread) for each in stations]).transpose(1, 2, 0)
    ranges = np.array([[(each.k_range, each.k_range_spread)] for each in stations]).T
    of_k_n, of_range = np.ones_like(k_n[0]), np.ones_like(ranges[0])
    # Neighbours that share most nodes err alike. Farther apart than that they truly differ.
    shared = round(float(np.median(widths)) * count / length)
    for stride in {1, max(min(shared, count // AROUND), 1)}:
        smooth = inner & (turn * stride < SHARPEST)
        for ratio, (values, bars) in ((of_k_n, k_n), (of_range, ranges)):
            found = scatter_ratio(np.where(smooth, values, np.nan), bars, closed, stride)
            np.maximum(ratio, found, out=ratio)
    return tuple(
        _widened(station, of_k_n[:, number], float(of_range[0, number]))
        for number, station in enumerate(stations)
    )


def _widened(station: Station, of_k_n: Array, of_range: float) -> Station:
    """A station with bars times factors; what a range lacks counts as its discretisation."""
    station = replace(station, k_n_spread=station.k_n_spread * of_k_n)
    parts, total = station.k_range_parts, station.k_range_spread
    if not (of_range > 1 and math.isfinite(total)):
        return station
    wider = math.hypot(parts.discretisation, total * math.sqrt(of_range**2 - 1))
    parts = replace(parts, discretisation=wider)
    return replace(station, k_range_parts=parts, k_range_spread=parts.total)
