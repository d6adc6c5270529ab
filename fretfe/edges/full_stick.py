# SPDX-License-Identifier: LGPL-3.0-or-later
"""Singular edge terms of increments of full stick, which give K_T and K_I."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array, Positions
from fretfe.analytic._arguments import check_positive, check_range
from fretfe.edges.consensus import consensus
from fretfe.edges.series import Increments, fit_series, increments, singular_terms, windows

# Distance, in elements, of the effective edge of an increment of full stick from the outermost node
# in contact, outward, per displacement degree. Measured on half-planes with matching meshes, four
# gradings, two sizes: .56 to .59 and .90 to 1.05.
OVERHANG = {1: 0.98, 2: 0.57}
# The same of an exact Galerkin solution, without any displacement degree.
GALERKIN_OVERHANG = 0.53
OVERHANG_UNCERTAINTY = 0.05
# Bound of the search; GALERKIN_OVERHANG, and more for finite elements.
LARGEST_OVERHANG = 1.6


@dataclass(frozen=True)
class FullStickFit:
    """Edge term k (1 + beta s)/sqrt(s) of increments of full stick, with the sign of the traction.

    For the edge that was passed; ``spread`` is the uncertainty of ``k``. Numbers for one increment
    and one pair of edges, else arrays.
    """

    k: Array
    beta: Array
    spread: Array


def full_stick_factors(
    x: Array, q: Array, edges: ArrayLike, overhang: float
) -> tuple[FullStickFit, FullStickFit]:
    """Return the singular edge terms at both ends of a section through the whole contact.

    The cumulative force is fitted (``series``) with up to 14 terms; the error of a fit is what the
    next two orders change, and the spread holds the effect of OVERHANG_UNCERTAINTY too. At least
    16 nodes must be in contact. Results have the shape of all states, then all increments. The sign
    of K_T and K_S is that of k along the vectors of the station's frame.

    Args:
        x: (n,) positions along the section, increasing.
        q: (n,) increment of a component of the shear, or of the pressure (which gives K_I), not
            zero in contact; or (..., n) increments on the same contact area.
        edges: (2,) true places of the first and the last end, from ``fit_edge``; or (..., 2) those
            of many states.
        overhang: distance of the effective edges of the discrete increment from the outermost nodes
            in contact, in elements: OVERHANG of the displacement degree.

    Raises:
        ValueError: if ``edges`` do not increase, ``overhang`` is negative or ``q`` zero everywhere.
    """
    edges = np.asarray(edges, dtype=np.float64)
    check_positive("edges[1] - edges[0]", edges[..., 1] - edges[..., 0])
    check_range("overhang", overhang, low=0.0)
    data, states = increments(x, q.reshape(-1, x.size)), edges.reshape(-1, 2)
    k, beta, spread = _terms(data, states, overhang)
    shifted, _, _ = _terms(data, states, overhang + OVERHANG_UNCERTAINTY)
    shape = (2, *edges.shape[:-1], *q.shape[:-1])
    results = (part.reshape(shape) for part in (k, beta, np.hypot(spread, shifted - k)))
    first, last = (FullStickFit(*parts) for parts in zip(*results, strict=True))
    return first, last


def effective_edges(x: Array, q: Array, overhang: float) -> Array:
    """Return (2,) the first and the last edge that discrete increments effectively have.

    Args:
        x: (n,) positions along the section, increasing.
        q: (..., n) increments on the same contact area.
        overhang: as in ``full_stick_factors``.
    """
    return np.array(increments(x, q.reshape(-1, x.size)).ends(overhang))


def effective_overhang(x: Array, q: Array) -> float:
    """Return the overhang that an increment shows; x, q (n,), at least 16 nodes in contact.

    To calibrate a discretisation on an increment whose mismatch is next to linear, such as a shear
    force between bodies that are large against the contact. Any other increment misleads.

    Raises:
        ValueError: if ``q`` is zero everywhere or too few nodes are in contact.
    """
    data = increments(x, q[None])
    check_range("nodes in contact", data.inside.size, low=16)
    found = [_overhang(data, window, n) for window in windows(data.inside) for n in (1, 2, 3)]
    return float(np.median(found))


def _terms(data: Increments, edges: Array, overhang: float) -> tuple[Array, Array, Array]:
    """Return k, beta and the spread of k, (2, states, increments) each, that all fits agree on."""
    if not windows(data.inside):
        shape = 2, len(edges), len(data.force)
        return np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.inf)
    series = fit_series(data, overhang)
    k, beta = singular_terms(series, edges)
    changes = [np.abs(k[..., :-2, :] - k[..., i : k.shape[-2] - 2 + i, :]) for i in (1, 2)]
    change = np.where(series.allowed[:, 2:, None], np.maximum(*changes), np.nan)
    values, slopes, errors = (
        _fits_last(part) for part in (k[..., :-2, :], beta[..., :-2, :], change)
    )
    score = np.broadcast_to(errors.max(axis=0), errors.shape)
    k_agreed, spread = consensus(values, errors, score)
    return k_agreed, consensus(slopes, errors, score)[0], spread


def _fits_last(part: Array) -> Array:
    """Return (2, states, increments, fits) from (states, 2, windows, orders, increments)."""
    states, edges, *_, increments = part.shape
    return part.reshape(states, edges, -1, increments).transpose(1, 0, 3, 2)


def _overhang(data: Increments, window: Positions, terms: int) -> float:
    """Return the overhang that fits best, within 0 ... LARGEST_OVERHANG.

    Only for an increment of which so few terms hold all: a truncated series hides in the overhang.
    """

    def squares(overhang: float) -> float:
        model = data.model(window, terms, overhang)
        target = data.force[0, window] - data.force[0, -1] * model[:, 0]
        rest = np.linalg.lstsq(model[:, 1:], target)[0]
        return float(np.sum((model[:, 1:] @ rest - target) ** 2))

    # Imported where it is needed: it takes as long as all other imports of a check.
    from scipy.optimize import minimize_scalar

    bounds = (0.0, LARGEST_OVERHANG)
    return float(minimize_scalar(squares, bounds=bounds, method="bounded").x)
