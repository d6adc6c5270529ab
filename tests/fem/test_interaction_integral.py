# SPDX-License-Identifier: LGPL-3.0-or-later
"""K_T and K_I by interaction integrals: independent of the path, and those of half-planes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HOLD, SLIDING, pad, press, pull, shear, wave

from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import normal_increment_factor, tangential_factor
from fretfe.history.solution import Factor, StationIntegrals
from fretfe.results.model import Result

Solve = Callable[[dict[str, Any]], Result]
SIDES: tuple[Side, Side] = ("left", "right")
# Large, so that half-planes are near; held from below, the block takes Q half to either side.
SIZES = {"upper_width": 20.0, "lower_width": 30.0, "lower_height": 30.0, "upper_height": 10.0}


def cylinder(size: float, **parameters: float) -> dict[str, Any]:
    values = {"upper_radius": 50.0, "lower_radius": 0.0, "size": size, **SIZES, **parameters}
    return {"template": "cylinder", "parameters": values}


def tables(
    degree: int, size: float, plane: str = "strain", zone: float = 1.0, **changed: Any
) -> dict[str, Any]:
    model = {"degree": degree, "plane": plane}
    return pad(geometry=cylinder(size, zone=zone), model=model, **changed)


@pytest.fixture(scope="module", params=[(1, 0.01), (2, 0.02), (2, 0.01)], ids=str)
def answer(request: pytest.FixtureRequest, solved: Solve) -> Result:
    return solved(tables(*request.param))


def integrals(answer: Result) -> StationIntegrals:
    found = answer.solution.contacts[0].integrals
    assert found is not None
    return found


def test_radii_agree(answer: Result) -> None:
    found = integrals(answer)
    largest = np.abs(found.factors).max(axis=(0, 1, 2, 3))
    # the smallest circle has 10 elements along its radius
    assert np.all(np.ptp(found.factors, axis=1) < 3e-3 * largest)
    assert found.reaches[-1] > 2 * found.reaches[0]


@pytest.mark.parametrize("number", [0, 1], ids=SIDES)
def test_half_planes(answer: Result, number: int) -> None:
    found, side = integrals(answer), SIDES[number]
    half_width = float(np.diff(found.positions[-1])[0]) / 2
    drivers = answer.solution.drivers
    shear_unit = found.factors[-1, :, number, Factor.K_T, drivers.index("shear")]
    press_unit = found.factors[-1, :, number, Factor.K_I, drivers.index("press")]
    # 0.5 % from the bodies' size, and half an element of a 58-element half-width
    expected = float(tangential_factor(1.0, 0.0, half_width, side))
    assert shear_unit == pytest.approx(np.full(3, expected), rel=0.01)
    expected = float(normal_increment_factor(-1.0, 0.0, half_width, side))
    assert press_unit == pytest.approx(np.full(3, expected), rel=0.01)
    # a normal load does not shear the edge, but for the slope of the pad there, a/R = 0.0115
    press_shear = found.factors[-1, :, number, Factor.K_T, drivers.index("press")]
    assert np.abs(press_shear).max() < 0.02 * abs(expected)


@pytest.mark.parametrize("number", [0, 1], ids=SIDES)
def test_two_extractions_agree(answer: Result, number: int) -> None:
    edge = answer.contacts[0].stations[number]
    # At order 1 the tractions alternate more, and the edges of a discrete increment are known less
    # well: 0.51 % measured.
    limit = 5e-3 if answer.solution.degree == 2 else 8e-3
    assert edge.k_t_range_fitted == pytest.approx(edge.k_t_range, rel=limit)
    assert edge.k_range_parts.extraction < 3e-3 * edge.k_t_range
    assert answer.contacts[0].shear_mismatch == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("number", [0, 1], ids=SIDES)
def test_k_n_from_the_movement_of_the_edge(answer: Result, number: int) -> None:
    edge = answer.contacts[0].stations[number]
    # order 1: positions of the edges alternate by a few hundredths of an element
    assert edge.k_n_moved == pytest.approx(edge.k_n[-1], rel=0.02)


def test_bulk_tension(solved: Solve) -> None:
    loads = {
        "press": press(),
        "shear": {**shear(0.0), "history": [HOLD, {"hold": True, "until": 3.0}]},
        "pull": pull(100.0),
    }
    answer = solved(tables(2, 0.02, loads=loads, supports=SLIDING))
    contact = answer.contacts[0]
    a = float(contact.half_width[-1])
    for edge, side in zip(contact.stations, SIDES, strict=True):
        expected = 2 * float(tangential_factor(0.0, 100.0, a, side))
        assert edge.k_t_range == pytest.approx(expected, rel=0.01)
        # tension pulls body 2 outward under the pad: the shear on it points inward at both edges
        peak = int(np.argmax(answer.loads.values[:, 2]))
        assert edge.k_t[peak] == pytest.approx(expected / 2, rel=0.01)
    assert np.ptp(contact.effective_tension) == pytest.approx(200.0, rel=0.01)


def test_the_sign_follows_the_shear_at_both_edges(solved: Solve) -> None:
    answer = solved(tables(2, 0.02))
    contact = answer.contacts[0]
    for state in (7, 9, 17, 19):
        force = contact.shear_force[state]
        left, right = (edge.k_t[state] for edge in contact.stations)
        assert np.sign(left) == np.sign(force) == -np.sign(right)


def test_stiffness_and_plane_state_do_not_matter(solved: Solve) -> None:
    bodies = {"upper": {"young": 70e3, "poisson": 0.3}, "lower": {"young": 70e3, "poisson": 0.3}}
    answer = solved(tables(2, 0.02, "stress", 1.6, bodies=bodies))
    edge = answer.contacts[0].stations[0]
    a = float(answer.contacts[0].half_width[-1])
    # K_T does not depend on the stiffness or the plane state
    assert edge.k_t_range == pytest.approx(
        2 * float(tangential_factor(60.0, 0, a, "left")), rel=0.01
    )
    assert edge.k_n_moved == pytest.approx(edge.k_n[-1], rel=0.01)


def test_no_k_n_from_an_edge_that_leaves_its_surface(solved: Solve) -> None:
    # 5 % more load makes the half-width 2.5 % larger than 0.575
    answer = solved(tables(2, 0.02, zone=0.58))
    assert all(np.isnan(edge.k_n_moved) for edge in answer.contacts[0].stations)
    assert all(np.isfinite(edge.k_n[-1]) for edge in answer.contacts[0].stations)


def test_waves_that_start_with_a_phase_have_integrals(solved: Solve) -> None:
    history = [{"ramp": 30.0, "until": 1.0, "steps": 4}, wave(60.0, 30.0)]
    shifted = {**shear(), "history": history}
    contacts = {"main": {**pad()["contacts"]["main"], "friction_from": 0.0}}
    answer = solved(tables(2, 0.02, loads={"press": press(), "shear": shifted}, contacts=contacts))
    edge = answer.contacts[0].stations[0]
    assert edge.k_t_range == pytest.approx(edge.k_t_range_fitted, rel=0.01)
