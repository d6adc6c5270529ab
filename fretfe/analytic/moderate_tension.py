# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact partial slip of a Hertz contact under shear force and moderate bulk tension.

Elastically similar half-planes, constant normal load, Q and sigma0 in proportion (Nowell and Hills
1987). Moderate: slip at both edges has the direction of Q, the tension only shifts the stick zone.
In it the change of the traction must bring the two surfaces the strain difference of the tension,
(1/pi) PV int q(t)/(t - x) dt = -sigma0/4. Signs as in ``fretfe.analytic.edges``; arrays broadcast.

The bound |e| <= a - c is that of the state that is asked for. On the way there from zero, in
proportion, slip at both edges has one direction throughout if |sigma0| <= 4|Q|/(pi a), so that K_T
of the two edges has opposite signs (or one vanishes). Between this and the wider bound, an edge has
slipped the other way at first, and the solution is no longer exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array
from fretfe.analytic._numerics import check_range
from fretfe.analytic.edges import tension_for_zero_factor
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import Hertz

# Share of 4 f p0 by which round-off may take a tension beyond a bound: the bound itself is valid.
ROUND_OFF = 1e-12


def stick_zone_moderate_tension(
    contact: PartialSlip, shear_force: ArrayLike, bulk_tension: ArrayLike
) -> tuple[Array, Array]:
    """Return half-width c and centre e of the stick zone, first loading.

    c as without tension, e = a sigma0/(4 f p0) sign(Q): towards the edge where |K_T| is smaller.
    The slip zones are a - c + e long at the left and a - c - e at the right edge. For a steady
    cycle pass half the ranges.

    Raises:
        ValueError: if the contact is not a Hertz contact, |Q| exceeds f P, or |e| > a - c: the
            tension is then not moderate, slip at the edges has opposite signs.
    """
    a, scale = contact.half_width, _tension_scale(contact)
    c = contact.stick_half_width(shear_force)
    tension = np.asarray(bulk_tension, dtype=np.float64)
    excess = np.abs(tension) / scale - (1.0 - c / a)
    if np.any(excess > ROUND_OFF):
        raise ValueError(
            "bulk_tension must be moderate, else the stick zone reaches an edge and slip there has "
            f"the other sign: |e| <= a - c, found |e| - (a - c) = {a * np.max(excess):g}"
        )
    return c, np.sign(shear_force) * a * tension / scale


def shear_moderate_tension(
    contact: PartialSlip, x: ArrayLike, shear_force: ArrayLike, bulk_tension: ArrayLike
) -> Array:
    """Return q(x) of the first loading, Q and sigma0 in proportion.

    q = sign(Q) f [p(x; a) - p(x - e; c)], the second part that of a Hertz contact of half-width c
    around e, peak pressure p0 c/a.

    Raises:
        ValueError: as ``stick_zone_moderate_tension``.
    """
    c, e = stick_zone_moderate_tension(contact, shear_force, bulk_tension)
    full = contact.profile.pressure(x, contact.half_width)
    inner = contact.profile.pressure(np.asarray(x) - e, c)
    return np.sign(shear_force) * contact.friction * (full - inner)


def cyclic_shear_moderate_tension(
    contact: PartialSlip,
    x: ArrayLike,
    shear_force: ArrayLike,
    *,
    amplitude: float,
    tension_amplitude: float,
    rising: bool,
) -> Array:
    """Return q(x) in the steady cycle of Q between -Q1 and +Q1 and sigma0 = sigma1 Q/Q1.

    To the state at the last reversal comes twice the field of half the changes since.

    Args:
        contact: Hertz contact.
        x: positions.
        shear_force: present Q, |Q| <= Q1, of any shape that broadcasts with ``x``.
        amplitude: Q1 > 0.
        tension_amplitude: sigma1, positive if in phase with Q, negative if in anti-phase.
        rising: whether Q rises from -Q1 (else it falls from +Q1).

    Raises:
        ValueError: if the contact is not a Hertz contact, Q1 is outside (0, f P], Q outside
            [-Q1, Q1], or |sigma1| > 4 Q1/(pi a): slip at one edge is then against that at the
            other right after a reversal.
    """
    check_range("amplitude", amplitude, low=0.0, open_low=True)
    check_range("shear_force", shear_force, low=-amplitude, high=amplitude)
    limit = float(tension_for_zero_factor(amplitude, contact.half_width, "right"))
    if abs(tension_amplitude) > limit + ROUND_OFF * _tension_scale(contact):
        raise ValueError(
            f"tension_amplitude must lie in [-{limit:g}, {limit:g}], else the edges slip in "
            f"opposite directions after each reversal; found {tension_amplitude:g}"
        )
    extreme = -1.0 if rising else 1.0
    share = (np.asarray(shear_force, dtype=np.float64) / amplitude - extreme) / 2.0
    start = shear_moderate_tension(contact, x, extreme * amplitude, extreme * tension_amplitude)
    return start + 2.0 * shear_moderate_tension(
        contact, x, share * amplitude, share * tension_amplitude
    )


def _tension_scale(contact: PartialSlip) -> float:
    """Return 4 f p0, the tension that shifts the stick zone by a."""
    if not isinstance(contact.profile, Hertz):
        raise ValueError(f"contact must have a Hertz profile, found {contact.profile!r}")
    return 4.0 * contact.friction * float(contact.profile.peak_pressure(contact.half_width))
