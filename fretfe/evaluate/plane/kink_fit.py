# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges and K_N of wedges: contacts whose initial gap is straight beside one kink.

Their pressure has a logarithm at the kink, and no polynomial follows its square over more than a
few elements next to an edge. Half-planes with the edges m - a and m + a and the kink at m + a t
have at m + a z, with r = sqrt(1 - z^2),

    p = A ln|(1 - t z + r sqrt(1 - t^2))/(z - t)| + r (c0 + c1 z + ...)
    K_N sqrt(a/2) = A sqrt((1 + t)/(1 - t)) + c0 + c1    at the right edge; at the left one -t, -c1

A is E*/(2 pi) times the change of slope (Johnson 1985, section 5.2, and (A0) for t = 0). The second
part is what surfaces add that are a little bent, and bodies that are no half-planes. A rounded kink
is the mean of kinks all over the rounding. A, c0 and both edges are fitted to the integrals of the
pressure over the hats of the nodes, which do not alternate as nodal values do, and over all of the
kink; c1 shows what that leaves open. The gap alone says whether there is a kink.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools, Indices, Positions
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.numerics import FARTHEST
from fretfe.evaluate.plane.section import main_patch
from fretfe.history.solution import ContactHistory

# Nodes belong to the kink whose change of slope is this part of the largest, and a node more on
# either side. Surfaces are straight if the others in contact have a tenth of it together.
OF_KINK = 0.02
STRAIGHT = 0.1
# Elements between the kink and the outermost nodes without which the fit knows nothing.
ROOM = 3
# Nodes between them up to which polynomials of the pressure know nothing either.
NEAR = 8
# Errors of nodal forces over those of the scales: next to an edge K_N sqrt(h), alternating and
# farther inside with one sign, and next to the kink A. From Galerkin solutions of sharp, rounded
# and tilted wedges with 5 to 80 elements over the half-width.
AT_EDGE = 0.07
TAIL = 0.0135
AT_KINK = 0.03
# Intervals of 95 % over the standard error and over that of one sign; the misfit counts as if it
# had been found once more on so many nodes with these errors.
INTERVAL = 1.0
ONE_SIGN = 2.0
USUAL = 4
# Kinks are inside the contact by this part of its half-width at least while edges are sought.
INSIDE = 0.999
# What elements that grow inward leave of K_N, and half as much of a: 2e-6 with 200 to 400 over it.
SMALLEST = 2.5e-6
# Relative error of K_N by finite elements, times the cube of their number from edge to kink.
COARSE = 3.5
# Newton's method: steps of half an element at most, until they are next to none. Derivatives by the
# edges have steps of DIFFERENCE elements.
ITERATIONS = 40
CONVERGED = 1e-6
DIFFERENCE = 1e-4
# Variance of the change of slope over that of a sharp kink from which there is a rounding.
ROUNDED = 0.05
# Kinks that stand for a rounding, by Gauss.
POINTS, SHARES = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class Kink:
    """Change of slope of the initial gap of a contact.

    Attributes:
        places: (k,) along the arc, in the mean of which it is.
        shares: (k,) of the change of slope.
        first, last: nodes that belong to it.
        low, high: nodes between which the gap is straight beside them.
    """

    places: Array
    shares: Array
    first: int
    last: int
    low: int
    high: int


def find_kink(contact: ContactHistory, pressure: Array) -> Kink | None:
    """Return the kink of the initial gap where bodies touch, or None without one.

    Only of similar bodies without a layer: others have other pressures. Gaps are means around
    nodes, which spread a kink over some of them: as far as those of a sharp one at its place.

    Args:
        contact: whose gap.
        pressure: (T, N) of some states.
    """
    arc, layer = contact.surface.arc, contact.surface.layer
    touched = np.any(pressure > 0, axis=0)[2:-2]
    if contact.surface.dundurs or layer is not None or not touched.any():
        return None
    # A mean is that at the centroid of the hat where surfaces are straight.
    centroids = (arc[:-2] + arc[1:-1] + arc[2:]) / 3
    change = _change_of_slope(centroids, np.asarray(contact.gap[0])[1:-1])
    top = int(np.argmax(np.where(touched, change, -np.inf)))
    small = np.flatnonzero(change < OF_KINK * change[top])
    if not change[top] > 0 or not len(small) or not small[0] < top < small[-1]:
        return None
    part = slice(small[small < top][-1], small[small > top][0] + 1)
    places = centroids[1:-1][part]
    middle, width = _moments(places, change[part])
    second = np.diff(np.abs(arc - middle) ** 3) / np.diff(arc) / 3
    sharp = _change_of_slope(centroids, np.diff(second) / (arc[2:] - arc[:-2]))
    by_nodes, least = _moments(places, sharp[part])
    rounded = width - least > ROUNDED * least
    half = np.sqrt(3 * (width - least)) * POINTS if rounded else np.zeros(1)
    return Kink(
        places=2 * middle - by_nodes + half,
        shares=SHARES / 2 if rounded else np.ones(1),
        first=2 + part.start,
        last=1 + part.stop,
        low=1 + part.start - _straight(change[: part.start][::-1], change[part]),
        high=2 + part.stop + _straight(change[part.stop :], change[part]),
    )


def _straight(beside: Array, kink: Array) -> int:
    """Return the number of nodes beside a kink, outward, up to where the gap is straight."""
    return int(np.searchsorted(np.cumsum(np.abs(beside)), STRAIGHT / 2 * kink.sum()))


def _change_of_slope(x: Array, values: Array) -> Array:
    """Return (n - 2,) at the inner ones of n nodes."""
    return np.asarray(np.diff(np.diff(values) / np.diff(x)))


def _moments(x: Array, weights: Array) -> tuple[float, float]:
    """Return mean and variance."""
    middle = float(weights @ x / weights.sum())
    return middle, float(weights @ (x - middle) ** 2 / weights.sum())


@dataclass(frozen=True)
class _Forces:
    """Forces of T states on n nodes in a row, all those of the kink as one.

    Attributes:
        arc: (N,) nodes of the contact.
        kink: of it.
        starts: (n,) the first inner node of each.
        places: (n,) of the nodes; of the kink its middle.
        beside: (n,) elements from a node to the kink.
        weights: (n,) lengths of the nodes; of the kink of one of its nodes.
        values: (T, n) forces.
        used: (T, n) those of the contact, and of a node outside of it on either side.
        edges: (2, T) where the outermost nodes say they are.
        sizes: (2, T) of elements there.
    """

    arc: Array
    kink: Kink
    starts: Positions
    places: Array
    beside: Array
    weights: Array
    values: Array
    used: Bools
    edges: Array
    sizes: Array

    @classmethod
    def of(cls, arc: Array, pressure: Array, kink: Kink) -> _Forces:
        """Those of piecewise-linear pressures (T, N) of one patch each."""
        inner, weights = arc[1:-1], (arc[2:] - arc[:-2]) / 2
        lengths, left, right = np.diff(arc), pressure[:, :-1], pressure[:, 1:]
        forces = lengths[1:] * (2 * left + right)[:, 1:] + lengths[:-1] * (left + 2 * right)[:, :-1]
        starts = np.delete(np.arange(inner.size), np.arange(kink.first, kink.last))
        places = inner[starts]
        ends = arc[[kink.first, kink.last]]
        size = float(np.ptp(ends)) / (kink.last - kink.first)
        beside = np.abs(places - np.clip(places, *ends)) / size
        pressed = pressure > 0
        first = np.argmax(pressed, axis=1)
        last = arc.size - 1 - np.argmax(pressed[:, ::-1], axis=1)
        numbers = starts + 1
        used = (numbers >= first[:, None] - 1) & (numbers <= last[:, None] + 1)
        near = np.array([np.minimum(first + 3, arc.size - 2), np.maximum(last - 3, 1)]) - 1
        sizes = weights[near]
        edges = arc[[first, last]] + sizes * [[0.5], [-0.5]]
        values = np.add.reduceat(forces / 6, starts, axis=1)
        return cls(
            arc,
            kink,
            starts,
            places,
            beside,
            np.where(beside > 0, weights[starts], size),
            values,
            used,
            edges,
            sizes,
        )

    def model(self, edges: Array, terms: int) -> Array:
        """Return (T, n, 1 + terms) the forces by A and by as many of c0 and c1."""
        middle, a = edges.mean(axis=0)[:, None], np.ptp(edges, axis=0)[:, None] / 2
        z = (self.arc - middle) / a
        shares = zip(self.kink.places, self.kink.shares, strict=True)
        parts = [sum(share * _logarithm(z, (place - middle) / a) for place, share in shares)]
        second = a**2 * np.array([*parts, *_roots(z)[:terms]])
        forces = np.diff(np.diff(second) / np.diff(self.arc))
        return np.moveaxis(np.add.reduceat(forces, self.starts, axis=2), 0, -1)

    def k_n(self, edges: Array, coefficients: Array) -> Array:
        """Return (2, T) at the edges (2, T), from coefficients (1 + terms, T)."""
        middle, a = edges.mean(axis=0), np.ptp(edges, axis=0) / 2
        t = np.clip((self.kink.places[:, None] - middle) / a, -INSIDE, INSIDE)
        rows = []
        for side in (-1, 1):
            logarithm = self.kink.shares @ np.sqrt((1 + side * t) / (1 - side * t))
            powers = np.array([1.0, side])[: len(coefficients) - 1]
            rows.append(coefficients[0] * logarithm + powers @ coefficients[1:])
        return np.array(rows) * np.sqrt(2 / a)

    def errors(self, edges: Array, k_n: Array, kink: Array) -> tuple[Array, Array]:
        """Return (T, n) errors of the forces and (2, T, n) the parts by each edge of one sign.

        Args:
            edges: (2, T).
            k_n: (2, T).
            kink: (T,) A.
        """
        elements = np.abs(self.places - edges[..., None]) / self.sizes[..., None]
        scale = np.abs(k_n * np.sqrt(self.sizes))[..., None] * self.weights
        tails = TAIL * scale * np.maximum(elements, 0.5) ** -1.5
        alternating = AT_EDGE * scale * np.exp(-elements)
        beside = AT_KINK * np.abs(kink)[:, None] * self.weights * np.exp(-1 - self.beside)
        squares = (tails**2 + alternating**2).sum(axis=0) + beside**2
        return np.sqrt(squares), tails


def _logarithm(z: Array, t: Array) -> Array:
    """Return (T, N) the second integral of the pressure of a kink at t (T, 1); a = A = 1."""
    t = np.clip(t, -INSIDE, INSIDE)
    x = np.clip(z, -1.0, 1.0)
    away, r, q, angle = x - t, np.sqrt(1 - x**2), np.sqrt(1 - t**2), np.arcsin(x)
    ratio = (1 - t * x + r * q) / np.where(away == 0, 1.0, np.abs(away))
    logarithm = np.where(away == 0, 0.0, np.log(ratio))
    first = away * logarithm + q * angle
    second = away**2 / 2 * logarithm + q * (r / 2 + (x - t / 2) * angle)
    return np.asarray(second + first * (z - x))


def _roots(z: Array) -> tuple[Array, Array]:
    """Return (T, N) the second integrals of r and of r z."""
    x = np.clip(z, -1.0, 1.0)
    r, angle = np.sqrt(1 - x**2), np.arcsin(x)
    even = r / 2 + x * angle / 2 - r**3 / 6 + (x * r + angle) / 2 * (z - x)
    odd = -(x * r**3 / 4 + 3 / 8 * (x * r + angle)) / 3 - r**3 / 3 * (z - x)
    return even, odd


def _fit(forces: _Forces, terms: int) -> tuple[Array, Array]:
    """Return (2, 2, T) K_N and place of both edges, and their bars; NaN without convergence.

    Args:
        forces: on the nodes.
        terms: 1 to fit A, c0 and the edges, 2 to fit c1 too.
    """
    edges, errors = forces.edges, np.broadcast_to(forces.weights, forces.values.shape)
    for _ in range(ITERATIONS):
        scale = (forces.used / errors)[..., None]
        columns, values = forces.model(edges, terms) * scale, forces.values[..., None] * scale
        linear = np.linalg.pinv(columns) @ values
        moved = []
        for side in np.eye(2)[..., None]:
            step = DIFFERENCE * side * forces.sizes
            change = forces.model(edges + step, terms) - forces.model(edges - step, terms)
            moved.append(change * scale @ linear / (2 * DIFFERENCE))
        inverse = np.linalg.pinv(np.concatenate([columns, *moved], axis=2))
        rest = values - columns @ linear
        found = (inverse @ rest)[..., 0].T
        steps = np.clip(found[-2:], -0.5, 0.5)
        edges = edges + steps * forces.sizes
        edges = np.clip(
            edges, *(forces.edges + each * forces.sizes for each in (-FARTHEST, FARTHEST))
        )
        coefficients = linear[..., 0].T + found[:-2]
        k_n = forces.k_n(edges, coefficients)
        errors, tails = forces.errors(edges, k_n, coefficients[0])
        settled = np.abs(steps).max(axis=0) < CONVERGED
        if settled.all():
            break
    edges = np.where(settled, edges, np.nan)
    freedom = forces.used.sum(axis=1) - len(found)
    misfit = ((rest[..., 0] ** 2).sum(axis=1) + USUAL) / (freedom + USUAL)
    # What exceeds the errors, as with elements of order 1, is not independent from node to node.
    misfit = np.maximum(misfit, 4 * misfit - 3)
    gradients = _gradients(forces, edges, coefficients)
    by_values = np.einsum("gtk,tkn->gtn", gradients, inverse)
    scatter = misfit * (by_values**2).sum(axis=2)
    parts = np.abs(np.einsum("gtn,etn->get", by_values, tails * scale[..., 0])).sum(axis=1)
    bars = np.hypot(INTERVAL * np.sqrt(scatter), ONE_SIGN * parts)
    return np.array([k_n, edges]), bars.reshape(2, 2, -1)


def _gradients(forces: _Forces, edges: Array, coefficients: Array) -> Array:
    """Return (4, T, 3 + terms) of K_N at both edges, and of both edges in elements."""
    count, states = coefficients.shape
    rows = np.zeros((4, states, count + 2))
    for number in range(count):
        unit = np.zeros((count, 1))
        unit[number] = 1.0
        rows[:2, :, number] = forces.k_n(edges, unit)
    for number, side in enumerate(np.eye(2)[..., None]):
        step = DIFFERENCE * side * forces.sizes
        change = forces.k_n(edges + step, coefficients) - forces.k_n(edges - step, coefficients)
        rows[:2, :, count + number] = change / (2 * DIFFERENCE)
        rows[2 + number, :, count + number] = forces.sizes[number]
    return rows


def _outermost(arc: Array, pressure: Array) -> tuple[Indices, Indices]:
    """Return (T,) the first and the last node of the main patch in each state."""
    patches = [main_patch(arc, state) for state in pressure]
    first, last = np.transpose([(each.first, each.last) for each in patches])
    return first, last


def near_kink(arc: Array, pressure: Array, kink: Kink) -> tuple[Bools, Bools]:
    """Return (T,) whether each edge is so near to the kink that no polynomial holds beside it.

    The pressure inside of the kink says nothing of the edge then. What is bent beside it, as waves
    are, is no kink.

    Args:
        arc: (N,) nodes.
        pressure: (T, N) nodal values.
        kink: of the initial gap.
    """
    first, last = _outermost(arc, pressure)
    beyond = kink.first - first, last - kink.last
    straight = _straight_between(first, last, kink)
    left, right = (straight & (each >= -1) & (each < NEAR) for each in beyond)
    return left, right


def _straight_between(first: Indices, last: Indices, kink: Kink) -> Bools:
    """(T,) True where the gap between two nodes (T,) is straight but for the kink."""
    return (first >= kink.low) & (last <= kink.high)


def fit_beside_kink(arc: Array, pressure: Array, kink: Kink) -> tuple[EdgeFit, EdgeFit]:
    """Return the fits at both edges; NaN in states that do not have the kink well inside.

    Args:
        arc: (N,) nodes.
        pressure: (T, N) nodal values of piecewise-linear pressures out of a solver.
        kink: of the initial gap.
    """
    first, last = _outermost(arc, pressure)
    room = np.minimum(kink.first - first, last - kink.last)
    own = np.flatnonzero((room >= ROOM) & _straight_between(first, last, kink))
    found = np.full((2, 2, len(pressure)), np.nan)
    bars = np.full(found.shape, np.inf)
    if own.size:
        nodes = np.arange(arc.size)
        inside = (nodes >= first[own, None]) & (nodes <= last[own, None])
        forces = _Forces.of(arc, np.where(inside, pressure[own], 0.0), kink)
        found[..., own], spread = _fit(forces, 1)
        change = _fit(forces, 2)[0] - found[..., own]
        k_n, edges = found[..., own]
        away = np.abs(edges - kink.shares @ kink.places) / forces.sizes
        parts = np.hypot(SMALLEST, COARSE / away.min(axis=0) ** 3) * k_n
        least = np.array([parts, np.tile(SMALLEST / 4 * np.ptp(edges, axis=0), (2, 1))])
        bars[..., own] = np.sqrt(spread**2 + change**2 + least**2)
    known = np.isfinite(bars).all(axis=(0, 1))
    found[..., ~known], bars[..., ~known] = np.nan, np.inf
    (k_n, edges), (k_n_bars, edge_bars) = found, bars
    rows = zip(edges, k_n, edge_bars, k_n_bars, strict=True)
    left, right = (EdgeFit(*row) for row in rows)
    return left, right
