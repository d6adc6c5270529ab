# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids extruded from the templates: valid elements, volumes, complete boundaries, symmetry."""

from __future__ import annotations

import math
from pathlib import Path

import gmsh
import numpy as np
import pytest
from cases.pad_cases import pad_text, press
from harness.launch import fretfe
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fretfe.bodies.cyclic import tie_sides
from fretfe.case import Solid, parse_case
from fretfe.mesh.elements import directed_facets, exterior_facets, jacobian_determinants
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.make import mesh_template, write_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.mesh.templates import find_template
from fretfe.surface.checks import load_mesh

COARSE: dict[str, dict[str, float]] = {
    "cylinder": {"size": 0.2, "growth": 0.5},
    "dovetail": {"edge_size": 0.1, "edge_zone": 0.3, "flank_size": 0.5, "growth": 0.5},
    "firtree": {"edge_size": 0.05, "flank_size": 0.2, "growth": 0.5, "lobe_gap": 0.01},
    "flat_rounded": {"edge_size": 0.08, "flat_size": 0.2, "growth": 0.5},
    "wedge": {"size": 0.2, "growth": 0.5},
}
SOLID = Solid(length=6.0, skew=0.0, layers=3)
SKEWED = Solid(length=6.0, skew=-35.0, layers=2)


def plane(name: str, order: int) -> Mesh:
    return mesh_template(find_template(name), COARSE[name], order)


# Quadrature of degree 3, barycentric: the determinant of a map of order 2 is a cubic.
CUBIC_PLACES = np.vstack([np.full((1, 4), 1 / 4), np.full((4, 4), 1 / 6) + np.eye(4) / 3])
CUBIC_WEIGHTS = np.array([-4 / 5, 9 / 20, 9 / 20, 9 / 20, 9 / 20]) / 6
# Gmsh's order of the edges of a tetrahedron
EDGES = [(0, 1), (1, 2), (2, 0), (3, 0), (2, 3), (1, 3)]


def determinants(body: BodyMesh, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Jacobian determinants at barycentric places (p, 4) of each tetrahedron (m, p)."""
    slopes = np.vstack([-np.ones(3), np.eye(3)])
    gradients = np.tile(slopes, (len(places), 1, 1))
    if body.order == 2:
        corners = (4 * places[:, :, None] - 1) * slopes
        middles = [4 * (places[:, [i]] * slopes[j] + places[:, [j]] * slopes[i]) for i, j in EDGES]
        gradients = np.concatenate([corners, np.stack(middles, axis=1)], axis=1)
    values: NDArray[np.float64] = np.linalg.det(
        np.einsum("qka,mkd->mqad", gradients, body.points[body.cells])
    )
    return values


def area(body: BodyMesh) -> float:
    """Of a plane mesh; exact: the determinant is linear along the cell or of degree 2."""
    at_nodes = jacobian_determinants(body.points, body.cells, body.cell, body.order)
    return float(at_nodes[:, -3:].mean(axis=1).sum() / 2)


def outer_faces(body: BodyMesh) -> dict[tuple[int, ...], int]:
    """Vertices of the faces that one tetrahedron only has, and the vertex opposite to them."""
    faces: dict[tuple[int, ...], list[int]] = {}
    for cell in body.cells[:, :4].tolist():
        for opposite in range(4):
            face = tuple(sorted(cell[:opposite] + cell[opposite + 1 :]))
            faces.setdefault(face, []).append(cell[opposite])
    assert max(map(len, faces.values())) <= 2
    return {face: cells[0] for face, cells in faces.items() if len(cells) == 1}


CASES = pytest.mark.parametrize(
    ("name", "order", "solid"),
    [(name, order, SOLID) for name in COARSE for order in (1, 2)] + [("firtree", 2, SKEWED)],
    ids=lambda value: f"skew{value.skew:g}" if isinstance(value, Solid) else str(value),
)


@CASES
def test_elements_are_valid_and_fill_the_volume(name: str, order: int, solid: Solid) -> None:
    flat = plane(name, order)
    for body in extrude(flat, solid).bodies.values():
        assert determinants(body, np.eye(4)).min() > 0
        at_places = determinants(body, CUBIC_PLACES)
        assert at_places.min() > 0
        expected = area(flat.bodies[body.name]) * solid.length
        # round-off: sums of thousands of terms of one sign
        assert (at_places @ CUBIC_WEIGHTS).sum() == pytest.approx(expected, rel=1e-10)


@CASES
def test_boundaries_are_complete_and_outside(name: str, order: int, solid: Solid) -> None:
    flat = plane(name, order)
    for body in extrude(flat, solid).bodies.values():
        before = flat.bodies[body.name]
        assert set(body.boundaries) == {
            *before.boundaries,
            f"{body.name}_front",
            f"{body.name}_back",
        }
        faces = outer_faces(body)
        edges, _ = exterior_facets(directed_facets(before.cells, before.cell, before.order), "line")
        assert len(faces) == 2 * len(before.cells) + 2 * solid.layers * len(edges)
        for group, facets in body.boundaries.items():
            opposite = [faces[tuple(sorted(facet))] for facet in facets[:, :3].tolist()]
            a, b, c = (body.points[facets[:, k]] for k in range(3))
            inward = body.points[opposite] - a
            assert (np.einsum("fd,fd->f", np.cross(b - a, c - a), inward) < 0).all()
            if group in before.boundaries:
                assert len(facets) == 2 * solid.layers * len(before.boundaries[group])
            else:
                assert len(facets) == len(before.cells)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", ["dovetail", "firtree"])
def test_left_and_right_mirror_each_other(name: str, order: int) -> None:
    for body in extrude(plane(name, order), SOLID).bodies.values():
        # so do the tetrahedra: their means tell the ways to divide a prism apart
        cells = body.points[body.cells].mean(axis=1)
        distance, _ = cKDTree(cells * [-1, 1, 1]).query(cells)
        assert distance.max() < 1e-5
        flanks = [group for group in body.boundaries if "flank_left" in group]
        assert len(flanks) == {"dovetail": 1, "firtree": 3}[name]
        for group in flanks:
            # means over a facet tell the two diagonals of a quadrilateral apart
            left = body.points[body.boundaries[group]].mean(axis=1)
            mirror = body.points[body.boundaries[group.replace("left", "right")]].mean(axis=1)
            distance, _ = cKDTree(mirror * [-1, 1, 1]).query(left)
            # Gmsh finds the mirror images of nodes on arcs to about 1e-6 of their radius
            assert len(left) == len(mirror) and distance.max() < 1e-5


def test_curved_sides_are_extruded_curved() -> None:
    upper = extrude(plane("cylinder", 2), SKEWED).bodies["upper"]
    x, y, z = upper.points[np.unique(upper.boundaries["upper_contact"])].T
    x = x - math.tan(math.radians(SKEWED.skew)) * z
    # all nodes, those on diagonals too, lie on the cylinder; Gmsh's tolerance on curves
    np.testing.assert_allclose(y, 8 - np.sqrt(64 - x**2), atol=1e-9)
    front = upper.points[np.unique(upper.boundaries["upper_front"])]
    np.testing.assert_allclose(front[:, 2], 6.0)


@pytest.mark.parametrize("order", [1, 2])
def test_file_holds_the_groups_and_gmsh_finds_good_elements(tmp_path: Path, order: int) -> None:
    solid = extrude(plane("firtree", order), SKEWED)
    write_mesh(solid, tmp_path / "solid.msh")
    with gmsh_model(tmp_path / "solid.msh"):
        gmsh.merge(str(tmp_path / "solid.msh"))
        names = {
            (dim, gmsh.model.getPhysicalName(dim, tag))
            for dim, tag in gmsh.model.getPhysicalGroups()
        }
        tags = np.concatenate(gmsh.model.mesh.getElements(3)[1])
        jacobians = gmsh.model.mesh.getElementQualities(tags, "minDetJac")
        qualities = gmsh.model.mesh.getElementQualities(tags, "minSJ")
    expected = {(3, "blade"), (3, "disc")}
    expected |= {(2, name) for body in solid.bodies.values() for name in body.boundaries}
    assert names == expected
    assert len(tags) == sum(len(body.cells) for body in solid.bodies.values())
    assert jacobians.min() > 0 and qualities.min() > 0


SOLID_WEDGE = {
    "template": "wedge",
    "parameters": {"size": 0.2, "growth": 0.5},
    "order": 1,
    "solid": {"length": 4.0, "layers": 2},
}


def test_commands_take_a_solid(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(
        pad_text(geometry=SOLID_WEDGE, loads={"press": press(steps=1)})
    )
    case, target, results = tmp_path / "case.toml", tmp_path / "solid.msh", tmp_path / "results"
    done = fretfe("mesh", case, "-o", target)
    assert done.returncode == 0, done.stderr
    assert "tetrahedra" in done.stdout and target.stat().st_size > 0
    done = fretfe("check", case)
    assert done.returncode == 0, done.stderr
    assert "The case is valid." in done.stdout
    done = fretfe("run", case, "-o", results, "--no-report")
    assert done.returncode == 0, done.stderr
    assert "Contacts: P, |Q| in N, area in contact" in done.stdout.replace("\n", " ")
    assert {"results.json", "results.h5", "contacts.hdf"} <= {
        each.name for each in results.iterdir()
    }
    done = fretfe("run", case, "-o", results, "--set", "model.thickness=2.0")
    assert done.returncode == 2
    assert "model.thickness: expected 1 on a mesh of solids, found 2" in done.stderr


@pytest.mark.parametrize("name", ["dovetail", "firtree"])
def test_a_skewed_sector_has_straight_slots_and_sides_that_are_images(name: str) -> None:
    flanks = ["left", "right"] if name == "dovetail" else ["left_1", "right_1"]
    sides = {"boundary1": "disc_side_left", "boundary2": "disc_side_right"}
    centre = [0.0, -300.0, 0.0]
    sector = {"sectors": 36, "pitch_radius": 300.0, "disc_depth": 60.0}
    case = parse_case(
        {
            "geometry": {
                "template": name,
                "parameters": COARSE[name] | sector,
                "solid": {"length": 20.0, "skew": 10.0, "layers": 2},
            },
            "bodies": {body: {"young": 1.0, "poisson": 0.3} for body in ("blade", "disc")},
            "contacts": {
                each: {
                    "surface1": f"blade_flank_{each}",
                    "surface2": f"disc_flank_{each}",
                    "friction": 0.3,
                }
                for each in flanks
            },
            "symmetry": {"disc": {"type": "cyclic", **sides, "sectors": 36, "centre": centre}},
            "loads": {
                "p": {
                    "type": "traction",
                    "boundary": "blade_top",
                    "direction": "y",
                    "history": [{"ramp": 1.0, "until": 1.0, "steps": 1}],
                }
            },
        }
    )
    disc = load_mesh(case).bodies["disc"]
    assert determinants(disc, CUBIC_PLACES).min() > 0
    tie = tie_sides(case.symmetry["disc"], ("symmetry", "disc"), case.source, disc, 2)
    np.testing.assert_array_equal(tie.weights.data, 1.0)
    assert len(tie.weights.data) == len(tie.followers) > 50
    for each in flanks:
        points = disc.points[np.unique(disc.boundaries[f"disc_flank_{each}"])]
        straight = points[:, 0] - math.tan(math.radians(10.0)) * points[:, 2]
        first = points[points[:, 2] == 0]
        distance, _ = cKDTree(first[:, :2]).query(np.column_stack([straight, points[:, 1]]))
        assert distance.max() < 1e-12
