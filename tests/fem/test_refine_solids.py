# SPDX-License-Identifier: LGPL-3.0-or-later
"""Meshes of solids that refine themselves: sizes of each mesh, the end at the limit, a sphere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cycled_sphere import FRICTION, PEAK, cycles, tables
from pad_cases import pad, press

from fretfe.backends import RunOptions
from fretfe.backends.meshes import FINER, finer_case, is_solid, starting_mesh
from fretfe.case import Case, parse_case
from fretfe.fem.backend import BACKEND
from fretfe.mesh.mesh import count_unknowns


def case(geometry: dict[str, Any], **edges: float) -> Case:
    edges = {"tolerance": 0.02, **edges}
    return parse_case(pad(geometry=geometry, loads={"press": press(steps=1)}, edges=edges))


def test_plane_templates_are_no_solids() -> None:
    plane = {"template": "cylinder"}
    assert not is_solid(case(plane))
    assert is_solid(case({"template": "sphere"}))
    assert is_solid(case(plane | {"solid": {"length": 4.0, "layers": 2}}))


def test_sizes_at_the_edge_shrink_together() -> None:
    given = {"template": "cylinder_finite", "parameters": {"size": 0.2}}
    finer = finer_case(case(given), 2.0)
    found = finer.geometry.parameters
    assert found == pytest.approx({"size": 0.1, "end_size": 0.125, "length_size": 0.75})
    assert finer.edges.tolerance is None


def test_layers_of_an_extruded_template_become_thinner() -> None:
    solid = {"length": 4.0, "layers": 5}
    geometry = {"template": "flat_rounded", "parameters": {"edge_size": 0.02}, "solid": solid}
    finer = finer_case(case(geometry), FINER).geometry
    assert finer.parameters == pytest.approx({"edge_size": 0.02 / FINER})
    assert finer.solid is not None and finer.solid.layers == 7


def test_first_mesh_is_that_of_the_case() -> None:
    geometry = {"template": "sphere", "parameters": {"size": 0.35, "growth": 0.5}}
    first = count_unknowns(starting_mesh(case(geometry)), 2)
    assert first == count_unknowns(starting_mesh(case(geometry, tolerance=0.1)), 2)
    assert first < 20_000


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_sphere_until_the_limit(capsys: pytest.CaptureFixture[str]) -> None:
    """Three meshes; the fourth one has too many unknowns."""
    data = tables(FRICTION, shear=cycles())
    data["geometry"]["parameters"] = {"size": 0.2, "growth": 0.6}
    data |= {"edges": {"tolerance": 1e-4, "unknowns": 60_000, "stations": 12}}
    data |= {"cycle": {"start": 4.0, "end": 6.0}}
    result = BACKEND.solve(parse_case(data), RunOptions())
    refinement = result.refinement
    assert refinement is not None and not refinement.converged
    assert "edges.unknowns: mesh 4 would have" in refinement.reason
    unknowns = [each.unknowns for each in refinement.passes]
    assert unknowns == sorted(unknowns) and unknowns[-1] <= 60_000
    # Too coarse for fronts at first: nothing to compare is no agreement.
    assert refinement.passes[0].change == np.inf
    (front,) = refinement.passes[-1].stations
    assert front.k_n == pytest.approx(PEAK * np.sqrt(2), rel=0.02)
