# SPDX-License-Identifier: LGPL-3.0-or-later
"""Inclined rollers and platens that tilt."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import ramp

from fretfe.case import parse_case
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.results.model import Result

ANGLE = 25.0
HISTORY = {"press": ramp(-0.03), "shear": ramp(0.004)}


def run(case: dict[str, Any], *meshes: BodyMesh) -> Result:
    whole = parse_case({"geometry": {"file": "none.msh"}, **case})
    return solve(MPI.COMM_WORLD, whole, load=lambda: Mesh({each.name: each for each in meshes}))


def turned(vector: Sequence[float], angle: float) -> list[float]:
    return [float(v) for v in blocks.rotated(angle)(np.array([vector]))[0]]


def on_rollers(angle: float) -> Result:
    """A block pressed and sheared by a guided platen on one whose base and side roll; turned.

    The corner of base and side is on two rollers, that of side and contact is a contact node.
    """
    names = ("upper", "lower")
    platen = {"type": "platen", "boundary": "upper_top", "control": "displacement"}
    along = {"press": turned([0, 1], angle), "shear": turned([1, 0], angle)}
    case = {
        "bodies": {name: {"young": 200.0, "poisson": 0.3} for name in names},
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.4}
        },
        "loads": {
            name: {**platen, "direction": along[name], "history": HISTORY[name]} for name in along
        },
        "supports": {
            "base": {"boundary": "lower_bottom", "direction": along["press"]},
            "side": {"boundary": "lower_left", "direction": along["shear"]},
        },
    }
    mapping = blocks.rotated(angle)
    upper = blocks.block("upper", [0.1, 0.45, 0.9], [0, 0.5, 1.0], order=2, mapping=mapping)
    lower = blocks.block("lower", [0.0, 0.3, 0.6, 1.2], [-1.0, 0.0], order=2, mapping=mapping)
    return run(case, upper, lower)


@pytest.mark.mpi
def test_inclined_rollers_hold_as_those_along_the_axes_do() -> None:
    straight, inclined = on_rollers(0.0), on_rollers(ANGLE)
    if straight.root_solution is None:  # another rank than the first one
        return
    tractions = [np.asarray(each.solution.contacts[0].traction) for each in (straight, inclined)]
    assert np.abs(tractions[0]).max() > 1.0
    np.testing.assert_allclose(tractions[1], tractions[0], atol=1e-9 * tractions[0].max())
    forces = [each.solution.forces for each in (straight, inclined)]
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-9 * np.abs(forces[0]).max())
    for name in ("force", "moment"):
        parts = inclined.solution.certificates
        assert (parts[f"{name}_imbalance"] < 1e-10 * parts[f"{name}_scale"].max()).all()


def tilting(control: str, value: float, centre: float = 0.5) -> Result:
    """A block pressed down by a platen that tilts about (centre, 1)."""
    names = ("upper", "lower")
    platen = {"type": "platen", "boundary": "upper_top", "direction": "y"}
    case = {
        "bodies": {name: {"young": 200.0, "poisson": 0.3} for name in names},
        "contacts": {
            "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.4}
        },
        "loads": {
            "press": {**platen, "control": "force", "history": ramp(-1.0)},
            "tilt": {
                "type": "tilt",
                "boundary": "upper_top",
                "centre": [centre, 1.0],
                "control": control,
                "history": ramp(value),
            },
        },
        "supports": {"base": {"boundary": "lower_bottom", "fix": ["x", "y"]}},
    }
    upper = blocks.block("upper", [0.0, 0.25, 0.5, 0.75, 1.0], [0, 0.5, 1.0], order=2)
    lower = blocks.block("lower", [-0.5, 0.0, 0.5, 1.0, 1.5], [-1.0, 0.0], order=2)
    return run(case, upper, lower)


def moment_on_platen(found: Result, centre: float) -> float:
    """Moment about (centre, 1) that balances what the contact does to the upper block."""
    contact = found.solution.contacts[0]
    p, q = (contact.surface.weights[:, None] * np.asarray(contact.mean_traction[-1])).T
    # The shear on the upper block is -q, a unit of length below the axis.
    return float(q.sum() - p @ (contact.surface.points[:, 0] - centre))


def test_a_platen_that_tilts_freely_passes_on_no_moment() -> None:
    found = tilting("moment", 0.0, 0.4)
    assert moment_on_platen(found, 0.4) == pytest.approx(0.0, abs=1e-10)
    assert abs(found.solution.amplitudes[-1, found.solution.coordinates.index("tilt")]) > 1e-5


def test_moment_and_rotation_of_a_tilt_are_conjugate() -> None:
    by_moment = tilting("moment", 0.05)
    names = by_moment.solution.coordinates
    turn = float(by_moment.solution.amplitudes[-1, names.index("tilt")])
    assert turn > 0  # anticlockwise
    assert moment_on_platen(by_moment, 0.5) == pytest.approx(0.05, rel=1e-9)
    by_turn = tilting("rotation", turn)
    assert by_turn.solution.forces[-1, names.index("tilt")] == pytest.approx(0.05, rel=1e-9)
    parts = by_turn.solution.certificates
    for name in ("force", "moment"):
        assert (parts[f"{name}_imbalance"] < 1e-10 * parts[f"{name}_scale"].max()).all()
