# SPDX-License-Identifier: LGPL-3.0-or-later
"""Press fits: a ring on a shaft, blocks between walls, and what loads do to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import run
from cases.pad_cases import TOP, cylinder, pad, press, shear

from fretfe._typing import Array
from fretfe.case import Solid
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.reason import Kind
from fretfe.results.model import Result

Solve = Callable[[dict[str, Any]], Result]
YOUNG, POISSON = 1000.0, 0.3
STEEL = {"young": YOUNG, "poisson": POISSON}


def fit(size: float, steps: int = 1, **more: Any) -> dict[str, Any]:
    history = [{"ramp": size, "until": 1.0, "steps": steps}]
    return {"type": "interference", "contact": "main", "history": history, **more}


def polar(points: Array) -> Array:
    radius, angle = points.T
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@pytest.mark.parametrize("plane", ["stress", "strain"])
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_ring_on_a_shaft(plane: str, friction: float) -> None:
    """p = E' d (b^2 - R^2)/(2 R b^2) of a solid shaft; here with a narrow bore, by Lame."""
    bore, radius, outer, overlap = 0.05, 1.0, 2.0, 1e-3
    angles = np.linspace(0, np.pi / 2, 13)
    shaft = blocks.block(
        "shaft", bore * 20 ** np.linspace(0, 1, 13), angles, order=2, mapping=polar
    )
    ring = blocks.block("ring", np.linspace(radius, outer, 9), angles, order=2, mapping=polar)
    contact = {"surface1": "ring_left", "surface2": "shaft_right", "friction": friction}
    data = {
        "model": {"plane": plane},
        "bodies": {"ring": STEEL, "shaft": STEEL},
        "contacts": {"main": contact},
        "supports": {
            f"{name}_{side}": {"boundary": f"{name}_{side}", "fix": [axis]}
            for name in ("ring", "shaft")
            for side, axis in (("bottom", "y"), ("top", "x"))
        },
        "loads": {"fit": fit(overlap, 2)},
    }
    found = run(data, ring, shaft)
    modulus = YOUNG if plane == "stress" else YOUNG / (1 - POISSON**2)
    hub, core = (
        (large**2 + small**2) / (large**2 - small**2)
        for large, small in ((outer, radius), (radius, bore))
    )
    pressure = modulus * overlap / (radius * (hub + core))
    half, whole = found.tractions[0], found.tractions[1]
    assert whole[:, 0] == pytest.approx(pressure, rel=1e-3)
    assert (
        np.abs(whole[:, 1]).max() < 5e-3 * pressure
    )  # mean normals of the last nodes are not those of the walls
    assert half[:, 0] == pytest.approx(whole[:, 0] / 2, rel=1e-9)
    solid = modulus * overlap * (outer**2 - radius**2) / (2 * radius * outer**2)
    assert whole[:, 0].mean() == pytest.approx(solid, rel=0.01)


@pytest.mark.mpi
@pytest.mark.parametrize("solid", [False, True], ids=["plane", "solid"])
def test_blocks_between_walls(solid: bool) -> None:
    """p = M d/(h1 + h2) for the modulus M of uniaxial strain; a gap is closed first."""
    gap, overlap = 0.002, 0.005
    x = np.linspace(0, 1, 4)
    upper = blocks.block("upper", x, np.linspace(gap, 0.6 + gap, 3))
    lower = blocks.block("lower", np.linspace(0, 1, 6), np.linspace(-0.4, 0, 3))
    meshes = {"upper": upper, "lower": lower}
    if solid:
        meshes = extrude(Mesh(meshes), Solid(length=0.4, layers=2)).bodies
    walls = [f"{name}_{side}" for name in meshes for side in ("left", "right")]
    supports = {wall: {"boundary": wall, "fix": ["x"]} for wall in walls}
    for end in ("lower_bottom", "upper_top"):
        supports[end] = {"boundary": end, "fix": ["y"]}
    if solid:
        ends = [f"{name}_{end}" for name in meshes for end in ("back", "front")]
        supports |= {end: {"boundary": end, "fix": ["z"]} for end in ends}
    history = [
        {"ramp": gap + overlap, "until": 1.0, "steps": 2},
        {"ramp": gap / 2, "until": 2.0, "steps": 1},
    ]
    contact = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
    data = {
        "bodies": {"upper": STEEL, "lower": STEEL},
        "contacts": {"main": contact},
        "supports": supports,
        "loads": {"fit": fit(0.0, history=history)},
    }
    found = run(data, *meshes.values())
    stiff = YOUNG * (1 - POISSON) / ((1 + POISSON) * (1 - 2 * POISSON))
    np.testing.assert_allclose(found.tractions[1][:, 0], stiff * overlap, rtol=1e-9)
    np.testing.assert_allclose(found.tractions[1][:, 1:], 0.0, atol=1e-9 * stiff * overlap)
    np.testing.assert_allclose(found.tractions[2], 0.0, atol=1e-12)


def test_an_overlap_of_a_pad_is_an_approach(solved: Solve) -> None:
    """On a flat block it makes no difference, whatever is asked: for pressure or edge factors."""
    fixed = {**TOP, "direction": "y", "control": "displacement"}
    answers = []
    for down, overlap in ((-0.02, 0.0), (0.0, 0.02)):
        loads = {
            "press": {**fixed, "history": [{"ramp": down, "until": 1.0, "steps": 2}]},
            "shear": shear(cycles=1, steps=4),
            "fit": fit(overlap, 2),
        }
        answers.append(solved(pad(geometry=cylinder(size=0.05), loads=loads)))
    pressed, fitted = (each.contacts[0] for each in answers)
    np.testing.assert_allclose(fitted.normal_force, pressed.normal_force, rtol=1e-9)
    for one, other in zip(pressed.stations, fitted.stations, strict=True):
        np.testing.assert_allclose(other.k_n, one.k_n, rtol=1e-8)
        np.testing.assert_allclose(other.k_i, one.k_i, rtol=1e-8, atol=1e-6)
        np.testing.assert_allclose(other.k_t, one.k_t, rtol=1e-8, atol=1e-6)
        assert other.k_n_moved == pytest.approx(one.k_n_moved, rel=1e-6)


def test_an_overlap_of_the_order_of_the_radius_is_told(solved: Solve) -> None:
    """Under a force it makes no difference to the pressure, whatever the radii become."""
    loads = {"press": press(steps=1), "fit": fit(2.0)}
    answer = solved(pad(geometry=cylinder(size=0.2), loads=loads))
    (limit,) = (each for each in answer.limits if "interference" in each.quantity)
    assert limit.found == pytest.approx(2.0 / 50.0, rel=1e-3)
    (warned,) = (each for each in answer.warnings if each.kind is Kind.OVERLAP)
    assert "over the smaller radius of the surfaces is 0.04" in warned.text
