# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sleeves between the plates of a bolt that slip outward to both sides: little but their middle
sticks, and nothing else holds them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks, sectors
from cases.contact_runs import Run, ramp, run

from fretfe._typing import Array, Indices
from fretfe.contact.state import SLIP, STICK
from fretfe.errors import ConvergenceError
from fretfe.mesh.mesh import BodyMesh

# Across half of the bolt: its shank, a gap, a sleeve, and what the plates have beyond it.
SHANK, NEAR, FAR, END = 1.0, 2.0, 5.0, 6.0
# Of the lower plate, the sleeves and the head; the head is the softer one.
BOTTOM, HEIGHT, TOP = -3.0, 6.0, 8.0
STEEL = {"young": 210e3, "poisson": 0.3, "expansion": 1.2e-5, "reference_temperature": 20.0}


def mirrored(half: list[float]) -> Array:
    return np.array([*(-x for x in reversed(half)), *half])


def above(mesh: BodyMesh, side: str, name: str, left: float, right: float) -> dict[str, Indices]:
    """The facets of a boundary between two places along x."""
    facets = mesh.boundaries[f"{mesh.name}_{side}"]
    x = mesh.points[facets[:, :2], 0].mean(axis=1)
    return {name: facets[(x > left) & (x < right)]}


def plate(name: str, y: Array, side: str) -> BodyMesh:
    lines = mirrored([SHANK, NEAR, *np.linspace(NEAR, FAR, 5)[1:], END])
    mesh = blocks.block(name, lines, y, order=2)
    seats = [
        above(mesh, side, f"{name}_{where}", *sorted((sign * NEAR, sign * FAR)))
        for where, sign in (("left", -1), ("right", 1))
    ]
    outer: dict[str, Indices] = {}
    if name == "plate":
        outer["base"] = mesh.boundaries["plate_bottom"]
    return replace(mesh, boundaries=seats[0] | seats[1] | outer)


def bolt() -> BodyMesh:
    shank = blocks.block("shank", [-SHANK, SHANK], np.linspace(0.0, HEIGHT, 5), order=2)
    parts = [
        plate("plate", np.linspace(BOTTOM, 0.0, 4), "top"),
        replace(shank, boundaries={}),
        plate("head", np.linspace(HEIGHT, TOP, 3), "bottom"),
    ]
    return sectors.joined(parts, "bolt")


def sleeve(where: str, sign: int, elements: int) -> BodyMesh:
    lines = np.sort(sign * np.linspace(NEAR, FAR, elements + 1))
    return blocks.block(where, lines, np.linspace(0.0, HEIGHT, 7), order=2)


def clamped(elements: int, friction: float, loads: dict[str, dict[str, Any]], **more: Any) -> Run:
    contacts = {
        f"{end}_{where}": {"surface1": f"{where}_{face}", "surface2": f"{end}_{where}"}
        for where in ("left", "right")
        for end, face in (("plate", "bottom"), ("head", "top"))
    }
    case = {
        "bodies": {"bolt": STEEL, "left": STEEL, "right": STEEL},
        "contacts": {name: {**each, "friction": friction} for name, each in contacts.items()},
        "supports": {"base": {"boundary": "base", "fix": ["x", "y"]}},
        "loads": loads,
        **more,
    }
    sides = {"left": -1, "right": 1}
    return run(case, bolt(), *(sleeve(*each, elements) for each in sides.items()))


def heat(change: float, *bodies: str) -> dict[str, dict[str, Any]]:
    load = {"type": "temperature", "value": 20.0 + change, "bodies": list(bodies)}
    return {"heat": {**load, "history": ramp(1.0)}}


HEATED, COOLED = heat(100.0, "left", "right"), heat(-100.0, "bolt")
PRESSED = {
    f"fit_{where}": {"type": "interference", "contact": f"head_{where}", "history": ramp(0.005)}
    for where in ("left", "right")
}


@pytest.mark.parametrize(
    ("elements", "friction", "loads"),
    [
        pytest.param(9, 0.1, HEATED, id="one way below, the other way above"),
        pytest.param(10, 0.1, COOLED, id="the same with a node in the middle"),
        pytest.param(10, 0.1, PRESSED, id="pressed in"),
        pytest.param(9, 0.3, HEATED, id="held by one node in a contact"),
        pytest.param(10, 0.3, COOLED, id="the bolt cooled"),
        pytest.param(20, 0.3, HEATED, id="fine"),
        pytest.param(9, 0.3, PRESSED, id="pressed in with friction"),
        pytest.param(9, 0.9, HEATED, id="rough"),
        pytest.param(10, 0.9, COOLED, id="rough, the bolt cooled"),
        pytest.param(40, 0.3, HEATED, id="finer", marks=pytest.mark.slow),
        pytest.param(20, 0.9, COOLED, id="rough and fine", marks=pytest.mark.slow),
    ],
)
def test_what_slips_to_both_sides_is_held(
    elements: int, friction: float, loads: dict[str, dict[str, Any]]
) -> None:
    """Left and right are images, to what 1e-12 of displacements that cancel is of a pressure."""
    found = clamped(elements, friction, loads)
    contacts = found.model.reduction.interface.contacts
    tractions, image = found.tractions[-1], np.array([1.0, -1.0])
    assert (found.results[-1].state.status == SLIP).any()
    assert found.results[-1].certificate.worst < 1e-10
    for end in ("plate", "head"):
        left, right = (tractions[contacts[f"{end}_{where}"]] for where in ("left", "right"))
        assert np.abs(left[::-1] - image * right).max() < 1e-9 * np.abs(tractions).max()


def test_a_body_that_slips_both_ways_stays_where_it_slips_least() -> None:
    """By round-off it would be anywhere: twice the load moves it twice as far, by an axis."""
    found = clamped(9, 0.1, HEATED)
    first, last = (each.state for each in found.results)
    assert not (last.status == STICK).any()
    assert np.abs(last.relative[:, 1] - 2 * first.relative[:, 1]).max() < 1e-9


def test_what_is_free_is_named() -> None:
    """Gravity of ten times what friction carries; before that the sleeves slip to both sides."""
    push = {"type": "acceleration", "direction": "x"}
    history = [{"hold": True, "until": 1.0}, {"ramp": 1e9, "until": 2.0, "steps": 1}]
    steel = {name: {**STEEL, "density": 1e-5} for name in ("bolt", "left", "right")}
    with pytest.raises(ConvergenceError, match=r"^step 3 of 3 .* the loads find no resistance"):
        clamped(9, 0.1, {**HEATED, "push": {**push, "history": history}}, bodies=steel)
