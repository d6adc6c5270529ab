# SPDX-License-Identifier: LGPL-3.0-or-later
"""Elements along the fronts at free ends, judged before the solve: too long, and by what key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import BASE, pad, press

from fretfe.bodies.free_ends import ThickEnd, end_warning, graded, thick_ends
from fretfe.case import Case, parse_case
from fretfe.errors import CaseError
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.make import write_mesh
from fretfe.surface.checks import load_mesh

pytest.importorskip("gmsh")

PLANE = {"template": "cylinder", "parameters": {"size": 0.2, "zone": 1.5, "growth": 0.5}}
LENGTH = 4.0
STATIONS = 10
# Half of the spacing of the stations.
FIRST = LENGTH / STATIONS / 2
BACK = {name: {"boundary": f"{name}_back", "fix": ["z"]} for name in ("upper", "lower")}
FRONT = {f"{name}2": {"boundary": f"{name}_front", "fix": ["z"]} for name in ("upper", "lower")}


def solid(**keys: Any) -> dict[str, Any]:
    return {**PLANE, "solid": {"length": LENGTH, "layers": 5, **keys}}


def case(geometry: dict[str, Any], supports: dict[str, Any] | None = None, **edges: float) -> Case:
    tables = pad(
        geometry=geometry,
        loads={"press": press(steps=1)},
        edges={"stations": STATIONS, **edges},
        supports={**BASE, **(supports or {})},
    )
    return parse_case(tables)


def found(one: Case) -> list[ThickEnd]:
    return list(thick_ends(one, load_mesh(one)))


def test_layers_thicker_than_the_first_station_is_away_are_reported_with_the_size_to_use() -> None:
    one = case(solid())
    (end,) = found(one)
    assert end.contact == "main"
    assert end.size == pytest.approx(LENGTH / 5)
    # stations at .2, .6, 1.0, ...
    assert end.left_out == 2
    assert end.wanted == pytest.approx(0.7 * FIRST, rel=0.02)
    (text,) = end_warning(one, load_mesh(one))
    assert "at 2 of 10 stations next to an end" in text and "0.8 mm long" in text
    assert text.endswith("set geometry.solid.end_size = 0.14")
    assert not found(case(solid(end_size=0.14)))


def test_the_end_of_a_shorter_body_is_free_in_the_length_of_the_other_one() -> None:
    shorter = solid(spans={"upper": [0.2, LENGTH]})
    (end,) = found(case(shorter, FRONT | BACK))
    first = (LENGTH - 0.2) / STATIONS / 2
    assert end.wanted == pytest.approx(0.7 * first, rel=0.01)
    assert not found(case(shorter | {"solid": shorter["solid"] | {"end_size": 0.1}}, FRONT))
    with pytest.raises(CaseError, match=r"solid.spans: expected spans of the bodies lower, upper"):
        load_mesh(case(solid(spans={"pad": [1.0, LENGTH]})))
    tolerant = graded(case(shorter, tolerance=0.06)).geometry.solid
    assert tolerant is not None and tolerant.end_size == pytest.approx(0.7 * first, rel=0.06)


def test_layers_between_two_stations_leave_out_one() -> None:
    (end,) = found(case(solid(end_size=0.3)))
    assert (end.left_out, end.size) == (1, pytest.approx(0.3, rel=0.1))


@pytest.mark.parametrize(
    ("supports", "count"), [(BACK, 1), (BACK | FRONT, 0)], ids=["half", "both held"]
)
def test_no_end_is_free_in_a_plane_of_symmetry(supports: dict[str, Any], count: int) -> None:
    assert len(found(case(solid(), supports))) == count


def test_templates_of_solids_are_judged_by_their_own_key_and_round_contacts_have_no_ends() -> None:
    sizes = {"size": 0.4, "growth": 0.6, "end_size": 1.0, "length_size": 3.0}
    one = case({"template": "cylinder_finite", "parameters": sizes})
    (text,) = end_warning(one, load_mesh(one))
    # 10 mm long: the first station is .5 mm from an end, and the mesh has .97 of its key
    assert text.endswith("set geometry.parameters.end_size = 0.36")
    sphere = {"template": "sphere", "parameters": {"size": 0.35, "growth": 0.5}}
    assert not found(case(sphere))


def test_a_mesh_file_has_no_key(tmp_path: Path) -> None:
    whole = case(solid())
    plane = load_mesh(case(PLANE))
    assert whole.geometry.solid is not None
    write_mesh(extrude(plane, whole.geometry.solid), tmp_path / "pad.msh")
    one = case({"file": str(tmp_path / "pad.msh")})
    (text,) = end_warning(one, load_mesh(one))
    assert text.endswith("make them 0.14 mm long there")
    assert found(one) == found(whole)


@pytest.mark.parametrize("size", [0.2, 0.3])
def test_a_length_to_use_does_not_follow_the_elements_of_a_mesh_file(
    tmp_path: Path, size: float
) -> None:
    """Elements that are smaller at the end are smaller across the front, too: both may be meant."""
    solid_keys = case(solid(layers=10)).geometry.solid
    assert solid_keys is not None
    geometry = {**PLANE, "parameters": {"size": size, "zone": 1.5, "growth": 0.5}}
    write_mesh(extrude(load_mesh(case(geometry)), solid_keys), tmp_path / "pad.msh")
    one = case({"file": str(tmp_path / "pad.msh")}, stations=20)
    (text,) = end_warning(one, load_mesh(one))
    assert "0.4 mm long" in text and "at 2 of 20 stations" in text
    assert text.endswith("make them 0.07 mm long there, or 0.7 times as long as across the front")


def test_a_case_that_refines_itself_begins_with_layers_for_its_stations() -> None:
    tolerant = graded(case(solid(), tolerance=0.06))
    assert tolerant.geometry.solid is not None and tolerant.geometry.solid.end_size == 0.14
    # bars at the first station fall with the square of the layers
    stricter = graded(case(solid(), tolerance=0.015))
    assert stricter.geometry.solid is not None and stricter.geometry.solid.end_size == 0.07
    given = case(solid(end_size=0.5), tolerance=0.06)
    assert graded(given) is given
    template = {"template": "cylinder_finite"}
    # .25 mm by default: half of the spacing is .5 mm
    assert graded(case(template, tolerance=0.06)).geometry.parameters == {}
    fine = graded(case(template, stations=40, tolerance=0.06)).geometry
    assert fine.parameters == {"end_size": 0.087}
