# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fits of fronts in many states of a solid contact, between similar and unlike bodies."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.analytic.edges import sliding_exponent
from fretfe.evaluate.missing_shear import (
    MissingShear,
    widened,
    without_every_other,
    without_missing,
)
from fretfe.evaluate.space.gap_shape import fit_similar
from fretfe.evaluate.space.pressure_fit import Curve, FrontFit, FrontFitter
from fretfe.history.solution import ContactHistory
from fretfe.history.state_array import blocks

# Elements from the front whose shear over pressure tells which way it slips.
NEXT_TO_FRONT = 2.5
# Nodes of a sector whose distances from the front differ by less than this part of an element make
# one row along it; rows begin so many elements outside the reference front.
ROW = 0.5
BEGIN = 2.0
# Elements from the front in which nothing is known of the shear that is missing: the status of the
# outermost nodes means nothing.
OUTERMOST = 1.0


class _Rows:
    """Rows of nodes along a front, around one station.

    Attributes:
        x: (g,) distances of the rows from the reference front, increasing; the last one is the
            other edge of the contact, where no shear is missing.
    """

    def __init__(self, contact: ContactHistory, curve: Curve, station: int) -> None:
        sector = curve.sectors[station]
        self._size, self._nodes = sector.size, sector.nodes
        self._area = contact.surface.weights[sector.nodes] * sector.fade
        self._inward = contact.surface.frames[sector.nodes, 1:] @ curve.frames.inward[station]
        self._near = sector.s < NEXT_TO_FRONT * sector.size
        order = np.argsort(sector.s, kind="stable")
        self._order = order[sector.s[order] > -BEGIN * sector.size]
        self._starts = _starts(sector.s[self._order], ROW * sector.size)
        self._areas = self._sums(self._area[None])
        x = self._sums((self._area * sector.s)[None])[0] / self._areas[0]
        end = max(2 * float(curve.depth[station]), float(x[-1]) + sector.size)
        self.x = np.append(x, end)
        after = np.clip(np.searchsorted(self.x, sector.s), 1, len(self.x) - 1)
        share = (sector.s - self.x[after - 1]) / (self.x[after] - self.x[after - 1])
        self._after, self._share = after, np.clip(share, 0.0, 1.0)
        self._couple = MissingShear(self.x, contact.surface.dundurs)

    def tractions(self, traction: Array) -> tuple[Array, Array]:
        """(T, m) pressure and inward shear of the nodes, of tractions (T, N, 3)."""
        own = traction[:, self._nodes]
        return own[..., 0], np.einsum("tmd,md->tm", own[..., 1:], self._inward)

    def ratio(self, traction: Array) -> Array:
        """(T,) inward shear over pressure next to the front; 0 without any."""
        pressure, shear = (
            each[:, self._near] @ self._area[self._near] for each in self.tractions(traction)
        )
        return np.divide(shear, pressure, where=pressure > 0, out=np.zeros_like(pressure))

    def missing(self, traction: Array, ratio: Array, place: Array) -> Array:
        """(T, g) shear that is missing to a ratio (T,) times the pressure, mean of each row.

        Args:
            traction: (T, N, 3)
            ratio: (T,) of sliding.
            place: (T,) of the front.
        """
        pressure, shear = self.tractions(traction)
        rows = self._sums((shear - ratio[:, None] * pressure) * self._area) / self._areas
        rows = np.pad(rows, ((0, 0), (0, 1)))
        rows[self.x < place[:, None] + OUTERMOST * self._size] = 0.0
        return rows

    def coarser(self, missing: Array) -> tuple[Array, Array]:
        """The same by every other row, in both ways."""
        return without_every_other(self.x, missing)

    def pressure(self, missing: Array, exponent: Array, place: Array) -> Array:
        """(T, m) pressure at the nodes by missing shear (T, g); exponent and place (T,)."""
        rows = self._couple.pressure(missing, exponent, 1, place)
        after = self._after
        return (1 - self._share) * rows[:, after - 1] + self._share * rows[:, after]

    def _sums(self, values: Array) -> Array:
        """(T, g) sums over rows of values (T, m) at the nodes."""
        return np.add.reduceat(values[:, self._order], self._starts, axis=1)


def _starts(s: Array, width: float) -> Indices:
    """Beginnings of rows in distances (m,) that increase, each row narrower than a width."""
    starts, begin = [], 0
    while begin < len(s):
        starts.append(begin)
        begin = int(np.searchsorted(s, s[begin] + width, side="right"))
    return np.array(starts, dtype=np.int64)


def fit_states(contact: ContactHistory, curve: Curve, states: Indices) -> Array:
    """(k, n, stations) the attributes of fits in n states."""
    stations = range(len(curve.sectors))
    rows = [_Rows(contact, curve, each) for each in stations] if contact.surface.dundurs else []
    parts = []
    for block in blocks(len(states), contact.traction[0].size):
        traction = np.asarray(contact.mean_traction[states[block]])
        if rows:
            fits = _unlike_fit(contact, curve.fits, rows, traction)
        else:
            fits = fit_similar(contact, curve, traction[..., 0])
        parts.append(np.array([*vars(fits).values()]))
    return np.concatenate(parts, axis=1)


def _unlike_fit(
    contact: ContactHistory, fitter: FrontFitter, rows: Sequence[_Rows], traction: Array
) -> FrontFit:
    """Fits at stations between unlike bodies, with exponents by the inward part of the slip.

    Args:
        contact: whose fronts these are.
        fitter: of n stations.
        rows: of the stations.
        traction: (T, N, 3) means around the nodes.
    """
    pressure, limit = traction[..., 0], contact.friction.largest
    ratios = np.clip([each.ratio(traction) for each in rows], -limit, limit)
    exponents = sliding_exponent(contact.surface.dundurs, ratios)
    fit = fitter.fit(pressure, exponents.T)
    missing = [
        each.missing(traction, ratio, place)
        for each, ratio, place in zip(rows, ratios, fit.place.T, strict=True)
    ]

    def refit(known: FrontFit, missing: Sequence[Array]) -> FrontFit:
        coupled = [
            each.pressure(*parts)
            for each, *parts in zip(rows, missing, exponents, known.place.T, strict=True)
        ]
        return fitter.fit(pressure, exponents.T, coupled)

    pairs = [each.coarser(own) for each, own in zip(rows, missing, strict=True)]
    fit, others = without_missing(fit, missing, list(zip(*pairs, strict=True)), refit)
    place = widened(fit.place_spread, fit.place, [each.place for each in others])
    k_n = widened(fit.k_n_spread, fit.k_n, [each.k_n for each in others])
    return replace(fit, place_spread=place, k_n_spread=k_n)
