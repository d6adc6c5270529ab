# SPDX-License-Identifier: LGPL-3.0-or-later
"""Galerkin half-plane contact for tests: tractions sampled as a mortar finite element method does.

Tractions are piecewise linear on given nodes, relative displacements are weighted with the same hat
functions, all integrals are exact. Similar half-planes with E* = 1, so that the relative
displacement is -(2/pi) int q(y) ln|x - y| dy. Edges fall between nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Bools


def second_differences(nodes: Array) -> NDArray[np.longdouble]:
    """Return (n - 2, n) W: the integral of hat i times f'' is sum_k W_ik f(node k)."""
    x = nodes.astype(np.longdouble)
    h, rows = np.diff(x), np.arange(x.size - 2)
    weights = np.zeros((x.size - 2, x.size), dtype=np.longdouble)
    weights[rows, rows] = 1 / h[:-1]
    weights[rows, rows + 1] = -1 / h[:-1] - 1 / h[1:]
    weights[rows, rows + 2] = 1 / h[1:]
    return weights


def compliance(nodes: Array) -> Array:
    """Return the Galerkin matrix of -(2/pi) ln|x - y|, exact: fourth differences of r^4 ln r."""
    x = nodes.astype(np.longdouble)
    r = np.abs(x[:, None] - x)
    logarithm = np.log(np.where(r > 0, r, 1))
    fourth_integral = -(r**4) / 24 * (logarithm - np.longdouble(25) / 12)
    weights = second_differences(nodes)
    return np.asarray(2 / np.pi * (weights @ fourth_integral @ weights.T), dtype=float)


def hat_integrals(nodes: Array, second_integral: Callable[[Array], Array]) -> Array:
    """Return the integrals of f against the inner hats, from a function whose f'' it is."""
    values = second_integral(nodes.astype(np.longdouble))
    return np.asarray(second_differences(nodes) @ values, dtype=float)


@dataclass(frozen=True)
class Contact:
    """Nodal pressure (n,), zero at both end nodes, and the load."""

    x: Array
    pressure: Array

    @property
    def touching(self) -> NDArray[np.intp]:
        return np.flatnonzero(self.pressure)

    def bonded(self, shear_force: float, bulk_tension: float) -> Array:
        """Return the stuck shear traction (n,) over the fixed contact area."""
        return self.bonded_to(lambda x: -bulk_tension / 2 * x**3 / 6, shear_force)

    def bonded_to(self, mismatch_second_integral: Callable[[Array], Array], force: float) -> Array:
        """Return the stuck traction (n,) of a total force and a relative displacement, any u(x)."""
        first, last = self.touching[0], self.touching[-1]
        nodes = self.x[first - 1 : last + 2]
        weight = hat_integrals(nodes, lambda x: x**2 / 2)
        mismatch = hat_integrals(nodes, mismatch_second_integral)
        q = np.zeros_like(self.x)
        q[first : last + 1] = solve(compliance(nodes), weight, mismatch, force)
        return q

    def partial_slip(self, shear_force: float, friction: float) -> tuple[Array, Array, Bools]:
        """Return shear (n,), slip (n,) and whether a node slips (n,), first loading with Q > 0."""
        matrix, weight = compliance(self.x), hat_integrals(self.x, lambda x: x**2 / 2)
        bound = friction * self.pressure[1:-1]
        inside, slips = bound > 0, np.zeros(bound.size, dtype=bool)
        for _ in range(50):
            q, stick = np.where(slips, bound, 0.0), np.flatnonzero(inside & ~slips)
            reduced = matrix[np.ix_(stick, stick)]
            rest = shear_force - float(weight @ q)
            q[stick] = solve(reduced, weight[stick], -(matrix @ q)[stick], rest)
            relative = (matrix @ q) / weight
            slip = relative[stick].mean() - relative
            changed = inside & np.where(slips, slip > 0, q > bound)
            if np.array_equal(changed, slips):
                return np.pad(q, 1), np.pad(np.where(slips, slip, 0.0), 1), np.pad(slips, 1)
            slips = changed
        raise AssertionError("the active set did not settle")


def solve(matrix: Array, weight: Array, right: Array, force: float) -> Array:
    """Return t with matrix t = right + weight * (unknown rigid motion) and weight @ t = force."""
    size = weight.size
    system = np.zeros((size + 1, size + 1))
    system[:size, :size] = matrix
    system[:size, size] = -weight
    system[size, :size] = weight
    return np.asarray(np.linalg.solve(system, np.append(right, force))[:size])


def press(nodes: Array, gap_second_integral: Callable[[Array], Array], load: float) -> Contact:
    """Return the frictionless contact at a load; the gap is given by a function whose f'' it is."""
    matrix, weight = compliance(nodes), hat_integrals(nodes, lambda x: x**2 / 2)
    gap = hat_integrals(nodes, gap_second_integral)
    inside = np.ones(weight.size, dtype=bool)
    for _ in range(100):
        pressure, chosen = np.zeros(weight.size), np.flatnonzero(inside)
        reduced = matrix[np.ix_(chosen, chosen)]
        pressure[chosen] = solve(reduced, weight[chosen], -gap[chosen], load)
        opening = (matrix @ pressure + gap) / weight
        opening -= opening[chosen].mean()
        changed = np.where(inside, pressure > 0, opening < 0)
        if np.array_equal(changed, inside):
            return Contact(nodes, np.pad(pressure, 1))
        inside = changed
    raise AssertionError("the active set did not settle")


def uniform_nodes(h: float, phase: float) -> Array:
    """Return nodes around -1 ... 1, shifted by a fraction of h."""
    count = int(1.2 / h)
    return np.asarray((np.arange(-count, count + 1) + phase) * h, dtype=np.float64)


def graded_nodes(h: float, coarsest: float, phase: float) -> Array:
    """Return nodes of size h at x = -1 and 1 that grow by a tenth of the distance from there."""
    reach = 1 + 30 * h
    x = np.linspace(-reach, reach, 100001)
    size = np.minimum(h + 0.1 * np.abs(np.abs(x) - 1), coarsest)
    count = np.concatenate([[0.0], np.cumsum(np.diff(x) * (1 / size[1:] + 1 / size[:-1]) / 2)])
    return np.asarray(np.interp(np.arange(phase, count[-1]), count, x), dtype=np.float64)
