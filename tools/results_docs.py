# SPDX-License-Identifier: LGPL-3.0-or-later
"""Write what docs/results.md and docs/exchange.md list of quantities: keys, units, columns.

Units and new keys come from the declarations of `Contact` and `Station`; what a key means beyond
its declaration is written by hand and stays.

Run from anywhere: .venv/bin/python tools/results_docs.py
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from fretfe.case import Units
from fretfe.decision import stress_histories
from fretfe.evaluate.contacts import (
    Contact,
    CountedCycles,
    LocalProblem,
    SlipZone,
    Station,
    StationHistory,
    histories,
    quantities,
)
from fretfe.evaluate.headline import Headline, ToldZone, WorstPlace
from fretfe.exchange import export
from fretfe.results import quantities as declared
from fretfe.results.writer import CONTACT_KEYS

DOCS = Path(__file__).parents[1] / "docs"
OWNERS = {
    each.__name__: each
    for each in (
        *(Contact, CountedCycles, LocalProblem, SlipZone, Station),
        *(Headline, ToldZone, WorstPlace),
    )
}
COLUMNS = {
    "contacts.csv": (declared.CONTACT, *export.STATE, *declared.CONTACTS),
    "factors.csv": (*declared.STATION, *export.STATE, *declared.FACTORS),
    "edges.csv": declared.EDGES,
    "cycles.csv": (*declared.STATION, *declared.CYCLES),
    "stations.csv": declared.STATIONS,
    "tractions.csv": export.PLANE_TRACTIONS,
    "local.csv": export.PLANE_LOCAL,
    "stress.csv": export.STRESS,
    "edge_stress.csv": export.EDGE_STRESS,
    "edge_histories.csv": stress_histories.HISTORY_COLUMNS,
    "edge_parameters.csv": stress_histories.PARAMETER_COLUMNS,
}
HISTORIES = {Contact: histories(Contact), Station: histories(StationHistory)}
WORDS = Units(length="length", force="force", stress="stress", time="time")
# What stands between the two marks is written by this script.
_KEYS = re.compile(r"(<!-- keys of (\w+) -->\n)(.*?)(<!-- end -->\n)", re.DOTALL)
_ROW = re.compile(r"\| (.+?) \| ?(.*?) ?\| (.+) \|")
_COLUMNS = re.compile(r"(<!-- columns of ([\w.]+) -->).*?(<!-- end -->)")


def with_keys(page: str) -> str:
    """The page with the units of all keys, and a row for each key that has none."""
    return _KEYS.sub(lambda match: match[1] + _table(match[3], OWNERS[match[2]]) + match[4], page)


def with_columns(page: str) -> str:
    """The page with the columns of all declared."""
    return _COLUMNS.sub(
        lambda match: (
            match[1] + ", ".join(f"`{each.name}`" for each in COLUMNS[match[2]]) + match[3]
        ),
        page,
    )


def _table(text: str, owner: type) -> str:
    """The rows of a table: those of keys that are gone are left out, new keys come last."""
    known = CONTACT_KEYS if owner is Contact else [each.name for each in fields(owner)]
    head, border, *rows = text.splitlines()
    kept, listed = [], set[str]()
    for row in rows:
        if (cells := _ROW.fullmatch(row)) is None:
            raise ValueError(f"expected a row of three cells, found {row}")
        keys, told, meaning = cells.groups()
        names = re.findall(r"`(\w+)`", keys)
        if all(name in known for name in names):
            kept.append(_row(keys, _unit(owner, names) or told, meaning))
            listed |= set(names)
    known_numbers = quantities(owner)
    kept += [
        _row(f"`{name}`", _unit(owner, [name]), known_numbers[name].meaning)
        for name in known
        if name not in listed and name in known_numbers
    ]
    if missing := [name for name in known if name not in listed and name not in known_numbers]:
        raise ValueError(f"{owner.__name__}: expected a row or a declaration of {missing}")
    return "\n".join([head, border, *kept]) + "\n"


def _row(*cells: str) -> str:
    return "".join(f"| {each} " if each else "| " for each in cells) + "|"


def _unit(owner: type, names: list[str]) -> str:
    """Units of keys in words, T before those of histories; empty without, or if one is unknown."""
    known = quantities(owner)
    if not all(name in known for name in names):
        return ""
    units = dict.fromkeys(declared.unit(known[name].kind, WORDS, solid=True) for name in names)
    history = ["T"] if set(names) & set(HISTORIES.get(owner, [])) else []
    return ", ".join([*history, *(each or "–" for each in units)]) if any(units) else ""


PAGES: dict[str, Callable[[str], str]] = {"results.md": with_keys, "exchange.md": with_columns}


def main() -> None:
    """Write the pages."""
    for name, change in PAGES.items():
        path = DOCS / name
        path.write_text(change(path.read_text("utf-8")), "utf-8")


if __name__ == "__main__":
    main()
