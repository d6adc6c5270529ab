# SPDX-License-Identifier: LGPL-3.0-or-later
"""Warnings of plane contacts, on meshes of a few numbers."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.evaluate.contacts import Station, fronts_of, unknown_station
from fretfe.evaluate.evaluate import _sliding
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.evaluate.warnings import _beside_fine_mesh, _beside_plane_mesh, _uncertain
from fretfe.history.solution import ContactHistory, Solution
from fretfe.reason import TOLD, Kind, Reason
from fretfe.verdict import Verdict


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


def test_an_edge_without_factors_slips_as_a_whole_where_its_contact_slides() -> None:
    """Bodies part in each cycle, so that K_T is unknown: that was told as no slip zone."""
    solution = cast(Solution, SimpleNamespace(cycle=(1, 3)))
    station = unknown_station("left", 0, 4, Reason(Kind.NO_CONTACT, 1, 3))
    station = replace(station, k_n=np.full(4, 10.0), k_n_spread=np.full(4, 6.0))
    found = {"fronts": fronts_of([station])}
    assert _sliding(solution, found, 0.0) is found
    ((slides,),) = (front.stations for front in _sliding(solution, found, 0.5)["fronts"])
    assert longest_verdict(slides).verdict is Verdict.GROSS
    (told,) = _uncertain(slides, Kind.K_N_UNCERTAIN)
    assert told[0] is Kind.FACTORS_UNKNOWN
    ((kind, text),) = _uncertain(replace(station, size=0.2), Kind.K_N_UNCERTAIN)
    assert kind is Kind.K_N_UNCERTAIN
    assert text.endswith("half of it, with elements of 0.2 (0.05 or less are wanted)")
