# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts across rows of elements that are long, skewed, and grow towards the front and beyond."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded, edge_factor_k_n
from fretfe.evaluate.space.pressure_fit import FrontFit, FrontFitter
from fretfe.evaluate.space.sectors import Frames, Sectors

# A flat with a rounding of which .33 is in contact: the pressure is another function behind it.
HALF_WIDTH = 2.25
PUNCH = FlatRounded(HALF_WIDTH - 0.33, 8.0, 6e4)
SKEW, LAYER, LAYERS, STATIONS = np.radians(10.0), 1.5, 8, 40
# The fine zone ends behind the front; elements grow from there by this ratio.
FINE_ZONE, GROWTH = 0.06, 1.37


def rows(size: float, offset: float) -> Array:
    """(n,) places of the nodes across the front, which is at 0."""
    s, step = [FINE_ZONE + offset], size
    while s[-1] > -0.6:
        step *= GROWTH
        s.append(s[-1] - step)
    return np.concatenate([s[::-1], s[0] + size * np.arange(1, int(1.9 / size))])


def means(s: Array) -> tuple[Array, Array]:
    """(n,) means of the exact pressure around nodes, weighted by hats, and (n,) their lengths."""
    gauss, weights = np.polynomial.legendre.leggauss(12)
    sums, lengths = np.zeros((2, len(s)))
    for number, (left, right) in enumerate(pairwise(s)):
        if right > 0:
            ends = np.sqrt([max(left, 0.0), right])  # of roots, in which the pressure is smooth
            root = ends[0] + np.diff(ends) * (gauss + 1) / 2
            amounts = (
                weights * np.diff(ends) * root * PUNCH.pressure(HALF_WIDTH - root**2, HALF_WIDTH)
            )
            share = (root**2 - left) / (right - left)
            sums[number : number + 2] += np.sum(amounts * (1 - share)), np.sum(amounts * share)
        lengths[number : number + 2] += (right - left) / 2
    return sums / lengths, lengths


def skewed(s: Array) -> tuple[Frames, Sectors]:
    """Stations of the front, and the surface of rows (n,) along z = 0, 1.5, ... 12."""
    along = np.array([np.sin(SKEW), 0.0, np.cos(SKEW)])
    z = LAYER * np.arange(LAYERS + 1)
    # Rows lie in planes z = const, and the front is askew to them.
    points = np.zeros((len(z), len(s), 3))
    points[..., 0] = s / np.cos(SKEW) + np.tan(SKEW) * z[:, None]
    points[..., 2] = z[:, None]
    numbers = np.arange(len(z) * len(s)).reshape(len(z), len(s))
    corners = numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, 1:], numbers[1:, :-1]
    facets = np.stack(corners, axis=-1).reshape(-1, 4)
    length = LAYER * LAYERS / np.cos(SKEW)
    arc = (np.arange(STATIONS) + 0.5) * length / STATIONS
    ones = np.ones((STATIONS, 1))
    frames = Frames(
        points=arc[:, None] * along,
        inward=ones * [np.cos(SKEW), 0.0, -np.sin(SKEW)],
        along=ones * along,
        across=ones * [0.0, 1.0, 0.0],
        curvature=np.zeros(STATIONS),
        arc=arc,
        length=length,
        closed=False,
    )
    return frames, Sectors(points.reshape(-1, 3), facets)


def fitted(size: float, offset: float) -> tuple[FrontFit, Array, Array]:
    """Fits at all stations, and the sizes of elements there across the front and along it."""
    s = rows(size, offset)
    frames, surface = skewed(s)
    depth = np.full(STATIONS, HALF_WIDTH)
    sectors = [surface.around(frames, number, 1.5 * HALF_WIDTH) for number in range(STATIONS)]
    pressure, lengths = (np.tile(each, LAYERS + 1) for each in means(s))
    fit = FrontFitter(sectors, lengths, 1.5 * depth, depth).fit(pressure[None])
    sizes = np.array([(sector.size, sector.along_size) for sector in sectors])
    return fit, *sizes.T


@pytest.mark.parametrize("size", [0.0191, 0.0052])
def test_elements_at_the_front_are_found_from_between_the_rows(size: float) -> None:
    """From the middle of a layer too, where 200 edges along it are nearer than any across it."""
    s = rows(size, 0.0)
    _, across, along = fitted(size, 0.0)
    np.testing.assert_allclose(along, LAYER / np.cos(SKEW), rtol=0.02)
    at_front = np.diff(s)[np.searchsorted(s, 0.0) - 1]
    # No more than an element off, which is as much longer or shorter.
    assert np.all((across < 1.01 * at_front * GROWTH) & (across > 0.99 * at_front / GROWTH))


@pytest.mark.parametrize("size", [0.0191, 0.01, 0.0052])
def test_k_n_is_within_its_bar_wherever_the_front_is_in_its_element(size: float) -> None:
    exact = float(edge_factor_k_n(PUNCH, HALF_WIDTH))
    for offset in size * np.arange(8) / 8:
        fit, _, _ = fitted(size, offset)
        error = np.abs(fit.k_n[0] - exact)
        assert np.all(error <= fit.k_n_spread[0])
        assert np.all(fit.k_n_spread[0] < 0.12 * exact)
