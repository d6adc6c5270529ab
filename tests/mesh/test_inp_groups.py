# SPDX-License-Identifier: LGPL-3.0-or-later
"""Abaqus and CalculiX files: nothing that joins parts is passed over, and the rest is listed."""

from __future__ import annotations

from pathlib import Path

import pytest

from fretfe.case import Body
from fretfe.errors import MeshError
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp_groups import read_inp

# Two squares on each other, with nodes of their own; a line stands for the top.
DECK = """\
*HEADING
Prüfstand
*NODE
1, 0, 0
2, 1, 0
3, 1, 1
4, 0, 1
5, 0, 1
6, 1, 1
7, 1, 2
8, 0, 2
*ELEMENT, TYPE=CPE4, ELSET=LOWER
1, 1, 2, 3, 4
*ELEMENT, TYPE=CPE4, ELSET=UPPER
2, 5, 6, 7, 8
*ELEMENT, TYPE=T2D2, ELSET=TOP
3, 7, 8
*ELEMENT, TYPE=T2D2, ELSET=SIDE
4, 5, 8
"""
BODIES = {name: Body(young=210e3, poisson=0.3) for name in ("upper", "lower")}
EVERYTHING = """\
*MATERIAL, NAME=STEEL
*ELASTIC
210000., .3
*SOLID SECTION, ELSET=LOWER, MATERIAL=STEEL
*CONTACT PAIR, INTERACTION=I
TOP, SIDE
*STEP
*STATIC
*BOUNDARY
1, 1, 2
*BOUNDARY
2, 1, 2
*NODE PRINT, NSET=N
U
*END STEP
"""


def read(folder: Path, text: str) -> RawMesh:
    (folder / "pad.inp").write_text(text, encoding="utf-8")
    return read_inp(folder / "pad.inp", BODIES, ["top"], ({}, {}))


def refused(folder: Path, text: str) -> str:
    with pytest.raises(MeshError) as caught:
        read(folder, text)
    return str(caught.value)


def test_what_is_not_used_is_listed_once(tmp_path: Path) -> None:
    assert read(tmp_path, DECK).notes == ("pad.inp: elements that are not used: 1 T2D2",)
    keywords, _ = read(tmp_path, DECK + EVERYTHING).notes
    assert keywords == (
        "pad.inp: keywords that are not used: 2 *BOUNDARY, 1 *CONTACT PAIR, 1 *END STEP, "
        "1 *NODE PRINT, 1 *STATIC, 1 *STEP"
    )


@pytest.mark.parametrize(
    "lines",
    [
        "*TIE, NAME=T, CYCLIC SYMMETRY\nA, B\n",
        "*MPC\nTIE, 3, 5\n",
        "*EQUATION\n2\n3, 1, 1., 5, 1, -1.\n",
        "*EMBEDDED ELEMENT, HOST ELSET=LOWER\nUPPER\n",
        "*embeddedelement\nUPPER\n",
        "*RIGID BODY, ELSET=UPPER, REF NODE=8\n",
        "*EQUA\n2\n3, 1, 1., 5, 1, -1.\n",
        "*TI, NAME=T, CYCL\nA, B\n",
        "*Contact  Pair, INTER=I, TI\nA, B\n",
        "*Shell to Solid Coupling\nA, B\n",
        "*CONTACT PAIR, INTERACTION=I, TIED\nA, B\n",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n",
        "*PRE-TENSION SECTION, SURFACE=S, NODE=8\n",
    ],
)
def test_what_joins_parts_is_refused(tmp_path: Path, lines: str) -> None:
    message = refused(tmp_path, DECK + lines)
    keyword = lines.partition("\n")[0].partition(",")[0].upper()
    line = len(DECK.splitlines()) + 1
    assert f"pad.inp, line {line}: {' '.join(keyword.split())}" in message
    message = message.replace(" with CYCLIC SYMMETRY", "")
    assert "is not supported; it joins nodes or parts, which would come apart here" in message


@pytest.mark.parametrize(
    "lines",
    [
        "*COUPLING, REF NODE=8, SURFACE=S, CONSTRAINT NAME=C\n*KINEMATIC\n",
        "*COUPL, REF=8, SURF=S\n",
        "*DISTRIBUTING COUPLING, ELSET=E\n8, 1.\n",
    ],
)
def test_reference_nodes_become_platens(tmp_path: Path, lines: str) -> None:
    """Nothing is joined by the node of a load: the case has a type of load for it."""
    message = refused(tmp_path, DECK + lines)
    assert "is not supported; it moves a surface with a reference node: delete it" in message
    assert "a load of type platen" in message and "come apart" not in message


@pytest.mark.parametrize("kind", ["SPRINGA", "CONN2D2", "COH2D4", "GAPUNI", "CINPE4", "DASHPOTA"])
def test_elements_that_join_parts_are_refused(tmp_path: Path, kind: str) -> None:
    message = refused(tmp_path, DECK + f"*ELEMENT, TYPE={kind}, ELSET=E\n9, 3, 6\n")
    assert f"element 9 is of type {kind}, which is not supported" in message


def test_bodies_of_lines_and_masses_are_no_joints(tmp_path: Path) -> None:
    assert "1 MASS" in read(tmp_path, DECK + "*ELEMENT, TYPE=MASS, ELSET=M\n9, 3\n").notes[0]


def test_names_that_are_not_text(tmp_path: Path) -> None:
    path = tmp_path / "pad.inp"
    path.write_bytes(DECK.encode("latin-1"))
    assert read_inp(path, BODIES, ["top"], ({}, {})).bodies.keys() == {"upper", "lower"}
    path.write_bytes(DECK.encode() + b"*NSET, NSET=Fl\xe4che\n1\n")
    with pytest.raises(MeshError, match=r"cannot read \*NSET: expected UTF-8 text"):
        read_inp(path, BODIES, ["top"], ({}, {}))
