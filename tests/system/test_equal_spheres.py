# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two equal spheres whose meshes are mirror images: pressure does not feel Q, and ±Q returns.

By Masing's rule a cycle of ±Q ends where it began if slip is parallel to the load. With ν = 0 it is
between half-spaces; meshes turn it a little, since shear along x moves their nodes along z too, and
the cycle is approached by a factor of ten per cycle. Without that coupling it returns at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.marching import march_through

from fretfe._typing import Array
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case, Solid, parse_case
from fretfe.contact.interface import DenseCompliance, Interface
from fretfe.contact.march import March
from fretfe.contact.state import StepLoads
from fretfe.fem._compat import MPI
from fretfe.fem.model import build_model, step_loads
from fretfe.fem.run import load_history
from fretfe.fem.timing import Clock
from fretfe.mesh.elements import reversal
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import BodyMesh, Mesh

# The contact radius is 1.
RADIUS, YOUNG, FRICTION, SIZE = 50.0, 2e5, 0.5, 0.2
FORCE = 4 / 3 * YOUNG / RADIUS
PEAK = 3 * FORCE / (2 * np.pi)
SHEAR = 0.4 * FRICTION * FORCE
CYCLES, RISE, STEPS = 6, 4, 12

pytestmark = pytest.mark.slow


def lines(growth: float, fine: int) -> Array:
    """From 0 beyond 9, the first ones apart by SIZE."""
    steps = SIZE * np.concatenate([np.ones(fine), growth ** np.arange(1, 12)])
    ends = np.concatenate([[0.0], np.cumsum(steps)])
    return ends[: int(np.searchsorted(ends, 9.0)) + 1]


def upper() -> BodyMesh:
    """Hexahedra whose lower side is a paraboloid, fine in the middle."""
    half, heights = lines(1.6, 6), lines(1.5, 1)
    x = np.concatenate([-half[:0:-1], half])
    plane = blocks.block("upper", x, heights, cell="quadrilateral")
    body = extrude(Mesh({"upper": plane}), Solid(length=1.0, layers=len(x) - 1)).bodies["upper"]
    points = body.points.copy()
    layer = np.round((points[:, 2] - points[:, 2].min()) * (len(x) - 1)).astype(int)
    points[:, 2] = x[layer]
    rise = (points[:, 0] ** 2 + points[:, 2] ** 2) / (2 * RADIUS)
    points[:, 1] += rise * (1 - points[:, 1] / heights[-1])
    return replace(body, points=points)


def mirrored(body: BodyMesh) -> BodyMesh:
    facets = reversal("quadrilateral", 1)
    names = {name: name.replace("upper", "lower") for name in body.boundaries}
    return replace(
        body,
        name="lower",
        points=body.points * [1, -1, 1],
        cells=body.cells[:, reversal(body.cell, 1)],
        boundaries={names[name]: each[:, facets] for name, each in body.boundaries.items()},
    )


def case() -> Case:
    hold = {"hold": True, "until": 1.0}
    cycles = [
        {"ramp": (-1) ** k * SHEAR, "until": 2.0 + k, "steps": STEPS // 2}
        for k in range(1, 2 * CYCLES + 1)
    ]

    def platen(direction: str, *history: dict[str, Any]) -> dict[str, Any]:
        load = {"type": "platen", "boundary": "upper_top", "direction": direction}
        return {**load, "control": "force", "history": list(history)}

    contact = {"surface1": "upper_bottom", "surface2": "lower_bottom", "friction": FRICTION}
    return parse_case(
        {
            "geometry": {"file": "none.msh"},
            "model": {"degree": 1},
            "bodies": {name: {"young": YOUNG, "poisson": 0.0} for name in ("upper", "lower")},
            "contacts": {"main": contact},
            "supports": {"base": {"boundary": "lower_top", "fix": ["x", "y", "z"]}},
            "loads": {
                "press": platen("y", {"ramp": -FORCE, "until": 1.0, "steps": 1}),
                "shear": platen("x", hold, {"ramp": SHEAR, "until": 2.0, "steps": RISE}, *cycles),
            },
        }
    )


@pytest.fixture(scope="module")
def problem() -> tuple[Interface, Sequence[StepLoads]]:
    body = upper()
    mesh = Mesh({"upper": body, "lower": mirrored(body)})
    prepared = build_model(MPI.COMM_WORLD, case(), Clock(), load=lambda: mesh)
    history = load_history(MPI.COMM_WORLD, case(), DEFAULTS)
    reduction = prepared.model.reduction
    return reduction.interface, step_loads(case(), history, reduction)


def tractions(interface: Interface, steps: Sequence[StepLoads]) -> Array:
    """(T, N, 3) over the peak of the pressure, from the pressed state on."""
    found = [result.state.traction for result in march_through(March(interface), steps)]
    return np.array(found) / interface.roots[:, None] / PEAK


def changes(history: Array) -> Array:
    """Largest change of a traction over each cycle."""
    turns = history[RISE::STEPS]
    return np.abs(np.diff(turns, axis=0)).max(axis=(1, 2))


def test_pressure_does_not_feel_shear_and_the_cycle_settles(
    problem: tuple[Interface, Sequence[StepLoads]],
) -> None:
    history = tractions(*problem)
    assert history[0, :, 0].max() == pytest.approx(1.0, abs=0.03)
    np.testing.assert_allclose(
        history[:, :, 0], history[:1, :, 0].repeat(len(history), 0), atol=1e-10
    )
    found = changes(history)
    # 7.7e-4, 2.6e-5, 4.9e-6, 1.3e-6, 3.7e-7, 1.0e-7
    assert found[0] < 2e-3 and found[-1] < 1e-6
    assert (found[1:] < 0.5 * found[:-1]).all()


def test_cycle_returns_at_once_if_slip_is_parallel_to_the_load(
    problem: tuple[Interface, Sequence[StepLoads]],
) -> None:
    interface, steps = problem
    count = interface.size
    rows = np.arange(3 * count)
    parts = interface.compliance.block(rows, rows).reshape(count, 3, count, 3)
    parts[:, 1, :, 2] = 0.0
    parts[:, 2, :, 1] = 0.0
    compliance = DenseCompliance(parts.reshape(3 * count, 3 * count))
    history = tractions(replace(interface, compliance=compliance), steps)
    # Places opposite are sampled, and normals of meshed surfaces turn by 4e-9 in the contact.
    assert changes(history).max() < 3e-8
    # After half a cycle shear is the opposite.
    half = history[RISE + STEPS // 2, :, 1:] + history[RISE, :, 1:]
    assert np.abs(half).max() < 1e-7
