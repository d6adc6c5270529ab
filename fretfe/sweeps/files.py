# SPDX-License-Identifier: LGPL-3.0-or-later
"""Table and picture of a sweep on disk, and the cases that are solved already."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fretfe.errors import OutputError
from fretfe.report.figures.sweep import write_sweep
from fretfe.results.digest import KEY, are_unchanged, with_digest
from fretfe.results.files import disk_reason
from fretfe.results.writer import FIGURE, TABLE, VARIANTS
from fretfe.sweeps.engine import Solved, Sweep
from fretfe.sweeps.table import add_records, columns_of, write_records, write_table


def write_files(sweep: Sweep, directory: Path) -> bool:
    """Write table and picture; return True if there is a picture.

    Raises:
        OutputError: if a file cannot be written.
    """
    try:
        write_table(directory / TABLE, sweep)
        # A picture of an earlier sweep would not belong to this table.
        (directory / FIGURE).unlink(missing_ok=True)
        return write_sweep(directory / FIGURE, sweep.keys, sweep.records(), sweep.units)
    except OSError as error:
        raise _cannot(directory, error) from error


class SolvedFile:
    """The cases of a sweep in the order in which they are solved; the table grows with them.

    Args:
        directory: folder of the sweep.
    """

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        self._records: list[dict[str, Any]] = []
        self._columns: list[str] = []

    def read(self) -> dict[int, Solved]:
        """The cases that are there, by number; a line that was cut off or changed is left out.

        Raises:
            OutputError: if the file cannot be written; so does `add`.
        """
        path = self._directory / VARIANTS
        lines = path.read_text("utf-8", "replace").splitlines() if path.is_file() else []
        found: dict[int, Solved] = {}
        for line in lines:
            try:
                data = json.loads(line)
                if not are_unchanged(data):
                    continue
                del data[KEY]
                data["edges"], data["notes"] = tuple(data["edges"]), tuple(data["notes"])
                number = data.pop("number")
                found[number] = Solved(**data)
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
                continue
        path.unlink(missing_ok=True)
        for number, solved in found.items():
            self.add(number, solved)
        return found

    def add(self, number: int, solved: Solved) -> None:
        """Add a case."""
        text = json.dumps({"number": number, **asdict(solved)}, default=lambda value: value.item())
        line = json.dumps(with_digest(json.loads(text)))
        records = solved.records()
        self._records += records
        columns = columns_of(self._records)
        table = self._directory / TABLE
        try:
            with (self._directory / VARIANTS).open("a", encoding="utf-8") as file:
                file.write(line + "\n")
            if columns == self._columns:
                add_records(table, records, columns)
            else:
                write_records(table, self._records, columns)
        except OSError as error:
            raise _cannot(self._directory, error) from error
        self._columns = columns


def _cannot(directory: Path, error: OSError) -> OutputError:
    return OutputError(f"{directory}: the sweep cannot be written: {disk_reason(error)}")
