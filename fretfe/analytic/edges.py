# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Asymptotic description of a contact edge: factors, slip lengths, dissipation, and its error.

Conventions. Body 1 lies above body 2; ``x`` runs along the interface, the contact occupies
-a <= x <= a, and ``s`` is the distance inward from an edge. The shear traction ``q`` is the one
that body 1 exerts on body 2, positive in +x, and ``Q`` its integral. Pressure ``p`` is positive
and ``P`` its integral (per unit thickness). ``bulk_tension`` is the difference of the remote
tensions parallel to the interface, body 2 minus body 1.

Near an edge p -> K_N sqrt(s), and while nothing slips q -> +K_T/sqrt(s) at the left edge and
-K_T/sqrt(s) at the right one: K_T is positive *at each edge* if the traction on body 2 points
inward. A normal load increment over a fixed contact area gives p -> K_I/sqrt(s).

Dundurs' second constant beta couples pressure and shear of unlike bodies: with g the relative
displacement across, positive where it opens, and w that of body 2 along the interface,

    dg/dx = (2/E*) (-(1/pi) int p/(x - t) dt + beta q)
    dw/dx = (2/E*) (-(1/pi) int q/(x - t) dt - beta p)

(Johnson 1985, section 2.3, for both bodies). Where an edge slides, p ~ s^lambda; where nothing
slips, p + i q = (K_I + i K_T) s^(-1/2) (s/l)^(i epsilon) with q positive inward at either edge: K_I
and K_T are values at a reference length l, and (K_I + i K_T)(l) goes with l^(i epsilon).

The other half-plane formulas hold for elastically similar bodies, the slip laws for slip zones that
are short against the length over which the edge description holds. Numbers in brackets are those of
docs/theory.md, which has the references.

The cyclic slip length d = (range of K_T)/(f K_N) is the first term of an expansion in the slip
length. The exact solutions of symmetric half-plane contacts at constant normal load say how far it
can be trusted (`asymptote_error` and the others of this name), and in which direction it errs: too
short under a shear force, too long under a tension that makes the edges slip in opposite
directions.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import Side, check_positive, check_range, side_sign
from fretfe.analytic.profiles import Profile

# Step of a numerical derivative, over the length of the rounded part: round-off and truncation are
# both below 1e-8.
STEP = 1e-4


def tangential_factor(
    shear_force: ArrayLike, bulk_tension: ArrayLike, half_width: ArrayLike, side: Side
) -> Array:
    """Return K_T of a stuck contact between half-planes, from shear force and bulk tension.

    K_T = +-Q/(pi sqrt(2a)) + (sigma0/4) sqrt(a/2), plus at the left edge (7). Exact for similar
    half-planes, whose tractions at full stick are Q/(pi sqrt(a^2-x^2)) and
    -sigma0 x/(4 sqrt(a^2-x^2)) (6): Johnson 1985; Hills and Andresen 2021.

    Args:
        shear_force: Q per unit thickness, any shape that broadcasts with the others.
        bulk_tension: sigma_2 - sigma_1.
        half_width: a > 0.
        side: "left" or "right".

    Returns:
        K_T in stress times square root of length, positive inward; broadcast shape.

    Raises:
        ValueError: if ``half_width`` is not positive or ``side`` is unknown.
    """
    a = check_positive("half_width", half_width)
    shear_term = np.asarray(shear_force) / (np.pi * np.sqrt(2.0 * a))
    return side_sign(side) * shear_term + np.asarray(bulk_tension) / 4.0 * np.sqrt(a / 2.0)


def tension_for_zero_factor(shear_force: ArrayLike, half_width: ArrayLike, side: Side) -> Array:
    """Return the bulk tension at which K_T of this edge vanishes, -+4Q/(pi a), minus at the left.

    (7a), the zero of (7): the traction of full stick is then finite at the edge. K_T is positive
    exactly for a greater tension, at either edge and for either sign of Q. Compare the tension
    itself with this value, or take the sign of ``tangential_factor``; never compare the ratio
    sigma0 a/Q with -+4/pi: dividing by Q < 0 turns the inequality round, and Q = 0 has no ratio.

    Args:
        shear_force: Q per unit thickness, any shape that broadcasts with the half-width.
        half_width: a > 0.
        side: "left" or "right".

    Raises:
        ValueError: if ``half_width`` is not positive or ``side`` is unknown.
    """
    a = check_positive("half_width", half_width)
    return -side_sign(side) * 4.0 / np.pi * np.asarray(shear_force) / a


def normal_increment_factor(
    normal_force: ArrayLike, moment: ArrayLike, half_width: ArrayLike, side: Side
) -> Array:
    """Return K_I of a normal load increment over a fixed contact area between half-planes.

    K_I of (3) is P/(pi sqrt(2a)) +- 2M/(pi a sqrt(2a)), plus at the right edge: the moment
    ``M`` is the integral of p x dx about the centre, so a positive one loads the right edge.

    Args:
        normal_force: increment of P per unit thickness, any broadcastable shape.
        moment: increment of M per unit thickness.
        half_width: a > 0.
        side: "left" or "right".

    Raises:
        ValueError: if ``half_width`` is not positive or ``side`` is unknown.
    """
    a = check_positive("half_width", half_width)
    rocking = 2.0 * np.asarray(moment) / a
    return (np.asarray(normal_force) - side_sign(side) * rocking) / (np.pi * np.sqrt(2.0 * a))


def edge_advance(normal_factor_increment: ArrayLike, k_n: ArrayLike) -> Array:
    """Return the distance by which an increment of K_I moves the edge outward, 2 dK_I/K_N.

    First order in the distance: exact as the increment goes to zero.

    Raises:
        ValueError: if ``k_n`` is not positive.
    """
    return 2.0 * np.asarray(normal_factor_increment) / check_positive("k_n", k_n)


def effective_bulk_tension(
    k_t_left: ArrayLike, k_t_right: ArrayLike, half_width: ArrayLike
) -> Array:
    """Return the bulk tension that gives half-planes the same mean of the two edge factors.

    Inverse of the mean of (7) over both edges; defines the tension that a contact
    of arbitrary bodies feels.

    Raises:
        ValueError: if ``half_width`` is not positive.
    """
    a = check_positive("half_width", half_width)
    mean = (np.asarray(k_t_left) + np.asarray(k_t_right)) / 2.0
    return 4.0 * mean / np.sqrt(a / 2.0)


def shear_force_from_factors(
    k_t_left: ArrayLike, k_t_right: ArrayLike, half_width: ArrayLike
) -> Array:
    """Return the shear force that half-planes need for this difference of the edge factors.

    Q = pi sqrt(2a) (K_T(left) - K_T(right))/2, from (7): no free parameter, so its agreement with
    the integral of q is a check of the half-plane description.

    Raises:
        ValueError: if ``half_width`` is not positive.
    """
    a = check_positive("half_width", half_width)
    half_difference = (np.asarray(k_t_left) - np.asarray(k_t_right)) / 2.0
    return np.pi * np.sqrt(2.0 * a) * half_difference


def shear_force_mismatch(
    k_t_left: ArrayLike, k_t_right: ArrayLike, half_width: ArrayLike, shear_force: ArrayLike
) -> Array:
    """Return (Q from the edge factors - Q)/Q, zero if the half-plane edge description holds.

    Raises:
        ValueError: if ``half_width`` is not positive or ``shear_force`` is zero.
    """
    measured = np.asarray(shear_force, dtype=np.float64)
    if np.any(measured == 0.0):
        raise ValueError("shear_force must not be zero, the mismatch is relative to it; found 0")
    return shear_force_from_factors(k_t_left, k_t_right, half_width) / measured - 1.0


def slip_length_first_loading(k_t: ArrayLike, k_n: ArrayLike, friction: ArrayLike) -> Array:
    """Return d = 2 |K_T|/(f K_N) (8), the slip zone of the first, monotonic loading.

    On edge asymptotics: Dini and Hills 2004; Dini, Sackfield and Hills 2005; Hills and Andresen
    2021.

    Raises:
        ValueError: if ``k_n`` or ``friction`` is not positive.
    """
    return 2.0 * np.abs(k_t) / (check_positive("friction", friction) * check_positive("k_n", k_n))


def slip_length_cyclic(k_t_range: ArrayLike, k_n: ArrayLike, friction: ArrayLike) -> Array:
    """Return d = (range of K_T)/(f K_N), the slip zone of the steady cycle at constant normal load.

    (9), with the sources of ``slip_length_first_loading``. Half the length that first loading
    through the same range would give: on reversal the change of traction is limited by 2 f p. For
    Hertz under shear force alone it is low by about d/(2a).

    Raises:
        ValueError: if ``k_t_range`` is negative or ``k_n`` or ``friction`` is not positive.
    """
    factor_range = check_range("k_t_range", k_t_range, low=0.0)
    return factor_range / (check_positive("friction", friction) * check_positive("k_n", k_n))


def slip_length_loop(
    k_t: ArrayLike, k_i: ArrayLike, k_n: ArrayLike, friction: ArrayLike, reference: int = 0
) -> Array:
    """Return the inner end of the slip zone of a steady closed loop with varying normal load.

    d = [max(K_T - f K_I) - min(K_T + f K_I)]/(f K_N) (11), with both factors counted from
    the reference state and d measured inward from the edge as it is in that state. It
    is the border of the permanent stick zone for one-signed slip per half cycle. Where the edge
    retreats, the length swept by the edge itself is a lower bound of d.

    Args:
        k_t: (..., T) K_T at the states of the closed loop, from any origin.
        k_i: (..., T) K_I at the same states, from any origin.
        k_n: (...) K_N in the reference state.
        friction: coefficient f.
        reference: index of the reference state along the last axis.

    Returns:
        (...) d, zero if the edge neither slips nor moves inward from the reference state.

    Raises:
        ValueError: if ``k_n`` or ``friction`` is not positive.
    """
    f = check_positive("friction", friction)
    stiffness = f * check_positive("k_n", k_n)
    tangential = _counted_from(k_t, reference)
    normal = f[..., None] * _counted_from(k_i, reference)
    spread = np.max(tangential - normal, axis=-1) - np.min(tangential + normal, axis=-1)
    return spread / stiffness


def _counted_from(history: ArrayLike, reference: int) -> Array:
    values = np.asarray(history, dtype=np.float64)
    return values - values[..., reference, None]


def slip_lengths_in_phase(
    k_t_range: ArrayLike, k_i_range: ArrayLike, k_n: ArrayLike, friction: ArrayLike
) -> tuple[Array, Array]:
    """Return the slip length from the edge at high and at low normal load, both in phase with K_T.

    d_high = (dK_T + f dK_I)/(f K_N) and d_low = (dK_T - f dK_I)/(f K_N), from (11): to first order
    the same material point. Where dK_T < f dK_I nothing slips in the steady state: d_low is then
    zero and d_high the distance that the edge moves.

    Raises:
        ValueError: if a range is negative or ``k_n`` or ``friction`` is not positive.
    """
    f = check_positive("friction", friction)
    stiffness = f * check_positive("k_n", k_n)
    normal = f * check_range("k_i_range", k_i_range, low=0.0)
    tangential = np.maximum(check_range("k_t_range", k_t_range, low=0.0), normal)
    return (tangential + normal) / stiffness, (tangential - normal) / stiffness


def factor_range_phase_shifted(
    shear_amplitude: ArrayLike,
    tension_amplitude: ArrayLike,
    phase: ArrayLike,
    half_width: ArrayLike,
    side: Side,
) -> Array:
    """Return the range of K_T for Q = Qm + Qa cos(wt), sigma0 = sm + sa cos(wt - phase).

    2 sqrt(A^2 + B^2 +- 2AB cos(phase)) (10), plus at the left edge, with A = Qa/(pi sqrt(2a)) and
    B = (sa/4) sqrt(a/2), from (7). Similar half-planes, constant normal load.

    Args:
        shear_amplitude: Qa, any broadcastable shape.
        tension_amplitude: sa.
        phase: lag of the tension in radians.
        half_width: a > 0.
        side: "left" or "right".

    Raises:
        ValueError: if ``half_width`` is not positive or ``side`` is unknown.
    """
    shear = tangential_factor(shear_amplitude, 0.0, half_width, side)
    tension = tangential_factor(0.0, tension_amplitude, half_width, side)
    return 2.0 * np.abs(shear + tension * np.exp(-1j * np.asarray(phase)))


def dissipation_per_cycle(
    k_n: ArrayLike, slip_length: ArrayLike, friction: ArrayLike, e_star: ArrayLike
) -> Array:
    """Return the energy that one edge dissipates per steady cycle and unit thickness.

    W = pi f^2 K_N^2 d^3/(3 E*) with the cyclic slip length d, which is zero or more. For
    Hertz under shear force alone exact/formula is .975 at d = .05 a and .949 at .1 a.

    Raises:
        ValueError: if ``slip_length`` is negative or another argument is not positive.
    """
    d = check_range("slip_length", slip_length, low=0.0)
    strength = check_positive("friction", friction) * check_positive("k_n", k_n)
    return np.pi * strength**2 * d**3 / (3.0 * check_positive("e_star", e_star))


def edge_slip_first_loading(
    k_n: ArrayLike, slip_length: ArrayLike, friction: ArrayLike, e_star: ArrayLike
) -> Array:
    """Return the slip at the edge itself after monotonic loading, (4/3)(f K_N/E*) d^(3/2).

    Its range over a steady cycle is twice this with the cyclic slip length d.

    Raises:
        ValueError: if ``slip_length`` is negative or another argument is not positive.
    """
    d = check_range("slip_length", slip_length, low=0.0)
    strength = check_positive("friction", friction) * check_positive("k_n", k_n)
    return 4.0 / 3.0 * strength / check_positive("e_star", e_star) * d**1.5


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
    known = (remaining > 0.0) & (exact > 0.0) & (d > 0.0)
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
    # Imported where it is needed: see `profiles`.
    from scipy.special import ellipe, ellipkm1

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


def sliding_exponent(dundurs: float, coefficient: ArrayLike) -> Array:
    """Return lambda of p ~ s^lambda at an edge that slides: 1/2 - arctan(f beta)/pi.

    Args:
        dundurs: beta.
        coefficient: any shape, f where the shear on body 2 acts inward at the edge, -f where it
            acts outward.
    """
    return np.asarray(0.5 - np.arctan(np.multiply(coefficient, dundurs)) / np.pi)


def oscillation(dundurs: float) -> float:
    """Return epsilon = ln((1 + beta)/(1 - beta))/(2 pi) of full stick.

    Raises:
        ValueError: if ``dundurs`` is not between -1/2 and 1/2.
    """
    if not abs(dundurs) <= 0.5:
        raise ValueError(f"dundurs must be between -0.5 and 0.5, found {dundurs}")
    return math.atanh(dundurs) / math.pi


def at_length(
    factors: npt.NDArray[np.complex128], epsilon: float, ratio: ArrayLike
) -> npt.NDArray[np.complex128]:
    """Return K_I + i K_T (complex, any shape) at a length that is ``ratio`` times theirs."""
    return np.asarray(factors * np.exp(1j * epsilon * np.log(ratio)))


def full_stick_factor(
    normal_force: ArrayLike,
    moment: ArrayLike,
    shear_force: ArrayLike,
    bulk_tension: ArrayLike,
    half_width: ArrayLike,
    side: Side,
    dundurs: float,
) -> npt.NDArray[np.complex128]:
    """Return K_I + i K_T of a stuck contact between half-planes, at the reference length 1.

    With X = ((a + x)/(a - x))^(i epsilon)/sqrt(a^2 - x^2) the traction p + i q at full stick is
    cosh(pi epsilon) X times (P + i Q)/pi, -i sigma0 (x - 2 i epsilon a)/4 under a tension, and
    2 M (x - 2 i epsilon a)/(pi a^2 (1 + 4 epsilon^2)) by a rotation (from Plemelj's formulas;
    Muskhelishvili 1953). For beta = 0 these are (3) and (7).

    Args:
        normal_force: P through the centre, without rotation; any shape that broadcasts.
        moment: of the pressure that a rotation adds, about the centre; Q contributes
            `shear_moment` without a rotation.
        shear_force: Q, without rotation.
        bulk_tension: sigma_2 - sigma_1.
        half_width: a > 0.
        side: "left" or "right".
        dundurs: beta.

    Returns:
        Stress times square root of length, broadcast shape.

    Raises:
        ValueError: if ``half_width`` is not positive or ``side`` is unknown.
    """
    a, epsilon = check_positive("half_width", half_width), oscillation(dundurs)
    sign, lever = side_sign(side), 1 + 2j * epsilon
    force = np.asarray(normal_force) + 1j * sign * np.asarray(shear_force)
    rocking = -sign * 2 * np.asarray(moment) * lever / (a * (1 + 4 * epsilon**2))
    factor = (force + rocking) / (np.pi * np.sqrt(2 * a))
    mismatch = 0.25j * np.asarray(bulk_tension) * lever * np.sqrt(a / 2)
    return at_length(np.cosh(np.pi * epsilon) * (factor + mismatch), epsilon, 1 / (2 * a))


def shear_moment(dundurs: float, half_width: ArrayLike) -> Array:
    """Return the moment by a rotation that makes up for that of a unit of Q, 2 epsilon a.

    At full stick without rotation shear between unlike bodies gives the pressure the moment
    -2 epsilon a Q.
    """
    return np.asarray(2 * oscillation(dundurs) * np.asarray(half_width))
