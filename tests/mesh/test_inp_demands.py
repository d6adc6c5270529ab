# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ties, sectors and rigid surfaces of a deck that a case must have, too."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from cases.decks import LOW, NODES, UP

from fretfe.case import Body, parse_case
from fretfe.case.tables import Part
from fretfe.errors import MeshError
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp_demands import NOTHING, Uses
from fretfe.mesh.inp_groups import read_inp
from fretfe.mesh.load import grouped_mesh

STEEL = Body(young=210e3, poisson=0.3)
# The rows are joined by a tie; the left and right sides of the lower one are those of a sector.
DECK = (
    f"*NODE\n{NODES}99, 1.5, 9.\n*ELEMENT, TYPE=CPE4, ELSET=LOW\n{LOW}"
    f"*ELEMENT, TYPE=CPE4, ELSET=UP\n{UP}*ELSET, ELSET=BOTH\nLOW, UP\n"
    "*SURFACE, NAME=FACE\nLOW, S3\n*SURFACE, NAME=PAD\nUP, S1\n*SURFACE, NAME=HEAD\nUP, S3\n"
    "*NSET, NSET=FACE_NODES\n5, 6, 7, 8\n*NSET, NSET=L\n1, 5\n*NSET, NSET=R\n4, 8\n"
    "*SURFACE, TYPE=NODE, NAME=S_L\nL\n*SURFACE, TYPE=NODE, NAME=S_R\nR\n"
)
TIE = "*TIE, NAME=T\nFACE, PAD\n"
CYCLIC = (
    "*TIE, CYCLIC SYMMETRY, NAME=C\nS_L, S_R\n"
    "*CYCLIC SYMMETRY MODEL, N=12, TIE=C\n0., -9., 0., 0., -9., 1.\n"
)
RIGID = "*RIGID BODY, NSET=R, REF NODE=99\n"


def read(
    folder: Path, text: str, uses: Uses = NOTHING, part: Part | None = None, bodies: str = "low up"
) -> RawMesh:
    (folder / "pad.inp").write_text(text)
    members = dict.fromkeys(bodies.split(), STEEL)
    return read_inp(folder / "pad.inp", members, ["head"], ({}, {}), uses, part)


@pytest.mark.parametrize("pair", [("FACE", "PAD"), ("PAD", "FACE"), ("FACE_NODES", "PAD")])
def test_a_tie_by_any_name_of_its_facets(tmp_path: Path, pair: tuple[str, str]) -> None:
    assert read(tmp_path, DECK + TIE, Uses([pair])).notes == ()


@pytest.mark.parametrize("sides", [("S_L", "S_R"), ("R", "L")])
def test_sectors_by_any_name_of_their_sides(tmp_path: Path, sides: tuple[str, str]) -> None:
    assert read(tmp_path, DECK + CYCLIC, Uses(sectors={sides: 12})).notes == ()


@pytest.mark.parametrize(
    ("lines", "uses", "reason"),
    [
        (TIE, Uses([("FACE", "HEAD")]), "*TIE of FACE and PAD, which the case does not tie"),
        ("*TIE, NAME=T\nNONE, NOR\n", NOTHING, "*TIE of NONE and NOR, which the case does not tie"),
        (CYCLIC, NOTHING, 'boundary2 = "S_R" and sectors = 12, found none'),
        (CYCLIC, Uses([("S_L", "S_R")]), "and sectors = 12, found none"),
        (CYCLIC, Uses(sectors={("S_L", "S_R"): 10}), "and sectors = 12, found sectors = 10"),
        (RIGID, NOTHING, "*RIGID BODY moves R as one rigid piece, which the case does not"),
    ],
)
def test_what_the_case_has_not(tmp_path: Path, lines: str, uses: Uses, reason: str) -> None:
    with pytest.raises(MeshError) as caught:
        read(tmp_path, DECK + lines, uses)
    assert reason in str(caught.value)


@pytest.mark.parametrize("lines", [TIE, CYCLIC, RIGID, "*ELEMENT, TYPE=SPRINGA\n90, 4, 8\n"])
def test_outside_of_a_part_nothing_is_asked(tmp_path: Path, lines: str) -> None:
    """A part around the upper left corner has neither the joint nor the right side."""
    part = Part(centre=(0.0, 2.0), radius=0.5)
    read(tmp_path, DECK + lines, part=part)
    with pytest.raises(MeshError):
        read(tmp_path, DECK + lines, part=Part(centre=(0.0, 2.0), radius=4.0))


def test_cut_boundaries_exist_after_the_cut_only(tmp_path: Path) -> None:
    (tmp_path / "pad.inp").write_text(DECK + RIGID)
    tables: dict[str, Any] = {
        "geometry": {"file": "pad.inp", "part": {"centre": [0.0, 1.0], "radius": 2.3}},
        "bodies": {"low": {"young": 1e5, "poisson": 0.3}, "up": {"young": 1e5, "poisson": 0.3}},
        "contacts": {"main": {"surface1": "PAD", "surface2": "FACE", "friction": 0.5}},
        "supports": {"cut": {"boundary": "low_cut", "fix": ["x", "y"]}},
        "loads": {"press": {"type": "displacement", "boundary": "up_cut", "direction": "y",
                            "history": [{"ramp": -1e-3, "until": 1.0, "steps": 1}]}},
    }  # fmt: skip
    mesh = grouped_mesh(parse_case(tables, tmp_path / "case.toml"))
    # two of three squares: the cut is the side between the second and the third
    assert {name: len(body.boundaries[f"{name}_cut"]) for name, body in mesh.bodies.items()} == {
        "low": 1, "up": 1,
    }  # fmt: skip
    del tables["geometry"]["part"]
    with pytest.raises(MeshError, match="element set LOW_CUT for the boundary 'low_cut'"):
        grouped_mesh(parse_case(tables, tmp_path / "case.toml"))


def test_elements_outside_of_a_part_need_no_body(tmp_path: Path) -> None:
    part = Part(centre=(0.0, 2.0), radius=0.5)
    assert read(tmp_path, DECK, part=part, bodies="up").bodies.keys() == {"up"}
    with pytest.raises(MeshError, match="3 of 6 are in none"):
        read(tmp_path, DECK, bodies="up")
