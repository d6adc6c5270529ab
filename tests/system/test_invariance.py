# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane bodies turned, moved, mirrored, in other units, in another order, bodies exchanged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import ramp
from harness.launch import python
from scipy.spatial import cKDTree

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.history.solution import ContactHistory
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result

SAME = np.eye(2)
ANGLE = np.radians(31.0)
TURN = np.array([[np.cos(ANGLE), -np.sin(ANGLE)], [np.sin(ANGLE), np.cos(ANGLE)]])
MIRROR = np.diag([-1.0, 1.0])
PADS = {"a": -0.5, "b": 0.5}
# Force along the normal, and along the surface, of each pad.
FORCES = {"a": (-3.0, 0.9), "b": (-2.0, -0.6)}
INCH, POUND, METRE = 1 / 25.4, 1 / 4.4482216152605, 1e-3
Name = tuple[str, str]


def rounded(centre: float, points: Array) -> Array:
    """A pad whose lower side has a radius of 0.5."""
    x, y = points.T
    return np.column_stack([x, y + (0.6 - y) / 0.6 * (x - centre) ** 2])


def two_pads() -> Mesh:
    """Two rounded pads on one block, in mm."""
    bodies = {
        name: blocks.block(
            name,
            np.linspace(centre - 0.3, centre + 0.3, 13),
            [0.0, 0.1, 0.3, 0.6],
            order=2,
            mapping=partial(rounded, centre),
        )
        for name, centre in PADS.items()
    }
    bodies["block"] = blocks.block("block", np.linspace(-1, 1, 42), [-0.8, -0.3, -0.1, 0], order=2)
    return Mesh(bodies)


def touching(name: str, exchanged: bool) -> dict[str, Any]:
    """The contact of a pad."""
    surfaces = [f"{name}_bottom", f"block_top_{name}"]
    one, other = reversed(surfaces) if exchanged else surfaces
    return {"surface1": one, "surface2": other, "friction": 0.4}


def case(
    turn: Array = SAME,
    length: float = 1.0,
    force: float = 1.0,
    *,
    backwards: bool = False,
    exchanged: bool = False,
) -> Any:
    """Pressed, then sheared; in other units, or with its tables the other way round."""

    def listed(tables: dict[str, Any]) -> dict[str, Any]:
        return dict(reversed(tables.items())) if backwards else tables

    def platen(name: str, axis: int) -> dict[str, Any]:
        hold: list[dict[str, Any]] = [{"hold": True, "until": 1}] if axis == 0 else []
        move = {**ramp(force * FORCES[name][1 - axis])[0], "until": 2 - axis, "steps": 3 - axis}
        direction = [float(each) for each in turn[:, axis]]
        table = {"type": "platen", "boundary": f"{name}_top", "control": "force"}
        return {**table, "direction": direction, "history": [*hold, move]}

    young = 200.0 * force / length**2
    return parse_case(
        {
            "geometry": {"file": "none.msh"},
            "model": {"thickness": length},
            "bodies": listed({n: {"young": young, "poisson": 0.3} for n in ("a", "b", "block")}),
            "contacts": listed({name: touching(name, exchanged) for name in PADS}),
            "loads": listed({f"{n}{i}": platen(n, i) for n in PADS for i in (1, 0)}),
            "supports": listed(
                {
                    f"base_{axis}": {
                        "boundary": "block_bottom",
                        "direction": [float(each) for each in turn[:, axis]],
                    }
                    for axis in range(2)
                }
            ),
        }
    )


def mesh(change: Callable[[Array], Array] = lambda x: x, *, backwards: bool = False) -> Mesh:
    """The bodies, moved; the upper side of the block is a surface for each pad."""
    bodies = {}
    for name, body in two_pads().bodies.items():
        sides = dict(body.boundaries)
        if name == "block":
            top = sides.pop("top", None)
            top = sides.pop("block_top") if top is None else top
            left = body.points[top].mean(axis=1)[:, 0] < 0
            sides |= {"block_top_a": top[left], "block_top_b": top[~left]}
        bodies[name] = replace(body, points=change(body.points), boundaries=sides)
    return Mesh(dict(reversed(bodies.items())) if backwards else bodies)


def mirrored(body_mesh: Mesh) -> Mesh:
    """The image in x = 0, its cells and facets the right way round."""
    order = [1, 0, 3, 2, 4, 7, 6, 5, 8]
    return Mesh(
        {
            name: replace(
                body,
                points=body.points @ MIRROR,
                cells=body.cells[:, order],
                boundaries={key: each[:, [1, 0, 2]] for key, each in body.boundaries.items()},
            )
            for name, body in body_mesh.bodies.items()
        }
    )


def solved(changed: Any, bodies: Mesh) -> Result:
    result = solve(MPI.COMM_WORLD, changed, load=lambda: bodies)
    assert result.failure is None
    return result


def contact(result: Result, name: str) -> ContactHistory:
    return next(each for each in result.solution.contacts if each.name == name)


def vectors(history: ContactHistory) -> Array:
    """(T, N, 2) traction on body 2 in the axes of the case."""
    signed = np.asarray(history.traction) * np.array([-1.0, 1.0])
    return np.einsum("tnc,ncd->tnd", signed, history.surface.frames)


@pytest.fixture(scope="module")
def original() -> Result:
    return solved(case(), mesh())


def difference(found: Result, original: Result, turn: Array, stress: float = 1.0) -> float:
    """The largest difference of tractions at the same nodes, over the largest traction."""
    worst = 0.0
    for name in PADS:
        one, other = contact(original, name), contact(found, name)
        expected, seen = vectors(one) @ turn.T, vectors(other) / stress
        worst = max(worst, float(np.abs(seen - expected).max() / np.abs(expected).max()))
    return worst


CHANGES: dict[str, tuple[dict[str, Any], dict[str, Any], Array, float]] = {
    "turned": ({"turn": TURN}, {"change": lambda x: x @ TURN.T}, SAME, 1.0),
    "moved by 1 m": ({}, {"change": lambda x: x + 1000.0}, SAME, 1.0),
    "in metres": ({"length": METRE}, {"change": lambda x: METRE * x}, SAME, METRE**-2),
    "in inches and pounds": (
        {"length": INCH, "force": POUND}, {"change": lambda x: INCH * x}, SAME, POUND / INCH**2,
    ),
    "in another order": ({"backwards": True}, {"backwards": True}, SAME, 1.0),
}  # fmt: skip
# Round-off of the factors of the bodies, and of places 1 m away from the origin.
TOLERANCE = 1e-9


def test_it_slips_in_part(original: Result) -> None:
    for name in PADS:
        assert set(np.unique(contact(original, name).status[-1])) == {0, 1, 2}


@pytest.mark.parametrize("name", CHANGES)
def test_the_same_answer(original: Result, name: str) -> None:
    table, moved, _, stress = CHANGES[name]
    found = solved(case(**table), mesh(**moved))
    turn = table.get("turn", SAME)
    assert difference(found, original, turn, stress) < TOLERANCE


def test_mirrored(original: Result) -> None:
    found = solved(case(MIRROR), mirrored(mesh()))
    for name in PADS:
        one, other = contact(original, name), contact(found, name)
        distance, rows = cKDTree(one.surface.points @ MIRROR).query(other.surface.points)
        assert distance.max() < 1e-12
        expected = (vectors(one) @ MIRROR)[:, rows]
        assert np.abs(vectors(other) - expected).max() < TOLERANCE * np.abs(expected).max()


def test_exchanged_bodies(original: Result) -> None:
    """The tractions are carried by the same surface; gaps are measured along the other normal."""
    found = solved(case(exchanged=True), mesh())
    for name in PADS:
        one, other = contact(original, name), contact(found, name)
        distance, rows = cKDTree(one.surface.points).query(other.surface.points)
        assert distance.max() < 1e-12
        change = vectors(other) + vectors(one)[:, rows]
        assert np.abs(change).max() < 0.02 * np.abs(vectors(one)).max()
        force = np.asarray(next(c for c in found.contacts if c.name == name).normal_force)
        np.testing.assert_allclose(force[-1], -FORCES[name][0], rtol=1e-6)


ON_RANKS = """
import sys
sys.path[:0] = [{tests!r}, {folder!r}]
from fretfe.fem._compat import MPI
import numpy as np
import test_invariance as own
result = own.solved(own.case(), own.mesh())
if MPI.COMM_WORLD.rank == 0:
    np.savez({target!r}, **{{name: own.vectors(own.contact(result, name)) for name in own.PADS}})
"""


@pytest.mark.parametrize("ranks", [2, 3])
def test_on_several_ranks(original: Result, tmp_path: Path, ranks: int) -> None:
    folder, target = Path(__file__).parent, tmp_path / "found.npz"
    names = {"tests": str(folder.parent), "folder": str(folder), "target": str(target)}
    done = python("-c", ON_RANKS.format(**names), ranks=ranks)
    assert done.returncode == 0, done.stderr
    with np.load(target) as found:
        for name in PADS:
            expected = vectors(contact(original, name))
            assert np.abs(found[name] - expected).max() < TOLERANCE * np.abs(expected).max()
