# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of the campaign in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from campaign.draw import Draw
from campaign.judge import QUANTITIES, Judged

# Elements over the half-width, or over the rounded part in contact, that the guide advises: with
# them a contact counts as resolved.
RESOLVED, RESOLVED_SOLIDS = 25, 10
# Numbers of elements between which bars are compared with errors.
BINS = (3, 5, 10, 20, 40, 80)


def tables(
    judged: Iterable[Judged], quantities: Sequence[str] = QUANTITIES, elements: int = RESOLVED
) -> str:
    """A table of all numbers, one of those on meshes with enough elements, one by elements."""
    everything = list(judged)
    resolved = [each for each in everything if each.draw.per_half_width >= elements]
    return "\n\n".join(
        [
            f"All {_count(everything)} cases:",
            table(everything, quantities),
            f"The {_count(resolved)} cases with {elements} elements or more:",
            table(resolved, quantities),
            "By elements:",
            by_elements(everything, quantities),
        ]
    )


def by_elements(judged: list[Judged], quantities: Sequence[str] = QUANTITIES) -> str:
    """A row for each quantity and number of elements: how many bars hold, and how sharp they are.

    Of an ideal bar of 95 % the ratio is 2.9 if errors are normally distributed.
    """
    rows = [
        "| number | elements | given | silently wrong | bars hold | median bar | median error | "
        "ratio |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for quantity in quantities:
        for low, high in pairwise(BINS):
            own = [
                each
                for each in judged
                if each.quantity == quantity and low <= each.draw.per_half_width < high
            ]
            if own:
                rows.append(_row(f"{quantity} | {low} to {high}", own))
    return "\n".join(rows)


def kinds(judged: list[Judged], quantities: Sequence[str] = QUANTITIES) -> str:
    """The same with a row for each quantity and kind of history."""
    names = dict.fromkeys(each.draw.kind for each in judged if isinstance(each.draw, Draw))
    rows = [
        "| number | history | given | silently wrong | bars hold | median bar | median error | "
        "ratio |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for quantity in quantities:
        for name in names:
            own = [
                each
                for each in judged
                if each.quantity == quantity
                and isinstance(each.draw, Draw)
                and each.draw.kind == name
            ]
            rows.append(_row(f"{quantity} | {name}", own))
    return "\n".join(rows)


def _row(title: str, own: list[Judged]) -> str:
    """Given, silently wrong, share of bars that hold, medians and their ratio."""
    given = [each for each in own if np.isfinite(each.value)]
    wrong = sum(each.verdict == "wrong" for each in own)
    sized = _sized(given)
    cells = [f"{len(given)} of {len(own)}", str(wrong), *_shares(given), "–"]
    if sized:
        bar, error = _medians(sized)
        cells[-1] = f"{bar / error:.1f}" if error else "–"
    return "| " + " | ".join([title, *cells]) + " |"


def _count(judged: list[Judged]) -> int:
    return len({each.draw.number for each in judged})


def table(judged: list[Judged], quantities: Sequence[str] = QUANTITIES) -> str:
    """A row for each quantity."""
    rows = [
        "| number | given | right | flagged | silently wrong | bars hold | median bar | "
        "median error |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for quantity in quantities:
        own = [each for each in judged if each.quantity == quantity]
        given = [each for each in own if np.isfinite(each.value)]
        counts = [sum(e.verdict == v for e in own) for v in ("right", "flagged", "wrong")]
        cells = [f"{len(given)} of {len(own)}", *map(str, counts), *_shares(given)]
        rows.append("| " + " | ".join([quantity, *cells]) + " |")
    return "\n".join(rows)


def _shares(given: list[Judged]) -> list[str]:
    """How many bars hold, and the medians of bar and error."""
    sized = _sized(given)
    if not sized:
        return ["–"] * 3
    hold = np.mean([each.error <= each.bar for each in given])
    bar, error = _medians(sized)
    return [f"{hold:.1%}", f"{bar:.2%}", f"{error:.2%}"]


def _sized(given: list[Judged]) -> list[Judged]:
    """Those that errors can be relative to; no slip has a bar, but no size."""
    return [each for each in given if each.size and each.value]


def _medians(sized: list[Judged]) -> tuple[float, float]:
    """Of the bars and the errors, relative."""
    bar = np.median([each.bar / each.size for each in sized])
    error = np.median([abs(each.value - each.truth) / each.size for each in sized])
    return float(bar), float(error)
