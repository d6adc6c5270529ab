# SPDX-License-Identifier: LGPL-3.0-or-later
"""Initial strain below surfaces: depths and directions, notes of coarse meshes, wrong tables."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.pad_cases import pad, press

from fretfe._typing import Array
from fretfe.bodies.definition import define_model, model_notes
from fretfe.bodies.loads.strain import Layer
from fretfe.case import parse_case
from fretfe.errors import CaseError, MeshError
from fretfe.idealise import obstacles
from fretfe.materials.material import Material
from fretfe.mesh.mesh import Mesh, check_groups
from fretfe.surface.surface import boundary_surface


def ring(points: Array) -> Array:
    radius, angle = points.T
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def test_depth_below_a_curved_surface_and_its_directions() -> None:
    mesh = blocks.block(
        "b", np.linspace(1, 2, 5), np.linspace(0, np.pi / 2, 13), order=2, mapping=ring
    )
    layer = Layer((boundary_surface(mesh, "b_right"),), np.array([0.0, 1.0]), np.array([3.0, 1.0]))
    radius, angle = np.array([[2.0, 1.75, 1.2], [0.3, 0.9, 1.3]])
    strain = layer.strain(ring(np.stack([radius, angle], axis=1)))
    size = 3.0 - 2.0 * (2.0 - radius)
    normal = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    np.testing.assert_allclose(np.einsum("mij,mj->mi", strain, normal), 0.0, atol=0.02)
    np.testing.assert_allclose(np.trace(strain, axis1=1, axis2=2), 2 * size, rtol=2e-3)
    np.testing.assert_allclose(strain[:, 2, 2], size, rtol=2e-3)


def test_the_nearest_surface_counts_and_beside_its_end_the_distance() -> None:
    mesh = blocks.block("b", np.linspace(0, 4, 9), np.linspace(0, 1, 3))
    surfaces = tuple(boundary_surface(mesh, f"b_{side}") for side in ("left", "bottom"))
    depths, values = np.array([0.0, 1.0]), np.array([1.0, 0.0])
    strain = Layer(surfaces, depths, values).strain(np.array([[0.1, 0.5], [2.0, 0.2]]))
    np.testing.assert_allclose(strain[0], 0.9 * np.diag([0, 1, 1]), atol=1e-9)
    np.testing.assert_allclose(strain[1], 0.8 * np.diag([1, 0, 1]), atol=1e-9)
    half = blocks.block("b", np.linspace(0, 2, 5), np.linspace(0, 1, 3))
    bottom = Layer((boundary_surface(half, "b_bottom"),), depths, values)
    # (2.8, .6) is 1 from the end, (2.3, .4) half; samples are nearer by less than 1/16.
    size = bottom.strain(np.array([[2.8, 0.6], [2.3, 0.4]]))[:, 2, 2]
    np.testing.assert_allclose(size, [0.0, 0.5], atol=0.07)


def peened(**keys: Any) -> dict[str, Any]:
    own = {
        "type": "eigenstrain",
        "surfaces": ["lower_top"],
        "depths": [0.0, 0.5],
        "values": [1e-3, 0.0],
        "history": [{"ramp": 1.0, "until": 1.0, "steps": 2}],
    }
    table = {key: value for key, value in {**own, **keys}.items() if value is not None}
    contact = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
    base = {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}}
    return pad(
        loads={"press": {**press(), "boundary": "upper_top"}, "peen": table},
        contacts={"main": contact},
        supports=base,
    )


def mesh(rows: int) -> Mesh:
    upper = blocks.block("upper", [0, 1, 2], [0, 1])
    lower = blocks.block("lower", [0, 1, 2], np.linspace(-1, 0, rows + 1))
    return Mesh({"upper": upper, "lower": lower})


@pytest.mark.parametrize(("rows", "notes"), [(1, 1), (2, 0), (4, 0)])
def test_elements_that_do_not_see_the_layer_are_told(rows: int, notes: int) -> None:
    case = parse_case(peened())
    found = model_notes(case, define_model(case, mesh(rows)), mesh(rows))
    assert len(found) == notes
    if notes:
        assert found[0].startswith(
            "loads.peen: elements below the surfaces of lower are up to 1 mm high, next to depths "
            "that differ by 0.5 mm"
        )


def test_a_layer_that_no_body_contains_is_told() -> None:
    case = parse_case(peened(depths=[0.0, 500.0], values=[1e-3, 0.0]))
    (note,) = model_notes(case, define_model(case, mesh(4)), mesh(4))
    assert note == (
        "loads.peen: the depths go down to 500 mm, but nothing of lower is deeper below the "
        "surfaces than 1 mm: check their unit"
    )


def test_a_uniform_strain_needs_no_fine_mesh() -> None:
    case = parse_case(peened(depths=[0.0], values=[1e-3]))
    assert model_notes(case, define_model(case, mesh(1)), mesh(1)) == ()


KEYS: dict[str, tuple[dict[str, Any], str]] = {
    "count": ({"values": [1.0]}, "expected as many values as depths, found 2 depths and 1 values"),
    "start": ({"depths": [0.1, 0.5]}, "expected depths that increase from 0, found [0.1, 0.5]"),
    "order": ({"depths": [0.0, 0.0]}, "expected depths that increase from 0, found [0.0, 0.0]"),
    "negative": ({"depths": [0.0, -1.0]}, "loads.peen.depths[item 2]: expected a number >= 0"),
    "nan": ({"values": [1.0, float("nan")]}, "loads.peen.values[item 2]: expected a finite number"),
    "empty": ({"depths": [], "values": []}, "loads.peen.depths: expected"),
    "no surface": ({"surfaces": []}, "loads.peen.surfaces: expected"),
    "missing": (
        {"surfaces": None},
        "loads.peen: expected 'surfaces', 'depths' and 'values', or "
        "'file', found 'depths', 'values'",
    ),
    "nothing": (
        {"surfaces": None, "depths": None, "values": None},
        "loads.peen: expected 'surfaces', 'depths' and 'values', or 'file', found none",
    ),
    "both": ({"file": "a.csv"}, "or 'file', found 'surfaces', 'depths', 'values', 'file'"),
    "bodies": ({"bodies": ["lower"]}, "loads.peen: expected 'bodies' with 'file' only"),
    "text": ({"surfaces": "lower_top"}, "loads.peen.surfaces: expected"),
    "boundary": ({"boundary": "lower_top"}, "loads.peen.boundary: unknown key"),
}


@pytest.mark.parametrize(("keys", "expected"), KEYS.values(), ids=KEYS)
def test_bad_keys(keys: dict[str, Any], expected: str) -> None:
    with pytest.raises(CaseError, match=re.escape(expected)):
        parse_case(peened(**keys))


def test_an_unknown_surface() -> None:
    with pytest.raises(MeshError, match=r"peen\.surfaces\[item 1\]: no physical curve 'tip'"):
        check_groups(mesh(1), parse_case(peened(surfaces=["tip"])))


def test_half_planes_have_no_layers() -> None:
    data = pad(loads={"press": press(), "peen": peened()["loads"]["peen"]})
    (reason,) = (each for each in obstacles(parse_case(data)) if "peen" in each)
    assert reason.endswith("found an eigenstrain (everywhere)")


WHOLE = "x,y,exx,eyy,ezz,exy\n-9,-9,1,2,3,4\n9,-9,1,2,3,4\n-9,9,1,2,3,4\n9,9,1,2,3,4\n"
FILES: dict[str, tuple[str, str]] = {
    "whole": (WHOLE, ""),
    "no component": (WHOLE.replace("ezz", "z"), "expected one column 'ezz'"),
    "nan": (WHOLE.replace("4\n-9,9", "nan\n-9,9"), "line 3, column 'exy': expected a finite"),
    "a point twice": (WHOLE.replace("-9", "9"), "expected a point of its own"),
    "near": (WHOLE.replace("9", ".9"), "expected points that reach as far as the body"),
    "other body": (WHOLE, "loads.peen.bodies[item 1]: expected one of the bodies 'upper', 'lower'"),
}


@pytest.mark.parametrize(("text", "expected"), FILES.values(), ids=FILES)
def test_files_of_strains(text: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "weld.csv").write_text(text)
    keys: dict[str, Any] = {"surfaces": None, "depths": None, "values": None, "file": "weld.csv"}
    if "bodies" in expected:
        keys["bodies"] = ["shim"]

    def define() -> Array:
        case = parse_case(peened(**keys), tmp_path / "case.toml")
        load = define_model(case, mesh(1)).loads[-1]
        case_body = case.bodies["lower"]
        return load.initial_strain("lower", Material.of(case_body, "strain"), np.zeros((1, 2)))[0]

    if not expected:
        np.testing.assert_allclose(define(), [[1, 4, 0], [4, 2, 0], [0, 0, 3]], atol=1e-12)
        return
    with pytest.raises(CaseError, match=re.escape(expected)):
        define()
