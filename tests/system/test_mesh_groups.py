# SPDX-License-Identifier: LGPL-3.0-or-later
"""The groups that a case names against the groups that the mesh has."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest
from cases.tiny_meshes import TWO_SQUARES, TinyMesh

from fretfe.case import Case, parse_case
from fretfe.errors import MeshError
from fretfe.mesh.make import read_mesh
from fretfe.mesh.mesh import Mesh, check_groups

MATERIAL = {"young": 2e5, "poisson": 0.3}
RAMP = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
CASE: dict[str, Any] = {
    "geometry": {"file": "m.msh"},
    "bodies": {"upper": MATERIAL, "lower": MATERIAL},
    "contacts": {
        "middle": {"surface1": "upper_face", "surface2": "lower_face", "friction": 0.3}
    },
    "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
    "loads": {
        "pull": {"type": "traction", "boundary": "upper_top", "direction": "y", "history": RAMP}
    },
}  # fmt: skip
SQUARES = TWO_SQUARES.add((1, "lower_bottom", (1, 2)))


def mesh(directory: Path, tiny: TinyMesh = SQUARES) -> Mesh:
    return read_mesh(tiny.write(directory / "m.msh"))


def case(*path: str, value: Any = None) -> Case:
    """The case with the value at a path replaced."""
    data = copy.deepcopy(CASE)
    if path:
        table = data
        for key in path[:-1]:
            table = table[key]
        table[path[-1]] = value
    return parse_case(data)


def test_fitting_mesh(tmp_path: Path) -> None:
    check_groups(mesh(tmp_path), case())


def test_loads_without_boundary_are_no_matter(tmp_path: Path) -> None:
    dense = {"young": 2e5, "poisson": 0.3, "density": 8e-9}
    data = copy.deepcopy(CASE)
    data["bodies"] = {"upper": dense, "lower": dense}
    data["loads"] = {"spin": {"type": "rotation", "centre": [0, 0], "history": RAMP}}
    check_groups(mesh(tmp_path), parse_case(data))


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        pytest.param(
            ("bodies",),
            {"uper": MATERIAL, "lower": MATERIAL},
            r"bodies\.uper: no physical surface 'uper' \(did you mean upper",
            id="body",
        ),
        pytest.param(
            ("contacts", "middle", "surface1"),
            "uper_face",
            r"contacts\.middle\.surface1: no physical curve 'uper_face' \(did you mean upper_face",
            id="surface1",
        ),
        pytest.param(
            ("contacts", "middle", "surface2"),
            "xyz",
            r"contacts\.middle\.surface2: no physical curve 'xyz'\n",
            id="surface2",
        ),
        pytest.param(
            ("supports", "base", "boundary"),
            "bottom",
            r"supports\.base\.boundary: no physical curve 'bottom'",
            id="support",
        ),
        pytest.param(
            ("loads", "pull", "boundary"),
            "upper",
            r"loads\.pull\.boundary: no physical curve 'upper'",
            id="load",
        ),
        pytest.param(
            ("contacts", "middle", "surface2"),
            "upper_top",
            r"contacts\.middle: expected surfaces of two bodies.*are both on 'upper'",
            id="same body",
        ),
    ],
)
def test_misfit(tmp_path: Path, path: tuple[str, ...], value: Any, message: str) -> None:
    with pytest.raises(MeshError, match=message) as caught:
        check_groups(mesh(tmp_path), case(*path, value=value))
    assert "bodies (physical surfaces) of the mesh: lower, upper\n" in str(caught.value)
    assert "lower_face, lower_bottom, upper_face, upper_top" in str(caught.value)


def test_body_that_the_case_forgot(tmp_path: Path) -> None:
    nodes = (*SQUARES.nodes, (5.0, 0.0, 0.0), (6.0, 0.0, 0.0), (5.0, 1.0, 0.0))
    tiny = TinyMesh(nodes, (*SQUARES.elements, (2, "third", (9, 10, 11))))
    with pytest.raises(MeshError, match=r"has a body 'third', but the case has no \[bodies\.third"):
        check_groups(mesh(tmp_path, tiny), case())


def test_contact_surface_on_two_bodies(tmp_path: Path) -> None:
    tiny = SQUARES.add((1, "sides", (2, 3)), (1, "sides", (6, 7)))
    with pytest.raises(MeshError, match=r"surface1: expected a boundary of one body.*lower, upper"):
        check_groups(mesh(tmp_path, tiny), case("contacts", "middle", "surface1", value="sides"))
