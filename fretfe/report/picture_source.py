# SPDX-License-Identifier: LGPL-3.0-or-later
"""A results folder with fields, as pictures of stress need it. Needs PyVista."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fretfe._typing import Array
from fretfe.report.field_files import BodyField, field_times, find_time, read_body
from fretfe.report.picture_texts import time_text
from fretfe.results.model import Result
from fretfe.results.reader import load_result, read_numbers
from fretfe.results.writer import FIELDS


@dataclass(frozen=True)
class Source:
    """A results folder with fields.

    Attributes:
        folder: where they are.
        numbers: contents of `results.json`.
        result: of the run.
        times: of the fields.
    """

    folder: Path
    numbers: Mapping[str, Any]
    result: Result
    times: Array
    _read: dict[int, dict[str, BodyField]] = field(default_factory=dict)

    def available(self, states: Sequence[int]) -> list[int]:
        """Those of the states whose fields are there."""
        return [state for state in states if self._number(state) is not None]

    def bodies(self, state: int) -> dict[str, BodyField]:
        """Fields of all bodies at a state, which must be there."""
        if state not in self._read:
            number = self._number(state)
            assert number is not None
            self._read[state] = {
                name: read_body(self.folder / FIELDS, name, number, self._poisson(name))
                for name in self.result.bodies
            }
        return self._read[state]

    def forget(self) -> None:
        """Give the memory of all fields back."""
        self._read.clear()

    def when(self, state: int) -> str:
        """The time of a state, with its unit."""
        return time_text(self.numbers, state)

    def _number(self, state: int) -> int | None:
        return find_time(self.times, self.numbers["times"][state])

    def _poisson(self, body: str) -> float | None:
        case = self.numbers["case"]
        if case.get("model", {}).get("plane", "strain") == "stress":
            return None
        return float(case["bodies"][body]["poisson"])


def open_source(directory: Path) -> Source:
    """The results of a run.

    Raises:
        OutputError: if they are missing.
    """
    result = load_result(directory)
    times = field_times(directory / FIELDS, list(result.bodies))
    return Source(directory, read_numbers(directory), result, times)
