# SPDX-License-Identifier: LGPL-3.0-or-later
"""`PYTHONPATH=tests python -m campaign [COUNT]`: how many numbers are right, flagged or wrong."""

from __future__ import annotations

import sys

import numpy as np
from campaign.draw import draw
from campaign.judge import Judged, judge

import fretfe.fem  # noqa: F401

COUNT = 300


def main() -> None:
    """Judge the first cases and print a table for docs/validate.md."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    judged: list[Judged] = []
    for number in range(count):
        numbers = list(judge(draw(number)))
        judged += numbers
        for each in numbers:
            if each.verdict == "wrong":
                print(
                    f"wrong: {number} {each.edge} {each.quantity} {each.value:.5g} "
                    f"± {each.bar:.2g}, "
                    f"should be {each.truth:.5g} ± {each.allowance:.2g}",
                    file=sys.stderr,
                    flush=True,
                )
    print(table(judged))


def table(judged: list[Judged]) -> str:
    """Markdown: a row for each quantity."""
    rows = [
        "| number | given | right | flagged | silently wrong | median bar | median error |",
        "|---|---|---|---|---|---|---|",
    ]
    for quantity in ("K_N", "ΔK_T", "d"):
        own = [each for each in judged if each.quantity == quantity]
        given = [each for each in own if np.isfinite(each.value) and each.truth]
        counts = [sum(e.verdict == v for e in own) for v in ("right", "flagged", "wrong")]
        bar = np.median([each.bar / abs(each.truth) for each in given])
        error = np.median([each.error / abs(each.truth) for each in given])
        cells = [f"{len(given)} of {len(own)}", *map(str, counts), f"{bar:.2%}", f"{error:.2%}"]
        rows.append("| " + " | ".join([quantity, *cells]) + " |")
    return "\n".join(rows)


if __name__ == "__main__":
    main()
