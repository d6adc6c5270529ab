# SPDX-License-Identifier: LGPL-3.0-or-later
"""Exact steady cycles of shear force and bulk tension, at constant and at varying normal load."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from fretfe.analytic.partial_slip import hertz_dissipation
from fretfe.analytic.profiles import Hertz
from fretfe.case import Case
from fretfe.quality import measures, pads
from fretfe.quality.comparison import Benchmark, Measure, Quantity
from fretfe.quality.pads import HOLD, Pad, pad_case, press, ramp, rocking_case, wave

HALF_WIDTH = 1.0
RADIUS = 50.0
E_STAR = 100.0
FRICTION = 0.5
PEAK_PRESSURE = 1.0
POISSON = 0.3
# Both bodies alike: 1/E* = 2 (1 - nu^2)/E.
YOUNG = 2 * (1 - POISSON**2) * E_STAR
NORMAL_FORCE = pads.hertz_load(HALF_WIDTH, RADIUS, E_STAR)
# All lags are whole steps. At a lag of 90 degrees K_T turns at a step too.
STEPS = 72
# Unlike bodies: steps in a cycle, and known values at the left and the right edge.
UNLIKE_STEPS = 16
UNLIKE_SLIP = (0.17360, 0.15306)
UNLIKE_K_N = (1.43094, 1.39545)
UNLIKE_RANGE = 0.105826
ANGLE = 0.5
PUNCH_RADIUS = 100.0
FLAT = 0.5
STICK = 0.85
BODIES = {"upper_width": 30.0, "upper_height": 30.0, "lower_width": 60.0, "lower_height": 60.0}


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
TENSION_ONLY = LOOPS[2]
LAGGING = LOOPS[5]


def hertz_pad(friction: float = FRICTION) -> Pad:
    """The pad that gives E* = 100 and, under `NORMAL_FORCE`, a = 1 and p0 = 1."""
    parameters = pads.hertz_parameters(RADIUS, HALF_WIDTH)
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


def at_both_edges(
    name: str,
    known: Sequence[float],
    scale: float,
    tolerances: dict[str, float],
    measure: Callable[[int], Measure],
) -> tuple[Quantity, ...]:
    """A quantity at the left and at the right edge; the edge goes into its name."""
    return tuple(
        Quantity(name.format(edge), known[side], scale, tolerances, measure(side))
        for side, edge in enumerate(("left", "right"))
    )


def slip_lengths(loop: Loop) -> tuple[Quantity, ...]:
    """Slip lengths at the left and the right edge."""
    # The table resolves 0.005. Where the closed form is not exact it is the asymptote: 0.0114 off
    # for the longest of these zones, of the order of d^2/(2a).
    tolerances = {"halfplane": 0.005, "fem": 0.009}
    return at_both_edges("d {}", loop.length, HALF_WIDTH, tolerances, measures.slip_length)


def predicted_lengths(loop: Loop) -> tuple[Quantity, ...]:
    """ΔK_T/(f K_N) at both edges, for the known range of K_T."""
    # Four digits are given. Finite elements: 0.5 % in ΔK_T or K_N of the longest zone, 0.2 a.
    digits = 0.5e-4 + loop.missed * max(loop.asymptotic)
    tolerances = {"halfplane": digits + 2e-5, "fem": 0.001}
    return at_both_edges(
        "ΔK_T/(f K_N) {}", loop.asymptotic, HALF_WIDTH, tolerances, measures.predicted_length
    )


def factor_ranges(loop: Loop) -> tuple[Quantity, ...]:
    """ΔK_T at both edges, relative to the larger one: the loads may cancel at the other edge."""
    ranges = pads.k_t_ranges(
        loop.shear * FRICTION * NORMAL_FORCE,
        loop.tension * FRICTION * PEAK_PRESSURE,
        math.radians(loop.lag),
        HALF_WIDTH,
    )
    # Half-planes: the half-width, which is fitted. Finite elements: fits of K_T, and bodies; two
    # ways of fitting differed by 0.2 %.
    tolerances = {"halfplane": loop.missed + 3e-5, "fem": 0.004}
    return at_both_edges("ΔK_T {}", ranges, max(ranges), tolerances, measures.k_t_range)


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
    stick_load = pads.hertz_load(STICK, RADIUS, E_STAR)
    k_n = pads.hertz_k_n(HALF_WIDTH, RADIUS, E_STAR)
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
        pads.wedge_load(HALF_WIDTH, slope, E_STAR),
        pads.wedge_load(STICK, slope, E_STAR),
        pads.wedge_k_n(HALF_WIDTH, slope, E_STAR),
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
        pads.flat_rounded_load(HALF_WIDTH, *shape),
        pads.flat_rounded_load(STICK, *shape),
        pads.flat_rounded_k_n(HALF_WIDTH, *shape),
    )


def cyclic_shear() -> tuple[Benchmark, ...]:
    """Half-width, K_N, slip lengths; for Hertz the friction work too."""
    return tuple(_cyclic_shear(punch) for punch in (hertz(), wedge(), flat_rounded()))


def _cyclic_shear(punch: Punch) -> Benchmark:
    shear_force = FRICTION * (punch.load - punch.stick_load)
    # Half-planes: K_N of the wedge and of the rounding by a fit, borders to a tenth of an element.
    # Finite elements: the wedge feels its bodies (a 0.1 %), K_N the elements at the edge.
    width = {"halfplane": 6e-5, "fem": 0.0012}
    factor = {"halfplane": 1e-3, "fem": 0.008}
    length = {"halfplane": 6e-4, "fem": 0.002}
    quantities = [
        Quantity("a", HALF_WIDTH, HALF_WIDTH, width, measures.half_width),
        Quantity("K_N", punch.k_n, punch.k_n, factor, measures.k_n),
        *at_both_edges("d {}", (HALF_WIDTH - STICK,) * 2, HALF_WIDTH, length, measures.slip_length),
    ]
    if punch.pad.template == "cylinder":
        quantities.append(_friction_work(punch.load, shear_force))
    return Benchmark(
        name=f"cyclic shear, {punch.name}",
        source=punch.source,
        case=pad_case(
            punch.pad, normal=[press(punch.load)], shear=[HOLD, wave(shear_force, steps=STEPS)]
        ),
        quantities=tuple(quantities),
    )


def unlike_bodies() -> Benchmark:
    """Titanium on steel as far as Young's moduli go, beta = -.085: K_N and d at either edge, ΔK_T.

    Between unlike bodies K_N and K_T are those at lengths, and the edges differ.
    """
    ratio, load = 210 / 114, pads.hertz_load(HALF_WIDTH, RADIUS, E_STAR)
    soft = (1 - POISSON**2) * E_STAR * (1 + 1 / ratio)
    parameters = pads.hertz_parameters(RADIUS, HALF_WIDTH) | {"size": 0.01 * HALF_WIDTH}
    pad = Pad("cylinder", parameters, FRICTION, (soft, soft * ratio), POISSON)
    factor, length = {"halfplane": 2e-3, "fem": 0.01}, {"halfplane": 6e-4, "fem": 0.004}
    width = {"halfplane": 1e-3, "fem": 5e-3}
    slip, k_n = UNLIKE_SLIP, UNLIKE_K_N
    return Benchmark(
        name="cyclic shear, unlike bodies",
        source="half-planes with the coupling of pressure and shear, of its own, 900 elements",
        case=pad_case(
            pad, normal=[press(load)], shear=[HOLD, wave(0.3 * FRICTION * load, steps=UNLIKE_STEPS)]
        ),
        quantities=(
            *at_both_edges("K_N {}", k_n, k_n[0], factor, measures.slipping_k_n),
            *at_both_edges("d {}", slip, HALF_WIDTH, length, measures.slip_length),
            *at_both_edges("ΔK_T {}", (UNLIKE_RANGE,) * 2, UNLIKE_RANGE, width, measures.k_t_range),
        ),
    )


def _friction_work(load: float, shear_force: float) -> Quantity:
    """W = 4 (fP)^2/(pi E*) [u (2 - u)/2 + (1 - u) ln(1 - u)], u = Q1/(fP), both edges."""
    work = float(hertz_dissipation(Hertz(RADIUS, E_STAR), load, FRICTION, shear_force))
    # The work goes with the cube of the slip length.
    tolerances = {"halfplane": 5e-4, "fem": 0.005}
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
    tolerances = {"halfplane": 4e-4, "fem": 0.008}
    return Benchmark(
        name=f"normal load varies, {name}",
        source="Barber, Davies and Hills 2011",
        case=pad_case(
            replace(pad, parameters={**pad.parameters, "size": 0.01 * HALF_WIDTH}),
            normal=[press(start), wave(change, mean=mean, phase=lead, steps=STEPS)],
            shear=[HOLD, wave(FRICTION * carried, steps=STEPS)],
        ),
        quantities=at_both_edges(
            "permanent stick, {} border",
            (-border, border),
            HALF_WIDTH,
            tolerances,
            measures.stick_border,
        ),
    )


def rocking() -> Benchmark:
    """A pad that is free to turn: the Hertz contact shifts by M/P, its width stays."""
    shift = 0.1 * HALF_WIDTH
    tolerances = {"halfplane": 6e-5, "fem": 0.0015}
    return Benchmark(
        name="moment, Hertz",
        source="a parabola that turns is the same parabola at another place: Johnson 1985, 4.2",
        case=_rocking_case(shift),
        quantities=at_both_edges(
            "{} edge",
            (shift - HALF_WIDTH, shift + HALF_WIDTH),
            HALF_WIDTH,
            tolerances,
            measures.position,
        ),
    )


def _rocking_case(shift: float) -> Case:
    """The moment M = P shift is that of a shear force at the top of the pad."""
    pad = hertz_pad()
    pressure = NORMAL_FORCE / (2 * pad.parameters["upper_width"])
    shear = pressure * shift / pad.parameters["upper_height"]
    return rocking_case(pad, pressure=[press(pressure)], shear=[HOLD, ramp(shear, 4)])
