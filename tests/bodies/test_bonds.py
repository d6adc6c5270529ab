# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parts of a body that are bonded: what the ties carry over, and ties that are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.tied_blocks import Block, pressed_case, write_deck

from fretfe.bodies.cyclic import Tie
from fretfe.bodies.rigid_modes import held_model
from fretfe.case import Case
from fretfe.errors import CaseError, MeshError, ModelError
from fretfe.mesh.load import grouped_mesh

LOW = Block("PAD", "low", np.linspace(0, 4, 9), np.linspace(1, 2, 4))
# Other nodes in the same place, a narrower one, one that stands off.
SAME = Block("PAD", "high", LOW.x, np.linspace(2, 3, 4))
OTHER = Block("PAD", "high", np.linspace(0, 4, 8), np.linspace(2, 3, 4))
NARROW = Block("PAD", "high", np.linspace(1.1, 2.3, 4), np.linspace(2, 3, 4))
APART = Block("PAD", "high", LOW.x, np.linspace(2.01, 3, 4))
BLOCK = Block("BLOCK", "block", np.linspace(0, 4, 9), np.linspace(0, 1, 4))
TIE = {"glue": {"boundary1": "low_top", "boundary2": "high_bottom"}}


def case(folder: Path, *parts: Block, **tables: Any) -> Case:
    write_deck(folder / "pad.inp", [LOW, *parts, BLOCK])
    return pressed_case(folder / "pad.inp", "high_top", **{"ties": TIE, **tables})


def bond(found: Case) -> Tie:
    pad = next(each for each in held_model(found, grouped_mesh(found)).bodies if each.name == "pad")
    assert pad.bond is not None and pad.tie is None
    return pad.bond


@pytest.mark.parametrize("part", [SAME, OTHER, NARROW], ids=["same", "other", "narrow"])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("layers", [0, 2])
def test_linear_displacements_are_carried_over(
    tmp_path: Path, part: Block, degree: int, layers: int
) -> None:
    geometry: dict[str, Any] = {"file": "pad.inp"}
    supports: dict[str, Any] = {"base": {"boundary": "block_bottom", "fix": ["x", "y"]}}
    if layers:
        geometry["solid"] = {"length": 0.7, "layers": layers}
        supports["front"] = {"boundary": "block_front", "fix": ["z"]}
    found = bond(case(tmp_path, part, model={"degree": degree}, geometry=geometry,
                      supports=supports))  # fmt: skip
    moved, constant = np.random.default_rng(4).normal(size=(2, 3, 3))
    size = found.followers.shape[1]

    def linear(points: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        return np.asarray(points @ moved[:size, :size] + constant[0, :size])

    np.testing.assert_allclose(
        found.image(linear(found.leaders)), linear(found.followers), atol=2e-12
    )
    # the narrow one follows, else the one with more nodes
    names = found.groups[0] + found.groups[1]
    assert names == (("high_bottom", "low_top") if part is NARROW else ("low_top", "high_bottom"))
    if part is SAME:
        assert (found.weights.data == 1.0).all() and len(found.weights.data) == len(found.leaders)


def test_pieces_that_ties_join_are_one(tmp_path: Path) -> None:
    mesh = grouped_mesh(case(tmp_path, SAME))
    assert mesh.bodies["pad"].pieces == 2
    assert "body 'pad' consists of 2 pieces that are tied" in mesh.notes
    third = Block("PAD", "third", np.linspace(6, 7, 3), np.linspace(1, 2, 3))
    found = case(tmp_path, SAME, third)
    joined = "low_bottom, low_top, high_bottom, high_top, is not joined"
    with pytest.raises(ModelError, match=rf"piece 1 of 2 of the body 'pad', .* {joined}"):
        held_model(found, grouped_mesh(found))


def test_boundaries_that_are_apart_are_refused(tmp_path: Path) -> None:
    message = (
        r"ties.glue: expected boundaries in the same place, .* that is 0.01 from the other, \("
    )
    with pytest.raises(CaseError, match=message):
        bond(case(tmp_path, APART))
    beside = Block("PAD", "high", LOW.x + 0.5, SAME.y)
    with pytest.raises(CaseError, match=r"that is 0.5 from the other, \((0|4.5), 2\)"):
        bond(case(tmp_path, beside))


def test_ties_of_what_is_something_else_are_refused(tmp_path: Path) -> None:
    for side, what in (("low_bottom", r"contacts.main.surface1"), ("high_top", "loads.press")):
        tie = {"glue": {"boundary1": "low_top", "boundary2": side}}
        with pytest.raises(CaseError, match=rf"only the tied part acts on, found '{side}', which is"
                           rf" {what}"):  # fmt: skip
            case(tmp_path, SAME, ties=tie)
    with pytest.raises(CaseError, match="expected two boundaries, found 'low_top' twice"):
        case(tmp_path, SAME, ties={"glue": {"boundary1": "low_top", "boundary2": "low_top"}})
    with pytest.raises(MeshError, match=r"no surface, node set or element set HIGH_FLOOR"):
        grouped_mesh(
            case(tmp_path, SAME, ties={"glue": {**TIE["glue"], "boundary2": "high_floor"}})
        )
    with pytest.raises(MeshError, match=r"'low_left' is on pad and 'block_right' on block"):
        ties = {"glue": {"boundary1": "low_left", "boundary2": "block_right"}}
        grouped_mesh(case(tmp_path, SAME, ties=TIE | {"more": ties["glue"]}))


def test_a_contact_surface_ends_at_no_tie(tmp_path: Path) -> None:
    beside = Block("PAD", "high", np.linspace(4, 5, 4), LOW.y)
    ties = {"glue": {"boundary1": "low_right", "boundary2": "high_left"}}
    with pytest.raises(CaseError, match="the contact surface 'low_bottom' at one of them"):
        bond(case(tmp_path, beside, ties=ties))


@pytest.mark.parametrize("held", ["low_left", "high_left"])
def test_the_part_that_is_held_leads(tmp_path: Path, held: str) -> None:
    supports: dict[str, dict[str, Any]] = {
        "base": {"boundary": "block_bottom", "fix": ["x", "y"]},
        "pad": {"boundary": held, "fix": ["x"]},
    }
    found = bond(case(tmp_path, OTHER, supports=supports))
    assert found.groups[1] == ("low_top" if held == "low_left" else "high_bottom",)
    other = "high_left" if held == "low_left" else "low_left"
    both: dict[str, dict[str, Any]] = {**supports, "more": {"boundary": other, "fix": ["x"]}}
    bond(case(tmp_path, OTHER, supports=both))
    both["more"]["fix"] = ["y"]
    with pytest.raises(CaseError, match=r"ties.glue: .* both parts are held alike, found \(0, 2\)"):
        bond(case(tmp_path, OTHER, supports=both))


def test_ties_that_meet_are_refused(tmp_path: Path) -> None:
    right = Block("PAD", "right", np.linspace(4, 5, 4), np.linspace(2, 3, 4))
    ties = {**TIE, "wall": {"boundary1": "high_right", "boundary2": "right_left"}}
    with pytest.raises(CaseError, match="expected ties that do not meet, found two of 'pad' that"):
        bond(case(tmp_path, SAME, right, ties=ties))
