# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes that no machine could solve are refused before they are made."""

from __future__ import annotations

import pytest

from fretfe.errors import MeshError
from fretfe.mesh import make as expected
from fretfe.mesh.gmsh import script_model
from fretfe.mesh.make import expected_elements, mesh_template
from fretfe.mesh.templates import find_template

CYLINDER = find_template("cylinder")


def test_the_number_of_elements_is_known_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expected, "ENOUGH", 500)
    mesh = mesh_template(CYLINDER, {}, 1)
    count = sum(len(body.cells) for body in mesh.bodies.values())
    with script_model(CYLINDER, {}) as gmsh:
        assert count / 2 < expected_elements(gmsh, 0.15) < 2 * count
        assert gmsh.option.getNumber(expected.FACTOR) == 1
        assert not gmsh.model.mesh.getElementTypes().size


def test_layers_of_swept_bodies_are_no_finer_than_they_are() -> None:
    """Their number does not fall with larger elements, as that of the cells in a section does."""
    cylinder, thin = find_template("cylinder_finite"), {"end_size": 0.08, "length_size": 1.0}
    count = sum(len(body.cells) for body in mesh_template(cylinder, thin, 1).bodies.values())
    with script_model(cylinder, thin) as gmsh:
        assert count / 2 < expected_elements(gmsh, 0.4) < 2 * count


def test_a_mesh_that_is_too_large(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expected, "HARMLESS", {2: 1e3, 3: 1e3})
    monkeypatch.setattr(expected, "ENOUGH", 500)
    whole = mesh_template(CYLINDER, {"size": 0.02}, 1)
    monkeypatch.setattr(expected, "MOST_ELEMENTS", 5e3)
    with pytest.raises(MeshError, match=r"template 'cylinder': expected at most 5e\+03 elements"):
        mesh_template(CYLINDER, {}, 1)
    monkeypatch.setattr(expected, "MOST_ELEMENTS", 5e6)
    # the coarse meshes leave no trace
    monkeypatch.setattr(expected, "HARMLESS", {2: 0.0, 3: 0.0})
    again = mesh_template(CYLINDER, {"size": 0.02}, 1)
    for name, body in whole.bodies.items():
        assert (body.points == again.bodies[name].points).all()


def test_many_rows_of_triangles_are_known_from_the_curves_alone() -> None:
    with script_model(CYLINDER, {"zone": 6.0, "size": 1e-5, "growth": 0.03}) as gmsh:
        # two faces 12 mm wide: 2 · 12/(1e-5 · 0.03) · 4/√3 = 1.8e8, fewer along the coarser one
        assert 5e7 < expected_elements(gmsh, 0.03) < 2e8


def test_coarse_meshes_that_fail_are_no_fault_of_the_mesh() -> None:
    """Quadrilaterals alone need an even number of sides along each curve."""
    with script_model(CYLINDER, {}) as gmsh:
        gmsh.option.setNumber("Mesh.RecombineAll", 1)
        gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 3)
        assert expected_elements(gmsh, 0.15) == 0.0
        gmsh.model.mesh.generate(2)
        assert gmsh.model.mesh.getElements(2)[1][0].size > 100


@pytest.mark.parametrize(
    ("name", "sizes"),
    [
        ("cylinder", {"size": 1e-4}),
        ("wedge", {"size": 1e-4}),
        ("flat_rounded", {"edge_size": 1e-4, "flat_size": 1e-4}),
    ],
)
def test_contacts_of_too_many_lines_are_refused_before_anything_is_meshed(
    name: str, sizes: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """2 mm of contact have 20 000 lines: full matrices of 40 000 tractions, 66 GB by themselves."""
    monkeypatch.setattr(expected, "machine_memory", lambda: 16.0 * 2**30)
    monkeypatch.setattr(expected, "expected_elements", lambda *_: pytest.fail("meshed"))
    with pytest.raises(MeshError, match=r"[12]e\+04 of them along a contact.*Nothing was meshed"):
        mesh_template(find_template(name), sizes, 1)
