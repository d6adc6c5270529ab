# SPDX-License-Identifier: LGPL-3.0-or-later
"""A comparison of two results as JSON and as figures in a folder."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from fretfe.errors import OutputError
from fretfe.exchange.comparison import Comparison
from fretfe.exchange.figures import FIGURES
from fretfe.results.files import disk_reason, replace_text
from fretfe.results.writer import prepare_other

SCHEMA = {"name": "fretfe-comparison", "version": 1}
COMPARISON = "comparison.json"


def comparison_numbers(comparison: Comparison) -> dict[str, Any]:
    """The comparison without its curves, in the types of JSON; null for what is unknown."""
    return {
        "schema": SCHEMA,
        "labels": list(comparison.labels),
        "contacts": [list(pair) for pair in comparison.contacts],
        "quantities": [_plain(record) for record in comparison.records()],
        "tractions": [
            _plain(
                {
                    "contact": each.contact,
                    "extreme": each.extreme,
                    "first_time": each.first.time,
                    "second_time": each.second.time,
                    "pressure_difference": each.pressure_difference,
                    "shear_difference": each.shear_difference,
                }
            )
            for each in comparison.tractions
        ],
        "histories": [
            _plain(
                {
                    "contact": each.contact,
                    "edge": each.edge,
                    "quantity": each.quantity,
                    "unit": each.unit,
                    "common": each.common,
                    "difference": each.difference,
                }
            )
            for each in comparison.histories
        ],
        "notes": list(comparison.notes),
    }


def write_comparison(comparison: Comparison, folder: Path) -> tuple[Path, ...]:
    """Write `comparison.json` and the figures.

    Args:
        comparison: of two results.
        folder: for the files; made if missing. Figures of an earlier comparison are replaced.

    Returns:
        The files.

    Raises:
        CaseError: if the folder holds results of a run.
        OutputError: if a file cannot be written.
    """
    prepare_other(folder)
    text = json.dumps(comparison_numbers(comparison), indent=1, allow_nan=False) + "\n"
    files = [folder / COMPARISON]
    try:
        replace_text(files[0], text)
        for name, draw in FIGURES.items():
            path = folder / name
            # A figure of an earlier comparison would not belong to these numbers.
            path.unlink(missing_ok=True)
            if draw(comparison, path):
                files.append(path)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the comparison: {disk_reason(error)}") from error
    return tuple(files)


def _plain(record: dict[str, Any]) -> dict[str, Any]:
    return {name: _number(value) for name, value in record.items()}


def _number(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
