# SPDX-License-Identifier: LGPL-3.0-or-later
"""The monolithic solver and the condensed path agree on small solids in every step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import Run, run
from reference.monolithic_runs import assert_same, monolithic, statuses

from fretfe._typing import Array
from fretfe.case import Solid
from fretfe.contact.state import OPEN, SLIP, STICK
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh

Data = dict[str, Any]

WIDTH, DEPTH = 0.6, 0.5
BODIES = {
    "pad": {"young": 1000.0, "poisson": 0.2, "density": 1e-3},
    "block": {"young": 2100.0, "poisson": 0.3, "density": 2e-3},
}
CELLS = pytest.mark.parametrize("cell", ["quadrilateral", "triangle"])


def cap(points: Array) -> Array:
    """A lower side with radii of 2 and 3, whose lowest point is no node."""
    x, y, z = points.T
    return np.column_stack([x, y + (1 - y) * ((x - 0.04) ** 2 / 4 + (z - 0.03) ** 2 / 6), z])


def solids(cell: str, order: int) -> list[BodyMesh]:
    """A rounded pad on a wider block, meshes that do not match."""
    x = np.linspace(-WIDTH, WIDTH, 7)
    pad = blocks.block("pad", x, [0.0, 0.3, 1.0], order=order, cell=cell)
    pad = extrude(Mesh({"pad": pad}), Solid(length=2 * DEPTH, layers=4)).bodies["pad"]
    x = np.linspace(-0.9, 0.9, 8)
    block = blocks.block("block", x, [-1.0, -0.4, 0.0], order=order, cell=cell)
    block = extrude(Mesh({"block": block}), Solid(length=1.6, layers=5)).bodies["block"]
    move = np.array([0.0, 0.0, DEPTH]), np.array([0.0, 0.0, 0.8])
    return [
        replace(pad, points=cap(pad.points - move[0])),
        replace(block, points=block.points - move[1]),
    ]


def case(loads: Data, degree: int = 2, supports: Data | None = None, **contact: Any) -> Data:
    main = {"surface1": "pad_bottom", "surface2": "block_top", "friction": 0.4}
    return {
        "model": {"degree": degree},
        "bodies": BODIES,
        "contacts": {"main": main | contact},
        "supports": supports or {"base": {"boundary": "block_bottom", "fix": ["x", "y", "z"]}},
        "loads": loads,
    }


def platen(direction: Any, control: str, *values: float) -> Data:
    """A platen whose load has the given values at the ends of steps."""
    table = {"times": [*map(float, range(len(values) + 1))], "values": [0.0, *values]}
    kind = {"type": "platen", "boundary": "pad_top", "direction": direction, "control": control}
    return kind | {"history": [table]}


def tilt(axis: Any, control: str, *values: float) -> Data:
    kind = {"type": "tilt", "axis": axis, "control": control, "centre": [0.0, 0.0, 0.0]}
    return without(platen("x", "", *values) | kind, "direction")


def without(load: Data, key: str) -> Data:
    return {name: value for name, value in load.items() if name != key}


PRESSED = (-8.0, -20.0, -20.0, -20.0, -20.0)
PRESS = platen("y", "force", *PRESSED)
BOTH_WAYS = {
    "press": PRESS,
    "shear": platen("x", "force", 0.0, 0.0, 4.0, 4.0, -3.0),
    "side": platen("z", "force", 0.0, 0.0, 0.0, 3.0, 4.0),
}
MOVED = {
    "press": platen("y", "displacement", -0.01, -0.025, -0.025, -0.025),
    "shear": platen("x", "displacement", 0.0, 0.0, 0.003, -0.004),
    "side": platen("z", "displacement", 0.0, 0.001, 0.004, 0.004),
}
CASES: dict[str, Data] = {
    "two directions": case(BOTH_WAYS),
    "frictionless preload": case(MOVED, friction_from=2.0),
    "moved": case(MOVED),
    "gross slip": case(MOVED | {"side": platen("z", "displacement", 0.0, 0.01, 0.06, 0.1)}),
    "multipliers on the block": case(MOVED, multipliers="surface2"),
    "lift-off": case({"press": platen("y", "displacement", -0.02, 0.01, -0.02, -0.03)}),
    "tilt": case(
        {
            "press": PRESS,
            "roll": tilt("z", "rotation", 0.0, 0.01, 0.05, 0.05, -0.02),
            "pitch": tilt("x", "moment", 0.0, 0.5, 0.5, -1.0, -1.0),
            "twist": tilt("y", "moment", 0.0, 0.0, 0.4, 0.4, -0.4),
        }
    ),
    "inclined rollers": case(
        {
            "press": PRESS,
            "spin": {
                "type": "rotation",
                "centre": [0.0, -10.0, 0.0],
                "axis": [0.2, 0.0, 1.0],
                "history": [{"ramp": 8.0, "until": 5.0, "steps": 5}],
            },
        },
        supports={
            "base": {"boundary": "block_bottom", "fix": ["y"]},
            "side": {"boundary": "block_right", "direction": [0.8, 0.0, 0.6]},
            "end": {"boundary": "block_front", "fix": ["z"]},
        },
    ),
}


def solved(name: str, cell: str, order: int) -> Run:
    data = CASES[name] | {"model": {"degree": order}}
    return run(data, *solids(cell, order))


@pytest.mark.parametrize("name", CASES)
def test_same_as_condensed(name: str) -> None:
    condensed = solved(name, "triangle", order=1)
    assert_same(condensed, monolithic(condensed))


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_hexahedra_as_condensed(name: str) -> None:
    condensed = solved(name, "quadrilateral", order=1)
    assert_same(condensed, monolithic(condensed))


@pytest.mark.slow
@CELLS
@pytest.mark.parametrize("name", ["two directions", "tilt"])
def test_same_as_condensed_of_degree_two(name: str, cell: str) -> None:
    condensed = solved(name, cell, order=2)
    assert_same(condensed, monolithic(condensed))


def test_cases_stick_and_slip() -> None:
    """The comparison would say little if all nodes were in one state."""
    assert {OPEN, STICK, SLIP} <= statuses(solved("two directions", "triangle", 1))
    sliding = solved("gross slip", "triangle", 1).results[-1].state
    assert not np.any(sliding.status == STICK)
