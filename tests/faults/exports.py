# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results to compare or export that are damaged or of something else, and tractions of others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from faults.fault import Fault, damaged
from faults.originals import FOREIGN_TEXT
from faults.results_of import OUTPUTS, RUNS, blocked, damage, with_runs

HEADER, *ROWS = FOREIGN_TEXT.splitlines()
CELLS = [row.split(",") for row in ROWS]
EDGES = ("edges", "foreign.csv", "--friction", "0.4", "--json")
# In place of a folder with results.
NO_RUNS = ("nothing", "run/results.json", "", ".", "/dev/null", "x" * 5000)
DECK = """*NODE
1, -2.0, -1.0
2, 2.0, -1.0
3, 2.0, 0.0
4, -2.0, 0.0
*ELEMENT, TYPE=CPE4, ELSET=BODY
1, 1, 2, 3, 4
*SURFACE, NAME=TOP
BODY, S3
"""
# What seems to be the list of an earlier export.
LISTINGS = {
    "paths": b"file\n../rig.csv\n/etc/passwd.csv\n..csv\n",
    "no listing": b"a,b\n1,2\n",
    "latin 1": "file\nPrüfung.csv\n".encode("latin-1"),
    "NUL": b"file\na\0.csv\n",
    "long": b"file\n" + b"x" * 200_000 + b".csv\n",
    "binary": bytes(range(256)) * 40,
    "empty": b"",
    "longer rows": b"file\na.csv,b,c\n",
}


def faults() -> Iterator[Fault]:
    """All of them."""
    yield from _compare()
    yield from _export()
    yield from _forces()
    for name, content in ACCEPTED.items():
        yield _foreign(name, content, (), False)
    for name, content in REFUSED.items():
        yield _foreign(name, content, (), True)
    for words in WORDS_REFUSED:
        yield _foreign(f"with {' '.join(words)}"[:60], FOREIGN_TEXT, words, True)
    for seed in range(40):
        yield _foreign(f"damaged/{seed}", damaged(FOREIGN_TEXT.encode(), seed), (), None)


def _compare() -> Iterator[Fault]:
    pairs = [("solid", "solid"), *((name, "run") for name in RUNS), *(("run", n) for n in NO_RUNS)]
    for one, other in pairs:
        refused = other in NO_RUNS or (one in ("solid", "metres") and other == "run")
        command = ("compare", one, other, "--json")
        yield Fault(f"compare/{one} with {other[:20]!r}", command, with_runs(), refused)
    into = ("compare", "run", "other_load", "-o")
    for seed in range(16):
        prepare = with_runs(damage("other_load", seed))
        yield Fault(f"compare/damaged/{seed}", (*into[:3], "--json"), prepare)
    for name, output, work in OUTPUTS:
        yield Fault(f"compare/into {name}", (*into, output), with_runs(work), True)
    for name in ("comparison.json", "differences.png", "histories.png"):
        prepare = with_runs(blocked(name))
        yield Fault(f"compare/{name} is a folder", (*into, "out"), prepare, True)


def _export() -> Iterator[Fault]:
    into = ("export", "run", "-o")
    for name in RUNS:
        yield Fault(f"export/{name}", ("export", name, "-o", "out"), with_runs(), False)
    for name in NO_RUNS:
        command = ("export", name, "-o", "out")
        yield Fault(f"export/{name[:20]!r}", command, with_runs(), True)
    for seed in range(16):
        prepare = with_runs(damage("run", seed))
        yield Fault(f"export/damaged/{seed}", (*into, "out"), prepare)
    for name, output, work in OUTPUTS:
        yield Fault(f"export/into {name}", (*into, output), with_runs(work), True)
    for name in ("loads.csv", "tractions.csv", "columns.csv"):
        prepare = with_runs(blocked(name))
        yield Fault(f"export/{name} is a folder", (*into, "out"), prepare, True)
    for name, listing in LISTINGS.items():

        def write(here: Path, listing: bytes = listing) -> None:
            (here / "out").mkdir()
            (here / "out" / "columns.csv").write_bytes(listing)

        yield Fault(f"export/columns.csv: {name}", (*into, "out"), with_runs(write), True)


def _forces() -> Iterator[Fault]:
    """Models that take forces: the block below the contact, y = 0 its upper side."""
    words = ("model.inp", "top", "--body", "lower", "-o", "out")
    whole = DECK.encode()
    decks: dict[str, tuple[bytes, bool | None]] = {
        "whole": (whole, False),
        "elsewhere": (whole.replace(b", 0.0\n", b", 7.0\n"), True),
        "without area": (whole.replace(b"2.0, 0.0", b"-2.0, 0.0"), True),
        "nan": (whole.replace(b"2.0, 0.0", b"nan, 0.0"), True),
        "tiny": (whole.replace(b"2.0, ", b"2e-30, "), True),
        "another surface": (whole.replace(b"NAME=TOP", b"NAME=FOOT"), True),
        "the other way": (whole.replace(b", -1.0", b", 1.0"), None),
        "empty": (b"", True),
    }
    decks |= {f"damaged/{seed}": (damaged(whole, seed), None) for seed in range(20)}
    for name, (data, refused) in decks.items():
        prepare = with_runs(_model(data))
        yield Fault(f"forces/{name}", ("forces", "run", *words), prepare, refused)
    for name in (*NO_RUNS, "solid"):
        command = ("forces", name, *words)
        yield Fault(f"forces/of {name[:20]!r}", command, with_runs(_model(whole)), True)
    for more in (("--time", "nan"), ("--time", "-1"), ("--factor", "nan"), ("--factor", "1e300"),
                 ("--contact", "x"), ("--body", "../x")):  # fmt: skip
        other = ("forces", "run", *words, *more)
        yield Fault(f"forces/{' '.join(more)}", other, with_runs(_model(whole)), True)
    for name, output, work in OUTPUTS:
        command = ("forces", "run", *words[:-1], output)
        yield Fault(f"forces/into {name}", command, with_runs(_model(whole), work), True)


def _model(data: bytes) -> Callable[[Path], object]:
    return lambda here: (here / "model.inp").write_bytes(data)


def _foreign(
    name: str, content: str | bytes, words: tuple[str, ...], refused: bool | None
) -> Fault:
    data = content if isinstance(content, bytes) else content.encode()

    def write(good: Path, here: Path) -> None:
        (here / "foreign.csv").write_bytes(data)

    return Fault(f"foreign.csv/{name}", (*EDGES, *words), write, refused)


def _lines(header: str, cells: list[list[str]]) -> str:
    return "\n".join([header, *map(",".join, cells)]) + "\n"


def _with(column: int, text: str, row: int = 20) -> str:
    cells = [[*each] for each in CELLS]
    cells[row][column] = text
    return _lines(HEADER, cells)


def _scaled(column: int, factor: float) -> str:
    cells = [[*each] for each in CELLS]
    for each in cells:
        each[column] = f"{factor * float(each[column]):.9g}"
    return _lines(HEADER, cells)


ACCEPTED: dict[str, str | bytes] = {
    "whole": FOREIGN_TEXT,
    "byte order mark": b"\xef\xbb\xbf" + FOREIGN_TEXT.encode(),
    "semicolons": FOREIGN_TEXT.replace(",", ";"),
    "semicolons and decimal commas": FOREIGN_TEXT.replace(",", ";").replace(".", ","),
    "tabs": FOREIGN_TEXT.replace(",", "\t"),
    "Windows": FOREIGN_TEXT.replace("\n", "\r\n"),
    "backwards": _lines(HEADER, CELLS[::-1]),
    "shuffled": _lines(HEADER, CELLS[::2] + CELLS[1::2]),
    "other columns with texts": _with(0, "PART-1-1.7"),
    "padded names": FOREIGN_TEXT.replace("CPRESS", " CPRESS "),
    "small letters": FOREIGN_TEXT.lower(),
}
REFUSED: dict[str, str | bytes] = {
    "empty": "",
    "one line": HEADER,
    "no header": "\n".join(ROWS),
    "one row": "\n".join([HEADER, ROWS[20]]),
    "no pressure": FOREIGN_TEXT.replace("CPRESS", "S11"),
    "no place": FOREIGN_TEXT.replace("COOR1", "U1"),
    "two pressures": _lines(HEADER + ",PRES", [[*each, "1"] for each in CELLS]),
    "pressure twice": _lines(HEADER + ",CPRESS", [[*each, "1"] for each in CELLS]),
    "normal stress": FOREIGN_TEXT.replace("CPRESS", "contact normal stress"),
    "negative": _scaled(3, -1.0),
    "nothing in contact": _scaled(3, 0.0),
    "shear across": _lines(HEADER, [[*each[:5], each[3]] for each in CELLS]),
    "the same node twice": "\n".join([HEADER, *ROWS, ROWS[20]]),
    "the same place": _scaled(1, 0.0),
    "tiny": _scaled(1, 1e-31),
    "text": _with(3, "No data"),
    "no number": _with(3, "nan"),
    "infinite": _with(3, "inf"),
    "empty cell": _with(1, ""),
    "huge": _with(3, "1e31"),
    "several frames": "\n".join([HEADER, *ROWS, *ROWS]),
    "longer rows": _lines(HEADER, [[*each, "1"] for each in CELLS]),
    "shorter rows": _lines(HEADER, [each[:4] for each in CELLS]),
    "decimal commas": FOREIGN_TEXT.replace(".", ","),
    "UTF-16": FOREIGN_TEXT.encode("utf-16"),
    "latin 1": FOREIGN_TEXT.encode() + "§".encode("latin-1"),
    "NUL": FOREIGN_TEXT.encode() + b"\0",
    "units of Ansys below the header": _lines(
        HEADER, [["", "mm", "mm", "MPa", "MPa", "MPa"], *CELLS]
    ),
}
WORDS_REFUSED = (
    ("--x", "nothing"), ("--p", "nothing"), ("--q", "nothing"), ("--slip", "nothing"),
    ("--x", ""), ("--p", ""), ("--q", ""), ("--slip", ""),
    ("--x", "CPRESS"), ("--p", "COOR1"), ("--q", "COOR1"), ("--q", "CPRESS"), ("--slip", "CPRESS"),
    ("--slip", "CSHEAR1"), ("--x", "CSHEAR1"), ("--x", "node"),
    ("--compression", "negative"), ("--compression", "up"), ("--compression", ""),
    ("--friction", "nan"), ("--friction", "inf"), ("--friction", "-1"), ("--friction", "0"),
    ("--friction", "1e400"), ("--friction", "a"), ("--p", "x" * 5000), ("--p", "[red]p[/red]"),
)  # fmt: skip
