# SPDX-License-Identifier: LGPL-3.0-or-later
"""Counted cycles of all plane edges under irregular loads as a CSV file: a row for each."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.results.model import Result

CYCLES = "cycles.csv"


def write_cycles(path: Path, result: Result) -> None:
    """Write the cycles; if the loads are regular there is no file."""
    edges = [edge for contact in result.contacts for edge in contact.stations]
    if not any(edge.cycles.irregular for edge in edges):
        path.unlink(missing_ok=True)
        return
    rows = cycle_records(result)
    first = next(rows)
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(first))
        writer.writeheader()
        for row in (first, *rows):
            writer.writerow(
                {k: "" if isinstance(v, float) and np.isnan(v) else v for k, v in row.items()}
            )


def cycle_records(result: Result) -> Iterator[dict[str, Any]]:
    """Texts and numbers of every counted cycle, by name; numbers that do not exist are NaN."""
    times = result.loads.times
    for contact in result.contacts:
        for edge in contact.stations:
            cycles = edge.cycles
            for number, (start, end) in enumerate(zip(cycles.start, cycles.end, strict=True)):
                yield {
                    "contact": contact.name,
                    "edge": edge.front,
                    "start": int(start),
                    "end": int(end),
                    "start_time": float(times[start]),
                    "end_time": float(times[end]),
                    "count": float(cycles.count[number]),
                    "k_t_start": float(edge.k_t[start]),
                    "k_t_end": float(edge.k_t[end]),
                    "k_t_range": float(cycles.k_t_range[number]),
                    "k_t_mean": float(cycles.k_t_mean[number]),
                    "effective_range": float(cycles.effective_range[number]),
                    "slip": float(cycles.slip[number]),
                    "worst": number == cycles.worst,
                }
