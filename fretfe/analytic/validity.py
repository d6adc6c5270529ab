# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error of the cyclic slip length d = (range of K_T)/(f K_N), from solutions that are exact.

The formula is the first term of an expansion in the slip length. The exact solutions of symmetric
half-plane contacts at constant normal load say how far it can be trusted, and in which direction it
errs: too short under a shear force, too long under a tension that makes the edges slip in opposite
directions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipkm1

from fretfe._typing import Array
from fretfe.analytic._numerics import check_positive, check_range
from fretfe.analytic.profiles import Profile

# Step of a numerical derivative, over the length of the rounded part: round-off and truncation are
# both below 1e-8.
STEP = 1e-4


def asymptote_error(profile: Profile, half_width: ArrayLike, slip_length: ArrayLike) -> Array:
    """Return predicted/exact - 1 of the cyclic slip length under a shear force alone.

    The amplitude Q1 that makes the formula predict d follows from Q1/f = d P'(a); the exact slip
    zones end at the half-width c with P(c) = P(a) - Q1/f (Ciavarella 1998, Jäger 1998), whatever
    the friction. Hertz: [sqrt(1 - 2 d/a) - 1]/2, about -d/(2a); wedge: 0.

    Args:
        profile: symmetric profile.
        half_width: a > 0, any shape that broadcasts with the slip length.
        slip_length: d as predicted, not as exact; zero or more.

    Returns:
        Relative error, negative where the prediction is short; the exact length is d/(1 + error).
        NaN outside the range of the formula, Q1 >= f P: the contact would slide. Round-off is about
        1e-16 a/d.

    Raises:
        ValueError: if ``half_width`` is not positive or ``slip_length`` is negative.
    """
    predicted = check_range("slip_length", slip_length, low=0.0)
    a, d = np.broadcast_arrays(check_positive("half_width", half_width), predicted)
    load = profile.load(a)
    remaining = load - d * profile.load_slope(a)
    exact = a - profile.half_width(np.where(remaining > 0.0, remaining, load))
    known = (remaining > 0.0) & (exact > 0.0)
    error = np.divide(d, exact, out=np.ones_like(d), where=known) - 1.0
    return np.where(remaining > 0.0, error, np.nan)


def mixed_asymptote_error(
    profile: Profile, half_width: ArrayLike, slip_length: ArrayLike, tension_share: ArrayLike
) -> Array:
    """Return predicted/exact - 1 of the cyclic slip length under a shear force and a bulk tension.

    The tension has the share r in the range of K_T at this edge, of which the formula predicts d.
    Of that (1 - r) d belong to the shear force, and the other edge slips over (1 - 2r) d, the other
    way if that is negative. To second order in d

        exact - d = [exact - d]((1 - r) d, shear alone) + (P''/P' - 1/a) (2r - r^2) d^2/2
                    - (2r - 1)^2 d^2/(4a), the last term for r > 1/2 alone.

    For Hertz the middle term is zero; the formula is then exact where both edges slip the same way
    (Nowell and Hills 1987: the stick zone of Mindlin, moved), and has the expansion of
    `hertz_tension_asymptote_error` for tension alone. The middle term is the first term's share of
    what the pressure next to an edge depends on with the profile; the shear at full stick does not.

    Args:
        profile: symmetric profile.
        half_width: a > 0, any shape that broadcasts with the others.
        slip_length: d as predicted, zero or more.
        tension_share: r from 0 (shear force alone) to 1 (tension alone), or outside where the two
            work against each other. Where the tension lags behind the shear force, its share
            between the extremes of K_T at this edge; that the other edge turns round in between is
            left out.

    Returns:
        Relative error; the exact length is d/(1 + error). NaN where the shear force would make the
        contact slide, or the expansion says that nothing slips.

    Raises:
        ValueError: if ``half_width`` is not positive or ``slip_length`` is negative.
    """
    a, r = check_positive("half_width", half_width), np.asarray(tension_share, dtype=np.float64)
    d = check_range("slip_length", slip_length, low=0.0)
    by_shear = np.abs(1.0 - r) * d
    of_shear = by_shear / (1.0 + asymptote_error(profile, a, by_shear)) - by_shear
    step = STEP * (a - max(profile.kinks, default=0.0))
    low, high = (profile.load_slope(a + each) for each in (-step, step))
    stiffening = (high - low) / (2.0 * step * profile.load_slope(a))
    of_profile = (stiffening - 1.0 / a) * (2.0 * r - r**2) * d**2 / 2.0
    of_opposite_slip = np.maximum(2.0 * r - 1.0, 0.0) ** 2 * d**2 / (4.0 * a)
    exact = d + of_shear + of_profile - of_opposite_slip
    known = exact > 0.0
    error = np.divide(d, exact, out=np.ones_like(exact), where=known) - 1.0
    return np.where(known | (d == 0.0), error, np.nan)


def hertz_tension_asymptote_error(half_width: ArrayLike, slip_length: ArrayLike) -> Array:
    """Return predicted/exact - 1 of the cyclic slip length of Hertz under bulk tension alone.

    The edges slip in opposite directions, the stick zone -c <= x <= c stays centred. That its
    traction is finite at both ends demands sigma0/4 = (2 f/pi) int_c^a p(x)/sqrt(x^2 - c^2) dx for
    the amplitude sigma0 of the cycle, which is (2 f p0/pi) [K(m) - E(m)] with the complete elliptic
    integrals of m = 1 - (c/a)^2, while the formula predicts d = a sigma0/(4 f p0). About +d/(4a).

    Args:
        half_width: a > 0, any shape that broadcasts with the slip length.
        slip_length: d as predicted, zero or more.

    Returns:
        Relative error, positive: the prediction is long. The exact length is d/(1 + error).

    Raises:
        ValueError: if ``half_width`` is not positive or ``slip_length`` is negative.
    """
    a = check_positive("half_width", half_width)
    predicted = check_range("slip_length", slip_length, low=0.0) / a
    # Newton's method for the exact length: the prediction is a convex function of it and not
    # smaller than it, so that no iterate falls below the solution.
    exact = np.minimum(predicted, 1.0 - 1e-9)
    for _ in range(60):
        stick = 1.0 - exact
        m = exact * (2.0 - exact)
        excess = 2.0 / np.pi * (ellipkm1(stick**2) - ellipe(m)) - predicted
        step = excess * np.pi * stick / (2.0 * ellipe(m))
        exact = np.clip(exact - step, 0.0, 1.0)
    return np.divide(predicted, exact, out=np.ones_like(predicted), where=exact > 0.0) - 1.0
