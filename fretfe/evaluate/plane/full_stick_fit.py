# SPDX-License-Identifier: LGPL-3.0-or-later
"""Singular edge terms of increments of full stick, which give K_T and K_I.

The nodal values of a discrete traction oscillate next to the singularity, the cumulative force does
not. Discrete increments behave as if their edges stood a fraction of an element outside the
outermost nodes in contact: the overhang.

With x - centre = -a cos(t) the traction of full stick is sum_j c_j cos(j t)/sin(t), so that the
cumulative force is a (c_0 t + sum_j c_j sin(j t)/j), and the total gives c_0. One term is exact for
half-planes under shear force and bulk tension; a mismatch that varies along the contact needs more.
Half-planes have the mismatch sum_j (c_j a/j) T_j, apart from a factor: a polynomial in x. The same
total and mismatch are then applied to the true contact area.

The fit knows nothing of the true edges, so that it is made once for all states of a contact area.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebvander
from numpy.typing import ArrayLike

from fretfe._typing import Array, Bools, Positions
from fretfe.analytic._numerics import check_positive, check_range
from fretfe.evaluate.numerics import consensus

# Orders of the series that are tried.
ORDERS = np.array([1, 2, 3, 4, 5, 6, 8, 10, 12, 14])
# Nodes that windows leave out at either end, the smallest first.
DROPS = np.array([3, 5, 8, 12])
# Distance, in elements, of the effective edge of an increment of full stick from the outermost node
# in contact, outward, per displacement degree. Measured on half-planes with matching meshes, four
# gradings, two sizes: .56 to .59 and .90 to 1.05.
OVERHANG = {1: 0.98, 2: 0.57}
# The same of an exact Galerkin solution, without any displacement degree.
GALERKIN_OVERHANG = 0.53
OVERHANG_UNCERTAINTY = 0.05


@dataclass(frozen=True)
class Increments:
    """Cumulative forces (k, n) of k increments of full stick at nodes (n,), from the first one.

    ``first`` and ``last`` are the outermost nodes in contact, ``inside`` (m,) the indices of all
    from one to the other. One node out of contact stands outside each, unless the surface ends.
    """

    x: Array
    force: Array
    first: float
    last: float
    inside: Positions

    def ends(self, overhang: float) -> tuple[float, float]:
        """Return the effective edges, ``overhang`` elements outside the outermost nodes."""
        before, behind = self.first - self.x[0], self.x[-1] - self.last
        return self.first - overhang * before, self.last + overhang * behind

    def model(self, window: Positions, terms: int, overhang: float) -> Array:
        """Return (nodes, 1 + terms): force per unit of the total, and per unit c_1 ... c_terms."""
        first, last = self.ends(overhang)
        a = (last - first) / 2
        angle = np.arccos((first + a - self.x[window]) / a)
        orders = np.arange(1, terms + 1)
        return np.column_stack([angle / np.pi, a * np.sin(angle[:, None] * orders) / orders])


@dataclass(frozen=True)
class Series:
    """Series of k increments: every order that the windows allow.

    Attributes:
        ends: effective edges.
        total: (k,) forces.
        terms: (windows, orders, J, k) coefficients c_1 ... c_J, zero behind the order.
        allowed: (windows, orders) whether a window has nodes enough for the order.
    """

    ends: tuple[float, float]
    total: Array
    terms: Array
    allowed: Bools


def increments(x: Array, q: Array) -> Increments:
    """Return the increments between their outermost nodes.

    Args:
        x: (n,) positions.
        q: (k, n) piecewise-linear tractions on the same contact area, not zero in contact.

    Raises:
        ValueError: if q is zero everywhere.
    """
    active = np.flatnonzero(q.any(axis=0))
    if active.size == 0:
        raise ValueError("q must differ from 0 at one node at least, found none")
    first, last = max(active[0] - 1, 0), active[-1] + 1
    nodes, traction = x[first : last + 1], q[:, first : last + 1]
    steps = np.diff(nodes) * (traction[:, 1:] + traction[:, :-1]) / 2
    force = np.column_stack([np.zeros(len(q)), np.cumsum(steps, axis=1)])
    inside = np.arange(active[0], active[-1] + 1) - first
    return Increments(nodes, force, float(x[active[0]]), float(x[active[-1]]), inside)


def windows(inside: Positions) -> list[Positions]:
    """Return the nodes in contact without DROPS at either end, as far as enough are left."""
    enough = 2 * ORDERS[2] + 4
    return [inside[drop:-drop] for drop in DROPS if inside.size >= 2 * drop + enough]


def fit_series(data: Increments, overhang: float) -> Series:
    """Fit series of every order in every window, at least one window.

    One triangular factor of a window serves all its orders, since their terms are nested.

    Args:
        data: the increments.
        overhang: distance of the effective edges from the outermost nodes, in elements.
    """
    used = windows(data.inside)
    allowed = np.array([[window.size >= 2 * order + 4 for order in ORDERS] for window in used])
    count, total = ORDERS[allowed.any(axis=0)].max(), data.force[:, -1]
    model = data.model(used[0], count, overhang)
    target = data.force[:, used[0]].T - np.outer(model[:, 0], total)
    inner = np.array([np.isin(used[0], window) for window in used])
    # A row of zeros takes a node out of a window.
    columns = inner[:, :, None] * np.column_stack([model[:, 1:], target])
    triangles = np.linalg.qr(columns, mode="r")[:, None, :count]
    free = allowed[:, :, None] & (np.arange(count) < ORDERS[:, None])
    # Rows and columns of the terms that are not used are those of the identity.
    system = np.where(free[..., None] & free[..., None, :], triangles[..., :count], np.eye(count))
    terms = np.linalg.solve(system, np.where(free[..., None], triangles[..., count:], 0.0))
    return Series(data.ends(overhang), total, terms, allowed)


def singular_terms(series: Series, edges: Array) -> tuple[Array, Array]:
    """Return k and beta of k (1 + beta s)/sqrt(s), each (states, 2, windows, orders, k).

    Args:
        series: of k increments.
        edges: (states, 2) true places of both ends.
    """
    a = (edges[:, 1] - edges[:, 0]).reshape(-1, 1, 1, 1, 1) / 2
    sums = np.tensordot(_edge_sums(series.ends, edges, series.terms.shape[2]), series.terms, (3, 2))
    amount = (sums[:, :, 0] + series.total / np.pi) / a
    # Without a singular term, as by symmetry, there is no beta either.
    ratio = np.divide(sums[:, :, 1], a * amount, out=np.zeros_like(amount), where=amount != 0.0)
    return np.sqrt(a / 2) * amount, (0.25 - ratio) / a


def _edge_sums(ends: tuple[float, float], edges: Array, terms: int) -> Array:
    """Return (states, 2 edges, 2 sums, J): what units of c_1 ... c_J over ``ends`` contribute.

    With C_j, the coefficients over the true area times its half-width, the sums are those of
    C_j cos(j t) and of j^2 C_j cos(j t) at the edge. The mismatch is moved by way of its values at
    Chebyshev points of the true area.
    """
    orders, points = np.arange(terms + 1), chebpts1(terms + 1)
    signs, fitted = (-1.0) ** orders, (ends[1] - ends[0]) / 2
    a, centre = (edges[:, 1:] - edges[:, :1]) / 2, edges.mean(axis=1, keepdims=True)
    at = (centre + a * points - np.mean(ends)) / fitted
    mismatch = chebvander(at, terms)[..., 1:] * (signs[1:] * fitted / orders[1:])
    # C_j = (-1)^j j times the coefficient of T_j; t = 0 at the first edge, pi at the last.
    at_edges = orders * np.stack([signs, np.ones(terms + 1)])
    # That coefficient is 2/(J + 1) times the sum of the values times T_j over the points.
    weights = np.stack([at_edges, orders**2 * at_edges], axis=1) * 2 / (terms + 1)
    return np.einsum("esj,pj,tpi->tesi", weights, chebvander(points, terms), mismatch)


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

    The cumulative force is fitted with up to 14 terms; the error of a fit is what the
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
