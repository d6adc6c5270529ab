# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files of tests for `fretfe strength` that are damaged, hostile or of something else."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

from faults.fault import Fault, damaged
from faults.originals import TESTS_TEXT
from faults.results_of import OUTPUTS, RUNS, blocked, damage, with_runs

HEADER, *ROWS = TESTS_TEXT.splitlines()
COLUMNS = HEADER.split(",")


def _cell(column: int, text: str, row: int = 3) -> str:
    """The file with another text in one cell, the first column having number 0."""
    cells = ROWS[row].split(",")
    cells[column] = text
    return "\n".join([HEADER, *ROWS[:row], ",".join(cells), *ROWS[row + 1 :]]) + "\n"


def _column(column: int, text: str) -> str:
    """The file with the same text in all cells of a column."""
    rows = [row.split(",") for row in ROWS]
    for cells in rows:
        cells[column] = text
    return "\n".join([HEADER, *map(",".join, rows)]) + "\n"


def _named(column: int, name: str) -> str:
    names = [*COLUMNS]
    names[column] = name
    return "\n".join([",".join(names), *ROWS]) + "\n"


def _without(column: int) -> str:
    lines = [line.split(",") for line in (HEADER, *ROWS)]
    return "\n".join(",".join(cells[:column] + cells[column + 1 :]) for cells in lines) + "\n"


CELLS = {
    "text": "many", "empty": "", "nan": "nan", "inf": "inf", "minus": "-3", "overflow": "1e999",
    "huge": "1e31", "hex": "0x10", "Fortran": "1D3", "underscore": "1_000", "Arabic": "٣",
    "formula": "=1+1", "percent": "5%", "more than": ">1000",
}  # fmt: skip
REFUSED: dict[str, str | bytes] = {
    "empty": "",
    "blank lines": "\n\n \n",
    "one line": HEADER,
    "no header": "\n".join(ROWS),
    "header twice": "\n".join([HEADER, HEADER, *ROWS]),
    "longer rows": "\n".join([HEADER, *(row + ",7" for row in ROWS)]),
    "shorter rows": "\n".join([HEADER, *(row.rpartition(",")[0] for row in ROWS)]),
    "decimal commas": TESTS_TEXT.replace(".", ","),
    "UTF-16": TESTS_TEXT.encode("utf-16"),
    "latin 1": TESTS_TEXT.encode() + "§".encode("latin-1"),
    "NUL": TESTS_TEXT.encode() + b"\0",
    "quote": TESTS_TEXT + '1,2,"3\n',
    "long cell": _cell(2, "9" * 200_000),
    "results": '{"schema": {"name": "fretfe-results"}}',
    "tab in the header": TESTS_TEXT.replace(",", "\t", 3),
    "both kinds of factors": "\n".join(
        [HEADER + ",k_n_ratio,dk_t_ratio", *(row + ",1,1" for row in ROWS)]
    ),
    "ratios without a stress": TESTS_TEXT.replace("k_n [MPa/mm^0.5]", "k_n_ratio").replace(
        "dk_t [MPa*mm^0.5]", "dk_t_ratio"
    ),
    "life in thousands": _named(2, "life [1e3]"),
}
# Read, with a margin or the reason why there is none.
ACCEPTED: dict[str, str | bytes] = {
    "whole": TESTS_TEXT,
    "byte order mark": b"\xef\xbb\xbf" + TESTS_TEXT.encode(),
    "semicolons": TESTS_TEXT.replace(",", ";"),
    "semicolons and decimal commas": TESTS_TEXT.replace("^0.5", "^(1/2)")
    .replace(",", ";")
    .replace(".", ","),
    "tabs": TESTS_TEXT.replace(",", "\t"),
    "Windows": TESTS_TEXT.replace("\n", "\r\n"),
    "old Macintosh": TESTS_TEXT.replace("\n", "\r"),
    "capitals": TESTS_TEXT.replace("k_n", "K_N").replace("life", "Life"),
    "one test": "\n".join([HEADER, ROWS[0]]),
    "two tests": "\n".join([HEADER, *ROWS[:2]]),
    "the same test": "\n".join([HEADER, *ROWS[:1] * 20]),
    "run-outs alone": _column(3, "1"),
    "failures alone": _column(3, "0"),
    "one life": _column(2, "1000"),
    "lives of a cycle": _column(2, "1"),
    "lives of all ages": _column(2, "1e30"),
    "short lives": _column(2, "1e-30"),
    "one K_N": _column(0, "1237"),
    "one range": _column(1, "40"),
    "tiny factors": _column(0, "1e-30"),
    "huge factors": _column(1, "1e30"),
    "another friction": _column(4, "0.9"),
    "another material": _column(5, "70e3"),
    "lives that grow": "\n".join(
        [HEADER, *(",".join([*a.split(",")[:2], b.split(",")[2], *a.split(",")[3:]])
                   for a, b in zip(ROWS, ROWS[::-1], strict=True))]
    ),
    "one outlier": _cell(2, "1e30"),
    "a test of nothing": _cell(1, "1e-30"),
    "100 000 rows": "\n".join([HEADER, *ROWS * 4200]),
}  # fmt: skip
LIVES = (
    *("nan", "inf", "-inf", "0", "-1", "1e400", "many", "", "1e-400", "1,5", "0x10"),
    *("1e-300", "1e300"),
)


def faults() -> Iterator[Fault]:
    """All of them."""
    for name, content in ACCEPTED.items():
        yield Fault(f"tests.csv/{name}", _strength(), with_runs(_file(content)), False)
    for name, content in REFUSED.items():
        yield Fault(f"tests.csv/{name}", _strength(), with_runs(_file(content)), True)
    for seed in range(40):
        content = damaged(TESTS_TEXT.encode(), seed)
        yield Fault(f"tests.csv/damaged/{seed}", _strength(), with_runs(_file(content)))
    yield from _columns()
    for name, make in {
        "pipe": lambda here: os.mkfifo(here / "tests.csv"),
        "folder": lambda here: (here / "tests.csv").mkdir(),
        "device": lambda here: (here / "tests.csv").symlink_to("/dev/zero"),
        "missing": lambda here: None,
    }.items():
        yield Fault(f"tests.csv/{name}", _strength(), with_runs(make), True)
    whole = _file(TESTS_TEXT)
    for life in LIVES:
        command = ("strength", "tests.csv", "run", f"--life={life}", "--json")
        yield Fault(f"strength/life {life!r}", command, with_runs(whole), True)
    for life in ("1e-30", "1e30", "0.5"):
        command = ("strength", "tests.csv", "run", f"--life={life}", "--json")
        yield Fault(f"strength/life {life!r}", command, with_runs(whole), False)
    yield from _results(whole)
    into = ("strength", "tests.csv", "run", "--life", "4e5", "-o")
    for name, output, prepare in OUTPUTS:
        yield Fault(f"strength/into {name}", (*into, output), with_runs(whole, prepare), True)
    for name in ("strength.json", "strength.png"):
        prepare = blocked(name)
        yield Fault(f"strength/{name} is a folder", (*into, "out"), with_runs(whole, prepare), True)
    yield Fault("strength/into a folder", (*into, "out"), with_runs(whole), False)


def _strength(*results: str) -> tuple[str, ...]:
    return ("strength", "tests.csv", *(results or ("run",)), "--life", "4e5", "--json")


def _file(content: str | bytes) -> Callable[[Path], object]:
    data = content if isinstance(content, bytes) else content.encode()
    return lambda here: (here / "tests.csv").write_bytes(data)


def _columns() -> Iterator[Fault]:
    for number, column in enumerate(COLUMNS):
        name = column.split(" ")[0]
        for kind, text in CELLS.items():
            prepare = with_runs(_file(_cell(number, text)))
            yield Fault(f"tests.csv/{name}: {kind}", _strength(), prepare, True)
        if name not in ("runout", "poisson"):
            prepare = with_runs(_file(_cell(number, "0")))
            yield Fault(f"tests.csv/{name}: zero", _strength(), prepare, True)
        prepare = with_runs(_file(_without(number)))
        yield Fault(f"tests.csv/without {name}", _strength(), prepare, True)
        twice = "\n".join(f"{line},{line.split(',')[number]}" for line in (HEADER, *ROWS))
        yield Fault(f"tests.csv/two columns {name}", _strength(), with_runs(_file(twice)), True)
        if "[" in column:
            for unit in ("", " []", " [m]", " [Pa/m^0.5]", " [GPa]", " [ksi*in^0.5]", " [MPa]]"):
                prepare = with_runs(_file(_named(number, name + unit)))
                # A modulus may be in any unit of stress.
                refused = (name, unit) != ("young", " [GPa]")
                yield Fault(f"tests.csv/{name}{unit}", _strength(), prepare, refused)
    for text in ("2", "0.5", "yes", "true"):
        prepare = with_runs(_file(_cell(3, text)))
        yield Fault(f"tests.csv/runout {text}", _strength(), prepare, True)
    for text in ("0.5", "-1", "7"):
        prepare = with_runs(_file(_cell(6, text)))
        yield Fault(f"tests.csv/poisson {text}", _strength(), prepare, True)


def _results(whole: Callable[[Path], object]) -> Iterator[Fault]:
    """Components that are none, or of other units."""
    for name in RUNS:
        # A result whose factors are not known is listed with the reason.
        refused = name in ("metres", "solid")
        yield Fault(f"strength/of {name}", _strength(name), with_runs(whole), refused)
    for name in ("nothing", "tests.csv", "", ".", "/dev/null"):
        yield Fault(f"strength/of {name!r}", _strength(name), with_runs(whole), True)
    mixed = _strength("run", "metres")
    yield Fault("strength/of two units", mixed, with_runs(whole), True)
    yield Fault("strength/of one twice", _strength("run", "run"), with_runs(whole), None)
    for seed in range(12):
        yield Fault(
            f"strength/of damaged/{seed}", _strength(), with_runs(whole, damage("run", seed))
        )
