# SPDX-License-Identifier: LGPL-3.0-or-later
"""Published contacts under one loading, and blocks that slide: closed forms, written out here."""

from __future__ import annotations

from pathlib import Path

from fretfe.case import Case, parse_case
from fretfe.quality import measures
from fretfe.quality.comparison import Benchmark, Measure, Quantity
from fretfe.quality.pads import FACES, HOLD, Pad, hertz_parameters, pad_case, press, ramp

# Published numbers have six digits. Fits of K_N promise a thousandth.
DIGITS = 5e-6
FITTED = 1e-3
SHEAR_STEPS = 8
PLATE_MESH = Path(__file__).with_name("plate.msh")
MESH = Path(__file__).with_name("sliding_wedge.msh")
SLOPE = 0.1
FRICTION = 0.3
# The force gives a mean pressure of 0.25 % of E: elastic displacements are a few thousandths of the
# length, and the push makes all of the contact slip.
YOUNG = 200e3
FORCE = 1000.0
PUSH = 0.02


def relative(
    name: str, reference: float, measure: Measure, tolerances: dict[str, float]
) -> Quantity:
    """A quantity whose differences are fractions of its known value."""
    return Quantity(name, reference, abs(reference), tolerances, measure)


def two_cylinders() -> Benchmark:
    """Two equal cylinders, pressed and sheared once."""
    half_width = 0.680778
    # As wide as the radius allows. Tall bodies turn under the shear force, and a common rotation
    # moves the two curved faces past each other: 12 half-widths leave K_T 0.6 % high.
    body = {"width": 7.0, "height": 8.0, "radius": 8.0}
    parameters = {f"{side}_{key}": body[key] for side in ("upper", "lower") for key in body}
    pad = Pad("cylinder", parameters, friction=0.2, young=(200.0, 200.0), poisson=0.3)
    return Benchmark(
        name="two cylinders, Cattaneo-Mindlin",
        source="Cattaneo 1938; Mindlin 1949; data of Yang, Laursen and Meng 2005 (Ansys VM272)",
        case=pad_case(pad, normal=[press(10.0)], shear=[HOLD, ramp(0.93616, SHEAR_STEPS)]),
        quantities=(*_cylinder_factors(half_width), *_cylinder_shear()),
    )


def _cylinder_factors(half_width: float) -> tuple[Quantity, ...]:
    # Half-planes: the fits at the edge, on elements of 0.003 a there; the border of the stick zone
    # is found to a tenth of an element. Finite elements: bodies of 12 a,
    # which leave 0.3 to 0.6 % in K_T.
    width = {"halfplane": 6e-5, "fem": 0.005}
    factor = width | {"halfplane": FITTED}
    shear_factor = width | {"halfplane": 2e-5, "fem": 0.01}
    length = {"halfplane": 5e-4, "fem": 0.002}
    return (
        relative("a", half_width, measures.half_width, width),
        relative("p0", 9.351351, measures.peak_pressure, width),
        relative("K_N", 16.02826, measures.k_n, factor),
        relative("K_T", 0.255377, measures.k_t, shear_factor),
        Quantity("d", 0.184267, half_width, length, measures.mean_slip_length),
    )


def _cylinder_shear() -> tuple[Quantity, ...]:
    values = {0.0: 0.5062, 0.2: 0.5393, 0.4: 0.7053, 0.55: 1.1022, 0.6: 0.8837}
    largest = max(values.values())
    # Four digits are given. Finite elements: next to the border of the stick zone q has a kink, and
    # a shift of that by 0.002 a is what 0.5 % are.
    tolerances = {"halfplane": 3e-4, "fem": 0.01}
    return tuple(
        Quantity(f"q at x = {x:g}", q, largest, tolerances, measures.shear_at(x))
        for x, q in values.items()
    )


def cylinder_on_block() -> Benchmark:
    """A steel cylinder on an aluminium block, pressed without friction."""
    half_width, radius = 6.2146, 50.0
    parameters = hertz_parameters(radius, half_width) | {
        # A cylinder is at most twice its radius wide.
        "upper_width": 45.0,
        "upper_height": 60.0,
    }
    pad = Pad("cylinder", parameters, friction=0.0, young=(210e3, 70e3), poisson=0.3)
    # Five digits are given for a. Finite elements: the face is a circle, which rises 0.4 % more
    # than the parabola at the edge, and the cylinder is 14 a wide.
    width = {"halfplane": 6e-5, "fem": 0.0013}
    pressure = width | {"fem": 0.004}
    factor = {"halfplane": FITTED, "fem": 0.01}
    return Benchmark(
        name="cylinder on block, frictionless",
        source="Hertz 1882; data of NAFEMS contact benchmark 1 (Konter 2006)",
        case=pad_case(pad, normal=[press(35e3)]),
        quantities=(
            relative("a", half_width, measures.half_width, width),
            relative("p0", 3585.36, measures.peak_pressure, pressure),
            relative("K_N", 2033.95, measures.k_n, factor),
        ),
    )


def fretting_specimens() -> tuple[Benchmark, ...]:
    """A pad on a specimen under shear force and bulk tension in proportion."""
    return _specimen(0.85, 0.81497, 0.07035), _specimen(2.0, 0.92589, 0.02990)


def _specimen(friction: float, stick: float, centre: float) -> Benchmark:
    half_width, radius = 0.206698, 10.0
    parameters = hertz_parameters(radius, half_width)
    pad = Pad("cylinder", parameters, friction, (72.1e3, 72.1e3), 0.33, thickness=4.0)
    width = {"halfplane": 6e-5, "fem": 0.001}
    factor = {"halfplane": FITTED, "fem": 0.0015}
    # Five digits are given. The borders of the stick zone are found to a tenth of an element.
    length = {"halfplane": 3e-4, "fem": 0.0025}
    return Benchmark(
        name=f"fretting specimen, f = {friction:g}",
        source="Nowell and Hills 1987; data of Kosec, Slak, Abdel Wahab et al. 2019",
        case=pad_case(
            pad,
            normal=[press(543.0)],
            shear=[HOLD, ramp(155.0, SHEAR_STEPS)],
            tension=[HOLD, ramp(100.0, SHEAR_STEPS)],
        ),
        quantities=(
            relative("a", half_width, measures.half_width, width),
            relative("p0", 418.104, measures.peak_pressure, width),
            relative("K_N", 1300.56, measures.k_n, factor),
            Quantity("c/a", stick, 1.0, length, measures.stick_half_width_ratio),
            Quantity("e/a", centre, 1.0, length, measures.stick_centre_ratio),
        ),
    )


def unloaded_cylinder() -> Benchmark:
    """A cylinder on a flat, sheared once to half of f P, then unloaded: slip in both directions.

    The published program is of level sets with wear; its tractions were compared with Mindlin's.
    """
    half_width, load, friction = 0.091336, 120.0, 0.6
    parameters = hertz_parameters(6.0, half_width) | {"upper_width": 20 * half_width}
    pad = Pad("cylinder", parameters, friction, (200e3, 200e3), 0.3)
    shear = friction * load / 2
    width = {"halfplane": 6e-5, "fem": 0.0015}
    # Four digits are given. The borders are found to a tenth of an element.
    length = {"halfplane": 6e-4, "fem": 0.003}
    return Benchmark(
        name="cylinder, sheared and unloaded",
        source="Mindlin and Deresiewicz 1953; data of LevelSetWear 2026, figure 11",
        case=pad_case(
            pad,
            normal=[press(load)],
            shear=[
                HOLD,
                ramp(shear, SHEAR_STEPS),
                {"ramp": 0.0, "until": 3.0, "steps": SHEAR_STEPS},
            ],
        ),
        quantities=(
            relative("a", half_width, measures.half_width, width),
            Quantity("d loaded", 0.02675, half_width, length, measures.first_slip_length),
            Quantity("d unloaded", 0.01224, half_width, length, measures.mean_slip_length),
        ),
    )


def pushed_plate() -> Benchmark:
    """Half of a plate on a rigid plane, pressed down and pushed from its side in proportion.

    Displacements along the plane, of a group of codes; the source asks for 5 % of each.
    """
    values = {0.0: 28.6, 1.25: 27.2, 5.0: 22.8, 7.5: 19.8, 11.25: 15.0}
    largest = max(values.values())
    loads = {
        name: {
            "type": "traction",
            "boundary": boundary,
            "direction": direction,
            "history": [{"ramp": pressure, "until": 1.0, "steps": SHEAR_STEPS}],
        }
        for name, boundary, direction, pressure in (
            ("press", "upper_top", [0.0, -1.0], 50.0),
            ("push", "upper_left", "x", 150.0),
        )
    }
    supports = {"middle": "upper_middle", "rest": "lower_middle"}
    case = parse_case(
        {
            "geometry": {"file": PLATE_MESH.name},
            "bodies": {
                "upper": {"young": 130e3, "poisson": 0.2},
                "lower": {"young": 1e10, "poisson": 0.2},
            },
            "contacts": {"main": {**FACES, "friction": 1.0}},
            "supports": {
                "base": {"boundary": "lower_bottom", "fix": ["x", "y"]},
                **{name: {"boundary": each, "fix": ["x"]} for name, each in supports.items()},
            },
            "loads": loads,
            "output": {"fields": "none"},
        },
        source=PLATE_MESH.with_name("plate.toml"),
    )
    return Benchmark(
        name="pushed plate",
        source="GRECO, code_aster SSNV128 (V6.04.128)",
        case=case,
        # Three digits. Of the last one that of code_aster itself, 15.61, is 4 % off.
        quantities=tuple(
            Quantity(
                f"u at x = {x:g}", u * 1e-3, largest * 1e-3, {"fem": 0.015}, measures.slip_at(x)
            )
            for x, u in values.items()
        ),
    )


def sliding_wedge() -> Benchmark:
    """A block on a wedge, pressed down with a force and pushed uphill."""
    ratio = (SLOPE + FRICTION) / (1 - FRICTION * SLOPE)
    # Exact in any discretisation: equilibrium is met to the accuracy of the solver.
    tolerances = {"fem": 1e-6}
    measure = measures.force_ratio("push", "press")
    return Benchmark(
        name="sliding wedge block",
        source="NAFEMS CGS-4 (Feng and Prinja 2001)",
        case=_case(),
        quantities=(Quantity("H/V", ratio, ratio, tolerances, measure),),
    )


def _case() -> Case:
    body = {"young": YOUNG, "poisson": 0.3}
    platen = {"type": "platen", "boundary": "upper_top"}
    by_force, by_displacement = ({**platen, "control": each} for each in ("force", "displacement"))
    return parse_case(
        {
            "geometry": {"file": MESH.name},
            "bodies": {"upper": body, "lower": body},
            "contacts": {"main": {**FACES, "friction": FRICTION}},
            "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
            "loads": {
                "press": {**by_force, "direction": [0.0, -1.0], "history": [press(FORCE)]},
                "push": {**by_displacement, "direction": "x", "history": [HOLD, ramp(PUSH, 8)]},
            },
            "output": {"fields": "none"},
        },
        source=MESH.with_name("sliding_wedge.toml"),
    )
