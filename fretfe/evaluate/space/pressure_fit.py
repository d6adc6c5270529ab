# SPDX-License-Identifier: LGPL-3.0-or-later
"""K_N and the place of a front at stations of a solid, from the pressures around them.

p = t^lambda (K_N + c_1 t + c_2 t^2 + ...), t the distance from the front and lambda = 1/2 but
between unlike bodies, is fitted to moments of the pressure: its integrals with smooth bumps, which
have their places one after the other from the front inward and fade out along it. Nodal values
alternate about the truth next to a front, as the contact area ends at nodes. Moments see of it only
that of second order of what elements carry about the front, one unknown more, which goes with the
curvature of a bump there. Bumps of several widths and numbers, and several orders, are joined by
``average``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import csr_array

from fretfe._core import _kernels
from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.numerics import average
from fretfe.evaluate.space.sectors import Frames, Sector

# Distances between bumps, in elements, and numbers of bumps: the windows of the fits.
SPACINGS = (1.0, 1.5, 2.0, 3.0)
COUNTS = (4, 5, 7, 10)
WINDOWS = tuple((spacing, count) for spacing in SPACINGS for count in COUNTS)
# Numbers of terms of the series.
TERMS = (2, 3, 4)
# A bump reaches over so many spacings to either side.
REACH = 2
# The series of a Hertzian contact converges as far as so many half-widths. Windows that go beyond
# those of the contact whose pressure falls as fast are left out: a rounding may end there, and the
# pressure be another function. Those of so many elements, the least for two orders, are not.
CONVERGES = 2.0
SHORTEST = 6.0
# Scatter of a moment relative to it, times the distance of bumps in elements; more of the first
# two, which hold the front.
SCATTER = 0.004
FIRST = 0.01
# Half-width of the 95 % interval over the estimated error, of the place and of K_N.
INTERVALS = np.array([1.5, 1.7])
# Error of K_N times the square of the number of elements over the half-width of the contact, or
# over the length in which K_N makes the pressure. Rows of nodes along the front, as layers have
# them, all end at the same place within an element, and no mean along the front tells: cylinders
# with 5 to 13 elements are off by .7 to 1.0 of that, of either sign.
COARSE = 1.0
# Places of the front that are looked at, in spacings from the reference front, and for which
# moments are tabulated.
FARTHEST = 1.5
PLACES = np.linspace(-FARTHEST - 0.1, FARTHEST + 0.1, 161)
ITERATIONS = 3
# Nodes sample a bump well enough if they give its integral to so much.
SAMPLED = 0.15
# Exponents lambda of which moments are tabulated; between them they are a polynomial of it, to 1e-5
# as far as they reach.
EXPONENTS = 0.5 + 0.06 * np.arange(-2, 3)


@dataclass(frozen=True)
class FrontFit:
    """Fronts and K_N at n stations in T states; NaN, with infinite bars, where there is no fit.

    Error bars are half the width of an interval that is meant to hold the truth with 95 %.

    Attributes:
        place: (T, n) distance of the front from the reference front, inward.
        place_spread: (T, n) its error bar.
        k_n: (T, n) stress over root of length.
        k_n_spread: (T, n) its error bar.
        length: (T, n) over which K_N makes the pressure: that of the Hertzian contact, of this
            half-width, whose pressure falls behind K_N sqrt(t) as fast.
        exponent: (T, n) lambda; where it is not 1/2, K_N is that at the length 1.
    """

    place: Array
    place_spread: Array
    k_n: Array
    k_n_spread: Array
    length: Array
    exponent: Array

    def of(self, station: int) -> EdgeFit:
        """That of one station."""
        columns = self.place, self.k_n, self.place_spread, self.k_n_spread, self.exponent
        return EdgeFit(*(each[:, station] for each in columns))


def load_growth(length: float, half_width: float) -> float:
    """Relative growth of dP/da with a in the plane problem next to a front.

    By superposed flat punches ((A0) of the theory guide) a symmetric contact of half-planes of the
    half-width a, with dP/da growing at the rate g, has next to its edges the pressure
    p = K_N sqrt(t) (1 + (5/(12a) - 2g/3) t + ...). Hertz has `length` = a and g = 1/a; a flat with
    rounded ends has a g far below 1/`length`.

    Args:
        length: over which K_N makes the pressure, as of `FrontFit`: 1 - t/(4 length).
        half_width: a.
    """
    return 3 / (8 * length) + 5 / (8 * half_width)


class FrontFitter:
    """Fits of fronts at n stations, in any number of states.

    Args:
        sectors: nodes around each station.
        weights: (N,) areas that belong to the nodes of the surface.
        deepest: (n,) distances from the reference front as far as which bumps reach.
        depth: (n,) half-widths of the contact along `inward`.
    """

    def __init__(
        self, sectors: Sequence[Sector], weights: Array, deepest: Array, depth: Array
    ) -> None:
        self._count, self._depth = len(sectors), depth
        self._sizes = np.array([sector.size for sector in sectors])
        self._bends = np.array([sector.curvature for sector in sectors])
        self._windows = []
        for spacing in SPACINGS:
            distances = spacing * self._sizes
            bumps = [
                _bumps(sector, weights[sector.nodes], float(distance))
                for sector, distance in zip(sectors, distances, strict=True)
            ]
            self._windows += [
                _window(sectors, bumps, len(weights), deepest, distances, count) for count in COUNTS
            ]

    def fit(
        self, pressure: Array, exponent: Array | float = 0.5, coupled: Sequence[Array] = ()
    ) -> FrontFit:
        """Fronts and K_N, (T, n) each, in T states.

        Args:
            pressure: (T, N) means around the nodes.
            exponent: (T, n) lambda, or one for all.
            coupled: (T, m) pressures around each station, at the nodes of its sector, that are
                taken off before.
        """
        shape = len(pressure), self._count
        exponent = np.broadcast_to(exponent, shape)
        fits = np.full((2, *shape, len(WINDOWS), len(TERMS)), np.nan)
        errors, misfits = np.full_like(fits, np.nan), np.ones_like(fits)
        slopes = np.full(fits.shape[1:], np.nan)
        for number, (stations, matrix) in enumerate(self._windows):
            spacing, count = WINDOWS[number]
            moments = (matrix @ pressure.T).T.reshape(len(pressure), -1, count)
            for row, station in enumerate(stations if len(coupled) else ()):
                own = slice(*matrix.indptr[[row * count, (row + 1) * count]])
                moments[:, row] -= coupled[station] @ matrix.data[own].reshape(count, -1).T
            states, rows = np.nonzero((moments > 0).all(axis=2))
            if not len(rows):
                continue
            at, distances = stations[rows], spacing * self._sizes[stations[rows]]
            # Lengths in spacings so far: those of places, and roots of those of K_N.
            power = exponent[states, at]
            scale = np.array([distances, distances**-power])
            for column, terms in enumerate(TERMS):
                if count >= terms + 2:  # the place and the spread are unknown too
                    bends = self._bends[at] * distances
                    found = _fit(moments[states, rows], bends, power, terms, spacing)
                    fits[:, states, at, number, column] = found.values * scale
                    errors[:, states, at, number, column] = found.errors * scale
                    misfits[:, states, at, number, column] = found.misfit
                    slopes[states, at, number, column] = found.slope / distances
        means, bars, length = _joined(fits, errors, misfits, slopes)
        fits[:, self._too_far(length)] = np.nan
        means, bars, length = _joined(fits, errors, misfits, slopes)
        coarse = COARSE * (self._sizes / np.minimum(length, self._depth)) ** 2 * means[1]
        spread = np.where(np.isfinite(means[1]), np.hypot(bars[1], coarse), np.inf)
        return FrontFit(means[0], bars[0], means[1], spread, length, exponent)

    def _too_far(self, length: Array) -> Bools:
        """(T, n, windows) windows that reach beyond what the series stands for.

        Args:
            length: (T, n) over which K_N makes the pressure, by all windows; that of single
                stations scatters, so the median along the front counts.
        """
        known = np.isfinite(length)
        shared = np.where(known, np.minimum(length, self._depth), np.nan)
        typical = np.full((len(length), 1, 1), np.inf)
        typical[known.any(axis=1), 0, 0] = np.nanmedian(shared[known.any(axis=1)], axis=1)
        reach = np.array([spacing * (count - 1 + REACH) for spacing, count in WINDOWS])
        far = reach * self._sizes[:, None] > CONVERGES * typical
        return np.asarray(far & (reach > SHORTEST))


class Curve(Protocol):
    """Stations of a front, and its fits."""

    frames: Frames
    sectors: tuple[Sector, ...]
    depth: Array
    fits: FrontFitter


def _joined(
    fits: Array, errors: Array, misfits: Array, slopes: Array
) -> tuple[Array, Array, Array]:
    """Means and bars (2, T, n) of places and K_N over windows and orders, and lengths (T, n).

    Args:
        fits: (2, T, n, windows, orders) places and K_N; NaN where there is none.
        errors: (2, T, n, windows, orders) of them.
        misfits: (2, T, n, windows, orders) chi^2 over degrees of freedom.
        slopes: (T, n, windows, orders) c_1/K_N.
    """
    intervals = INTERVALS[:, None, None]
    means, bars, shares = average(fits, errors, np.zeros_like(fits), misfits, intervals)
    # p = K_N sqrt(t) (1 - t/(4 a)) next to the edge of a Hertzian contact.
    slope = np.abs(np.nansum(shares[1] * slopes[..., :-1], axis=(-2, -1)))
    return means, bars, np.divide(0.25, slope, out=np.full_like(slope, np.inf), where=slope > 0)


def _window(
    sectors: Sequence[Sector],
    of_sectors: Sequence[Array],
    size: int,
    deepest: Array,
    distances: Array,
    count: int,
) -> tuple[Indices, csr_array]:
    """(m,) stations that have room for some bumps, and what gives their moments (m count, N)."""
    stations: list[int] = []
    parts, columns = [np.empty(0)], [np.empty(0, dtype=np.int64)]
    lengths = [np.zeros(1, dtype=np.int64)]
    for station, sector in enumerate(sectors):
        if (count - 1 + REACH) * distances[station] > deepest[station]:
            continue
        bumps = _moments(sector, of_sectors[station][:count], float(distances[station]))
        if bumps is not None:
            stations.append(station)
            parts.append(bumps.ravel())
            columns.append(np.tile(sector.nodes, count))
            lengths.append(np.full(count, bumps.shape[1]))
    rows = np.cumsum(np.concatenate(lengths))
    shape = len(stations) * count, size
    matrix = csr_array((np.concatenate(parts), np.concatenate(columns), rows), shape=shape)
    return np.array(stations, dtype=np.int64), matrix


def _bumps(sector: Sector, weights: Array, distance: float) -> Array:
    """(n, m) bumps at 0, 1, 2, ... distances from the reference front, times areas of m nodes."""
    area = weights * sector.fade / distance
    return np.asarray(_bump(sector.s / distance - np.arange(max(COUNTS))[:, None]) * area)


def _moments(sector: Sector, bumps: Array, distance: float) -> Array | None:
    """(count, m) what gives the integrals with each bump over the width of the sector.

    None if the nodes do not sample the bumps (count, m).
    """
    # The width at the reference front.
    width = bumps.sum(axis=1) / (1 - sector.curvature * distance * np.arange(len(bumps)))
    middle = np.median(width)
    if not np.all(np.abs(width - middle) <= SAMPLED * middle) or not middle > 0:
        return None
    return np.asarray(bumps / width[:, None])


def _bump(s: Array) -> Array:
    """Cubic B-spline about 0, of integral 1 and reach 2."""
    s = np.abs(s)
    return np.where(s < 1, 2 / 3 - s**2 + s**3 / 2, np.maximum(2 - s, 0.0) ** 3 / 6)


def _bump_curvature(s: Array) -> Array:
    """Second derivative of `_bump`."""
    s = np.abs(s)
    return np.where(s < 1, 3 * s - 2, np.maximum(2 - s, 0.0))


@dataclass(frozen=True)
class _Fits:
    """Fits to the moments of m stations, lengths in spacings; NaN where there is none.

    Attributes:
        values: (2, m) place and K_N.
        errors: (2, m) their standard errors.
        slope: (m,) c_1/K_N.
        misfit: (m,) chi^2 over degrees of freedom.
    """

    values: Array
    errors: Array
    slope: Array
    misfit: Array


def _fit(moments: Array, curvature: Array, exponent: Array, terms: int, spacing: float) -> _Fits:
    """Fit a series to moments (m, count), curvature of the front and exponent given, (m,) each."""
    sigma = SCATTER / spacing * moments
    sigma[:, :2] *= FIRST / SCATTER
    tables, shares = _shared(exponent)
    place, factor, slope, *errors, rest = _kernels.fit_moments(
        tables, PLACES[0], PLACES[1] - PLACES[0], shares, moments, sigma, curvature, terms,
        FARTHEST, ITERATIONS,
    ).T  # fmt: skip
    found = (np.abs(place) < FARTHEST) & (factor > 0)
    free = moments.shape[1] - terms - 2
    return _Fits(
        values=np.where(found, [place, factor], np.nan),
        errors=np.array(errors),
        slope=slope,
        misfit=rest / free if free else np.ones(len(moments)),
    )


def _shared(exponent: Array) -> tuple[Array, Array]:
    """Tables of moments as of `_tables`, and their shares (m, e) for exponents (m,)."""
    if np.all(exponent == 0.5):
        return _tables((0.5,)), np.ones((len(exponent), 1))
    shares = np.empty((len(exponent), len(EXPONENTS)))
    for number, each in enumerate(EXPONENTS):
        others = np.delete(EXPONENTS, number)
        shares[:, number] = np.prod((exponent[:, None] - others) / (each - others), axis=1)
    return _tables(tuple(EXPONENTS.tolist())), shares


@cache
def _tables(exponents: tuple[float, ...]) -> Array:
    """(e, 4, pieces, bumps, powers + 1) cubic splines over `PLACES`, highest power of places first.

    They are of moments of t^exponent t^k, and last of a spread.
    """
    splines = (CubicSpline(PLACES, _moment_values(exponent)) for exponent in exponents)
    return np.ascontiguousarray([each.c for each in splines])


def _moment_values(exponent: float) -> Array:
    """(p, bumps, powers + 1) moments of all bumps and powers for fronts at `PLACES`.

    Integrals over r with t = r^2, by Gauss's rule.
    """
    powers, bumps = np.arange(max(TERMS) + 1), np.arange(max(COUNTS))
    nodes, gauss = np.polynomial.legendre.leggauss(8)
    # The bumps are polynomials between whole numbers.
    values = np.zeros((len(PLACES), len(bumps), len(powers) + 1))
    for row, place in enumerate(PLACES):
        ends = np.append(place, np.arange(np.floor(place) + 1, max(COUNTS) + REACH + 1))
        roots = np.sqrt(ends - place)
        r = (roots[:-1, None] + np.diff(roots)[:, None] * (nodes + 1) / 2).ravel()
        weight = (np.diff(roots)[:, None] * gauss / 2).ravel()
        s = place + r**2
        shapes = _bump(s - bumps[:, None])
        values[row, :, :-1] = (shapes * weight) @ (
            2 * r[:, None] ** (2 * exponent + 1 + 2 * powers)
        )
        values[row, :, -1] = _bump_curvature(place - bumps)
    return values
