# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write the table of measured differences in docs/verify.md.

Run from anywhere: .venv/bin/fretfe verify --json | .venv/bin/python tools/verify_docs.py
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[1] / "docs" / "verify.md"
BACKENDS = ("halfplane", "fem")
HEADER = f"| benchmark | {' | '.join(BACKENDS)} |"
# What stands between the two marks is written by this script.
_TABLE = re.compile(r"(<!-- measured differences -->\n\n).*?(\n<!-- end -->\n)", re.DOTALL)
# Smaller differences are round-off.
SMALLEST = 1e-12

Cell = tuple[float, float]


def largest_differences(
    rows: Iterable[Mapping[str, Any]],
) -> dict[tuple[str, str], dict[str, Cell]]:
    """Largest difference and tolerance by benchmark and quantity, and by backend.

    Args:
        rows: those of `fretfe verify --json`; rows without a comparison do not count.
    """
    found: dict[tuple[str, str], dict[str, Cell]] = {}
    for row in rows:
        if row["difference"] is not None:
            line = found.setdefault((row["benchmark"], _both_edges(row["quantity"])), {})
            difference, tolerance = line.get(row["backend"], (0.0, 0.0))
            line[row["backend"]] = (
                max(difference, abs(row["difference"])),
                max(tolerance, row["tolerance"]),
            )
    return found


def _both_edges(quantity: str) -> str:
    """The name of a quantity without the edge, or the place, that it belongs to."""
    if quantity in ("left edge", "right edge"):
        return "positions of the edges"
    if quantity.startswith("permanent stick"):
        return "border of the permanent stick zone"
    if quantity.startswith("q at "):
        return "q at five places"
    return re.sub(r" (left|right)$", "", quantity)


def table(differences: Mapping[tuple[str, str], Mapping[str, Cell]]) -> str:
    """The table in Markdown: of each benchmark the quantity that takes most of its tolerance."""
    found: dict[str, dict[str, dict[str, Cell]]] = {}
    for (benchmark, quantity), line in differences.items():
        for backend, cell in line.items():
            found.setdefault(benchmark, {}).setdefault(backend, {})[quantity] = cell
    lines = [HEADER, "|---" * (1 + len(BACKENDS)) + "|"]
    for benchmark, own in found.items():
        cells = [_largest(own.get(backend, {})) for backend in BACKENDS]
        lines.append(f"| {benchmark} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _largest(cells: Mapping[str, Cell]) -> str:
    if not cells:
        return "–"
    quantity, (difference, tolerance) = max(cells.items(), key=lambda each: each[1][0] / each[1][1])
    shown = f"< {SMALLEST:.0e}" if difference < SMALLEST else f"{difference:.1e}"
    return f"{quantity}: {shown} ({tolerance:.1e})".replace("e-0", "e-")


def main() -> None:
    """Put the rows on standard input into the page."""
    new = table(largest_differences(json.load(sys.stdin)["rows"]))
    page = _TABLE.sub(lambda match: match[1] + new + match[2], PAGE.read_text("utf-8"))
    PAGE.write_text(page, "utf-8")


if __name__ == "__main__":
    main()
