# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows that spreadsheets, programs and people put around the header of a table."""

from __future__ import annotations

from pathlib import Path

import pytest

from fretfe.errors import CaseError
from fretfe.loads import csv_file
from fretfe.loads.csv_file import is_unit, read_columns, read_table

ROWS = "0,1.5\n1,2.5\n"


@pytest.mark.parametrize("large", [False, True], ids=["by cells", "at once"])
@pytest.mark.parametrize(
    ("text", "units"),
    [
        (f"# own export, mm and MPa\nt,p\n{ROWS}", ()),
        (f'"# own, quoted"\n\nt,p\n# more\n{ROWS}# end\n', ()),
        (f"t,p\ns,MPa\n{ROWS}", ("s", "MPa")),
        (f"t,p\n[s],(N/mm^2)\n{ROWS}", ("[s]", "(N/mm^2)")),
        (f"# t,p\n{ROWS}", ()),
        ("# t p\n0 1.5\n1 2.5\n", ()),
        (f"#,t,p\n{ROWS.replace('0,', '7,0,').replace('1,2', '8,1,2')}", ()),
        ("sep=;\nt;p\n0;1,5\n1;2,5\n", ()),
        ('"sep=;"\r\nt;p\r\ns;MPa\r\n0;1,5\r\n1;2,5\r\n', ("s", "MPa")),
        (f"sep=,\nt,p\n{ROWS}", ()),
        (f"\N{BYTE ORDER MARK}sep=\t\nt\tp\n{ROWS.replace(',', chr(9))}", ()),
    ],
)
def test_rows_around_the_header(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, units: tuple[str, ...], large: bool
) -> None:
    monkeypatch.setattr(csv_file, "LARGE", 0 if large else 1_000_000)
    path = tmp_path / "table.csv"
    path.write_bytes(text.encode("utf-8"))
    table = read_table(path, ["t", "p"])
    assert table.columns["t"].tolist() == [0, 1] and table.columns["p"].tolist() == [1.5, 2.5]
    lines = path.read_text("utf-8-sig").splitlines()
    assert all("5" in lines[line - 1] for line in table.lines) and table.units == units
    times, values = read_columns(path, "t", "p", {})
    assert (times.tolist(), values.tolist()) == ([0, 1], [1.5, 2.5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,p\nlow,high\n0,1\n", "line 2, column 't': expected a finite number, found 'low'"),
        ("t,p\n1,-\n0,1\n", "line 2, column 'p': expected a finite number, found '-'"),
        ("t,p\ns,MPa\n", "expected rows of numbers below the header, found none"),
        ("t,p\ns,MPa\ns,MPa\n0,1\n", "line 3, column 't': expected a finite number, found 's'"),
        ("sep=|\nt|p\n0|1\n", "line 1: expected a separator of ',', ';', 'tab', 'space', found"),
        ("# note\n0,1\n", "expected one column 't', found '0', '1'"),
        ("# only a comment\n", "expected a header row with the column names, found an empty file"),
    ],
)
def test_rows_that_are_neither_units_nor_numbers(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(text, "utf-8")
    with pytest.raises(CaseError) as caught:
        read_table(path, ["t", "p"])
    assert message in str(caught.value)


@pytest.mark.parametrize("text", ["mm", "[MPa]", "N/mm^2", "N/mm2", "N mm", "s^-1", "°C", "µm"])
def test_units(text: str) -> None:
    assert is_unit(text)


@pytest.mark.parametrize("text", ["", "left", "x", "p max", "1.5", "nan", "mm left", "10"])
def test_no_units(text: str) -> None:
    assert not is_unit(text)


@pytest.mark.parametrize(
    ("text", "separator", "message"),
    [
        ("t;Q\n0;0\n", None, "one column 'time', found 't', 'Q', with the separator ';'"),
        ("\ufefft;Q\n0;0\n", None, "found 't', 'Q', with the separator ';'"),
        ('"t";"Q"\n0;0\n', None, "found 't', 'Q', with the separator ';'"),
        ("t\tQ\n0\t0\n", None, "found 't', 'Q', with the separator 'tab'"),
        ("t Q\n0 0\n", None, "found 't', 'Q', with the separator 'space'"),
        ("t [s];Q [kN]\n0;0\n", None, "found 't [s]', 'Q', with the separator ';'"),
        ("t|Q\n0|0\n", None, "found 't|Q', with the separator ','"),
        ("time;Q\n0;0\n", ",", "found 'time;Q', with the separator ','; it has one with ';'"),
        ("time;Q\n0,0\n", None, "line 2: expected 2 cells with the separator ';', as in"),
        ("time,Q\n0;0\n", None, "with the separator ',', as in the header, found '0;0'"),
        ("time,Q\n0,0\n1\n", None, "line 3, column 'Q': expected a finite number, found an"),
    ],
)  # fmt: skip
def test_refusals_name_the_separator(
    tmp_path: Path, text: str, separator: str | None, message: str
) -> None:
    path = tmp_path / "loads.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(CaseError) as caught:
        read_columns(path, "time", "Q", {}, separator)
    assert message in str(caught.value)
