# SPDX-License-Identifier: LGPL-3.0-or-later
"""Free ends of fronts of solids by the sub-models around them, in words."""

from __future__ import annotations

from collections.abc import Iterator

from fretfe.mesh.mesh import place_text
from fretfe.quality.ends import NUMBERS, EndAnswer, EndNumber
from fretfe.report.texts import with_error
from fretfe.results.model import Result


def end_lines(run: Result, answer: EndAnswer) -> Iterator[str]:
    """Numbers at a free end, in words."""
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
            grows = f", and grows towards it {power}"
        yield f"{place} |ΔK| is {known} {length} from it [{run.unit('k_t')}]{grows}."
    else:
        yield f"{place} |ΔK| means nothing in the part, which is within a local length of its ends."
    texts = "; ".join(_number_text(run, each) for each in answer.numbers)
    yield f"Nodes on the last {answer.length:g} {length} of the front: {texts}."
    if answer.meetings:
        met = answer.meetings[0]
        yield (
            f"Run and sub-model {'agree' if met.agrees else 'differ'} at {met.station}, "
            f"{met.distance:.3g} {length} from that end: |ΔK| "
            f"{with_error(met.run, met.run_spread)} and {with_error(met.part, met.part_spread)}."
        )
    else:
        yield "No station of the run is near enough to that end to be compared."


def _number_text(run: Result, found: EndNumber) -> str:
    declared = NUMBERS[found.name]
    unit = run.unit(declared.kind)
    mean = f"mean {with_error(found.mean, found.mean_spread)}"
    if found.grows:
        power = _power(found.exponent, found.exponent_spread)
        return f"{declared.meaning} {mean} {unit}, growing {power}".replace("  ", " ")
    largest = with_error(found.largest, found.largest_spread)
    return f"{declared.meaning} {largest} {unit}, {mean}".replace(" ,", ",")


def _power(exponent: float, spread: float) -> str:
    """Growth towards an end, in words."""
    return f"like distance^-m, m = {with_error(exponent, spread)}"
