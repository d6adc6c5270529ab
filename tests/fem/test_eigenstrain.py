# SPDX-License-Identifier: LGPL-3.0-or-later
"""Layers of initial strain: their stress where a body is held, which a contact does not feel."""

from __future__ import annotations

from typing import Any

import blocks
import numpy as np
import pytest
from contact_runs import Run, run

from fretfe._typing import Array
from fretfe.case import Solid
from fretfe.mesh.load import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh

YOUNG, POISSON = 1000.0, 0.3
DEPTH, STRAIN = 0.2, 2e-3
# Grid lines that include those at which the profile bends.
HEIGHTS = np.concatenate([np.linspace(-0.6, -0.3, 4), np.linspace(-0.25, 0, 6)])


def bodies(solid: bool = False, count: int = 8) -> list[BodyMesh]:
    """A punch with a curved lower side on a block."""

    def lifted(points: Array) -> Array:
        x, y = points.T
        return np.stack([x, y + 0.01 * (0.5 - x) ** 2 * (1 - y / 0.4)], axis=1)

    upper = blocks.block(
        "upper", np.linspace(0.2, 0.8, 7), np.linspace(0, 0.4, 4), order=2, mapping=lifted
    )
    lower = blocks.block("lower", np.linspace(0, 1, count + 1), HEIGHTS, order=2)
    if not solid:
        return [upper, lower]
    return list(
        extrude(Mesh({"upper": upper, "lower": lower}), Solid(length=0.3, layers=2)).bodies.values()
    )


def pressed(plane: str = "strain", solid: bool = False, **loads: Any) -> dict[str, Any]:
    """A block between walls, under a punch that is pressed and sheared."""
    steel = {"young": YOUNG, "poisson": POISSON}
    walls = {"left": "lower_left", "right": "lower_right"}
    supports: dict[str, Any] = {
        "base": {"boundary": "lower_bottom", "fix": ["y"]},
        "punch": {"boundary": "upper_left", "fix": ["x"]},
        **{name: {"boundary": boundary, "fix": ["x"]} for name, boundary in walls.items()},
    }
    if solid:
        ends = [f"{name}_{end}" for name in ("upper", "lower") for end in ("back", "front")]
        supports |= {end: {"boundary": end, "fix": ["z"]} for end in ends}
    press = [{"hold": True, "until": 0.5}, {"ramp": -1.0, "until": 1.0, "steps": 2}]
    push = [{"hold": True, "until": 1.0}, {"ramp": -0.2, "until": 2.0, "steps": 1}]
    top = {"type": "traction", "boundary": "upper_top", "direction": "y", "history": press}
    side = {"type": "traction", "boundary": "upper_right", "direction": "x", "history": push}
    contact = {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
    return {
        "model": {} if solid else {"plane": plane},
        "bodies": {"upper": steel, "lower": steel},
        "contacts": {"main": contact},
        "supports": supports,
        "loads": {**loads, "press": top, "push": side},
    }


def peened(depths: list[float], values: list[float]) -> dict[str, Any]:
    return {
        "type": "eigenstrain",
        "surfaces": ["lower_top"],
        "depths": depths,
        "values": values,
        "history": [{"ramp": 2.0, "until": 0.5, "steps": 1}],
    }


def profile(y: Array, depths: list[float], values: list[float]) -> Array:
    return np.asarray(2 * np.interp(-y, depths, values))


PROFILES = {
    "uniform": ([0.0], [STRAIN]),
    "layer": ([0.0, 0.1, DEPTH], [STRAIN, 1.5 * STRAIN, 0.0]),
}


def stress_of(found: Run) -> tuple[Array, Array]:
    """Depths (m,) and stress (m, 4 or 6) of the block at the nodes of its elements, at the end."""
    last = len(found.results), found.steps[-1].amplitudes if found.steps else None
    count, amplitudes = found.model.comm.bcast(last)
    fields = found.fields(count - 1)
    if "lower" not in fields:
        return np.empty(0), np.empty((0, 4))
    body = found.model.bodies["lower"]
    stress = body.elastic.element_stresses(fields["lower"], body.initial_stress(amplitudes))
    nodes = body.elastic.element_nodes()
    return nodes.reshape(-1, nodes.shape[2])[:, 1], stress.reshape(-1, stress.shape[2])


@pytest.mark.mpi
@pytest.mark.parametrize("name", PROFILES)
@pytest.mark.parametrize(
    ("plane", "solid"), [("strain", False), ("stress", False), ("strain", True)]
)
def test_a_held_body_has_the_stress_and_its_contact_feels_nothing(
    plane: str, solid: bool, name: str
) -> None:
    """sigma = -E/(1 - nu) e in both directions of the surface, -E e in plane stress."""
    depths, values = PROFILES[name]
    treated = run(pressed(plane, solid, peen=peened(depths, values)), *bodies(solid))
    plain = run(pressed(plane, solid), *bodies(solid))
    pressure = np.abs(plain.tractions).max()
    assert pressure > 1.0
    assert np.abs(treated.tractions - plain.tractions).max() < 1e-10 * pressure
    heights, stress = stress_of(treated)
    modulus = YOUNG / (1 - POISSON) if plane == "strain" else YOUNG
    sizes = -modulus * profile(heights, depths, values)
    plain_stress = stress_of(plain)[1]
    if not len(heights):  # of another rank
        return
    expected = np.zeros_like(stress)
    expected[:, 0] = sizes
    expected[:, 2] = sizes if plane == "strain" else 0.0
    expected += plain_stress
    # Exact: lines of the mesh are where the profile bends.
    assert np.abs(stress - expected).max() < 1e-9 * np.abs(sizes).max()


def test_layer_between_lines_of_the_mesh() -> None:
    """The strain is met at the lines of the mesh, and linear in the elements between them."""
    depths, values = [0.0, 0.11, 0.17], [STRAIN, STRAIN, 0.0]
    treated = run(pressed(peen=peened(depths, values)), *bodies())
    plain = run(pressed(), *bodies())
    pressure = np.abs(plain.tractions).max()
    assert np.abs(treated.tractions - plain.tractions).max() < 1e-10 * pressure
    heights, stress = stress_of(treated)
    found = (stress - stress_of(plain)[1])[:, 0]
    at_lines = profile(HEIGHTS, depths, values)
    sizes = -YOUNG / (1 - POISSON) * np.interp(heights, HEIGHTS, at_lines)
    np.testing.assert_allclose(found, sizes, atol=1e-9 * np.abs(sizes).max())
