# SPDX-License-Identifier: LGPL-3.0-or-later
"""Steady cycles of shear force and bulk tension, out of phase, at constant normal load.

Qa cos t and sigma_a cos(t - lag) on a Hertz contact with E* = 100, a = 1, p0 = 1 and f = 0.5. The
slip lengths come from a semi-analytical half-plane solution of its own (300 elements x = a sin u,
third cycle, 60 increments in a cycle) whose resolution is about 0.005 a. In phase there is an exact
solution as well: c = a sqrt(1 - Q/(fP)), shifted by a sigma0/(4 f p0) (Nowell and Hills 1987).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fretfe.case import Case
from fretfe.quality.verify import measures
from fretfe.quality.verify.cases import HOLD, Pad, pad_case, press, wave
from fretfe.quality.verify.classic import hertz_parameters
from fretfe.quality.verify.measures import LEFT, NAMES, RIGHT
from fretfe.quality.verify.model import Benchmark, Quantity
from fretfe.quality.verify.references import hertz_load, k_t_ranges

HALF_WIDTH, RADIUS, E_STAR, FRICTION, PEAK_PRESSURE = 1.0, 50.0, 100.0, 0.5, 1.0
POISSON = 0.3
# Both bodies alike: 1/E* = 2 (1 - nu^2)/E.
YOUNG = 2 * (1 - POISSON**2) * E_STAR
NORMAL_FORCE = hertz_load(HALF_WIDTH, RADIUS, E_STAR)
# All lags are whole steps. At a lag of 90 degrees K_T turns at a step too.
STEPS = 72


@dataclass(frozen=True)
class Loop:
    """A load loop and the slip lengths of its steady cycle, (left, right), in half-widths.

    Attributes:
        shear: Qa/(fP).
        tension: sigma_a/(f p0).
        lag: of the tension, in degrees.
        length: slip lengths, semi-analytical; the shortest one from the exact solution.
        asymptotic: range of K_T over f K_N.
    """

    shear: float
    tension: float
    lag: float
    length: tuple[float, float]
    asymptotic: tuple[float, float]

    @property
    def name(self) -> str:
        """Name of the loop: its loads."""
        return f"loop Q {self.shear:g}, tension {self.tension:g}, lag {self.lag:g}°"

    @property
    def exact(self) -> bool:
        """True if there is an exact solution: shear alone, or in phase with the tension."""
        return self.shear > 0 and self.lag == 0

    @property
    def missed(self) -> float:
        """Largest share of a range that lies between steps: K_T of two sines turns at any time."""
        return 1 - math.cos(math.pi / STEPS) if self.lag else 0.0


# Below the resolution of the semi-analytical solution: 1 - sqrt(1 - 0.15) - 0.3/4.
SHORTEST = 1 - math.sqrt(1 - 0.15) - 0.3 / 4
LOOPS = (
    Loop(0.15, 0.0, 0.0, (0.0781, 0.0781), (0.0750, 0.0750)),
    Loop(0.30, 0.0, 0.0, (0.1613, 0.1613), (0.1500, 0.1500)),
    Loop(0.0, 0.30, 0.0, (0.0741, 0.0741), (0.0750, 0.0750)),
    Loop(0.0, 0.80, 0.0, (0.1910, 0.1910), (0.2000, 0.2000)),
    Loop(0.15, 0.30, 0.0, (0.1501, SHORTEST), (0.1500, 0.0)),
    Loop(0.15, 0.30, 45.0, (0.1393, 0.0556), (0.1386, 0.0574)),
    Loop(0.15, 0.30, 90.0, (0.1090, 0.1043), (0.1061, 0.1061)),
    Loop(0.30, 0.30, 60.0, (0.2098, 0.1393), (0.1984, 0.1299)),
)
TENSION_ONLY, LAGGING = LOOPS[2], LOOPS[5]


def hertz_pad(friction: float = FRICTION) -> Pad:
    """The pad that gives E* = 100 and, under `NORMAL_FORCE`, a = 1 and p0 = 1."""
    parameters = hertz_parameters(RADIUS, HALF_WIDTH)
    return Pad("cylinder", parameters, friction, (YOUNG, YOUNG), POISSON)


def loop_case(loop: Loop, friction: float = FRICTION) -> Case:
    """Three cycles of a loop; the amplitudes always refer to f = 0.5."""
    shear_force = loop.shear * FRICTION * NORMAL_FORCE
    tension = loop.tension * FRICTION * PEAK_PRESSURE
    # Q starts at zero, the tension where its wave starts: it gets there without friction.
    start = -tension * math.sin(math.radians(loop.lag))
    pull = [press(start) if start else HOLD, wave(tension, phase=-loop.lag, steps=STEPS)]
    return pad_case(
        hertz_pad(friction),
        normal=[press(NORMAL_FORCE)],
        shear=[HOLD, *([wave(shear_force, steps=STEPS)] if loop.shear else [])],
        tension=pull if loop.tension else [],
    )


def slip_lengths(loop: Loop) -> tuple[Quantity, ...]:
    """Slip lengths at the left and the right edge."""
    # The table resolves 0.005. Where the closed form is not exact it is the asymptote: 0.0114 off
    # for the longest of these zones, of the order of d^2/(2a).
    tolerances = {"analytic": 0.005 if loop.exact else 0.015, "halfplane": 0.005, "fem": 0.009}
    return tuple(
        Quantity(
            f"d {NAMES[side]}",
            loop.length[side],
            HALF_WIDTH,
            tolerances,
            measures.slip_length(side),
        )
        for side in (LEFT, RIGHT)
    )


def predicted_lengths(loop: Loop) -> tuple[Quantity, ...]:
    """ΔK_T/(f K_N) at both edges, for the known range of K_T."""
    # Four digits are given. Finite elements: 0.5 % in ΔK_T or K_N of the longest zone, 0.2 a.
    digits = 0.5e-4 + loop.missed * max(loop.asymptotic)
    tolerances = {"analytic": digits, "halfplane": digits + 2e-5, "fem": 0.001}
    return tuple(
        Quantity(
            f"ΔK_T/(f K_N) {NAMES[side]}",
            loop.asymptotic[side],
            HALF_WIDTH,
            tolerances,
            measures.predicted_length(side),
        )
        for side in (LEFT, RIGHT)
    )


def factor_ranges(loop: Loop) -> tuple[Quantity, ...]:
    """ΔK_T at both edges, relative to the larger one: the loads may cancel at the other edge."""
    ranges = k_t_ranges(
        loop.shear * FRICTION * NORMAL_FORCE,
        loop.tension * FRICTION * PEAK_PRESSURE,
        math.radians(loop.lag),
        HALF_WIDTH,
    )
    # Half-planes: the half-width, which is fitted. Finite elements: fits of K_T, and bodies; two
    # ways of fitting differed by 0.2 %.
    tolerances = {
        "analytic": loop.missed + 1e-9,
        "halfplane": loop.missed + 3e-5,
        "fem": 0.004,
    }
    return tuple(
        Quantity(
            f"ΔK_T {NAMES[side]}", ranges[side], max(ranges), tolerances, measures.k_t_range(side)
        )
        for side in (LEFT, RIGHT)
    )


def loop_benchmarks() -> tuple[Benchmark, ...]:
    """One benchmark for each loop."""
    return tuple(
        Benchmark(
            name=loop.name,
            source="semi-analytical half-plane solution; ΔK_T of the stuck contact in closed form",
            case=loop_case(loop),
            quantities=(*slip_lengths(loop), *predicted_lengths(loop), *factor_ranges(loop)),
        )
        for loop in LOOPS
    )
