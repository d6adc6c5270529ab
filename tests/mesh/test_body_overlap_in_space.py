# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids in the same place are found anywhere, and those that touch are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import blocks
from scipy.spatial.transform import Rotation

from fretfe._typing import Array, Bools
from fretfe.case import Case, Solid, parse_case
from fretfe.errors import MeshError
from fretfe.mesh.body_overlap import ClosedSurface, body_overlaps
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.checks import check_contacts

UNITS = np.eye(3)
# Its first axis is the diagonal of a cube: the corner at the origin points down.
ON_CORNER = Rotation.align_vectors([[0, 1, 0]], [[1, 1, 1]])[0].as_matrix()


def cube(
    name: str,
    place: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    size: float = 1.0,
    turn: Array = UNITS,
    cell: str = "triangle",
    order: int = 1,
) -> BodyMesh:
    """A cube from the origin on, turned, then moved."""
    lines = [np.linspace(0, 1, 5)] * 2
    plane = Mesh({name: blocks.block(name, *lines, cell=cell, order=order)})
    body = extrude(plane, Solid(length=1.0, layers=3)).bodies[name]
    return replace(body, points=size * body.points @ turn.T + place)


def bump(name: str, sign: float, order: int) -> BodyMesh:
    """The half of a cube above (or below) a wave; the mesh of the other half does not match."""
    count = 9 if sign > 0 else 7

    def bent(points: Array) -> Array:
        x, y = points.T
        return np.stack([x, 0.2 * np.cos(3 * x) * (1 - np.abs(y)) + y], axis=1)

    y = np.linspace(0, 1, 5) if sign > 0 else np.linspace(-1, 0, 4)
    body = blocks.block(name, np.linspace(0, 1, count), y, order=order, mapping=bent)
    return extrude(Mesh({name: body}), Solid(length=1.0, layers=3)).bodies[name]


def mesh(*bodies: BodyMesh) -> Mesh:
    return Mesh({body.name: body for body in bodies})


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
@pytest.mark.parametrize("order", [1, 2])
def test_depth_and_place(cell: str, order: int) -> None:
    """A cube that stands with a corner .3 deep in another one."""
    corner = cube("upper", (0.5, -0.3, 0.5), turn=ON_CORNER, cell=cell, order=order)
    block = cube("lower", (0.0, -1.0, 0.0), cell=cell, order=order)
    (overlap,) = body_overlaps(mesh(corner, block))
    assert overlap.body1 == "upper"
    assert overlap.depth == pytest.approx(0.3, abs=1e-12)
    np.testing.assert_allclose(overlap.point, [0.5, -0.3, 0.5], atol=1e-12)


@pytest.mark.parametrize(
    "second",
    [
        pytest.param(cube("b", (0.4, 0.3, 0.35), size=0.2), id="inside"),
        pytest.param(cube("b"), id="same place"),
        pytest.param(cube("b", cell="quadrilateral"), id="same place, other mesh"),
        pytest.param(cube("b", (0.93, 0.0, 0.0)), id="side by side"),
        pytest.param(cube("b", (0.5, 0.5, 0.9), turn=ON_CORNER), id="edges cross"),
    ],
)
def test_overlaps_are_found(second: BodyMesh) -> None:
    assert len(body_overlaps(mesh(cube("a"), second))) == 1
    assert len(body_overlaps(mesh(second, cube("a")))) == 1


@pytest.mark.parametrize(
    "bodies",
    [
        pytest.param(mesh(cube("a"), cube("b", (0.0, 1.0, 0.0))), id="touch"),
        pytest.param(mesh(cube("a"), cube("b", (0.3, 0.98, 0.4))), id="less than a tenth"),
        pytest.param(mesh(cube("a"), cube("b", (1.5, 1.0, 1.5), turn=ON_CORNER)), id="beside"),
        pytest.param(mesh(bump("a", 1.0, 1), bump("b", -1.0, 1)), id="straight on curved"),
        pytest.param(mesh(bump("a", 1.0, 2), bump("b", -1.0, 2)), id="curved on curved"),
    ],
)
def test_bodies_that_touch_do_not_overlap(bodies: Mesh) -> None:
    assert not body_overlaps(bodies)


def wound(points: Array, walls: Array) -> Bools:
    """Points inside by the solid angles under which they see the triangles."""
    a, b, c = np.moveaxis(walls[None] - points[:, None, None], 2, 0)
    norms = [np.linalg.norm(each, axis=2) for each in (a, b, c)]
    pairs = ((a, b, norms[2]), (b, c, norms[0]), (c, a, norms[1]))
    below = np.prod(norms, axis=0) + sum(np.sum(u * v, axis=2) * w for u, v, w in pairs)
    volume = np.sum(a * np.cross(b, c), axis=2)
    angles = 2 * np.arctan2(volume, below)
    return np.asarray(np.abs(angles.sum(axis=1)) > 2 * np.pi)


@pytest.mark.parametrize("order", [1, 2])
def test_inside_is_where_the_surface_winds_around(order: int) -> None:
    surface = ClosedSurface(bump("a", 1.0, order))
    points = np.random.default_rng(3).uniform(-0.2, 1.3, (600, 3))
    inside = surface.inside(points)
    assert 80 < inside.sum() < 220
    np.testing.assert_array_equal(inside, wound(points, surface.walls))


def test_distances_are_the_smallest_ones() -> None:
    surface = ClosedSurface(bump("a", 1.0, 1))
    points = np.random.default_rng(4).uniform(-0.2, 1.3, (30, 3))
    found, nearest = surface.distances(points)
    s = np.linspace(0, 1, 21)
    u, v = (each[np.add.outer(s, s) <= 1 + 1e-9] for each in np.meshgrid(s, s))
    places = np.stack([1 - u - v, u, v], axis=1) @ surface.walls
    sampled = np.array([np.linalg.norm(places - p, axis=2).min(axis=1) for p in points])
    # Sampled distances are too large, by what half of a twentieth of a triangle makes of them.
    assert (found <= sampled.min(axis=1) + 1e-12).all()
    np.testing.assert_allclose(found, sampled[np.arange(len(points)), nearest], atol=0.01)
    assert (surface.estimate(points) >= found - 1e-12).all()


def contacts(first: str = "upper_bottom", second: str = "lower_top") -> Case:
    steel = {"young": 2e5, "poisson": 0.3}
    contact = {"surface1": first, "surface2": second, "friction": 0.3}
    bodies = {"upper": steel, "lower": steel}
    return parse_case(
        {"geometry": {"file": "m.msh"}, "bodies": bodies, "contacts": {"main": contact}}
    )


def test_overlap_away_from_the_contact_is_told() -> None:
    """A third body inside the lower one, of which no contact surface is near."""
    bodies = mesh(
        cube("upper"), cube("lower", (0, -1, 0)), cube("third", (0.4, -0.6, 0.4), size=0.2)
    )
    message = (
        r"bodies 'third' and 'lower' overlap: a point of 'third' at \(.*\) is 0\.4875 mm inside"
    )
    with pytest.raises(MeshError, match=message) as caught:
        check_contacts(bodies, contacts())
    assert "contacts.main" not in str(caught.value)


def test_surfaces_deep_inside_the_other_body_are_told_once() -> None:
    """They never face each other; that the bodies overlap is what is wrong."""
    with pytest.raises(MeshError, match=r"bodies '\w+' and '\w+' overlap") as caught:
        check_contacts(mesh(cube("upper", (0, -0.7, 0)), cube("lower", (0, -1, 0))), contacts())
    assert "face" not in str(caught.value)
