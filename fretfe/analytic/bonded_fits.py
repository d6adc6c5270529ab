# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fits of the singular edge terms of a bonded increment to its cumulative force.

The nodal values of a discrete traction oscillate next to the singularity, the cumulative force does
not. Discrete increments behave as if their edges stood a fraction of an element outside the
outermost nodes in contact: the overhang.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from fretfe.analytic._arguments import FloatArray

IndexArray = NDArray[np.intp]
# Orders of the series that are tried.
ORDERS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 14)
# Bound of the search; .53 for an exact Galerkin solution, more for finite elements.
LARGEST_OVERHANG = 1.6


class SingularTerm(NamedTuple):
    """k (1 + beta s)/sqrt(s) at one edge."""

    k: float
    beta: float


class BondedFits(NamedTuple):
    """A fit: k and beta (2, 2) at the left and the right edge; change of k (2,) by more terms."""

    values: FloatArray
    changes: FloatArray


@dataclass(frozen=True)
class BondedIncrement:
    """Cumulative force (n,) of a bonded increment at nodes (n,), from its left end.

    ``left`` and ``right`` are the outermost nodes in contact. One node out of contact stands
    outside each, unless the surface ends there.
    """

    x: FloatArray
    force: FloatArray
    left: float
    right: float

    def ends(self, overhang: float) -> tuple[float, float]:
        """Return the effective edges, ``overhang`` elements outside the outermost nodes."""
        outside_left, outside_right = self.left - self.x[0], self.x[-1] - self.right
        return self.left - overhang * outside_left, self.right + overhang * outside_right

    def model(self, window: IndexArray, terms: int, overhang: float) -> FloatArray:
        """Return (nodes, 1 + terms): force due to the total, and per unit c_1 ... c_terms."""
        left, right = self.ends(overhang)
        a = (right - left) / 2
        angle = np.arccos((left + a - self.x[window]) / a)
        orders = np.arange(1, terms + 1)
        series = a * np.sin(angle[:, None] * orders) / orders
        return np.column_stack([self.force[-1] * angle / np.pi, series])


def windows(inside: IndexArray) -> list[IndexArray]:
    """Return the nodes in contact (n,) without 3 to 12 at either end, as far as enough are left."""
    enough = 2 * ORDERS[2] + 4
    return [inside[drop:-drop] for drop in (3, 5, 8, 12) if inside.size >= 2 * drop + enough]


def fits_of_window(
    data: BondedIncrement, window: IndexArray, overhang: float, edges: tuple[float, float]
) -> list[BondedFits]:
    """Return the fits of rising order, each with what the next two orders change."""
    orders = [terms for terms in ORDERS if window.size >= 2 * terms + 4]
    fits = np.array([fit_bonded(data, window, terms, overhang, edges) for terms in orders])
    changes = [
        np.abs(fits[i + 1 : i + 3, :, 0] - fits[i, :, 0]).max(axis=0) for i in range(len(fits) - 2)
    ]
    return [BondedFits(*row) for row in zip(fits, changes, strict=False)]


def fit_bonded(
    data: BondedIncrement,
    window: IndexArray,
    terms: int,
    overhang: float,
    edges: tuple[float, float],
) -> tuple[SingularTerm, SingularTerm]:
    """Return the singular terms at the left and the right edge of a contact with known edges.

    With x - centre = -a cos(t) a stuck traction is sum_j c_j cos(j t)/sin(t), so the cumulative
    force is a (c_0 t + sum_j c_j sin(j t)/j), and the total gives c_0. One term is exact for
    half-planes under shear force and bulk tension; a mismatch that varies along the contact needs
    more. The same total and mismatch are then applied to the true contact area.

    Args:
        data: the increment.
        window: indices of the nodes used.
        terms: number of c_j besides c_0.
        overhang: distance of the effective edges from the outermost nodes, in elements.
        edges: true left and right edge.
    """
    model = data.model(window, terms, overhang)
    rest = np.linalg.lstsq(model[:, 1:], data.force[window] - model[:, 0])[0]
    weights = _moved(data, overhang, rest, edges)
    signs = (-1.0) ** np.arange(terms + 1)
    return _edge_term(weights, edges), _edge_term(weights * signs, edges)


def fit_overhang(data: BondedIncrement, window: IndexArray, terms: int) -> float:
    """Return the overhang that fits best, within 0 ... LARGEST_OVERHANG.

    Only for an increment of which so few terms hold all: a truncated series hides in the overhang.
    """

    def squares(overhang: float) -> float:
        model = data.model(window, terms, overhang)
        target = data.force[window] - model[:, 0]
        rest = np.linalg.lstsq(model[:, 1:], target)[0]
        return float(np.sum((model[:, 1:] @ rest - target) ** 2))

    bounds = (0.0, LARGEST_OVERHANG)
    return float(minimize_scalar(squares, bounds=bounds, method="bounded").x)


def _moved(
    data: BondedIncrement, overhang: float, rest: FloatArray, edges: tuple[float, float]
) -> FloatArray:
    """Return c_0 ... over the true contact area for the same total and the same mismatch.

    Half-planes have the mismatch sum_j (c_j a/j) T_j, apart from a factor: a polynomial in x.
    """
    ends, orders = data.ends(overhang), np.arange(1, rest.size + 1)
    a, fitted = (edges[1] - edges[0]) / 2, (ends[1] - ends[0]) / 2
    signs = (-1.0) ** orders
    series = Chebyshev(np.append(0.0, rest * signs * fitted / orders), domain=ends)
    coefficients = series.convert(domain=edges, kind=Chebyshev).coef[1:]
    moved = np.zeros(rest.size)
    moved[: coefficients.size] = coefficients
    return np.append(data.force[-1] / (np.pi * a), moved * signs * orders / a)


def _edge_term(weights: FloatArray, edges: tuple[float, float]) -> SingularTerm:
    """Return the edge term at t = 0 of sum_j weights_j cos(j t)/sin(t)."""
    a, total = (edges[1] - edges[0]) / 2, np.sum(weights)
    decay = np.sum(np.arange(weights.size) ** 2 * weights) / total
    return SingularTerm(float(np.sqrt(a / 2) * total), float((0.25 - decay) / a))


def increment(x: FloatArray, q: FloatArray) -> tuple[BondedIncrement, IndexArray]:
    """Return the increment between its outermost nodes, and the indices of those in contact.

    Args:
        x: (n,) positions.
        q: (n,) piecewise-linear traction, not zero in contact.

    Raises:
        ValueError: if q is zero everywhere.
    """
    active = np.flatnonzero(q)
    if active.size == 0:
        raise ValueError("q must differ from 0 at one node at least, found none")
    around = slice(max(active[0] - 1, 0), active[-1] + 2)
    nodes, traction = x[around], q[around]
    steps = np.diff(nodes) * (traction[1:] + traction[:-1]) / 2
    force = np.append(0.0, np.cumsum(steps))
    data = BondedIncrement(nodes, force, float(x[active[0]]), float(x[active[-1]]))
    return data, np.flatnonzero((nodes >= data.left) & (nodes <= data.right))
