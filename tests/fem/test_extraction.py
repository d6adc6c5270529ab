# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors and slip zones of finite elements, each by two methods and against half-planes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import HOLD, SLIDING, TOP, pad, press, pull, shear, wave

from fretfe.analytic.profiles import FlatRounded, Profile, Wedge, composite_modulus, edge_factor_k_n
from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.fem.extraction import _tubes
from fretfe.reason import Kind
from fretfe.results.model import Result

BLOCKS = {"upper_width": 20.0, "upper_height": 10.0, "lower_width": 30.0, "lower_height": 30.0}
E_STAR = float(composite_modulus(210e3, 0.3, 210e3, 0.3))


Solve = Callable[[dict[str, Any]], Result]


@cache
def half_planes(name: str) -> Result:
    return find_backend("halfplane").solve(parse_case(CASES[name]))


def cylinder(size: float = 0.01) -> dict[str, Any]:
    values = {"upper_radius": 50.0, "lower_radius": 0.0, "size": size, **BLOCKS}
    return {"template": "cylinder", "parameters": values}


def tension_case(shear_ratio: float, tension: float, phase: float) -> dict[str, Any]:
    """Q = 240 shear_ratio sin, sigma0 = tension sin(- phase); what the held side adds is taken off.

    f P = 240 with P = 600, f = 0.4.
    """
    amplitude = 240.0 * shear_ratio
    side = amplitude / (2 * BLOCKS["lower_height"])
    start = float(tension * np.sin(np.radians(-phase)))
    lagging = [{"ramp": start, "until": 1.0, "steps": 4}, wave(tension, -phase)]
    return pad(
        geometry=cylinder(),
        supports=SLIDING,
        loads={
            "press": press(),
            "shear": shear(amplitude),
            "pull": {**pull(tension), "history": lagging},
            "balance": pull(-side),
        },
    )


# Q/(f P), sigma0 (f p0 = 265), phase. In the last two the tension dominates: slip at the two edges
# goes opposite ways.
TENSION: dict[str, tuple[float, float, float]] = {
    "in phase": (0.2, 50.0, 0.0),
    "in opposition": (0.2, 50.0, 180.0),
    "60 degrees": (0.2, 60.0, 60.0),
    "90 degrees": (0.15, 80.0, 90.0),
    "opposite slip": (0.05, 120.0, 0.0),
    "opposite slip, 45 degrees": (0.08, 140.0, 45.0),
}
CASES = {name: tension_case(*loads) for name, loads in TENSION.items()}


@pytest.mark.parametrize("number", [0, 1], ids=["left", "right"])
@pytest.mark.parametrize("name", TENSION)
def test_bulk_tension_and_phase(solved: Solve, name: str, number: int) -> None:
    fem, reference = (each.contacts[0] for each in (solved(CASES[name]), half_planes(name)))
    edge, expected = fem.stations[number], reference.stations[number]
    half_width = float(reference.half_width[-1])
    lengths, references = (
        [zone.length for zone in each.slip_zones[-2:]] for each in (edge, expected)
    )
    assert lengths == pytest.approx(references, abs=0.01 * half_width)
    # formulas (4), (5); a K_T that nearly vanishes is compared with that of the other edge
    largest = max(each.k_t_range for each in reference.stations)
    assert edge.k_t_range == pytest.approx(expected.k_t_range, rel=0.01, abs=0.003 * largest)
    assert edge.k_t_range_fitted == pytest.approx(edge.k_t_range, rel=5e-3, abs=0.003 * largest)


def test_free_pad_stays_where_nothing_pushes_it(solved: Solve) -> None:
    """Pressed on without friction, and free to slide: round-off of the loads must not move it."""
    solution = solved(CASES["in phase"]).solution
    (contact,) = solution.contacts
    frictionless = np.flatnonzero(~contact.friction.acts)
    assert len(frictionless) == 5
    # Points of the two surfaces part by some of their elastic displacement, p0/E* of the width.
    assert np.abs(contact.slip[frictionless]).max() < 1e-3


WEDGE_ANGLE = 0.5
PUNCHES: dict[str, tuple[Profile, dict[str, float], float]] = {
    "wedge": (
        Wedge(float(np.tan(np.radians(WEDGE_ANGLE))), E_STAR),
        {"angle": WEDGE_ANGLE, "size": 0.006, "zone": 1.3},
        30.0,
    ),
    "b/a = .5": (FlatRounded(0.5, 60.0, E_STAR), {"edge_size": 0.005, "zone": 1.2}, 30.0),
    "b/a = .8": (FlatRounded(0.8, 60.0, E_STAR), {"edge_size": 0.002, "zone": 1.1}, 30.0),
    "b/a = .95": (FlatRounded(0.95, 60.0, E_STAR), {"edge_size": 0.0005, "zone": 1.02}, 30.0),
}


def punch_case(name: str) -> dict[str, Any]:
    profile, parameters, width = PUNCHES[name]
    values = {**parameters, "upper_width": width, "lower_width": width}
    values |= {"upper_height": width, "lower_height": width}
    template = "wedge"
    if isinstance(profile, FlatRounded):
        template = "flat_rounded"
        values |= {"flat_half_width": profile.flat_half_width, "radius": profile.radius}
    ramp = {"ramp": -float(profile.load(1.0)), "until": 1.0, "steps": 2}
    contact = {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 0.0}
    return pad(
        geometry={"template": template, "parameters": values},
        contacts={"main": contact},
        loads={"press": {**TOP, "direction": "y", "history": [ramp]}},
    )


@pytest.mark.parametrize("name", PUNCHES)
def test_k_n_by_both_methods(solved: Solve, name: str) -> None:
    profile = PUNCHES[name][0]
    answer = solved(punch_case(name))
    expected = float(edge_factor_k_n(profile, 1.0))
    for edge in answer.contacts[0].stations:
        assert edge.k_n[-1] == pytest.approx(expected, rel=0.01)
        assert edge.k_n_moved == pytest.approx(expected, rel=0.01)


def varying_case() -> dict[str, Any]:
    """P from 600 to 1200 in phase with Q."""
    normal = [
        {"ramp": -900.0, "until": 1.0, "steps": 6},
        {**wave(-300.0, steps=24), "mean": -900.0},
    ]
    loads = {"press": {**press(), "history": normal}, "shear": shear(190.0, steps=24)}
    contacts = {"main": {**pad()["contacts"]["main"], "friction_from": 0.0}}
    return pad(geometry=cylinder(0.008), loads=loads, contacts=contacts)


def test_normal_load_in_phase(solved: Solve) -> None:
    fem = solved(varying_case()).contacts[0]
    reference = find_backend("halfplane").solve(parse_case(varying_case())).contacts[0]
    half_width = float(np.nanmax(fem.half_width))
    for edge, expected in zip(fem.stations, reference.stations, strict=True):
        first, second = edge.slip_zones[-2:]
        # the same material point
        assert first.border == pytest.approx(second.border, abs=0.01 * half_width)
        assert first.border == pytest.approx(expected.slip_zones[-2].border, abs=0.01 * half_width)
        for zone in (first, second):
            # (11) is short by about d/(2a), d from the edge at high load
            longest = max(first.length, second.length)
            error = longest / (2 * half_width)
            assert zone.predicted_loop == pytest.approx(zone.length, rel=1.5 * error + 0.03)


def test_a_coarse_mesh_is_not_trusted(solved: Solve) -> None:
    # eight elements across the half-width
    answer = solved(pad(geometry=cylinder(0.07)))
    contact = answer.contacts[0]
    fine = find_backend("halfplane").solve(parse_case(pad(geometry=cylinder()))).contacts[0]
    for edge, reference in zip(contact.stations, fine.stations, strict=True):
        error = abs(edge.k_n[-1] - reference.k_n[-1])
        assert edge.k_n_spread[-1] > error
    assert {each.kind for each in contact.warnings} & {Kind.K_N_UNCERTAIN, Kind.NOT_RESOLVED}


def test_holds_are_no_cycle(solved: Solve) -> None:
    loads = {"press": press(), "shear": {**shear(), "history": [HOLD]}}
    contact = solved(pad(geometry=cylinder(0.02), loads=loads))
    for edge in contact.contacts[0].stations:
        assert np.isnan(edge.k_t_range) and np.isfinite(edge.k_n_moved)


def test_friction_work_is_the_area_of_the_hysteresis_loop(solved: Solve) -> None:
    loads = {"press": press(), "shear": shear(100.0, cycles=3, steps=60)}
    answer = solved(pad(geometry=cylinder(0.02), loads=loads))
    solution, contact = answer.solution, answer.contacts[0]
    assert solution.cycle is not None
    cycle = slice(solution.cycle[0], solution.cycle[1] + 1)
    force, path = solution.forces[cycle], solution.amplitudes[cycle]
    # trapezoids over the loops of all boundaries
    work = np.sum((force[1:] + force[:-1]) / 2 * np.diff(path, axis=0))
    # the friction work takes the shear at the end of each step: first order in the 60 steps
    assert contact.dissipation == pytest.approx(work, rel=0.03)
    assert work > 0
    assert sum(edge.dissipation for edge in contact.stations) == pytest.approx(contact.dissipation)
    assert abs(contact.dissipation_change) < 1e-4


@pytest.mark.parametrize(("radius", "crystals"), [(1.0, False), (1.0, True), (50.0, True)])
def test_tubes_between_crystals_are_short_where_the_front_bends(
    radius: float, crystals: bool
) -> None:
    """The frame of a station turns along the front with 1/radius, the crystal does not."""
    sector = SimpleNamespace(size=0.1, along_size=0.1, curvature=1 / radius)
    frames = SimpleNamespace(slid=lambda _: SimpleNamespace(to_end=[np.inf]))
    front = SimpleNamespace(sectors=[sector], depth=[1.0], frames=frames, aside=np.zeros(1))
    (tubes,) = _tubes(front, crystals)  # type: ignore[arg-type]
    lengths = [each.half_length for each in tubes]
    # At most .3 of the radius, and the last way five eighths of it; else 8 and 5 elements.
    short = crystals and radius == 1.0
    assert lengths == pytest.approx([0.3] * 3 + [0.1875] if short else [0.8] * 3 + [0.5])
