# SPDX-License-Identifier: LGPL-3.0-or-later
"""The first mesh of CAD bodies that sweep a section: fine at its edges, expected or solved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cases.swept_punch import ARC, Placed
from harness.told import Told

from fretfe.analytic.profiles import FlatRounded
from fretfe.backends import RunOptions
from fretfe.backends.meshes import PlanePasses
from fretfe.backends.passes import SweptPasses, passes_of, starting_mesh
from fretfe.case import Case, changed
from fretfe.errors import MeshError
from fretfe.fem._compat import MPI
from fretfe.fem.refine import solve_section
from fretfe.mesh.load import sweep_of
from fretfe.mesh.mesh import Mesh

PLACED = Placed((1.0, 2.0, 3.0), 0.7, (13.0, -7.0, 101.0))
PUNCH = FlatRounded(flat_half_width=1.0, radius=1.0, e_star=210e3 / (2 * (1 - 0.3**2)))


def reach(pressure: float) -> float:
    """Distance of the edges from the flat, for a pressure on a top of 3 by 8 over the 8 of it."""
    return float(PUNCH.half_width(pressure * 2 * (1 + ARC[0]))) - 1.0


def across(case: Case, mesh: Mesh, from_flat: float) -> tuple[np.ndarray, np.ndarray]:
    """Sizes of facets across the edges in the section, and how far away they are."""
    sweep = sweep_of(case)
    assert sweep is not None
    ends = [PLACED.of([side * (1 + from_flat), 0.0, 5.0]) for side in (-1, 1)]
    edges, sizes, away = sweep.in_plane(np.array(ends)), [], []
    for body, name in (("upper", "upper_contact"), ("lower", "lower_contact")):
        facets = mesh.bodies[body].boundaries[name][:, :3]
        corners = sweep.in_plane(mesh.bodies[body].points)[facets]
        sides = corners - np.roll(corners, 1, axis=1)
        sizes.append(np.linalg.norm(sides, axis=2).max(axis=1))
        middles = corners.mean(axis=1)[:, None]
        away.append(np.linalg.norm(middles - edges, axis=2).min(axis=1))
    return np.concatenate(sizes), np.concatenate(away)


def swept(case: Case) -> SweptPasses:
    passes = passes_of(case, RunOptions())
    assert isinstance(passes, SweptPasses)
    return passes


def test_sections_are_fine_at_the_edges_that_are_expected(tmp_path: Path) -> None:
    case = PLACED.case(tmp_path)
    sizes, away = across(case, starting_mesh(case), reach(1.0))
    # five elements over the rise, a third of the reach
    assert 0.02 * reach(1.0) < sizes[away < 0.1 * reach(1.0)].max() < 0.15 * reach(1.0)
    # 16 on the flat, but for the fine ones
    assert sizes[away > 0.5].min() > 0.05


def test_sections_are_fine_where_they_were_solved_to_have_edges(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = changed(PLACED.case(tmp_path), {"loads.press.ramp": -100.0})
    # The fifth is the first one with elements that tell K_N.
    monkeypatch.setattr(PlanePasses, "most", 5)
    passes, told = swept(case), Told()
    solve_section(MPI.COMM_SELF, passes, RunOptions(observer=told))
    assert not any("was not solved" in text for text in told.announced)
    sizes, away = across(case, passes.load(), reach(100.0))
    assert sizes[away < 0.1 * reach(100.0)].max() < 0.15 * reach(100.0)
    assert sizes[away > 0.5].min() > 0.05


def test_what_is_no_plane_case_is_meshed_without_a_solved_section(tmp_path: Path) -> None:
    case = changed(PLACED.case(tmp_path), {"supports.base.fix": ["x", "y"]})
    passes, told = swept(case), Told()
    solve_section(MPI.COMM_SELF, passes, RunOptions(observer=told))
    assert any("the section was not solved" in text for text in told.announced)
    assert passes.load().dimension == 3


def test_a_mesh_larger_than_the_case_allows_is_not_made(tmp_path: Path) -> None:
    case = changed(Placed().case(tmp_path), {"edges.unknowns": 1000})
    with pytest.raises(MeshError, match=r"edges\.unknowns: mesh 1 would have \d+ unknowns"):
        starting_mesh(case)
