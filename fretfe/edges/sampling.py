# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors of sampled pressures next to an edge: noise, and the error of nodal values.

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

from fretfe._typing import Array
from fretfe.edges.section import Section

ALTERNATING, DECAY, TAIL = 0.8, 0.95, 0.02
# Of the median of the absolute values of normal deviates.
MEDIAN_OF_NORMAL = 0.6745
# Round-off, relative to the largest pressure.
SMALLEST_NOISE = 1e-13


@dataclass(frozen=True)
class Sampling:
    """Errors of the samples of T states.

    Attributes:
        errors: (T, m) standard deviations: noise and error of nodal values.
        tails: (T, m) the part of the latter that has the same sign at all nodes.
        size: (T,) element size h at the front.
    """

    errors: Array
    tails: Array
    size: Array


def sampling(section: Section) -> Sampling:
    """Return the errors of pressures along a section with at least 10 nodes in every state."""
    s, pressure = section.s, section.values
    size = s[:, 4] / 4
    # The edge is half an element outside the outermost node, give or take as much.
    distance = s + size[:, None] / 2
    k_n = np.sqrt(np.median(pressure[:, 3:9] ** 2 / distance[:, 3:9], axis=1))
    relative, scale = distance / size[:, None], (k_n * np.sqrt(size))[:, None]
    tails = scale * TAIL * relative**-1.5
    alternating = scale * ALTERNATING * np.exp(-DECAY * relative)
    errors = np.sqrt(_noise(section)[:, None] ** 2 + alternating**2 + tails**2)
    return Sampling(errors, tails, size)


def _noise(section: Section) -> Array:
    """Return (T,) noise of the samples in the outer half, without three nodes at either end."""
    noise = np.empty(len(section.nodes))
    # States between the same two nodes are seen together.
    _, group = np.unique(
        np.column_stack([section.origin, section.nodes]), axis=0, return_inverse=True
    )
    order = np.argsort(group.ravel(), kind="stable")
    for states in np.split(order, np.flatnonzero(np.diff(group.ravel()[order])) + 1):
        nodes = int(section.nodes[states[0]])
        last = min(nodes - 3, 3 + max((nodes - 6) // 2, 20))
        inside = slice(1, last + 2)
        noise[states] = scatter(section.s[states[0], inside], section.values[states, inside])
    return np.maximum(noise, SMALLEST_NOISE * section.values.max(axis=1))


def scatter(x: Array, values: Array) -> Array:
    """Return (...) standard deviations of the noise in values (..., n) at x (n,), n >= 5.

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
    expected = np.sum(weights * values[..., inner[:, None] + offsets], axis=-1)
    deviation = (values[..., inner] - expected) / np.sqrt(1 + np.sum(weights**2, axis=1))
    return np.asarray(np.median(np.abs(deviation), axis=-1) / MEDIAN_OF_NORMAL)
