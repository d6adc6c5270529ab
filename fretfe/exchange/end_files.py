# SPDX-License-Identifier: LGPL-3.0-or-later
"""What two sub-models say of a free end of a front: in words, as JSON and as a figure."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from fretfe.files import json_value, replace_text, writing
from fretfe.mesh.mesh import place_text
from fretfe.quality.ends import NUMBERS, EndAnswer, EndNumber
from fretfe.report.texts import with_error
from fretfe.report.theme import BLUE, GREY, SINGLE, STYLE, VERMILLION, save_figure
from fretfe.results.front_ends import find_end, known_ranges
from fretfe.results.model import Result

ANSWER = "end.json"
FIGURE = "end.png"
SCHEMA = {"name": "fretfe-end", "version": 1}


def write_end(run: Result, answer: EndAnswer, folder: Path) -> tuple[Path, Path]:
    """Write numbers and figure of a free end.

    Args:
        run: of the whole.
        answer: of the end.
        folder: for the files.

    Raises:
        OutputError: if they cannot be written.
    """
    text = json.dumps(as_numbers(run, answer), indent=1, allow_nan=False)
    with writing(folder, "the answer at the end"):
        replace_text(folder / ANSWER, text + "\n")
        save_figure(end_figure(run, answer), folder / FIGURE)
    return folder / ANSWER, folder / FIGURE


def as_numbers(run: Result, answer: EndAnswer) -> dict[str, Any]:
    """The answer in plain types; what is unknown is None."""
    numbers = {
        name: {
            "unit": run.unit(NUMBERS[name].kind),
            "meaning": NUMBERS[name].meaning,
            "grows": each.grows,
            **asdict(each),
        }
        for name, each in answer.numbers.items()
    }
    meetings = [{**asdict(each), "agrees": each.agrees} for each in answer.meetings]
    found: dict[str, Any] = json_value(
        {"schema": SCHEMA, **vars(answer), "numbers": numbers, "meetings": meetings}
    )
    return found


def end_lines(run: Result, answer: EndAnswer) -> Iterator[str]:
    """An answer in words."""
    length, factor = run.unit("length"), run.unit("k_t")
    yield f"Free end {answer.name} at {place_text(answer.point)} {length}"
    if len(answer.distance):
        near = ", ".join(
            f"{with_error(answer.k_range[n], answer.k_range_spread[n])} at {answer.distance[n]:.3g}"
            for n in dict.fromkeys((0, len(answer.distance) // 4, len(answer.distance) // 2))
        )
        yield (
            f"|ΔK| in {factor} by the distance from it in {length}: {near}; nearer it means nothing"
        )
        yield f"|ΔK| grows towards the end {_power(answer.exponent, answer.exponent_spread)}"
    else:
        yield "|ΔK| is unknown near it: stations are within a local length of an end"
    yield f"Nodes over the last {answer.length:g} {length} of the front:"
    for name, each in answer.numbers.items():
        yield f"  {_number_text(run, name, each)}"
    for met in answer.meetings[:2]:
        yield (
            f"Run and sub-model {'agree' if met.agrees else 'differ'} at {met.station}, "
            f"{met.distance:.3g} {length} from the end: |ΔK| "
            f"{with_error(met.run, met.run_spread)}, {with_error(met.part, met.part_spread)}"
        )


def _number_text(run: Result, name: str, found: EndNumber) -> str:
    unit = run.unit(NUMBERS[name].kind)
    mean = f"mean {with_error(found.mean, found.mean_spread)} {unit}".rstrip()
    if found.grows:
        power = _power(found.exponent, found.exponent_spread)
        return f"{NUMBERS[name].meaning}: {mean}; no largest value, as it grows {power}"
    largest = with_error(found.largest, found.largest_spread)
    return f"{NUMBERS[name].meaning}: {largest} {unit}".rstrip() + f", {mean}"


def _power(exponent: float, spread: float) -> str:
    """Growth towards an end, in words."""
    if not exponent > spread:
        return "like no power"
    return f"like distance^-m, m = {with_error(exponent, spread)}"


def end_figure(run: Result, answer: EndAnswer) -> Figure:
    """|ΔK| along the front near its end, by the run and by both sub-models."""
    end = find_end(run, answer.name)
    assert end is not None
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(SINGLE, 0.75 * SINGLE), layout="constrained")
        axes = figure.subplots()
        table = known_ranges(end)
        table = table[:, table[0] <= 1.5 * answer.distance.max(initial=answer.length)]
        axes.errorbar(*table, fmt="s", ms=3, color=GREY, label="run")
        axes.plot(answer.distance, answer.coarser, color=BLUE, ls="--", label="coarser sub-model")
        axes.errorbar(
            answer.distance, answer.k_range, answer.k_range_spread,
            fmt="o", ms=3, color=VERMILLION, label="finer sub-model",
        )  # fmt: skip
        axes.set(xlabel=f"from {answer.name} [{run.unit('length')}]", xlim=(0.0, None))
        axes.set_ylabel(run.axis_label("k_range"))
        axes.legend()
    return figure
