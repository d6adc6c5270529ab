# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case file: values as read, messages for mistakes, schema, documentation."""

from __future__ import annotations

import copy
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from fretfe.case import (
    Body,
    PlatenLoad,
    RotationLoad,
    Solid,
    Wave,
    case_schema,
    check_dimension,
    load_case,
    parse_case,
    unit_vector,
)
from fretfe.errors import CaseError
from fretfe.materials.material import Material
from fretfe.materials.moduli import contact_modulus, plane_modulus

DOCS = Path(__file__).parents[2] / "docs" / "case-file.md"
KEYS = "".join(page.read_text("utf-8") for page in (DOCS, DOCS.with_name("histories.md")))
VALID = """
[geometry]
file = "b1.msh"
[bodies.pad]
young = 210e3
poisson = 0.3
[bodies.substrate]
young = 70e3
poisson = 0.25
[contacts.flank]
surface1 = "pad_contact"
surface2 = "substrate_contact"
friction = 0.4
[supports.base]
boundary = "substrate_bottom"
fix = ["x", "y"]
[loads.press]
type = "platen"
boundary = "pad_top"
direction = "y"
control = "force"
history = [ { ramp = -1.0, until = 1.0, steps = 5 } ]
"""
ABSENT = object()


def edited(**changes: Any) -> dict[str, Any]:
    """The valid case with keys set or removed; a dotted key is written with two underscores."""
    data = tomllib.loads(VALID)
    for key, value in changes.items():
        *tables, last = key.split("__")
        table = data
        for name in tables:
            table = table[int(name)] if isinstance(table, list) else table.setdefault(name, {})
        if value is ABSENT:
            del table[last]
        else:
            table[last] = copy.deepcopy(value)
    return data


def message(**changes: Any) -> str:
    """The message for the valid case with these changes."""
    with pytest.raises(CaseError) as caught:
        parse_case(edited(**changes), "b1.toml")
    return str(caught.value)


def load(kind: str = "platen", **keys: Any) -> dict[str, Any]:
    """A load table with a short history."""
    history = [{"ramp": 1.0, "until": 1.0, "steps": 1}]
    control = {"control": "force"} if kind == "platen" else {}
    return {"type": kind, "history": history, **control, **keys}


def test_values_are_read_with_their_defaults(tmp_path: Path) -> None:
    path = tmp_path / "b1.toml"
    path.write_text(VALID)
    case = load_case(path)
    assert case.source == path
    assert case.resolve("b1.msh") == tmp_path / "b1.msh"
    assert (case.units.length, case.units.force, case.units.stress) == ("mm", "N", "MPa")
    assert (case.model.plane, case.model.thickness, case.model.degree) == ("strain", 1.0, 2)
    assert case.geometry.file == "b1.msh"
    assert case.bodies["substrate"] == Body(young=70e3, poisson=0.25)
    assert case.contacts["flank"].friction_from == 0
    assert case.contacts["flank"].multipliers == "finer"
    assert case.supports["base"].fix == ("x", "y")
    assert isinstance(case.loads["press"], PlatenLoad)
    assert case.cycle.given is None
    assert case.cycle.until_steady and case.cycle.most_more == 20
    assert case.output.fields == "extremes"


def test_case_as_run_can_be_read_again() -> None:
    case = parse_case(edited(loads__pull=load("traction", boundary="right", direction=[3, 4])))
    again = parse_case(json.loads(json.dumps(case.model_dump(exclude_unset=True))))
    assert again == case


def test_case_cannot_be_changed() -> None:
    case = parse_case(edited())
    with pytest.raises(ValidationError):
        case.bodies["pad"].density = 1.0


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + VALID.replace("\n", "\r\n").encode())
    assert load_case(path).bodies["pad"] == Body(young=210e3, poisson=0.3)


@pytest.mark.parametrize(
    ("direction", "expected"),
    [("y", (0, 1)), ([3, 4], (0.6, 0.8)), ([0, -2], (0, -1))],
    ids=["axis", "vector", "negative"],
)
def test_directions_become_unit_vectors(direction: Any, expected: tuple[float, ...]) -> None:
    case = parse_case(edited(loads__press__direction=direction))
    press = case.loads["press"]
    assert isinstance(press, PlatenLoad)
    # Two roundings: a quotient of small integers and a square root.
    assert unit_vector(press.direction, 2) == pytest.approx(expected, abs=1e-15)
    assert unit_vector(press.direction, 3) == pytest.approx((*expected, 0), abs=1e-15)


def test_rotation_axis_is_normalised_and_points_out_of_the_plane_by_default() -> None:
    data = edited(bodies__pad__density=1.0, bodies__substrate__density=1.0)
    data["loads"]["spin"] = load("rotation", centre=[0, -200])
    data["loads"]["tilted"] = load("rotation", centre=[0, 0, 0], axis=[0, 3, 4])
    case = parse_case(data)
    spin, tilted = case.loads["spin"], case.loads["tilted"]
    assert isinstance(spin, RotationLoad) and isinstance(tilted, RotationLoad)
    assert spin.axis == (0, 0, 1)
    assert tilted.axis == pytest.approx((0, 0.6, 0.8), abs=1e-15)


@pytest.mark.parametrize(("plane", "expected"), [("strain", 100 / 0.91), ("stress", 100.0)])
def test_moduli_of_like_bodies(plane: Any, expected: float) -> None:
    body = Body(young=100, poisson=0.3)
    assert Material.of(body, plane).shear_modulus == pytest.approx(100 / 2.6, rel=1e-15)
    assert plane_modulus(body, plane) == pytest.approx(expected, rel=1e-15)
    assert contact_modulus(body, body, plane) == pytest.approx(expected / 2, rel=1e-15)


def test_contact_modulus_on_a_rigid_body_is_the_plane_modulus() -> None:
    soft, rigid = Body(young=100, poisson=0.3), Body(young=1e18, poisson=0.2)
    # The compliance of the other body is 1e-16 of the whole.
    assert contact_modulus(soft, rigid, "strain") == pytest.approx(100 / 0.91, rel=1e-14)


RANGES = {
    "young-zero": ("bodies__pad__young", 0, "bodies.pad.young: expected a number > 0, found 0"),
    "young-nan": ("bodies__pad__young", float("nan"), "expected a finite number, found nan"),
    "young-inf": ("bodies__pad__young", float("inf"), "expected a finite number, found inf"),
    "young-bool": ("bodies__pad__young", True, "bodies.pad.young: expected a number, found true"),
    "young-text": ("bodies__pad__young", "210e3", "expected a number, found text '210e3'"),
    "poisson-low": ("bodies__pad__poisson", -1, "bodies.pad.poisson: expected a number > -1"),
    "density": ("bodies__pad__density", 0, "bodies.pad.density: expected a number > 0, found 0"),
    "friction": ("contacts__flank__friction", -0.1, "flank.friction: expected a number >= 0"),
    "friction-from": (
        "contacts__flank__friction_from",
        -1,
        "friction_from: expected a number >= 0",
    ),
    "thickness": ("model__thickness", 0.0, "model.thickness: expected a number > 0, found 0"),
    "degree": ("model__degree", 3, "model.degree: expected a number <= 2, found 3 (1 or 2)"),
    "degree-bool": ("model__degree", True, "model.degree: expected a whole number, found true"),
    "unknowns-bool": ("edges__unknowns", True, "unknowns: expected a whole number, found true"),
    "plane": ("model__plane", "strian", "'strain' or 'stress', found text 'strian'; did you mean"),
    "fix-axis": ("supports__base__fix", ["x", "w"], "supports.base.fix[item 2]: expected 'x', 'y'"),
    "fix-empty": ("supports__base__fix", [], "base.fix: expected at least 1 entry, found 0"),
    "direction": (
        "loads__press__direction",
        "up",
        "direction: expected 'x', 'y' or 'z', or a list",
    ),
    "zero-vector": (
        "loads__press__direction",
        [0, 0.0],
        "press.direction: expected a direction of",
    ),
    "long-vector": ("loads__press__direction", [1, 0, 0, 0], "at most 3 entries, found 4"),
    "vector-bool": ("loads__press__direction", [True, 0], "direction[item 1]: expected a number"),
    "load-type": ("loads__press__type", "plate", "loads.press.type: expected one of 'platen'"),
    "load-typeless": ("loads__press__type", ABSENT, "loads.press.type: expected one of 'platen'"),
    "load-number": ("loads__press", 5, "loads.press: expected a table, found 5"),
    "history-empty": ("loads__press__history", [], "press.history: expected at least 1 entry"),
    "history-number": ("loads__press__history", 1, "press.history: expected a list, found 1"),
    "fields": (
        "output__fields",
        "lst",
        "output.fields: expected 'extremes', 'last', 'none' or 'all'",
    ),
    "fields-time": ("output__fields", [-1.0], "output.fields[item 1]: expected a number >= 0"),
    "body-name": (
        "bodies__my pad",
        {"young": 1, "poisson": 0},
        'bodies."my pad": expected a name of letters',
    ),
    "one-body": ("bodies__pad", ABSENT, "bodies: expected at least 2 entries, found 1"),
    "no-contact": ("contacts", {}, "contacts: expected at least 1 entry, found 0"),
    "no-geometry": ("geometry", ABSENT, "geometry: expected a value (the key is required)"),
    "no-friction": (
        "contacts__flank__friction",
        ABSENT,
        "contacts.flank.friction: expected a value",
    ),
    "two-sources": ("geometry__template", "wedge", "'template' and 'file', found both"),
    "no-source": ("geometry", {}, "geometry: expected exactly one of 'template' and 'file'"),
    "parameters": (
        "geometry__parameters",
        {"a": 1},
        "geometry: 'parameters' cannot be given with 'b1.msh' (Gmsh mesh)",
    ),
    "order": ("geometry__order", 1, "geometry: 'order' cannot be given with 'b1.msh' (Gmsh mesh)"),
    "file": (
        "geometry__file",
        "b1.stl",
        "geometry: expected a file name that ends in one of (Gmsh mesh: .msh; Gmsh script: .geo; "
        "CAD file: .step, .stp, .brep; XDMF mesh: .xdmf; Abaqus or CalculiX mesh: .inp), found "
        "'b1.stl'",
    ),
    "cycle": ("cycle", {"start": 2, "end": 2}, "cycle: expected start < end, found start = 2"),
    "title": ("title", 1, "title: expected text, found 1"),
}


@pytest.mark.parametrize(("key", "value", "expected"), RANGES.values(), ids=RANGES)
def test_a_value_out_of_range_is_named(key: str, value: Any, expected: str) -> None:
    text = message(**{key: value})
    assert text.startswith("b1.toml: ")
    assert expected in text
    assert "pydantic" not in text and "http" not in text
    assert "\n" not in text  # one mistake, one line


@pytest.mark.parametrize("value", [0.5, 0.6])
def test_incompressible_material_is_explained(value: float) -> None:
    text = message(bodies__pad__poisson=value)
    assert f"b1.toml: bodies.pad.poisson: expected a number < 0.5, found {value}" in text
    assert "incompressible" in text


@pytest.mark.parametrize("value", [-0.99, 0.0, 0.4999])
def test_poisson_in_range_is_accepted(value: float) -> None:
    body = Body(young=210e3, poisson=value)
    assert parse_case(edited(bodies__pad__poisson=value)).bodies["pad"] == body


ONE = "expected exactly one of 'point', 'points', 'label', 'color', 'tag', 'tags', found"
SELECTORS: dict[str, tuple[dict[str, Any], str]] = {
    "none": ({"bodies": {"a": {}}}, f"geometry.bodies.a: {ONE} none"),
    "two": (
        {"bodies": {"a": {"point": [0, 1], "label": "A"}}},
        f"geometry.bodies.a: {ONE} 'point' and 'label'",
    ),
    "only-body": ({"boundaries": {"a": {"body": "b"}}}, f"geometry.boundaries.a: {ONE} none"),
    "point": ({"bodies": {"a": {"point": [0, 1, 2, 3]}}}, "bodies.a.point: expected at most 3"),
    "points": ({"bodies": {"a": {"points": []}}}, "bodies.a.points: expected at least 1 entry"),
    "color": (
        {"bodies": {"a": {"color": "red"}}},
        "geometry.bodies.a.color: expected a colour as in '#ff0000', found 'red'",
    ),
    "tag": ({"bodies": {"a": {"tag": 1.5}}}, "bodies.a.tag: expected a whole number, found 1.5"),
    "key": (
        {"bodies": {"a": {"pont": [0, 1]}}},
        "geometry.bodies.a.pont: unknown key; did you mean 'point' or 'points'?",
    ),
    "body": (
        {"bodies": {"a": {"point": [0, 1], "body": "b"}}},
        "geometry.bodies.a.body: unknown key",
    ),
    "nameless": ({"size": 1}, "geometry: expected a table [geometry.bodies] that names the bodies"),
    "way": (
        {"bodies": {"a": {"tag": 1}}},
        "geometry: bodies.a: expected 'point', 'points', 'label', 'color' for 'a.step' (CAD file), "
        "found 'tag'",
    ),
    "no-points": (
        {"file": "a.xdmf", "boundaries": {"a": {"point": [0, 1]}}},
        "boundaries.a: expected 'tag', 'tags' for 'a.xdmf' (XDMF mesh), found 'point'",
    ),
    "curves": (
        {"file": "a.inp", "boundaries": {"a": {"label": "A", "body": "b"}}},
        "boundaries.a: expected 'body' with a CAD file only",
    ),
    "size": ({"file": "a.geo", "size": 1.0}, "'size' cannot be given with 'a.geo' (Gmsh script)"),
    "facets": ({"facets": "f.xdmf"}, "'facets' cannot be given with 'a.step' (CAD file)"),
    "template": (
        {"file": None, "template": "wedge", "size": 1.0},
        "geometry: expected 'size' with a file only, found together with 'template'",
    ),
}


@pytest.mark.parametrize(("tables", "expected"), SELECTORS.values(), ids=SELECTORS)
def test_wrong_tables_of_a_geometry_file(tables: dict[str, Any], expected: str) -> None:
    geometry = {"file": "a.step", **tables}
    geometry = {key: value for key, value in geometry.items() if value is not None}
    text = message(geometry=geometry)
    assert expected in text
    assert "\n" not in text  # one mistake, one line


SOLIDS = {
    "length": ({"length": 0, "layers": 1}, "geometry.solid.length: expected a number > 0, found 0"),
    "skew": (
        {"length": 1, "layers": 1, "skew": 60},
        "geometry.solid.skew: expected a number < 60, found 60",
    ),
    "lean": (
        {"length": 1, "layers": 1, "skew": -60},
        "geometry.solid.skew: expected a number > -60, found -60",
    ),
    "layers": (
        {"length": 1, "layers": 0},
        "geometry.solid.layers: expected a number >= 1, found 0",
    ),
    "missing": ({"length": 1}, "geometry.solid.layers: expected a value"),
    "end_size": (
        {"length": 1, "layers": 4, "end_size": 0.3},
        "geometry.solid: expected an end_size of at most the thickness of equal layers "
        "(1/4 = 0.25), found 0.3",
    ),
    "spans": (
        {"length": 1, "layers": 1, "spans": {"pad": [0.2, 1.1]}},
        "geometry.solid: expected spans that increase, up to the length 1, found pad = [0.2, 1.1]",
    ),
    "key": (
        {"length": 1, "layers": 1, "skw": 5},
        "geometry.solid.skw: unknown key; did you mean 'skew'?",
    ),
}


@pytest.mark.parametrize(("solid", "expected"), SOLIDS.values(), ids=SOLIDS)
def test_a_wrong_solid_is_named(solid: dict[str, Any], expected: str) -> None:
    assert expected in message(geometry={"template": "wedge", "solid": solid})


def test_templates_and_files_are_extruded() -> None:
    solid = {"length": 10, "layers": 2}
    case = parse_case(edited(geometry={"template": "wedge", "solid": solid}))
    assert case.geometry.solid == Solid(length=10.0, skew=0.0, layers=2)
    case = parse_case(edited(geometry={"file": "b1.msh", "solid": solid}))
    assert case.geometry.solid == Solid(length=10.0, skew=0.0, layers=2)


SEGMENTS = {
    "ramp-steps": ({"ramp": 1, "until": 1, "steps": 0}, ".steps: expected a number >= 1, found 0"),
    "ramp-half": ({"ramp": 1, "until": 1, "steps": 2.5}, ".steps: expected a whole number"),
    "ramp-no-steps": ({"ramp": 1, "until": 1}, ".steps: expected a value (the key is required)"),
    "until-zero": ({"hold": True, "until": 0}, ".until: expected a number > 0, found 0"),
    "hold-false": ({"hold": False, "until": 1}, ".hold: expected true, found false"),
    "misspelt": ({"rmap": 1, "until": 1}, ": expected one of the keys 'ramp', 'hold'"),
    "mixed": ({"ramp": 1, "until": 1, "steps": 1, "hold": True}, ".hold: unknown key"),
    "lengths": ({"times": [1, 2], "values": [1]}, ": expected as many values as times, 2, found 1"),
    "order": ({"times": [1, 1], "values": [0, 1]}, ": expected strictly increasing times"),
    "number": (3, ": expected a table, found 3"),
}


@pytest.mark.parametrize(("segment", "expected"), SEGMENTS.values(), ids=SEGMENTS)
def test_a_wrong_segment_is_named(segment: Any, expected: str) -> None:
    first = {"ramp": 1.0, "until": 1.0, "steps": 1}
    text = message(loads__press__history=[first, segment])
    assert f"b1.toml: loads.press.history[segment 2]{expected}" in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("key", "value", "expected"),
    [
        ("period", 0, "a number > 0"),
        ("cycles", 0, "a number >= 1"),
        ("steps_per_cycle", 3, "a number >= 4"),
        ("amplitude", "1", "a number, found text '1'"),
        ("wave", "sinus", "'sine' or 'triangle', found text 'sinus'; did you mean 'sine'?"),
    ],
)
def test_a_wrong_wave_is_named(key: str, value: Any, expected: str) -> None:
    wave = {"wave": "sine", "amplitude": 1, "period": 1, "cycles": 1, "steps_per_cycle": 4}
    text = message(loads__press__history=[wave | {key: value}])
    assert f"b1.toml: loads.press.history[segment 1].{key}: expected {expected}" in text


UNKNOWN = {
    "top": ("titel", "x", "titel: unknown key; did you mean 'title' or 'ties'?"),
    "section": ("geometry__flie", "x", "geometry.flie: unknown key; did you mean 'file'?"),
    "named": ("contacts__flank__frction", 1, "contacts.flank.frction: unknown key; did you mean"),
    "case": ("bodies__pad__Density", 1, "bodies.pad.Density: unknown key; did you mean 'density'?"),
    "load": ("loads__press__contrl", 1, "loads.press.contrl: unknown key; did you mean 'control'?"),
    "segment": (
        "loads__press__history__0__stps",
        1,
        "loads.press.history[segment 1].stps: unknown key; did you mean 'steps'?",
    ),
    "far": ("model__colour", 1, "expected one of 'plane', 'thickness', 'degree'"),
}


@pytest.mark.parametrize(("key", "value", "expected"), UNKNOWN.values(), ids=UNKNOWN)
def test_an_unknown_key_comes_with_the_nearest_valid_ones(
    key: str, value: Any, expected: str
) -> None:
    assert expected in message(**{key: value})


def test_a_misspelt_required_key_is_one_problem() -> None:
    text = message(bodies__pad__young=ABSENT, bodies__pad__yuong=1.0, bodies__pad__colour=1)
    assert text.splitlines() == [
        "b1.toml: bodies.pad.yuong: unknown key; did you mean 'young', which is required?",
        "b1.toml: bodies.pad.colour: unknown key, expected one of 'young', 'poisson', 'density', "
        "'expansion', 'reference_temperature', 'material', 'temperature'",
    ]
    # only in the same table, and once
    text = message(bodies__pad__young=ABSENT, bodies__substrate__yuong=1.0, bodies__pad__poison=0.3)
    assert text.splitlines() == [
        "b1.toml: bodies.pad.young: expected a value (the key is required), found none",
        "b1.toml: bodies.pad.poison: unknown key; did you mean 'poisson'?",
        "b1.toml: bodies.substrate.yuong: unknown key; did you mean 'young'?",
    ]


def test_all_problems_are_listed_one_per_line() -> None:
    text = message(
        bodies__pad__young=-1,
        bodies__pad__poison=0.3,
        contacts__flank__friction=-1,
        supports__top={"boundary": "pad_top", "fix": ["x"]},
    )
    keys = [re.match(r"b1\.toml: (\S+): ", line) for line in text.splitlines()]
    assert [key and key.group(1) for key in keys] == [
        "bodies.pad.young",
        "bodies.pad.poison",
        "contacts.flank.friction",
        "supports.top.boundary",  # a contradiction between tables that are valid
    ]


def contact(surface1: str, surface2: str) -> dict[str, Any]:
    """A contact table."""
    return {"surface1": surface1, "surface2": surface2, "friction": 0.1}


CONTRADICTIONS = {
    "one-surface-twice": (
        {"contacts__flank__surface2": "pad_contact"},
        "contacts.flank.surface2: expected a surface of its own, found 'pad_contact', which is "
        "already contacts.flank.surface1",
    ),
    "two-contacts": (
        {"contacts__other": contact("free", "pad_contact")},
        "contacts.other.surface2: expected a surface of its own, found 'pad_contact', which is "
        "already contacts.flank.surface1",
    ),
    "platen-support": (
        {"supports__base__boundary": "pad_top"},
        "supports.base.boundary: expected a boundary that is not a platen, found 'pad_top', the "
        "platen of loads.press",
    ),
    "platen-displacement": (
        {"loads__side": load("displacement", boundary="pad_top", direction="x")},
        "loads.side.boundary: expected a boundary that is not a platen, found 'pad_top'",
    ),
    "platen-contact": (
        {"contacts__flank__surface1": "pad_top"},
        "contacts.flank.surface1: expected a boundary that is not a platen, found 'pad_top'",
    ),
    "platen-oblique": (
        {"loads__shear": load(boundary="pad_top", direction=[1, 0.01])},
        "loads.shear.direction: expected a direction at right angles to that of loads.press",
    ),
    "platen-same": (
        {"loads__more": load(boundary="pad_top", direction="y")},
        "loads.more.direction: expected a direction at right angles to that of loads.press on the "
        "same platen 'pad_top', found 'y' and 'y'",
    ),
    "fixed-displacement": (
        {"loads__side": load("displacement", boundary="substrate_bottom", direction="x")},
        "loads.side.direction: expected a free component, found 'x' of 'substrate_bottom', which "
        "supports.base prescribes already",
    ),
    "displacement-on-a-roller": (
        {
            "supports__side": {"boundary": "right", "direction": [-2, 0]},
            "loads__side": load("displacement", boundary="right", direction="x"),
        },
        "loads.side.direction: expected a free component, found 'x' of 'right', which "
        "supports.side prescribes already",
    ),
    "displacement-twice": (
        {
            "loads__one": load("displacement", boundary="right", direction="x"),
            "loads__two": load("displacement", boundary="right", direction="x"),
        },
        "loads.two.direction: expected a free component, found 'x' of 'right', which loads.one "
        "prescribes already",
    ),
    "rotation": (
        {"loads__spin": load("rotation", centre=[0, 0]), "bodies__pad__density": 1.0},
        "loads.spin: a rotation needs the density of every body that it acts on, missing: "
        "bodies.substrate.density",
    ),
    "interference": (
        {"loads__fit": load("interference", contact="seat")},
        "loads.fit.contact: expected one of the contacts 'flank', found 'seat'",
    ),
    "acceleration": (
        {"loads__fall": load("acceleration", direction="y"), "bodies__pad__density": 1.0},
        "loads.fall: an acceleration needs the density of every body that it acts on, missing: "
        "bodies.substrate.density",
    ),
}


@pytest.mark.parametrize(("changes", "expected"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_contradictions_between_tables_are_named(changes: dict[str, Any], expected: str) -> None:
    text = message(**changes)
    assert text.startswith(f"b1.toml: {expected}")
    assert "\n" not in text


HELD_LOADS = {
    "held-load": (
        {"loads__push": load("traction", boundary="substrate_bottom", direction="y")},
        "'substrate_bottom', which supports.base holds along y: that carries 100% of it",
    ),
    "load-held-in-part": (
        {
            "supports__side": {"boundary": "right", "fix": ["x"]},
            "loads__push": load("force", boundary="right", direction=[3, -4]),
        },
        "'right', which supports.side holds along x: that carries 60% of it",
    ),
    "load-on-a-roller": (
        {
            "supports__side": {"boundary": "right", "direction": [1, 1]},
            "loads__push": load("force", boundary="right", direction="x"),
        },
        "'right', which supports.side holds along [0.5, 0.5, 0]: that carries 71% of it",
    ),
    "load-on-a-guided-platen": (
        {"loads__push": load("traction", boundary="pad_top", direction="x")},
        "'pad_top', which loads.press holds along x",
    ),
    "load-on-a-moved-platen": (
        {
            "loads__press__control": "displacement",
            "loads__push": load("traction", boundary="pad_top", direction="y"),
        },
        "'pad_top', which loads.press holds along y",
    ),
    "load-on-a-tilt": (
        {
            "loads__tilt": {
                **load("tilt", boundary="right"),
                "centre": [0, 0],
                "control": "moment",
            },
            "loads__push": load("force", boundary="right", direction="x"),
        },
        "'right', which loads.tilt holds along x",
    ),
    "load-on-a-moved-boundary": (
        {
            "loads__side": load("displacement", boundary="right", direction="x"),
            "loads__push": load("force", boundary="right", direction="x"),
        },
        "'right', which loads.side holds along x",
    ),
    "load-on-a-cut": (
        {
            "loads__side": load("field", boundary="right", file="run.frd"),
            "loads__push": load("force", boundary="right", direction="y"),
        },
        "'right', which loads.side holds along y",
    ),
}


@pytest.mark.parametrize(("changes", "expected"), HELD_LOADS.values(), ids=HELD_LOADS)
def test_loads_that_their_own_boundary_carries_are_named(
    changes: dict[str, Any], expected: str
) -> None:
    text = message(**changes)
    begin = "b1.toml: loads.push: expected a load that moves its boundary, found that it acts on "
    assert text.startswith(begin + expected)
    assert "\n" not in text


@pytest.mark.parametrize(
    "changes",
    [
        {"loads__push": load("traction", boundary="pad_top", direction="y")},
        {
            "supports__side": {"boundary": "right", "fix": ["x"]},
            "loads__push": load("force", boundary="right", direction="y"),
        },
        {"loads__shear": load(boundary="pad_top", direction="x")},
        {
            "loads__press__direction": [3, 4],
            "loads__s": load(boundary="pad_top", direction=[-4, 3]),
        },
        {
            "supports__side": {"boundary": "right", "fix": ["x"]},
            "loads__push": load("force", boundary="right", direction=[1e-3, 1]),
        },
        {"loads__other": load(boundary="elsewhere", direction=[1, 1])},
        {"loads__pull": load("traction", boundary="pad_top", direction="normal")},
        {"geometry": {"template": "dovetail", "parameters": {"edge_size": 0.02}, "order": 1}},
        {"geometry": {"file": "a.STEP", "size": 0.1, "order": 1, "bodies": {"a": {"label": "A"}}}},
        {"geometry": {"file": "a.geo", "order": 1, "parameters": {"a": 1}}},
        {"geometry": {"file": "a.inp", "boundaries": {"a": {"label": "B 1"}}}},
        {"geometry": {"file": "a.xdmf", "facets": "b.xdmf", "bodies": {"a": {"tags": [0, -3]}}}},
    ],
    ids=[
        "traction-along-a-platen",
        "load-across-a-support",
        "axes",
        "orthogonal-vectors",
        "load-across-a-support-but-for-digits",
        "other-platen",
        "traction-on-platen",
        "template",
        "cad",
        "script",
        "inp",
        "xdmf",
    ],
)
def test_valid_combinations_are_accepted(changes: dict[str, Any]) -> None:
    assert parse_case(edited(**changes)).title == ""


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"a = 1\nb = = 2\n", "line 2, column 5: not valid TOML"),
        (b"a = [1,\n  2", "line 2, column 4: not valid TOML"),
        (b"a = 1\na = 2\n", "line 2, column 6: not valid TOML"),
        (b"a = 1\nb = -0,25 # so\n", "line 2, column 7: not valid TOML"),
        (b"a = 1\nb = '\xff'\n", "bytes in line 2 that are not UTF-8 text"),
    ],
    ids=["value", "unfinished", "twice", "comma", "latin-1"],
)
def test_a_file_that_is_not_toml_is_located(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    with pytest.raises(CaseError) as caught:
        load_case(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert expected in str(caught.value)


def test_a_geometry_in_place_of_a_case(tmp_path: Path) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(tmp_path / "x.STEP")
    assert (
        "expected a case file (TOML), found a CAD file: write one beside it with [geometry] "
        'file = "x.STEP", with bodies and boundaries of it chosen by point' in str(caught.value)
    )


@pytest.mark.parametrize(
    ("content", "number"),
    [
        ("friction = 0,6", "0.6"),
        ("friction =-0,25 # comment", "-0.25"),
        ("a = { x = 50,0, y = 1 }", "50.0"),
        ("a = { x = 50.0, y = 1,25 }", "1.25"),
        ("a = [1, 2,\nb = 3", ""),
        ("a = 1,", ""),
        ("a = { x = 1,5.0 } }", ""),
    ],
)
def test_a_decimal_comma_is_told(tmp_path: Path, content: str, number: str) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(content)
    with pytest.raises(CaseError) as caught:
        load_case(path)
    hint = f"; a decimal number is written with a point: {number}"
    assert str(caught.value).endswith(hint) == bool(number)


def test_a_missing_file_and_a_folder_are_errors(tmp_path: Path) -> None:
    missing = tmp_path / "none.toml"
    with pytest.raises(CaseError, match=re.escape(f"{missing}: expected a case file")):
        load_case(missing)
    with pytest.raises(CaseError, match="found a folder"):
        load_case(str(tmp_path))


def test_a_file_that_cannot_be_read_is_an_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(path))

    (tmp_path / "b1.toml").touch()
    monkeypatch.setattr(Path, "read_bytes", refuse)  # the tests may run as root, who reads all
    with pytest.raises(CaseError, match=r"a file that cannot be read \(Permission denied\)"):
        load_case(tmp_path / "b1.toml")


@pytest.mark.parametrize(
    ("changes", "dimension", "expected"),
    [
        ({"supports__base__fix": ["z"]}, 2, "fix[item 1]: expected 'x' or 'y' on this mesh"),
        ({"loads__press__direction": "z"}, 2, "loads.press.direction: expected nothing that moves"),
        ({"loads__press__direction": [0, 1, 1]}, 2, "press.direction: expected nothing that moves"),
        ({"loads__press__direction": [0, 1, 0]}, 2, "press.direction: expected 2 components"),
        ({"loads__press__direction": [0, 1]}, 3, "press.direction: expected 3 components"),
    ],
    ids=["support", "axis", "vector", "long-vector", "short-vector"],
)
def test_directions_must_fit_the_mesh(
    changes: dict[str, Any], dimension: int, expected: str
) -> None:
    plane = {"model__plane": "stress"} if dimension == 2 else {}
    case = parse_case(edited(**changes, **plane), "b1.toml")
    with pytest.raises(CaseError, match=re.escape(expected)):
        check_dimension(case, dimension)
    check_dimension(parse_case(edited()), dimension)


@pytest.mark.parametrize(
    ("keys", "dimension", "expected"),
    [
        ({"centre": [0, 0, 0]}, 2, "loads.spin.centre: expected 2 components on this mesh, found"),
        ({"centre": [0, 0], "axis": [0, 1, 0]}, 2, "loads.spin.axis: expected [0, 0, 1] or"),
        ({"centre": [0, 0, 0], "axis": [0, 1]}, 3, "loads.spin.axis: expected 3 components"),
    ],
    ids=["centre", "in-plane", "short"],
)
def test_rotation_must_fit_the_mesh(keys: dict[str, Any], dimension: int, expected: str) -> None:
    data = edited(bodies__pad__density=1.0, bodies__substrate__density=1.0)
    data["loads"]["press"]["direction"] = [0, 1, 0][:dimension]
    data["loads"]["spin"] = load("rotation", **keys)
    with pytest.raises(CaseError, match=re.escape(expected)):
        check_dimension(parse_case(data), dimension)


@pytest.mark.parametrize(
    ("cycle", "most"),
    [
        ({"more": 3}, 3),
        ({"more": 0}, 0),
        ({"until_steady": True}, 20),
        ({"until_steady": False}, 0),
    ],
)
def test_most_cycles_that_are_added(cycle: dict[str, Any], most: int) -> None:
    assert parse_case(edited(cycle=cycle)).cycle.most_more == most


def test_ends_take_layers() -> None:
    geometry = {"file": "b1.msh", "solid": {"length": 2.0, "layers": 4}}
    whole = tomllib.loads(VALID) | {"geometry": geometry, "edges": {"ends": True}}
    assert parse_case(whole).edges.ends
    with pytest.raises(CaseError, match=r"edges\.ends: expected geometry\.solid with it"):
        parse_case(whole | {"geometry": {"file": "b1.msh"}})
    sides = {"type": "cyclic", "boundary1": "one", "boundary2": "other", "sectors": 12}
    leaning = {"geometry": geometry | {"solid": {"length": 2.0, "layers": 4, "skew": 5.0}}}
    sector = whole | {"symmetry": {"disc": sides | {"centre": [0.0, -9.0]}}}
    assert parse_case(sector).edges.ends
    with pytest.raises(CaseError, match=r"edges\.ends: expected no sector .* leave it out"):
        parse_case(sector | leaning)
    with pytest.raises(CaseError, match=r"edges\.ends: expected no edges\.tolerance"):
        parse_case(whole | {"edges": {"ends": True, "tolerance": 0.1}})


def test_no_cycles_are_added_in_the_plane() -> None:
    case = parse_case(edited(cycle={"more": 3}), "b1.toml")
    with pytest.raises(CaseError, match=r"cycle\.more: expected none in the plane, .* found 3"):
        check_dimension(case, 2)
    check_dimension(parse_case(edited(cycle={"more": 0})), 2)


def properties() -> dict[str, dict[str, Any]]:
    """All keys of all tables in the schema, as ``Table.key``."""
    schema = case_schema()
    tables = {"Case": schema} | schema["$defs"]
    return {
        f"{name}.{key}": value
        for name, table in tables.items()
        for key, value in table["properties"].items()
    }


@pytest.mark.parametrize("name", properties())
def test_every_key_is_described_in_the_schema_and_in_the_documentation(name: str) -> None:
    assert len(properties()[name].get("description", "")) > 10
    key = name.split(".")[1]
    assert re.search(rf"`\[?{key}\b[^`]*`", KEYS), key


def test_schema_is_closed_and_is_json() -> None:
    schema = json.loads(json.dumps(case_schema()))
    assert schema["required"] == ["geometry", "bodies", "contacts"]
    assert not schema["additionalProperties"]
    assert schema["$defs"]["Body"]["properties"]["poisson"]["anyOf"][0]["exclusiveMaximum"] == 0.5


def test_the_documented_example_is_valid() -> None:
    example = re.findall(r"```toml\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)[0]
    case = parse_case(tomllib.loads(example))
    assert list(case.loads) == ["press", "shear", "tension"]
    wave = case.loads["tension"].history[1]
    assert isinstance(wave, Wave)
    assert wave.phase == -60


GEOMETRY_EXAMPLES = re.findall(
    r"```toml\n(.*?)```", DOCS.with_name("geometry.md").read_text(encoding="utf-8"), re.DOTALL
)


@pytest.mark.parametrize("example", GEOMETRY_EXAMPLES)
def test_examples_of_geometry_files_are_valid(example: str) -> None:
    assert parse_case({**edited(), **tomllib.loads(example)}).geometry.file is not None
