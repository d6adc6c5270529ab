# SPDX-License-Identifier: LGPL-3.0-or-later
"""CAD files of solid bodies: volumes and faces chosen by point and label, sizes, mistakes."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import gmsh
import numpy as np
import pytest
from cases.pad_cases import pad, press

from fretfe.case import parse_case
from fretfe.errors import CaseError, FretfeError, MeshError
from fretfe.mesh.elements import facet_measures
from fretfe.mesh.gmsh import gmsh_model
from fretfe.mesh.load import grouped_mesh
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.unnamed import unnamed_contacts

BODIES: dict[str, Any] = {"upper": {"point": [0, 0, 1]}, "lower": {"point": [1.5, 0, -1]}}
BOUNDARIES: dict[str, Any] = {
    "upper_contact": {"point": [0.3, 0.2, 0], "body": "upper"},
    "upper_top": {"point": [0, 0, 2]},
    "upper_side": {"point": [0, 1, 1.5]},
    "lower_contact": {"point": [0.3, 0.2, 0], "body": "lower"},
    "lower_sides": {"points": [[-2, 0, -1], [2, 0, -1]]},
    "lower_bottom": {"point": [0, 0, -2]},
}
CAD: dict[str, Any] = {"size": 0.4, "order": 2, "bodies": BODIES, "boundaries": BOUNDARIES}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cylinder of radius 1 and height 2 on a block of 4 by 4 by 2; and the two in one piece."""
    path = tmp_path_factory.mktemp("cad")
    for name, joined in (("apart", False), ("joined", True)):
        with gmsh_model(path):
            occ = gmsh.model.occ
            cylinder, block = occ.addCylinder(0, 0, 0, 0, 0, 2, 1), occ.addBox(-2, -2, -2, 4, 4, 2)
            if joined:
                occ.fragment([(3, cylinder)], [(3, block)])
            occ.synchronize()
            for suffix in (".step", ".brep"):
                gmsh.write(str(path / f"{name}{suffix}"))
    return path


def mesh_of(file: Path, units: str = "mm", **changes: Any) -> Mesh:
    tables = pad(
        geometry={"file": str(file), **CAD, **changes},
        units={"length": units},
        supports={"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        loads={"press": press(steps=1)},
    )
    return grouped_mesh(parse_case(tables))


def area(body: BodyMesh, name: str) -> float:
    return float(facet_measures(body.points, body.boundaries[name]).sum())


@pytest.mark.parametrize("suffix", [".step", ".brep"])
def test_bodies_and_faces_are_those_chosen(folder: Path, suffix: str) -> None:
    mesh = mesh_of(folder / f"apart{suffix}")
    upper, lower = mesh.bodies["upper"], mesh.bodies["lower"]
    assert (upper.cell, upper.order, mesh.dimension) == ("tetrahedron", 2, 3)
    assert area(upper, "upper_contact") == pytest.approx(math.pi, rel=1e-3)
    assert area(upper, "upper_side") == pytest.approx(4 * math.pi, rel=1e-3)
    assert area(lower, "lower_contact") == pytest.approx(16)
    assert area(lower, "lower_sides") == pytest.approx(2 * 8)
    assert upper.points[np.unique(upper.boundaries["upper_top"]), 2] == pytest.approx(2)


def test_elements_have_the_size_asked_for_on_the_contact(folder: Path) -> None:
    lower = mesh_of(folder / "apart.step", size=0.25).bodies["lower"]
    facets = lower.boundaries["lower_contact"]
    edges = np.sqrt(facet_measures(lower.points, facets) * 4 / math.sqrt(3))
    assert np.median(edges) == pytest.approx(0.25, rel=0.15)
    assert len(lower.boundaries["lower_bottom"]) < len(facets) / 4


def test_bodies_that_touch_without_a_contact_are_listed(folder: Path) -> None:
    tables = pad(
        geometry={"file": str(folder / "apart.step"), **CAD},
        supports={"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}},
        loads={"press": press(steps=1)},
    )
    case = parse_case(tables)
    mesh = grouped_mesh(case)
    main = case.contacts["main"]
    assert list(unnamed_contacts(mesh, {main.surface1, main.surface2})) == []
    (found,) = unnamed_contacts(mesh, set())
    assert found.startswith("bodies 'upper' and 'lower' touch around (")


def test_a_revolved_nose_meshes_to_its_pole(tmp_path: Path) -> None:
    """The spherical tip has an edge of no length at its pole, where a stranger points at it."""
    radius, wide, high = 10.0, 1.6, 4.0
    with gmsh_model(tmp_path):
        occ = gmsh.model.occ
        rim = radius - math.sqrt(radius**2 - wide**2)
        places = [(0, 0), (wide, rim), (wide, high), (0, high)]
        first, *others = (occ.addPoint(x, 0, z) for x, z in places)
        arc = occ.addCircleArc(first, occ.addPoint(0, 0, radius), others[0])
        lines = [occ.addLine(*ends) for ends in pairwise([*others, first])]
        section = occ.addPlaneSurface([occ.addCurveLoop([arc, *lines])])
        occ.revolve([(2, section)], 0, 0, 0, 0, 0, 1, 2 * math.pi)
        occ.remove([(2, section)], recursive=True)
        occ.addBox(-2, -2, -2, 4, 4, 2)
        occ.synchronize()
        gmsh.write(str(tmp_path / "nose.step"))
    boundaries = BOUNDARIES | {
        "upper_contact": {"point": [0, 0, 0], "body": "upper"},
        "upper_top": {"point": [0.2, 0.1, high]},
        "upper_side": {"point": [0, wide, 2]},
    }
    mesh = mesh_of(tmp_path / "nose.step", size=0.3, boundaries=boundaries)
    upper = mesh.bodies["upper"]
    assert area(upper, "upper_contact") == pytest.approx(2 * math.pi * radius * rim, rel=1e-3)
    facets = upper.points[upper.boundaries["upper_contact"][:, :3]]
    sides = np.linalg.norm(facets - np.roll(facets, 1, axis=1), axis=2)
    assert np.median(sides) == pytest.approx(0.3, rel=0.1)
    assert np.percentile(sides, [5, 95]) == pytest.approx(0.3, rel=0.35)


def test_lengths_are_converted(folder: Path) -> None:
    changes = {
        "size": 0.04,
        "bodies": {"upper": {"point": [0, 0, 0.1]}, "lower": {"point": [0.15, 0, -0.1]}},
        "boundaries": {
            name: {
                key: (np.array(value) / 10).tolist() if key.startswith("point") else value
                for key, value in selector.items()
            }
            for name, selector in BOUNDARIES.items()
        },
    }
    lower = mesh_of(folder / "apart.step", "cm", **changes).bodies["lower"]
    assert area(lower, "lower_contact") == pytest.approx(0.16)


def changed(name: str, **selector: Any) -> dict[str, Any]:
    return {"boundaries": BOUNDARIES | {name: selector}}


PLANE_POINTS = {"bodies": BODIES | {"upper": {"point": [0, 1]}}}
ALL = {"points": [[0, 0, 1], [1.5, 0, -1]]}
TWICE = {"bodies": {"upper": ALL, "lower": {"point": [0, 0, 1]}}}
MISTAKES: dict[str, tuple[str, dict[str, Any], type[FretfeError], str]] = {
    "joined": ("joined.brep", {}, MeshError, "'upper' and 'lower' have a face in common"),
    "plane point": ("apart.step", PLANE_POINTS, MeshError, "expected 3 coordinates, as the bodies"),
    "body twice": ("apart.step", TWICE, MeshError, "bodies.lower and .* are both volume"),
    "far point": (
        "apart.step",
        changed("upper_top", point=[0, 0, 3]),
        MeshError,
        "upper_top: the point .0, 0, 3. is 1 away from the nearest face",
    ),
    "two faces": (
        "apart.step",
        changed("lower_contact", point=[0.3, 0.2, 0]),
        MeshError,
        "does not tell between face .* say which with body = NAME",
    ),
    "no size": (
        "apart.step",
        {"size": None},
        CaseError,
        "the contact faces are parallel to each other",
    ),
}


@pytest.mark.parametrize(("name", "changes", "error", "message"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes_are_named(
    folder: Path, name: str, changes: dict[str, Any], error: type[FretfeError], message: str
) -> None:
    with pytest.raises(error, match=message):
        mesh_of(folder / name, **changes)
