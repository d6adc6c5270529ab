# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Asymptotic description of a contact edge: factors, slip lengths, dissipation.

Conventions. Body 1 lies above body 2; ``x`` runs along the interface, the contact occupies
-a <= x <= a, and ``s`` is the distance inward from an edge. The shear traction ``q`` is the one
that body 1 exerts on body 2, positive in +x, and ``Q`` its integral. Pressure ``p`` is positive
and ``P`` its integral (per unit thickness). ``bulk_tension`` is the difference of the remote
tensions parallel to the interface, body 2 minus body 1.

Near an edge p -> K_N sqrt(s), and while nothing slips q -> +K_T/sqrt(s) at the left edge and
-K_T/sqrt(s) at the right one: K_T is positive *at each edge* if the traction on body 2 points
inward. A normal load increment over a fixed contact area gives p -> K_I/sqrt(s).

The half-plane formulas hold for elastically similar bodies, the slip laws for slip zones that are
short against the length over which the edge description holds. Numbers in brackets are those of
docs/theory.md, which has the references.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import Side, check_positive, check_range, side_sign


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
