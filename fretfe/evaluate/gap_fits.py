# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fits of edges over what a given gap makes of the pressure, for the edges that they find."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.numerics import SYSTEMATIC


@dataclass(frozen=True)
class GapFits(ABC):
    """Patches over a gap, whose pressure over S of `GapSeries` is fitted.

    Attributes:
        edges: (2, ...) of the patches, as far as they are known without fits.
        sizes: of the elements there, to be multiplied with the edges.
    """

    edges: Array
    sizes: Array

    @abstractmethod
    def fit(self, edges: Array, every: int = 1) -> EdgeFit:
        """Fits, unknown where S is not positive.

        Args:
            edges: for which S is taken.
            every: the nodes at which the gap is known: all, or every other one.
        """

    @abstractmethod
    def moved(self, fit: EdgeFit, edges: Array) -> Array:
        """Edges where a fit has them."""

    @abstractmethod
    def others(self, edges: Array, off: Array) -> tuple[Sequence[EdgeFit], Sequence[EdgeFit]]:
        """Fits from less that is known, and for edges that are a little off."""

    def settled(self) -> EdgeFit:
        """Fits for the edges that they find, with bars for what S leaves open.

        That is what fits change by if the gap is known at every other node only, if other things
        are less known, and if S is that of edges elsewhere by their bars.
        """
        edges = self.edges
        for _ in range(8):
            fit = self.fit(edges)
            edges = self.moved(fit, edges)
        coarser = self.fit(self.moved(self.fit(edges, every=2), edges), every=2)
        off = self.sizes / 8  # smaller steps would see round-off, larger ones other shapes
        vaguer, beside = self.others(edges, off)
        return _widened(fit, [coarser, *vaguer], beside, np.broadcast_to(off, fit.k_n.shape))


def _widened(
    fit: EdgeFit, vaguer: Sequence[EdgeFit], others: Sequence[EdgeFit], off: Array
) -> EdgeFit:
    """A fit with bars that hold what it changes by.

    Args:
        fit: for the edges that it finds.
        vaguer: from less that is known: from the gap at every other node.
        others: for edges that are a little off.
        off: by how much; a part of that moves the edge on, and that once more.
    """
    on = np.max([np.abs(each.position - fit.position) for each in others], axis=0)
    more = np.divide(off, off - on, out=np.full(on.shape, np.nan), where=on < off)
    by_edges = np.max([np.abs(each.k_n - fit.k_n) for each in others], axis=0)
    changes = [np.abs(np.subtract(astuple(each)[:2], astuple(fit)[:2])) for each in vaguer]
    finer = SYSTEMATIC * np.sum(changes, axis=0)
    place = (fit.spread_position + finer[0]) * more
    k_n = fit.spread_k_n + finer[1] + by_edges * place / off
    bars = [np.nan_to_num(each, nan=np.inf) for each in (place, k_n)]
    return EdgeFit(fit.position, fit.k_n, *bars)
