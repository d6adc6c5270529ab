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
from fretfe.analytic._arguments import check_positive, check_range
from fretfe.analytic.profiles import Profile


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
