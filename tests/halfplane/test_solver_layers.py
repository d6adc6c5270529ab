# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes with a layer between them, against collocation of constant tractions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.pad_cases import PAD, pad
from reference.half_plane_collocation import compliance, partial_slip, pressed

import fretfe
from fretfe.analytic.profiles import composite_modulus
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.history.solution import OPEN, STICK
from fretfe.reason import Kind
from fretfe.results.model import Result

MODULUS = composite_modulus(210e3, 0.3, 210e3, 0.3)
HALF_WIDTH = float(np.sqrt(4 * 600 * 50 / (np.pi * MODULUS)))
FIRST = [{"hold": True, "until": 1}, {"ramp": 120, "until": 2, "steps": 4}]


def solved(length: float, ratio: float = 1.0, history: list[Any] | None = None) -> Result:
    """The pad on a layer of a length E*/k over the half-width, sheared k_t = ratio k_n."""
    tables = {name: dict(table) for name, table in PAD.items()}
    if length:
        normal = MODULUS / (length * HALF_WIDTH)
        layer = {"normal": normal, "tangential": ratio * normal}
        tables["contacts"] = {"main": {**PAD["contacts"]["main"], "layer": layer}}
    if history is not None:
        tables["loads"] = {**PAD["loads"], "shear": {**PAD["loads"]["shear"], "history": history}}
    return fretfe.run(parse_case(pad(**tables)), backend="halfplane")


@pytest.mark.parametrize(("length", "ratio"), [(0.01, 1.0), (0.1, 2.0), (1.0, 0.5)])
def test_pressure_and_slip_are_those_of_collocation(length: float, ratio: float) -> None:
    result = solved(length, ratio, FIRST)
    history = result.contact_history("main")
    x = np.linspace(-1, 1, 1201) * (1.1 + 0.6 * length) * HALF_WIDTH
    given = length * HALF_WIDTH / MODULUS
    pressure = pressed(x, x**2 / 100, compliance(x, MODULUS, given), 600.0)
    arc, size = history.surface.arc, x[1] - x[0]
    own = np.interp(arc, x, pressure)
    assert np.abs(history.traction[-1][:, 0] - own).max() < 0.01 * pressure.max()

    def within_an_element(found: float, expected: float) -> bool:
        near = np.argmin(np.abs(arc - found))
        return abs(found - expected) < np.diff(arc)[near - 1 : near + 1].max() + size

    touching = pressure > 0
    reached = float(np.abs(arc[history.status[-1] != OPEN]).max())
    assert within_an_element(reached, float(x[touching].max()))
    places = x[touching]
    matrix = compliance(places, MODULUS, given / ratio)
    shear, slips = partial_slip(places, matrix, 0.4 * pressure[touching], 120.0)
    inside = np.abs(arc) < places.max()
    wrong = history.traction[-1][inside, 1] - np.interp(arc[inside], places, shear)
    # The most where it bends sharply, at the border of the slip zone.
    assert np.abs(wrong).max() < 0.02 * 0.4 * pressure.max()
    assert np.abs(wrong).mean() < 0.002 * 0.4 * pressure.max()
    stuck = float(np.abs(arc[history.status[-1] == STICK]).max())
    assert within_an_element(stuck, float(np.abs(places[~slips]).max()))


def test_a_stiff_layer_changes_nothing() -> None:
    stiff, none = solved(1e-12), solved(0.0)
    pair = stiff.contact_history("main").traction[-1], none.contact_history("main").traction[-1]
    assert np.abs(pair[0] - pair[1]).max() < 1e-8 * 664
    for one, other in zip(stiff.contacts[0].stations, none.contacts[0].stations, strict=True):
        assert one.decisive_k_n == pytest.approx(other.decisive_k_n, rel=1e-7)
        assert one.k_range == pytest.approx(other.k_range, rel=1e-7)
    assert not stiff.contacts[0].warnings


@pytest.mark.parametrize("length", [0.0001, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3])
def test_bars_of_factors_hold_those_without_a_thin_layer(length: float) -> None:
    thin, none = solved(length), solved(0.0)
    for one, other in zip(thin.contacts[0].stations, none.contacts[0].stations, strict=True):
        (k_n, bar), exact = one.decisive_k_n, other.decisive_k_n[0]
        assert abs(k_n - exact) < bar < 0.1 * exact
        assert abs(one.k_range - other.k_range) < one.k_range_spread < 0.15 * other.k_range


def test_slip_zones_on_a_thick_layer_are_known() -> None:
    result = solved(0.5, history=FIRST)
    history, states = result.contact_history("main"), result.contacts[0]
    arc, status = history.surface.arc, history.status[-1]
    inner = np.abs(arc[status == STICK]).max()
    outer = np.abs(arc[status != OPEN]).max()
    for station in states.stations:
        zone = station.longest_zone
        assert zone is not None
        # From the end of the contact, within elements of .01.
        assert zone.reported_length == pytest.approx(outer - inner, abs=0.02)


def test_bodies_must_be_large_against_a_contact_that_a_soft_layer_makes_wide() -> None:
    with pytest.raises(CaseError, match="expected bodies larger than 2 times"):
        solved(2000.0)


def test_a_layer_that_gives_along_the_surface_alone_leaves_k_n() -> None:
    stations = zip(
        solved(1e-6, 1e-6).contacts[0].stations, solved(0.0).contacts[0].stations, strict=True
    )
    for one, other in stations:
        assert one.decisive_k_n[0] == pytest.approx(other.decisive_k_n[0], rel=1e-3)
        assert one.decisive_k_n[1] < 0.02 * one.decisive_k_n[0]


def test_a_thick_layer_warns() -> None:
    assert Kind.LAYER in {each.kind for each in solved(0.5).contacts[0].warnings}
