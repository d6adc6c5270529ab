# SPDX-License-Identifier: LGPL-3.0-or-later
"""The first mesh of CAD bodies that sweep a section, before anything is solved."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cases.swept_punch import ARC, Placed

from fretfe.analytic.profiles import FlatRounded
from fretfe.backends.passes import starting_mesh
from fretfe.case import changed
from fretfe.errors import MeshError
from fretfe.mesh.load import sweep_of


def test_sections_are_fine_at_the_edges_that_are_expected(tmp_path: Path) -> None:
    placed = Placed((1.0, 2.0, 3.0), 0.7, (13.0, -7.0, 101.0))
    case = placed.case(tmp_path)
    mesh, sweep = starting_mesh(case), sweep_of(case)
    assert sweep is not None
    # 1 on a top of 3 by 8, over the 8 of the contact
    punch = FlatRounded(flat_half_width=1.0, radius=1.0, e_star=210e3 / (2 * (1 - 0.3**2)))
    reach = float(punch.half_width(2 * (1 + ARC[0]))) - 1.0
    edges = sweep.in_plane(
        np.array([placed.of([side * (1 + reach), 0.0, 5.0]) for side in (-1, 1)])
    )
    for body, name in (("upper", "upper_contact"), ("lower", "lower_contact")):
        facets = mesh.bodies[body].boundaries[name][:, :3]
        corners = sweep.in_plane(mesh.bodies[body].points)[facets]
        across = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        middles = corners.mean(axis=1)
        away = np.linalg.norm(middles[:, None] - edges, axis=2).min(axis=1)
        # five elements over the rise, a third of the reach
        assert 0.02 * reach < across[away < 0.1 * reach].max() < 0.15 * reach
        # 16 on the flat, but for the fine ones
        assert across[away > 0.5].min() > 0.05


def test_a_mesh_larger_than_the_case_allows_is_not_made(tmp_path: Path) -> None:
    case = changed(Placed().case(tmp_path), {"edges.unknowns": 1000})
    with pytest.raises(MeshError, match=r"edges\.unknowns: mesh 1 would have \d+ unknowns"):
        starting_mesh(case)
