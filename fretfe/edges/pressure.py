# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge position and K_N, from polynomials through the squared pressure next to the edge.

p^2 = K_N^2 s + c2 s^2 + ... with unknown edge is fitted in p, by weighted least squares, over
windows of many lengths and in several orders; ``average`` joins the fits. The weights hold the
noise of the samples and the error that nodal values have next to an edge (``sampling``), so that
no node but the outermost has to be left out. The fits of all states are solved together, as stacks
of small matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Positions
from fretfe.edges.average import average
from fretfe.edges.polynomials import FARTHEST, HIGHEST, edge_terms, weighted_triangles
from fretfe.edges.sampling import sampling
from fretfe.edges.section import Section

# Nodes between a window and the far edge.
FAR = 3
# Nodes in the shortest window: two orders, to compare, with two nodes more than unknowns.
SHORTEST = 6
FEWEST_NODES = 1 + SHORTEST + FAR
# What windows of few nodes hide, times the square of their number: relative error of K_N, and error
# of the edge in elements. From finite elements with 12 to 100 elements over the rounded part.
COARSE_K_N, COARSE_POSITION = 4.0, 12.0

# Half-width of the 95 % interval over the estimated error, of the edge and of K_N. The edge depends
# on the outermost nodes, whose error is rather assumed too large.
INTERVALS = np.array([[1.33], [1.72]])


@dataclass(frozen=True)
class EdgeFit:
    """Position along the arc and K_N (stress over root of length), with error bars; (T,) each.

    A spread is half the width of an interval that is meant to hold the truth with 95 %.
    """

    position: Array
    k_n: Array
    spread_position: Array
    spread_k_n: Array


def fit_edge(section: Section) -> EdgeFit:
    """Return the position of the edge and K_N from the pressures of T states along a section.

    Windows and orders are weighted by the data, so that a short square-root zone (rounded edge) and
    a long one (cylinder) both work. NaN, with infinite spreads, if fewer than ``FEWEST_NODES`` are
    in contact or the pressure does not fall to zero like a root.
    """
    results = np.tile([[np.nan], [np.nan], [np.inf], [np.inf]], len(section.nodes))
    enough = np.flatnonzero(section.nodes >= FEWEST_NODES)
    if enough.size:
        results[:, enough] = _fit(section.of_states(enough))
    results[0] = section.place(results[0])
    return EdgeFit(*results)


def _fit(section: Section) -> Array:
    """Return (4, T): edge, inward from the outermost node, K_N and their error bars."""
    samples = sampling(section)
    reach = np.maximum(section.nodes // 2, np.minimum(section.nodes - FAR, SHORTEST + 1))
    lengths = _lengths(int(reach.max()) - 1)
    # Edge and K_N, their standard errors, their systematic errors, chi^2/nu.
    fits = np.full((7, len(reach), len(lengths), HIGHEST - 1), np.nan)
    windows, states = np.nonzero(lengths[:, None] < reach)
    parts = (section.s, section.values, samples.errors, samples.tails)
    triangles = np.concatenate(
        [
            weighted_triangles(*(part[states[windows == number], 1 : 1 + nodes] for part in parts))
            for number, nodes in enumerate(lengths)
        ]
    )
    length = lengths[windows]
    scale = section.s[states, length]
    bounds = np.array([-FARTHEST * samples.size, section.s[:, 1]])[:, states]
    for order in range(2, HIGHEST + 1):
        enough = np.flatnonzero(length >= order + 3)
        terms = edge_terms(
            triangles[enough], order, length[enough], scale[enough], bounds[:, enough]
        )
        fits[:, states[enough], windows[enough], order - 2] = terms
    means, bars, weights = average(fits[:2], fits[2:4], fits[4:6], fits[6], INTERVALS)
    used = np.sum(weights * lengths[:, None], axis=(-2, -1))
    used = np.maximum(used, 1.0)  # 0 without a fit
    coarse = np.array([COARSE_POSITION * samples.size, COARSE_K_N * means[1]]) / used**2
    results = np.concatenate([means, np.hypot(bars, coarse)])
    for state in np.flatnonzero(np.isnan(means).any(axis=0)):
        results[:, state] = _without_comparison(fits[:2, state], samples.size[state])
    return results


def _without_comparison(fits: Array, size: float) -> Array:
    """Return edge, K_N and bars if no two orders fit one window; fits (2, windows, orders).

    The medians of what there is, with bars that say not to rely on it; NaN if there is nothing.
    """
    known = np.isfinite(fits).all(axis=0)
    if not known.any():
        return np.array([np.nan, np.nan, np.inf, np.inf])
    position, k_n = np.median(fits[:, known], axis=1)
    return np.array([position, k_n, FARTHEST * size, k_n])


def _lengths(longest: int) -> Positions:
    """Return the numbers of nodes of all windows, growing by a quarter."""
    lengths = [SHORTEST]
    while (length := int(np.ceil(1.25 * lengths[-1]))) <= longest:
        lengths.append(length)
    return np.array(lengths)
