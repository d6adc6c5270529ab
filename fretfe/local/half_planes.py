# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes under tractions that are the same at both edges of a contact, on one half of it.

Places are distances s from the outermost place of an edge inward, in units of the half-width there:
the middle of the contact is at s = 1. Next to the edge elements are as fine as wanted over all of
the distance that the edge travels; from there on they grow with the distance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fretfe._typing import Array
from fretfe.local.friction import Stiffness
from fretfe.local.hat_functions import HatFunctions

# Elements grow by this fraction of their distance from where the edge is, up to a largest size.
# With 20 elements over a slip zone its length is found to half a per cent.
GROWTH = 0.08
COARSEST = 0.1
# Of the reference point of displacements, in half-widths; only a rigid motion depends on it.
FAR = 100.0
# Samples of the shape of the pressure, and Gauss points for each.
SAMPLES = 401
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(24)


@lru_cache(maxsize=16)
def half_planes(finest: float, travel: float, *, whole: bool = False) -> HalfPlanes:
    """Half-planes on a grid for edges that travel some way, with elements as fine as wanted.

    Args:
        finest: size of an element over the half-width.
        travel: of the edges, likewise.
        whole: whether both edges are wanted, which differ between unlike bodies.
    """
    places = [0.0]
    while places[-1] < 1.0:
        size = max(finest, GROWTH * (places[-1] - travel))
        places.append(places[-1] + min(size, COARSEST))
    s = np.array(places) / places[-1]
    grid = np.concatenate([s - 1, (1 - s)[-2::-1]])
    return WholeHalfPlanes(grid) if whole else HalfPlanes(grid)


class HalfPlanes:
    """Two half-planes, E* = 1 and half-width 1, and hat functions on one half of their contact.

    Args:
        grid: (2 n + 1,) nodes from -1 to 1, symmetric.

    Attributes:
        s: (n,) places of the nodes.
        weights: (n,) lengths that belong to them.
        points: (m,) x of the points at which pressures are taken.
        own: which of the nodes, and of the forces, are those of the edge that is looked at.
        part: of the force that acts on the nodes.
    """

    own = slice(None)
    part = 0.5

    def __init__(self, grid: Array) -> None:
        hats = HatFunctions(grid)
        count = (len(hats.nodes) + 1) // 2
        self.s = 1 + hats.nodes[:count]
        self.weights = hats.weights[:count].copy()
        self.weights[-1] /= 2
        whole = hats.compliance(FAR)
        folded = whole[:count, :count] + whole[:count, ::-1][:, :count]
        folded[-1] /= 2
        folded[:, -1] /= 2
        half = hats.points.size // 2
        self.points, self._tests = hats.points[:half], hats.tests[:count, :half]
        self._invert(folded)

    def _invert(self, compliance: Array) -> None:
        """Take the compliance (n, n) to tractions of all nodes."""
        inverse = np.linalg.inv(compliance)
        moved = inverse @ self.weights
        self._stuck = moved / (self.weights @ moved)
        self.change = inverse - np.outer(moved, self._stuck)

    def stiffness(self, tangential: Array) -> Stiffness:
        """Change of the shear by slip, along x and across the plane.

        Args:
            tangential: (S, 2, 2) compliance to shear in both directions over that to pressure.
        """
        return Stiffness(self.change, np.linalg.inv(tangential), self._stuck)

    def pressure(self, shapes: Array, half_width: Array, centre: Array | float = 0.0) -> Array:
        """(S, n) mean pressures around the nodes, of contacts of some half-widths (S,).

        Args:
            shapes: (S, SAMPLES) as of `pressure_shapes`.
            half_width: up to 1.
            centre: (S,) x of their middles; zero where only one half has nodes.
        """
        distance = np.abs(self.points - np.reshape(centre, (-1, 1)))
        x = np.minimum(distance / half_width[:, None], 1.0)
        place = x * (SAMPLES - 1)
        below = np.minimum(place.astype(np.int64), SAMPLES - 2)
        rest, rows = place - below, np.arange(len(shapes))[:, None]
        smooth = shapes[rows, below] * (1 - rest) + shapes[rows, below + 1] * rest
        return self.means(np.sqrt(1 - x**2) * smooth)

    def means(self, values: Array) -> Array:
        """(..., n) means around the nodes of values (..., m) at the points."""
        return np.asarray(values @ self._tests.T / self.weights)


class WholeHalfPlanes(HalfPlanes):
    """The same on all of the contact: between unlike bodies its two edges differ.

    Nodes are those next to the left and next to the right edge in turn, from the edges inward; the
    left edge is looked at, and its inward direction is that of x.

    Attributes:
        coupling: (n, n) weighted relative displacement across by shear along x, for beta = 1; its
            transpose that along x by pressure, as of `HatFunctions.coupling`.
    """

    own = slice(0, None, 2)
    part = 1.0

    def __init__(self, grid: Array) -> None:
        hats = HatFunctions(grid)
        count = len(hats.nodes)
        order = np.column_stack([np.arange(count), np.arange(count)[::-1]]).ravel()[:count]
        self.s, self.weights = 1 + hats.nodes[order], hats.weights[order]
        self.points, self._tests = hats.points, hats.tests[order]
        rows = np.ix_(order, order)
        self.coupling = hats.coupling()[rows]
        self._invert(hats.compliance(FAR)[rows])


def pressure_shapes(powers: Array) -> Array:
    """(S, SAMPLES) pressure of contacts of half-width 1, over √(1 - x^2), at x from 0 to 1.

    The gap of the bodies grows with |x|^n. By superposed flat punches (A0 of the theory guide)
    p = (1/π) ∫ (dP/da) da/√(a² - x²) from |x| to 1, with dP/da = a^(n-1) here, times π: n = 2 gives
    Hertz' 1.

    Args:
        powers: (S,) n >= 1.
    """
    distinct, which = np.unique(powers, return_inverse=True)
    x, w = np.linspace(0.0, 1.0, SAMPLES) ** 2, ((POINTS + 1) / 2) ** 2
    squares = x[:, None] + (1 - x[:, None]) * w
    return np.array([squares ** (n / 2 - 1) @ (WEIGHTS / 2) for n in distinct])[which]


@dataclass(frozen=True)
class Contacts:
    """S symmetric contacts of half-planes whose left edges have some factors in a reference state.

    Attributes:
        half_width: (S,) in the reference state.
        k_n: (S,) there.
        power: (S,) n of the gap |x|^n: 2 of a cylinder, whose slip zones grow as at a straight
            front, 3 as at the front of a circle.
    """

    half_width: Array
    k_n: Array
    power: Array

    def widths(self, k_i: Array) -> Array:
        """(S, ...) half-widths where K_I is (S, ...), counted from the reference state.

        K_N = 2 dK_I/da and K_N grows with the root of a, at the front of a cylinder and of a sphere
        alike. NaN where the contact would open.
        """
        extra = (1,) * (k_i.ndim - 1)
        b, k_n = (each.reshape(-1, *extra) for each in (self.half_width, self.k_n))
        power = 1 + 3 * k_i / (k_n * b)
        return np.asarray(b * np.where(power > 0, power, np.nan) ** (2 / 3))

    def forces(self, widths: Array) -> Array:
        """(S,) shear force for a unit of K_T or K_S, while the contact has some half-widths (S,).

        By K_T = Q/(π √(2a)), times what the front of a circle shortens by: with it the contacts
        answer P and Q out of phase as a sphere does.
        """
        shorter = (widths / self.half_width) ** (self.power - 2)
        return np.asarray(np.pi * np.sqrt(2 * widths) * shorter)

    def level(self, widths: Array) -> Array:
        """(S,) factor of the shape of the pressure at some half-widths (S,)."""
        now = (widths / self.half_width) ** (self.power - 1)
        return np.asarray(self.k_n * np.sqrt(self.half_width / 2) * now)


def work_share(power: Array | float, depth: Array | float, twist: Array | float = 0.0) -> Array:
    """(...) friction work at the fronts of `Contacts` over that in the plane.

    A stick zone that shrinks from a to c makes the bodies more compliant by ln(a/c) of what the
    edge of a plane punch does, by a/c - 1 at the front of a circle, and by (a^3/c^3 - 1)/3 there
    under a twist, all with the same first order. The loop of a steady cycle (Masing) has the area
    ∫ F' D (F(a) + F(c) - 2 F) dx from c to a, with D that of x and F(x) what is short of sliding
    where all but x slips: of the force x^n, of the moment of a twist the integral of x^2 E(1 - x^2)
    with the complete elliptic integral E: discs that turn, which add up to f p of Hertz (Lubkin
    1951; Jäger 1995). Between straight and round fronts in proportion.

    Args:
        power: (...) n.
        depth: (...) longest slip zone over the half-width, below 1.
        twist: (...) share of the shear that turns with the front.
    """
    n = np.asarray(power)[..., None]
    c = 1 - np.maximum(depth, 1e-6)[..., None]
    x = (1 + c) / 2 + (1 - c) / 2 * POINTS
    weights = WEIGHTS * x ** (n - 1) * (1 + c**n - 2 * x**n)
    plane = -np.sum(weights * np.log(x), axis=-1)
    share = np.sum(weights * (1 / x - 1), axis=-1) / plane
    share = share + twist * (_twisted_loop(x, c) * n[..., 0] / plane - share)
    return np.asarray(1 + np.clip(n[..., 0] - 2, 0.0, 1.0) * (share - 1))


def _twisted_loop(x: Array, c: Array) -> Array:
    """(...) loop of a circle under a twist, in the measure of `work_share`, over n.

    Args:
        x: (..., points) Gauss points between the radius of the stick zone and 1.
        c: (..., 1) that radius.
    """
    rate = _moment_rate(x)
    below = c[..., None] + (x - c)[..., None] / 2 * (1 + POINTS)
    moment = (_moment_rate(below) @ WEIGHTS) * (x - c) / 2
    whole = np.sum(WEIGHTS * rate, axis=-1, keepdims=True) * (1 - c) / 2
    return np.asarray(np.sum(WEIGHTS * rate * (1 / x**3 - 1) / 3 * (whole - 2 * moment), axis=-1))


def _moment_rate(x: Array) -> Array:
    """(...) dM/dx of a twist that has made all but a circle x of 1 slip; 1 at the front."""
    angle = np.pi / 4 * (1 + POINTS)
    root = np.sqrt(1 - (1 - x[..., None] ** 2) * np.sin(angle) ** 2)
    return np.asarray(x**2 * (root @ WEIGHTS) / 2)
