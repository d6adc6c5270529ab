# SPDX-License-Identifier: LGPL-3.0-or-later
"""The plots of reports: made into SVG for the tests that look at it alone.

To lay out and write a plot takes three quarters of the time of a page. The tests draw every plot,
but what they get of it is an empty element, except inside of `whole_plots`. Processes that tests
start make whole ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.report import theme

WHOLE = theme._svg


def empty_svg(figure: Figure, key: str) -> str:
    """What a page needs of a plot: an element, and an id that no other plot has."""
    return f'<svg id="{key}-figure"></svg>'


def leave_plots_empty() -> None:
    """From now on, in this process."""
    theme._svg = empty_svg


@contextmanager
def whole_plots() -> Iterator[None]:
    """Plots as users get them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(theme, "_svg", WHOLE)
        yield


def tick_numbers(axes: Axes, which: str) -> list[str]:
    """Numbers at the ticks of an axis, "x" or "y", of a figure that was drawn."""
    axis = getattr(axes, f"{which}axis")
    low, high = sorted(axis.get_view_interval())
    ticks = (each for each in axis.get_major_ticks() if low <= each.get_loc() <= high)
    return [each.label1.get_text() for each in ticks if each.label1.get_visible()]
