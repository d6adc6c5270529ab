# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows of decks for nodes and sides that no surface or set names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cases.decks import solid_deck
from mesh.test_inp_steps import PAIR, proposed, step

from fretfe.case import parse_case
from fretfe.mesh.inp import read_deck
from fretfe.mesh.inp_groups import Groups, supported_cells
from fretfe.surface.checks import load_mesh

# The four nodes of the foot, one after the other, and those of the crest.
FOOT = "*BOUNDARY\n" + "".join(f"{node}, 1, 2\n" for node in (1, 2, 3, 4))
CREST = ((25, 0.5), (26, 1.0), (27, 1.0), (28, 0.5))


@pytest.mark.parametrize(
    ("lines", "table"),
    [
        # as an even traction
        (step("*CLOAD", *(f"{node}, 2, {-force}" for node, force in CREST)),
         {"type": "force", "boundary": "CLOAD_1", "direction": "y", "value": -3.0}),
        # in two rows, one of them for a set that is no boundary
        ("*NSET, NSET=ENDS\n25, 28\n" + step("*CLOAD", "ENDS, 1, 0.5", "26, 1, 1.", "27, 1, 1."),
         {"type": "force", "boundary": "CLOAD_1", "direction": "x", "value": 3.0}),
        (step("*DLOAD", "21, P3, 7.", "22, P3, 7.", "23, P3, 7."),
         {"type": "traction", "boundary": "HEAD", "direction": "normal", "value": -7.0}),
        (step("*DLOAD", "21, P3, 7.", "22, P3, 7."),
         {"type": "traction", "boundary": "DLOAD_1", "direction": "normal", "value": -7.0}),
    ],
)  # fmt: skip
def test_loads_without_a_name(tmp_path: Path, lines: str, table: dict[str, Any]) -> None:
    tables, lacks = proposed(tmp_path, PAIR + FOOT + lines)
    assert lacks == []
    assert tables["supports"] == {"boundary_1": {"boundary": "BOUNDARY_1", "fix": ["x", "y"]}}
    (load,) = tables["loads"].values()
    assert {**load, "value": load["history"][0]["ramp"]} == {**table, "history": load["history"]}
    mesh = load_mesh(parse_case(tables, tmp_path / "pad.toml"))
    own = mesh.bodies["up"].points[mesh.bodies["up"].boundaries[table["boundary"]]]
    assert own[..., 1].min() == own[..., 1].max() == 2.0
    assert own[..., 0].max() == (2.0 if table["boundary"] == "DLOAD_1" else 3.0)


def test_what_is_no_surface_stays_as_it_is(tmp_path: Path) -> None:
    """Sides inside, and a lone node."""
    lines = "*BOUNDARY\n26, 1\n" + step("*DLOAD", "21, P2, 7.")
    tables, lacks = proposed(tmp_path, PAIR + FOOT + lines)
    assert len(lacks) == 2 and "26, 1: single nodes are neither held" in lacks[0]
    assert "loads" not in tables and tables["supports"].keys() == {"boundary_1"}


def test_forces_that_turn_the_body_are_no_even_traction(tmp_path: Path) -> None:
    lines = step("*CLOAD", *(f"{node}, 2, {node}." for node, _ in CREST))
    tables, lacks = proposed(tmp_path, PAIR + FOOT + lines)
    assert "loads" not in tables
    assert "25, 2, 25. and 3 more: single nodes are neither held nor loaded" in lacks[0]


def test_nodes_of_no_element_are_left_out(tmp_path: Path) -> None:
    more = "*NODE\n77, 9., 9.\n*NSET, NSET=BASE\n1, 2, 3, 4, 77\n*BOUNDARY\nBASE, 1, 2\n"
    tables, lacks = proposed(tmp_path, PAIR + more)
    assert lacks == [] and tables["supports"]["boundary_1"]["fix"] == ["x", "y"]


def test_pieces_and_sheets_that_are_held_along_z(tmp_path: Path) -> None:
    """A boundary is on one body; of a sheet the faces, not the rim."""
    path = tmp_path / "sheets.inp"
    every = [*range(1, 9), *range(11, 19)]
    path.write_text(solid_deck() + "*BOUNDARY\n" + "".join(f"{node}, 3\n" for node in every))
    deck = read_deck(path)
    Groups(path, deck, 3, [[*supported_cells(path, deck, 3).items()]])
    assert deck.analysis[0].rows == [["BOUNDARY_1", "3", "3", ""], ["BOUNDARY_2", "3", "3", ""]]
    assert deck.surfaces["BOUNDARY_1"] == [(1, 1), (1, 2)] and deck.unnamed["BOUNDARY_2"] == 8
