# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge position and K_N, from a cubic through the squared pressure next to the edge.

How many of the outermost nodes a fit leaves out, and how far it reaches inward, is varied. Errors
are estimated from the residual; errors of p are taken as equal at all nodes. The fits of all states
and windows are solved together, as stacks of small matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretfe.analytic._arguments import FloatArray, Side, side_sign
from fretfe.edges.consensus import consensus
from fretfe.edges.patches import main_patch

IndexArray = NDArray[np.intp]
EPS = np.finfo(np.float64).eps
# Powers of a cubic.
ORDERS = np.arange(4)


@dataclass(frozen=True)
class EdgeFit:
    """Edge position and K_N (stress over root of length) of the main patch, with spreads.

    Numbers for one pressure, arrays (...) for pressures (..., n).
    """

    position: FloatArray
    k_n: FloatArray
    spread_position: FloatArray
    spread_k_n: FloatArray


def fit_edge(x: FloatArray, p: FloatArray, side: Side) -> EdgeFit:
    """Return edge position and K_N of the main patch; x (n,), p (n,) or many states (..., n).

    p^2 = K_N^2 s + c2 s^2 + c3 s^3 with unknown edge. The window is chosen by the data, so that a
    short square-root zone (rounded edge) and a long one (cylinder) both work.

    Raises:
        ValueError: if nothing is in contact in a state or ``side`` is unknown.
    """
    sign, states = side_sign(side), p.reshape(-1, x.size)
    patches = [main_patch(x, state) for state in states]
    first = np.array([patch.first for patch in patches], dtype=np.intp)
    last = np.array([patch.last for patch in patches], dtype=np.intp)
    outermost = first if sign > 0 else last
    fits = _fit_windows(sign * x, states, outermost, last - first + 1, int(sign))
    score = fits[3] / fits[1]
    position, spread_position = consensus(fits[0], fits[2], score)
    k_n, spread_k_n = consensus(fits[1], fits[3], score)
    results = x[outermost] + sign * position, k_n, spread_position, spread_k_n
    return EdgeFit(*(result.reshape(p.shape[:-1])[()] for result in results))


def _windows(nodes: int) -> list[tuple[int, int]]:
    """Return (drop, length) of all windows: 2 to 5 nodes left out, lengths growing by a third."""
    windows, length = [], 6
    while length + 5 <= nodes:
        windows += [(drop, length) for drop in (2, 3, 4, 5)]
        length = int(np.ceil(1.3 * length))
    return windows


def _fit_windows(
    x: FloatArray, p: FloatArray, outermost: IndexArray, nodes: IndexArray, step: int
) -> FloatArray:
    """Return (4, T, windows) edge from the outermost node, K_N, their standard errors; NaN if none.

    Args:
        x: (n,) positions, increasing inward.
        p: (T, n) pressures.
        outermost: (T,) indices of the outermost nodes in contact.
        nodes: (T,) numbers of nodes in contact.
        step: difference of the indices of a node and the next one inward.
    """
    windows = _windows(int(nodes.max(initial=0)))
    shape = len(p), len(windows)
    # Three nodes more than the window has keep it away from the other edge.
    enough = nodes[:, None] >= np.array([drop + length + 3 for drop, length in windows])
    triangles, ends = np.empty((*shape, 5, 5)), np.empty((*shape, 2))
    for number, (drop, length) in enumerate(windows):
        some = np.flatnonzero(enough[:, number])
        index = outermost[some, None] + step * np.arange(drop, drop + length)
        s = x[index] - x[outermost[some], None]
        triangles[some, number] = _triangles(s, p[some[:, None], index])
        ends[some, number] = s[:, [0, -1]]
    lengths = np.broadcast_to([length for _, length in windows], shape)
    fits = np.full((4, *shape), np.nan)
    fits[:, enough] = _edges(triangles[enough], ends[enough], lengths[enough])
    return fits


def _triangles(s: FloatArray, p: FloatArray) -> FloatArray:
    """Return (m, 5, 5) triangular factors of (1, z, z^2, z^3, p^2)/(2 p), z = s/s_last; (m, l)."""
    z = s / s[:, -1:]
    columns = np.stack([np.ones_like(z), z, z**2, z**3, p**2], axis=-1)
    return np.asarray(np.linalg.qr(columns / (2 * p[..., None]), mode="r"))


def _edges(triangles: FloatArray, ends: FloatArray, nodes: IndexArray) -> FloatArray:
    """Return (4, m) edge, K_N and their standard errors of m cubics through p^2; NaN if none.

    Args:
        triangles: (m, 5, 5) from ``_triangles``.
        ends: (m, 2) distances of first and last node of the window from the outermost node.
        nodes: (m,) numbers of nodes in the windows.
    """
    fits = np.full((4, len(nodes)), np.nan)
    left, singular, right = np.linalg.svd(triangles[:, :4, :4])
    regular = singular[:, 3] > EPS * nodes * singular[:, 0]
    inverse = right[regular].transpose(0, 2, 1) / singular[regular, None, :]
    rotated = left[regular].transpose(0, 2, 1) @ triangles[regular, :4, 4:]
    cubics = (inverse @ rotated)[..., 0]
    start, scale = ends[regular].T
    root = _last_root(cubics, start / scale)
    position, k_n, gradients = _edge_terms(cubics, root, scale)
    deviation = np.abs(triangles[regular, 4, 4]) / np.sqrt(nodes[regular] - 4)
    errors = np.linalg.norm(gradients @ inverse, axis=-1) * deviation[:, None]
    fits[:, regular] = position, k_n, *errors.T
    return fits


def _edge_terms(
    cubics: FloatArray, root: FloatArray, scale: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return edge (m,), K_N (m,), and their gradients (m, 2, 4) with respect to the cubics (m, 4).

    NaN where the root (m,) is NaN or the cubic does not rise there.
    """
    powers = root[:, None] ** ORDERS
    derivatives = ORDERS * root[:, None] ** np.maximum(ORDERS - 1, 0)
    slope = np.sum(cubics * derivatives, axis=1)
    slope = np.where(slope > 0.0, slope, np.nan)
    curvature = 2 * cubics[:, 2] + 6 * cubics[:, 3] * root
    k_n = np.sqrt(slope / scale)
    edge_gradient = -powers / slope[:, None]
    slope_gradient = derivatives + curvature[:, None] * edge_gradient
    gradients = [scale[:, None] * edge_gradient, slope_gradient * (k_n / (2 * slope))[:, None]]
    return root * scale, k_n, np.stack(gradients, axis=1)


def _last_root(cubics: FloatArray, before: FloatArray) -> FloatArray:
    """Return (m,) the last real root before z = ``before`` (m,) of cubics (m, 4) in rising order.

    NaN if there is none after z = -1.
    """
    # A leading coefficient that vanishes exactly has no companion matrix.
    leading = np.where(cubics[:, 3] == 0, EPS * np.abs(cubics).max(axis=1), cubics[:, 3])
    companion = np.zeros((len(cubics), 3, 3))
    companion[:, [0, 1], [1, 2]] = 1.0
    companion[:, :, 0] = -cubics[:, 2::-1] / leading[:, None]
    roots = np.linalg.eigvals(companion)
    suited = (np.abs(roots.imag) < 1e-9) & (roots.real < before[:, None]) & (roots.real >= -1.0)
    root = np.where(suited, roots.real, -np.inf).max(axis=1)
    return np.where(suited.any(axis=1), root, np.nan)
