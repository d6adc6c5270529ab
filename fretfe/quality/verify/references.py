# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closed forms behind the known values, written out here: independent of `fretfe.analytic`.

Elastically similar half-planes, all forces per unit thickness. Hertz, wedge: Johnson, Contact
Mechanics, 1985, chapters 4 and 5. Flat with rounded ends: Ciavarella, Hills and Monno, Proc. IMechE
C 212, 1998. Stuck contact under shear force and bulk tension: Hills and Nowell, Mechanics of
Fretting Fatigue, 1994.
"""

from __future__ import annotations

import math


def hertz_load(half_width: float, radius: float, e_star: float) -> float:
    """P = pi E* a^2/(4R)."""
    return math.pi * e_star * half_width**2 / (4 * radius)


def hertz_k_n(half_width: float, radius: float, e_star: float) -> float:
    """K_N = E*/(2R) sqrt(2a), from p = E*/(2R) sqrt(a^2 - x^2)."""
    return e_star / (2 * radius) * math.sqrt(2 * half_width)


def wedge_load(half_width: float, slope: float, e_star: float) -> float:
    """P = E* alpha a."""
    return e_star * slope * half_width


def wedge_k_n(half_width: float, slope: float, e_star: float) -> float:
    """K_N = (E* alpha/pi) sqrt(2/a), from p = (E* alpha/pi) arcosh(a/|x|)."""
    return e_star * slope / math.pi * math.sqrt(2 / half_width)


def flat_rounded_load(half_width: float, flat: float, radius: float, e_star: float) -> float:
    """P = E* a^2/(4R) (pi - 2 phi - sin 2 phi), sin phi = b/a."""
    phi = math.asin(flat / half_width)
    return e_star * half_width**2 / (4 * radius) * (math.pi - 2 * phi - math.sin(2 * phi))


def flat_rounded_k_n(half_width: float, flat: float, radius: float, e_star: float) -> float:
    """K_N = E*/(2R) sqrt(2a) (1 - 2 phi/pi), sin phi = b/a."""
    phi = math.asin(flat / half_width)
    return hertz_k_n(half_width, radius, e_star) * (1 - 2 * phi / math.pi)


def shear_part(shear_force: float, half_width: float) -> float:
    """K_T of a shear force, Q/(pi sqrt(2a)): the stuck shear is Q/(pi sqrt(a^2 - x^2))."""
    return shear_force / (math.pi * math.sqrt(2 * half_width))


def tension_part(bulk_tension: float, half_width: float) -> float:
    """K_T of a tension, sigma0/4 sqrt(a/2): the stuck shear is -sigma0 x/(4 sqrt(a^2 - x^2))."""
    return bulk_tension / 4 * math.sqrt(half_width / 2)


def k_t_ranges(
    shear_force: float, bulk_tension: float, lag: float, half_width: float
) -> tuple[float, float]:
    """Range of K_T at the left and at the right edge of Qa cos t and sigma_a cos(t - lag).

    K_T = +-A cos t + B cos(t - lag), plus at the left: range 2 sqrt(A^2 + B^2 +- 2AB cos lag).
    """
    a, b = shear_part(shear_force, half_width), tension_part(bulk_tension, half_width)
    product = 2 * a * b * math.cos(lag)
    left, right = a**2 + b**2 + product, a**2 + b**2 - product
    # In phase the two parts may cancel to round-off.
    return 2 * math.sqrt(max(left, 0.0)), 2 * math.sqrt(max(right, 0.0))
