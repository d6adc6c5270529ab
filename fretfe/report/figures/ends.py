# SPDX-License-Identifier: LGPL-3.0-or-later
"""Free ends of fronts of solids by the sub-models around them, along the front."""

from __future__ import annotations

from matplotlib.figure import Figure

from fretfe.quality.ends import EndAnswer
from fretfe.report.page.ends import end_lines
from fretfe.report.theme import BLUE, GREY, SINGLE, VERMILLION, Plot, make_plot
from fretfe.results.front_ends import find_end, known_ranges
from fretfe.results.model import Result

INTRO = (
    "Two sub-models around a free end, driven by the run, with small elements there; those of the "
    "coarser one are twice as long. |ΔK| over the distance from the end, as far as it means "
    "something. Next to the end the nodes tell: the largest of their ranges of slip, friction work "
    "and tractions in the evaluated cycle, and the mean along the front; bars are by the "
    "difference of the two."
)


def end_plot(run: Result, answer: EndAnswer, key: str) -> Plot:
    """|ΔK| along the front near its end, by the run and by both sub-models."""
    end = find_end(run, answer.name)
    assert end is not None
    table = known_ranges(end)
    table = table[:, table[0] <= 1.5 * answer.distance[-1]]

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        axes.errorbar(table[0], table[1], table[2], fmt="s", color=GREY, label="run")
        axes.plot(answer.distance, answer.coarser, "--", color=BLUE, label="coarser sub-model")
        found = answer.distance, answer.k_range, answer.k_range_spread
        axes.errorbar(*found, fmt="o", color=VERMILLION, label="finer sub-model")
        axes.set_xlabel(f"distance from {answer.name} [{run.unit('length')}]")
        axes.set_ylabel(run.axis_label("k_range"))
        axes.set_xlim(left=0.0)
        axes.legend()

    caption = " ".join(end_lines(run, answer))
    return make_plot(key, f"Free end {answer.name}", caption, SINGLE, draw)
