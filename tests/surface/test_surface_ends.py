# SPDX-License-Identifier: LGPL-3.0-or-later
"""Borders of contact surfaces between solids: where a body ends, and where its surface goes on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases import blocks
from cases.solid_runs import solid_result, surface

from fretfe._typing import Array, Bools
from fretfe.case import Solid
from fretfe.evaluate.evaluate import evaluate
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.reason import Kind
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import build_surface, rim_edges, rim_nodes

LENGTH = 0.7


def rounded(points: Array) -> Array:
    """The bottom of a pad, and its sides, along two arcs."""
    x, y = points.T
    return np.column_stack([x, y + 0.3 * (1 - y) * x**2])


def bodies(
    cell: str = "quadrilateral", order: int = 1, skew: float = 0.0, longer: float = 0.0
) -> dict[str, BodyMesh]:
    """A pad on a block, which is wider and longer at the far end by `longer`."""
    x, wide = np.linspace(-0.6, 0.6, 9), np.linspace(-1.0, 1.0, 10)
    pad = blocks.block("pad", x, [0.0, 0.5, 1.0], cell=cell, order=order, mapping=rounded)
    base = blocks.block("block", wide, [-1.0, -0.5, 0.0], cell=cell, order=order)
    solids = (
        Solid(length=LENGTH, layers=3, skew=skew),
        Solid(length=LENGTH + longer, layers=4, skew=skew),
    )
    return {
        each.name: extrude(Mesh({each.name: each}), solid).bodies[each.name]
        for each, solid in zip((pad, base), solids, strict=True)
    }


def coupled(solids: dict[str, BodyMesh], side: str = "surface1") -> Coupling:
    upper = build_surface(solids["pad"], "pad_bottom")
    return couple("main", upper, build_surface(solids["block"], "block_top"), side, 2)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_a_body_ends_at_its_edges_and_not_where_its_group_does(cell: str, order: int) -> None:
    pad = bodies(cell, order)["pad"]
    whole = build_surface(pad, "pad_bottom")
    ends = np.unique(np.sort(whole.ends, axis=1), axis=0)
    np.testing.assert_array_equal(ends, rim_edges(whole.corners))
    facets = pad.boundaries["pad_bottom"]
    some = facets[pad.points[facets].mean(axis=1)[:, 0] < 0.3]
    part = build_surface(replace(pad, boundaries={"part": some}), "part")
    middles = part.vertices[part.ends].mean(axis=1)
    cut = part.vertices[rim_edges(part.corners)].mean(axis=1)[:, 0] > 0.25
    assert cut.sum() == 3 and len(middles) == len(cut) - 3
    assert middles[:, 0].max() < 0.25


def at_ends(coupling: Coupling, skew: float = 0.0) -> Bools:
    """Nodes in the planes where both bodies end, those on their edges left out."""
    z, x = coupling.surface.points[:, 2], coupling.surface.points[:, 0]
    middle = x + np.tan(np.radians(skew)) * z
    return (np.abs(z * (LENGTH - z)) < 1e-9) & (np.abs(middle) < 0.55)


def free_nodes(coupling: Coupling) -> Bools:
    free = coupling.surface.free
    assert free is not None
    return free


@pytest.mark.parametrize("side", ["surface1", "surface2"])
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_both_bodies_end_at_the_planes_they_share(cell: str, side: str) -> None:
    coupling = coupled(bodies(cell), side)
    shared, free = at_ends(coupling), free_nodes(coupling)
    assert shared.sum() >= 8 and free[shared].all()
    assert coupling.surface.facets is not None
    rim = rim_nodes(coupling.surface.facets, len(coupling.surface.points))
    inside = np.abs(coupling.surface.points[:, 2] - LENGTH / 2) < 0.49 * LENGTH
    assert rim[inside].any() and not free[inside].any()


def test_both_bodies_end_where_they_are_skewed() -> None:
    for skew in (10.0, -10.0):
        coupling = coupled(bodies(skew=skew))
        ends = (
            np.abs(coupling.surface.points[:, 2] * (LENGTH - coupling.surface.points[:, 2])) < 1e-9
        )
        assert np.count_nonzero(ends & free_nodes(coupling)) >= np.count_nonzero(ends) - 4


def test_a_body_that_goes_on_is_no_common_end() -> None:
    coupling = coupled(bodies(longer=0.2))
    near, far = (np.abs(coupling.surface.points[:, 2] - z) < 1e-9 for z in (0.0, LENGTH))
    assert free_nodes(coupling)[near].any() and not free_nodes(coupling)[far].any()


def test_a_group_that_is_too_small_is_no_end() -> None:
    solids = bodies()
    facets = solids["pad"].boundaries["pad_bottom"]
    z = solids["pad"].points[facets].mean(axis=1)[:, 2]
    solids["pad"] = replace(solids["pad"], boundaries={"pad_bottom": facets[z < 0.6 * LENGTH]})
    coupling = coupled(solids)
    assert free_nodes(coupling)[np.abs(coupling.surface.points[:, 2]) < 1e-9].any()
    assert not free_nodes(coupling)[coupling.surface.points[:, 2] > 0.1].any()


def test_warning_where_not_both_bodies_end() -> None:
    result = solid_result({"main": surface(half=0.9)})
    (contact,) = result.solution.contacts
    (told,) = (each for each in result.warnings if each.kind is Kind.SURFACE_BORDER)
    assert told.text.startswith("the contact reaches the border of its surface, first at (")
    assert contact.surface.facets is not None
    rim = rim_nodes(contact.surface.facets, len(contact.surface.points))
    ended = replace(contact, surface=replace(contact.surface, free=rim))
    (found,) = evaluate(replace(result.solution, contacts=(ended,)))
    assert Kind.SURFACE_BORDER not in {each.kind for each in found.warnings}
