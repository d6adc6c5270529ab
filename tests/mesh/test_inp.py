# SPDX-License-Identifier: LGPL-3.0-or-later
"""Input files as other programs write them: the same mesh, or a word of what is not read."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.decks import LOW, NODES, UP

from fretfe.case import Body, parse_case
from fretfe.errors import MeshError
from fretfe.mesh.elements import directed_facets, exterior_facets, jacobian_determinants
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp import read_deck
from fretfe.mesh.inp_cards import cards, included_files
from fretfe.mesh.inp_groups import read_inp
from fretfe.mesh.inp_outline import outline
from fretfe.mesh.split import mesh_from_raw

STEEL = Body(young=210e3, poisson=0.3)
BODIES = {"low": STEEL, "up": STEEL}
SURFACES = "*SURFACE, NAME=FACE\nTOP, S3\n*SURFACE, NAME=HEAD\nUP, S3\n"
SETS = "*ELSET, ELSET=TOP, GENERATE\n1, 3, 1\n"
DECK = (
    f"*NODE\n{NODES}*ELEMENT, TYPE=CPE4, ELSET=LOW\n{LOW}*ELEMENT, TYPE=CPE4, ELSET=UP\n{UP}"
    f"{SETS}{SURFACES}"
)
ELASTIC = "*MATERIAL, NAME=STEEL\n*ELASTIC\n{}\n*SOLID SECTION, ELSET=LOW, MATERIAL=STEEL\n"


def read(folder: Path, text: str) -> RawMesh:
    (folder / "pad.inp").write_text(text, encoding="utf-8")
    return read_inp(folder / "pad.inp", BODIES, ["face", "head"], ({}, {}))


def blocks(raw: RawMesh) -> list[dict[str, Any]]:
    return [
        {name: [(each.gmsh_type, each.nodes.tolist()) for each in found]
         for name, found in groups.items()}
        for groups in (raw.bodies, raw.boundaries)
    ]  # fmt: skip


def refused(folder: Path, text: str) -> str:
    with pytest.raises(MeshError) as caught:
        read(folder, text)
    return str(caught.value)


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("1, 3, 0", "expected a step of 1 or more, found 0"),
        ("1, 3, x", "expected a step of 1 or more, found x"),
        ("1, one", "expected a number from 1 to"),
    ],
)
def test_rows_of_generated_sets_are_refused_in_words(tmp_path: Path, row: str, reason: str) -> None:
    message = refused(tmp_path, DECK.replace("1, 3, 1", row))
    assert reason in message and "invalid literal" not in message


@pytest.mark.parametrize(
    ("old", "new", "line", "reason"),
    [
        ("\n2, 1., 0.", "\n2, 1_0., 0.", 3, "expected a finite number, found 1_0."),
        ("\n2, 1., 0.", "\n2, 1., 0.0_256", 3, "expected a finite number, found 0.0_256"),
        ("\n2, 1., 0.", "\n2, 1.,", 3, "expected x, y and (in all rows or none) z, found 1."),
        ("\n2, 1., 0.", "\n2,", 3, "expected x, y and (in all rows or none) z, found "),
        ("\n2, 1., 0.", "\n2, , 0.", 3, "expected a finite number, found none"),
        ("\n2, 1., 0.", "\n2, 1., 0., .5", 3, "expected x, y and (in all rows or none) z"),
        ("\n2, 1., 0.", "\n2; 1.; 0.", 3, "from 1 to 999999999, found 2; 1.; 0."),
        ("\n2, 1., 0.", "\n2.0, 1., 0.", 3, "from 1 to 999999999, found 2.0"),
        ("\n1, 0., 0.", "\n0, 0., 0.", 2, "from 1 to 999999999, found 0"),
        ("\n2, 2, 3, 7, 6", "\n2, 2, 3, 7, 5.0", 20, "from 1 to 999999999, found 5.0"),
        ("\n2, 2, 3, 7, 6", "\n2 2 3 7 6", 20, "from 1 to 999999999, found 2 2 3 7 6"),
        ("\n2, 2, 3, 7, 6", "\n2, 2, 3, 7, 1_0", 20, "from 1 to 999999999, found 1_0"),
        ("1, 3, 1\n", "0, 3, 1\n", 26, "from 1 to 999999999, found 0"),
        (SETS, "*ELSET, ELSET=TOP\n1, 2, 3.0\n", 26, "from 1 to 999999999, found 3.0"),
        (SETS, f"*TIE, NAME=T\n{SETS}", 26, "cannot read *TIE: expected two surfaces, found none"),
        (SETS, f"*TIE, NAME=T\nFACE\n{SETS}", 26, "*TIE: expected two surfaces, found FACE"),
        (SETS, f"*TIE, NAME=T\nFACE,\n{SETS}", 26, "*TIE: expected two surfaces, found FACE"),
    ],
)
def test_rows_that_are_no_numbers_or_names_are_refused_by_their_line(
    tmp_path: Path, old: str, new: str, line: int, reason: str
) -> None:
    """Cells are taken for what Fortran reads, and nothing that is missing for 0."""
    assert old in DECK
    message = refused(tmp_path, DECK.replace(old, new, 1))
    assert message.startswith(f"{tmp_path / 'pad.inp'}, line {line}: cannot read *")
    assert reason in message


def test_coordinates_as_fortran_writes_them(tmp_path: Path) -> None:
    """With an empty cell at the end, too, as some programs write plane decks."""
    text = DECK.replace("\n2, 1., 0.", "\n+2, 1.D+00, -.0e0,")
    np.testing.assert_array_equal(read(tmp_path, text).points, read(tmp_path, DECK).points)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("GENERATE", "GEN"),
        ("TYPE=CPE4, ELSET=", "TYP = CPE4 , els ="),
        ("*SURFACE, NAME=", "*SURFACE, TYP=ELEM, NAM="),
        ("*ELSET, ELSET", "*ELS, ELS"),
        ("*NODE\n", "*NODE, SYSTEM=R\n"),
        ("*NODE\n", "\N{BYTE ORDER MARK}*NODE\n"),
        ("*NODE\n", "*NODE, SYS=REC\n"),
        ("5\n2,", "5,\n2,"),
        (LOW, LOW.replace("\n", ",\n")),
        (LOW, LOW.replace("1, 2, ", "1, 2,\n")),
        (SETS + SURFACES, SURFACES + SETS),
        (SETS, "*ELSET, ELSET=TOP\nREST, 1\n*ELSET, ELSET=REST\n2, 3\n"),
        ("CPE4", "S4R"),
        ("CPE4", "S4"),
    ],
)
def test_the_same_mesh_written_otherwise(tmp_path: Path, old: str, new: str) -> None:
    text = DECK.replace(old, new)
    assert text != DECK
    if new.startswith("S4"):  # edges of shells: Abaqus, and CalculiX behind the two faces
        text = text.replace(", S3", ", E3" if new == "S4R" else ", S5")
    plain = read(tmp_path, DECK)
    found = read(tmp_path, text)
    assert sorted(blocks(found)[1]["face"][0][1]) == sorted(blocks(plain)[1]["face"][0][1])
    assert blocks(found)[0] == blocks(plain)[0] and found.notes == ()
    np.testing.assert_array_equal(found.points, plain.points)


@pytest.mark.parametrize(
    ("how", "parts"),
    [
        ("UNION", "*SURFACE, NAME=A\n1, S3\n*SURFACE, NAME=B\n2, S3\n3, S3\n"),
        ("INTERSECTION", "*SURFACE, NAME=A\nTOP, S3\n1, S1\n*SURFACE, NAME=B\n21, S3\nTOP, S3\n"),
        ("DIFF", "*SURFACE, NAME=A\nTOP, S3\n1, S1\n*SURFACE, NAME=B\n1, S1\n"),
    ],
)
def test_surfaces_of_surfaces(tmp_path: Path, how: str, parts: str) -> None:
    """They are read when all others are known, wherever they stand."""
    combined = f"*SURFACE, NAME=FACE, COMBINE={how}\nA, B\n{parts}"
    found = read(tmp_path, DECK.replace("*SURFACE, NAME=FACE\nTOP, S3\n", combined))
    assert blocks(found) == blocks(read(tmp_path, DECK))


def test_parts_of_surfaces_without_sides(tmp_path: Path) -> None:
    """Which side is free depends on the elements: no two of them can be compared."""
    combined = "*SURFACE, NAME=FACE, COMBINE=DIFFERENCE\nHEAD, B\n*SURFACE, NAME=B\n1,\n"
    text = DECK.replace("*SURFACE, NAME=FACE\nTOP, S3\n", combined)
    assert "expected surfaces with sides (S1, ...) for DIFFERENCE" in refused(tmp_path, text)
    three = text.replace("HEAD, B", "HEAD, HEAD, HEAD")
    assert "two, found DIFFERENCE of 3" in " ".join(refused(tmp_path, three).split())


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig"])
def test_files_of_windows(tmp_path: Path, encoding: str) -> None:
    plain = read(tmp_path, DECK)
    (tmp_path / "rest.inp").write_text(DECK, encoding=encoding)
    (tmp_path / "pad.inp").write_text("*INCLUDE, INPUT=rest.inp\n", encoding=encoding)
    found = read_inp(tmp_path / "pad.inp", BODIES, ["face", "head"], ({}, {}))
    assert blocks(found) == blocks(plain)
    assert list(included_files(tmp_path / "pad.inp")) == [tmp_path / "rest.inp"]


@pytest.mark.parametrize("side", ["SPOS", "sneg", "S2", ""])
def test_shells_on_solids_stand_for_their_facets(tmp_path: Path, side: str) -> None:
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    nodes = "".join(f"{n}, {x}, {y}, {z}\n" for n, (x, y, z) in enumerate(corners, start=1))
    (tmp_path / "cube.inp").write_text(
        f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=CUBE\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
        f"*ELEMENT, TYPE=S4, ELSET=SKIN\n2, 5, 6, 7, 8\n*SURFACE, NAME=TOP\nSKIN, {side}\n"
    )
    raw = read_inp(tmp_path / "cube.inp", {"cube": STEEL}, ["top"], ({}, {}))
    (found,) = raw.boundaries["top"]
    assert sorted(found.nodes[0]) == [4, 5, 6, 7] and raw.notes == ()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("*FRICTION,\n0.4,\n*STATIC\n", [("FRICTION", {}), ("STATIC", {})]),
        (
            "*SOLID SECTION, ELSET=UP,\n*STATIC\n",
            [("SOLIDSECTION", {"ELSET": "UP"}), ("STATIC", {})],
        ),
        ("*BOUNDARY,\nLBOT, 1, 2\n", [("BOUNDARY", {})]),
        ("*NSET, NSET=A,\nGENERATE\n1, 3, 1\n", [("NSET", {"NSET": "A", "GENERATE": ""})]),
    ],
    ids=["data", "keyword", "set", "parameter"],
)
def test_a_comma_behind_a_keyword_takes_parameters_only(
    tmp_path: Path, text: str, expected: list[tuple[str, dict[str, str]]]
) -> None:
    (tmp_path / "deck.inp").write_text(text)
    found = list(cards(tmp_path / "deck.inp"))
    assert [(each.word, dict(each.parameters)) for each in found] == expected
    assert found[0].place.endswith("line 1")


@pytest.mark.parametrize(
    ("card", "meant"),
    [("BOUNDARY, AMPLTUDE=A", "AMPLITUDE"), ("ELASTIC, TPYE=ORTHO", "TYPE")],
)
def test_misspelt_parameters_are_refused_where_others_are_not(
    tmp_path: Path, card: str, meant: str
) -> None:
    (tmp_path / "deck.inp").write_text(f"*{card}\n1, 2\n*{card.split(',')[0]}, FOO=1\n1, 2\n")
    with pytest.raises(MeshError, match=rf"line 1: .*unknown parameter .*did you mean {meant}\?"):
        list(cards(tmp_path / "deck.inp"))


def test_included_rows_go_on_with_the_keyword_before_them(tmp_path: Path) -> None:
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "nodes.txt").write_text(NODES)
    plain = read(tmp_path, DECK)
    found = read(tmp_path, DECK.replace(NODES, "*INCL, INP=mesh\\nodes.txt\n"))
    assert blocks(found) == blocks(plain)
    assert "line 1: expected a keyword, which begins with *" in refused(tmp_path, NODES + DECK)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("GENERATE", "GENRATE", "found GENRATE"),
        ("GENERATE", "IN", "found IN, with which INSTANCE and INTERNAL begin"),
        ("*ELSET", "*EL", "*EL, with which ELEMENT, ELSET, ELASTIC, ELGEN, ELCOPY begin"),
        ("*NODE\n", "*NODE, SYS=C\n", "expected x, y and z, found SYSTEM=CYLINDRICAL"),
        ("*NODE\n", "*NODE, INP=x\n", "the parameter INPUT is not supported"),
        ("1, 3, 1", "1, 3, 1, 1", "expected first, last and perhaps step"),
        ("CPE4", "S4", "found one of its faces (SPOS, SNEG, S1, S2)"),
        ("TOP, S3", "NONE, S3", "there is no set 'NONE'; the boundary 'face' needs it"),
        ("TOP, S3", "NONE, SPOS", "there is no set 'NONE'; the boundary 'face' needs it"),
        ("NAME=FACE", "NAME=FACE, TYPE=SEGMENTS", "surfaces of type SEGMENTS are not supported"),
        ("NAME=FACE", "NAME=FACE, COMBINE=UNION", "there is no surface 'TOP' of elements"),
        ("ELSET=LOW", "ELSET=LOW, OFFSET=5", "the parameter OFFSET is not supported"),
    ],
)
def test_what_is_not_understood(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = DECK.replace(old, new)
    if new == "S4":
        text = text.replace(", S3", ", S1")
    assert message in " ".join(refused(tmp_path, text).split())


CORNERS = {
    1: (0, 0, 0), 2: (1, 0, 0), 3: (1, 1, 0), 4: (0, 1, 0),
    5: (0, 0, 1), 6: (1, 0, 1), 7: (1, 1, 1), 8: (0, 1, 1),
}  # fmt: skip
EDGES = ((1, 2), (2, 3), (3, 4), (4, 1), (5, 6), (6, 7), (7, 8), (8, 5), (1, 5), (2, 6), (3, 7),
         (4, 8))  # fmt: skip


@pytest.mark.parametrize("parts", [(16, 5), (11, 10), (9, 8, 4), (21,)])
@pytest.mark.parametrize("comma", ["", ","])
def test_rows_of_twenty_nodes(tmp_path: Path, parts: tuple[int, ...], comma: str) -> None:
    """Nodes are counted by the type, wherever a row ends and whether a comma says so or not."""
    places: dict[int, tuple[float, ...]] = dict(CORNERS)
    for number, (a, b) in enumerate(EDGES, 9):
        places[number] = tuple((p + q) / 2 for p, q in zip(CORNERS[a], CORNERS[b], strict=True))
    nodes = "".join(f"{n}, {x}, {y}, {z}\n" for n, (x, y, z) in places.items())
    values, rows, last = [7, *places], "", 0
    for part in parts:
        rows += ", ".join(map(str, values[last : last + part])) + comma + "\n"
        last += part
    deck = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D20R, ELSET=CUBE\n{rows}*SURFACE, NAME=TOP\n7, S2\n"
    (tmp_path / "cube.inp").write_text(deck)
    raw = read_inp(tmp_path / "cube.inp", {"cube": STEEL}, ["top"], ({}, {}))
    assert [each.nodes.shape for each in raw.bodies["cube"]] == [(1, 27)]
    assert [each.nodes.shape for each in raw.boundaries["top"]] == [(1, 9)]


# Of the element guides of Abaqus and CalculiX.
TYPES = {
    1: "MASS ROTARYI HEATCAP DCOUP2D DCOUP3D SPRING1",
    2: "B21 B23 B31 B31OS B33H PIPE31 ELBOW31 SAX1 SFMAX1 T2D2 T3D2H R2D2 RAX2 CONN3D2 DC1D2",
    3: "B22 B32R PIPE22 ELBOW32 SAX2 MAX2 T3D3 CPE3 STRI3 S3R R3D3 M3D3",
    4: "CPE4R CPS4I CAX4H CGAX4 C3D4 S4R R3D4 SFM3D4 COH2D4 DC2D4",
    6: "STRI65 CPEG6M C3D6 SC6R S6",
    8: "CPE8R S8R5 C3D8I SC8R CSS8 COH3D8 DC3D8 M3D8",
    10: "C3D10HS",
    20: "C3D20RH",
    27: "C3D27R",
}


@pytest.mark.parametrize(
    ("kind", "count"), [(kind, count) for count, kinds in TYPES.items() for kind in kinds.split()]
)
def test_elements_whose_rows_all_end_with_a_comma(tmp_path: Path, kind: str, count: int) -> None:
    nodes = ", ".join(map(str, range(1, count + 1)))
    rows = f"*ELEMENT, TYPE={kind}, ELSET=MORE\n" + "".join(f"{n}, {nodes},\n" for n in (91, 92))
    (tmp_path / "pad.inp").write_text(DECK + rows)
    found = read_deck(tmp_path / "pad.inp").elements
    assert {number: len(found[number][1]) for number in (91, 92)} == {91: count, 92: count}


def test_a_node_that_is_missing_is_told_of_its_element(tmp_path: Path) -> None:
    message = refused(tmp_path, DECK.replace("2, 2, 3, 7, 6\n", "2, 2, 3, 7\n"))
    assert "element 2 of type CPE4: expected 4 nodes, found 3" in message


def test_what_is_not_used_is_no_obstacle(tmp_path: Path) -> None:
    lines = "*NSET, NSET=PROBE\nNOT_WRITTEN\n*SURFACE, TYPE=SEGMENTS, NAME=ROLL\nSTART, 0., 5.\n"
    rigid = "*NODE, NSET=RP\n99, 0., 5.\n*RIGID BODY, ANALYTICAL SURFACE=ROLL, REF NODE=99\n"
    change = "*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\nFACE, HEAD\n"
    found = read(tmp_path, DECK + lines + rigid + change)
    assert blocks(found) == blocks(read(tmp_path, DECK))
    assert found.notes[0].startswith(
        "pad.inp: sets and surfaces that cannot be read, and are not used: PROBE, ROLL; PROBE: "
        "pad.inp, line 32: cannot read *NSET: there is no set 'NOT_WRITTEN'"
    )
    assert "1 *MODEL CHANGE, 1 *RIGID BODY" in found.notes[1]


def test_constants_over_temperature(tmp_path: Path) -> None:
    """Tables as a case has them; at the first temperature where a body has none."""
    rows = ELASTIC.format("210000., .3, 20.\n180000., .3, 420.")
    (tmp_path / "pad.inp").write_text(DECK + rows)
    low = tomllib.loads("\n".join(outline(tmp_path / "pad.inp").lines))["bodies"]["low"]
    assert low == {
        "young": {"temperatures": [20.0, 420.0], "values": [210e3, 180e3]},
        "poisson": {"temperatures": [20.0, 420.0], "values": [0.3, 0.3]},
    }
    data = {
        "geometry": {"file": "pad.inp"},
        "contacts": {"main": {"surface1": "head", "surface2": "face", "friction": 0.5}},
        "supports": {"base": {"boundary": "foot", "fix": ["x", "y"]}},
    }
    for body, young, note in (
        ({}, 210e3, "young and poisson at 20 °C, the first of a table, as the body has no temp"),
        ({"temperature": 220.0}, 195e3, "constants at 220 °C"),
    ):
        bodies = {"low": body, "up": {"young": 1.0, "poisson": 0.3}}
        case = parse_case({**data, "bodies": bodies}, tmp_path / "case.toml")
        assert case.bodies["low"].model_dump()["young"] == young
        assert note in case.material_notes[0]


@pytest.mark.parametrize("kind", ["CAX4", "R3D4"])
def test_elements_that_are_not_supported_are_refused_without_a_case(
    tmp_path: Path, kind: str
) -> None:
    (tmp_path / "pad.inp").write_text(DECK.replace("CPE4", kind))
    with pytest.raises(MeshError, match=f"{kind}.* not supported"):
        outline(tmp_path / "pad.inp")


@pytest.mark.parametrize(
    ("rows", "side"),
    [
        ("*ELEMENT, TYPE=CPE3, ELSET=LOW\n2, 2, 3, 7\n4, 2, 7, 6\n", "S2"),
        ("*ELEMENT, TYPE=CPE4, ELSET=LOW\n2, 2, 3, 7, 7\n4, 2, 7, 6, 6\n", "S2"),
        ("*ELEMENT, TYPE=CPE4, ELSET=LOW\n2, 2, 2, 3, 7\n4, 7, 6, 2, 2\n", "S1"),
    ],
    ids=["mixed", "double", "doubled first"],
)
def test_triangles_among_quadrilaterals(tmp_path: Path, rows: str, side: str) -> None:
    """The body is made of triangles; its area and its top stay (sides keep their numbers)."""
    text = DECK.replace("2, 2, 3, 7, 6\n", "").replace("*ELSET", rows + "*ELSET", 1)
    text = text.replace("TOP, S3\n", f"1, S3\n3, S3\n4, {side}\n")
    mesh = mesh_from_raw(read(tmp_path, text), "pad.inp")
    low = mesh.bodies["low"]
    assert (low.cell, len(low.cells), mesh.bodies["up"].cell) == ("triangle", 6, "quadrilateral")
    (x1, y1), (x2, y2) = np.moveaxis(np.diff(low.points[low.cells], axis=1), 0, -1)
    assert np.sum(x1 * y2 - x2 * y1) / 2 == pytest.approx(3.0, rel=1e-12)
    assert sorted(low.points[low.boundaries["face"]][:, :, 1].ravel()) == [1.0] * 6
    assert "body 'low' has 2 quadrilaterals and 2 triangles, and is divided into" in mesh.notes[0]


BRICK = (
    "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 0., 1.\n"
    "6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n9, 0., 0., 2.\n10, 1., 0., 2.\n"
    "11, 1., 1., 2.\n12, 0., 1., 2.\n21, 0., 0., 2.\n22, 1., 0., 2.\n23, 1., 1., 2.\n"
    "24, 0., 1., 2.\n25, 0., 0., 3.\n26, 1., 0., 3.\n27, 1., 1., 3.\n28, 0., 1., 3.\n"
    "*ELEMENT, TYPE=C3D8, ELSET=UP\n2, 21, 22, 23, 24, 25, 26, 27, 28\n"
    "*ELEMENT, TYPE=C3D8R, ELSET=LOW\n1, 5, 6, 7, 8, 9, 10, 11, 12\n{}"
    "*NSET, NSET=FACE\n9, 10, 11, 12\n*NSET, NSET=ALL, ELSET=LOW\n*SURFACE, NAME=HEAD\nUP, S2\n"
)


@pytest.mark.parametrize(
    "rows",
    [
        "*ELEMENT, TYPE=C3D6, ELSET=LOW\n3, 1, 2, 4, 5, 6, 8\n4, 2, 3, 4, 6, 7, 8\n",
        "3, 1, 2, 4, 4, 5, 6, 8, 8\n4, 2, 3, 4, 4, 6, 7, 8, 8\n",
        "*ELEMENT, TYPE=C3D6, ELSET=LOW\n3, 1, 2, 3, 5, 6, 7\n4, 1, 3, 4, 5, 7, 8\n",
    ],
    ids=["across", "double nodes", "ahead"],
)
def test_wedges_under_a_hexahedron(tmp_path: Path, rows: str) -> None:
    """Two triangles lie on its lower face: nothing is outside there, whichever way they run."""
    raw = read(tmp_path, BRICK.format(rows))
    mesh = mesh_from_raw(raw, "pad.inp")
    low = mesh.bodies["low"]
    volumes = jacobian_determinants(low.points, low.cells, "tetrahedron", 1)[:, 0] / 6
    # 6 of the hexahedron, 3 of each wedge; the volume of two cubes
    assert len(volumes) == 12 and volumes.sum() == pytest.approx(2.0, rel=1e-12)
    outside, _ = exterior_facets(directed_facets(low.cells, "tetrahedron", 1), "triangle")
    # ten squares
    assert (len(outside), len(low.boundaries["face"])) == (20, 2)
    assert mesh.bodies["up"].cell == "hexahedron"
    # a set with nodes all over the body has its outside and nothing within
    (tmp_path / "all.inp").write_text(BRICK.format(rows))
    everything = read_inp(tmp_path / "all.inp", BODIES, ["all", "head"], ({}, {}))
    found = mesh_from_raw(everything, "all.inp").bodies["low"].boundaries["all"]
    assert len(found) == 20
