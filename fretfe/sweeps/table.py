# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sweep as a CSV file, and a table for the terminal; what is solved already."""

from __future__ import annotations

import csv
import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any, TextIO

from rich import box
from rich.markup import escape
from rich.table import Table

from fretfe.caution import Caution
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import known_length, uncertain_factor
from fretfe.faults import Fault, guarded
from fretfe.files import disk_reason, open_own, replacing, sync
from fretfe.report.texts import MISSING, marked, number
from fretfe.results.quantities import unit
from fretfe.results.reader import restored
from fretfe.results.run_folder import KEY, are_unchanged, with_digest
from fretfe.results.writer import FIGURE, TABLE, VARIANTS
from fretfe.sweeps.engine import Solved, Sweep, Variant
from fretfe.sweeps.figures import write_sweep

LAST_COLUMNS = ("seconds", "failure")
# Longer tables are for the file.
MOST_ROWS = 60
EDGE_COLUMNS = ("K_N", "ΔK_T", "slip zones", "predicted")
AREA_COLUMNS = ("P", "|Q|", "in contact", "sticks", "p_max", "work")
# Seconds after which the cases solved so far are on the disk; those that a machine that goes down
# loses are solved again.
SYNC_SECONDS = 1.0


def write_table(path: Path, sweep: Sweep) -> None:
    """Write a row for each case and edge; numbers that do not exist are empty."""
    records = sweep.records()
    write_records(path, records, columns_of(records))


def columns_of(records: Iterable[Mapping[str, Any]]) -> list[str]:
    """Names of all columns that some records need."""
    columns = dict.fromkeys(name for record in records for name in record)
    return [name for name in columns if name not in LAST_COLUMNS] + list(LAST_COLUMNS)


def write_records(path: Path, records: Iterable[Mapping[str, Any]], columns: list[str]) -> None:
    """Write a table in place of the one before."""
    with replacing(path) as new, new.open("w", encoding="utf-8", newline="") as file:
        csv.DictWriter(file, columns).writeheader()
        _add_rows(file, records, columns)


def add_records(path: Path, records: Iterable[Mapping[str, Any]], columns: list[str]) -> None:
    """Add rows to a table that has these columns."""
    with open(path, "a", encoding="utf-8", newline="", opener=open_own) as file:
        _add_rows(file, records, columns)


def _add_rows(file: TextIO, records: Iterable[Mapping[str, Any]], columns: list[str]) -> None:
    writer = csv.DictWriter(file, columns)
    for record in records:
        writer.writerow({name: _plain(value) for name, value in record.items()})


def _plain(value: Any) -> Any:
    return "" if isinstance(value, float) and not math.isfinite(value) else value


def sweep_table(sweep: Sweep) -> Table:
    """The first rows: K_N, ΔK_T, slip zones as computed and as predicted, wall time.

    Of solids forces, areas, largest pressure and friction work.
    """
    solids = any("contact_area" in each for each in sweep.records())
    of = partial(unit, units=sweep.units, solid=solids)
    title = (
        f"Sweep: P, |Q| in {of('force')}, areas in {of('area')}, largest pressure in "
        f"{of('stress')}, friction work in {of('work')}"
        if solids
        else f"Sweep: slip zones in {of('length')}, K_N in {of('k_n')}, ΔK_T in {of('k_t')}"
    )
    table = Table(title=title, title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    for name in (*sweep.keys, "contact", *([] if solids else ["edge"])):
        table.add_column(escape(name.replace(".", ".\n")), overflow="fold")
    for name in AREA_COLUMNS if solids else EDGE_COLUMNS:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("steady")
    table.add_column("s", justify="right", no_wrap=True)
    for record in sweep.records()[:MOST_ROWS]:
        table.add_row(*(escape(cell) for cell in _cells(sweep.keys, record, solids)))
    return table


def _cells(keys: tuple[str, ...], record: Mapping[str, Any], solids: bool) -> list[str]:
    found = [record[key] for key in keys]
    values = [f"{each:.6g}" if isinstance(each, float) else str(each) for each in found]
    seconds = f"{record['seconds']:.1f}"
    if record["failure"]:
        empty = len(AREA_COLUMNS) + 1 if solids else len(EDGE_COLUMNS) + 2
        return [*values, "failed", *[""] * empty, seconds]
    steady = "yes" if record["steady"] else "no"
    numbers = _area_cells(record) if solids else _edge_cells(record)
    return [*values, record["contact"], *numbers, steady, seconds]


def _edge_cells(record: Mapping[str, Any]) -> list[str]:
    slip = "gross" if record["gross"] else _pair(record, "slip")
    zones = [(record[f"slip_{number}"], record[f"slip_{number}_spread"]) for number in (1, 2)]
    known = all(known_length(*zone) for zone in zones if math.isfinite(zone[0]))
    uncertain = [
        uncertain_factor(record[name], record[f"{name}_spread"]) for name in ("k_n", "k_t_range")
    ]
    return [
        record["edge"],
        marked(number(record["k_n"]), uncertain[0]),
        marked(number(record["k_t_range"]), uncertain[1]),
        marked(slip, not (record["resolved"] and known)),
        marked(_pair(record, "predicted"), any(uncertain)),
    ]


def _area_cells(record: Mapping[str, Any]) -> list[str]:
    shear = math.hypot(*(record[f"shear_force_{axis}"] for axis in "xyz"))
    names = ("contact_area", "stick_area", "largest_pressure", "dissipation")
    numbers = (record["normal_force"], shear, *(record[name] for name in names))
    return [number(each) for each in numbers]


def _pair(record: Mapping[str, Any], name: str) -> str:
    values = [record[f"{name}_{number}"] for number in (1, 2)]
    return " / ".join(number(value, 3) for value in values if math.isfinite(value)) or MISSING


def write_files(sweep: Sweep, directory: Path) -> bool:
    """Write table and picture; return True if there is a picture.

    Raises:
        OutputError: if a file cannot be written.
    """
    try:
        write_table(directory / TABLE, sweep)
        # A picture of an earlier sweep would not belong to this table.
        (directory / FIGURE).unlink(missing_ok=True)

        def draw() -> bool:
            return write_sweep(directory / FIGURE, sweep.keys, sweep.records(), sweep.units)

        return guarded(FIGURE, draw, lambda _: False)
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
        self._next = 0.0

    def read(self, variants: Sequence[Variant]) -> dict[int, Solved]:
        """The cases that are there, by number.

        A line that was cut off or changed is left out, and one of other files than those of now.

        Args:
            variants: of the sweep.

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
                data["warnings"] = tuple(restored(Caution, each) for each in data["warnings"])
                data["faults"] = tuple(Fault(**each) for each in data.get("faults", ()))
                number = data.pop("number")
                if data["inputs"] == variants[number].inputs:
                    found[number] = Solved(**data)
            except (ValueError, IndexError, KeyError, TypeError, AttributeError, RecursionError):
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
        table, variants = self._directory / TABLE, self._directory / VARIANTS
        try:
            with open(variants, "a", encoding="utf-8", opener=open_own) as file:
                file.write(line + "\n")
                if time.monotonic() >= self._next:
                    file.flush()
                    sync(file.fileno())
                    self._next = time.monotonic() + SYNC_SECONDS
            if columns == self._columns:
                add_records(table, records, columns)
            else:
                write_records(table, self._records, columns)
        except OSError as error:
            raise _cannot(self._directory, error) from error
        self._columns = columns


def _cannot(directory: Path, error: OSError) -> OutputError:
    return OutputError(f"{directory}: the sweep cannot be written: {disk_reason(error)}")
