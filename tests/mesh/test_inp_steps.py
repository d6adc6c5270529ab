# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts and steps of a deck as tables of a case."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.decks import LOW, NODES, UP
from typer.testing import CliRunner

from fretfe.case import parse_case
from fretfe.cli.app import app
from fretfe.errors import CaseError, MeshError
from fretfe.loads import build_history
from fretfe.mesh.inp import read_deck
from fretfe.mesh.inp_outline import outline
from fretfe.surface.checks import load_mesh

MODEL = (
    f"*NODE\n{NODES}*ELEMENT, TYPE=CPE4, ELSET=LOW\n{LOW}*ELEMENT, TYPE=CPE4, ELSET=UP\n{UP}"
    "*ELSET, ELSET=ALL\nLOW, UP\n*NSET, NSET=FOOT\n1, 2, 3, 4\n*NSET, NSET=CREST\n25, 26, 27, 28\n"
    "*SURFACE, NAME=FACE\nLOW, S3\n*SURFACE, NAME=PAD\nUP, S1\n*SURFACE, NAME=HEAD\nUP, S3\n"
    "*SURFACE, NAME=SIDE\n3, S2\n"
    "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., .3\n*DENSITY\n7.8E-9\n"
    "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n2.5,\n"
    "*SOLID SECTION, ELSET=LOW, MATERIAL=STEEL\n2.5,\n"
    "*SOLID SECTION, ELSET=UP, MATERIAL=STEEL\n2.5,\n"
    "*SURFACE INTERACTION, NAME=RUB\n*FRICTION\n0.4,\n*SURFACE INTERACTION, NAME=SLICK\n"
)
PAIR = "*CONTACT PAIR, INTERACTION=RUB, TYPE=SURFACE TO SURFACE\nPAD, FACE\n"
HELD = "*BOUNDARY\nFOOT, ENCASTRE\n"


def proposed(folder: Path, text: str) -> tuple[dict[str, Any], list[str]]:
    """The tables of the case, and what was not understood."""
    path = folder / "pad.inp"
    path.write_text(MODEL.replace("ELSET=ALL, MATERIAL", "ELSET=NONE, MATERIAL") + text)
    lines = outline(path).lines
    marks = ("# not taken over:", "# names that a boundary may have, as such or as a label in "
             "[geometry.boundaries]")  # fmt: skip
    begin = lines.index(marks[0]) + 1 if marks[0] in lines else lines.index(marks[1])
    return tomllib.loads("\n".join(lines)), [
        line.removeprefix("# pad.inp, ") for line in lines[begin : lines.index(marks[1])] if line
    ]


def step(*lines: str, static: str = "0.25, 1.", words: str = "") -> str:
    return "\n".join([f"*STEP{words}\n*STATIC\n{static}", *lines, "*END STEP\n"])


def test_a_whole_deck_becomes_a_case_that_is_valid(tmp_path: Path) -> None:
    press = step("*DSLOAD", "HEAD, P, 10.", "*CLOAD", "CREST, 1, 0.5", "*NODE FILE\nU")
    tables, lacks = proposed(tmp_path, PAIR + HELD + press)
    assert lacks == []
    assert tables["model"] == {"thickness": 2.5}
    assert tables["contacts"] == {
        "pad": {"surface1": "PAD", "surface2": "FACE", "friction": 0.4}
    }  # fmt: skip
    assert tables["supports"] == {"foot": {"boundary": "FOOT", "fix": ["x", "y"]}}
    assert tables["loads"] == {
        "head_normal": {
            "type": "traction", "boundary": "HEAD", "direction": "normal",
            "history": [{"ramp": -10.0, "until": 1.0, "steps": 4}],
        },
        # four nodes
        "crest_x": {
            "type": "force", "boundary": "CREST", "direction": "x",
            "history": [{"ramp": 2.0, "until": 1.0, "steps": 4}],
        },
    }  # fmt: skip
    found = CliRunner().invoke(app, ["check", str(tmp_path / "pad.inp")])
    output = found.output.splitlines()
    assert found.exit_code == 0
    assert output[-2:] == [
        "# pad.inp: keywords that are not used: 1 *NODE FILE",
        "# This case is valid: write it to a file beside the deck.",
    ]
    bare = tmp_path / "bare.inp"
    bare.write_text(MODEL)
    found = CliRunner().invoke(app, ["check", str(bare)])
    output = found.output.splitlines()
    assert found.exit_code == CaseError.exit_code
    assert "# This case cannot be solved yet:" in output
    assert any(
        "contacts: " in line for line in output[output.index("# This case cannot be solved yet:") :]
    )


AMPLITUDE = "*AMPLITUDE, NAME=A{}\n0., 0., 0.5, 1.\n1., -1., 1.5, 0.\n"


@pytest.mark.parametrize(
    ("lines", "times", "values"),
    [
        # step after step, with what is not named again
        ((step("*DSLOAD", "HEAD, P, 10."), step("*DSLOAD", "HEAD, P, 4."), step()),
         (0, 1, 2), (0, -10, -4)),
        ((step("*DSLOAD", "HEAD, P, 10."), step("*DSLOAD, OP=NEW")), (0, 1, 2), (0, -10, 0)),
        ((step(), step("*DSLOAD", "HEAD, P, 10.")), (0, 1, 2), (0, 0, -10)),
        ((step("*DSLOAD", "HEAD, P, 10.", words=", AMP=STEP"),), (0, 0.25, 1), (0, -10, -10)),
        # over the time of the step
        ((AMPLITUDE.format(""), step("*DSLOAD, AMPL=A", "HEAD, P, 10.", static="1., 2.")),
         (0, 0.5, 1, 1.5, 2), (0, -10, 10, 0, 0)),
        ((AMPLITUDE.format(""), step(), step("*DSLOAD, AMPLITUDE=A", "HEAD, P, 10.",
          static="1., 2."), step()), (0, 1, 1.5, 2, 2.5, 3), (0, 0, -10, 10, 0, 0)),
        # a jump within the first increment
        (("*AMPLITUDE, NAME=A\n0., 1., 1., 1.\n", step("*DSLOAD, AMPLITUDE=A", "HEAD, P, 10.")),
         (0, 0.25, 1), (0, -10, -10)),
    ],
)  # fmt: skip
def test_histories(
    tmp_path: Path, lines: tuple[str, ...], times: tuple[float, ...], values: tuple[float, ...]
) -> None:
    tables, lacks = proposed(tmp_path, PAIR + HELD + "".join(lines))
    assert lacks == []
    history = build_history(parse_case(tables, tmp_path / "pad.toml"))
    number = history.channels.index("head_normal")
    found = dict(zip(history.times, history.values[:, number], strict=True))
    assert [found[float(time)] for time in times] == pytest.approx(list(values), abs=1e-12)


@pytest.mark.parametrize(
    ("lines", "name", "table"),
    [
        (step("*DSLOAD", "SIDE, TRVEC, 3., 1., 0., 0."), "side", {
            "type": "traction", "boundary": "SIDE", "direction": [1.0, 0.0],
            "history": [{"ramp": 3.0, "until": 1.0, "steps": 4}]}),
        (step("*DLOAD", "UP, P3, 7."), "head_normal", {
            "type": "traction", "boundary": "HEAD", "direction": "normal",
            "history": [{"ramp": -7.0, "until": 1.0, "steps": 4}]}),
        (step("*DLOAD", "ALL, GRAV, 9810., 0., -1., 0."), "acceleration", {
            "type": "acceleration", "direction": [0.0, -1.0],
            "history": [{"ramp": 9810.0, "until": 1.0, "steps": 4}]}),
        # the square of the speed
        (step("*DLOAD", "ALL, CENTRIF, 1.E4, 0., -50., 0., 0., 0., 1."), "rotation", {
            "type": "rotation", "centre": [0.0, -50.0],
            "history": [{"ramp": 100.0, "until": 1.0, "steps": 4}]}),
        (step("*BOUNDARY", "CREST, 2, 2, -.01"), "crest_y", {
            "type": "displacement", "boundary": "CREST", "direction": "y",
            "history": [{"ramp": -0.01, "until": 1.0, "steps": 4}]}),
        (step("*BOUNDARY", "CREST, 2, 2, -.01", static="1.E-4, 2."), "crest_y", {
            "type": "displacement", "boundary": "CREST", "direction": "y",
            "history": [{"ramp": -0.01, "until": 2.0, "steps": 10}]}),
        ("*BOUNDARY\nCREST, 2\n" + step() + step("*BOUNDARY", "CREST, 2, 2, -.01"), "crest_y", {
            "type": "displacement", "boundary": "CREST", "direction": "y",
            "history": [{"hold": True, "until": 1.0, "steps": 1},
                        {"ramp": -0.01, "until": 2.0, "steps": 4}]}),
    ],
)  # fmt: skip
def test_loads(tmp_path: Path, lines: str, name: str, table: dict[str, Any]) -> None:
    tables, lacks = proposed(tmp_path, PAIR + HELD + lines)
    assert (lacks, tables["loads"]) == ([], {name: table})
    parse_case(tables, tmp_path / "pad.toml")


def test_supports(tmp_path: Path) -> None:
    held = "*BOUNDARY\nFOOT, YSYMM\nFOOT, 1, 1\n*BOUNDARY\nCREST, 3, 6\nCREST, XSYMM\n"
    tables, lacks = proposed(tmp_path, PAIR + held)
    assert lacks == []
    assert tables["supports"] == {
        "foot": {"boundary": "FOOT", "fix": ["y", "x"]},
        "crest": {"boundary": "CREST", "fix": ["x"]},
    }


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("*BOUNDARY\n1, 1, 2\n", "*BOUNDARY: 1, 1, 2: single nodes are neither held nor"),
        ("*NSET, NSET=SOME\n1, 4\n*BOUNDARY\nSOME, 1, 2\n", "expected nodes of whole facets"),
        (step("*DSLOAD", "HEAD, HP, -1."), "expected P or TRVEC, found HP"),
        (step("*DLOAD", "LOW, P2, -1."), "expected sides on the outside of a body (P1, P2, ...)"),
        (step("*DLOAD", "UP, GRAV, 1., 0., -1., 0."), "expected all elements, found 3 that are"),
        (step("*DSLOAD, AMPLITUDE=B", "HEAD, P, 1."), "the amplitude B is not known"),
        ("*AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n1, 1., 0., 0.\n", "DEFINITION=PERIODIC"),
        (AMPLITUDE.format(", TIME=TOTAL TIME"), "expected TIME=STEPTIME, found TIME=TOTALTIME"),
        (AMPLITUDE.format(", VALUE=ABSOLUTE"), "expected VALUE=RELATIVE, found VALUE=ABSOLUTE"),
        (step("*CLOAD", "26, 2, -3."), "*CLOAD: 26, 2, -3.: single nodes are neither held nor"),
        ("*STEP\n*FREQUENCY\n5\n*END STEP\n", "step 1 is not static"),
        (step(static="0.25, one"), "*STATIC: expected a finite number, found one"),
        (step("*CLOAD", "CREST, 2"), "list index out of range"),
        (step(words=", NLGEOM"), "*STEP: NLGEOM: displacements and turns are small here"),
        (step() + step("*BOUNDARY", "FOOT, 1, 2"), "FOOT is held or moved along x from t = 1 on"),
        (step("*BOUNDARY", "FOOT, 1") + step("*BOUNDARY, OP=NEW", "CREST, 2"), "step 2 frees FOOT"),
        ("*CONTACT PAIR, INTERACTION=NONE\nPAD, FACE\n", "no friction is known of the"),
        ("*CONTACT PAIR, INTERACTION=RUB\nPAD, NONE\n", "no surface, node set or element set NONE"),
        ("*CONTACT PAIR, INTERACTION=RUB\nPAD,\n", "expected two surfaces, found PAD"),
        ("*SURFACE INTERACTION, NAME=GLUE\n*FRICTION, ROUGH\n", "expected one coefficient"),
    ],
)  # fmt: skip
def test_what_is_not_taken_over_is_listed(tmp_path: Path, lines: str, reason: str) -> None:
    _, lacks = proposed(tmp_path, lines)
    assert any(lack.startswith("line ") and reason in lack for lack in lacks), lacks


def test_frictionless_pairs_and_planes_that_are_turned(tmp_path: Path) -> None:
    tables, _ = proposed(tmp_path, PAIR.replace("RUB", "SLICK"))
    assert tables["contacts"]["pad"]["friction"] == 0.0
    path = tmp_path / "turned.inp"
    turned = "".join(f"{n}, {x}, 0., {y}\n" for n, x, y in
                     (row.split(", ") for row in NODES.splitlines()))  # fmt: skip
    path.write_text(MODEL.replace(NODES, turned).replace("CPE4", "CPS4") + PAIR + HELD)
    lines = outline(path).lines
    assert tomllib.loads("\n".join(lines))["model"] == {"plane": "stress", "thickness": 2.5}
    assert not any(line.startswith("[supports") for line in lines)
    assert any("the bodies are not in a plane of constant z" in line for line in lines)


def test_ties_become_a_body_of_their_parts(tmp_path: Path) -> None:
    """What is tied to the part with the surface of a contact is of its body."""
    lid = "".join(f"{40 + n}, {n}., 2.\n{50 + n}, {n}., 2.5\n" for n in range(4))
    cells = "".join(f"{n + 41}, {n + 40}, {n + 41}, {n + 51}, {n + 50}\n" for n in range(3))
    more = (
        f"*NODE\n{lid}*ELEMENT, TYPE=CPE4, ELSET=LID\n{cells}*SURFACE, NAME=LIDTOP\nLID, S3\n"
        "*SURFACE, NAME=LIDFOOT\nLID, S1\n*SOLID SECTION, ELSET=LID, MATERIAL=STEEL\n2.5,\n"
        "*TIE, NAME=GLUE, POSITION TOLERANCE=0.1\nLIDFOOT, HEAD\n"
    )
    text = more + PAIR + HELD + step("*DSLOAD", "LIDTOP, P, 10.")
    tables, lacks = proposed(tmp_path, text)
    assert lacks == [] and tables["bodies"].keys() == {"pad", "face"}
    assert tables["ties"] == {"tie1": {"boundary1": "LIDFOOT", "boundary2": "HEAD"}}
    case = parse_case(tables, tmp_path / "pad.toml")
    mesh = load_mesh(case)
    assert mesh.bodies["pad"].pieces == 2 and mesh.bodies["pad"].points[:, 1].max() == 2.5
    output = CliRunner().invoke(app, ["check", str(tmp_path / "pad.inp")]).output.splitlines()
    assert output[-1] == "# This case is valid: write it to a file beside the deck."
    del tables["ties"]
    with pytest.raises(MeshError, match=r"line \d+: \*TIE of LIDFOOT and HEAD, which the case does "
                       r"not tie: expected a table \[ties.NAME\]"):  # fmt: skip
        load_mesh(parse_case(tables, tmp_path / "pad.toml"))


def test_pieces_of_one_element_set(tmp_path: Path) -> None:
    """Bodies are the pieces that the surfaces of a contact lie on, by the names of these."""
    one = "*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n2.5,\n"
    model = MODEL[: MODEL.index("*SOLID")] + one + MODEL[MODEL.index("*SURFACE INTERACTION") :]
    path = tmp_path / "pad.inp"
    path.write_text(model + PAIR + HELD + step("*DSLOAD", "HEAD, P, 10."))
    lines = outline(path).lines
    bodies = tomllib.loads("\n".join(lines))["bodies"]
    steel = {"young": 210e3, "poisson": 0.3, "density": 7.8e-9}
    assert bodies == {"pad": steel, "face": steel}
    case = parse_case({**tomllib.loads("\n".join(lines)), "bodies": {"pad": {}, "face": {}}}, path)
    mesh = load_mesh(case)
    assert [np.ptp(mesh.bodies[name].points, axis=0).tolist() for name in ("pad", "face")] == [
        [3.0, 1.0], [3.0, 1.0]
    ]  # fmt: skip
    assert mesh.bodies["pad"].points[:, 1].min() == 1.0
    # by a set of nodes
    deck = read_deck(path)
    assert deck.elements_of("FOOT") == [1, 2, 3] and deck.elements_of("NONE") == []


RIGID = "*NODE, NSET=RP\n99, 1.5, 2.5\n"
COUPLED = "*COUPLING, REF NODE=RP, SURFACE=HEAD, CONSTRAINT NAME=C\n"
CAPS = ("*RIGID BODY, NSET=CREST, REF NODE=99\n", COUPLED + "*KINEMATIC\n1, 2\n",
        "*KINEMATIC COUPLING, REF NODE=99\nCREST, 1, 2\n")  # fmt: skip


@pytest.mark.parametrize("cap", CAPS)
def test_reference_nodes_of_rigid_surfaces_are_platens_to_be_added(
    tmp_path: Path, cap: str
) -> None:
    label = "HEAD" if "HEAD" in cap else "CREST"
    push = cap + "*BOUNDARY\nRP, XSYMM\n" + step("*CLOAD", "RP, 2, -30.", "RP, 6, 4.")
    tables, lacks = proposed(tmp_path, PAIR + HELD + RIGID + push)
    assert "loads" not in tables and tables["supports"].keys() == {"foot"}
    own = f'platen with boundary = "{label}", and of type tilt with centre = [1.5, 2.5]'
    assert len(lacks) == 2 and all(own in lack for lack in lacks)
    assert "RP, 2, -30. and 1 more: this node moves" in lacks[1]
    history = {"history": [{"ramp": -0.01, "until": 1.0, "steps": 4}]}
    platen = {"type": "platen", "boundary": label, "direction": "y", "control": "displacement"}
    case = parse_case({**tables, "loads": {"press": platen | history}}, tmp_path / "pad.toml")
    load_mesh(case)


def test_a_reference_node_that_spreads_a_force_is_one_to_be_added(tmp_path: Path) -> None:
    spread = RIGID + COUPLED + "*DISTRIBUTING\n" + step("*CLOAD", "RP, 1, 5.")
    _, (lack,) = proposed(tmp_path, PAIR + HELD + spread)
    assert 'force with boundary = "HEAD" and through = [1.5, 2.5]' in lack


@pytest.mark.parametrize(
    ("wrong", "line"),
    [("*BOUNDRY\nFOOT, ENCASTRE\n", "line 55: cannot read *BOUNDRY: unknown keyword; did you mean "
      "*BOUNDARY?"), ("*CONTACT PIAR\n", "did you mean *CONTACTPAIR?"), ("*TEI\n", "mean *TIE?"),
     ("*EQUATON\n", "mean *EQUATION?")],
)  # fmt: skip
def test_misspelt_keywords_are_refused(tmp_path: Path, wrong: str, line: str) -> None:
    with pytest.raises(MeshError) as caught:
        proposed(tmp_path, wrong)
    assert line in str(caught.value)


def test_names_that_the_deck_has_not(tmp_path: Path) -> None:
    """The nearest name and the line, and no plain "valid"."""
    text = (
        PAIR + "*CONTACT PAIR, INTERACTION=RUBB\nPADD, FACE\n" + HELD
        + step("*DSLOAD", "HEADD, P, 10.", "HEAD, P, 1.", "*CLOAD", "CRSET, 1, .5", "999, 1, 1.",
               "*DSLOAD, AMPLITUDE=A", "SIDE, P, 1.", "*TEMPERATURE", "FOOT, 20.")
    )  # fmt: skip
    _, lacks = proposed(tmp_path, text)
    assert [lack.replace(str(tmp_path), "") for lack in lacks] == [
        "line 72: *TEMPERATURE: not supported: without it the model is another one",
        "line 57: *CONTACT PAIR: no surface, node set or element set PADD for the boundary 'PADD' "
        "(did you mean PAD?); surfaces: FACE, PAD, HEAD, SIDE; node sets: FOOT, CREST; element "
        "sets: LOW, UP, ALL",
        "line 64: *DSLOAD: HEADD, P, 10.: no surface, node set or element set HEADD for the "
        "boundary 'HEADD' (did you mean HEAD?); surfaces: FACE, PAD, HEAD, SIDE; node sets: FOOT, "
        "CREST; element sets: LOW, UP, ALL",
        "line 67: *CLOAD: CRSET, 1, .5: no node set CRSET (did you mean CREST?); node sets: FOOT, "
        "CREST",
        "line 67: *CLOAD: 999, 1, 1.: there is no node 999",
        "line 70: *DSLOAD: the amplitude A is not known",
    ]
    output = CliRunner().invoke(app, ["check", str(tmp_path / "pad.inp")]).output.splitlines()
    assert (
        output[-1]
        == "# It is not the deck: 6 things of the deck are not in it, see 'not taken over'."
    )
