# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes in place of bodies that are none say so, and by how much they are wrong."""

from __future__ import annotations

import pytest
from cases.pad_cases import PAD, STEEL, cylinder, pad, press, shear

from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.idealise import idealise
from fretfe.quality.validation import summary, validate
from fretfe.reason import Kind
from fretfe.results.model import Result

HALF_WIDTH = 0.5749
QUANTITY = "error of K_N or ΔK_T because the bodies are not half-planes"
STRETCH = "error of the slip zones because P stretches different bodies by different amounts"
# K_N of finite elements with the lower body so many half-widths high, over that of one 42 high.
K_N_BY_HEIGHT = {3.0: 1.0256}


def test_a_low_body_is_no_half_plane() -> None:
    case = parse_case(pad(geometry=cylinder(lower_height=3 * HALF_WIDTH)))
    validation = validate(case, find_backend("halfplane"))
    (row,) = (each for each in validation.rows if each.quantity == QUANTITY)
    assert row.verdict == "unknown" and row.value == pytest.approx(0.03, rel=0.1)
    assert not validation.passed
    assert summary(validation).endswith("nothing can be said of this case before they are known.")
    (contact,) = validation.result.contacts
    assert Kind.BODY_SIZE in {each.kind for each in contact.warnings}
    for station in contact.stations:
        missing = (K_N_BY_HEIGHT[3.0] - 1) * station.k_n[-1]
        assert missing < station.k_n_spread[-1] < 2 * missing


def test_large_bodies_pass() -> None:
    result = find_backend("halfplane").solve(parse_case(pad()))
    limit = result.limits[-1]
    assert limit.quantity == QUANTITY and limit.found < 0.004
    kinds = {each.kind for each in result.warnings}
    assert not kinds & {each.kind for each in result.limits}


# Slip zones over the half-width of bodies so many half-widths wide and twice as high that are
# pressed on against f = .05: titanium on steel by finite elements, and by half-planes.
BY_WIDTH = {18: 0.123, 75: 0.169}
OF_HALF_PLANES = 0.190


def pressed_on(widths: int) -> Result:
    """Titanium on steel under P alone, against friction."""
    half_width = 0.68
    sizes = {
        f"{body}_{side}": times * widths * half_width
        for body in ("upper", "lower")
        for side, times in (("width", 1), ("height", 2))
    }
    tables = pad(
        geometry=cylinder(**sizes),
        bodies={"upper": {"young": 114e3, "poisson": 0.34}, "lower": STEEL},
        loads={"press": press(steps=10)},
    )
    tables["contacts"]["main"] = {**tables["contacts"]["main"], "friction": 0.05}
    del tables["contacts"]["main"]["friction_from"]
    return find_backend("halfplane").solve(parse_case(tables))


@pytest.mark.parametrize("widths", BY_WIDTH)
def test_unlike_bodies_stretch_under_p(widths: int) -> None:
    """The change is told, and in the error bars of the slip zones."""
    result = pressed_on(widths)
    (contact,), limit = result.contacts, result.limits[-1]
    longest = max(station.slip_zones[-1].length for station in contact.stations)
    change = limit.found * longest / contact.half_width[-1]
    assert limit.quantity == STRETCH
    assert change == pytest.approx(OF_HALF_PLANES - BY_WIDTH[widths], rel=0.25)
    for station in contact.stations:
        assert station.slip_zones[-1].spread > change * contact.half_width[-1]


@pytest.mark.parametrize("widths", [*BY_WIDTH, 90])
def test_large_stretches_are_warned_of(widths: int) -> None:
    """At 75 half-widths it is 5.2 % of the slip zone, at 90 less than the 5 % of the limit."""
    result = pressed_on(widths)
    warned = Kind.BODY_STRETCH in {each.kind for each in result.contacts[0].warnings}
    assert result.limits[-1].exceeded == warned == (widths in BY_WIDTH)


def test_stretch_matters_as_far_as_p_varies_with_friction() -> None:
    """Not where P is constant in the cycle, nor between bodies that stretch alike."""
    unlike = pad(bodies={"upper": {"young": 114e3, "poisson": 0.34}, "lower": STEEL})
    alike = pad()
    del alike["contacts"]["main"]["friction_from"]
    for tables in (unlike, alike):
        result = find_backend("halfplane").solve(parse_case(tables))
        assert STRETCH not in [each.quantity for each in result.limits]


# Wedges by degrees, with bodies of 60 to 150 half-widths, by finite elements: what ΔK_T and slip
# zones, by the direction of slip, are larger by than those of half-planes.
BY_SLOPE = {3.0: (0.018, 0.040), 6.0: (0.037, 0.068)}


@pytest.mark.parametrize("angle", BY_SLOPE)
def test_surfaces_that_meet_at_a_slope_are_no_planes(angle: float) -> None:
    """The bars hold it, whatever the size of the bodies."""
    sizes = dict.fromkeys(("upper_width", "upper_height", "lower_width", "lower_height"), 1e3)
    case = parse_case(pad(geometry={"template": "wedge", "parameters": {"angle": angle, **sizes}}))
    k_t, slip = BY_SLOPE[angle]
    problem = idealise(case)
    assert problem.k_n_error < 1e-5
    assert k_t < problem.k_t_error < 1.2 * k_t
    result = find_backend("halfplane").solve(case)
    (contact,) = result.contacts
    for station in contact.stations:
        assert k_t * station.k_t_range < station.k_range_spread
        for zone in station.slip_zones:
            assert slip * zone.length < zone.spread < 1.4 * slip * zone.length
    assert Kind.BODY_SIZE in {each.kind for each in contact.warnings}


def test_flats_feel_the_width_of_bodies_more_than_cylinders() -> None:
    """By elements, refined to 1 %, ΔK_T of a flat 1.01 wide in blocks of 20 is 16.672 ± .012."""
    sizes = {f"{body}_{name}": 20.0 for body in ("upper", "lower") for name in ("width", "height")}
    titanium = {"young": 115e3, "poisson": 0.32}
    tables = pad(
        geometry={
            "template": "flat_rounded",
            "parameters": {"flat_half_width": 0.6, "radius": 30.0, "zone": 1.2, **sizes},
        },
        bodies={"upper": titanium, "lower": titanium},
        contacts={"main": {**PAD["contacts"]["main"], "friction": 0.5}},
        loads={"press": press(500.0), "shear": shear(37.5, steps=24)},
    )
    (contact,) = find_backend("halfplane").solve(parse_case(tables)).contacts
    for station in contact.stations:
        missing = station.k_t_range - 16.672
        assert 0 < missing < station.k_range_spread < 2 * missing
