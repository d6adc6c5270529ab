# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a deck, as keywords of Abaqus and CalculiX have them."""

from __future__ import annotations

from pathlib import Path

import pytest
from cases.decks import solid_deck

from fretfe.errors import MeshError
from fretfe.mesh.inp import read_deck
from fretfe.mesh.inp_sectors import Sector, sectors

TIE = "*TIE, CYCLIC SYMMETRY, NAME={0}, POSITION TOLERANCE=0.1\n{0}1, {0}2\n"
MODEL = "*CYCLIC SYMMETRY MODEL, N=18, NGRAPH=18{}\n{}\n"
AXIS = "0., -5., 0., 0., -5., 2."


def found(folder: Path, lines: str, dimension: int = 3) -> list[Sector]:
    path = folder / "disc.inp"
    path.write_text(solid_deck() + lines)
    return sectors(read_deck(path), dimension)


def test_a_model_of_all_ties(tmp_path: Path) -> None:
    one, other = found(tmp_path, TIE.format("A") + TIE.format("B") + MODEL.format("", AXIS))
    assert (one.sides, other.sides) == (("A1", "A2"), ("B1", "B2"))
    assert one.count == other.count == 18
    assert one.centre.tolist() == [0.0, -5.0, 0.0] and one.axis.tolist() == [0.0, 0.0, 2.0]


def test_models_that_name_their_ties(tmp_path: Path) -> None:
    two = MODEL.format(", TIE=B", AXIS) + MODEL.format(", TIE=A", AXIS).replace("N=18", "N=9")
    each = found(tmp_path, TIE.format("A") + TIE.format("B") + two)
    assert {sector.sides[0]: sector.count for sector in each} == {"A1": 9, "B1": 18}


def test_a_plane_model_needs_a_centre_only(tmp_path: Path) -> None:
    (sector,) = found(tmp_path, TIE.format("A") + MODEL.format("", "1., 2."), dimension=2)
    assert sector.centre.tolist() == [1.0, 2.0, 0.0] and sector.axis.tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("lines", "dimension", "reason"),
    [
        (TIE.format("A"), 3, "expected one *CYCLIC SYMMETRY MODEL of this *TIE"),
        (MODEL.format("", AXIS), 3, "expected a *TIE with CYCLIC SYMMETRY, found none"),
        (TIE.format("A") + MODEL.format(", TIE=B", AXIS), 3, "called B, found none"),
        (TIE.format("A") + 2 * MODEL.format("", AXIS), 3, "CYCLIC SYMMETRY, found 2"),
        (TIE.format("A") + MODEL.format("", "1., 2."), 3, "two points on the axis, found 2"),
        (TIE.format("A") + MODEL.format("", "0,0,0,0,0,0"), 3, "two different points on the axis"),
        (TIE.format("A") + MODEL.format("", "0,0,0,1,0,0"), 2, "expected an axis along z"),
        (TIE.format("A") + MODEL.format("", AXIS).replace("N=18, ", ""), 3, "parameter N is"),
    ],
)  # fmt: skip
def test_what_is_not_understood(tmp_path: Path, lines: str, dimension: int, reason: str) -> None:
    with pytest.raises(MeshError) as caught:
        found(tmp_path, lines, dimension)
    assert reason in str(caught.value)
