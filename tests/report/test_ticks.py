# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ticks of plots: the numbers of Matplotlib's own ones, and names of axes beyond them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from harness.plots import tick_numbers
from matplotlib.figure import Figure

from fretfe.report.theme import log_axis, plain_axis
from fretfe.report.ticks import draw_ticks


def plain(figure: Figure) -> None:
    axes = figure.subplots()
    axes.plot([-0.3, 0.4], [1e5, 7e5])
    plain_axis(axes, "y")


def logarithmic(figure: Figure) -> None:
    axes = figure.subplots()
    axes.plot([1e-4, 3.0], [3.0, 40.0])
    log_axis(axes, "x")
    log_axis(axes, "y")


def shared(figure: Figure) -> None:
    top, bottom = figure.subplots(2, 1, sharex=True)
    top.plot([0.0, 1.3], [-20.0, 30.0])
    bottom.tick_params(axis="x", labelrotation=30)


def own(figure: Figure) -> None:
    figure.subplots().set_yticks([0.2, 0.7], ["left edge", "right edge"])


DRAWN = (plain, logarithmic, shared, own)


def figure_of(draw: Callable[[Figure], None]) -> Figure:
    figure = Figure(figsize=(3.7, 3.0), layout="constrained")
    draw(figure)
    for axes in figure.axes:
        axes.set_xlabel("x")
        axes.set_ylabel("y")
    return figure


@pytest.mark.parametrize("draw", DRAWN)
def test_numbers_are_those_of_matplotlib_and_names_are_beyond_them(
    draw: Callable[[Figure], None],
) -> None:
    figure, same = figure_of(draw), figure_of(draw)
    same.draw_without_rendering()
    draw_ticks(figure)
    figure.draw_without_rendering()
    for axes, other in zip(figure.axes, same.axes, strict=True):
        for which in "xy":
            axis = getattr(other, f"{which}axis")
            low, high = sorted(axis.get_view_interval())
            expected = [
                tick.label1.get_text()
                for tick in axis.get_major_ticks()
                if low <= tick.get_loc() <= high and tick.label1.get_visible()
            ]
            assert tick_numbers(axes, which) == expected
        numbers = [each.get_window_extent() for each in axes.texts]
        for name in (axes.xaxis.label, axes.yaxis.label):
            assert not any(name.get_window_extent().overlaps(number) for number in numbers)


def test_names_of_panels_below_each_other_are_aligned() -> None:
    figure = figure_of(shared)
    draw_ticks(figure)
    figure.draw_without_rendering()
    places = [axes.yaxis.label.get_window_extent().x0 for axes in figure.axes]
    assert places[0] == pytest.approx(places[1])


def test_a_factor_that_all_numbers_share_stays() -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0.0, 1.0], [0.0, 3e-9])
    draw_ticks(figure)
    figure.draw_without_rendering()
    assert axes.yaxis.get_offset_text().get_text() == "1e\N{MINUS SIGN}9"
    assert len(axes.get_yticks()) > 2
    assert np.any([each.get_text() == "0.2" for each in axes.texts])
