# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes pressed together over any smooth gap, with any number of contact patches.

Independent of fretfe and of elements: the pressure of each patch, t from -1 to 1 over it, is
sqrt(1 - t^2) times a series of U_n(t), whose Cauchy integral is pi T_{n+1} inside of the patch and
pi (s - sign(s) sqrt(s^2 - 1))^{n+1} outside. Collocation at Chebyshev's points, which crowd at the
edges; the edges follow from what slope is left over in each patch, from the gaps between patches
and from the load.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from reference.half_plane_collocation import compliance, pressed
from scipy.optimize import root

from fretfe._typing import Array

Function = Callable[[Array], Array]


@dataclass(frozen=True)
class Patches:
    """Solution of m patches, from left to right.

    Attributes:
        edges: (m, 2) left and right.
        k_n: (m, 2) K_N there.
        forces: (m,) P of each.
    """

    edges: Array
    k_n: Array
    forces: Array

    @property
    def main(self) -> int:
        """The patch that carries most."""
        return int(np.argmax(self.forces))


def patches(gap: Function, slope: Function, load: float, reach: float, modulus: float) -> Patches:
    """Contact under a load.

    Args:
        gap: initial gap over x.
        slope: its derivative.
        load: P.
        reach: the contact lies within +- reach.
        modulus: E*.

    Raises:
        AssertionError: if no set of patches with pressure all over them is found.
    """
    edges = _first_guess(gap, load, reach, modulus)
    terms = 48
    while True:
        shape = edges.shape
        found = root(
            lambda x, n=terms, s=shape: _Trial.of(gap, slope, x.reshape(s), n, modulus).rest(load),
            edges.ravel(),
            tol=1e-12,
        )
        edges = found.x.reshape(shape)
        trial = _Trial.of(gap, slope, edges, terms, modulus)
        tail = np.abs(trial.series[:, -4:]).max() / np.abs(trial.series).max()
        if tail < 1e-7 or terms > 400:
            break
        terms *= 2
    assert np.abs(trial.rest(load)).max() < 1e-8, "the edges did not settle"
    assert trial.presses, "there is tension in a patch"
    return Patches(edges, trial.k_n, trial.forces)


def _first_guess(gap: Function, load: float, reach: float, modulus: float) -> Array:
    """(m, 2) edges by even elements."""
    x = np.linspace(-reach, reach, 601)
    touches = pressed(x, gap(x), compliance(x, modulus), load) > 0
    ends = np.flatnonzero(np.diff(touches, prepend=False, append=False)).reshape(-1, 2)
    half = (x[1] - x[0]) / 2
    return np.array([(x[first] - half, x[last - 1] + half) for first, last in ends])


@dataclass(frozen=True)
class _Trial:
    """Pressures with the slopes of the gap, but for a constant in each patch, for given edges.

    Attributes:
        gap: initial gap.
        edges: (m, 2).
        series: (m, n) coefficients of U.
        left: (m,) slope that is left over.
        modulus: E*.
    """

    gap: Function
    edges: Array
    series: Array
    left: Array
    modulus: float

    @classmethod
    def of(cls, gap: Function, slope: Function, edges: Array, terms: int, modulus: float) -> _Trial:
        middle, half = edges.mean(axis=1), np.ptp(edges, axis=1) / 2
        t = np.cos(np.pi * (np.arange(terms + 1) + 0.5) / (terms + 1))
        x = (middle[:, None] + half[:, None] * t).ravel()
        columns = [
            2 / modulus * _cauchy((x - m) / a, terms) for m, a in zip(middle, half, strict=True)
        ]
        constants = np.repeat(np.eye(len(edges)), terms + 1, axis=0)
        found = np.linalg.solve(np.hstack([*columns, constants]), slope(x))
        series = found[: -len(edges)].reshape(len(edges), terms)
        return cls(gap, edges, series, found[-len(edges) :], modulus)

    @property
    def half(self) -> Array:
        return np.asarray(np.ptp(self.edges, axis=1) / 2)

    @property
    def forces(self) -> Array:
        """(m,) U_0 alone has a resultant."""
        return np.asarray(np.pi / 2 * self.half * self.series[:, 0])

    @property
    def k_n(self) -> Array:
        """(m, 2) limits of p over the root of the distance: U_n(+-1) = (+-1)^n (n + 1)."""
        n = np.arange(self.series.shape[1])
        ends = np.array([(-1.0) ** n * (n + 1), n + 1.0])
        return np.asarray(self.series @ ends.T * np.sqrt(2 / self.half)[:, None])

    @property
    def presses(self) -> bool:
        """True if no patch is under tension anywhere."""
        angle = np.linspace(1e-3, np.pi - 1e-3, 2001)
        n = np.arange(1, self.series.shape[1] + 1)
        return bool((self.series @ np.sin(n[:, None] * angle)).min() > 0)

    def rest(self, load: float) -> Array:
        """(2 m,) what is left over, without a dimension: of slopes, gaps between, and load."""
        size = load / (self.modulus * float(self.half.sum()))
        points, weights = np.polynomial.legendre.leggauss(80)
        angle = np.pi / 2 * points
        between = []
        for (_, first), (last, _) in zip(self.edges[:-1], self.edges[1:], strict=True):
            width = (last - first) / 2
            x = (first + last) / 2 + width * np.sin(angle)
            turned = sum(
                _cauchy((x - edges.mean()) / a, len(row)) @ row
                for edges, a, row in zip(self.edges, self.half, self.series, strict=True)
            )
            closed = 2 / self.modulus * turned @ (weights * np.pi / 2 * np.cos(angle)) * width
            opened = self.gap(np.array([first, last]))
            between.append((opened[1] - opened[0] - closed) / float(self.half.sum()))
        return np.array(
            [*self.left / size, *np.array(between) / size, self.forces.sum() / load - 1]
        )


def _cauchy(s: Array, terms: int) -> Array:
    """(k, n) integrals of sqrt(1 - t^2) U_n(t)/(s - t) over pi at s (k,)."""
    n = np.arange(1, terms + 1)
    inside = np.cos(n * np.arccos(np.clip(s, -1, 1))[:, None])
    away = np.maximum(np.abs(s), 1.0)
    outside = (np.sign(s) * (away - np.sqrt(away**2 - 1)))[:, None] ** n
    return np.where(np.abs(s)[:, None] < 1, inside, outside)
