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
from fretfe.caution import Kind
from fretfe.history.solution import OPEN, STICK
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


@pytest.mark.parametrize("length", [0.0001, 0.001, 0.003])
def test_bars_of_factors_hold_those_without_a_thin_layer(length: float) -> None:
    thin, none = solved(length), solved(0.0)
    for one, other in zip(thin.contacts[0].stations, none.contacts[0].stations, strict=True):
        (k_n, bar), exact = one.decisive_k_n, other.decisive_k_n[0]
        assert abs(k_n - exact) < bar < 0.3 * exact
        assert abs(one.k_range - other.k_range) < one.k_range_spread < 0.01 * other.k_range


@pytest.mark.parametrize("length", [0.01, 0.1])
def test_movement_of_the_edge_gives_k_n_where_fits_see_the_layer_alone(length: float) -> None:
    for station in solved(length).contacts[0].stations:
        assert np.isnan(station.reported_k_n)
        assert station.k_n_moved == pytest.approx(1237.75, rel=0.04)


def test_a_thick_layer_has_no_factors_and_says_why() -> None:
    contact = solved(0.5).contacts[0]
    assert all(
        np.isnan([each.reported_k_n, each.reported_range]).all() for each in contact.stations
    )
    assert {each.kind for each in contact.warnings} == {Kind.LAYER}
