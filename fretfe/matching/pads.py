# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of a pad on a flat specimen whose edge has given factors, in closed form.

Both bodies are elastically similar half-planes, the profile is symmetric. Numbers in brackets are
those of docs/theory.md. Forces are per unit length of the pad.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from fretfe.analytic.edges import factor_range_phase_shifted, mixed_asymptote_error
from fretfe.analytic.profiles import (
    FlatRounded,
    Hertz,
    Profile,
    Wedge,
    edge_factor_k_n,
    peak_pressure,
)
from fretfe.errors import ModelError

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(16)
# Tolerances of roots, relative.
EXACT = 1e-14
NEWTON = 60


@dataclass(frozen=True)
class Factors:
    """Factors that the edge of a test shall have.

    Attributes:
        k_n: K_N at the mean load.
        k_t_range, k_i_range: ranges in the cycle; with `k_i_range` 0 the normal force is constant.
        in_step: 1 if K_T rises with K_I, -1 if it falls.
        friction: coefficient.
        bulk_range: range of the bulk stress.
        bulk_phase: lag of it behind Q, radians.
    """

    k_n: float
    k_t_range: float
    k_i_range: float
    in_step: int
    friction: float
    bulk_range: float = 0.0
    bulk_phase: float = 0.0


@dataclass(frozen=True)
class PadTest:
    """A pad and the loads of its test.

    The edge that is matched is the left one: P = normal_force + normal_amplitude sin, Q =
    shear_amplitude sin, with the phase of the bulk stress behind it.

    Attributes:
        profile: of the pad.
        factors: that its left edge has.
        half_width: a at the mean load.
        normal_force, normal_amplitude: of P.
        shear_amplitude: of Q; negative if K_T falls with K_I, NaN if no Q gives the range.
    """

    profile: Profile
    factors: Factors
    half_width: float
    normal_force: float
    normal_amplitude: float
    shear_amplitude: float

    @property
    def governing_length(self) -> float:
        """Length over which the edge makes the pressure: a, or a - b."""
        return self.half_width - max(self.profile.kinks, default=0.0)

    @property
    def widest(self) -> float:
        """Half-width at the largest normal force."""
        return float(self.profile.half_width(self.normal_force + self.normal_amplitude))

    @property
    def peak_pressure(self) -> float:
        """Largest pressure at the largest normal force; infinite for a wedge."""
        return peak_pressure(self.profile, self.widest)

    @property
    def shear_ratio(self) -> float:
        """Q/(f P) at the smallest normal force; the contact slides at 1."""
        smallest = self.normal_force - self.normal_amplitude
        ratio = abs(self.shear_amplitude) / (self.factors.friction * max(smallest, 0.0) or math.nan)
        return ratio if math.isfinite(ratio) else math.inf

    @property
    def slip(self) -> tuple[float, float]:
        """Slip lengths from the edge at the high and at the low normal force, by (11)."""
        given = self.factors
        normal = given.friction * given.k_i_range
        sizes = (given.k_t_range + normal, max(given.k_t_range - normal, 0.0))
        long, short = (size / (given.friction * given.k_n) for size in sizes)
        return long, short

    @property
    def tension_share(self) -> float:
        """Share of the bulk stress in the range of K_T, between the extremes of K_T."""
        given = self.factors
        half = (given.k_t_range / 2) or math.nan
        tension = given.bulk_range / 2 / 4 * math.sqrt(self.half_width / 2) / half
        across, along = math.sin(given.bulk_phase), math.cos(given.bulk_phase)
        # Both parts add up to the amplitude of K_T, in whose direction each is counted.
        shear = math.sqrt(max(1 - (tension * across) ** 2, 0.0)) - tension * along
        return tension * (tension + shear * along)

    @property
    def asymptote_error(self) -> float:
        """Predicted/exact - 1 of the longer slip length at constant normal force; or NaN."""
        error = mixed_asymptote_error(
            self.profile, self.half_width, self.slip[0], self.tension_share
        )
        return float(error)


def pad_test(profile: Profile, factors: Factors) -> PadTest:
    """The loads that give the edges of a pad some factors.

    K_N gives the half-width by (5), and that the mean of P. With an in-phase P the increments are
    dK_I = dP/(pi sqrt(2a)) and dK_T = dQ/(pi sqrt(2a)), a that of the moment, so that the
    amplitudes are in the ratio of the ranges. At constant P the range is (10), solved for Q.

    Where K_I would need P to become negative the amplitude is P or more.
    """
    a = half_width_for(profile, factors.k_n)
    normal_force = float(profile.load(a))
    if factors.k_i_range > 0:
        amplitude = _normal_amplitude(profile, normal_force, factors.k_i_range)
        shear = factors.in_step * amplitude * factors.k_t_range / factors.k_i_range
    else:
        amplitude, shear = 0.0, _shear_amplitude(factors, a)
    return PadTest(profile, factors, a, normal_force, amplitude, shear)


def closed_form(test: PadTest) -> Factors:
    """The factors that a pad and its loads have between half-planes: the inverse of `pad_test`."""
    given, a = test.factors, test.half_width
    k_i_range = 0.0
    if test.normal_amplitude > 0:
        ends = test.profile.half_width(
            test.normal_force + test.normal_amplitude * np.array([-1, 1])
        )
        k_i_range = _normal_factor(test.profile, float(ends[0]), float(ends[1]))
        k_t_range = abs(test.shear_amplitude) / test.normal_amplitude * k_i_range
    else:
        k_t_range = float(
            factor_range_phase_shifted(
                test.shear_amplitude, given.bulk_range / 2, given.bulk_phase, a, "left"
            )
        )
    k_n = float(edge_factor_k_n(test.profile, a))
    return replace(given, k_n=k_n, k_t_range=k_t_range, k_i_range=k_i_range)


def half_width_for(profile: Profile, k_n: float) -> float:
    """The half-width at which a profile has K_N, from the closed forms behind (5)."""
    if isinstance(profile, Hertz):
        return 2 * (k_n * profile.radius / profile.e_star) ** 2
    if isinstance(profile, Wedge):
        return 2 * (profile.e_star * profile.slope / (np.pi * k_n)) ** 2
    if not isinstance(profile, FlatRounded):
        raise TypeError(f"expected Hertz, Wedge or FlatRounded, found {type(profile).__name__}")
    b = profile.flat_half_width
    # A flat lowers K_N: the contact is wider than that of the cylinder without it.
    least = 2 * (k_n * profile.radius / profile.e_star) ** 2

    def excess(beyond: float) -> float:
        return float(edge_factor_k_n(profile, b + math.exp(beyond))) / k_n - 1

    low, high = math.log(1e-12 * (least + b)), math.log(4 * (least + b))
    if excess(low) >= 0 or excess(high) <= 0:
        raise ModelError(
            f"a contact about {least:.4g} beyond the flat, which is too little beside {b:.4g} for "
            "numbers to tell"
        )
    return b + math.exp(brentq(excess, low, high, xtol=EXACT, rtol=EXACT))


def _shear_amplitude(factors: Factors, a: float) -> float:
    """Q of (10) with the plus sign: A = -B cos(phase) + sqrt(range^2/4 - B^2 sin(phase)^2)."""
    tension = factors.bulk_range / 2 / 4 * math.sqrt(a / 2)
    across = tension * math.sin(factors.bulk_phase)
    square = (factors.k_t_range / 2) ** 2 - across**2
    if square < 0:
        return math.nan
    shear = math.sqrt(square) - tension * math.cos(factors.bulk_phase)
    return shear * math.pi * math.sqrt(2 * a) if shear >= 0 else math.nan


def _normal_amplitude(profile: Profile, force: float, k_i_range: float) -> float:
    """Amplitude of P about its mean that gives the range of K_I.

    Newton's method for the half-widths a1 < a2 of the cycle: P(a1) + P(a2) = 2 P, and the integral
    of dK_I = (K_N/2) da from a1 to a2 is the range.
    """
    least = max(profile.kinks, default=0.0)
    most = _normal_factor(profile, least, float(profile.half_width(2 * force)))
    if most <= k_i_range:
        return force * k_i_range / most
    middle = float(profile.half_width(force))
    ends = middle + np.array([-0.5, 0.5]) * (middle - least) * k_i_range / most
    for _ in range(NEWTON):
        missing = [
            float(profile.load(ends).sum()) - 2 * force,
            _normal_factor(profile, ends[0], ends[1]) - k_i_range,
        ]
        slopes = [profile.load_slope(ends), edge_factor_k_n(profile, ends) * [-0.5, 0.5]]
        after = ends - np.linalg.solve(slopes, missing)
        after = np.maximum(after, least + (ends - least) / 4)
        done = np.abs(after - ends).max() <= EXACT * ends[1]
        ends = after
        if done:
            break
    return float(np.diff(profile.load(ends))[0] / 2)


def _normal_factor(profile: Profile, low: float, high: float) -> float:
    """K_I from one half-width to another; smooth in the root of what is beyond a flat."""
    least = max(profile.kinks, default=0.0)
    start, end = math.sqrt(low - least), math.sqrt(high - least)
    root = (start + end) / 2 + POINTS * (end - start) / 2
    values = root * edge_factor_k_n(profile, least + root**2)
    return float(WEIGHTS @ values) * (end - start) / 2
