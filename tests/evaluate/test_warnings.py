# SPDX-License-Identifier: LGPL-3.0-or-later
"""Warnings of plane contacts, on meshes of a few numbers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.evaluate.contacts import Station, unknown_station
from fretfe.evaluate.warnings import _beside_fine_mesh, _beside_plane_mesh
from fretfe.evaluate.withheld import TOLD
from fretfe.history.solution import ContactHistory, Solution


def graded(*places: float, finest: Array) -> Array:
    """Nodes from -2 to 2, of elements of a finest size at each place that grow by .3."""
    arc = [-2.0]
    while arc[-1] < 2:
        sizes = finest + 0.3 * np.abs(arc[-1] - np.array(places))
        arc.append(arc[-1] + float(sizes.min()))
    return np.array(arc)


@pytest.mark.parametrize(
    ("right", "found"), [(0.999, ""), (0.7, "further in"), (1.4, "further out")]
)
def test_a_mesh_that_is_finer_at_the_other_edge_is_none_that_ends_too_early(
    right: float, found: str
) -> None:
    """The edge at 1 has elements ten times as long as the one at -1, of its own or beside it."""
    arc = graded(-1.0, right, finest=np.array([0.002, 0.02]))
    traction = np.where(np.abs(arc) < 1, 1.0, 0.0)[None, :, None]
    history = SimpleNamespace(surface=SimpleNamespace(arc=arc), traction=traction)
    station = replace(unknown_station("right", 0, 1, TOLD), position=np.ones(1))
    solution = cast(Solution, SimpleNamespace(cycle=None))
    told = _beside_plane_mesh(solution, cast(ContactHistory, history), station)
    assert (told or "").count("further") == bool(found)
    assert found in (told or "")


def test_mirrored_edges_want_the_fine_mesh_to_reach_as_far() -> None:
    """Fine elements begin .03 inward of the edge, which moves inward by .04 in the cycle."""
    ends = np.concatenate([np.arange(-0.1, 0.03, 0.01), np.arange(0.03, 0.1, 0.002)])
    elements = np.column_stack([ends[:-1], ends[1:]])
    told = []
    for inward in (1, -1):
        place = inward * np.array([0.0, 0.02, 0.04])
        station = SimpleNamespace(position=place, decisive=0, inward=inward, size=0.01, last=2)
        solution = cast(Solution, SimpleNamespace(cycle=(0, 2)))
        lengths = np.ptp(elements, axis=1)
        told.append(_beside_fine_mesh(solution, cast(Station, station), elements, lengths))
    assert told[0] == told[1]
    assert told[0] is not None and "ends 0.038 too early" in told[0]
