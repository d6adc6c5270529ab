# SPDX-License-Identifier: LGPL-3.0-or-later
"""Free ends of fronts of solids by the sub-models around them, in words and tables."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from fretfe.mesh.mesh import place_text
from fretfe.quality.end_rows import NUMBERS
from fretfe.quality.ends import FITTED
from fretfe.report.texts import MISSING, plain_table, with_error
from fretfe.results.end_answers import EndAnswer, both_ways, read_answers
from fretfe.results.model import Result

if TYPE_CHECKING:
    from rich.table import Table


def end_lines(run: Result, answer: EndAnswer) -> Iterator[str]:
    """|ΔK| near a free end, in words, and whether it meets that of the run."""
    length = run.unit("length")
    place = f"Free end {answer.name} at {place_text(answer.point)} {length}, by sub-models:"
    chosen = range(0, len(answer.distance), max(len(answer.distance) // 3, 1))
    known = ", ".join(
        f"{with_error(answer.k_range[n], answer.k_range_spread[n])} at {answer.distance[n]:.3g}"
        for n in chosen
    )
    if known:
        grows = ""
        if answer.exponent > answer.exponent_spread:
            power = _power(answer.exponent, answer.exponent_spread)
            grows = f", and grows {_fitted(run, answer)} {power}"
        yield f"{place} |ΔK| is {known} {length} from it [{run.unit('k_t')}]{grows}."
    else:
        yield f"{place} |ΔK| means nothing in the part, which is within a local length of its ends."
    if answer.meetings:
        met = answer.meetings[0]
        yield (
            f"Run and sub-model {'agree' if met.agrees else 'differ'} at {met.station}, "
            f"{met.distance:.3g} {length} from that end: {both_ways(met)}."
        )
    else:
        yield "No station of the run is near enough to that end to be compared."


def end_tables(run: Result) -> list[Table]:
    """Numbers of the nodes next to each free end of a run that has sub-models."""
    return [end_table(run, answer) for answer in read_answers(run)]


def end_table(run: Result, answer: EndAnswer) -> Table:
    """Numbers of the nodes next to a free end; none is largest where it grows like a power."""
    title = f"Nodes on the last {answer.length:g} {run.unit('length')} of {answer.name}"
    table = plain_table(
        title, ("", "unit", "largest", "mean", f"grows {_fitted(run, answer)}"), text=2
    )
    for each in answer.numbers:
        declared = NUMBERS[each.name]
        table.add_row(
            declared.meaning,
            run.unit(declared.kind),
            MISSING if each.grows else with_error(each.largest, each.largest_spread),
            with_error(each.mean, each.mean_spread),
            _power(each.exponent, each.exponent_spread) if each.grows else "",
        )
    return table


def _fitted(run: Result, answer: EndAnswer) -> str:
    """Distances from an end to which powers are fitted, in words."""
    return f"within {FITTED * answer.length:.2g} {run.unit('length')}"


def _power(exponent: float, spread: float) -> str:
    """Growth towards an end, in words."""
    if math.isnan(exponent):
        return "like an unknown power"
    return f"like distance^-m, m = {with_error(exponent, spread)}"
