# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes that refine themselves, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from mpi4py import MPI

import numpy as np
import pytest
from cases.pad_cases import SLIDING, pad, press, pull, shear
from harness.told import Told

from fretfe.analytic.profiles import FlatRounded, Hertz
from fretfe.backends import RunOptions
from fretfe.case import Case, parse_case
from fretfe.errors import CaseError, ConvergenceError, MeshError
from fretfe.fem import refine as refine_module
from fretfe.fem.backend import BACKEND
from fretfe.mesh.mesh import Mesh, mesh_summary
from fretfe.results.field_files import FieldReader
from fretfe.results.model import Result

E_STAR = 210e3 / (1 - 0.09) / 2
FRICTION, LOAD = 0.4, 600.0
CYLINDER = {"upper_radius": 50.0, "upper_width": 12.0, "lower_radius": 0.0, "lower_width": 12.0}
PROFILE = Hertz(radius=50.0, e_star=E_STAR)
HALF_WIDTH = float(PROFILE.half_width(LOAD))


def k_n(profile: Any, half_width: float) -> float:
    """K_N = (1/pi) sqrt(2/a) dP/da of half-planes."""
    return float(profile.load_slope(half_width)) * math.sqrt(2 / half_width) / math.pi


def hertz(tolerance: float, amplitude: float, **tables: Any) -> dict[str, Any]:
    """The first mesh has 40 elements along the surfaces, 10 of them across the contact."""
    geometry = {"template": "cylinder", "parameters": {**CYLINDER, "zone": 4 * HALF_WIDTH}}
    return pad(
        geometry=geometry,
        edges={"tolerance": tolerance},
        loads={"press": press(), "shear": shear(amplitude, steps=20)},
        **tables,
    )


@cache
def solved_hertz() -> Result:
    """Slip zones of d = 0.02 a: Q = 2 f P d/a nearly."""
    return BACKEND.solve(parse_case(hertz(0.005, 0.04 * FRICTION * LOAD)))


@pytest.mark.mpi
def test_hertz_to_half_a_percent_with_thirty_thousand_unknowns() -> None:
    refinement = solved_hertz().refinement
    assert refinement is not None
    assert refinement.converged, refinement.reason
    assert refinement.passes[-1].change <= 0.005
    assert refinement.passes[-1].unknowns < 30_000
    for edge in solved_hertz().contacts[0].stations:
        assert edge.k_n[-1] == pytest.approx(k_n(PROFILE, HALF_WIDTH), rel=5e-3)
        # 2 Q/(pi sqrt(2 a)); the bodies are 21 half-widths wide, which takes away 0.2 %
        expected = 0.08 * FRICTION * LOAD / (math.pi * math.sqrt(2 * HALF_WIDTH))
        assert edge.k_t_range == pytest.approx(expected, rel=5e-3)


@pytest.mark.mpi
def test_short_slip_zones_are_resolved() -> None:
    solution = solved_hertz().root_solution
    zone = HALF_WIDTH * (1 - math.sqrt(1 - 0.04))
    assert zone == pytest.approx(0.02 * HALF_WIDTH, rel=0.02)
    for edge in solved_hertz().contacts[0].stations:
        for found in edge.slip_zones[-2:]:
            # 0.3 % of it are 6e-5 of the half-width
            assert found.length == pytest.approx(zone, rel=5e-3)
    if solution is not None:
        distance = np.abs(solution.contacts[0].surface.arc)
        inside = (distance > HALF_WIDTH - zone) & (distance < HALF_WIDTH)
        assert np.count_nonzero(inside) / 2 >= 8


@pytest.mark.skipif(MPI.COMM_WORLD.size > 1, reason="needs the mesh on every rank")
def test_far_away_the_mesh_stays_coarse_and_well_shaped() -> None:
    bodies = solved_hertz().bodies
    assert min(body.smallest_angle for body in mesh_summary(Mesh(dict(bodies)))) > 25
    refinement = solved_hertz().refinement
    assert refinement is not None
    # from the second mesh, which does not resolve the zones, to the last, elements become 39 times
    # smaller, and twice as many
    first, last = refinement.passes[1], refinement.passes[-1]
    assert last.smallest_element < first.smallest_element / 30
    assert last.unknowns < 3 * first.unknowns


@pytest.mark.slow
def test_a_tiny_rounding_to_one_percent_with_forty_thousand_unknowns() -> None:
    profile = FlatRounded(1.0, 50.0, E_STAR)
    half_width = 1 / 0.95
    geometry = {
        "template": "flat_rounded",
        "parameters": {
            "radius": 50.0,
            "upper_width": 20.0,
            "upper_height": 20.0,
            "lower_width": 20.0,
            "lower_height": 20.0,
        },
    }
    load = float(profile.load(half_width))
    loads = {"press": press(load), "shear": shear(0.05 * FRICTION * load)}
    result = BACKEND.solve(
        parse_case(pad(geometry=geometry, edges={"tolerance": 0.005}, loads=loads))
    )
    assert result.refinement is not None
    assert result.refinement.converged
    assert result.refinement.passes[-1].unknowns < 40_000
    for edge in result.contacts[0].stations:
        assert edge.k_n[-1] == pytest.approx(k_n(profile, half_width), rel=0.01)
        assert abs(edge.position[-1]) == pytest.approx(half_width, rel=1e-3)


@pytest.mark.slow
def test_edges_that_differ_are_resolved_each_for_itself() -> None:
    loads = {"press": press(), "shear": shear(40.0), "pull": pull(30.0)}
    case = {**hertz(0.01, 40.0), "supports": SLIDING, "loads": loads}
    result = BACKEND.solve(parse_case(case))
    assert result.refinement is not None
    assert result.refinement.converged
    left, right = result.contacts[0].stations
    assert left.k_t_range > 2 * right.k_t_range
    for edge in (left, right):
        assert edge.k_n[-1] == pytest.approx(k_n(PROFILE, HALF_WIDTH), rel=0.01)
        for zone in edge.slip_zones[-2:]:
            # the loop formula is off by half of d/a = 0.06 and 0.12
            assert zone.length == pytest.approx(zone.predicted_loop, rel=0.1)


def test_a_contact_smaller_than_an_element_is_found() -> None:
    case = {**hertz(0.01, 0.2), "loads": {"press": press(2.0), "shear": shear(0.2)}}
    half_width = float(PROFILE.half_width(2.0))
    result = BACKEND.solve(parse_case(case))
    assert result.refinement is not None
    assert result.refinement.passes[0].smallest_element > 2 * half_width
    for edge in result.contacts[0].stations:
        assert edge.k_n[-1] == pytest.approx(k_n(PROFILE, half_width), rel=0.01)


def test_too_many_unknowns_end_the_refinement_and_keep_what_there_is() -> None:
    case = hertz(0.005, 9.6)
    case["edges"]["unknowns"] = 12_000
    told = Told()
    result = BACKEND.solve(parse_case(case, Path("pad.toml")), RunOptions(observer=told))
    refinement = result.refinement
    assert refinement is not None
    assert not refinement.converged
    assert "pad.toml: edges.unknowns: mesh 3 would have" in refinement.reason
    assert "expected at most 12000" in refinement.reason
    assert len(refinement.passes) == 2
    assert np.isfinite(result.contacts[0].stations[0].k_n[-1])
    assert told.announced[0].startswith("mesh 1: ")


def test_a_later_pass_that_fails_does_not_take_the_others_away(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    solve, calls = refine_module.solve, []

    def failing(comm: MPI.Comm, case: Case, options: RunOptions, load: Any) -> Any:
        calls.append(load)
        keep = options.keep
        if len(calls) == 3:
            failure = ConvergenceError("step 7 failed")
            options = replace(options, keep=lambda result: keep(replace(result, failure=failure)))
        return solve(comm, case, options, load)

    monkeypatch.setattr(refine_module, "solve", failing)
    fields = tmp_path / "fields.hdf"
    case = {**hertz(0.005, 9.6), "output": {"fields": "last"}}
    there: list[bool] = []
    options = RunOptions(fields=fields, keep=lambda _: there.append(fields.exists()))
    result = BACKEND.solve(parse_case(case), options)
    assert result.failure is None
    # numbers are written before fields, when those of the mesh before are gone
    assert there == [False, False]
    assert result.refinement is not None
    assert result.refinement.reason == "step 7 failed"
    assert len(result.refinement.passes) == 2
    # the fields are those of the second mesh, too
    assert [path.name for path in tmp_path.iterdir()] == ["fields.hdf"]
    assert len(FieldReader(fields).nodes("upper")) == len(result.bodies["upper"].cells)


def test_the_first_mesh_may_have_too_many_unknowns() -> None:
    case = hertz(0.005, 9.6)
    case["edges"]["unknowns"] = 1000
    with pytest.raises(MeshError, match=r"edges\.unknowns: mesh 1 would have \d+ unknowns"):
        BACKEND.solve(parse_case(case))


def test_element_sizes_and_an_accuracy_contradict_each_other() -> None:
    case = hertz(0.005, 9.6)
    case["geometry"]["parameters"] |= {"size": 0.05, "growth": 0.2}
    with pytest.raises(CaseError, match=r"no element sizes together .*, found size, growth"):
        BACKEND.solve(parse_case(case))


def test_a_finished_mesh_cannot_be_refined() -> None:
    case = pad(edges={"tolerance": 0.01}, geometry={"file": "pad.msh"})
    with pytest.raises(CaseError, match=r"edges\.tolerance: expected a geometry .*'pad\.msh'"):
        BACKEND.solve(parse_case(case))
