# SPDX-License-Identifier: LGPL-3.0-or-later
"""A comparison of two results as JSON and as figures of results laid over each other."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.exchange.comparison import EDGE_NUMBERS, FRONT_NUMBERS, Comparison, QuantityPair
from fretfe.exchange.overlays import Curve, HistoryPair, TractionPair
from fretfe.files import json_value, replace_text, writing
from fretfe.report.plotting import Axes, Figure, mpl
from fretfe.report.theme import (
    BLUE,
    GREY,
    LOW,
    SINGLE,
    STYLE,
    VERMILLION,
    WIDTH,
    envelope,
    save_figure,
)
from fretfe.results.writer import prepare_other
from fretfe.verdict import Verdict

# The first result lies wide and pale under the second one, so that both are seen where they agree.
FIRST: dict[str, Any] = {"lw": 4.0, "alpha": 0.35, "solid_capstyle": "butt"}
SECOND: dict[str, Any] = {"lw": 1.1, "ls": (0, (4.0, 1.5))}
# Beside the contact, as a fraction of its width.
MARGIN = 0.05
# Rows from one number of an edge to the next one in the same panel.
BELOW = 0.3
# Inches of a row of the figure of differences, and of what stands around them.
ROW = 0.32
AROUND = 1.3
SCHEMA = {"name": "fretfe-comparison", "version": 2}
COMPARISON = "comparison.json"
HISTORY_KEYS = ("contact", "edge", "quantity", "unit", "common", "difference")


def plot_tractions(comparison: Comparison) -> Figure:
    """Pressure and shear along every contact at the load extremes, one row per contact."""
    with mpl.rc_context(STYLE):
        figure, rows = _grid(len(compared_contacts(comparison)), 2)
        draw_tractions([panel for row in rows for panel in row], comparison)
        name_results(figure.axes[0], comparison.labels)
    return figure


def compared_contacts(comparison: Comparison) -> list[str]:
    """Names of the contacts with tractions."""
    return list(dict.fromkeys(each.contact for each in comparison.tractions))


def draw_tractions(panels: Sequence[Axes], comparison: Comparison) -> None:
    """Draw pressure and shear at the load extremes, two panels for each contact."""
    for place, contact in enumerate(compared_contacts(comparison)):
        own = panels[2 * place : 2 * place + 2]
        pairs = [each for each in comparison.tractions if each.contact == contact]
        for panel, pair in zip(own, pairs, strict=False):
            _draw_tractions(panel, comparison, pair)
        for panel in own[len(pairs) :]:
            panel.set_axis_off()


def plot_histories(comparison: Comparison) -> Figure:
    """P, Q and K_T over time, of solids also the contact area; one row per contact."""
    quantities = list(dict.fromkeys(each.quantity for each in comparison.histories))
    contacts = [first for first, _ in comparison.contacts]
    with mpl.rc_context(STYLE):
        figure, rows = _grid(len(contacts), len(quantities))
        for contact, panels in zip(contacts, rows, strict=True):
            for panel, quantity in zip(panels, quantities, strict=True):
                own = [
                    each
                    for each in comparison.histories
                    if (each.contact, each.quantity) == (contact, quantity)
                ]
                if own:
                    _draw_histories(panel, comparison, own)
                else:
                    panel.set_axis_off()
        name_results(figure.axes[0], comparison.labels)
    return figure


def plot_differences(comparison: Comparison) -> Figure:
    """Relative differences of K_N, ΔK_T and the last two slip zones of every edge, with bars."""
    edges = list(dict.fromkeys((e.contact, e.edge) for e in comparison.quantities if e.edge))
    with mpl.rc_context(STYLE):
        size = (2 * WIDTH, AROUND + ROW * len(edges))
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(1, 3, sharey=True)
        for panel, names in zip(panels, _columns(comparison), strict=True):
            own = [each for each in comparison.quantities if each.quantity in names]
            _draw_differences(panel, edges, own, names)
        panels[0].set_yticks(range(len(edges)), [" ".join(each) for each in edges])
        panels[0].set_ylim(len(edges) - 0.5, -0.5)
        second, first = comparison.labels[1], comparison.labels[0]
        figure.suptitle(f"Difference of {second} from {first}")
    return figure


def _columns(comparison: Comparison) -> list[tuple[str, ...]]:
    compared = FRONT_NUMBERS if comparison.results[0].solid else EDGE_NUMBERS
    k_n, k_range, *zones = (each.symbol for each in compared[:4])
    return [(k_n,), (k_range,), tuple(zones)]


def _draw_differences(
    panel: Axes,
    edges: Sequence[tuple[str, str]],
    pairs: Sequence[QuantityPair],
    names: tuple[str, ...],
) -> None:
    """Draw numbers of some names; several of an edge below each other, in their order."""
    panel.axvline(0, color=GREY, lw=0.8)
    middle = (len(names) - 1) / 2
    for pair in pairs:
        if np.isfinite(pair.difference):
            bar = pair.difference_spread
            below = BELOW * (names.index(pair.quantity) - middle)
            panel.errorbar(
                100 * pair.difference,
                edges.index((pair.contact, pair.edge)) + below,
                xerr=100 * bar if np.isfinite(bar) else None,
                fmt="o" if np.isfinite(bar) else "x",
                ms=4.5, capsize=3,
                color=VERMILLION if pair.verdict is Verdict.DIFFERS else BLUE,
            )  # fmt: skip
    panel.set_xlabel(f"{', '.join(names)} [%]")
    if not any(np.isfinite(pair.difference) for pair in pairs):
        panel.text(
            0.5, 0.5, "not known", transform=panel.transAxes, ha="center", backgroundcolor="w"
        )
    # Equal results are a point in the middle, not an axis of round-off.
    reach = max(0.1, *(abs(each) for each in panel.get_xlim()))
    panel.set_xlim(-reach, reach)


def _grid(contacts: int, panels: int) -> tuple[Figure, Sequence[Sequence[Axes]]]:
    """A row of panels for each contact; those of a single one below each other, to be larger."""
    if contacts == 1:
        figure = Figure(figsize=(WIDTH, LOW * panels), layout="constrained")
        return figure, [list(figure.subplots(panels, 1))]
    figure = Figure(figsize=(2 * WIDTH, SINGLE * contacts), layout="constrained")
    return figure, list(figure.subplots(contacts, panels))


def name_results(axes: Axes, labels: tuple[str, str]) -> None:
    """A legend of the two results outside of the panels, of which one is given."""
    handles = [axes.plot([], [], color=GREY, **style)[0] for style in (FIRST, SECOND)]
    axes.figure.legend(handles, labels, loc="outside upper center", ncols=2)


def _draw_tractions(panel: Axes, comparison: Comparison, pair: TractionPair) -> None:
    units = comparison.results[0].case.units
    for curve, style in ((pair.first, FIRST), (pair.second, SECOND)):
        panel.plot(curve.x, curve.pressure, color=BLUE, **style)
        panel.plot(curve.x, curve.shear, color=VERMILLION, **style)
    panel.plot([], [], color=BLUE, label="p")
    panel.plot([], [], color=VERMILLION, label="q")
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_xlim(*_limits(pair.first, pair.second))
    times = (pair.first.time, pair.second.time)
    same = f"t = {times[0]:g}" if times[0] == times[1] else f"t = {times[0]:g} and {times[1]:g}"
    panel.set_title(f"{pair.contact}, {pair.extreme}, {same} {units.time}", loc="left")
    of_solids = "from the centre of pressure along Q"
    place = of_solids if comparison.results[0].solid else "x along the contact"
    panel.set_xlabel(f"{place} [{units.length}]")
    panel.set_ylabel(f"p, q [{units.stress}]")
    panel.legend(loc="best")


def _limits(*curves: Curve) -> tuple[float, float]:
    """The contact in both results and a little beyond."""
    pressed = [curve.x[curve.pressure > 0] for curve in curves]
    x = np.concatenate(pressed)
    if not len(x):
        return float(curves[0].x[0]), float(curves[0].x[-1])
    margin = MARGIN * np.ptp(x)
    return float(x.min() - margin), float(x.max() + margin)


def _draw_histories(panel: Axes, comparison: Comparison, pairs: Sequence[HistoryPair]) -> None:
    for pair, colour in zip(pairs, (BLUE, VERMILLION), strict=False):
        for times, values, style in (
            (pair.first_times, pair.first, FIRST),
            (pair.second_times, pair.second, SECOND),
        ):
            shown = envelope(values)
            panel.plot(times[shown], values[shown], color=colour, **style)
        if pair.edge:
            label = pair.edge if comparison.results[0].solid else f"{pair.edge} edge"
            panel.plot([], [], color=colour, label=label)
    panel.axhline(0, color=GREY, lw=0.6)
    panel.set_title(pairs[0].contact, loc="left")
    panel.set_xlabel(f"time [{comparison.results[0].case.units.time}]")
    panel.set_ylabel(f"{pairs[0].quantity} [{pairs[0].unit}]")
    if pairs[0].edge:
        panel.legend()


def _written(
    draw: Callable[[Comparison], Figure], has_content: Callable[[Comparison], bool]
) -> Callable[[Comparison, Path], bool]:
    """Write a figure where it has content; return whether it has."""

    def write(comparison: Comparison, path: Path) -> bool:
        if not has_content(comparison):
            return False
        with mpl.rc_context(STYLE):
            save_figure(draw(comparison), path)
        return True

    return write


FIGURES = {
    "differences.png": _written(plot_differences, lambda c: any(e.edge for e in c.quantities)),
    "tractions.png": _written(plot_tractions, lambda c: bool(c.tractions)),
    "histories.png": _written(plot_histories, lambda c: bool(c.histories)),
}


def comparison_numbers(comparison: Comparison) -> dict[str, Any]:
    """The comparison without its curves, in the types of JSON; null for what is unknown."""
    return {
        "schema": SCHEMA,
        "labels": list(comparison.labels),
        "contacts": [list(pair) for pair in comparison.contacts],
        "quantities": json_value(comparison.records()),
        "tractions": [
            {
                "contact": each.contact,
                "extreme": each.extreme,
                "first_time": each.first.time,
                "second_time": each.second.time,
                "pressure_difference": json_value(each.pressure_difference),
                "shear_difference": json_value(each.shear_difference),
            }
            for each in comparison.tractions
        ],
        "histories": [
            {name: json_value(getattr(each, name)) for name in HISTORY_KEYS}
            for each in comparison.histories
        ],
        "notes": list(comparison.notes),
    }


def write_comparison(comparison: Comparison, folder: Path) -> tuple[Path, ...]:
    """Write `comparison.json` and the figures.

    Args:
        comparison: of two results.
        folder: for the files; made if missing. Figures of an earlier comparison are replaced.

    Returns:
        The files.

    Raises:
        CaseError: if the folder holds results of a run.
        OutputError: if a file cannot be written.
    """
    prepare_other(folder)
    text = json.dumps(comparison_numbers(comparison), indent=1, allow_nan=False) + "\n"
    files = [folder / COMPARISON]
    with writing(folder, "the comparison"):
        replace_text(files[0], text)
        for name, draw in FIGURES.items():
            path = folder / name
            # A figure of an earlier comparison would not belong to these numbers.
            path.unlink(missing_ok=True)
            if draw(comparison, path):
                files.append(path)
    return tuple(files)
