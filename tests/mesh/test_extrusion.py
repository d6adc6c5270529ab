# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane meshes swept to solid ones."""

from __future__ import annotations

import numpy as np
import pytest
from cases import blocks

from fretfe.case import Solid
from fretfe.mesh.extrusion import Ends, extrude, layer_faces
from fretfe.mesh.mesh import Mesh

LENGTH, LAYERS, END = 12.0, 8, 0.1


@pytest.mark.parametrize("free", [(True, True), (True, False), (False, True)])
@pytest.mark.parametrize(("end", "length"), [(END, LENGTH), (0.013, LENGTH), (END, 0.25)])
def test_layers_are_thin_at_free_ends_and_grow_to_the_equal_thickness(
    free: Ends, end: float, length: float
) -> None:
    layers = LAYERS if length == LENGTH else 2
    faces = layer_faces(Solid(length=length, layers=layers, end_size=end), free)
    thick = np.diff(faces)
    assert faces[0] == 0.0
    assert faces[-1] == pytest.approx(length, rel=1e-14)
    assert thick.max() <= length / layers * (1 + 1e-12)
    growth = thick[1:] / thick[:-1]
    assert np.all(growth <= 1.4 + 1e-9)
    assert np.all(growth >= 1 / 1.4 - 1e-9)
    for number, is_free in zip((0, -1), free, strict=True):
        if is_free:
            assert 0.6 * end < thick[number] <= end * (1 + 1e-12)
    if free == (True, True):
        assert np.allclose(thick, thick[::-1], rtol=1e-12)
    elif length == LENGTH:
        assert np.argmin(thick) == (0 if free[0] else len(thick) - 1)


def test_layers_are_equal_without_a_thickness_of_those_at_ends_or_without_free_ends() -> None:
    equal = np.linspace(0.0, LENGTH, LAYERS + 1)
    solid = Solid(length=LENGTH, layers=LAYERS)
    assert np.array_equal(layer_faces(solid, (True, True)), equal)
    thin = Solid(length=LENGTH, layers=LAYERS, end_size=END)
    assert np.array_equal(layer_faces(thin, (False, False)), equal)


@pytest.mark.parametrize("end", [END, None])
def test_layers_have_faces_where_a_shorter_body_ends_and_are_thin_on_both_sides(
    end: float | None,
) -> None:
    solid = Solid(length=LENGTH, layers=LAYERS, end_size=end, spans={"a": (1.3, 11.0)})
    faces = layer_faces(solid, (True, True), ("a", "b"))
    thick = np.diff(faces)
    assert faces[0] == 0.0 and faces[-1] == LENGTH and thick.max() <= LENGTH / LAYERS + 1e-12
    for cut in (1.3, 11.0):
        place = int(np.flatnonzero(faces == cut)[0])
        if end is not None:
            beside = thick[place - 1 : place + 1]
            assert np.all((beside > 0.6 * end) & (beside <= end * (1 + 1e-12)))
    if end is not None:
        # Nothing ends at the ends of one body alone.
        assert thick[0] > 2 * end and thick[-1] > 2 * end
    # A third body ends there, too.
    three = np.diff(layer_faces(solid, (True, False), ("a", "b", "c")))
    assert end is None or (three[0] <= end * (1 + 1e-12) and three[-1] > 2 * end)


def test_a_shorter_body_begins_and_ends_within_the_length_of_the_other_one() -> None:
    lines = np.linspace(-1.0, 1.0, 3)
    flat = {name: blocks.block(name, lines, lines, cell="triangle") for name in ("a", "b")}
    solid = Solid(length=3.0, layers=3, skew=20.0, end_size=0.2, spans={"a": (0.5, 3.0)})
    found = extrude(Mesh(flat), solid).bodies
    for name, (start, end) in (("a", (0.5, 3.0)), ("b", (0.0, 3.0))):
        body = found[name]
        corners = body.points[body.cells[:, :4]]
        volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6
        assert volume == pytest.approx(4.0 * (end - start), rel=1e-12)
        back, front = (body.points[body.boundaries[f"{name}_{x}"]] for x in ("back", "front"))
        assert np.all(back[..., 2] == start) and np.all(front[..., 2] == end)
        middle = back[..., 0].min() / 2 + back[..., 0].max() / 2
        assert middle == pytest.approx(np.tan(np.radians(20.0)) * start, abs=1e-12)
    assert solid.shared("a", "b") == 2.5


@pytest.mark.parametrize("order", [1, 2])
def test_bodies_keep_their_volume_and_have_their_nodes_in_the_middle_of_layers(order: int) -> None:
    lines = np.linspace(-1.0, 1.0, 3)
    flat = Mesh({"b": blocks.block("b", lines, lines, cell="triangle", order=order)})
    solid = Solid(length=2.0, layers=2, end_size=0.1)
    body = extrude(flat, solid, free=(False, True)).bodies["b"]
    faces = layer_faces(solid, (False, True))
    expected = np.union1d(faces, (faces[1:] + faces[:-1]) / 2) if order == 2 else faces
    assert np.allclose(np.unique(body.points[:, 2]), expected, rtol=0, atol=1e-12)
    corners = body.points[body.cells[:, :4]]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6
    assert volume == pytest.approx(8.0, rel=1e-12)
