# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal contact of symmetric profiles: load, half-width, pressure and K_N.

Initial gap g(x), g(0) = 0; composite modulus E*; contact half-width ``a``; per unit thickness:

    P(a) = E* int_0^a t g'(t)/sqrt(a^2 - t^2) dt
    p(x) = (1/pi) int_|x|^a P'(b)/sqrt(b^2 - x^2) db      K_N = (1/pi) sqrt(2/a) P'(a)

(superposition of flat-punch increments). ``GeneralProfile`` evaluates them by quadrature, the other
classes in closed form. Valid for plane strain and plane stress (through E*), frictionless or
elastically similar bodies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import xlogy

from fretfe.analytic._arguments import FloatArray, check_positive, check_range


def composite_modulus(
    young_1: float,
    poisson_1: float,
    young_2: float,
    poisson_2: float,
    plane: Literal["strain", "stress"] = "strain",
) -> float:
    """Return E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; without the nu^2 in plane stress.

    Raises:
        ValueError: if a Young's modulus is not positive, a Poisson's ratio outside [-1, 0.5], or
            ``plane`` unknown.
    """
    if plane not in ("strain", "stress"):
        raise ValueError(f"plane must be 'strain' or 'stress', found {plane!r}")
    check_positive("young_1", young_1)
    check_positive("young_2", young_2)
    check_range("poisson_1", poisson_1, low=-1.0, high=0.5)
    check_range("poisson_2", poisson_2, low=-1.0, high=0.5)
    lateral = 1.0 if plane == "strain" else 0.0
    return 1.0 / ((1 - lateral * poisson_1**2) / young_1 + (1 - lateral * poisson_2**2) / young_2)


class Profile(Protocol):
    """What the partial-slip solutions need of a symmetric profile; arrays of any shape."""

    @property
    def e_star(self) -> float:
        """Composite modulus."""

    def load(self, half_width: ArrayLike) -> FloatArray:
        """Return P at a contact half-width."""

    def load_slope(self, half_width: ArrayLike) -> FloatArray:
        """Return dP/da."""

    def half_width(self, load: ArrayLike) -> FloatArray:
        """Return a at a load P >= 0."""

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> FloatArray:
        """Return p(x), zero outside the contact."""


def edge_factor_k_n(profile: Profile, half_width: ArrayLike) -> FloatArray:
    """Return K_N = (1/pi) sqrt(2/a) dP/da of any profile.

    Raises:
        ValueError: if ``half_width`` is not positive.
    """
    a = check_positive("half_width", half_width)
    return np.sqrt(2.0 / a) / np.pi * profile.load_slope(a)


@dataclass(frozen=True)
class Hertz:
    """Parabolic gap x^2/(2R): two cylinders with 1/R = 1/R1 + 1/R2."""

    radius: float
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("radius", self.radius)
        check_positive("e_star", self.e_star)

    def load(self, half_width: ArrayLike) -> FloatArray:
        """Return P = pi E* a^2/(4R)."""
        a = check_range("half_width", half_width, low=0.0)
        return np.pi * self.e_star * a**2 / (4.0 * self.radius)

    def load_slope(self, half_width: ArrayLike) -> FloatArray:
        """Return dP/da = pi E* a/(2R)."""
        a = check_range("half_width", half_width, low=0.0)
        return np.pi * self.e_star * a / (2.0 * self.radius)

    def half_width(self, load: ArrayLike) -> FloatArray:
        """Return a = sqrt(4PR/(pi E*))."""
        force = check_range("load", load, low=0.0)
        return np.sqrt(4.0 * force * self.radius / (np.pi * self.e_star))

    def peak_pressure(self, half_width: ArrayLike) -> FloatArray:
        """Return p0 = E* a/(2R)."""
        a = check_range("half_width", half_width, low=0.0)
        return self.e_star * a / (2.0 * self.radius)

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> FloatArray:
        """Return p = E*/(2R) sqrt(a^2 - x^2), zero outside."""
        a = check_range("half_width", half_width, low=0.0)
        inside = np.maximum(a**2 - np.asarray(x, dtype=np.float64) ** 2, 0.0)
        return self.e_star / (2.0 * self.radius) * np.sqrt(inside)


@dataclass(frozen=True)
class Wedge:
    """Shallow wedge, gap slope |x|; the pressure at the apex is infinite (logarithm)."""

    slope: float
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("slope", self.slope)
        check_positive("e_star", self.e_star)

    def load(self, half_width: ArrayLike) -> FloatArray:
        """Return P = E* slope a."""
        return self.e_star * self.slope * check_range("half_width", half_width, low=0.0)

    def load_slope(self, half_width: ArrayLike) -> FloatArray:
        """Return dP/da = E* slope."""
        a = check_range("half_width", half_width, low=0.0)
        return np.full_like(a, self.e_star * self.slope)

    def half_width(self, load: ArrayLike) -> FloatArray:
        """Return a = P/(E* slope)."""
        return check_range("load", load, low=0.0) / (self.e_star * self.slope)

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> FloatArray:
        """Return p = (E* slope/pi) arcosh(a/|x|), zero outside."""
        a = check_range("half_width", half_width, low=0.0)
        distance = np.abs(np.asarray(x, dtype=np.float64))
        root = np.sqrt(np.maximum((a - distance) * (a + distance), 0.0))
        with np.errstate(divide="ignore", invalid="ignore"):
            height = np.log((a + root) / distance)
        return self.e_star * self.slope / np.pi * np.where(distance < a, height, 0.0)


@dataclass(frozen=True)
class FlatRounded:
    """Flat of half-width b that ends in parabolic (round) shoulders, gap (|x| - b)^2/(2R).

    With sin(phi0) = b/a. Hertz for b = 0. K_N = (E*/(2R)) sqrt(2a) (1 - 2 phi0/pi).
    """

    flat_half_width: float
    radius: float
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_range("flat_half_width", self.flat_half_width, low=0.0)
        check_positive("radius", self.radius)
        check_positive("e_star", self.e_star)

    def load(self, half_width: ArrayLike) -> FloatArray:
        """Return P = (E* a^2/(4R)) (pi - 2 phi0 - sin(2 phi0)), a >= b."""
        a, b = self._check_half_width(half_width), self.flat_half_width
        area = a**2 * self._shoulder_angle(a) - b * np.sqrt((a - b) * (a + b))
        return self.e_star / (2.0 * self.radius) * area

    def load_slope(self, half_width: ArrayLike) -> FloatArray:
        """Return dP/da = (E* a/(2R)) (pi - 2 phi0), a >= b."""
        a = self._check_half_width(half_width)
        return self.e_star / self.radius * a * self._shoulder_angle(a)

    def half_width(self, load: ArrayLike) -> FloatArray:
        """Return a at a load P >= 0, by Newton's method; b if P = 0."""
        force = check_range("load", load, low=0.0)
        # P >= (2/3)(E*/R)(a - b)^2 and P is convex: no iterate is below the solution.
        a = self.flat_half_width + np.sqrt(1.5 * force * self.radius / self.e_star)
        for _ in range(60):
            excess = np.maximum(self.load(a) - force, 0.0)
            step = np.divide(excess, self.load_slope(a), out=np.zeros_like(a), where=excess > 0.0)
            a = a - step
            if not np.any(step > 0.0):
                break
        return a

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> FloatArray:
        """Return p(x), zero outside; with x = a sin(phi).

        2 pi R p/(E* a) = (pi - 2 phi0) cos(phi) + (sin(phi) + sin(phi0)) ln sin(phi + phi0)
        - (sin(phi) - sin(phi0)) ln |sin(phi - phi0)| - 2 sin(phi0) ln(cos(phi) + cos(phi0))
        (Ciavarella, Hills and Monno 1998, rearranged to stay finite at |x| = b).
        """
        a = self._check_half_width(half_width)
        with np.errstate(divide="ignore", invalid="ignore"):
            sine = np.abs(np.asarray(x, dtype=np.float64)) / a
            flat = self.flat_half_width / a
            cosine = np.sqrt(np.maximum(1.0 - sine**2, 0.0))
            cosine_flat = np.sqrt(1.0 - flat**2)
            total = sine * cosine_flat + cosine * flat
            difference = np.abs(sine * cosine_flat - cosine * flat)
            shape = 2.0 * np.arccos(flat) * cosine + xlogy(sine + flat, total)
            shape -= xlogy(sine - flat, difference) + 2.0 * xlogy(flat, cosine + cosine_flat)
        return self.e_star * a / (2.0 * np.pi * self.radius) * np.where(sine < 1.0, shape, 0.0)

    def _check_half_width(self, half_width: ArrayLike) -> FloatArray:
        return check_range("half_width", half_width, low=self.flat_half_width)

    def _shoulder_angle(self, a: FloatArray) -> FloatArray:
        """Return pi/2 - phi0; a = b = 0 counts as Hertz."""
        flat = np.divide(self.flat_half_width, a, out=np.zeros_like(a), where=a > 0.0)
        return np.arccos(flat)


@dataclass(frozen=True)
class GeneralProfile:
    """Any symmetric profile with g'(t) >= 0 and its derivative given for t > 0, by quadrature.

    ``kinks`` are the positions t > 0 where g'' jumps. Slow: one quadrature per value.
    """

    gap_slope: Callable[[float], float]
    gap_curvature: Callable[[float], float]
    e_star: float
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("e_star", self.e_star)

    def load(self, half_width: ArrayLike) -> FloatArray:
        """Return P(a)."""
        return np.vectorize(self._load)(check_range("half_width", half_width, low=0.0))

    def load_slope(self, half_width: ArrayLike) -> FloatArray:
        """Return dP/da."""
        return np.vectorize(self._load_slope)(check_range("half_width", half_width, low=0.0))

    def half_width(self, load: ArrayLike) -> FloatArray:
        """Return a at a load P > 0."""
        return np.vectorize(self._half_width)(check_positive("load", load))

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> FloatArray:
        """Return p(x), zero outside."""
        a = check_range("half_width", half_width, low=0.0)
        return np.vectorize(self._pressure)(np.asarray(x, dtype=np.float64), a)

    def _polar(self, function: Callable[[float], float], a: float) -> float:
        """Return the integral of function(angle) over 0 ... pi/2, split at the kinks."""
        angles = [np.arcsin(kink / a) for kink in self.kinks if kink < a]
        return _integral(function, [0.0, *angles, np.pi / 2])

    def _load(self, a: float) -> float:
        return self.e_star * a * self._polar(lambda t: np.sin(t) * self.gap_slope(a * np.sin(t)), a)

    def _load_slope(self, a: float) -> float:
        def integrand(angle: float) -> float:
            t = np.sin(angle)
            return t * self.gap_slope(a * t) + a * t**2 * self.gap_curvature(a * t)

        return self.e_star * self._polar(integrand, a)

    def _half_width(self, force: float) -> float:
        high = 1.0
        while self._load(high) < force:
            high *= 2.0
        low = high / 2.0
        while self._load(low) > force:
            low /= 2.0
        return float(brentq(lambda a: self._load(a) - force, low, high, xtol=1e-14 * high))

    def _pressure(self, x: float, a: float) -> float:
        if abs(x) >= a:
            return 0.0
        kinks = [np.sqrt(kink**2 - x**2) for kink in self.kinks if abs(x) < kink < a]

        def integrand(u: float) -> float:
            b = np.hypot(x, u)
            return self._load_slope(b) / b

        return _integral(integrand, [0.0, *kinks, np.sqrt(a**2 - x**2)]) / np.pi


def _integral(function: Callable[[float], float], ends: list[float]) -> float:
    pieces = (quad(function, *pair, epsabs=0.0, epsrel=1e-12, limit=200) for pair in pairwise(ends))
    return float(sum(piece[0] for piece in pieces))
