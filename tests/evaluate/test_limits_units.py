# SPDX-License-Identifier: LGPL-3.0-or-later
"""Labels of units that contradict each other, and numbers that hardly fit them."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import STEEL, pad

import fretfe
from fretfe.case import case_notes, parse_case
from fretfe.caution import Caution, Subject
from fretfe.errors import CaseError
from fretfe.evaluate.limits import ModelLimit, with_limit_warnings
from fretfe.fields.change_of_shape import change_of_shape, doubt_of_unit
from fretfe.reason import Kind

# Labels of length and force with that of stress, which the case need not name.
LABELS = [
    ({}, "MPa"),
    ({"length": "m"}, "Pa"),
    ({"force": "kN"}, "GPa"),
    ({"length": "in", "force": "lbf"}, "psi"),
    ({"length": "in"}, "N/in²"),
    ({"length": "furlong"}, "N/furlong²"),
    ({"length": "furlong", "stress": "MPa"}, "MPa"),
    ({"stress": "N/mm^2"}, "N/mm^2"),
]


@pytest.mark.parametrize(("labels", "stress"), LABELS)
def test_the_label_of_stress_is_that_of_force_over_area(
    labels: dict[str, str], stress: str
) -> None:
    assert parse_case(pad(units=labels)).units.stress == stress


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        ({"length": "m", "stress": "MPa"}, "expected stress = 'Pa', .* found 'MPa', .* 1e\\+06 of"),
        ({"stress": "GPa"}, "expected stress = 'MPa', .* found 'GPa', which is 1000 of it"),
    ],
)
def test_labels_that_contradict_each_other(labels: dict[str, str], expected: str) -> None:
    with pytest.raises(CaseError, match=f"case.toml: units: {expected}"):
        parse_case(pad(units=labels))


def bodies(**young: float) -> dict[str, Any]:
    return {name: {**STEEL, "young": value} for name, value in young.items()}


DOUBTS = {
    "Pa": ({}, 210e9, "2.1e+11 is in MPa, as [units] is not given, and no material is stiffer than "
           "5e+06 MPa. In Pa it would be usual: that is 210000 MPa"),
    "Pa, told": ({"stress": "MPa"}, 210e9, "2.1e+11 is in MPa, by [units], and no material"),
    "MPa": ({"length": "m"}, 210e3, "210000 is in Pa, by [units], and no material is softer than "
            "1e+06 Pa. In MPa it would be usual: that is 2.1e+11 Pa"),
    "GPa": ({"length": "m"}, 210.0, "In GPa it would be usual: that is 2.1e+11 Pa"),
    "rigid": ({}, 1e16, "1e+16 is in MPa, as [units] is not given, and no material is stiffer"),
}  # fmt: skip


@pytest.mark.parametrize(("labels", "young", "expected"), DOUBTS.values(), ids=DOUBTS)
def test_stiffness_in_another_unit(labels: dict[str, str], young: float, expected: str) -> None:
    usual = 210e9 if "length" in labels else 210e3
    (note,) = case_notes(parse_case(pad(units=labels, bodies=bodies(upper=young, lower=usual))))
    assert note.startswith("bodies.upper.young: ") and expected in note
    assert ("it would be usual" in note) == (young < 1e16)


@pytest.mark.parametrize(
    ("labels", "young"),
    [({}, 210e3), ({}, 1.0), ({}, 1.2e6), ({"length": "m"}, 70e9), ({"length": "furlong"}, 1e12)],
)
def test_usual_stiffness_is_not_doubted(labels: dict[str, str], young: float) -> None:
    assert case_notes(parse_case(pad(units=labels, bodies=bodies(upper=young, lower=young)))) == ()


def test_crystals_are_doubted_too() -> None:
    nickel = {"elastic": {"cubic": [250e9, 160e9, 130e9]}, "orientation": {"euler": [0, 0, 0]}}
    tables = pad(bodies={"upper": nickel, "lower": STEEL})
    (note,) = case_notes(parse_case(tables))
    assert note.startswith("bodies.upper.elastic: 2.5e+11 is in MPa")


DENSITIES = {
    "kg/m³": ({}, 7850.0, "7850 is in N·s²/mm⁴, as [units] is not given, and no material is denser "
              "than 2.5e-08 N·s²/mm⁴. In kg/m^3 it would be usual: that is 7.85e-09 N·s²/mm⁴"),
    "g/cm³": ({}, 7.85, "In g/cm^3 it would be usual: that is 7.85e-09 N·s²/mm⁴"),
    "t/mm³": ({"length": "m"}, 7.85e-9, "no material is lighter than 10 N·s²/m⁴. In t/mm^3 it would"
              " be usual: that is 7850 N·s²/m⁴"),
    "kg/mm³": ({}, 7.85e-6, "no material is denser than 2.5e-08 N·s²/mm⁴"),
    "right": ({}, 7.85e-9, ""),
    "metres": ({"length": "m"}, 2700.0, ""),
    "minutes": ({"time": "min"}, 7.85e-9, "no material is denser than"),
    "unknown": ({"length": "furlong"}, 7850.0, ""),
}  # fmt: skip


@pytest.mark.parametrize(("labels", "density", "expected"), DENSITIES.values(), ids=DENSITIES)
def test_density_in_another_unit(labels: dict[str, str], density: float, expected: str) -> None:
    steel = {"young": 210e9 if "length" in labels else 210e3, "poisson": 0.3, "density": density}
    notes = case_notes(parse_case(pad(units=labels, bodies={"upper": steel, "lower": steel})))
    assert len(notes) == bool(expected)
    for note in notes:
        assert note.startswith("bodies.upper.density, bodies.lower.density: ") and expected in note


def test_notes_of_a_run_without_finite_elements() -> None:
    """The pressure over the modulus falls with the root of the modulus, to 3e-6 here."""
    result = fretfe.run(parse_case(pad(bodies=bodies(upper=210e9, lower=210e9))), "halfplane")
    assert sum("In Pa it would be usual" in note for note in result.notes) == 1
    warnings = result.contacts[0].warnings
    (doubted,) = (each for each in warnings if each.kind is Kind.UNITS)
    assert "is 2.9e-06, where" in doubted.text


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (1e-6, [Kind.UNITS, Kind.UNSTEADY, Kind.SLIDING]),
        (1e-3, [Kind.UNSTEADY, Kind.SLOPE, Kind.SLIDING]),
        (0.05, [Kind.UNSTEADY, Kind.SLOPE, Kind.PRESSURE, Kind.SLIDING]),
        (3.0, [Kind.UNITS, Kind.UNSTEADY, Kind.SLIDING]),
    ],
)
def test_impossible_pressures_are_told_first(found: float, expected: list[Kind]) -> None:
    """In place of what else would have units checked."""
    contact = fretfe.run(parse_case(pad()), "halfplane").contacts[0]
    limits = [
        ModelLimit("main", Kind.SLOPE, "slope", 0.3, 0.1),
        ModelLimit("main", Kind.PRESSURE, "pressure", found, 0.02),
        ModelLimit("main", Kind.SLIDING, "sliding", 0.3, 0.1),
        ModelLimit("other", Kind.SLOPE, "slope", 0.3, 0.1),
    ]
    earlier = Caution(Kind.UNSTEADY, Subject("main"), "earlier")
    (warned,) = with_limit_warnings([replace(contact, warnings=(earlier,))], limits)
    assert [each.kind for each in warned.warnings] == expected


CIRCLE = np.stack([f(2 * np.pi * np.arange(40) / 40) for f in (np.cos, np.sin)], axis=1)


@pytest.mark.parametrize(
    ("slopes", "expected"),
    [
        ([[1, 0], [0, 1]], 1.0),
        ([[1, 0], [0, 0]], 1 / np.sqrt(2)),
        ([[0, 1], [0, 0]], 0.5),
        ([[0, 1], [-1, 0]], 0.0),
    ],
)
def test_change_of_the_shape_of_a_circle(slopes: list[list[float]], expected: float) -> None:
    """Two steps, of which the larger one counts, anywhere, with a shift and a turn besides."""
    places = 6.5 * CIRCLE + [100.0, -40.0]
    own = 6.5 * CIRCLE @ (1e-3 * np.array(slopes) + 2e-3 * np.array([[0, 1], [-1, 0]])) + 5.0
    found = change_of_shape(places, np.stack([0.5 * own, own]))
    assert found == pytest.approx(1e-3 * expected, rel=1e-9, abs=1e-15)


def test_change_of_the_shape_of_a_line_in_space() -> None:
    """Turns about the line itself move nothing, and are no reason to fail."""
    line = np.linspace(0, 3, 8)[:, None] * [1.0, 2.0, 2.0]
    assert change_of_shape(line, 1e-3 * line[None]) == pytest.approx(1e-3, rel=1e-9)
    assert np.isnan(change_of_shape(line[:1], line[None, :1]))


def test_rounding_is_no_change_of_shape() -> None:
    moved = (1.0 + 1e-7 * np.sin(7 * CIRCLE))[None]
    assert change_of_shape(CIRCLE, moved) > 0
    assert change_of_shape(CIRCLE, moved, rounding=6e-8) == 0


@pytest.mark.parametrize(
    ("strain", "scale", "expected"),
    [
        (5e-7, 1.0, "by 5e-07 of its size .* displacement_factor = 1000 would make it 0.0005"),
        (5e-7, 1e-3, "displacement_factor = 1 would make it 0.0005"),
        (0.5, 1000.0, "by 0.5 of its size .* displacement_factor = 1 would make it 0.0005"),
        (5e-13, 1.0, "by 5e-13 of its size .* is their unit that of the case, .* factor\\)\\?$"),
        (1e-3, 1.0, "^$"),
    ],
)
def test_displacements_in_another_unit(strain: float, scale: float, expected: str) -> None:
    found = doubt_of_unit(CIRCLE, strain * CIRCLE[None], scale)
    assert re.search(expected, found), found
