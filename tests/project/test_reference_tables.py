# SPDX-License-Identifier: LGPL-3.0-or-later
"""The reference tables are those that were made, of cases that can be read, and they converge."""

from __future__ import annotations

import csv
import json
import math
import runpy
from pathlib import Path

import pytest

from fretfe.case import load_case

ROOT = Path(__file__).parents[2]
TOOL = runpy.run_path(str(ROOT / "tools" / "reference_tables.py"))
FOLDER: Path = TOOL["FOLDER"]


def rows(name: str) -> list[dict[str, str]]:
    with (FOLDER / name).open(newline="") as file:
        return list(csv.DictReader(file))


def test_files_are_those_that_were_made() -> None:
    assert json.loads((FOLDER / "digests.json").read_text()) == TOOL["digests"](FOLDER)


def test_cases_are_those_of_the_tool() -> None:
    for name, case in TOOL["cases"]():
        stored = load_case(FOLDER / f"{name}.toml")
        assert stored.as_tables() == case.as_tables()


def test_columns_and_cases() -> None:
    edges, tractions = rows("edges.csv"), rows("tractions.csv")
    assert (list(edges[0]), list(tractions[0])) == (list(TOOL["EDGES"]), list(TOOL["TRACTIONS"]))
    names = [name for name, _ in TOOL["cases"]()]
    for table in (edges, tractions):
        assert list(dict.fromkeys(row["case"] for row in table)) == names
    # Both ends of two flanks, of the firtree of four.
    assert len(edges) == 3 * 4 + 8


@pytest.mark.parametrize("number", TOOL["NUMBERS"])
def test_both_meshes_agree_within_their_bars(number: str) -> None:
    """The coarse mesh has elements of twice the size; where it is too coarse it has no number."""
    ends = ("", "_spread", "_coarse", "_spread_coarse")
    for row in rows("edges.csv"):
        value, bar, coarse, other = (float(row[f"{number}{end}"]) for end in ends)
        assert 0 < bar < 0.5 * value, row
        assert not abs(coarse - value) > math.hypot(bar, other), row


def test_tractions_keep_the_law_of_friction() -> None:
    friction = {name: case.contacts for name, case in TOOL["cases"]()}
    for row in rows("tractions.csv"):
        f = friction[row["case"]][row["contact"]].friction
        assert isinstance(f, float)
        assert abs(float(row["q"])) <= 1.001 * f * float(row["p"]) + 1e-3


def test_calculix_finds_the_same_forces_and_tractions() -> None:
    """By a penalty on other elements: the page says by how much the programs differ."""
    found = dict(runpy.run_path(str(ROOT / "tools" / "calculix.py"))["differences"]())
    for name, difference in found.items():
        assert abs(difference) < (0.04 if "largest" in name or "range" in name else 0.01), name
    assert len(found) == 16
