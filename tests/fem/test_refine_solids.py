# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of solids that refine themselves: along the fronts only, of templates and of CAD files."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from campaign.extent import every_so_many_weeks
from cases.cycled_sphere import FORCE, FRICTION, PEAK, cycles, tables
from cases.pad_cases import pad, press
from harness.told import Told

from fretfe.backends import RunOptions, meshes
from fretfe.backends.meshes import FINER, finer_sweep
from fretfe.backends.passes import starting_mesh
from fretfe.case import Case, parse_case
from fretfe.errors import CaseError
from fretfe.fem.backend import BACKEND
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.load import grouped_mesh, makes_solids
from fretfe.mesh.mesh import count_unknowns
from fretfe.mesh.sizing import FinePlaces, refine_near


def case(geometry: dict[str, Any], **edges: float) -> Case:
    edges = {"tolerance": 0.02, **edges}
    return parse_case(pad(geometry=geometry, loads={"press": press(steps=1)}, edges=edges))


def test_plane_templates_are_no_solids() -> None:
    plane = {"template": "cylinder"}
    assert not makes_solids(case(plane))
    assert makes_solids(case({"template": "sphere"}))
    assert makes_solids(case(plane | {"solid": {"length": 4.0, "layers": 2}}))


def test_sizes_of_a_swept_template_shrink_together() -> None:
    given = {"template": "cylinder_finite", "parameters": {"size": 0.2}}
    found = finer_sweep(case(given), 2.0).geometry.parameters
    assert found == pytest.approx({"size": 0.1, "end_size": 0.125, "length_size": 0.75})
    ball = case({"template": "sphere", "parameters": {"size": 0.2}})
    assert finer_sweep(ball, 2.0) == ball


def test_layers_of_an_extruded_template_become_thinner() -> None:
    solid = {"length": 4.0, "layers": 5}
    geometry = {"template": "flat_rounded", "parameters": {"edge_size": 0.02}, "solid": solid}
    finer = finer_sweep(case(geometry), FINER).geometry
    assert finer.parameters == {"edge_size": 0.02}
    assert finer.solid is not None and finer.solid.layers == 7


def test_first_mesh_is_that_of_the_case() -> None:
    geometry = {"template": "sphere", "parameters": {"size": 0.35, "growth": 0.5}}
    first = count_unknowns(starting_mesh(case(geometry)), 2)
    assert first == count_unknowns(starting_mesh(case(geometry, tolerance=0.1)), 2)
    assert first < 20_000


def ring(size: float, *, plane: bool = False) -> FinePlaces:
    """A circle of radius 1 about the place where the sphere touches, or an edge of the pad."""
    angle = np.linspace(0.0, 2 * np.pi, 200)
    points = np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
    points = np.array([[1.0, 0.0, 0.0]]) if plane else points
    return FinePlaces(points, np.full(len(points), size))


def test_elements_are_finer_along_the_front_only() -> None:
    given = case({"template": "sphere", "parameters": {"size": 0.35, "growth": 0.5}})
    body = grouped_mesh(given, partial(refine_near, ring(0.08), 0.3)).bodies["upper"]
    facets = body.points[body.boundaries["upper_contact"][:, :3]]
    lengths = np.linalg.norm(np.diff(facets[:, [0, 1, 2, 0]], axis=1), axis=2)
    radius = np.linalg.norm(facets.mean(axis=1)[:, [0, 2]], axis=1)
    at_front = np.median(lengths[np.abs(radius - 1) < 0.05])
    assert at_front == pytest.approx(0.08, rel=0.2)
    assert np.median(lengths[radius < 0.4]) > 2 * at_front
    # The next model has its own sizes again.
    assert count_unknowns(grouped_mesh(given), 2) == count_unknowns(starting_mesh(given), 2)


def test_the_plane_mesh_that_is_extruded_is_finer_at_the_edge_on_both_sides() -> None:
    parameters = {"edge_size": 0.05, "growth": 0.4}
    solid = {"length": 1.0, "layers": 1}
    given = case({"template": "flat_rounded", "parameters": parameters, "solid": solid})
    count = [
        [len(body.cells) for body in grouped_mesh(given, size).bodies.values()]
        for size in (None, partial(refine_near, ring(0.01, plane=True), 0.3))
    ]
    (upper, lower), (finer_upper, finer_lower) = count
    assert finer_upper > 1.2 * upper and finer_lower > 1.2 * lower


@pytest.fixture(scope="module")
def step(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A quarter of the sphere of the template as a CAD file: two blocks, one with a round face."""
    path = tmp_path_factory.mktemp("cad") / "ball.step"
    with gmsh_model(path):
        occ = gmsh.model.occ
        block = [(3, occ.addBox(0, 0, 0, 6, 8, 6))]
        occ.intersect(block, [(3, occ.addSphere(0, 50, 0, 50))])
        occ.addBox(0, -8, 0, 6, 8, 6)
        occ.synchronize()
        gmsh.write(str(path))
    return path


def cad_tables(step: Path, **geometry: Any) -> dict[str, Any]:
    data = tables(FRICTION, shear=[{"hold": True, "until": 1.0}])
    press = data["loads"]["press"]
    data["loads"] = {"press": press | {"history": [{"ramp": -FORCE / 4, "until": 1, "steps": 1}]}}
    planes = {
        f"{body}_{axis}": {"point": [0 if axis == "x" else 3, y, 0 if axis == "z" else 3]}
        for body, y in (("upper", 4), ("lower", -4))
        for axis in "xz"
    }
    data["supports"] |= {name: {"boundary": name, "fix": [name[-1]]} for name in planes}
    data["geometry"] = {
        "file": str(step),
        "bodies": {"upper": {"point": [3, 4, 3]}, "lower": {"point": [3, -4, 3]}},
        "boundaries": {
            "upper_contact": {"point": [1, 50 - 2498**0.5, 1], "body": "upper"},
            "upper_top": {"point": [3, 8, 3]},
            "lower_contact": {"point": [3, 0, 3], "body": "lower"},
            "lower_bottom": {"point": [3, -8, 3]},
            **planes,
        },
        **geometry,
    }
    return data


def test_solids_of_a_cad_file_begin_with_an_element_size(step: Path) -> None:
    data = cad_tables(step) | {"edges": {"tolerance": 0.03}}
    with pytest.raises(CaseError, match=r"geometry\.size: expected an element size \(with edges"):
        BACKEND.solve(parse_case(data), RunOptions())


@pytest.mark.slow
@every_so_many_weeks(2, 0)
def test_solids_of_a_cad_file_refine_themselves(step: Path) -> None:
    data = cad_tables(step, size=0.5)
    data["edges"] = {"tolerance": 0.05, "stations": 12, "unknowns": 50_000, "local": False}
    result = BACKEND.solve(parse_case(data), RunOptions())
    refinement = result.refinement
    assert refinement is not None and refinement.converged, refinement
    (front,) = result.contacts[0].fronts
    # The tolerance is of the change from the mesh before; single fits may be worse, and know it.
    errors = np.abs(front.along("reported_k_n") / (PEAK * np.sqrt(2)) - 1)
    bars = np.array([x.k_n_spread[x.last] / x.k_n[x.last] for x in front.stations])
    assert (errors <= np.fmax(bars, 0.05)).all()
    assert np.median(errors) <= 0.025
    worst = refinement.passes[-1].worst
    assert worst is not None and worst.change <= 0.05 and worst.front == "front 1"
    assert {each.quantity for each in refinement.passes[-1].changes} == {"K_N", "ΔK"}


@pytest.mark.slow
def test_a_mesh_that_tells_fewer_fronts_is_not_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    fronts = iter((0, 2, 2, 1))  # of no mesh and the first, and of both
    monkeypatch.setattr(meshes, "fronts_told", lambda _: next(fronts))
    geometry = {"template": "sphere", "parameters": {"size": 0.35, "growth": 0.6}}
    result = BACKEND.solve(case(geometry, stations=8, local=False), RunOptions())
    refinement = result.refinement
    assert result.failure is None and refinement is not None
    assert len(refinement.passes) == 1
    assert refinement.reason.startswith("mesh 2 tells K_N along 1 fronts, expected the 2 of")
    assert not list(fronts)


@pytest.mark.slow
@every_so_many_weeks(2, 1)
def test_sphere_until_the_limit() -> None:
    """A mesh with too many unknowns is not solved; what the one before gave is kept."""
    data = tables(FRICTION, shear=cycles())
    data["geometry"]["parameters"] = {"size": 0.2, "growth": 0.6}
    data |= {"edges": {"tolerance": 1e-3, "unknowns": 110_000, "stations": 12, "local": False}}
    data |= {"cycle": {"start": 4.0, "end": 6.0, "more": 0}}
    told = Told()
    result = BACKEND.solve(parse_case(data), RunOptions(observer=told))
    refinement = result.refinement
    assert refinement is not None and not refinement.converged
    assert f"edges.unknowns: mesh {len(refinement.passes) + 1} would have" in refinement.reason
    unknowns = [each.unknowns for each in refinement.passes]
    assert unknowns == sorted(unknowns) and unknowns[-1] <= 110_000
    # Too coarse for fronts at first: nothing to compare is no agreement.
    assert refinement.passes[0].change == np.inf
    last = refinement.passes[-1]
    assert [station.number for station in last.stations] == list(range(12))
    assert last.changes == ()
    assert [x.k_n for x in last.stations] == pytest.approx(np.full(12, PEAK * np.sqrt(2)), rel=0.03)
    assert told.announced.count("mesh 1: no edge factors yet") == 1
