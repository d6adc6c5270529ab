# SPDX-License-Identifier: LGPL-3.0-or-later
"""Figures of a sweep: lines over one key that varies, maps over two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.case import Units
from fretfe.report.theme import (
    COLOURS,
    CYCLE,
    FILE_DPI,
    GREY,
    MARKERS,
    SINGLE,
    STYLE,
    WIDTH,
)

Record = Mapping[str, Any]
Edge = tuple[str, str]

LARGEST_DIMENSION = 2


def write_sweep(path: Path, keys: Sequence[str], records: Sequence[Record], units: Units) -> bool:
    """Draw ΔK_T and the slip-zone length of every edge over one or two keys.

    The length is the longer one of the last two slip zones; what the edge factors predict for it
    is dashed.

    Args:
        path: picture to write.
        keys: that vary.
        records: of `Sweep.records`; those without numbers are left out.
        units: labels.

    Returns:
        Whether there is a picture: not with more than two keys, and not without numbers.
    """
    solved = [record for record in records if "edge" in record]
    if not solved or len(keys) > LARGEST_DIMENSION:
        return False
    edges = list(dict.fromkeys((str(each["contact"]), str(each["edge"])) for each in solved))
    with mpl.rc_context(STYLE):
        draw = _draw_lines if len(keys) == 1 else _draw_maps
        figure = draw(keys, solved, edges, _labels(units))
        figure.savefig(path, dpi=FILE_DPI)
    return True


def _labels(units: Units) -> tuple[str, str]:
    return f"ΔK_T [{units.stress}·√{units.length}]", f"slip zone d [{units.length}]"


def _slip(record: Record, name: str = "slip") -> float:
    """The longer one of the last two; NaN if the whole contact slips."""
    lengths = [record[f"{name}_{number}"] for number in (1, 2)]
    known = [length for length in lengths if np.isfinite(length)]
    return max(known) if known and not record["gross"] else float("nan")


def _places(records: Sequence[Record], key: str) -> tuple[dict[Any, float], list[str]]:
    """Places of the values of a key on an axis, and their names if they are no numbers."""
    values = list(dict.fromkeys(_hashable(record[key]) for record in records))
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return {value: float(value) for value in sorted(values)}, []
    return {value: float(n) for n, value in enumerate(values)}, [str(value) for value in values]


def _hashable(value: Any) -> Any:
    return value if isinstance(value, int | float | str | bool) else str(value)


def _draw_lines(
    keys: Sequence[str], records: Sequence[Record], edges: list[Edge], labels: tuple[str, str]
) -> Figure:
    key = keys[0]
    places, names = _places(records, key)
    figure = Figure(figsize=(2 * WIDTH, SINGLE), layout="constrained")
    panels = figure.subplots(1, 2)
    for number, edge in enumerate(edges):
        own = [each for each in records if (each["contact"], each["edge"]) == edge]
        own.sort(key=lambda record: places[_hashable(record[key])])
        x = [places[_hashable(each[key])] for each in own]
        style: dict[str, Any] = {
            "color": CYCLE[number % len(CYCLE)],
            "marker": MARKERS[number % len(MARKERS)],
            # Edges often agree: the first one is seen around those that cover it.
            "markersize": 4 + 5 * (len(edges) - number - 1) / len(edges),
            "markerfacecolor": "none",
            "linewidth": 1.2,
        }
        panels[0].plot(x, [each["k_t_range"] for each in own], label=" ".join(edge), **style)
        panels[1].plot(x, [_slip(each) for each in own], label=" ".join(edge), **style)
        predicted = [_slip(each, "predicted") for each in own]
        panels[1].plot(x, predicted, color=style["color"], linestyle="--", linewidth=0.9)
    for panel, label in zip(panels, labels, strict=True):
        _finish_axis(panel, key, names, label)
    panels[1].plot([], [], color=GREY, linestyle="--", linewidth=0.9, label="predicted")
    panels[1].legend()
    return figure


def _finish_axis(panel: Axes, key: str, names: list[str], label: str) -> None:
    panel.set_xlabel(key)
    panel.set_ylabel(label)
    panel.set_ylim(0, 1.05 * panel.get_ylim()[1])
    if names:
        panel.set_xticks(range(len(names)), names)


def _draw_maps(
    keys: Sequence[str], records: Sequence[Record], edges: list[Edge], labels: tuple[str, str]
) -> Figure:
    figure = Figure(figsize=(2 * WIDTH, SINGLE * len(edges)), layout="constrained")
    rows = figure.subplots(len(edges), 2, squeeze=False)
    quantities = (lambda record: record["k_t_range"], _slip)
    for edge, panels in zip(edges, rows, strict=True):
        own = [each for each in records if (each["contact"], each["edge"]) == edge]
        for panel, label, quantity in zip(panels, labels, quantities, strict=True):
            values = {
                (_hashable(each[keys[0]]), _hashable(each[keys[1]])): quantity(each) for each in own
            }
            image = _draw_map(panel, keys, [_places(records, key) for key in keys], values)
            figure.colorbar(image, ax=panel, label=label)
            panel.set_title(" ".join(edge))
    return figure


def _draw_map(
    panel: Axes,
    keys: Sequence[str],
    axes: Sequence[tuple[dict[Any, float], list[str]]],
    values: Mapping[tuple[Any, Any], float],
) -> Any:
    """A cell for each combination, around its values; empty where there is no number."""
    (across, across_names), (up, up_names) = axes
    grid = np.array([[values.get((x, y), np.nan) for x in across] for y in up])
    borders = [_borders(np.array(list(places.values()))) for places in (across, up)]
    image = panel.pcolormesh(*borders, np.ma.masked_invalid(grid), cmap=COLOURS)
    panel.set_xlabel(keys[0])
    panel.set_ylabel(keys[1])
    if across_names:
        panel.set_xticks(range(len(across_names)), across_names)
    if up_names:
        panel.set_yticks(range(len(up_names)), up_names)
    return image


def _borders(centres: Array) -> Array:
    """(n + 1,) borders of cells half way between n increasing centres."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])
