# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a disc that are none: sides, axes, loads and supports that do not fit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import sectors
from cases.sectors import ramp

from fretfe.bodies.definition import define_model, side_notes
from fretfe.bodies.rigid_modes import held_model, modes_restrained_by_contact
from fretfe.case import check_dimension, parse_case
from fretfe.errors import CaseError, FretfeError
from fretfe.mesh.mesh import BodyMesh, Mesh, check_groups


def checked(
    *meshes: BodyMesh, sides: dict[str, Any] | None = None, **tables: Any
) -> dict[str, str]:
    """Motions that only contact prevents, of a sector that passes all checks."""
    symmetry = sectors.cyclic(**(sides or {}))
    data = sectors.spinning(1, symmetry=symmetry) | {"geometry": {"file": "none.msh"}}
    data |= {key: data.get(key, {}) | table for key, table in tables.items()}
    case = parse_case(data)
    bodies = meshes or (sectors.ring(), sectors.pad())
    mesh = Mesh({each.name: each for each in bodies})
    check_groups(mesh, case)
    check_dimension(case, mesh.dimension)
    return modes_restrained_by_contact(held_model(case, mesh), mesh)


def test_the_sector_is_held_and_its_block_is_not() -> None:
    assert checked() == {"pad": "to move in every direction and to turn"}


def test_a_table_says_all_that_is_wrong_with_it() -> None:
    wrong = {"sectors": 1, "boundary2": "ring_bottom", "centre": [0], "type": "mirror"}
    with pytest.raises(CaseError) as caught:
        checked(sides=wrong)
    text = str(caught.value)
    for part in ("sectors: expected a number >= 2, found 1", "type: expected 'cyclic'", "centre"):
        assert part in text
    with pytest.raises(CaseError, match="expected two boundaries, found 'ring_bottom' twice"):
        checked(sides={"boundary2": "ring_bottom"})
    with pytest.raises(CaseError, match="sectors: expected a whole number"):
        checked(sides={"sectors": 4.5})


@pytest.mark.parametrize(
    ("sides", "why"),
    [
        ({"sectors": 5}, r"360°/5 about the axis, found 'ring_bottom' at .*, turned, 0.43"),
        ({"centre": [0.1, 0.0]}, "images of one another"),
        ({"boundary2": "ring_right"}, "images of one another"),
        ({"boundary2": "ring_tip"}, r"no physical curve 'ring_tip' \(did you mean ring_top"),
        ({"boundary2": "pad_top"}, "on ring and 'pad_top' on pad"),
        ({"axis": [1, 0, 0]}, r"axis: expected \[0, 0, 1\] or \[0, 0, -1\]"),
        ({"centre": [0, 0, 1]}, "centre: expected 2 components on this mesh, found 3"),
    ],
)
def test_sides_that_are_no_images(sides: dict[str, Any], why: str) -> None:
    loads = {"spin": {"type": "rotation", "centre": sides.get("centre", [0, 0])[:2],
                      "axis": sides.get("axis", [0, 0, 1]),
                      "history": ramp(1.0)}}  # fmt: skip
    with pytest.raises(FretfeError, match=why):
        checked(sides=sides, loads=loads)


def test_either_sense_of_turning_will_do() -> None:
    assert checked(sides={"boundary1": "ring_top", "boundary2": "ring_bottom"}) == checked()
    assert checked(sides={"axis": [0, 0, -1]}) == checked()


@pytest.mark.parametrize(
    ("load", "why"),
    [
        ({"type": "acceleration", "direction": "x"}, "expected an acceleration along the axis"),
        ({"type": "rotation", "centre": [0.5, 0]}, "expected a rotation about the axis"),
        ({"type": "rotation", "centre": [0, 0], "axis": [1, 0, 0]}, "expected a rotation about"),
    ],
)
def test_loads_that_differ_from_sector_to_sector(load: dict[str, Any], why: str) -> None:
    with pytest.raises(CaseError, match=why):
        checked(loads={"more": {**load, "history": ramp(1.0)}})


@pytest.mark.parametrize(
    ("tables", "why"),
    [
        ({"supports": {"a": {"boundary": "ring_top", "fix": ["x"]}}}, "only the neighbour sector"),
        (
            {"symmetry": {"again": {**sectors.cyclic()["sides"], "boundary1": "ring_right",
                                    "boundary2": "ring_left"}}},
            "a body that has no others, but 'ring' has those of symmetry.sides",
        ),
        (
            {"symmetry": {"again": {**sectors.cyclic()["sides"], "sectors": 6, "centre": [1, 0],
                                    "boundary1": "pad_top", "boundary2": "pad_bottom"}}},
            r"(?s)expected that of symmetry.sides, 4, found 6.*the axis of symmetry.sides",
        ),
        ({"supports": {"a": {"boundary": "ring_right", "direction": [1, 0]}}},
         "a direction that does not turn with the sectors"),
        ({"supports": {"a": {"boundary": "ring_right", "fix": ["y"]}}},
         "a direction that does not turn with the sectors"),
        ({"loads": {"a": {"type": "platen", "boundary": "ring_right", "direction": "x",
                          "control": "displacement", "history": ramp(1.0)}}},
         "a moves it in a direction that does not turn with them"),
    ],
)  # fmt: skip
def test_what_is_not_the_same_at_both_sides(tables: dict[str, Any], why: str) -> None:
    ring = sectors.ring()
    ring.boundaries["ring_left"] = ring.boundaries["ring_seat"]
    with pytest.raises(FretfeError, match=why):
        checked(ring, sectors.pad(), **tables)


@pytest.mark.parametrize(
    ("points", "jump"),
    [([[0, 0], [2, 0]], 0.0), ([[0, -1], [0, 1]], 1.0)],
    ids=["over the middle", "from side to side"],
)
def test_strains_that_jump_from_sector_to_sector(points: list[list[float]], jump: float) -> None:
    warm = {**sectors.STEEL, "expansion": 1e-3, "reference_temperature": 0.0}
    heat = {"type": "temperature", "points": points, "values": [0.0, 100.0], "history": ramp(1.0)}
    data = sectors.spinning(1, symmetry=sectors.cyclic()) | {"geometry": {"file": "none.msh"}}
    data |= {"bodies": {name: warm for name in ("ring", "pad")}, "loads": {"heat": heat}}
    definition = define_model(
        parse_case(data), Mesh({"ring": sectors.ring(), "pad": sectors.pad()})
    )
    notes = tuple(side_notes(definition))
    assert len(notes) == (jump > 0)
    if notes:
        # 100 (1 + sin 45° 1.4)/2 and 100 (1 - sin 45° 1.4)/2 at the outer corners
        assert (
            "loads.heat: from one sector to the next the strain of ring jumps by 99.5 %" in notes[0]
        )


def test_a_boundary_that_is_held_alike() -> None:
    checked(supports={"a": {"boundary": "ring_right", "fix": ["x", "y"]}})


def test_a_contact_at_a_side() -> None:
    with pytest.raises(CaseError, match="contact surface 'ring_seat' of 'ring' at one of them"):
        checked(sectors.ring(seat=(-50, 30)), sectors.pad())


def test_a_support_at_one_side_only() -> None:
    ring = sectors.ring()
    outside = ring.boundaries["ring_right"]
    ring.boundaries["ring_corner"] = outside[np.argsort(ring.points[outside[:, 0], 1])[:2]]
    with pytest.raises(CaseError, match="found it at one side only"):
        checked(ring, sectors.pad(), supports={"a": {"boundary": "ring_corner", "fix": ["x", "y"]}})
