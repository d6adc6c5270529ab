# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts on the map of a contact area: where they are, and which station is marked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cases.solid_runs import RADIUS, solid_result, surface
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from fretfe.evaluate.space.evaluate import evaluate_fronts
from fretfe.evaluate.space.fronts import follow_fronts
from fretfe.report.pictures.surfaces import WORST, draw_surface
from fretfe.results.model import Result

STATE = 24


@pytest.fixture(scope="module")
def run() -> Result:
    """A circle with twelve stations, of which one is too near an end; |ΔK| is made up."""
    result = solid_result({"main": surface(bend=0.3)})
    (contact,) = result.solution.contacts
    (front,) = evaluate_fronts(
        result.solution, contact, follow_fronts(result.solution, contact, 12)
    )
    stations = tuple(
        replace(
            each,
            k_range=10.0 + each.number,
            k_range_spread=0.1,
            end=each.number == 11,
            to_end=0.0,
        )
        for each in front.stations
    )
    (area,) = result.contacts
    return replace(result, contacts=(replace(area, fronts=(replace(front, stations=stations),)),))


def lines_of(panel: Axes) -> list[Line2D]:
    """Lines at places of the surface, which ticks are not."""
    return [each for each in panel.lines if each.get_transform() == panel.transData]


def texts_of(panel: Axes) -> list[str]:
    """Texts beside places of the surface."""
    return [each.get_text() for each in panel.texts if isinstance(each, Annotation)]


def test_front_and_its_worst_station_on_the_map(run: Result) -> None:
    figure, caption = draw_surface(run, "main", [STATE])
    assert "station 10 of front 1 in stations.csv" in caption
    pressure, status = figure.axes[:2]
    for panel in (pressure, status):
        line, inner, end, worst = (np.array(each.get_data()).T for each in lines_of(panel))
        assert np.abs(np.linalg.norm(line, axis=1) / RADIUS - 1).max() < 0.01
        assert len(line) == 13 and len(inner) == 11 and len(end) == 1 and len(worst) == 1
        np.testing.assert_allclose(worst[0], line[10])
        assert lines_of(panel)[3].get_marker() == WORST["marker"]
        assert texts_of(panel) == ["10"]


def test_stations_that_are_not_known_are_gaps(run: Result) -> None:
    (area,) = run.contacts
    (front,) = area.fronts
    stations = list(front.stations)
    place = stations[10].position.copy()
    place[STATE] = np.nan
    stations[10] = replace(stations[10], position=place)
    fronts = (replace(front, stations=tuple(stations)),)
    moved = replace(run, contacts=(replace(area, fronts=fronts),))
    figure, _ = draw_surface(moved, "main", [STATE])
    line, *_ = (np.array(each.get_data()).T for each in lines_of(figure.axes[0]))
    assert np.isnan(line[10]).all() and np.isfinite(line[9]).all()
    assert not texts_of(figure.axes[0])
