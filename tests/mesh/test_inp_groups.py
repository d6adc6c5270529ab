# SPDX-License-Identifier: LGPL-3.0-or-later
"""Abaqus and CalculiX files: nothing that joins parts is passed over, and the rest is listed."""

from __future__ import annotations

from pathlib import Path

import pytest

from fretfe.case import Body
from fretfe.errors import MeshError
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp_demands import Uses
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
    assert keywords == ("pad.inp: keywords that are not used: 1 *NODE PRINT")


@pytest.mark.parametrize(
    "lines",
    [
        "*MPC\nTIE, 3, 5\n",
        "*EQUATION\n2\n3, 1, 1., 5, 1, -1.\n",
        "*EMBEDDED ELEMENT, HOST ELSET=LOWER\nUPPER\n",
        "*embeddedelement\nUPPER\n",
        "*EQUA\n2\n3, 1, 1., 5, 1, -1.\n",
        "*Contact  Pair, INTER=I, TI\nA, B\n",
        "*Shell to Solid Coupling\nA, B\n",
        "*CONTACT PAIR, INTERACTION=I, TIED\nA, B\n",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n",
    ],
)
def test_what_joins_parts_is_refused(tmp_path: Path, lines: str) -> None:
    message = refused(tmp_path, DECK + lines)
    keyword = lines.partition("\n")[0].partition(",")[0].upper()
    line = len(DECK.splitlines()) + 1
    assert f"pad.inp, line {line}: {' '.join(keyword.split())}" in message
    assert "is not supported; it joins nodes or parts, which would come apart here" in message


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("*USER ELEMENT, TYPE=U1, NODES=2, COORDINATES=2\n1, 2\n", "its stiffness is not that of"),
        ("*SUBSTRUCTURE PROPERTY, ELSET=E\n", "its stiffness is not that of any element of a body"),
        ("*SPRING, ELSET=E\n1, 1\n1000.\n", "put a support or a force in their place"),
        ("*RIGID SURFACE, TYPE=SEGMENTS, NAME=R\n", "rigid bodies need a mesh"),
        ("*DISPLAY BODY, INSTANCE=I\n", "leave its instance out"),
    ],
)
def test_what_else_a_model_would_lack_is_refused_with_its_reason(
    tmp_path: Path, lines: str, reason: str
) -> None:
    message = refused(tmp_path, DECK + lines)
    assert reason in message and "joins nodes" not in message


def test_nodes_of_instances_that_are_not_there(tmp_path: Path) -> None:
    for lines in ("*ELEMENT, TYPE=CPE4, ELSET=UPPER\n9, A.5, 6, 7, 8\n", "*NODE\nA.5, 1., 1.\n"):
        assert "there is no instance 'A'" in refused(tmp_path, DECK + lines)
    # a set that waits for one that comes later
    late = "*NSET, NSET=N\nLATER, 1x\n*NSET, NSET=LATER\n1, 2\n"
    assert "sets and surfaces that cannot be read" in read(tmp_path, DECK + late).notes[0]


def test_pretension_is_refused(tmp_path: Path) -> None:
    message = refused(tmp_path, DECK + "*PRE-TENSION SECTION, SURFACE=S, NODE=8\n")
    assert "tighten the bolt by a load of type pretension of that tie" in message


REFERENCE = "*NODE, NSET=RP\n99, 0., 5.\n"


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("*COUPLING, REF NODE=99, SURFACE=TOP\n*KINEMATIC\n",
         "moves TOP as one rigid piece, which the case does not: expected a load of type platen "
         'with boundary = "TOP", or a support'),
        ("*COUPL, REF=RP, SURF=TOP\n", "expected *KINEMATIC or *DISTRIBUTING after *COUPL"),
        ("*RIGID BODY, NSET=TOP, REF NODE=99\n", "moves TOP as one rigid piece"),
        ("*RIGID BODY, ELSET=UPPER, REF NODE=99\n", "a rigid part of a body is not supported"),
        ("*RIGID BODY, NSET=TOP, REF NODE=8\n",
         "the reference node 8 is a node of a body, which would come apart from TOP here"),
        ("*KINEMATIC COUPLING, REF NODE=99\nTOP, 1, 2\nLOW, 1, 2\n", "expected one set or surface"),
        ("*DISTRIBUTING COUPLING, ELSET=UPPER\nTOP, 1.\n", "is a node of a body"),
        ("*RIGID BODY, NSET=TOP, REF NODE=99\n*RIGID BODY, NSET=LOW, REF NODE=99\n",
         "moves several surfaces together"),
        ("*RIGID BODY, NSET=TOP, REF NODE=98\n", "expected one node that is defined, found 98"),
    ],
)  # fmt: skip
def test_reference_nodes_that_the_case_does_not_follow(
    tmp_path: Path, lines: str, reason: str
) -> None:
    assert reason in refused(tmp_path, DECK + REFERENCE + lines)


def test_reference_nodes_that_a_case_follows(tmp_path: Path) -> None:
    """A platen or a support of the same name; forces alone need none, nor does a roll."""
    path = tmp_path / "pad.inp"
    path.write_text(DECK + REFERENCE + "*RIGID BODY, NSET=TOP, REF NODE=RP\n")
    read_inp(path, BODIES, ["top"], ({}, {}), Uses(led=["TOP"]))
    spread = "*ELEMENT, TYPE=DCOUP2D, ELSET=E\n90, 99\n*DISTRIBUTING COUPLING, ELSET=E\nTOP, 1.\n"
    assert "1 DCOUP2D" in read(tmp_path, DECK + REFERENCE + spread).notes[0]


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
