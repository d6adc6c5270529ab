# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sides of a sector: the angle between them, facets that are missing, and curves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors

from fretfe.bodies.cyclic import Tie, tie_sides
from fretfe.case import Solid, Symmetry
from fretfe.errors import CaseError
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh

LINE: dict[str, Any] = {"centre": (0, 0, 0), "axis": (0, 0, 1)}


def tied(mesh: BodyMesh, count: int = 4, **keys: Any) -> Tie:
    table = {"boundary1": "ring_bottom", "boundary2": "ring_top", "centre": (0, 0), **keys}
    symmetry = Symmetry.model_validate({"type": "cyclic", "sectors": count, **table})
    return tie_sides(symmetry, ("symmetry", "sides"), Path("case.toml"), mesh, 2)


def solid(mesh: BodyMesh) -> BodyMesh:
    return extrude(Mesh({"ring": mesh}), Solid(length=0.4, layers=2)).bodies["ring"]


def ring(angle: float) -> BodyMesh:
    return sectors.ring(np.linspace(-angle / 2, angle / 2, 13), order=1)


@pytest.mark.parametrize(("count", "whole"), [(3, 240), (4, 270), (12, 330)])
def test_what_a_sector_leaves_of_a_turn_is_none(count: int, whole: float) -> None:
    """Its sides are images of one another too, by a turn through the gap."""
    tied(ring(360 / count), count)
    for swap in ({}, {"boundary1": "ring_top", "boundary2": "ring_bottom"}):
        with pytest.raises(CaseError, match=rf"expected a sector of 360°/{count} .* {whole}°, wh"):
            tied(ring(whole), count, **swap)


@pytest.mark.parametrize("axis", [1, -1])
def test_what_a_solid_sector_leaves_of_a_turn_is_none(axis: int) -> None:
    line = LINE | {"axis": (0, 0, axis)}
    tied(solid(ring(90)), **line)
    with pytest.raises(CaseError, match="found one of 270°, which overlaps its neighbours"):
        tied(solid(ring(270)), **line)


def test_a_half_is_its_own_complement() -> None:
    tied(ring(180), 2)


@pytest.mark.parametrize("space", [False, True], ids=["plane", "solid"])
@pytest.mark.parametrize("name", ["ring_bottom", "ring_top"])
def test_a_facet_missing_in_a_side_is_named(name: str, *, space: bool) -> None:
    """All nodes of the side are there, those of facets next to it."""
    mesh = solid(ring(90)) if space else ring(90)
    facets = mesh.boundaries[name]
    gone = mesh.points[facets[1]].mean(axis=0)
    mesh = replace(mesh, boundaries={**mesh.boundaries, name: np.delete(facets, 1, axis=0)})
    with pytest.raises(CaseError, match=f"and that '{name}' is whole there") as caught:
        tied(mesh, **(LINE if space else {}))
    # what has no counterpart is the middle of that facet, on the other side
    turn = np.array([[0, 1.0], [-1, 0]]) * (1 if name == "ring_top" else -1)
    x, y = turn @ gone[:2]
    assert f"at ({x:.6g}, {y:.6g}" in str(caught.value)


def curved(order: int, shift: float) -> BodyMesh:
    """Sides that bulge by 6 degrees, with nodes of one of them moved along the curve."""

    def mapping(points: np.ndarray) -> np.ndarray:
        radius, angle = points.T
        way = (radius - sectors.BORE) / (sectors.OUTSIDE - sectors.BORE)
        way = way + shift * (angle + 45) / 90 * np.sin(np.pi * way)
        radius = sectors.BORE + way * (sectors.OUTSIDE - sectors.BORE)
        return sectors.polar(np.column_stack([radius, angle + 6 * np.sin(np.pi * way)]))

    radii = np.linspace(sectors.BORE, sectors.OUTSIDE, 9)
    return blocks.block("ring", radii, np.linspace(-45, 45, 13), order=order, mapping=mapping)


@pytest.mark.parametrize(
    ("order", "wrong"),
    # Facets of h = 0.05 turn by up to h 0.1 (pi/0.4)^2 = 0.31 and from one to the next by up to
    # 0.12: h 0.31/8 = 1.9e-3 of chords, h 0.12/125 = 5e-5 of parabolas, of one side or both.
    [(1, 4e-3), (2, 1e-4)],
)
def test_curved_sides_may_have_other_nodes(order: int, wrong: float) -> None:
    """A turn about the axis is one of both sides, but for the chords of the curve."""
    sides = tied(curved(order, 0.05))
    assert sides.weights.nnz > 2 * len(sides.followers)
    np.testing.assert_allclose(sides.weights.sum(axis=1), 1.0, atol=1e-12)
    quarter = np.array([[0, -1.0], [1, 0]])
    image = sides.image(sides.leaders @ quarter.T)
    np.testing.assert_allclose(image, sides.followers @ quarter.T, atol=wrong)


def test_curved_solid_sides_may_have_other_nodes() -> None:
    sides = tied(solid(curved(1, 0.05)), **LINE)
    np.testing.assert_allclose(sides.weights.sum(axis=1), 1.0, atol=1e-12)


def test_sides_that_are_curved_otherwise_are_refused() -> None:
    """By a quarter of a facet, at a node."""
    mesh = curved(1, 0.0)
    top = mesh.boundaries["ring_top"]
    moved = mesh.points.copy()
    moved[top[3, 0]] += [0.01, -0.01]
    with pytest.raises(CaseError, match="images of one another"):
        tied(replace(mesh, points=moved))
