# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of a sweep: numbers of edges over the keys that vary, and the effects of the keys."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.case import Units
from fretfe.errors import OutputError
from fretfe.report.plotting import Axes, Figure, mpl
from fretfe.report.texts import number
from fretfe.report.theme import (
    BLUE,
    CYCLE,
    GREY,
    MARKERS,
    SINGLE,
    STYLE,
    VERMILLION,
    WIDTH,
    save_figure,
)
from fretfe.results.quantities import EDGES, SOLIDS, axis_label, unit

Record = Mapping[str, Any]
Edge = tuple[str, str]


def write_sweep(path: Path, keys: Sequence[str], records: Sequence[Record], units: Units) -> bool:
    """Draw ΔK_T and the slip-zone length of every edge over a key.

    The length is the longer one of the last two slip zones; what the edge factors predict for it
    is dashed. Over more keys, ΔK_T over each key and its effects.

    Args:
        path: picture to write.
        keys: that vary.
        records: of `Sweep.records`; those without numbers are left out.
        units: labels.

    Returns:
        Whether there is a picture: not without numbers.
    """
    solved = [record for record in records if "edge" in record]
    if not solved:
        return False
    with mpl.rc_context(STYLE):
        one = len(keys) == 1
        figure = _draw_lines(keys[0], solved, units) if one else _draw_effects(keys, solved, units)
        save_figure(figure, path)
    return True


def _edges(records: Sequence[Record]) -> list[Edge]:
    """Contacts and edges; the second name is empty of solids."""
    return list(
        dict.fromkeys((str(each["contact"]), str(each.get("edge", ""))) for each in records)
    )


def _longer_slip(record: Record, name: str = "slip") -> float:
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


def _draw_lines(key: str, records: Sequence[Record], units: Units) -> Figure:
    labels = axis_label("k_t_range", units, solid=False), f"slip zone d [{units.length}]"
    places, names = _places(records, key)
    figure = Figure(figsize=(2 * WIDTH, SINGLE), layout="constrained")
    panels = figure.subplots(1, 2)
    for own, edge, style in _styled(records):
        own.sort(key=lambda record: places[_hashable(record[key])])
        x = [places[_hashable(each[key])] for each in own]
        line = {**style, "label": " ".join(edge), "linewidth": 1.2}
        panels[0].plot(x, [each["k_t_range"] for each in own], **line)
        panels[1].plot(x, [_longer_slip(each) for each in own], **line)
        predicted = [_longer_slip(each, "predicted") for each in own]
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


@dataclass(frozen=True)
class Effect:
    """The change of a quantity with a key that goes through its range, others in their middle.

    Attributes:
        key: that varies.
        low, high: its smallest and largest value.
        at_low, at_high: the quantity there, of the linear function that fits all cases best.
    """

    key: str
    low: float
    high: float
    at_low: float
    at_high: float


def linear_effects(
    keys: Sequence[str], records: Sequence[Record], quantity: str
) -> tuple[list[Effect], float]:
    """Effects of all keys, the largest first, and the part of the variance that they explain.

    Args:
        keys: that vary.
        records: with numbers; each case counts with its largest value of all edges.
        quantity: name of a column.

    Raises:
        OutputError: if a value is no number, or cases do not tell the keys apart.
    """
    largest: dict[tuple[Any, ...], float] = {}
    for record in records:
        case = tuple(_hashable(record[key]) for key in keys)
        if math.isfinite(record[quantity]):
            largest[case] = max(largest.get(case, -math.inf), record[quantity])
    texts = {each for case in largest for each in case if isinstance(each, str | bool)}
    if texts:
        raise OutputError(f"expected numbers of all keys that vary, found {texts.pop()!r}")
    count = len(keys) + 1
    places, values = np.array(list(largest), dtype=float), np.array(list(largest.values()))
    if len(values) >= count:
        low, high = places.min(axis=0), places.max(axis=0)
        shares = (places - (low + high) / 2) / np.where(high > low, high - low, 1)
        columns = np.column_stack([np.ones(len(values)), shares])
        if np.linalg.matrix_rank(columns) == count:
            (middle, *slopes), explained = _fitted(columns, values)
            effects = [
                Effect(key, float(one), float(two), middle - slope / 2, middle + slope / 2)
                for key, one, two, slope in zip(keys, low, high, slopes, strict=True)
            ]
            return sorted(effects, key=lambda each: -abs(each.at_high - each.at_low)), explained
    raise OutputError(
        f"expected {count} cases or more with a known {quantity} that tell {len(keys)} keys "
        f"apart, found {len(values)}"
    )


def _fitted(columns: Array, values: Array) -> tuple[list[float], float]:
    """Factors of columns (n, k) that fit values (n,) best, and the variance that they explain."""
    factors = np.linalg.lstsq(columns, values, rcond=None)[0]
    rest, whole = float(np.var(values - columns @ factors)), float(np.var(values))
    return factors.tolist(), 1 - rest / whole if whole > 0 else 1.0


def solved_records(
    records: Sequence[Record], quantity: str, units: Units
) -> tuple[list[Record], str]:
    """Records that have a quantity, and its label.

    Raises:
        OutputError: if there are none, or it is no number.
    """
    solved = [each for each in records if "contact" in each]
    columns = {each.name: each for each in (EDGES if _has_edges(solved) else SOLIDS)}
    numbers = [
        name
        for name in columns
        if solved and isinstance(solved[0].get(name), float | int)
        if not isinstance(solved[0][name], bool)
    ]
    if quantity not in numbers:
        raise OutputError(f"expected one of {', '.join(numbers) or '(none)'}, found {quantity!r}")
    found = unit(columns[quantity].kind, units, solid=not _has_edges(solved))
    return solved, f"{quantity} [{found}]" if found else quantity


def _has_edges(records: Sequence[Record]) -> bool:
    return any("edge" in each for each in records)


def draw_tornado(panel: Axes, effects: Sequence[Effect], explained: float, label: str) -> None:
    """Draw a bar for each effect, the largest on top, from its value at the low end of the key."""
    panel.use_sticky_edges = False
    for place, each in enumerate(effects):
        rises = each.at_high >= each.at_low
        panel.barh(
            place, each.at_high - each.at_low, left=each.at_low, height=0.6,
            color=BLUE if rises else VERMILLION, hatch="" if rises else "//", edgecolor="white",
        )  # fmt: skip
    # Long keys leave no room for what is below and above the bars.
    keys = ["\n".join(re.findall(r".*\.|[^.]+$", each.key)) for each in effects]
    names = [f"{key}\n{number(each.low)} to {number(each.high)}"
             for key, each in zip(keys, effects, strict=True)]  # fmt: skip
    panel.set_yticks(range(len(effects)), names)
    panel.invert_yaxis()
    panel.axvline((effects[0].at_low + effects[0].at_high) / 2, color=GREY, lw=0.8)
    panel.set_xlabel(f"largest {label}")
    panel.set_title(f"hatched: falls with key\nlinear part {explained:.0%}", loc="left")


def draw_scatter(
    panels: Sequence[Axes],
    keys: Sequence[str],
    records: Sequence[Record],
    quantity: str,
    label: str,
) -> None:
    """Draw a quantity of all edges, with its error bars, over each key, one panel per key."""
    for key, panel in zip(keys, panels, strict=True):
        places, names = _places(records, key)
        for own, edge, style in _styled(records):
            x = [places[_hashable(each[key])] for each in own]
            bars = [each.get(f"{quantity}_spread", math.nan) for each in own]
            panel.errorbar(
                x, [each[quantity] for each in own], bars, ls="none", elinewidth=0.7,
                label=" ".join(edge).strip(), **style,
            )  # fmt: skip
        panel.set_xlabel(key)
        panel.set_ylabel(label)
        if names:
            panel.set_xticks(range(len(names)), names)
    panels[-1].legend()


def _styled(records: Sequence[Record]) -> Iterator[tuple[list[Record], Edge, dict[str, Any]]]:
    """Records of each edge, with its colour and marker."""
    edges = _edges(records)
    for place, edge in enumerate(edges):
        own = [each for each in records if (each["contact"], each.get("edge", "")) == edge]
        yield (
            own,
            edge,
            {
                "color": CYCLE[place % len(CYCLE)],
                "marker": MARKERS[place % len(MARKERS)],
                # Edges often agree: the first one is seen around those that cover it.
                "markersize": 4 + 5 * (len(edges) - place - 1) / len(edges),
                "markerfacecolor": "none",
            },
        )


def _draw_effects(keys: Sequence[str], records: Sequence[Record], units: Units) -> Figure:
    """ΔK_T over each key, and below the effects, if the cases tell them apart."""
    label = axis_label("k_t_range", units, solid=False)
    effects: list[Effect] = []
    explained = math.nan
    with suppress(OutputError):
        effects, explained = linear_effects(keys, records, "k_t_range")
    rows = -(-len(keys) // 2)
    height = SINGLE * rows + (SINGLE if effects else 0)
    figure = Figure(figsize=(2 * WIDTH, height), layout="constrained")
    names: list[Any] = [list(keys[2 * row : 2 * row + 2]) * 2 for row in range(rows)]
    panels = figure.subplot_mosaic([row[:2] for row in names] + [["", ""]] * bool(effects))
    draw_scatter([panels[key] for key in keys], keys, records, "k_t_range", label)
    if effects:
        draw_tornado(panels[""], effects, explained, label)
    return figure
