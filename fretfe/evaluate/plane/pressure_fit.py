# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge position and K_N, from polynomials through the squared pressure next to the edge.

p^2 = K_N^2 s + c2 s^2 + ... with unknown edge is fitted in p, by weighted least squares, over
windows of many lengths and in several orders; ``average`` joins the fits. The fits of all states
are solved together, as stacks of small matrices.

The weights hold the noise of the samples, estimated from their scatter, and the error that nodal
values have next to an edge, so that no node but the outermost has to be left out. Nodal values of
piecewise-linear pressures, with elements of size h, alternate about the true one next to the edge
by

    K_N sqrt(h) ALTERNATING exp(-DECAY s/h)

at most, and deviate farther inside by K_N sqrt(h) TAIL (h/s)^1.5: measured against closed forms on
half-planes and finite elements of order 1 and 2, with 12 to 100 elements over the rounded part and
edges anywhere between two nodes. Pressures out of a solver are put right by h^2 p''/12 first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Positions
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.edge_zone import WANTED_TO_PEAK
from fretfe.evaluate.numerics import FARTHEST, HIGHEST, average, edge_terms, weighted_triangles
from fretfe.evaluate.plane.section import Patch, PlaneFront, Section
from fretfe.reason import Kind, Reason

ALTERNATING = 0.8
DECAY = 0.95
TAIL = 0.02
# Of the median of the absolute values of normal deviates.
MEDIAN_OF_NORMAL = 0.6745
# Round-off, relative to the largest pressure.
SMALLEST_NOISE = 1e-13
# Nodes between a window and the far edge.
FAR = 3
# Nodes in the shortest window: two orders, to compare, with two nodes more than unknowns.
SHORTEST = 6
FEWEST_NODES = 1 + SHORTEST + FAR
# What a rise of the pressure over few elements hides, times the square of their number: relative
# error of K_N, and error of the edge in elements. From finite elements with 5 to 100 elements over
# the rounded part.
COARSE_K_N = 2.0
COARSE_POSITION = 5.0
# The rise ends where the pressure has this part of its largest value on the same side.
RISEN = 0.9
# If the lowest orders over the longest window give the same K_N as all fits but for SMOOTH, even a
# rise over few elements hides little: SMOOTHEST of the above at least. From 300 half-planes and 60
# contacts of finite elements: .02 and .04 are needed where they differ by less than .1 %.
SMOOTH = 0.06
SMOOTHEST = 0.05
# Elements that are so many times as long in the mean of the rise as at the edge grow inward; what
# they hide at least is that times this as much. Measured on half-planes whose edges move.
UNEVEN = 1.3
GRADED = 2.7
# Fits that disagree over few elements hardly know how well they know anything: a relative error of
# K_N of a DOUBTFUL-th of the number of elements of the rise doubles it. The edge never is off by
# many elements: its bar becomes so many times as large at most.
DOUBTFUL = 12.0
LARGEST_DOUBT = np.array([[1.5], [np.inf]])

# Half-width of the 95 % interval over the estimated error, of the edge and of K_N. The edge depends
# on the outermost nodes, whose error is rather assumed too large.
INTERVALS = np.array([[1.33], [1.72]])
# What that becomes, as a factor, for pressures out of a solver, which have no noise: the errors of
# windows and orders, whose scatter counts in full, largely cancel in the mean, unless the longest
# window is far off.
OFF = (0.05, 0.25)
SOLVED = (0.5, 1.25)


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


def _point_values(section: Section) -> Array:
    """Return (T, m) what the pressure is at the nodes, from the best piecewise-linear one.

    That has the means of the true one around each node, as a Galerkin solution against a smooth
    kernel has, and so differs from it at a node by -p'' (a^2 - ab + b^2)/12, a and b the sizes on
    both sides; h^2 p''/12 for equal ones.
    """
    s, p = section.s, section.values
    a, b = np.diff(s)[:, :-1], np.diff(s)[:, 1:]
    slopes = np.diff(p) / np.diff(s)
    bent = 2 * np.diff(slopes) / (a + b)
    known = p.copy()
    known[:, 1:-1] += np.nan_to_num(bent * (a**2 - a * b + b**2) / 12)
    return np.maximum(known, 0.0)


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


def fit_edge(
    section: Section,
    *,
    solved: bool = False,
    exponent: Array | float = 0.5,
    shape: Array | float = 1.0,
) -> EdgeFit:
    """Return the position of the edge and K_N from the pressures of T states along a section.

    Windows and orders are weighted by the data, so that a short square-root zone (rounded edge) and
    a long one (cylinder) both work. NaN, with infinite spreads, if fewer than ``FEWEST_NODES`` are
    in contact or the pressure does not fall to zero like a root.

    Args:
        section: the pressures.
        solved: whether they come out of a solver, without noise.
        exponent: (T,) or one for all: lambda of p ~ s^lambda. What is fitted is p^(1/(2 lambda)),
            which falls like a root.
        shape: (T, m) factor that the pressure has besides, positive, and 1 at the edge.
    """
    double = 2 * np.broadcast_to(exponent, section.nodes.shape)
    power = 1 / double[:, None]
    values = ((_point_values(section) if solved else section.values) / shape) ** power
    section = replace(section, values=(section.values / shape) ** power)
    results = np.tile([[np.nan], [np.nan], [np.inf], [np.inf]], len(section.nodes))
    enough = np.flatnonzero(section.nodes >= FEWEST_NODES)
    if enough.size:
        results[:, enough] = _fit(section.of_states(enough), values[enough], solved)
    results[0] = section.place(results[0])
    root, spread = results[[1, 3]]
    results[1] = root**double
    results[3] = spread * double * root ** (double - 1)
    position, k_n, spread_position, spread_k_n = results
    return EdgeFit(position, k_n, spread_position, spread_k_n, double / 2)


def _fit(section: Section, values: Array, solved: bool) -> Array:
    """Return (4, T): edge, inward from the outermost node, K_N and their error bars.

    Args:
        section: whose values tell the noise.
        values: (T, m) what is fitted.
        solved: as of `fit_edge`.
    """
    samples = sampling(section)
    reach = np.maximum(section.nodes // 2, np.minimum(section.nodes - FAR, SHORTEST + 1))
    lengths = _lengths(int(reach.max()) - 1)
    # Edge and K_N, their standard errors, their systematic errors, chi^2/nu.
    fits = np.full((7, len(reach), len(lengths), HIGHEST - 1), np.nan)
    windows, states = np.nonzero(lengths[:, None] < reach)
    parts = (section.s, values, samples.errors, samples.tails)
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
    means, bars, _ = average(fits[:2], fits[2:4], fits[4:6], fits[6], INTERVALS)
    off = _longest_off(fits[1], means[1])
    bars *= np.interp(off, OFF, SOLVED) if solved else 1.0
    rise, graded = _rise(section)
    hidden = COARSE_K_N * means[1] * np.clip(off / SMOOTH, SMOOTHEST * graded, 1.0)
    bars = np.hypot(bars, np.array([COARSE_POSITION * samples.size, hidden]) / rise**2)
    doubt = 1 + DOUBTFUL * bars[1] / (rise * means[1])
    results = np.concatenate([means, bars * np.minimum(doubt, LARGEST_DOUBT)])
    for state in np.flatnonzero(np.isnan(means).any(axis=0)):
        results[:, state] = _without_comparison(fits[:2, state], samples.size[state])
    return results


def _rise(section: Section) -> tuple[Array, Array]:
    """Return (T,) the elements over which the pressure rises to next to its largest value.

    From the outermost node to RISEN of the largest pressure up to the middle, one at least. Where
    elements grow inward their number counts, not that of the smallest ones over the same length.
    The second is (T,) what SMOOTHEST is multiplied by.
    """
    outer = np.arange(section.values.shape[1]) <= section.nodes[:, None] // 2
    values = np.where(outer, section.values, 0.0)
    risen = np.argmax(values >= RISEN * values.max(axis=1, keepdims=True), axis=1)
    risen = np.maximum(risen, 1)
    length = np.take_along_axis(section.s, risen[:, None], 1)[:, 0]
    growth = length / (risen * section.s[:, 4] / 4)
    return risen.astype(float), np.where(growth > UNEVEN, GRADED * growth, 1.0)


def _longest_off(k_n: Array, mean: Array) -> Array:
    """Return (T,) how far K_N by the lowest orders over the longest window is off the mean.

    Args:
        k_n: (T, windows, orders) by all fits; NaN where there is none.
        mean: (T,) of them.
    """
    known = np.isfinite(k_n[..., :2])
    longest = known.shape[1] - 1 - np.argmax(known[:, ::-1], axis=1, keepdims=True)
    ends = np.take_along_axis(k_n[..., :2], longest, axis=1)[:, 0]
    return np.where(known.any(axis=1), np.abs(ends / mean[:, None] - 1), np.inf).max(axis=1)


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


def why_no_root(x: Array, pressure: Array, patch: Patch, front: PlaneFront) -> Reason:
    """Reason why the pressure next to an edge has no fit.

    Args:
        x: (n,) nodes, increasing.
        pressure: (n,) there.
        patch: that the edge belongs to.
        front: on which side of it.
    """
    outermost = front.outermost(patch)
    if front.from_front(np.arange(len(x)))[0] == outermost:
        return Reason(Kind.SURFACE_ENDS)
    # In contact from the edge to the largest pressure on its side of the patch.
    inward = front.from_front(pressure[patch.first : patch.last + 1])
    nodes = int(np.argmax(inward[: (len(inward) + 1) // 2])) + 1
    return Reason(Kind.STEEP if nodes < WANTED_TO_PEAK else Kind.NO_ROOT, nodes, WANTED_TO_PEAK)
