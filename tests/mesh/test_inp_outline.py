# SPDX-License-Identifier: LGPL-3.0-or-later
"""Abaqus decks of parts, instances and an assembly, of included files and with materials."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from fretfe.case import Body, Case, case_text, changed, parse_case
from fretfe.cli.app import app
from fretfe.errors import CaseError, MeshError
from fretfe.mesh.gmsh import RawMesh
from fretfe.mesh.inp import Deck, read_deck
from fretfe.mesh.inp_groups import read_inp
from fretfe.mesh.inp_outline import outline

STEEL = Body(young=210e3, poisson=0.3)
RAMP = {"ramp": 1.0, "until": 1.0, "steps": 1}
BODIES = {"upper": STEEL, "lower": STEEL}
NODES = """\
*Node
      1,           0.,           0.
      2,           1.,           0.
      3,           1.,           1.
      4,           0.,           1.
"""
# A square that is placed twice, as Abaqus/CAE writes it: the second one on the first.
PART = f"""\
*Heading
** Job name: pad Model name: Model-1
*Preprint, echo=NO, model=NO, history=NO, contact=NO
*Part, name=Square
{NODES}*Element, type=CPE4R
1, 1, 2, 3, 4
*Nset, nset=All, generate
 1,  4,  1
*Elset, elset=All
 1,
*Elset, elset=_Head_S3, internal
 1,
*Surface, type=ELEMENT, name=Head
_Head_S3, S3
** Section: Section-1
*Solid Section, elset=All, material=Steel
,
*End Part
"""
ASSEMBLY = """\
*Assembly, name=Assembly
*Instance, name=Lower, part=Square
*End Instance
**
*Instance, name=Upper, part=SQUARE
          0.,           1.,           0.
*End Instance
*Nset, nset=Foot, instance=Lower
 1, 2
*Nset, nset=Corner
 upper.3, Lower.All
*Elset, elset=_Flank_S4, internal, instance=Upper, generate
 1,  1,  1
*Surface, type=ELEMENT, name=Flank
_Flank_S4, S4
LOWER.ALL, S4
*End Assembly
"""
SHIFT = "          0.,           1.,           0.\n"
MATERIAL = """\
*MATERIAL, NAME=steel
*Density
 7.85e-9,
*Elastic
210000., 0.3
*Expansion, zero=20.
 1.2e-5,
*Plastic
300., 0.
"""
FLAT = """\
*NODE
1, 0, 0
2, 1, 0
3, 1, 1
4, 0, 1
5, 0, 1
6, 1, 1
7, 1, 2
8, 0, 2
*ELEMENT, TYPE=CPE4R, ELSET=LOWER
1, 1, 2, 3, 4
*ELEMENT, TYPE=CPE4R, ELSET=UPPER
2, 5, 6, 7, 8
*NSET, NSET=FOOT
1, 2
*SURFACE, NAME=FLANK
2, S4
1, S4
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "pad.inp"
    path.write_text(text, encoding="utf-8")
    return path


def read(folder: Path, text: str) -> RawMesh:
    return read_inp(write(folder, text), BODIES, ["flank", "foot"], ({}, {}))


def deck(folder: Path, text: str) -> Deck:
    return read_deck(write(folder, text))


def refused(folder: Path, text: str) -> str:
    with pytest.raises(MeshError) as caught:
        read(folder, text)
    return str(caught.value)


def same(one: RawMesh, other: RawMesh) -> bool:
    """Whether nodes and elements are the same, bit for bit."""
    tables = [(one.bodies, other.bodies), (one.boundaries, other.boundaries)]
    return one.points.tobytes() == other.points.tobytes() and all(
        first.keys() == second.keys()
        and all(
            [(block.gmsh_type, block.nodes.tolist()) for block in first[name]]
            == [(block.gmsh_type, block.nodes.tolist()) for block in second[name]]
            for name in first
        )
        for first, second in tables
    )


def test_instances_are_the_flat_deck(tmp_path: Path) -> None:
    flat = read(tmp_path, FLAT)
    assert same(read(tmp_path, PART + ASSEMBLY + MATERIAL), flat)
    # a turn of a whole circle and one of nothing change no bit
    for row in ("0., 0., 0., 0., 0., 1., 360.", "1., 2., 0., 1., 2., 5., 0."):
        turned = ASSEMBLY.replace(SHIFT, f"{SHIFT}{row}\n")
        assert same(read(tmp_path, PART + turned), flat)


def test_independent_instances_are_the_flat_deck(tmp_path: Path) -> None:
    """Instances with meshes of their own, of parts that are empty."""
    mesh = PART.partition("name=Square\n")[2].partition("*End Part")[0]
    moved = mesh
    for number, place in zip((1, 2, 3, 4), ("0., 1.", "1., 1.", "1., 2.", "0., 2."), strict=True):
        row = next(line for line in NODES.splitlines() if line.strip().startswith(f"{number},"))
        moved = moved.replace(row, f"{number}, {place}")
    own = "*Part, name=Square\n*End Part\n" + ASSEMBLY.replace(
        "part=Square\n", f"part=Square\n{mesh}"
    ).replace(f"part=SQUARE\n{SHIFT}", f"part=SQUARE\n{moved}")
    assert same(read(tmp_path, own), read(tmp_path, FLAT))
    assert "nodes in the part, found some in the instance 'UPPER', which is moved" in refused(
        tmp_path,
        PART + ASSEMBLY.replace("0.\n*End Instance", "0.\n*Node\n9, 0., 0.\n*End Instance"),
    )


def test_turned_about_an_axis_after_it_is_moved(tmp_path: Path) -> None:
    rows = "2., 0., 0.\n0., 0., 0., 0., 0., 3., 90.\n"
    text = PART + ASSEMBLY.replace(SHIFT, rows)
    points = np.array(list(deck(tmp_path, text).nodes.values()))
    np.testing.assert_array_equal(points[4:, :2], [[0, 2], [0, 3], [-1, 3], [-1, 2]])
    # about an axis askew: lengths stay, points of the axis too, and three thirds are a whole turn
    third = PART + ASSEMBLY.replace(SHIFT, "0., 0., 0.\n0., 0., 0., 1., 1., 1., 120.\n")
    points = np.array(list(deck(tmp_path, third).nodes.values()))
    np.testing.assert_allclose(points[4:], points[:4][:, [2, 0, 1]], atol=1e-15)


def test_names_of_instances(tmp_path: Path) -> None:
    found = deck(tmp_path, PART + ASSEMBLY)
    assert found.element_sets["LOWER"] == [10**9 + 1]
    assert found.element_sets["UPPER.ALL"] == found.element_sets["UPPER"] == [2 * 10**9 + 1]
    assert found.node_sets["CORNER"] == [2 * 10**9 + 3, *(10**9 + n for n in (1, 2, 3, 4))]
    # two instances have it: neither is meant by its own name
    assert "ALL" not in found.element_sets
    assert found.text(found.node_sets["CORNER"][0]) == "UPPER.3"
    once = PART.replace("Square", "Other").replace("name=Head", "name=Foot") + PART
    alone = deck(tmp_path, once + ASSEMBLY.replace("part=Square", "part=Other"))
    assert alone.surfaces["HEAD"] == alone.surfaces["UPPER.HEAD"] == [(2 * 10**9 + 1, 3)]
    # the assembly has a node set of this name
    assert "FOOT" not in alone.surfaces


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("part=SQUARE", "part=Round", "there is no part 'ROUND'; parts: SQUARE"),
        ("name=Upper", "name=lower", "there is an instance 'LOWER' already"),
        (", part=SQUARE", "", "the parameter PART is missing"),
        ("*End Part\n", "", r"cannot read *ASSEMBLY: expected it outside parts and the assembly"),
        ("*End Assembly\n", "", "expected *END ASSEMBLY after it, found none"),
        ("*Assembly, name=Assembly\n", "", "cannot read *INSTANCE: expected it within *ASSEMBLY"),
        ("*End Instance\n**", "**", "expected it within *ASSEMBLY"),
        ("*Part, name=Square\n", "", "cannot read *END PART: expected *PART before it"),
        (SHIFT, "0., one, 0.\n", "expected a finite number, found one"),
        (SHIFT, "0., nan, 0.\n", "expected a finite number, found nan"),
        (SHIFT, "0., 1., 0., 7.\n", "expected a translation of 3 numbers, found 4"),
        (SHIFT, "0., 1., 0.\n0., 0., 1., 30.\n", "2 rows of 3, 4 numbers"),
        (
            SHIFT, "0., 1., 0.\n0., 0., 1., 0., 0., 1., 30.\n",
            "expected two different points on the axis",
        ),
        (
            SHIFT, "0., 1., 0.\n0., 0., 1., 0., 0., 2., turn\n",
            "expected a finite number, found turn",
        ),
        ("part=SQUARE", "part=Square, library=old", "the parameter LIBRARY is not supported"),
        ("instance=Lower", "instance=Under", "there is no instance 'UNDER'; instances: LOWER, UPP"),
        ("LOWER.ALL, S4", "LOWER.NONE, S4", "there is no set 'LOWER.NONE'"),
        (" 1, 2\n", " 1, 2000000000\n", "expected a number from 1 to 999999999"),
        ("1, 1, 2, 3, 4\n", "1, 1, 2, 3, 7\n", "element LOWER.1 has node LOWER.7, which is not"),
    ],
)  # fmt: skip
def test_wrong_assemblies(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = PART + ASSEMBLY + MATERIAL
    assert old in text
    found = refused(tmp_path, text.replace(old, new, 1))
    assert message in found
    assert found.startswith(str(tmp_path / "pad.inp"))


def test_parts_that_nothing_places(tmp_path: Path) -> None:
    assembly = "*ASSEMBLY, NAME=A\n*END ASSEMBLY\n"
    assert "found 0 nodes and 0 elements; no instance places the parts SQUARE" in refused(
        tmp_path, PART + assembly + MATERIAL
    )


def test_parts_without_an_assembly(tmp_path: Path) -> None:
    """A part that nothing can place is where its coordinates are."""
    found = deck(tmp_path, PART + MATERIAL)
    assert [found.text(number) for number in found.nodes] == [f"SQUARE.{n}" for n in range(1, 5)]
    assert found.element_sets["SQUARE"] == found.element_sets["ALL"]
    assert found.surfaces["HEAD"] == found.surfaces["SQUARE.HEAD"]


def test_included_files(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "nodes.inc").write_text(NODES)
    (tmp_path / "parts" / "square.inc").write_text(
        PART.replace(NODES, "*INCLUDE, INPUT=parts/nodes.inc\n")
    )
    text = "*Include, input=parts/square.inc\n" + ASSEMBLY
    assert same(read(tmp_path, text), read(tmp_path, FLAT))


def test_files_that_include_what_they_must_not(tmp_path: Path) -> None:
    inner = tmp_path / "deck"
    inner.mkdir()
    (tmp_path / "outside.inc").write_text(NODES)
    (inner / "link.inc").symlink_to(tmp_path / "outside.inc")
    for name in ("../outside.inc", str(tmp_path / "outside.inc"), "link.inc", "", "a\0b"):
        message = refused(inner, PART + f"*INCLUDE, INPUT={name}\n" + ASSEMBLY)
        assert "expected a file in the folder of pad.inp or below it" in message
    (inner / "one.inc").write_text("*INCLUDE, INPUT=two.inc\n")
    (inner / "two.inc").write_text("*INCLUDE, INPUT=one.inc\n")
    assert "one.inc includes itself" in refused(inner, "*INCLUDE, INPUT=one.inc\n")
    for number in range(12):
        (inner / f"{number}.inc").write_text(f"*INCLUDE, INPUT={number + 1}.inc\n")
    assert "more than 10 deep" in refused(inner, "*INCLUDE, INPUT=0.inc\n")
    (inner / "many.inc").write_text("**\n")
    assert "expected at most 1000 files" in refused(inner, "*INCLUDE, INPUT=many.inc\n" * 1001)
    with (inner / "huge.inc").open("wb") as file:
        file.truncate(2**33)
    assert "of 4 GiB together" in refused(inner, "*INCLUDE, INPUT=huge.inc\n")


def test_materials_against_the_case(tmp_path: Path) -> None:
    text = PART + ASSEMBLY + MATERIAL
    notes = read(tmp_path, text).notes
    assert notes[0] == "pad.inp: keywords that are not used: 1 *PLASTIC, 1 *PREPRINT"
    assert notes[1] == (
        "pad.inp: material STEEL of body 'upper' has density = 7.85e-09, expansion = 1.2e-05, "
        "reference_temperature = 20; the case has none, none, none, which counts"
    )
    bodies = {"upper": Body(young=200e3, poisson=0.3), "lower": STEEL}
    other = text.replace("*Expansion, zero=20.\n 1.2e-5,\n", "")
    notes = read_inp(write(tmp_path, other), bodies, ["flank"], ({}, {})).notes
    assert notes[1] == (
        "pad.inp: material STEEL of body 'upper' has density = 7.85e-09, young = 210000; the case "
        "has none, 200000, which counts"
    )
    known = Body(
        young=210e3, poisson=0.3, density=7.85e-9, expansion=12e-6, reference_temperature=20
    )
    same_numbers = {"upper": known, "lower": known}
    assert len(read_inp(write(tmp_path, text), same_numbers, ["flank"], ({}, {})).notes) == 1
    two = text.replace("*End Instance\n**", "*Solid Section, elset=all, material=Al\n*End Instance")
    two = two.replace("1, 1, 2, 3, 4\n", "1, 1, 2, 3, 4\n2, 1, 2, 3, 4\n", 1)
    two = two.replace("elset=All\n 1,", "elset=All\n 1, 2").replace(
        "elset=All, material", "elset=_Head_S3, material"
    )
    deck_of_two = read_deck(write(tmp_path, two))
    assert deck_of_two.sections[:2] == [("LOWER._HEAD_S3", "STEEL"), ("LOWER.ALL", "AL")]


def test_materials_that_are_not_isotropic(tmp_path: Path) -> None:
    for word in (", type=lamina", ", type=engineering constants", ", dependencies=1"):
        text = MATERIAL.replace("*Elastic", f"*Elastic{word}")
        steel = deck(tmp_path, PART + ASSEMBLY + text).materials["STEEL"]
        assert steel.left_out == [
            "*ELASTIC that is not isotropic or depends on more than temperature"
        ]
        assert steel.numbers.keys() == {"density", "expansion", "reference_temperature"}


def test_the_beginning_of_a_case(tmp_path: Path) -> None:
    """What `fretfe check` prints of a deck is a case but for its contacts, supports and loads."""
    path = write(tmp_path, PART + ASSEMBLY + MATERIAL)
    lines = outline(path).lines
    tables = tomllib.loads("\n".join(lines))
    steel = {"young": 210e3, "poisson": 0.3, "density": 7.85e-9, "expansion": 1.2e-5}
    steel["reference_temperature"] = 20.0
    assert tables == {
        "geometry": {"file": "pad.inp"},
        "bodies": {"lower": steel, "upper": steel},
    }
    assert "# surfaces: LOWER.HEAD, UPPER.HEAD, FLANK" in lines
    assert "# node sets: LOWER.ALL, UPPER.ALL, FOOT, CORNER" in lines
    assert "# pad.inp: keywords that are not used: 1 *PLASTIC, 1 *PREPRINT" in lines
    result = CliRunner().invoke(app, ["check", str(path)])
    assert result.output.splitlines()[: len(lines)] == lines
    for name, body in tables["bodies"].items():
        assert Body.model_validate(body) == Body.model_validate(steel), name


def test_the_title_and_the_sectors_of_a_deck(tmp_path: Path) -> None:
    sides = "*NSET, NSET=L\n1, 4\n*NSET, NSET=R\n2, 3\n"
    cyclic = (
        "*TIE, CYCLIC SYMMETRY, NAME=Side 1\nL, R\n"
        "*CYCLIC SYMMETRY MODEL, N=12\n0., -9., 0., 0., -9., 1.\n"
    )
    hard = "*SURFACE INTERACTION, NAME=I\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=HARD\n"
    path = tmp_path / "pad.inp"
    path.write_text(f"*HEADING\nPad, of the year 2\nmore\n{FLAT}{sides}{cyclic}{hard}")
    lines = outline(path).lines
    tables = tomllib.loads("\n".join(lines))
    assert tables["title"] == "Pad, of the year 2"
    assert tables["symmetry"] == {
        "sector1": {"type": "cyclic", "boundary1": "L", "boundary2": "R", "sectors": 12,
                   "centre": [0.0, -9.0]},
    }  # fmt: skip
    assert not any("not used" in line for line in lines)


def test_the_beginning_of_a_case_without_materials(tmp_path: Path) -> None:
    text = FLAT.replace("ELSET=LOWER", 'ELSET="Lower part"')
    lines = outline(write(tmp_path, text)).lines
    tables = tomllib.loads("\n".join(lines))
    assert tables["bodies"] == {"body1": {}, "upper": {}}
    assert tables["geometry"]["bodies"] == {"body1": {"label": "LOWER PART"}}
    assert lines.count("# to be added: young, poisson") == 2


def deck_case(folder: Path, text: str, **bodies: dict[str, Any]) -> Case:
    write(folder, text)
    contact = {"surface1": "upper_head", "surface2": "flank", "friction": 0.5}
    turning = {"type": "rotation", "centre": [0, 0], "history": [RAMP]}
    data = {
        "geometry": {"file": "pad.inp", "bodies": {"head": {"label": "Upper"}}},
        "bodies": {"head": {}, "lower": {}, **bodies},
        "contacts": {"main": contact},
        "loads": {"spin": turning},
    }
    return parse_case(data, folder / "pad.toml")


def test_materials_of_the_file_are_defaults(tmp_path: Path) -> None:
    """What the case gives counts; numbers of the run do not depend on the file any more."""
    text = PART + ASSEMBLY + MATERIAL
    own: dict[str, Any] = {"young": 200e3, "poisson": 0.3, "density": 8e-9}
    case = deck_case(tmp_path, text, lower=own)
    steel = Body(young=210e3, poisson=0.3, density=7.85e-9, expansion=12e-6,
                 reference_temperature=20)  # fmt: skip
    assert case.bodies == {"head": steel, "lower": Body(**own)}
    assert case.material_notes == (
        "bodies.head: STEEL of pad.inp: young = 210000, poisson = 0.3, density = 7.85e-9, "
        "expansion = 1.2e-5",
    )
    stiffer = changed(case, {"bodies.head.young": 220e3})
    assert stiffer.bodies["head"] == steel.model_copy(update={"young": 220e3})
    assert "210000" in case_text(case)
    for material, reason in (
        (MATERIAL.replace("*Elastic", "*Elastic, type=lamina"), r"that is not isotropic"),
        ("", "STEEL"),
    ):
        with pytest.raises(CaseError, match=rf"bodies.lower: expected young .*: .*{reason}"):
            deck_case(tmp_path, PART + ASSEMBLY + material, head=own)
    with pytest.raises(CaseError, match=r"bodies.head: expected young and poisson.*: none"):
        deck_case(tmp_path, FLAT)
    with pytest.raises(CaseError, match=r"geometry.file: .*line 1: \*MPC is not supported"):
        deck_case(tmp_path, "*MPC\nTIE, 1, 2\n")
