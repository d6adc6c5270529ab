# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact steady cycles: shear force at constant and at varying normal load; and a rocking pad.

Under cyclic shear +-Q1 the slip zones of any profile reach the edges c of the contact at the normal
load P - Q1/f (Ciavarella 1998; Jäger 1998; Cattaneo 1938 and Mindlin 1949 for Hertz). So the cases
are made from a and c: P = P(a), Q1 = f [P(a) - P(c)].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fretfe.analytic.partial_slip import hertz_dissipation
from fretfe.analytic.profiles import Hertz
from fretfe.case import Case
from fretfe.quality.verify import measures, references
from fretfe.quality.verify.cases import HOLD, Pad, pad_case, press, ramp, rocking_case, wave
from fretfe.quality.verify.loops import (
    E_STAR,
    FRICTION,
    HALF_WIDTH,
    NORMAL_FORCE,
    POISSON,
    RADIUS,
    STEPS,
    YOUNG,
    hertz_pad,
)
from fretfe.quality.verify.measures import LEFT, NAMES, RIGHT
from fretfe.quality.verify.model import Benchmark, Quantity

ANGLE, PUNCH_RADIUS, FLAT = 0.5, 100.0, 0.5
STICK = 0.85
BODIES = {"upper_width": 30.0, "upper_height": 30.0, "lower_width": 60.0, "lower_height": 60.0}


@dataclass(frozen=True)
class Punch:
    """A pad in contact over `HALF_WIDTH` under `load`, with the load for a half-width `STICK`."""

    name: str
    source: str
    pad: Pad
    load: float
    stick_load: float
    k_n: float


def hertz() -> Punch:
    """The pad of the load loops."""
    stick_load = references.hertz_load(STICK, RADIUS, E_STAR)
    k_n = references.hertz_k_n(HALF_WIDTH, RADIUS, E_STAR)
    source = "Cattaneo 1938; Mindlin and Deresiewicz 1953"
    return Punch("Hertz", source, hertz_pad(), NORMAL_FORCE, stick_load, k_n)


def wedge() -> Punch:
    """A wedge of 0.5 degrees on each side."""
    slope = math.tan(math.radians(ANGLE))
    # Elements of 0.01 leave 1.7 % in K_N: at the edge of a wedge p departs soon from a square root.
    parameters = BODIES | {"angle": ANGLE, "zone": 1.1, "size": 0.004, "growth": 0.2}
    return Punch(
        "wedge",
        "Johnson 1985, section 5.2; Ciavarella 1998",
        Pad("wedge", parameters, FRICTION, (YOUNG, YOUNG), POISSON),
        references.wedge_load(HALF_WIDTH, slope, E_STAR),
        references.wedge_load(STICK, slope, E_STAR),
        references.wedge_k_n(HALF_WIDTH, slope, E_STAR),
    )


def flat_rounded() -> Punch:
    """A flat with rounded ends, b/a = 0.5."""
    shape = (FLAT, PUNCH_RADIUS, E_STAR)
    parameters = BODIES | {
        "flat_half_width": FLAT,
        "radius": PUNCH_RADIUS,
        "zone": 1.15,
        # 100 elements over the part of the rounding that is in contact; 50 leave 0.6 % in K_N.
        "edge_size": 0.005,
        "flat_size": 0.05,
        "growth": 0.2,
    }
    return Punch(
        "flat and rounded, b/a = 0.5",
        "Ciavarella, Hills and Monno 1998; Ciavarella 1998",
        Pad("flat_rounded", parameters, FRICTION, (YOUNG, YOUNG), POISSON),
        references.flat_rounded_load(HALF_WIDTH, *shape),
        references.flat_rounded_load(STICK, *shape),
        references.flat_rounded_k_n(HALF_WIDTH, *shape),
    )


def cyclic_shear() -> tuple[Benchmark, ...]:
    """Half-width, K_N, slip lengths; for Hertz the friction work too."""
    return tuple(_cyclic_shear(punch) for punch in (hertz(), wedge(), flat_rounded()))


def _cyclic_shear(punch: Punch) -> Benchmark:
    shear_force = FRICTION * (punch.load - punch.stick_load)
    # Half-planes: K_N of the wedge and of the rounding by a fit, borders to a tenth of an element.
    # Finite elements: the wedge feels its bodies (a 0.1 %), K_N the elements at the edge.
    width = {"analytic": 1e-9, "halfplane": 6e-5, "fem": 0.0012}
    factor = {"analytic": 1e-9, "halfplane": 1e-3, "fem": 0.008}
    length = {"analytic": 1e-9, "halfplane": 6e-4, "fem": 0.002}
    quantities = [
        Quantity("a", HALF_WIDTH, HALF_WIDTH, width, measures.half_width),
        Quantity("K_N", punch.k_n, punch.k_n, factor, measures.k_n),
        *(
            Quantity(
                f"d {NAMES[side]}",
                HALF_WIDTH - STICK,
                HALF_WIDTH,
                length,
                measures.slip_length(side),
            )
            for side in (LEFT, RIGHT)
        ),
    ]
    if punch.pad.template == "cylinder":
        quantities.append(_friction_work(punch.load, shear_force))
    return Benchmark(
        name=f"cyclic shear, {punch.name}",
        source=punch.source,
        case=pad_case(
            punch.pad,
            normal=[press(punch.load)],
            shear=[HOLD, wave(shear_force, steps=STEPS)],
        ),
        quantities=tuple(quantities),
    )


def _friction_work(load: float, shear_force: float) -> Quantity:
    """W = 4 (fP)^2/(pi E*) [u (2 - u)/2 + (1 - u) ln(1 - u)], u = Q1/(fP), both edges."""
    work = float(hertz_dissipation(Hertz(RADIUS, E_STAR), load, FRICTION, shear_force))
    # The work goes with the cube of the slip length.
    tolerances = {"analytic": 1e-9, "halfplane": 5e-4, "fem": 0.005}
    return Quantity("friction work", work, work, tolerances, measures.dissipation)


def varying_normal_load() -> tuple[Benchmark, ...]:
    """P between P_max and P_max/2, in phase with Q and 90 degrees out of phase.

    The permanent stick zone is the contact area at P* = [min(Q + fP) - max(Q - fP)]/(2f) (Barber,
    Davies and Hills 2011). For P = Pm + Pa sin t, Q = Qa sin t, Qa > f Pa this is Pm - Qa/f, and
    for P = Pm + Pa cos t it is Pm - sqrt(Pa^2 + (Qa/f)^2).
    """
    mean, change = 0.75 * NORMAL_FORCE, 0.25 * NORMAL_FORCE
    carried = 0.4 * mean
    return (
        _varying("in phase", 0.0, mean, change, carried, mean - carried),
        _varying("90° apart", 90.0, mean, change, carried, mean - math.hypot(change, carried)),
    )


def _varying(
    name: str, lead: float, mean: float, change: float, carried: float, stick_load: float
) -> Benchmark:
    """P leads Q; `carried` is Qa/f, `stick_load` P*."""
    border = HALF_WIDTH * math.sqrt(stick_load / NORMAL_FORCE)
    pad = hertz_pad()
    start = mean + change * math.sin(math.radians(lead))
    # Out of phase the extremes of Q - fP and Q + fP lie between steps: 2e-6. The edge travels over
    # 0.18 a, and all of that slips: finite elements find the border to half an element of 0.01 a.
    tolerances = {"analytic": 5e-6, "halfplane": 4e-4, "fem": 0.008}
    return Benchmark(
        name=f"normal load varies, {name}",
        source="Barber, Davies and Hills 2011",
        case=pad_case(
            replace(pad, parameters={**pad.parameters, "size": 0.01 * HALF_WIDTH}),
            normal=[press(start), wave(change, mean=mean, phase=lead, steps=STEPS)],
            shear=[HOLD, wave(FRICTION * carried, steps=STEPS)],
        ),
        quantities=tuple(
            Quantity(
                f"permanent stick, {NAMES[side]} border",
                sign * border,
                HALF_WIDTH,
                tolerances,
                measures.stick_border(side),
            )
            for side, sign in ((LEFT, -1.0), (RIGHT, 1.0))
        ),
    )


def rocking() -> Benchmark:
    """A pad that is free to turn: the Hertz contact shifts by M/P, its width stays."""
    shift = 0.1 * HALF_WIDTH
    tolerances = {"analytic": 1e-9, "halfplane": 6e-5, "fem": 0.0015}
    return Benchmark(
        name="moment, Hertz",
        source="a parabola that turns is the same parabola at another place: Johnson 1985, 4.2",
        case=_rocking_case(shift),
        quantities=tuple(
            Quantity(
                f"{NAMES[side]} edge",
                sign * HALF_WIDTH + shift,
                HALF_WIDTH,
                tolerances,
                measures.position(side),
            )
            for side, sign in ((LEFT, -1.0), (RIGHT, 1.0))
        ),
    )


def _rocking_case(shift: float) -> Case:
    """The moment M = P shift is that of a shear force at the top of the pad."""
    pad = hertz_pad()
    pressure = NORMAL_FORCE / (2 * pad.parameters["upper_width"])
    shear = pressure * shift / pad.parameters["upper_height"]
    return rocking_case(pad, pressure=[press(pressure)], shear=[HOLD, ramp(shear, 4)])
