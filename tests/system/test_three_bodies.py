# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shim or a roller between two pads: two contacts that are equal by symmetry."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import Run, run
from cases.pad_cases import as_field

from fretfe._typing import Array

STEEL = {"young": 200e3, "poisson": 0.3}
WARM = {**STEEL, "expansion": 1e-4, "reference_temperature": 20.0}
RADIUS, HEIGHT, SHIM = 40.0, 4.0, 0.5
PRESS, SHEAR = -900.0, 150.0


def pad(points: Array) -> Array:
    """A block above y = 0 whose lower side is a cylinder, on a shim of twice SHIM."""
    x, y = points.T
    return np.stack([x, SHIM + y + (1 - y / HEIGHT) * x**2 / (2 * RADIUS)], axis=1)


def mirrored(points: Array) -> Array:
    """The pad turned by half a circle."""
    return -pad(points)


def barrel(points: Array) -> Array:
    """A shim whose sides are cylinders."""
    x, y = points.T
    return np.stack([x, y * (1 - x**2 / (2 * RADIUS * SHIM))], axis=1)


def stack(shear: float, middle: Callable[[Array], Array] | None, **heat: dict[str, Any]) -> Run:
    """Two pads on either side of a shim, perhaps mapped or hot, that nothing but they hold."""
    fine = np.concatenate([[-3.0, -1.6], np.linspace(-0.8, 0.8, 17), [1.6, 3.0]])
    rise = np.array([0.0, 0.2, 0.6, 1.5, HEIGHT])
    upper = blocks.block("upper", fine, rise, mapping=pad, order=2)
    lower = blocks.block("lower", fine, rise, mapping=mirrored, order=2)
    shim = blocks.block("shim", fine, np.linspace(-SHIM, SHIM, 5), mapping=middle, order=2)
    platen = {"type": "platen", "boundary": "upper_top", "control": "force"}
    wave = {"wave": "sine", "amplitude": shear, "period": 1.0, "cycles": 1, "steps_per_cycle": 4}
    waiting = [{"hold": True, "until": 1.0}, wave]
    case: dict[str, Any] = {
        "bodies": {"upper": STEEL, "shim": WARM, "lower": STEEL},
        "contacts": {
            "top": {"surface1": "upper_bottom", "surface2": "shim_top", "friction": 0.5},
            "bottom": {"surface1": "lower_bottom", "surface2": "shim_bottom", "friction": 0.5},
        },
        "supports": {"base": {"boundary": "lower_top", "fix": ["x", "y"]}},
        "loads": {
            **heat,
            "press": {
                **platen,
                "direction": "y",
                "history": [{"ramp": PRESS, "until": 1.0, "steps": 2}],
            },
            "shear": {**platen, "direction": "x", "history": waiting},
        },
    }
    return run(case, upper, shim, lower)


@pytest.mark.mpi
@pytest.mark.parametrize("middle", [None, barrel], ids=["flat", "cylinders"])
def test_both_contacts_of_a_shim_are_equal_by_symmetry(
    middle: Callable[[Array], Array] | None,
) -> None:
    """Turned by half a circle the stack is itself, and so are pressure and shear."""
    found = stack(SHEAR, middle)
    interface = found.model.comm.bcast(
        found.model.reduction.interface.contacts if found.model.comm.rank == 0 else None
    )
    top, bottom = (found.tractions[:, interface[name]] for name in ("top", "bottom"))
    scale = np.abs(top).max()
    assert (top[-1][:, 0] > 1e-3 * scale).sum() > 5
    assert np.abs(top[-2][:, 1]).max() > 0.05 * scale
    np.testing.assert_allclose(bottom, top, atol=1e-9 * scale)


def test_a_shim_that_another_run_heats(tmp_path: Path) -> None:
    """The temperatures are those of the shim alone; linear across it they bend it."""
    half = [{"ramp": 0.5, "until": 1.0, "steps": 1}]
    hot = {"type": "temperature", "bodies": ["shim"], "history": half}
    points = {"points": [[0.0, -5.0], [0.0, 5.0]], "values": [320.0, 20.0]}
    field = as_field(hot, tmp_path, 5.0, lambda x, y: 170.0 - 30.0 * y)
    loads: list[dict[str, Any]] = [{}, {"heat": {**hot, **points}}, {"heat": field}]
    cold, expected, found = (stack(SHEAR, None, **each).tractions for each in loads)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, atol=1e-9 * scale)
    assert np.abs(expected - cold).max() > 0.01 * scale
