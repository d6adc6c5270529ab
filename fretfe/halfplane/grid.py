# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodes on the surface of a half-plane, graded towards the contact edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array

# The grid ends this fraction of the contact outside its edges, which leaves room for errors of the
# edges; the outermost nodes carry no traction.
MARGIN = 0.01
# Elements at an edge are this much smaller than elements a governing length away from it.
FINEST = 0.05
# An edge that travels gets at least this many times its travel resolved like the edge itself.
TRAVEL = 1 / 3
SAMPLES = 20_001


@dataclass(frozen=True)
class EdgeRange:
    """Range of positions of one edge under the loads that the grid resolves.

    Attributes:
        low, high: extreme positions.
        length: distance over which the pressure changes near the edge: the half-width, or the
            rounded part.
    """

    low: float
    high: float
    length: float

    def size(self, x: Array) -> Array:
        """Relative element size at x, by its distance to the range.

        Grows with the square root of the distance, as the tractions do, and from the governing
        length on with the distance itself.
        """
        distance = np.maximum(np.maximum(self.low - x, x - self.high), 0.0)
        finest = max(FINEST * self.length, TRAVEL * (self.high - self.low))
        near = np.sqrt(distance * self.length + finest**2) / self.length
        return np.where(distance > self.length, (1 + distance / self.length) / 2, near)


def graded_grid(
    edges: tuple[EdgeRange, EdgeRange], reach: tuple[float, float], kinks: Array, elements: int
) -> Array:
    """(elements + 1,) increasing nodes from the left end of the reach to the right one.

    Args:
        edges: left and right edge.
        reach: largest extent of the contact in the whole history.
        kinks: positions that get a node: those where the profile is not smooth.
        elements: number of elements.
    """
    margin = MARGIN * (reach[1] - reach[0]) / 2
    x = np.linspace(reach[0] - margin, reach[1] + margin, SAMPLES)
    density = 1 / np.minimum(edges[0].size(x), edges[1].size(x))
    cumulative = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    nodes = np.interp(np.linspace(0.0, cumulative[-1], elements + 1), cumulative, x)
    nodes = (nodes - nodes[::-1]) / 2 if np.allclose(x, -x[::-1]) else nodes
    for kink in kinks[(kinks > nodes[1]) & (kinks < nodes[-2])]:
        nodes[np.argmin(np.abs(nodes - kink))] = kink
    return nodes
