# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane problems of many edges, those that want elements of about the same size together."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Indices
from fretfe.local.half_planes import half_planes
from fretfe.local.problem import EdgeHistories, EdgeSlip, March

# Elements over the smallest zone that is to be resolved, and the finest and coarsest over the
# half-width.
PER_ZONE = 20
FINEST = 2e-4
COARSEST = 0.03
# Edges travel at most so many of the finest elements.
TRAVEL = 40
# Edges that are marched together at most: with more all wait for the slowest, on other ranks too.
TOGETHER = 6
# Nodes of a grid behind those that an edge travels over: their elements grow.
GROWN = 35


@dataclass(frozen=True)
class Batch:
    """Edges that are marched together: what one rank does at a time.

    Attributes:
        edges: (k,) their numbers.
        histories: theirs.
        finest: element size over the half-width.
        travel: of the edges over the half-width.
    """

    edges: Indices
    histories: EdgeHistories
    finest: float
    travel: float

    @property
    def work(self) -> float:
        """Cost in no unit, to compare batches: about the square of the nodes of an edge."""
        return len(self.edges) * (self.travel / self.finest + GROWN) ** 2

    def solve(self) -> list[EdgeSlip]:
        """The solutions, in the order of the edges."""
        whole = self.histories.dundurs != 0
        return March(self.histories, half_planes(self.finest, self.travel, whole=whole)).solve()


# Does some batches, on one rank or on many, and gives their results in the same order.
Share = Callable[[Sequence[Batch]], "list[list[EdgeSlip]]"]


def solve_batches(batches: Sequence[Batch]) -> list[list[EdgeSlip]]:
    """Solve batches one after the other."""
    return [batch.solve() for batch in batches]


def solve_edges(histories: EdgeHistories, share: Share = solve_batches) -> list[EdgeSlip]:
    """Solve the plane problems of all edges.

    Args:
        histories: theirs.
        share: has the parts solved.
    """
    batches = _batches(histories)
    found: dict[int, EdgeSlip] = {}
    for batch, solved in zip(batches, share(batches), strict=True):
        found.update(zip(batch.edges.tolist(), solved, strict=True))
    return [found[edge] for edge in range(len(histories.k))]


def _batches(histories: EdgeHistories) -> list[Batch]:
    """Edges that want about the same grid, in groups."""
    widths = histories.contacts.widths(histories.k_i)
    first, last = histories.cycle or (0, widths.shape[1] - 1)
    outermost = histories.outermost
    nearest = widths[:, first : last + 1].min(axis=1) * (1 - histories.shift)
    travel = (outermost - nearest) / outermost
    wanted = np.clip(histories.zone / outermost / PER_ZONE, FINEST, COARSEST)
    wanted = np.maximum(wanted, travel / TRAVEL)
    finest = 2.0 ** np.floor(np.log2(wanted))
    travel = finest * 2.0 ** np.ceil(np.log2(np.maximum(travel / finest, 1.0)))
    keys, which = np.unique(np.column_stack([finest, travel]), axis=0, return_inverse=True)
    batches = []
    for number, (size, way) in enumerate(keys.tolist()):
        edges = np.flatnonzero(which.ravel() == number)
        for part in np.array_split(edges, math.ceil(len(edges) / TOGETHER)):
            batches.append(Batch(part, histories.of(part), size, way))
    return batches
