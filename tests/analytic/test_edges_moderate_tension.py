# SPDX-License-Identifier: LGPL-3.0-or-later
"""Hertz with moderate tension: strains in the stick zone by quadrature, friction law, balance."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import tangential_factor
from fretfe.analytic.partial_slip import (
    PartialSlip,
    cyclic_shear_moderate_tension,
    shear_moderate_tension,
    stick_zone_moderate_tension,
)
from fretfe.analytic.profiles import Hertz, Wedge, composite_modulus

P, F = 5.0, 0.4
LIMIT = F * P
CONTACT = PartialSlip(Hertz(2.0, 60.0), P, F)
A = CONTACT.half_width
# The tension at which K_T of one edge vanishes under Q = f P.
TENSION = 4 * LIMIT / (np.pi * A)
both_signs = pytest.mark.parametrize("sign", [1.0, -1.0])
both_phases = pytest.mark.parametrize("phase", [1.0, -1.0])
SIDES: tuple[Side, Side] = ("left", "right")
Traction = Callable[[float], float]


def integral(traction: Traction, *breaks: float) -> float:
    """Integrate over the contact in x = a sin t, broken where the traction has a kink."""
    angles = [-np.pi / 2, *sorted(np.arcsin(np.array(breaks) / A)), np.pi / 2]

    def density(t: float) -> float:
        return traction(A * np.sin(t)) * A * np.cos(t)

    ends = pairwise(angles)
    return float(sum(quad(density, *pair, epsabs=1e-11, limit=200)[0] for pair in ends))


def hilbert(traction: Traction, x: float, *breaks: float) -> float:
    """Return (1/pi) PV int q(t)/(t - x) dt over the contact, the singularity taken out."""
    at = traction(x)
    regular = integral(lambda t: (traction(t) - at) / (t - x) if t != x else 0.0, x, *breaks)
    return (regular + at * np.log((A - x) / (A + x))) / np.pi


@both_signs
@both_phases
@pytest.mark.parametrize("share", [0.2, 0.6])
def test_stick_zone_bears_the_strain_of_the_tension(
    share: float, sign: float, phase: float
) -> None:
    force, tension = sign * share * LIMIT, sign * phase * 0.7 * share * TENSION
    c, e = (float(v) for v in stick_zone_moderate_tension(CONTACT, force, tension))

    def q(x: float) -> float:
        return float(shear_moderate_tension(CONTACT, x, force, tension))

    found = [hilbert(q, e + place * c, e - c, e + c) for place in (-0.8, 0.1, 0.7)]
    # Square-root ends inside the quadrature: eight digits.
    assert found == pytest.approx([-tension / 4] * 3, rel=1e-7)
    assert integral(q, e - c, e + c) == pytest.approx(force, rel=1e-9)


def test_hilbert_of_the_stuck_traction_of_tension() -> None:
    # Of -sigma0 x/(4 sqrt(a^2 - x^2)), cut off where quadrature meets the singular ends.
    def q(x: float) -> float:
        return -3.0 * x / (4 * np.sqrt((A - x) * (A + x)))

    # Fixes the sign of the condition; the integrand stays singular at the ends.
    assert hilbert(q, 0.3 * A) == pytest.approx(-3.0 / 4, rel=1e-6)


@both_signs
@both_phases
def test_stick_zone_moves_to_the_smaller_factor(sign: float, phase: float) -> None:
    force, tension = sign * 0.5 * LIMIT, sign * phase * 0.2 * TENSION
    _, e = stick_zone_moderate_tension(CONTACT, force, tension)
    left, right = (abs(tangential_factor(force, tension, A, side)) for side in SIDES)
    assert np.sign(e) == (1.0 if right < left else -1.0)
    peak_pressure = 60 * A / 4
    assert abs(e) == pytest.approx(A * 0.2 * TENSION / (4 * F * peak_pressure), rel=1e-13)


@both_signs
@both_phases
def test_friction_law_of_the_first_loading(sign: float, phase: float) -> None:
    force, tension = sign * 0.5 * LIMIT, sign * phase * 0.4 * TENSION
    c, e = stick_zone_moderate_tension(CONTACT, force, tension)
    x = np.linspace(-1, 1, 401) * A
    q, bound = (
        shear_moderate_tension(CONTACT, x, force, tension),
        F * CONTACT.profile.pressure(x, A),
    )
    slips = np.abs(x - e) >= c
    assert slips[1] and slips[-2]
    assert q[slips] == pytest.approx(sign * bound[slips], abs=1e-14)
    assert (np.abs(q[~slips]) < bound[~slips]).all()


def test_no_tension_is_cattaneo() -> None:
    x = np.linspace(-1.2, 1.2, 33) * A
    found = shear_moderate_tension(CONTACT, x, -0.7 * LIMIT, 0.0)
    assert (found == CONTACT.shear(x, -0.7 * LIMIT)).all()
    cyclic = cyclic_shear_moderate_tension(
        CONTACT, x, 0.3 * LIMIT, amplitude=0.7 * LIMIT, tension_amplitude=0.0, rising=True
    )
    expected = CONTACT.cyclic_shear(x, 0.3 * LIMIT, 0.7 * LIMIT, rising=True)
    assert cyclic == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("friction", "c", "e"), [(0.85, 0.81497, 0.07035), (2, 0.92589, 0.02990)])
def test_fretting_specimen(friction: float, c: float, e: float) -> None:
    """Kosec, Slak and Abdel Wahab: 543 N, 155 N, 100 MPa, thickness 4 mm."""
    profile = Hertz(10.0, composite_modulus(72.1e3, 0.33, 72.1e3, 0.33))
    contact = PartialSlip(profile, 543.0 / 4, friction)
    found = np.array(stick_zone_moderate_tension(contact, 155.0 / 4, 100.0)) / contact.half_width
    assert found == pytest.approx([c, e], abs=5e-6)


# --- steady cycle


@both_phases
@pytest.mark.parametrize("rising", [False, True])
@pytest.mark.parametrize("share", [-0.7, 0.0, 0.5])
def test_cycle_balances_and_changes_by_the_tension(
    share: float, rising: bool, phase: float
) -> None:
    peak, tension = 0.6 * LIMIT, phase * 0.8 * 0.6 * TENSION

    def traction(at: float) -> Traction:
        def q(x: float) -> float:
            return float(
                cyclic_shear_moderate_tension(
                    CONTACT, x, at * peak, amplitude=peak, tension_amplitude=tension, rising=rising
                )
            )

        return q

    start = -1.0 if rising else 1.0
    now, before, half = traction(share), traction(start), (share - start) / 2
    zones = [stick_zone_moderate_tension(CONTACT, s * peak, s * tension) for s in (half, start)]
    breaks = [float(e + end * c) for c, e in zones for end in (-1, 1)]
    assert integral(now, *breaks) == pytest.approx(share * peak, abs=1e-9)
    c, e = (float(v) for v in zones[0])
    changed = hilbert(lambda x: now(x) - before(x), e + 0.4 * c, *breaks)
    assert changed == pytest.approx(-(share - start) * tension / 4, rel=1e-7)


@both_phases
@pytest.mark.parametrize("rising", [False, True])
@pytest.mark.parametrize("share", [-0.999999, -0.7, 0.0, 0.5, 0.999999])
def test_friction_law_in_the_cycle(share: float, rising: bool, phase: float) -> None:
    x, peak = np.linspace(-1, 1, 401) * A, 0.6 * LIMIT
    # At the limit of what is moderate: K_T of one edge vanishes.
    tension = phase * 0.6 * TENSION
    q = cyclic_shear_moderate_tension(
        CONTACT, x, share * peak, amplitude=peak, tension_amplitude=tension, rising=rising
    )
    bound, start = F * CONTACT.profile.pressure(x, A), -1.0 if rising else 1.0
    assert (np.abs(q) <= bound + 1e-13).all()
    half = (share - start) / 2
    c, e = stick_zone_moderate_tension(CONTACT, half * peak, half * tension)
    slips = np.abs(x - e) >= c
    assert q[slips] == pytest.approx(-start * bound[slips], abs=1e-13)


@both_phases
def test_cycle_closes(phase: float) -> None:
    x, peak, tension = np.linspace(-1, 1, 41) * A, 0.6 * LIMIT, phase * 0.3 * TENSION
    states = [
        cyclic_shear_moderate_tension(
            CONTACT, x, end, amplitude=peak, tension_amplitude=tension, rising=rising
        )
        for end, rising in [(peak, True), (peak, False), (-peak, True)]
    ]
    expected = shear_moderate_tension(CONTACT, x, peak, tension)
    assert states[0] == pytest.approx(expected, abs=1e-14)
    assert states[1] == pytest.approx(expected, abs=1e-14)
    assert states[2] == pytest.approx(-expected, abs=1e-14)


def test_arrays_broadcast() -> None:
    x, force = np.linspace(-1, 1, 7) * A, np.array([[0.5], [-0.2]]) * LIMIT
    found = cyclic_shear_moderate_tension(
        CONTACT, x, force, amplitude=0.6 * LIMIT, tension_amplitude=0.1, rising=True
    )
    single = cyclic_shear_moderate_tension(
        CONTACT, x[2], -0.2 * LIMIT, amplitude=0.6 * LIMIT, tension_amplitude=0.1, rising=True
    )
    assert found.shape == (2, 7)
    assert found[1, 2] == single


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: stick_zone_moderate_tension(PartialSlip(Wedge(1, 1), P, F), 1, 0),
            "contact must have a Hertz profile, found Wedge",
        ),
        (
            lambda: stick_zone_moderate_tension(CONTACT, [1.0, 0.1], 5.0),
            r"bulk_tension must be moderate, .* found \|e\| - \(a - c\) = 0.196669",
        ),
        (
            lambda: shear_moderate_tension(CONTACT, 0.0, 0.0, 0.1),
            "bulk_tension must be moderate",
        ),
        (lambda: shear_moderate_tension(CONTACT, 0.0, 2.1, 0.1), r"\[-2, 2\], found 2.1: beyond"),
        (
            lambda: cyclic_shear_moderate_tension(
                CONTACT, 0, 0, amplitude=1, tension_amplitude=-1.01 * TENSION / 2, rising=True
            ),
            "tension_amplitude must lie in .* opposite directions after each reversal; found -",
        ),
        (
            lambda: cyclic_shear_moderate_tension(
                CONTACT, 0, 1.1, amplitude=1, tension_amplitude=0, rising=True
            ),
            r"shear_force must lie in \[-1, 1\], found 1.1",
        ),
        (
            lambda: cyclic_shear_moderate_tension(
                CONTACT, 0, 0, amplitude=0, tension_amplitude=0, rising=True
            ),
            r"amplitude must lie in \(0, inf\), found 0",
        ),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
