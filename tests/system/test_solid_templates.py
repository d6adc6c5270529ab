# SPDX-License-Identifier: LGPL-3.0-or-later
"""Templates whose bodies are solid: sizes, faces and element sizes against what is asked for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases.pad_cases import pad, press

from fretfe._typing import Array
from fretfe.backends.passes import starting_mesh
from fretfe.case import parse_case
from fretfe.mesh.elements import facet_measures
from fretfe.mesh.make import mesh_template
from fretfe.mesh.mesh import BodyMesh, Mesh, body_unknowns, count_unknowns, mesh_summary
from fretfe.mesh.templates import find_template, template_directory

SIDES = {"left", "right", "back", "front", "contact"}
COARSE_SPHERE = {"size": 0.35, "growth": 0.5}
COARSE_CYLINDER = {"size": 0.4, "growth": 0.6, "end_size": 1.0, "length_size": 3.0}


def sphere(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("sphere"), COARSE_SPHERE | parameters, order)


def cylinder(order: int = 2, **parameters: float) -> Mesh:
    return mesh_template(find_template("cylinder_finite"), COARSE_CYLINDER | parameters, order)


def nodes(body: BodyMesh, name: str) -> Array:
    return body.points[np.unique(body.boundaries[f"{body.name}_{name}"])]


def area(body: BodyMesh, name: str) -> float:
    return float(facet_measures(body.points, body.boundaries[f"{body.name}_{name}"]).sum())


@pytest.mark.parametrize("order", [1, 2])
def test_faces_of_a_sphere_on_a_block(order: int) -> None:
    mesh = sphere(order)
    upper, lower = mesh.bodies["upper"], mesh.bodies["lower"]
    for body, end in ((upper, "top"), (lower, "bottom")):
        assert body.boundaries.keys() == {f"{body.name}_{side}" for side in SIDES | {end}}
        assert (body.cell, body.order) == ("tetrahedron", order)
        assert area(body, end) == pytest.approx(1600)
    x, y, z = nodes(upper, "contact").T
    # Gmsh's tolerance on curved faces; middles of straight edges lie inside
    np.testing.assert_allclose(np.hypot(np.hypot(x, y - 50), z), 50, atol=1e-6)
    assert y.min() == pytest.approx(0, abs=1e-3)
    assert np.abs([x, z]).max() == pytest.approx(1.6, abs=1e-6)
    assert area(lower, "contact") == pytest.approx(3.2**2)
    assert np.all(nodes(lower, "contact")[:, 1] == 0)
    assert nodes(upper, "left")[:, 0] == pytest.approx(-20)
    assert nodes(lower, "front")[:, 2] == pytest.approx(20)


def test_an_ellipsoid_on_a_sphere() -> None:
    mesh = sphere(radius_x=40, radius_z=90, lower_radius=60, contact_z=2)
    x, y, z = nodes(mesh.bodies["upper"], "contact").T
    # half axes: the vertical one is the smaller radius
    np.testing.assert_allclose(
        x**2 / 40**2 + (y - 40) ** 2 / 40**2 + z**2 / (90 * 40), 1, atol=1e-6
    )
    # so its curvatures are 1/40 and 1/90
    fitted = np.linalg.lstsq(np.column_stack([x**2 / 2, z**2 / 2]), y, rcond=None)[0]
    assert 1 / fitted == pytest.approx([40, 90], rel=2e-3)
    x, y, z = nodes(mesh.bodies["lower"], "contact").T
    np.testing.assert_allclose(np.hypot(np.hypot(x, y + 60), z), 60, atol=1e-6)
    assert np.abs(z).max() == pytest.approx(3.2, abs=1e-6)


def test_a_sphere_is_fine_in_the_contact_only() -> None:
    mesh = mesh_template(find_template("sphere"), {}, 2)
    for body, size in ((mesh.bodies["upper"], 0.085), (mesh.bodies["lower"], 1.07 * 0.085)):
        facets = body.boundaries[f"{body.name}_contact"]
        middle = body.points[facets[:, :3]].mean(axis=1)
        edges = np.sqrt(facet_measures(body.points, facets) * 4 / math.sqrt(3))
        fine = np.hypot(middle[:, 0], middle[:, 2]) < 1.2
        assert np.median(edges[fine]) == pytest.approx(size, rel=0.1)
        assert edges[fine].max() < 1.5 * size
        assert 45_000 < body_unknowns(body, 2) < 65_000
    # slivers, which Gmsh's optimiser removes, have some degrees or less
    assert min(body.smallest_angle for body in mesh_summary(mesh)) > 8


def test_a_mesh_can_be_made_again() -> None:
    first, second = sphere(), sphere()
    for name, body in first.bodies.items():
        np.testing.assert_array_equal(body.points, second.bodies[name].points)
        np.testing.assert_array_equal(body.cells, second.bodies[name].cells)


@pytest.mark.parametrize("overhang", [0.0, 4.0])
def test_faces_of_a_finite_cylinder(overhang: float) -> None:
    mesh = cylinder(overhang=overhang)
    upper, lower = mesh.bodies["upper"], mesh.bodies["lower"]
    assert upper.boundaries.keys() == {f"upper_{s}" for s in ("contact", "top", "back", "front")}
    assert lower.boundaries.keys() == {f"lower_{side}" for side in SIDES | {"bottom"}}
    x, y, z = nodes(upper, "contact").T
    np.testing.assert_allclose(np.hypot(x, y - 30), 30, atol=1e-6)
    assert (z.min(), z.max()) == pytest.approx((-5, 5))
    assert area(upper, "contact") == pytest.approx(2 * 30 * math.asin(1.5 / 30) * 10, rel=1e-6)
    assert area(lower, "contact") == pytest.approx(30)
    assert area(lower, "bottom") == pytest.approx(20 * (10 + 2 * overhang))
    assert area(lower, "left") == pytest.approx(10 * (10 + 2 * overhang))
    assert area(upper, "top") == pytest.approx(200)
    assert nodes(upper, "front")[:, 2] == pytest.approx(5)
    assert nodes(lower, "back")[:, 2] == pytest.approx(-5 - overhang)


def test_layers_are_thin_at_the_ends() -> None:
    mesh = cylinder(order=1, end_size=0.3, length_size=2.0, growth=0.4)
    z = np.unique(np.round(nodes(mesh.bodies["upper"], "contact")[:, 2], 9))
    layers = np.diff(z)
    assert layers == pytest.approx(layers[::-1])
    # scaled to fill the length, by less than a third of a layer in all
    assert layers[0] == pytest.approx(0.3, rel=0.2)
    ratios = layers[1 : len(layers) // 2] / layers[: len(layers) // 2 - 1]
    assert ratios == pytest.approx(1.4)


def test_scripts_of_solids_refine_themselves_as_templates_do() -> None:
    pressed = {"loads": {"press": press(steps=1)}, "edges": {"tolerance": 0.05}}
    ball = {"parameters": {"size": 0.35, "growth": 0.6}}
    extruded = {"parameters": {"size": 0.1}, "solid": {"length": 4.0, "layers": 2}}
    for name, geometry in (("sphere", ball), ("cylinder", extruded)):
        sources = {"template": name}, {"file": str(template_directory() / f"{name}.geo")}
        cases = [parse_case(pad(geometry=geometry | x, **pressed), trust_geo=True) for x in sources]
        first, second = (count_unknowns(starting_mesh(case), 2) for case in cases)
        assert first == second
