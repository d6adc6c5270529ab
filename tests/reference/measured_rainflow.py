# SPDX-License-Identifier: LGPL-3.0-or-later
"""Make tests/data/rainflow.json: 200 random histories, and what two packages count in them.

    pip install rainflow==3.2.0 fatpack==0.7.8
    PYTHONPATH=tests python -m reference.measured_rainflow

`rainflow` counts a history as section 5.4.4 of ASTM E1049-85 has it. `fatpack` counts by four
points; what a fourth repetition of a history adds to three are the cycles of the repeated one. The
values are whole numbers, in half of the histories few different ones: plateaus and equal ranges.
"""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

TARGET = Path(__file__).parents[1] / "data" / "rainflow.json"


def turning_points(history: np.ndarray) -> np.ndarray:
    """First and last value, and all peaks and valleys."""
    values = history[np.append(True, np.diff(history) != 0)]
    turns = np.flatnonzero(np.diff(np.sign(np.diff(values)))) + 1
    return values[[0, *turns, len(values) - 1]]


def ranges(pairs: list[list[float]]) -> list[int]:
    """Ranges of pairs of reversals."""
    return [int(abs(first - second)) for first, second in pairs]


def main() -> None:
    """Count, and write the file."""
    import fatpack  # type: ignore[import-not-found]
    import rainflow  # type: ignore[import-not-found]

    random = np.random.default_rng(19)
    rows: list[dict[str, Any]] = []
    for number in range(200):
        largest = 6 if number % 2 else 99
        history = random.integers(-largest, largest + 1, random.integers(4, 40)).astype(float)
        turns = [turning_points(np.tile(history, count)) for count in (3, 4)]
        before, after = (Counter(ranges(fatpack.find_rainflow_cycles(each)[0])) for each in turns)
        rows.append(
            {
                "history": history.astype(int).tolist(),
                "counted": sorted([*each[:3]] for each in rainflow.extract_cycles(history)),
                "repeated": sorted((after - before).elements()),
            }
        )
    lines = ",\n".join(json.dumps(row, separators=(",", ":")) for row in rows)
    TARGET.write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
