# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inputs with one known cause each: what refuses or doubts them names that cause, and its key.

Two rows of squares, one on the other, of a deck that each row of the table changes in one place,
or the pad of `hertz` as half-planes. Judged are exit code, key, and the words that only the cause
has; of cautions their kind.
"""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from cases.decks import LOW, NODES, UP
from cases.pad_cases import PAD

import fretfe
from fretfe.case import parse_case
from fretfe.checked import check
from fretfe.errors import CaseError, ConvergenceError, FretfeError, ModelError

DECK = (
    f"*NODE\n{NODES}*ELEMENT, TYPE=CPE4, ELSET=LOW\n{LOW}*ELEMENT, TYPE=CPE4, ELSET=UP\n{UP}"
    "*NSET, NSET=FOOT\n1, 2, 3, 4\n*NSET, NSET=CREST\n25, 26, 27, 28\n*NSET, NSET=ROW\n1, 2, 6\n"
    "*SURFACE, NAME=FACE\nLOW, S3\n*SURFACE, NAME=PAD\nUP, S1\n*SURFACE, NAME=HEAD\nUP, S3\n"
    "*SURFACE, NAME=LEFT\n21, S4\n*SURFACE, NAME=RIGHT\n23, S2\n"
    "*SURFACE, NAME=LOWLEFT\n1, S4\n*SURFACE, NAME=LOWRIGHT\n3, S2\n"
)
PRESS = {"ramp": -30.0, "until": 1.0, "steps": 2}
WAVE = {"wave": "sine", "amplitude": 5.0, "period": 1.0, "cycles": 2, "steps_per_cycle": 8}
CASE: dict[str, Any] = {
    "geometry": {"file": "pad.inp"},
    "bodies": {
        "low": {"young": 210e3, "poisson": 0.3},
        "up": {"young": 210e3, "poisson": 0.3},
    },
    "contacts": {"main": {"surface1": "PAD", "surface2": "FACE", "friction": 0.5}},
    "supports": {"base": {"boundary": "FOOT", "fix": ["x", "y"]}},
    "loads": {
        "press": {"type": "platen", "boundary": "HEAD", "direction": "y", "control": "force",
                  "history": [PRESS]},
    },
}  # fmt: skip
HOLD = {"hold": True, "until": 1.0}
SHEAR = {"wave": "sine", "amplitude": 60.0, "period": 1.0, "cycles": 2, "steps_per_cycle": 8}
TABLE = "t [s], q [N]\n0, 0\n1, 4\n2, 0\n"


class Row(NamedTuple):
    """One mistake.

    Attributes:
        exit_code: of the command.
        key: of the case, or line of the deck, that the message names.
        cause: words that name what is wrong.
        changes: values by dotted keys of the case; None takes a key away.
        deck: text of the deck and what stands in its place.
        files: other files, by name.
    """

    exit_code: int
    key: str
    cause: str
    changes: Mapping[str, Any] = {}
    deck: tuple[str, str] = ("", "")
    files: Mapping[str, str] = {}


def changed(tables: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """A copy with other values at dotted keys."""
    found = deepcopy(tables)
    for key, value in changes.items():
        *tables_around, last = key.split(".")
        table = found
        for name in tables_around:
            table = table.setdefault(name, {})
        if value is None:
            del table[last]
        else:
            table[last] = value
    return found


def platen(**keys: Any) -> dict[str, Any]:
    return {"type": "platen", "boundary": "HEAD", "direction": "y", "control": "force",
            "history": [PRESS], **keys}  # fmt: skip


PUSHED = {"type": "traction", "boundary": "HEAD", "history": [PRESS]}
MODEL_FAULT = ModelError.exit_code
CSV = {"csv": "q.csv", "time": "t", "value": "q"}
TIE = "*TIE, NAME=T\nFACE, PAD\n"
CYCLIC = "*TIE, CYCLIC SYMMETRY, NAME=C\nLOWLEFT, LOWRIGHT\n"
END = ("*SURFACE, NAME=LEFT", "{}*SURFACE, NAME=LEFT")


def behind(text: str) -> tuple[str, str]:
    """The deck with more lines."""
    return END[0], END[1].format(text)


ROWS = {
    # names
    "body": Row(
        3,
        "pad.inp",
        "no element set PLATE for the body 'plate'",
        {"bodies.plate": {"young": 1.0, "poisson": 0.3}},
    ),
    "body-without-elements": Row(
        3, "pad.inp", "3 of 6 are in none", {"geometry.bodies": {"low": {"label": "UP"}}}
    ),
    "one-body": Row(2, "bodies", "at least 2 entries, found 1", {"bodies.low": None}),
    "boundary": Row(
        3,
        "supports.base.boundary",
        "FOO for the boundary 'FOO' (did you mean FOOT?)",
        {"supports.base.boundary": "FOO"},
    ),
    "loaded-boundary": Row(3, "loads.press.boundary", "HEAD", {"loads.press.boundary": "HAED"}),
    "surface": Row(
        3,
        "contacts.main.surface2",
        "'FACES' (did you mean FACE ",
        {"contacts.main.surface2": "FACES"},
    ),
    "same-body": Row(
        3, "contacts.main", "are both on 'low'", {"contacts.main.surface1": "LOWLEFT"}
    ),
    "nodes-without-facets": Row(
        3, "ROW", "nodes of whole facets", {"supports.base.boundary": "ROW"}
    ),
    "key": Row(2, "contacts.main.frction", "friction", {"contacts.main.frction": 0.4}),
    "table": Row(2, "contact", "contacts", {"contact": {}}),
    "load-type": Row(2, "loads.press.type", "platen", {"loads.press.type": "plate"}),
    "direction": Row(2, "loads.press.direction", "text 'w'", {"loads.press.direction": "w"}),
    # values
    "young": Row(2, "bodies.up.young", "a number > 0, found -1", {"bodies.up.young": -1.0}),
    "poisson": Row(2, "bodies.up.poisson", "0.5", {"bodies.up.poisson": 0.5}),
    "friction": Row(2, "contacts.main.friction", "-0.1", {"contacts.main.friction": -0.1}),
    "not-finite": Row(
        2, "contacts.main.friction", "finite", {"contacts.main.friction": float("nan")}
    ),
    "text-for-number": Row(2, "bodies.up.young", "number", {"bodies.up.young": "210 GPa"}),
    "no-constants": Row(2, "bodies.up", "young", {"bodies.up": {"poisson": 0.3}}),
    "thickness": Row(2, "model.thickness", "0", {"model.thickness": 0.0}),
    "unit": Row(2, "units.length", "expected text, found 5", {"units.length": 5}),
    # histories
    "back-in-time": Row(
        2,
        "loads.press.history[segment 2].until",
        "expected a time after 1",
        {"loads.press.history": [PRESS, {**PRESS, "until": 0.5}]},
    ),
    "wave-not-from-zero": Row(
        2,
        "loads.press.history[segment 1]",
        "put a ramp to 5",
        {"loads.press.history": [{**WAVE, "phase": 90}]},
    ),
    "no-history": Row(2, "loads.press.history", "at least 1 entry", {"loads.press.history": []}),
    "cycle-no-step": Row(
        2, "cycle.start", "expected the time of a step", {"cycle": {"start": 0.3, "end": 1.0}}
    ),
    "cycle-too-late": Row(2, "cycle.end", "which ends at 1", {"cycle": {"start": 0.5, "end": 9.0}}),
    "cycle-of-half-a-wave": Row(
        2,
        "loads.press.history[segment 2].period",
        "a period that divides the cycle",
        {
            "loads.press.history": [PRESS, {**WAVE, "mean": -30.0}],
            "cycle": {"start": 1.0, "end": 1.5},
        },
    ),
    "open-cycle": Row(
        2,
        "loads.drift",
        "expected every load to return in the cycle",
        {
            "loads.press.history": [PRESS, {**WAVE, "mean": -30.0}],
            "loads.drift": {
                "type": "traction",
                "boundary": "LEFT",
                "direction": "x",
                "history": [{"ramp": 1.0, "until": 3.0, "steps": 20}],
            },
        },
    ),
    "no-csv": Row(
        2, "loads.press.history[segment 1].csv", "found nothing at", {"loads.press.history": [CSV]}
    ),
    "csv-column": Row(
        2,
        "loads.press.history[segment 1].csv",
        "'force'",
        {"loads.press.history": [{**CSV, "value": "force"}]},
        files={"q.csv": TABLE},
    ),
    "csv-unit": Row(
        2,
        "loads.press.history[segment 1].csv",
        "kN",
        {"loads.press.history": [CSV]},
        files={"q.csv": TABLE.replace("[N]", "[kN]")},
    ),
    "csv-text": Row(
        2,
        "loads.press.history[segment 1].csv",
        "line 3",
        {"loads.press.history": [CSV]},
        files={"q.csv": TABLE.replace("1, 4", "1, x")},
    ),
    "csv-open-repeat": Row(
        2,
        "loads.press.history[segment 1].repeat",
        "the same first and last",
        {"loads.press.history": [{**CSV, "repeat": 2}]},
        files={"q.csv": TABLE.replace("2, 0", "2, 1")},
    ),
    # friction
    "friction-too-short": Row(
        2,
        "contacts.main.friction",
        "0.5",
        {"contacts.main.friction": {"times": [0, 0.5], "values": [0.5, 0.4]}},
    ),
    "friction-lengths": Row(
        2,
        "contacts.main.friction",
        "2",
        {"contacts.main.friction": {"times": [0, 1], "values": [0.5]}},
    ),
    "friction-from": Row(
        2,
        "contacts.main.friction_from",
        "expected the time of a step",
        {"contacts.main.friction_from": 0.2},
    ),
    "friction-file": Row(
        2, "contacts.main.friction", "mu.csv", {"contacts.main.friction": {"csv": "mu.csv"}}
    ),
    # supports
    "held-contact": Row(
        2,
        "supports.more",
        "found 'PAD', which is contacts.main.surface1",
        {"supports.more": {"boundary": "PAD", "fix": ["x"]}},
    ),
    "held-and-moved": Row(
        2, "loads.press", "HEAD", {"supports.more": {"boundary": "HEAD", "fix": ["y"]}}
    ),
    "along-z": Row(2, "supports.base.fix", "z", {"supports.base.fix": ["x", "z"]}),
    # ties and sectors
    "tie-left-out": Row(
        3, "line", "*TIE of FACE and PAD, which the case does not tie", deck=behind(TIE)
    ),
    "tie-of-a-contact": Row(
        2,
        "ties.one.boundary1",
        "found 'PAD', which is contacts.main.surface1",
        {"ties.one": {"boundary1": "PAD", "boundary2": "LEFT"}},
    ),
    "tie-of-two-bodies": Row(
        3, "ties.one", "low", {"ties.one": {"boundary1": "LEFT", "boundary2": "LOWLEFT"}}
    ),
    "tie-unknown": Row(
        3,
        "ties.one.boundary1",
        "'LEFD' (did you mean LEFT?)",
        {"ties.one": {"boundary1": "LEFD", "boundary2": "RIGHT"}},
    ),
    "sector-left-out": Row(
        3,
        "line",
        "sectors = 12, found none",
        deck=behind(CYCLIC + "*CYCLIC SYMMETRY MODEL, N=12\n0,-9\n"),
    ),
    "sector-without-model": Row(
        3, "line", "expected one *CYCLIC SYMMETRY MODEL", deck=behind(CYCLIC)
    ),
    "sectors-that-are-none": Row(
        2,
        "symmetry.low",
        "images of one another by a turn of 360°/12",
        {
            "symmetry.low": {
                "type": "cyclic",
                "boundary1": "LOWLEFT",
                "boundary2": "LOWRIGHT",
                "sectors": 12,
                "centre": [1.5, -50.0],
            }
        },
    ),
    "sides-alike": Row(
        2,
        "symmetry.low",
        "twice",
        {
            "symmetry.low": {
                "type": "cyclic",
                "boundary1": "LOWLEFT",
                "sectors": 4,
                "boundary2": "LOWLEFT",
                "centre": [0.0, 0.0],
            }
        },
    ),
    # decks
    "no-deck": Row(3, "geometry.file", "found nothing", {"geometry.file": "none.inp"}),
    "suffix": Row(2, "geometry", "found 'pad.odb'", {"geometry.file": "pad.odb"}),
    "user-element": Row(
        3,
        "line",
        "its stiffness is not that of any element",
        deck=behind("*USER ELEMENT, TYPE=U1, NODES=2\n1, 2\n"),
    ),
    "spring": Row(3, "element 90", "SPRINGA", deck=behind("*ELEMENT, TYPE=SPRINGA\n90, 1, 5\n")),
    "axisymmetric": Row(3, "pad.inp", "axisymmetric elements (CAX4)", deck=("CPE4", "CAX4")),
    "equation": Row(
        3, "line", "it joins nodes or parts", deck=behind("*EQUATION\n2\n1, 1, 1., 5, 1, -1.\n")
    ),
    "misspelt": Row(3, "line", "did you mean *ELSET", deck=behind("*ELEST, ELSET=A\n1\n")),
    "node-missing": Row(
        3, "element 1", "node 77, which is not defined", deck=("1, 1, 2", "1, 1, 77")
    ),
    "node-too-few": Row(
        3,
        "element 1 of type CPE4",
        "expected 4 nodes, found 3",
        deck=("1, 1, 2, 6, 5", "1, 1, 2, 6"),
    ),
    "node-twice": Row(3, "line", "node 1 is defined twice", deck=behind("*NODE\n1, 7., 7.\n")),
    "node-text": Row(
        3,
        "pad.inp, line 3: cannot read *NODE",
        "found x.",
        deck=(
            "\n2, 1.",
            "\n2, x.",
        ),
    ),
    "twisted": Row(3, "up", "inverted", deck=("22, 22, 23, 27, 26", "22, 22, 27, 23, 26")),
    "rigid": Row(
        3,
        "line",
        "moves CREST as one rigid piece",
        deck=behind("*NODE\n99, 1., 9.\n*RIGID BODY, NSET=CREST, REF NODE=99\n"),
    ),
    # cuts
    "cut-too-small": Row(
        3,
        "geometry.part.radius",
        "the nearest node of these surfaces is",
        {"geometry.part": {"centre": [1.5, 9.0], "radius": 0.5}},
    ),
    "cut-of-space": Row(
        2,
        "geometry.part.centre",
        "expected 2 coordinates",
        {"geometry.part": {"centre": [1.5, 1.0, 0.0], "radius": 9.0}},
    ),
    "cut-misspelt": Row(
        3,
        "'lower_cut'",
        "element set LOWER_CUT",
        {
            "geometry.part": {"centre": [1.5, 1.0], "radius": 1.3},
            "supports.base.boundary": "lower_cut",
        },
    ),
    "cut-not-made": Row(
        3, "'low_cut'", "element set LOW_CUT", {"supports.base.boundary": "low_cut"}
    ),
    "outside-of-a-cut": Row(
        3,
        "supports.base.boundary",
        "'LOWRIGHT' in the part that geometry.part cuts out",
        {
            "geometry.part": {"centre": [0.0, 1.0], "radius": 1.5},
            "supports.base.boundary": "LOWRIGHT",
        },
    ),
    # what nothing carries
    "nothing-held": Row(4, "low", "nothing holds 'low' and 'up'", {"supports": {}}),
    "carried-by-a-support": Row(
        2,
        "loads.press",
        "'HEAD', which supports.top holds along y",
        {
            "loads.press": {**PUSHED, "direction": "y"},
            "supports.top": {"boundary": "HEAD", "fix": ["y"]},
        },
    ),
    "carried-across-its-normal": Row(
        2,
        "loads.press.boundary",
        "'HEAD', whose nodes 'top y' holds",
        {
            "loads.press": {**PUSHED, "direction": "normal"},
            "supports.top": {"boundary": "HEAD", "fix": ["y"]},
        },
    ),
    "carried-by-nodes-of-another-name": Row(
        2,
        "loads.press.boundary",
        "'HEAD', whose nodes 'top y' holds",
        {
            "loads.press": {**PUSHED, "direction": "y"},
            "supports.top": {"boundary": "CREST", "fix": ["x", "y"]},
        },
    ),
    "carried-by-a-platen": Row(
        2,
        "loads.more",
        "'HEAD', which loads.press holds along x",
        {"loads.more": {**PUSHED, "direction": "x"}},
    ),
    "carried-in-part": Row(
        2,
        "loads.press",
        "'HEAD', which supports.top holds along x: that carries 60% of it",
        {
            "loads.press": {**PUSHED, "direction": [3, -4]},
            "supports.top": {"boundary": "HEAD", "fix": ["x"]},
        },
    ),
    "slides-without-friction": Row(
        2,
        "loads.shear",
        "found 'up' free to move along x",
        {
            "contacts.main.friction": 0.0,
            "loads.shear": {**platen(direction="x"), "history": [HOLD, SHEAR]},
        },
    ),
    "weight-without-friction": Row(
        2,
        "loads.weight",
        "carries a force of",
        {
            "contacts.main.friction": 0.0,
            "bodies.up.density": 1.0,
            "bodies.low.density": 1.0,
            "loads.press": {**PUSHED, "direction": "y"},
            "loads.weight": {"type": "acceleration", "direction": [3, -4], "history": [PRESS]},
        },
    ),
    "no-load": Row(2, "loads", "a load with at least one step", {"loads": {}}),
    # layers, plane state
    "plane-state": Row(2, "model.plane", "'axisymmetric'", {"model.plane": "axisymmetric"}),
    "contact-twice": Row(
        2,
        "contacts",
        "PAD",
        {"contacts.more": {"surface1": "PAD", "surface2": "FACE", "friction": 0.1}},
    ),
    "surface-with-itself": Row(2, "contacts.main", "PAD", {"contacts.main.surface2": "PAD"}),
}


@pytest.mark.parametrize("row", ROWS.values(), ids=ROWS)
def test_the_cause_is_named(tmp_path: Path, row: Row) -> None:
    old, new = row.deck
    assert old in DECK
    (tmp_path / "pad.inp").write_text(DECK.replace(old, new, 1) if old else DECK)
    for name, text in row.files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(FretfeError) as caught:
        check(parse_case(changed(CASE, row.changes), tmp_path / "case.toml"))
    message = str(caught.value)
    assert caught.value.exit_code == row.exit_code, message
    assert row.key in message and row.cause in message
    assert row.exit_code == MODEL_FAULT or message.startswith(str(tmp_path / "case.toml"))


GAP = "s [mm], gap [mm]\n-1, 1e6\n1, 1e6\n"
HALF_PLANES = {
    "slides": (
        ConvergenceError,
        "the contact slides",
        {"loads.shear.history": [HOLD, {**SHEAR, "amplitude": 300.0}]},
    ),
    "pulled": (
        ModelError,
        "found -300 at time 0.5: nothing holds the bodies together",
        {"loads.press.history": [{**PRESS, "ramp": 600.0}]},
    ),
    "other-unit": (
        CaseError,
        "bodies.upper.young",
        {"bodies.upper.young": 0.21, "bodies.lower.young": 0.21},
    ),
    "small-body": (
        CaseError,
        "found a width or height of 1",
        {"geometry.parameters.lower_width": 1.0},
    ),
    "displacement": (
        CaseError,
        "loads.press: expected control = 'force'",
        {"loads.press.control": "displacement"},
    ),
    "pulled-off": (
        ConvergenceError,
        "found -11.25 at time",
        {"loads.press.history": [PRESS, {**PRESS, "ramp": 300.0, "until": 2.0}]},
    ),
    "nothing": (ModelError, "found 0 at time", {"loads.press.history": [{**PRESS, "ramp": 0.0}]}),
    "frictionless": (
        CaseError,
        "contacts.main.friction: expected friction, which alone carries",
        {"contacts.main.friction": 0.0},
    ),
    "gap": (CaseError, "contacts.main.gap: expected the gap", {"contacts.main.gap": "gap.csv"}),
    "stress": (CaseError, "output.stress_depths", {"output.stress_depths": [0.0]}),
}


@pytest.mark.parametrize(("kind", "cause", "changes"), HALF_PLANES.values(), ids=HALF_PLANES)
def test_half_planes_are_refused_for_the_cause(
    tmp_path: Path, kind: type[FretfeError], cause: str, changes: Mapping[str, Any]
) -> None:
    """It stands in the first reason, if there are several."""
    (tmp_path / "gap.csv").write_text(GAP)
    with pytest.raises(FretfeError) as caught:
        fretfe.run(parse_case(changed(PAD, changes), tmp_path / "case.toml"), "halfplane")
    assert caught.type is kind
    title, *reasons = str(caught.value).splitlines()
    assert "the backend 'halfplane' cannot solve this case" in title
    assert cause in "".join(reasons[:3])


def test_the_case_without_a_mistake_is_valid(tmp_path: Path) -> None:
    (tmp_path / "pad.inp").write_text(DECK)
    assert check(parse_case(CASE, tmp_path / "case.toml")) is not None
