# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is wrong with sampled pressures next to an edge: noise, and the error of nodal values.

Noise is estimated from the scatter of the samples. Nodal values of piecewise-linear pressures, with
elements of size h, alternate about the true one next to the edge by

    K_N sqrt(h) ALTERNATING exp(-DECAY s/h)

at most, and deviate farther inside by K_N sqrt(h) TAIL (h/s)^1.5: measured against closed forms on
half-planes and finite elements of order 1 and 2, with 12 to 100 elements over the rounded part and
edges anywhere between two nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Positions
from fretfe.analytic._arguments import Side, side_sign

ALTERNATING, DECAY, TAIL = 0.8, 0.95, 0.02
# Of the median of the absolute values of normal deviates.
MEDIAN_OF_NORMAL = 0.6745
# Round-off, relative to the largest pressure.
SMALLEST_NOISE = 1e-13


@dataclass(frozen=True)
class Sampling:
    """Samples of T states, counted inward from the outermost node in contact.

    Attributes:
        s: (T, m) distances from the outermost node; NaN behind the last node in contact.
        p: (T, m) pressures.
        errors: (T, m) standard deviations: noise and error of nodal values.
        tails: (T, m) the part of the latter that has the same sign at all nodes.
        size: (T,) element size h at the edge.
        nodes: (T,) numbers of nodes in contact.
    """

    s: Array
    p: Array
    errors: Array
    tails: Array
    size: Array
    nodes: Positions


def sampling(x: Array, p: Array, first: Positions, last: Positions, side: Side) -> Sampling:
    """Return the samples of each main patch with their errors.

    Args:
        x: (n,) positions, increasing.
        p: (T, n) pressures.
        first: (T,) first node in contact.
        last: (T,) last node in contact, at least 9 nodes further.
        side: of the edge.
    """
    nodes, sign = last - first + 1, side_sign(side)
    count = np.arange(nodes.max())
    outermost = (first if sign > 0 else last)[:, None]
    index = outermost + int(sign) * np.minimum(count, nodes[:, None] - 1)
    s = np.where(count < nodes[:, None], sign * (x[index] - x[outermost]), np.nan)
    pressure = np.take_along_axis(p, index, axis=1)
    size = s[:, 4] / 4
    # The edge is half an element outside the outermost node, give or take as much.
    distance = s + size[:, None] / 2
    k_n = np.sqrt(np.median(pressure[:, 3:9] ** 2 / distance[:, 3:9], axis=1))
    relative, scale = distance / size[:, None], (k_n * np.sqrt(size))[:, None]
    tails = scale * TAIL * relative**-1.5
    alternating = scale * ALTERNATING * np.exp(-DECAY * relative)
    noise = [_noise(*each) for each in zip(s, pressure, nodes, strict=True)]
    errors = np.sqrt(np.square(noise)[:, None] + alternating**2 + tails**2)
    return Sampling(s, pressure, errors, tails, size, nodes)


def _noise(s: Array, p: Array, nodes: int) -> float:
    """Return the noise of the samples (m,) in the outer half, without three nodes at either end."""
    last = min(nodes - 3, 3 + max((nodes - 6) // 2, 20))
    return max(scatter(s[1 : last + 2], p[1 : last + 2]), SMALLEST_NOISE * float(np.max(p)))


def scatter(x: Array, values: Array) -> float:
    """Return the standard deviation of the noise in values at x; both (n,), n >= 5.

    From the deviation of each value from the cubic through its four neighbours. The median of all
    counts, so that kinks do not.
    """
    inner, offsets = np.arange(2, x.size - 2), np.array([-2, -1, 1, 2])
    around = x[inner[:, None] + offsets]
    weights = np.ones_like(around)
    for i in range(4):
        for j in range(4):
            if j != i:
                weights[:, i] *= (x[inner] - around[:, j]) / (around[:, i] - around[:, j])
    expected = np.sum(weights * values[inner[:, None] + offsets], axis=1)
    deviation = (values[inner] - expected) / np.sqrt(1 + np.sum(weights**2, axis=1))
    return float(np.median(np.abs(deviation))) / MEDIAN_OF_NORMAL
