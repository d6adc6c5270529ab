# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts and K_N where a given gap bends the pressure over less than the windows of the fits.

Along the line that runs from a station inward the pressure is divided by what half-planes make of
the gap there. Of round fronts that is not quite what half-spaces make of it, but it has what is
short against the contact; the rest is as smooth as the gap.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.gap_fits import GapFits
from fretfe.evaluate.space.pressure_fit import SHORTEST, Curve, FrontFit
from fretfe.history.solution import ContactHistory
from fretfe.local.gap_series import GapSeries


def fit_similar(contact: ContactHistory, curve: Curve, pressure: Array) -> FrontFit:
    """Fits of a front between similar bodies, with what a given gap makes of the pressure.

    Args:
        contact: whose front it is.
        curve: its stations.
        pressure: (T, N) means around the nodes.
    """
    fit, surface = curve.fits.fit(pressure), contact.surface
    added, alone = surface.added_gap, _plain(fit)
    if added is None or surface.dundurs or surface.layer is not None:
        return fit
    chords = _Chords.of(surface.points, added, curve, pressure, fit.place)
    found = _better(alone, chords.settled())
    place, k_n, *bars, _ = astuple(found)
    return replace(fit, place=place, k_n=k_n, place_spread=bars[0], k_n_spread=bars[1])


def _plain(fit: FrontFit) -> EdgeFit:
    return EdgeFit(fit.place, fit.k_n, fit.place_spread, fit.k_n_spread)


def _better(alone: EdgeFit, shaped: EdgeFit) -> EdgeFit:
    """Of each state the fit over S, or the one alone where it knows more.

    What both differ by counts in the bars of the one alone.
    """
    apart = np.abs(np.subtract(astuple(shaped)[:2], astuple(alone)[:2]))
    place, k_n = np.array(astuple(alone)[2:4]) + np.nan_to_num(apart)
    alone = EdgeFit(alone.position, alone.k_n, place, k_n, alone.exponent)
    parts = zip(astuple(shaped), astuple(alone), strict=True)
    return EdgeFit(*(np.where(shaped.spread_k_n < k_n, *pair) for pair in parts))


@dataclass(frozen=True)
class _Chords(GapFits):
    """Lines from n stations through the contact in T states, edges (2, T, n) inward from them.

    Attributes:
        curve: the stations.
        pressure: (T, N) means around the nodes.
        series: (n,) S along each.
    """

    curve: Curve
    pressure: Array
    series: Sequence[GapSeries]

    @classmethod
    def of(
        cls, points: Array, added: Array, curve: Curve, pressure: Array, place: Array
    ) -> _Chords:
        """Those through contacts with pressures (T, N) and fronts at places (T, n).

        Args:
            points: (N, 3) nodes.
            added: (N,) E* times the gap that a case adds there.
            curve: the stations.
            pressure: (T, N) means around the nodes.
            place: (T, n) of the front.
        """
        stations = range(len(curve.sectors))
        pairs = [_along(points, added, curve, pressure, each) for each in stations]
        edges = np.array([ends for _, ends in pairs]).transpose(1, 2, 0)
        sizes = np.array([each.size for each in curve.sectors])
        edges[0] = np.where(np.isfinite(place), place, edges[0])
        edges[1] = np.maximum(edges[1], edges[0] + 3 * sizes)
        return cls(edges, sizes, curve, pressure, [series for series, _ in pairs])

    def others(self, edges: Array, off: Array) -> tuple[Sequence[EdgeFit], Sequence[EdgeFit]]:
        """With means of S around nodes, for contacts half an element wider; for fronts beside."""
        wider = edges + self.sizes / 2 * [[[0.0]], [[1.0]]]
        beside = [self.fit(edges + off * [[[way]], [[0.0]]]) for way in (-1.0, 1.0)]
        return [self.fit(edges, blurred=True), self.fit(wider)], beside

    def moved(self, fit: EdgeFit, edges: Array) -> Array:
        """(2, T, n) edges, the near ones where a fit has them, an element from where they were."""
        near = np.clip(fit.position, self.edges[0] - self.sizes, self.edges[0] + self.sizes)
        return np.array([np.where(np.isfinite(near), near, edges[0]), edges[1]])

    def fit(self, edges: Array, every: int = 1, blurred: bool = False) -> EdgeFit:
        """Fits (T, n), also with S as its mean around each node."""
        off, lost = [], np.zeros(edges.shape[1:])
        for station, sector in enumerate(self.curve.sectors):
            series, own = self.series[station], edges[..., station]
            at = np.column_stack([own[0], np.tile(sector.s, (len(own[0]), 1))])
            shape = series.over(own, at, every)
            if blurred:
                ways = (-sector.size, sector.size)
                shape = (4 * shape + sum(series.over(own, at + way) for way in ways)) / 6
            positive = (shape > 0).all(axis=1)
            lost[~positive, station] = np.nan
            share = np.where(positive[:, None], shape[:, :1] / shape[:, 1:], 1.0)
            off.append((1 - share) * self.pressure[:, sector.nodes])
        fit = _plain(self.curve.fits.fit(self.pressure, coupled=off))
        return EdgeFit(*(each + lost for each in astuple(fit)))


def _along(
    points: Array, added: Array, curve: Curve, pressure: Array, station: int
) -> tuple[GapSeries, Array]:
    """S along the line of a station, and (2, T) the ends of the contact there."""
    # Imported where it is needed: few contacts have a given gap.
    from scipy.interpolate import CloughTocher2DInterpolator, LinearNDInterpolator
    from scipy.spatial import Delaunay

    frames, sector, depth = curve.frames, curve.sectors[station], float(curve.depth[station])
    offset = points - frames.points[station]
    x, y, across = (offset @ each[station] for each in (frames.along, frames.inward, frames.across))
    near = (np.abs(x) <= sector.half_width) & (np.abs(y - depth) <= 4 * depth)
    near &= np.abs(across) <= 4 * depth
    # As long along the front as across it, so that triangles are no slivers.
    mesh = Delaunay(np.column_stack([x[near] * sector.size / sector.along_size, y[near]]))
    ends = y[near].min() / sector.size, y[near].max() / sector.size
    line = sector.size * np.arange(math.ceil(ends[0]), ends[1])
    places = np.column_stack([np.zeros_like(line), line])
    gap = CloughTocher2DInterpolator(mesh, added[near])(places)
    own = np.nan_to_num(LinearNDInterpolator(mesh, pressure[:, near].T)(places).T)
    # Without room around the station nothing is known of S.
    known = np.isfinite(gap) if np.isfinite(gap).sum() > SHORTEST else np.ones(len(gap), dtype=bool)
    line, gap, own = line[known], gap[known], own[:, known]
    inside, sides = _patches(line, own)
    return GapSeries.of(line, gap, inside, own), sides


def _patches(line: Array, pressure: Array) -> tuple[Bools, Array]:
    """(T, M) points in the patches that begin next to 0, and (2, T) their ends."""
    size, pressed = line[1] - line[0], pressure > 0
    begun = np.maximum.accumulate(pressed & (line > -SHORTEST * size), axis=1)
    inside = begun & ~np.maximum.accumulate(begun & ~pressed, axis=1)
    first, last = inside.argmax(axis=1), len(line) - 1 - inside[:, ::-1].argmax(axis=1)
    # Means around nodes reach beyond the contact.
    return inside, np.array([line[first] + size / 2, line[last] - size / 2])
