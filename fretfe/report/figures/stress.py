# SPDX-License-Identifier: LGPL-3.0-or-later
"""Largest stress along the surface, and the Smith-Watson-Topper parameter, next to the edges."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe.evaluate.contacts import Station
from fretfe.evaluate.stress import EdgeStress, StressHistory, StressParameters, stress_parameters
from fretfe.report.figures.plot import Plot, finish_edge_column, make_plot
from fretfe.report.figures.slip import edge_window
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import with_error
from fretfe.report.theme import CYCLE, DOUBLE

# Body 1 and body 2, as lines and as markers at the edge.
LINES, MARKERS = ("--", "-"), ("s", "o")
INTRO = (
    "At both edges, largest values in the evaluated cycle, under irregular loads in the worst one; "
    "dashed: body 1, solid: body 2. Above: stress along the surface, at the surface and at the "
    "depths that the case asks for; markers with bars: at the edge itself, where it has a cusp of "
    "which nodes see the less the larger the elements are. Below: the parameter of Smith, Watson "
    "and Topper on its critical plane. At the surface next to an edge it depends on the mesh; at a "
    "depth of a few elements it does not."
)


def stress_plot(shown: Shown) -> Plot | None:
    """Stress and its parameter along a contact; None if the run did not write any."""
    if not shown.run.has_stress:
        return None
    history = shown.run.stress_history(shown.tractions.pair)
    edges = [each for each in history.edges if each.contact == shown.tractions.name]
    return make_plot(
        f"{shown.key}-stress",
        shown.title,
        _caption(shown, edges),
        DOUBLE,
        lambda figure: _draw(figure, shown, history, edges),
    )


def _caption(shown: Shown, edges: list[EdgeStress]) -> str:
    unit = shown.run.case.units.stress
    known = [each for each in edges if not each.reason]
    texts = [
        f"{with_error(*each.largest)} {unit} ({each.edge} edge, {each.body})" for each in known
    ]
    missing = [
        f"not known at the {each.edge} edge of {each.body}: {each.reason}"
        for each in edges
        if each.reason
    ]
    return "Largest stress along the surface at the edges: " + "; ".join([*texts, *missing]) + "."


def _draw(figure: Figure, shown: Shown, history: StressHistory, edges: list[EdgeStress]) -> None:
    panels = figure.subplots(2, 2, sharex="col", sharey="row")
    units = shown.run.case.units
    for column, edge in zip(panels.T, shown.summary.stations, strict=True):
        top, bottom = column
        low, high = edge_window(shown, edge, *shown.run.loads.evaluated)
        seen = history.at(np.flatnonzero((history.arc >= low) & (history.arc <= high)))
        for number, body in enumerate(seen.bodies):
            material = shown.run.case.bodies[body.name]
            found = stress_parameters(seen, number, material)
            _lines(top, bottom, seen, found, number, units.length)
        _values(top, edge, [each for each in edges if each.edge == edge.front], history)
        finish_edge_column(column, edge_title(edge), (low, high), units.length)
    panels[0, 0].set_ylabel(f"σ along the surface [{units.stress}]")
    panels[1, 0].set_ylabel(f"SWT [{units.stress}]")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)


def _lines(
    top: Axes, bottom: Axes, seen: StressHistory, found: StressParameters, number: int, length: str
) -> None:
    """Lines of one body at all depths."""
    for place, depth in enumerate(found.depths):
        colour = CYCLE[place % len(CYCLE)]
        text = f"depth {depth:g} {length}" if depth > 0 else "surface"
        label = text if number == 1 else None
        for axes, values in ((top, found.largest_tension), (bottom, found.swt)):
            axes.plot(seen.arc, values[place], LINES[number], color=colour, lw=1.2, label=label)


def _values(axes: Axes, edge: Station, found: list[EdgeStress], history: StressHistory) -> None:
    """Markers with bars at the edge, body by body."""
    for number, each in enumerate(found):
        if each.reason:
            continue
        value, spread = each.largest
        at = history.states[int(np.nanargmax(each.value))]
        axes.errorbar(
            [edge.position[at]], [value], [spread], marker=MARKERS[number], ms=4, mfc="white",
            color=CYCLE[0], capsize=2, lw=1.0,
        )  # fmt: skip
