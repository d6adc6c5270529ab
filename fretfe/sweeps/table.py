# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sweep as a CSV file and as a table for the terminal."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TextIO

from rich import box
from rich.markup import escape
from rich.table import Table

from fretfe.results.files import replacing
from fretfe.sweeps.engine import Sweep

LAST_COLUMNS = ("seconds", "failure")
# Longer tables are for the file.
MOST_ROWS = 60
EDGE_COLUMNS = ("K_N", "ΔK_T", "slip zones", "predicted")
AREA_COLUMNS = ("P", "|Q|", "in contact", "sticks", "p_max", "work")


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
    with path.open("a", encoding="utf-8", newline="") as file:
        _add_rows(file, records, columns)


def _add_rows(file: TextIO, records: Iterable[Mapping[str, Any]], columns: list[str]) -> None:
    writer = csv.DictWriter(file, columns)
    for record in records:
        writer.writerow({name: _plain(value) for name, value in record.items()})


def _plain(value: Any) -> Any:
    return "" if isinstance(value, float) and math.isnan(value) else value


def sweep_table(sweep: Sweep) -> Table:
    """The first rows: K_N, ΔK_T, slip zones as computed and as predicted, wall time.

    Of solids forces, areas, largest pressure and friction work.
    """
    units, solids = sweep.units, any("contact_area" in each for each in sweep.records())
    title = (
        f"Sweep: P, |Q| in {units.force}, areas in {units.length}², largest pressure in "
        f"{units.stress}, friction work in {units.force}·{units.length}"
        if solids
        else f"Sweep: slip zones in {units.length}, K_N in {units.stress}/√{units.length}, "
        f"ΔK_T in {units.stress}·√{units.length}"
    )
    table = Table(title=title, title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    for name in (*sweep.keys, "contact", *([] if solids else ["edge"])):
        table.add_column(escape(name), overflow="fold")
    for name in AREA_COLUMNS if solids else EDGE_COLUMNS:
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("steady")
    table.add_column("s", justify="right", no_wrap=True)
    for record in sweep.records()[:MOST_ROWS]:
        table.add_row(*(escape(cell) for cell in _cells(sweep.keys, record, solids)))
    return table


def _cells(keys: tuple[str, ...], record: Mapping[str, Any], solids: bool) -> list[str]:
    values = [_shown(record[key]) for key in keys]
    seconds = f"{record['seconds']:.1f}"
    if record["failure"]:
        empty = len(AREA_COLUMNS) + 1 if solids else len(EDGE_COLUMNS) + 2
        return [*values, "failed", *[""] * empty, seconds]
    steady = "yes" if record["steady"] else "no"
    numbers = _area_cells(record) if solids else _edge_cells(record)
    return [*values, record["contact"], *numbers, steady, seconds]


def _edge_cells(record: Mapping[str, Any]) -> list[str]:
    slip = "gross" if record["gross"] else _pair(record, "slip")
    return [
        record["edge"],
        _number(record["k_n"]),
        _number(record["k_t_range"]),
        slip if record["resolved"] else f"~{slip}",
        _pair(record, "predicted"),
    ]


def _area_cells(record: Mapping[str, Any]) -> list[str]:
    shear = math.hypot(*(record[f"shear_force_{axis}"] for axis in "xyz"))
    names = ("contact_area", "stick_area", "largest_pressure", "dissipation")
    numbers = (record["normal_force"], shear, *(record[name] for name in names))
    return [_number(each) for each in numbers]


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _pair(record: Mapping[str, Any], name: str) -> str:
    values = [record[f"{name}_{number}"] for number in (1, 2)]
    return " / ".join(_number(value, 3) for value in values if math.isfinite(value)) or "-"


def _number(value: float, digits: int = 4) -> str:
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"
