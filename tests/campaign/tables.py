# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of the campaign in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from campaign.judge import QUANTITIES, Judged

# Elements over the half-width, or over the rounded part in contact, that the guide advises: with
# them a contact counts as resolved.
RESOLVED, RESOLVED_SOLIDS = 25, 10


def tables(
    judged: Iterable[Judged], quantities: Sequence[str] = QUANTITIES, elements: int = RESOLVED
) -> str:
    """A table of all numbers, and one of those on meshes with enough elements."""
    everything = list(judged)
    resolved = [each for each in everything if each.draw.per_half_width >= elements]
    return "\n\n".join(
        [
            f"All {_count(everything)} cases:",
            table(everything, quantities),
            f"The {_count(resolved)} cases with {elements} elements or more:",
            table(resolved, quantities),
        ]
    )


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
    sized = [each for each in given if each.size]
    if not sized:
        return ["–"] * 3
    hold = np.mean([each.error <= each.bar for each in given])
    bar = np.median([each.bar / each.size for each in sized])
    error = np.median([abs(each.value - each.truth) / each.size for each in sized])
    return [f"{hold:.1%}", f"{bar:.2%}", f"{error:.2%}"]
