# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that push or turn where nothing resists are refused, and only those."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors

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
    with pytest.raises(
        CaseError, match=r"supports.hub.fix: expected 'radial' at a body with sides"
    ):
        on_sector(supports={"hub": {"boundary": "pad_left", "fix": ["radial"]}})


def slid(friction: float, x: float, **platen: Any) -> None:
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
            "push": {**top, "direction": [x, -1], **platen},
        },
    }
    upper = blocks.block("upper", [0.0, 0.5, 1.0], [0.0, 0.5])
    carried(case, upper, blocks.block("lower", [-1.0, 0.0, 1.0, 2.0], [-1.0, 0.0]))


def test_what_only_contact_holds_slides_without_friction() -> None:
    """A traction of 1 along (1, -1) over a width of 1."""
    slid(0.3, 1.0)
    slid(0.0, 0.0)
    with pytest.raises(CaseError, match=r"loads.push: .* a force of 0.707\d* .* move along x$"):
        slid(0.0, 1.0)
