# SPDX-License-Identifier: LGPL-3.0-or-later
"""From a case to half-planes: what it becomes, and every reason why it does not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.pad_cases import (
    BASE,
    HOLD,
    ROUGH,
    SLIDING,
    STEEL,
    cylinder,
    pad,
    press,
    pull,
    shear,
    wave,
)
from reference.closed_forms import closed_contact

from fretfe.analytic.profiles import FlatRounded, Hertz, Wedge
from fretfe.case import parse_case
from fretfe.errors import ConvergenceError, FretfeError, ModelError
from fretfe.idealise import NotIdealisable, idealise, obstacles
from fretfe.idealise.problem import contact_edges, governing_length

E_STAR = 210e3 / (2 * 0.91)


def test_a_cylindrical_pad() -> None:
    problem = idealise(parse_case(pad()))
    assert isinstance(problem.profile, Hertz) and problem.profile.radius == 50.0
    assert problem.profile.e_star == pytest.approx(E_STAR)
    assert problem.normal_force[[0, 2, 4, -1]].tolist() == [0.0, 300.0, 600.0, 600.0]
    assert problem.shear_force.max() == 60.0 == -problem.shear_force.min()
    assert not problem.moment.any() and not problem.bulk_tension.any()
    # friction acts after time 1
    assert problem.friction[:5].tolist() == [0.0] * 5 and set(problem.friction[5:]) == {0.4}
    assert problem.contact == "main" and (problem.body1, problem.body2) == ("upper", "lower")
    assert "M = 0" in " ".join(problem.notes)


def test_two_cylinders_and_plane_stress() -> None:
    parameters = {"upper_radius": 8.0, "lower_radius": 24.0, "upper_width": 6.0, "lower_width": 6.0}
    case = pad(
        geometry={"template": "cylinder", "parameters": parameters},
        model={"plane": "stress"},
        bodies={"upper": STEEL, "lower": {"young": 205e3, "poisson": 0.29}},
    )
    problem = idealise(parse_case(case))
    assert isinstance(problem.profile, Hertz)
    assert problem.profile.radius == pytest.approx(6.0)
    assert problem.profile.e_star == pytest.approx(1 / (1 / 210e3 + 1 / 205e3))
    assert problem.dundurs != 0


def test_wedge_and_flat_rounded() -> None:
    wedge = pad(geometry={"template": "wedge", "parameters": {"angle": 1.5}})
    profile = idealise(parse_case(wedge)).profile
    assert isinstance(profile, Wedge) and profile.slope == pytest.approx(np.tan(np.radians(1.5)))
    values = {"flat_half_width": 1.0, "radius": 40.0, "upper_width": 15.0, "zone": 1.5}
    punch = pad(geometry={"template": "flat_rounded", "parameters": values})
    profile = idealise(parse_case(punch)).profile
    assert isinstance(profile, FlatRounded)
    assert (profile.flat_half_width, profile.radius) == (1.0, 40.0)


def test_forces_are_per_unit_thickness() -> None:
    problem = idealise(parse_case(pad(model={"thickness": 4.0})))
    assert problem.normal_force[-1] == 150.0 and problem.shear_force.max() == 15.0


def test_an_oblique_platen() -> None:
    load = {**press(500.0), "direction": [-0.06, 1.0]}
    loads = {"press": load, "across": {**shear(0.0), "direction": [1.0, 0.06]}}
    case = pad(loads=loads, contacts={"main": {**pad()["contacts"]["main"], "friction_from": 0.0}})
    problem = idealise(parse_case(case))
    unit = np.array([-0.06, 1.0]) / np.hypot(0.06, 1.0)
    assert problem.normal_force[-1] == pytest.approx(500 * unit[1])
    assert problem.shear_force[-1] == pytest.approx(-500 * unit[0])


@pytest.mark.parametrize(("side", "other"), [("lower_right", "left"), ("lower_left", "right")])
def test_bulk_tension(side: str, other: str) -> None:
    supports = {**SLIDING, "side": {"boundary": f"lower_{other}", "fix": ["x"]}}
    loads = {"press": press(), "shear": shear(), "pull": pull(100.0, side)}
    problem = idealise(parse_case(pad(supports=supports, loads=loads)))
    peak, sign = np.argmax(problem.shear_force), 1.0 if side == "lower_right" else -1.0
    # A positive normal traction pulls, on either side; similar bodies: sigma0 is that tension. The
    # held side carries Q = 60 over the height 12, half of which half-planes would not have there:
    # 1.16 times as much in a block as high as half of its width, by finite elements.
    share = 1.16 * sign * 60.0 / 24.0
    assert problem.bulk_tension[peak] == pytest.approx(100.0 + share)
    assert problem.bulk_tension[[0, 4]].tolist() == [0.0, 0.0]
    along = {**pull(100.0, side), "direction": "x"}
    problem = idealise(parse_case(pad(supports=supports, loads={**loads, "pull": along})))
    assert problem.bulk_tension[peak] == pytest.approx(sign * 100.0 + share)


FREE, GLUED = SLIDING["base"], BASE["base"]
LEFT, RIGHT = ({"boundary": f"lower_{side}", "fix": ["x"]} for side in ("left", "right"))
ROLLER = {"boundary": "lower_left", "direction": [-2.0, 0.0]}
NARROW, LOW = {"lower_width": 6.0}, {"lower_height": 6.0}
# ΔK_T at the left and at the right edge by finite elements of 0.015 (order 2), nu = .3.
HELD: dict[str, tuple[dict[str, Any], dict[str, float], tuple[float, float]]] = {
    "base": ({"b": GLUED}, {}, (35.551, 35.551)),
    "left": ({"b": FREE, "l": LEFT}, {}, (36.363, 34.805)),
    "roller": ({"b": FREE, "l": ROLLER}, {}, (36.363, 34.805)),
    "right": ({"b": FREE, "r": RIGHT}, {}, (34.805, 36.363)),
    "both": ({"b": FREE, "l": LEFT, "r": RIGHT}, {}, (35.594, 35.594)),
    "base and left": ({"b": GLUED, "l": LEFT}, {}, (36.222, 34.935)),
    "base and both": ({"b": GLUED, "l": LEFT, "r": RIGHT}, {}, (35.595, 35.595)),
    "left, low": ({"b": FREE, "l": LEFT}, LOW, (36.932, 34.252)),
    "base and left, low": ({"b": GLUED, "l": LEFT}, LOW, (35.743, 35.392)),
    "left, narrow": ({"b": FREE, "l": LEFT}, NARROW, (37.597, 33.566)),
    "base and left, narrow": ({"b": GLUED, "l": LEFT}, NARROW, (37.548, 33.622)),
}


@pytest.mark.parametrize(("supports", "sizes", "expected"), HELD.values(), ids=HELD)
def test_a_block_held_at_its_sides(
    supports: dict[str, Any], sizes: dict[str, float], expected: tuple[float, float]
) -> None:
    """Without any load on a side. A sliding block held at one side has Q/(2 H) if it is wide."""
    case = parse_case(pad(supports=supports, geometry=cylinder(**sizes)))
    stations = closed_contact(case).stations
    for station, range_by_elements in zip(stations, expected, strict=True):
        assert abs(station.k_t_range - range_by_elements) <= station.k_range_spread
        assert station.k_range_spread < 0.025 * station.k_t_range
    left, right = (station.k_t_range for station in stations)
    # Fits of finite elements and other Poisson's ratios: 3 % of what is added.
    assert left - right == pytest.approx(expected[0] - expected[1], rel=0.03, abs=1e-9)
    if sizes == LOW and FREE in supports.values():
        exact = 60.0 / 12.0 / 4 * np.sqrt(contact_edges(idealise(case)).right[-1] / 2)
        assert (left - right) / 4 == pytest.approx(exact, rel=1e-9)


def test_sides_that_are_held_keep_the_block_from_spreading() -> None:
    """Under P, by nu/(1 - nu) of P over the width: finite elements have -.0142 + .0035."""
    assert idealise(parse_case(pad())).stretch == 0
    held = {"b": FREE, "l": LEFT, "r": RIGHT}
    found = idealise(parse_case(pad(supports=held))).stretch
    assert found == pytest.approx(-0.3 / 0.7 / 24.0)


def test_a_pad_under_tractions_may_rock() -> None:
    def traction(direction: str, *segments: dict[str, Any]) -> dict[str, Any]:
        kind = {"type": "traction", "boundary": "upper_top", "direction": direction}
        return {**kind, "history": list(segments)}

    down = traction("normal", {"ramp": -25.0, "until": 1.0, "steps": 4})
    loads = {"press": down, "shear": traction("x", HOLD, wave(0.05))}
    problem = idealise(parse_case(pad(loads=loads)))
    # on the width 24 of the top, 12 above the contact
    assert problem.normal_force[-1] == pytest.approx(600.0)
    assert problem.shear_force.max() == pytest.approx(1.2)
    assert problem.moment == pytest.approx(12.0 * problem.shear_force)
    contact = contact_edges(problem)
    centre = (contact.left + contact.right) / 2
    assert centre[1:] == pytest.approx(problem.moment[1:] / problem.normal_force[1:])


def without(table: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in table.items() if name != key}


MAIN = pad()["contacts"]["main"]
REASONS: dict[str, tuple[dict[str, Any], str]] = {
    "template": (
        {"geometry": {"template": "dovetail"}},
        "geometry: expected one of the templates cylinder, wedge, flat_rounded, found 'dovetail'",
    ),
    "solid": (
        {"geometry": {"template": "cylinder", "solid": {"length": 5.0, "layers": 2}}},
        "geometry.solid: expected a plane case",
    ),
    "branch": (
        {"start": {"from": "preload", "time": 1.0}},
        "start: expected a case that begins unloaded",
    ),
    "rough": (
        {"contacts": {"main": {**MAIN, "layer": ROUGH}}},
        "contacts.main.layer: expected a stiffness, not a curve",
    ),
    "mesh file": ({"geometry": {"file": "mine.msh"}}, "found a mesh file, 'mine.msh'"),
    "surfaces": (
        {"contacts": {"main": {**MAIN, "surface1": "lower_contact", "surface2": "upper_contact"}}},
        "contacts.main: expected surface1 = 'upper_contact'",
    ),
    "displacement control": (
        {"loads": {"press": {**press(), "control": "displacement"}, "shear": shear()}},
        "loads.press: expected control = 'force', found 'displacement'",
    ),
    "rotation": (
        {
            "bodies": {
                "upper": {**STEEL, "density": 7.8e-9},
                "lower": {**STEEL, "density": 7.8e-9},
            },
            "loads": {
                "press": press(),
                "spin": {"type": "rotation", "centre": [0.0, -90.0], "history": [HOLD, wave(1.0)]},
            },
        },
        "loads.spin: expected a platen force or a traction on 'upper_top'",
    ),
    "tension across": (
        {
            "supports": SLIDING,
            "loads": {
                "press": press(),
                "shear": shear(),
                "pull": {**pull(1.0), "direction": "y"},
            },
        },
        "loads.pull: expected a bulk tension along x, found 'y'",
    ),
    "tension on a glued block": (
        {
            "supports": {**BASE, "side": SLIDING["side"]},
            "loads": {"press": press(), "shear": shear(), "pull": pull(1.0)},
        },
        "supports: expected 'lower_bottom' to be free in x under a bulk tension, found it fixed",
    ),
    "traction on a guided top": (
        {
            "loads": {
                "press": {
                    **pull(1.0, "upper_top"),
                    "history": [{"ramp": -25.0, "until": 1.0, "steps": 4}],
                },
                "shear": shear(),
            }
        },
        "loads.press: expected a load that moves its boundary, found that it acts on 'upper_top', "
        "which loads.shear holds along y",
    ),
    "tension on the held side": (
        {
            "supports": SLIDING,
            "loads": {"press": press(), "shear": shear(), "pull": pull(1.0, "lower_left")},
        },
        "loads: expected bulk tension on one side of the block and the other side fixed in x",
    ),
    "held side without a shear load": (
        {"supports": SLIDING, "loads": {"press": press()}},
        "loads: expected a force on 'upper_top' in x as well as the support of one side",
    ),
    "nothing held along x": (
        {"supports": {"base": SLIDING["base"]}},
        "supports: expected 'lower_bottom' or a side of the block to be fixed in x, found none",
    ),
    "inclined rollers": (
        {"supports": {**BASE, "side": {"boundary": "lower_left", "direction": [1.0, 1.0]}}},
        "supports.side: expected a direction along x or y, found (0.707107, 0.707107)",
    ),
    "tension without a shear load": (
        {"supports": SLIDING, "loads": {"press": press(), "pull": pull(1.0)}},
        "loads: expected a force on 'upper_top' in x as well as the bulk tension",
    ),
    "support of the pad": (
        {"supports": {**BASE, "pad": {"boundary": "upper_left", "fix": ["x"]}}},
        "supports: expected them on the lower body only, found upper_left",
    ),
    "block not held": (
        {"supports": {"side": {"boundary": "lower_left", "fix": ["x", "y"]}}},
        "supports: expected 'lower_bottom' to be fixed in y",
    ),
    "small bodies": (
        {"loads": {"press": press(3e5), "shear": shear()}},
        "geometry.parameters: expected bodies larger than 2 times what the contact reaches",
    ),
    "sliding": (
        {"loads": {"press": press(), "shear": shear(250.0)}},
        "expected |Q| < f P in every step, found Q = 250 and f P = 240 at time 1.25",
    ),
    "open": (
        {"loads": {"press": press(-600.0), "shear": shear()}},
        "expected a normal force P > 0 in some step, found -150 at time 0.25",
    ),
}


@pytest.mark.parametrize(("tables", "reason"), REASONS.values(), ids=REASONS)
def test_reasons(tables: dict[str, Any], reason: str) -> None:
    case = parse_case(pad(**tables))
    with pytest.raises(FretfeError) as raised:
        idealise(case)
    assert reason in str(raised.value)
    found = obstacles(case)
    assert len(found) == 1 and reason in found[0]


def test_friction_that_is_never_there_carries_no_shear() -> None:
    """Without a shear force there is a solution without it."""
    smooth = {"main": {**pad()["contacts"]["main"], "friction": 0.0}}
    with pytest.raises(NotIdealisable, match=r"contacts.main.friction: expected friction, which"):
        idealise(parse_case(pad(contacts=smooth)))
    assert not idealise(parse_case(pad(contacts=smooth, loads={"press": press()}))).friction.any()


@pytest.mark.parametrize(
    ("force", "last", "kind"),
    [(-600.0, 0.0, ModelError), (0.0, 0.0, ModelError), (600.0, 150.0, ConvergenceError)],
)
def test_half_planes_that_are_pressed_once_and_those_that_never_are(
    force: float, last: float, kind: type[FretfeError]
) -> None:
    history = [*press(force)["history"], {"ramp": last, "until": 2.0, "steps": 1}]
    with pytest.raises(kind, match=r"found (0|-150) at time") as raised:
        idealise(parse_case(pad(loads={"press": {**press(), "history": history}})))
    assert "-0 at" not in str(raised.value)


def test_all_reasons_come_together() -> None:
    loads = {"press": {**press(), "control": "displacement"}, "pull": pull(1.0)}
    with pytest.raises(NotIdealisable) as raised:
        idealise(parse_case(pad(loads=loads)))
    assert len(raised.value.reasons) == 4


def test_unlike_bodies_are_half_planes_without_closed_forms() -> None:
    case = parse_case(pad(bodies={"upper": STEEL, "lower": {"young": 70e3, "poisson": 0.3}}))
    found = idealise(case)
    # beta = (mu1 - mu2)(kappa - 1)/[(mu1 + mu2)(kappa + 1)]
    assert found.dundurs == pytest.approx(0.5 * 0.8 / 2.8)
    assert found.guided


def test_frictionless_dissimilar_bodies_are_fine() -> None:
    bodies = {"upper": STEEL, "lower": {"young": 70e3, "poisson": 0.3}}
    contacts = {"main": {**without(MAIN, "friction_from"), "friction": 0.0}}
    loads = {"press": press()}
    assert obstacles(parse_case(pad(bodies=bodies, contacts=contacts, loads=loads))) == ()


def test_governing_length_is_that_of_the_rounded_part() -> None:
    values = {"flat_half_width": 1.0, "radius": 40.0, "upper_width": 15.0, "zone": 1.5}
    problem = idealise(parse_case(pad(geometry={"template": "flat_rounded", "parameters": values})))
    assert governing_length(problem, 1.2) == pytest.approx(0.2)
    assert governing_length(idealise(parse_case(pad())), 1.2) == 1.2
