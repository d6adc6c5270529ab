# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges and K_N where a given gap bends the pressure over less than the windows of polynomials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.gap_fits import GapFits
from fretfe.evaluate.plane.pressure_fit import fit_edge
from fretfe.evaluate.plane.section import main_patch, plane_sections
from fretfe.history.solution import ContactHistory
from fretfe.local.gap_series import GapSeries


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
    found = astuple(_Patches.of(surface.arc, gap, pressure, beside).settled())
    others = (EdgeFit(*edge) for edge in zip(*found[:4], strict=True))
    return tuple(map(_better, fits, others))


def _better(alone: EdgeFit, shaped: EdgeFit) -> EdgeFit:
    """Of each state the fit over S where it contradicts the one alone, or knows more."""
    contradicts = np.abs(shaped.k_n - alone.k_n) > alone.spread_k_n
    chosen = contradicts | (shaped.spread_k_n < alone.spread_k_n)
    parts = zip(astuple(shaped), astuple(alone), strict=True)
    return EdgeFit(*(np.where(chosen, *pair) for pair in parts))


@dataclass(frozen=True)
class _Patches(GapFits):
    """The main patches of T states over a gap, edges (2, T).

    Attributes:
        series: S of them.
    """

    series: GapSeries

    @classmethod
    def of(cls, arc: Array, gap: Array, pressure: Array, beside: Array | None) -> _Patches:
        """Those of pressures (T, N) over a gap (N,) at the nodes."""
        found = [main_patch(arc, state) for state in pressure]
        ends = np.array([(each.first, each.last) for each in found]).T
        nodes = np.arange(arc.size)
        inside = (nodes >= ends[0][:, None]) & (nodes <= ends[1][:, None])
        sizes = np.diff(arc)[np.clip(ends - [[0], [1]], 0, arc.size - 2)]
        whole = pressure if beside is None else np.where(inside, pressure, pressure + beside)
        series = GapSeries.of(arc, gap, inside, whole)
        return cls(arc[ends] + sizes * [[-0.5], [0.5]], sizes, series)

    def others(self, edges: Array, off: Array) -> tuple[Sequence[EdgeFit], Sequence[EdgeFit]]:
        """For patches that are wider, or beside these."""
        return [], [self.fit(edges + off * [[-1.0], [1.0]]), self.fit(edges + off)]

    def moved(self, fit: EdgeFit, edges: Array) -> Array:
        """(2, T) edges as fits have them, not farther off than an element from the nodes."""
        found = np.clip(fit.position, self.edges - self.sizes, self.edges + self.sizes)
        return np.where(np.isfinite(found), found, edges)

    def fit(self, edges: Array, every: int = 1) -> EdgeFit:
        """Fits (2, T) at both edges."""
        found, sections = [], plane_sections(self.series.arc, self.series.pressure)
        for section, edge in zip(sections, edges, strict=True):
            places = section.origin[:, None] + section.inward * np.nan_to_num(section.s)
            shape = self.series.over(edges, np.column_stack([edge, places]), every)
            shape = np.where(np.isnan(section.s), 1.0, shape[:, 1:] / shape[:, :1])
            positive = (shape > 0).all(axis=1)
            fit = fit_edge(section, solved=True, shape=np.where(positive[:, None], shape, 1.0))
            found.append(np.array(astuple(fit)) + np.where(positive, 0.0, np.nan))
        return EdgeFit(*np.stack(found, axis=1))
