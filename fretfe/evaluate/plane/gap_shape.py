# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges and K_N where a given gap bends the pressure over less than the windows of polynomials.

On half-planes a patch from m - a to m + a over a gap of the slope g'(m + a z) = sum b_n T_n(z) has,
with r = sqrt(1 - z^2), the pressure (Cauchy integrals of Chebyshev's polynomials)

    p = r S(z),   S = E*/2 (b_1 U_0(z) + b_2 U_1(z) + ...)

Of S the given gap has all but the first two terms, which are those of the force and the moment of
the pressure itself: what other patches, and bodies that are no half-planes, add is smooth. Over S,
less these two terms as a factor, the pressure falls like a root all over the patch, so that the
polynomials of `fit_edge` hold over any window; of a parabola they are what they were. The initial
gap of a mesh takes no part: next to fine edges its slope is round-off of the geometry.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.numerics import SYSTEMATIC, pressure_moments
from fretfe.evaluate.plane.pressure_fit import FEWEST_NODES, fit_edge
from fretfe.evaluate.plane.section import hats, main_patch, plane_sections
from fretfe.history.solution import ContactHistory


def with_gap_shape(
    fits: Sequence[EdgeFit], contact: ContactHistory, pressure: Array, beside: Array | None = None
) -> tuple[EdgeFit, ...]:
    """Fits at both edges, those over S where they contradict the others, or know more.

    Of similar bodies without a layer, over a gap that a case gives.

    Args:
        fits: by polynomials alone.
        contact: of which they are.
        pressure: (T, N) in each state.
        beside: (T, N) of other patches of the pair, if there are any.
    """
    surface, gap = contact.surface, contact.surface.added_gap
    if gap is None or surface.dundurs or surface.layer is not None or not len(pressure):
        return tuple(fits)
    others = _Patches.of(surface.arc, gap, pressure, beside).settled()
    return tuple(map(_better, fits, others))


def _better(alone: EdgeFit, shaped: EdgeFit) -> EdgeFit:
    """Of each state the fit over S where it contradicts the one alone, or knows more."""
    contradicts = np.abs(shaped.k_n - alone.k_n) > alone.spread_k_n
    chosen = contradicts | (shaped.spread_k_n < alone.spread_k_n)
    parts = zip(astuple(shaped), astuple(alone), strict=True)
    return EdgeFit(*(np.where(chosen, *pair) for pair in parts))


@dataclass(frozen=True)
class _Patches:
    """The main patches of T states over a gap.

    Attributes:
        arc: (N,) nodes.
        places: (n,) at which the gap is known.
        gap: (n,) there, times E*.
        pressure: (T, N) of these patches alone.
        beside: (T, N) forces on the nodes of others, over pi/2.
        edges: (2, T) half an element outside of the outermost nodes.
        sizes: (2, T) of the elements there.
        count: of terms of S: that of the nodes in the longest one.
    """

    arc: Array
    places: Array
    gap: Array
    pressure: Array
    beside: Array
    edges: Array
    sizes: Array
    count: int

    @classmethod
    def of(cls, arc: Array, gap: Array, pressure: Array, beside: Array | None) -> _Patches:
        """Those of pressures (T, N) over a gap whose means around the nodes are given."""
        found = [main_patch(arc, state) for state in pressure]
        ends = np.array([(each.first, each.last) for each in found]).T
        nodes = np.arange(arc.size)
        inside = (nodes >= ends[0][:, None]) & (nodes <= ends[1][:, None])
        sizes = np.diff(arc)[np.clip(ends - [[0], [1]], 0, arc.size - 2)]
        edges = arc[ends] + sizes * [[-0.5], [0.5]]
        count = max(int(np.ptp(ends, axis=0).max()) + 1, FEWEST_NODES)
        others = np.where(inside, 0.0, pressure) + (0.0 if beside is None else beside)
        lengths = (np.diff(arc, prepend=arc[0]) + np.diff(arc, append=arc[-1])) / 2
        own = np.where(inside, pressure, 0.0)
        forces = 2 / np.pi * others * lengths
        return cls(arc, *_point_gaps(arc, gap), own, forces, edges, sizes, count)

    def settled(self) -> tuple[EdgeFit, ...]:
        """Fits for the edges that they find, with bars for what S leaves open.

        That is what fits change by if the gap is known at every other node only, and if S is that
        of edges elsewhere by their bars.
        """
        edges = self.edges
        for _ in range(8):
            fits = self.fits(edges)
            edges = self.moved(fits, edges)
        coarser = self.fits(self.moved(self.fits(edges, every=2), edges), every=2)
        off = self.sizes / 8  # smaller steps would see round-off, larger ones other shapes
        wider, beside = self.fits(edges + off * [[-1.0], [1.0]]), self.fits(edges + off)
        rows = zip(fits, coarser, wider, beside, off, strict=True)
        return tuple(_widened(fit, coarse, others, by) for fit, coarse, *others, by in rows)

    def moved(self, fits: Sequence[EdgeFit], edges: Array) -> Array:
        """(2, T) edges as fits have them, not farther off than an element from the nodes."""
        found = np.array([each.position for each in fits])
        found = np.clip(found, self.edges - self.sizes, self.edges + self.sizes)
        return np.where(np.isfinite(found), found, edges)

    def fits(self, edges: Array, every: int = 1) -> tuple[EdgeFit, ...]:
        """Fits at both edges of the pressure over S; unknown where that is not positive.

        Args:
            edges: (2, T) for which S is taken.
            every: the nodes at which the gap is known: all, or every other one.
        """
        middle, half = edges.mean(axis=0), np.ptp(edges, axis=0) / 2
        series = self._series(middle, half, every)
        found = []
        for section, edge in zip(plane_sections(self.arc, self.pressure), edges, strict=True):
            places = section.origin[:, None] + section.inward * np.nan_to_num(section.s)
            z = np.column_stack([edge, places])
            shape = _divided(series, np.clip((z - middle[:, None]) / half[:, None], -1.0, 1.0))
            shape = np.where(np.isnan(section.s), 1.0, shape[:, 1:] / shape[:, :1])
            positive = (shape > 0).all(axis=1)
            fit = fit_edge(section, solved=True, shape=np.where(positive[:, None], shape, 1.0))
            lost = np.where(positive, 0.0, np.nan)
            found.append(EdgeFit(*(each + lost for each in astuple(fit))))
        return tuple(found)

    def _series(self, middle: Array, half: Array, every: int) -> Array:
        """(T, n) coefficients of S, the first two by force and moment of the pressure."""
        angle = np.pi * (np.arange(self.count) + 0.5) / self.count
        at = middle[:, None] + half[:, None] * np.cos(angle)
        slopes = self._slopes(at, every)
        for state in np.flatnonzero(self.beside.any(axis=1)):
            nodes = np.flatnonzero(self.beside[state])
            slopes[state] -= 1 / (at[state, :, None] - self.arc[nodes]) @ self.beside[state, nodes]
        orders = np.arange(1, self.count)
        series = np.asarray(slopes @ np.cos(angle[:, None] * orders)) / self.count
        moment = pressure_moments(self.arc, self.pressure, middle)
        series[:, 0] = 2 / np.pi * np.trapezoid(self.pressure, self.arc, axis=1) / half
        series[:, 1] = 4 / np.pi * moment / half**2
        return series

    def _slopes(self, at: Array, every: int) -> Array:
        """Slopes of the gap at some places, by a cubic spline through what it is at nodes."""
        near = np.abs(self.places - (at.min() + at.max()) / 2) < 2 * np.ptp(at)
        x, values = self.places[near][::every], self.gap[near][::every]
        h, rise = np.diff(x), np.diff(values) / np.diff(x)
        matrix = np.diag(2 * (h[:-1] + h[1:])) + np.diag(h[1:-1], 1) + np.diag(h[1:-1], -1)
        bent = np.pad(np.linalg.solve(matrix, 6 * np.diff(rise)), 1)
        piece = np.clip(np.searchsorted(x, at) - 1, 0, len(h) - 1)
        s = (at - x[piece]) / h[piece]
        ends = (3 * s**2 - 1) * bent[piece + 1] - (3 * (1 - s) ** 2 - 1) * bent[piece]
        return np.asarray(rise[piece] + h[piece] / 6 * ends)


def _point_gaps(arc: Array, gap: Array) -> tuple[Array, Array]:
    """(n,) places, and a gap there whose means over the hats of the nodes (N,) are given."""
    places, variances = (each[1:-1] for each in hats(arc))
    bent = np.gradient(np.gradient(gap[1:-1], places), places)
    return places, gap[1:-1] - variances / 2 * bent


def _divided(series: Array, z: Array) -> Array:
    """(T, m) sums of a series (T, n) of U at z (T, m), over their first two terms."""
    last = before = np.zeros_like(z)
    for column in series.T[::-1]:  # Clenshaw
        last, before = column[:, None] + 2 * z * last - before, last
    return np.asarray(last / (series[:, :1] + 2 * z * series[:, 1:2]))


def _widened(fit: EdgeFit, coarse: EdgeFit, others: Sequence[EdgeFit], off: Array) -> EdgeFit:
    """A fit with bars that hold what it changes by.

    Args:
        fit: for the edges that it finds.
        coarse: from the gap at every other node.
        others: for edges that are a little off.
        off: (T,) by how much; a part of that moves the edge on, and that once more.
    """
    on = np.max([np.abs(each.position - fit.position) for each in others], axis=0)
    more = np.divide(off, off - on, out=np.full_like(off, np.nan), where=on < off)
    by_edges = np.max([np.abs(each.k_n - fit.k_n) for each in others], axis=0)
    finer = SYSTEMATIC * np.abs(np.subtract(astuple(coarse)[:2], astuple(fit)[:2]))
    place = (fit.spread_position + finer[0]) * more
    k_n = fit.spread_k_n + finer[1] + by_edges * place / off
    bars = [np.nan_to_num(each, nan=np.inf) for each in (place, k_n)]
    return EdgeFit(fit.position, fit.k_n, *bars)
