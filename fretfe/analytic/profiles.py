# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal contact of symmetric profiles: load, half-width, pressure and K_N.

Initial gap g(x), g(0) = 0; composite modulus E*; contact half-width ``a``; per unit thickness:

    P(a) = E* int_0^a t g'(t)/sqrt(a^2 - t^2) dt
    p(x) = (1/pi) int_|x|^a P'(b)/sqrt(b^2 - x^2) db      K_N = (1/pi) sqrt(2/a) P'(a)

(superposition of flat-punch increments). ``GeneralProfile`` evaluates them by quadrature,
``rocking.TabulatedProfile`` for the spline through a table, the classes below in closed form. Valid
for plane strain and plane stress (through E*), frictionless or elastically similar bodies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import (
    SMOOTH,
    check_positive,
    check_range,
    graded_rule,
    solve_half_width,
)

__all__ = [
    "FIRST_YIELD",
    "FlatRounded",
    "GeneralProfile",
    "Hertz",
    "Profile",
    "Wedge",
    "approach_slope",
    "composite_modulus",
    "edge_factor_k_n",
    "peak_pressure",
]

# Pressure at which a line contact yields below the surface, over the yield stress in tension, by
# Tresca and without shear (Johnson 1985, section 6.1). Of other pads than cylinders an estimate.
FIRST_YIELD = 1.67

_RIGHT_ANGLE = np.pi / 2.0
# Bounds the memory of the quadrature: some megabytes per array.
_BLOCK = 4096
# Stands for 0 where the slope may not be evaluated at 0 itself.
_NEXT_TO_ZERO = 1e-150


@dataclass(frozen=True)
class GeneralProfile:
    """Any symmetric profile with g'(t) >= 0, by quadrature; all methods take arrays of any shape.

    With t = a sin(angle), angle from 0 to pi/2:

        P(a)  = E* a int sin g'(t) dangle
        P'(a) = E* int [g'(a) - sin g'(t)]/cos^2 dangle
        p(x)  = (E*/pi) sqrt(a^2 - x^2) int [t g'(t) - x g'(x)]/(t^2 - x^2) dangle

    (the inversion of the integral equation of the half-plane, Johnson 1985, with the principal
    value taken out; the two halves of the contact added). Relative accuracy about 1e-12 for gaps
    that are smooth between the kinks and for powers like |x|^1.5; less where the pressure has or
    almost has a logarithm: 1e-6 at 1e-6 a from a corner, 1e-3 at the centre of |x|^1.2. The contact
    is one interval if g' does not decrease.

    Args:
        slope: g'(t) as a function of an array of t > 0.
        e_star: composite modulus.
        kinks: positions t >= 0 where g' or one of its derivatives jumps or is infinite.
    """

    slope: Callable[[Array], ArrayLike]
    e_star: float
    kinks: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("e_star", self.e_star)
        check_range("kinks", self.kinks, low=0.0)

    def gap(self, x: ArrayLike) -> Array:
        """Return g(x), the integral of the slope from 0 to |x|."""
        distance = np.abs(np.asarray(x, dtype=np.float64))
        bounds = np.minimum([0.0, *sorted(self.kinks), np.inf], distance[..., None])
        nodes, weights = graded_rule(bounds, ())
        return np.sum(weights * self._slope_at(nodes), axis=-1)

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g'(x), odd in x."""
        position = np.asarray(x, dtype=np.float64)
        return np.sign(position) * self._slope_at(np.abs(position))

    def load(self, half_width: ArrayLike) -> Array:
        """Return P(a)."""
        a = check_range("half_width", half_width, low=0.0)
        width = np.maximum(a, _NEXT_TO_ZERO)
        angle, weight = self._rule(width)
        slope = self._slope_at(width[..., None] * np.sin(angle))
        return self.e_star * a * np.sum(weight * np.sin(angle) * slope, axis=-1)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da."""
        width = np.maximum(check_range("half_width", half_width, low=0.0), _NEXT_TO_ZERO)
        angle, weight = self._rule(width)
        slope = self._slope_at(width[..., None] * np.sin(angle))
        fall = self._slope_at(width)[..., None] - np.sin(angle) * slope
        return self.e_star * np.sum(weight * fall / np.cos(angle) ** 2, axis=-1)

    def half_width(self, load: ArrayLike) -> Array:
        """Return a at a load P >= 0; at P = 0 the half-width of the flat, 0 if there is none."""
        force = check_range("load", load, low=0.0)
        starts = np.array([0.0, *sorted(self.kinks)])
        reached = np.maximum.accumulate(self.load(starts))
        low = starts[np.searchsorted(reached, force, side="right") - 1]
        return solve_half_width(
            self.load, self.load_slope, force, low, np.full(force.shape, np.inf)
        )

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
        """Return p(x), zero outside; not meaningful at a corner, where it is infinite."""
        a = check_range("half_width", half_width, low=0.0)
        distance, width = np.broadcast_arrays(np.abs(np.asarray(x, dtype=np.float64)), a)
        inside = distance < width
        found = np.zeros(distance.shape)
        at, within = distance[inside], width[inside]
        blocks = range(0, at.size, _BLOCK)
        parts = [self._inside(at[i : i + _BLOCK], within[i : i + _BLOCK]) for i in blocks]
        found[inside] = np.concatenate([np.zeros(0), *parts])
        return found

    def _inside(self, x: Array, a: Array) -> Array:
        """Return p(x) for 0 <= x < a, both (n,)."""
        place = np.arcsin(x / a)[:, None]
        angle, weight = self._rule(a, place)
        sine = np.sin(angle)
        excess = sine * self._slope_at(a[:, None] * sine)
        excess -= np.sin(place) * self._slope_at(x)[:, None]
        # The difference of the squares of the sines; 0 at most in a piece of no length.
        squares = np.sin(angle - place) * np.sin(angle + place)
        quotient = np.divide(excess, squares, out=np.zeros_like(excess), where=squares != 0.0)
        return self.e_star / np.pi * np.cos(place[:, 0]) * np.sum(weight * quotient, axis=-1)

    def _rule(self, a: Array, *places: Array) -> tuple[Array, Array]:
        """Return angles and weights over 0 ... pi/2, split at the kinks and further places."""
        sines = np.minimum(np.asarray(self.kinks), a[..., None]) / a[..., None]
        ends = np.broadcast_to([0.0, _RIGHT_ANGLE], (*a.shape, 2))
        bounds = np.concatenate([ends, np.arcsin(sines), *places], axis=-1)
        return graded_rule(np.sort(bounds, axis=-1), (_RIGHT_ANGLE,))

    def _slope_at(self, t: Array) -> Array:
        slope = np.asarray(self.slope(np.maximum(t, _NEXT_TO_ZERO)), dtype=np.float64)
        return np.broadcast_to(slope, t.shape)


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
    """A symmetric profile, as the solutions for whole contacts need it; arrays of any shape."""

    @property
    def e_star(self) -> float:
        """Composite modulus."""

    @property
    def kinks(self) -> tuple[float, ...]:
        """Positions t >= 0 where g' or g'' jumps or is infinite: corners, ends of a flat."""

    def gap(self, x: ArrayLike) -> Array:
        """Return g(x), even in x, g(0) = 0."""

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g'(x), odd in x."""

    def load(self, half_width: ArrayLike) -> Array:
        """Return P at a contact half-width."""

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da."""

    def half_width(self, load: ArrayLike) -> Array:
        """Return a at a load P >= 0."""

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
        """Return p(x), zero outside the contact."""


def edge_factor_k_n(profile: Profile, half_width: ArrayLike) -> Array:
    """Return K_N = (1/pi) sqrt(2/a) dP/da of any profile.

    Raises:
        ValueError: if ``half_width`` is not positive.
    """
    a = check_positive("half_width", half_width)
    return np.sqrt(2.0 / a) / np.pi * profile.load_slope(a)


def peak_pressure(profile: Profile, half_width: float) -> float:
    """Return the largest pressure of a pad of one contact zone; infinite for a wedge."""
    if isinstance(profile, Wedge):
        return math.inf
    start = max(profile.kinks, default=0.0)
    x = np.linspace(start, half_width, 200) if start else np.zeros(1)
    return float(profile.pressure(x, half_width).max())


def approach_slope(half_width: ArrayLike, distance: ArrayLike, e_star: float) -> Array:
    """Return d(approach)/dP = (2/(pi E*)) arcosh(distance/a), the normal compliance.

    The approach of the bodies is counted from the surface points at ``distance`` from the centre:
    in plane problems it has no finite value against points at infinity. Holds for any symmetric
    profile, as an increment of load acts like a flat punch (Johnson 1985).

    Args:
        half_width: a > 0, any shape that broadcasts with the other.
        distance: from the centre of the contact, at least a.
        e_star: composite modulus.

    Raises:
        ValueError: if a point lies inside the contact or an argument is not positive.
    """
    a = check_positive("half_width", half_width)
    ratio = check_range("distance/half_width", np.asarray(distance) / a, low=1.0)
    return 2.0 / (np.pi * check_positive("e_star", e_star)) * np.arccosh(ratio)


@dataclass(frozen=True)
class Hertz:
    """Parabolic gap x^2/(2R): two cylinders with 1/R = 1/R1 + 1/R2."""

    radius: float
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("radius", self.radius)
        check_positive("e_star", self.e_star)

    @property
    def kinks(self) -> tuple[float, ...]:
        """None."""
        return ()

    def gap(self, x: ArrayLike) -> Array:
        """Return g = x^2/(2R)."""
        return np.asarray(x, dtype=np.float64) ** 2 / (2.0 * self.radius)

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g' = x/R."""
        return np.asarray(x, dtype=np.float64) / self.radius

    def load(self, half_width: ArrayLike) -> Array:
        """Return P = pi E* a^2/(4R)."""
        a = check_range("half_width", half_width, low=0.0)
        return np.pi * self.e_star * a**2 / (4.0 * self.radius)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da = pi E* a/(2R)."""
        a = check_range("half_width", half_width, low=0.0)
        return np.pi * self.e_star * a / (2.0 * self.radius)

    def half_width(self, load: ArrayLike) -> Array:
        """Return a = sqrt(4PR/(pi E*))."""
        force = check_range("load", load, low=0.0)
        return np.sqrt(4.0 * force * self.radius / (np.pi * self.e_star))

    def peak_pressure(self, half_width: ArrayLike) -> Array:
        """Return p0 = E* a/(2R)."""
        a = check_range("half_width", half_width, low=0.0)
        return self.e_star * a / (2.0 * self.radius)

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
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

    @property
    def kinks(self) -> tuple[float, ...]:
        """The apex."""
        return (0.0,)

    def gap(self, x: ArrayLike) -> Array:
        """Return g = slope |x|."""
        return self.slope * np.abs(np.asarray(x, dtype=np.float64))

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g' = slope sign(x)."""
        return self.slope * np.sign(np.asarray(x, dtype=np.float64))

    def load(self, half_width: ArrayLike) -> Array:
        """Return P = E* slope a."""
        return self.e_star * self.slope * check_range("half_width", half_width, low=0.0)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da = E* slope."""
        a = check_range("half_width", half_width, low=0.0)
        return np.full_like(a, self.e_star * self.slope)

    def half_width(self, load: ArrayLike) -> Array:
        """Return a = P/(E* slope)."""
        return check_range("load", load, low=0.0) / (self.e_star * self.slope)

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
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

    Limit of a flat punch, a - b << a, each with a relative error of the order (a - b)/a:

        P   -> (2 sqrt(2)/3) (E*/R) sqrt(a) (a - b)^(3/2)
        K_N -> (2/pi) (E*/R) sqrt(a - b) = (2/pi) (E*/R)^(2/3) (3 pi K_I/2)^(1/3)

    with K_I = P/(pi sqrt(2a)), the edge factor of the punch: the rounding is short, so only K_I and
    the radius are felt at the edge.
    """

    flat_half_width: float
    radius: float
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_range("flat_half_width", self.flat_half_width, low=0.0)
        check_positive("radius", self.radius)
        check_positive("e_star", self.e_star)

    @property
    def kinks(self) -> tuple[float, ...]:
        """The end of the flat; none without a flat."""
        return (self.flat_half_width,) if self.flat_half_width > 0.0 else ()

    def gap(self, x: ArrayLike) -> Array:
        """Return g = (|x| - b)^2/(2R) outside the flat, 0 inside."""
        beyond = np.abs(np.asarray(x, dtype=np.float64)) - self.flat_half_width
        return np.maximum(beyond, 0.0) ** 2 / (2.0 * self.radius)

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g' = sign(x) (|x| - b)/R outside the flat, 0 inside."""
        position = np.asarray(x, dtype=np.float64)
        beyond = np.abs(position) - self.flat_half_width
        return np.sign(position) * np.maximum(beyond, 0.0) / self.radius

    def load(self, half_width: ArrayLike) -> Array:
        """Return P = (E* a^2/(4R)) (pi - 2 phi0 - sin(2 phi0)), a >= b.

        As an integral of sin^2 up to pi/2 - phi0: next to the flat the difference has no digits.
        """
        a = self._check_half_width(half_width)
        angle = self._shoulder_angle(a)
        squares = np.sin(angle[..., None] * SMOOTH.points) ** 2
        return self.e_star / self.radius * a**2 * angle * (squares @ SMOOTH.weights)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da = (E* a/(2R)) (pi - 2 phi0), a >= b."""
        a = self._check_half_width(half_width)
        return self.e_star / self.radius * a * self._shoulder_angle(a)

    def half_width(self, load: ArrayLike) -> Array:
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

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
        """Return p(x), zero outside; with x = a sin(phi).

        2 pi R p/(E* a) = (pi - 2 phi0) cos(phi) + (sin(phi) + sin(phi0)) ln sin(phi + phi0)
        - (sin(phi) - sin(phi0)) ln |sin(phi - phi0)| - 2 sin(phi0) ln(cos(phi) + cos(phi0))
        (Ciavarella, Hills and Monno 1998, rearranged to stay finite at |x| = b).
        """
        # Imported where it is needed: SciPy's special functions take a quarter of a second.
        from scipy.special import xlogy

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

    def _check_half_width(self, half_width: ArrayLike) -> Array:
        return check_range("half_width", half_width, low=self.flat_half_width)

    def _shoulder_angle(self, a: Array) -> Array:
        """Return pi/2 - phi0; a = b = 0 counts as Hertz."""
        b = self.flat_half_width
        return 2.0 * np.arctan(np.sqrt(np.divide(a - b, a + b, out=np.ones_like(a), where=a > 0.0)))
