# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that push or turn where nothing resists are refused, and only those."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors

from fretfe._typing import Array
from fretfe.bodies.carried import require_carried
from fretfe.case import parse_case
from fretfe.errors import CaseError
from fretfe.loads import build_history
from fretfe.mesh.mesh import BodyMesh, Mesh

ENDS_AT_ZERO = [{"ramp": 2.0, "until": 1.0, "steps": 1}, {"ramp": 0.0, "until": 2.0, "steps": 1}]


def carried(data: dict[str, Any], *meshes: BodyMesh) -> None:
    case = parse_case({"geometry": {"file": "none.msh"}, **data})
    require_carried(case, Mesh({each.name: each for each in meshes}), build_history(case))


def on_sector(*loads: dict[str, Any], **tables: Any) -> None:
    """A spinning sector with loads on its outside."""
    case = sectors.spinning(1, symmetry=sectors.cyclic(), **tables)
    for number, load in enumerate(loads):
        case["loads"][f"own{number}"] = {"boundary": "ring_right", **load}
    carried(case, sectors.ring(), sectors.pad())


def force(x: float, y: float, **keys: Any) -> dict[str, Any]:
    return {"type": "force", "direction": [x, y], "history": sectors.ramp(2.0), **keys}


def test_a_torque_that_nothing_carries_is_refused() -> None:
    """A force of 2 along y through the middle of an arc of ±45°, at 1.4 sin 45°/(π/4)."""
    torque = 2 * 1.4 * np.sin(np.pi / 4) / (np.pi / 4)
    text = rf"loads.own0: .*tangential.* a torque of {torque:.3g}\d* .* turn about \(0, 0\)"
    with pytest.raises(CaseError, match=text):
        on_sector(force(0, 1))
    with pytest.raises(CaseError, match=r"loads.own0: expected"):
        on_sector(force(0, 1, history=ENDS_AT_ZERO))
    # Among larger loads, too.
    with pytest.raises(CaseError, match=r"loads.own1: expected"):
        on_sector(force(1e6, 0), force(0, 1))


def test_torques_that_balance_or_that_a_support_carries() -> None:
    on_sector(force(1, 0))
    on_sector(force(0, 1), force(0, -1))
    on_sector({"type": "traction", "direction": "normal", "history": sectors.ramp(1.0)})
    hub = {"boundary": "ring_right", "fix": ["tangential"]}
    on_sector(force(0, 1), supports={"hub": hub})
    with pytest.raises(CaseError, match=r"loads.own0"):
        on_sector(force(0, 1), supports={"hub": {**hub, "fix": ["radial"]}})


@pytest.mark.parametrize(
    ("fix", "named"),
    [
        (["radial"], "'radial'"),
        (["radial", "tangential"], "'radial' and 'tangential'"),
        (["x", "tangential"], "'tangential'"),
    ],
)
def test_a_body_without_sides_has_no_directions_about_an_axis(fix: list[str], named: str) -> None:
    with pytest.raises(CaseError) as caught:
        on_sector(supports={"hub": {"boundary": "pad_left", "fix": fix}})
    assert f"supports.hub.fix: expected {named} at a body with sides" in str(caught.value)


def test_what_a_hub_holds_both_ways_moves_nothing() -> None:
    """A force along x is radial in part and tangential in part."""
    hub = {"boundary": "ring_right", "fix": ["radial", "tangential"]}
    with pytest.raises(CaseError, match=r"loads.own0.boundary: expected a boundary that can move"):
        on_sector(force(1, 0), supports={"hub": hub})


def slid(friction: float, x: float, **tables: Any) -> None:
    """A block on a larger one that is held, pressed and pushed along x."""
    top = {"type": "traction", "boundary": "upper_top", "history": sectors.ramp(1.0)}
    case = {
        "bodies": {name: {"young": 200.0, "poisson": 0.3} for name in ("upper", "lower")},
        "contacts": {
            "seat": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": friction}
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
        "loads": {
            "press": {**top, "direction": [0, -1]},
            "push": {**top, "direction": [x, -1]},
        },
        **tables,
    }
    upper = blocks.block("upper", [0.0, 0.5, 1.0], [0.0, 0.5])
    carried(case, upper, blocks.block("lower", [-1.0, 0.0, 1.0, 2.0], [-1.0, 0.0]))


def test_what_only_contact_holds_slides_without_friction() -> None:
    """A traction of 1 along (1, -1) over a width of 1."""
    slid(0.3, 1.0)
    slid(0.0, 0.0)
    with pytest.raises(CaseError, match=r"loads.push: .* a force of 0.707\d* .* move along x$"):
        slid(0.0, 1.0)


def pressed_and_pushed(shear: float) -> dict[str, Any]:
    """Platens with a normal force and a shear force, as `loads`."""
    top = {"type": "platen", "boundary": "upper_top", "control": "force"}
    return {
        "press": {**top, "direction": "y", "history": sectors.ramp(-600.0)},
        "push": {**top, "direction": "x", "history": sectors.ramp(shear)},
    }


def test_a_platen_that_does_not_push_may_slide() -> None:
    """P does no work in the motion along the surface but for round-off."""
    slid(0.0, 0.0, loads=pressed_and_pushed(0.0))


def test_a_platen_that_pushes_without_friction_is_named() -> None:
    with pytest.raises(CaseError, match=r"loads.push: .* a force of 1 N"):
        slid(0.0, 0.0, loads=pressed_and_pushed(1.0))


FACES = {
    "frame": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.0},
    "seat": {"surface1": "lower_bottom", "surface2": "ground_top", "friction": 0.0},
}


def stacked(push: dict[str, Any], friction: float = 0.0, **tables: Any) -> None:
    """A block on a slide, whose ends it cannot pass, on a ground that is held."""
    grid = np.linspace(0.0, 1.0, 5)

    def hollow(points: Array) -> Array:
        depth = np.clip(points[:, 1] + 1.0, 0.0, 1.0)  # of the bodies above the ground
        return points + np.outer(4 * (points[:, 0] - 0.5) ** 4 * depth, [0.0, 1.0])

    meshes = (
        blocks.block("upper", grid, [0.0, 0.5], mapping=hollow),
        blocks.block("lower", grid, [-1.0, 0.0], mapping=hollow),
        blocks.block("ground", [-1.0, 0.5, 2.0], [-2.0, -1.0]),
    )
    steel = {"young": 200.0, "poisson": 0.3, "density": 3.0}
    press = {"type": "traction", "boundary": "upper_top", "direction": [0, -1]}
    case = {
        "bodies": {each.name: steel for each in meshes},
        "contacts": {**FACES, "frame": {**FACES["frame"], "friction": friction}},
        "supports": {"base": {"boundary": "ground_bottom", "fix": ["x", "y"]}},
        "loads": {"press": {**press, "history": sectors.ramp(1.0)},
                  "push": {"history": sectors.ramp(1.0), **push}},
        **tables,
    }  # fmt: skip
    carried(case, *meshes)


PUSH = {"type": "force", "boundary": "upper_left", "direction": "x"}


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_bodies_that_slide_together_are_judged_together(friction: float) -> None:
    """The block is held in the hollow of the slide, with friction or without; both slide."""
    with pytest.raises(CaseError) as caught:
        stacked(PUSH, friction)
    assert "loads.push: expected a support" in str(caught.value)
    assert "a force of 1 N/mm" in str(caught.value)
    assert str(caught.value).endswith("found 'upper' and 'lower' free to move along x")
    stacked({**PUSH, "direction": "y"}, friction)


def test_body_forces_push_what_only_slides() -> None:
    """Weights of the block and the slide under it, aslant."""
    gravity = {"type": "acceleration", "direction": [0.6, -0.8], "history": sectors.ramp(2.0)}
    with pytest.raises(CaseError) as caught:
        stacked(gravity)
    # Density 3, 2 * .6 along x; straight sides between heights of 1/4, 1/64, 0, 1/64 and 1/4.
    area = 0.5 + 1 + (0.25 + 2 / 64) / 4
    assert f"a force of {3 * area * 1.2:.3g}" in str(caught.value)
    assert "loads.push" in str(caught.value) and "loads.press" not in str(caught.value)
    stacked({**gravity, "direction": "y"})
    with pytest.raises(CaseError, match=r"loads\.push"):
        stacked({"type": "rotation", "centre": [9.0, 0.0]})


def test_only_loads_along_the_free_motion_are_named() -> None:
    """A platen is pressed and pushed, without friction: only the push has nothing to carry it."""
    platen = {"type": "platen", "boundary": "upper_top", "control": "force"}
    top: dict[str, Any] = {"press": {**platen, "direction": "y", "history": sectors.ramp(-5.0)},
           "shear": {**platen, "direction": "x", "history": sectors.ramp(1.0)}}  # fmt: skip
    with pytest.raises(CaseError, match=r"loads.shear: .* a force of 1 N/mm") as caught:
        stacked({}, loads=top)
    assert "press" not in str(caught.value)
    top["press"]["direction"], top["shear"]["direction"] = [0.6, -0.8], [0.8, 0.6]
    with pytest.raises(CaseError, match=r"loads.press: .* \(with loads.shear\)$"):
        stacked({}, loads=top)


@pytest.mark.parametrize(
    ("support", "load"),
    [
        ({"boundary": "upper_left", "fix": ["x"]}, {"direction": "normal"}),
        ({"boundary": "upper_left", "direction": [1.0, 1.0]}, {"direction": "normal"}),
        ({"boundary": "left_again", "fix": ["x", "y"]}, {"direction": "y"}),
        ({"boundary": "left_again", "fix": ["x"]}, {"direction": [1.0, 5.0]}),
    ],
    ids=["normal", "roller", "same-nodes", "in-part"],
)
def test_loads_on_nodes_that_are_held_are_refused(
    support: dict[str, Any], load: dict[str, Any]
) -> None:
    """Held by the boundary of the load, whose normal the mesh knows, or by one with its nodes."""
    with pytest.raises(CaseError) as caught:
        held_left(support, load)
    assert "loads.push.boundary: expected a boundary that can move along its load" in str(
        caught.value
    )
    assert "'hold" in str(caught.value)


@pytest.mark.parametrize(
    ("support", "load"),
    [
        ({"boundary": "upper_left", "fix": ["y"]}, {"direction": "normal"}),
        ({"boundary": "left_again", "fix": ["x"]}, {"direction": "y"}),
        ({"boundary": "upper_bottom", "fix": ["x", "y"]}, {"direction": "normal"}),
    ],
    ids=["across", "same-nodes-across", "corner"],
)
def test_loads_across_what_is_held_act(support: dict[str, Any], load: dict[str, Any]) -> None:
    held_left(support, load)


def held_left(support: dict[str, Any], load: dict[str, Any]) -> None:
    """A block with a load on its left side, which a support holds, pressed by another one."""
    block = blocks.block("upper", [0.0, 0.5, 1.0], [0.0, 0.5])
    block = replace(
        block, boundaries={**block.boundaries, "left_again": block.boundaries["upper_left"]}
    )
    other = blocks.block("lower", [1.0, 2.0], [-1.0, 0.0, 1.0])
    push = {"type": "traction", "boundary": "upper_left", "history": sectors.ramp(1.0), **load}
    steel = {"young": 200.0, "poisson": 0.3}
    case = {
        "bodies": {"upper": steel, "lower": steel},
        "contacts": {
            "seat": {"surface1": "upper_right", "surface2": "lower_left", "friction": 0.3}
        },
        "supports": {"base": {"boundary": "lower_right", "fix": ["x", "y"]}, "hold": support},
        "loads": {"push": push},
    }
    carried(case, block, other)
