# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solids turned, moved, mirrored, in other units, in another order, with bodies exchanged."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cases import blocks
from cases.contact_runs import ramp
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from fretfe._typing import Array
from fretfe.case import Solid, parse_case
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.history.solution import ContactHistory
from fretfe.materials.crystals import bunge_rotation
from fretfe.mesh.extrusion import extrude
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result

UNITS = np.eye(3)
# Of the pad on the block.
MIDDLE = np.array([0.0, 0.0, 0.2])
TURN = Rotation.from_euler("zyx", [31, -57, 112], degrees=True).as_matrix()
ALONG_X, ALONG_Z = (
    [{"hold": True, "until": 1}, *ramp(0.9)],
    [{"hold": True, "until": 1}, *ramp(-0.4)],
)
for segments in (ALONG_X, ALONG_Z):
    segments[1]["until"] = 2
    segments[1]["steps"] = 3


def rounded(points: Array) -> Array:
    """A pad whose lower side has a radius of 2."""
    x, y = points.T
    return np.column_stack([x, y + (1 - y) * x**2 / 4])


def pad_on_block() -> Mesh:
    """A rounded pad, shorter than the block that it is pressed on; free ends."""
    upper = blocks.block(
        "pad", np.linspace(-0.5, 0.5, 9), [0.0, 0.3, 1.0], order=2, mapping=rounded
    )
    lower = blocks.block("block", np.linspace(-0.8, 0.8, 8), [-1.0, -0.3, 0.0], order=2)
    pad = extrude(Mesh({"pad": upper}), Solid(length=0.5, layers=2)).bodies["pad"]
    base = extrude(Mesh({"block": lower}), Solid(length=0.9, layers=3)).bodies["block"]
    return Mesh({"pad": replace(pad, points=pad.points + MIDDLE), "block": base})


def case(
    turn: Array = UNITS,
    length: float = 1.0,
    surfaces: tuple[str, str] = ("pad_bottom", "block_top"),
    body: dict[str, Any] | None = None,
) -> Any:
    """Pressed, then sheared in two directions; forces in the same unit, lengths in another."""

    def direction(axis: int) -> list[float]:
        return [float(value) for value in turn[:, axis]]

    platen = {"type": "platen", "boundary": "pad_top", "control": "force"}
    return parse_case(
        {
            "geometry": {"file": "none.msh"},
            "bodies": {
                name: body or {"young": 1000.0 / length**2, "poisson": 0.3}
                for name in ("pad", "block")
            },
            "contacts": {
                "main": {"surface1": surfaces[0], "surface2": surfaces[1], "friction": 0.4}
            },
            "loads": {
                "press": {**platen, "direction": direction(1), "history": ramp(-4.0)},
                "shear": {**platen, "direction": direction(0), "history": ALONG_X},
                "cross": {**platen, "direction": direction(2), "history": ALONG_Z},
            },
            "supports": {
                f"base_{axis}": {
                    "boundary": "block_bottom",
                    "direction": direction(axis),
                }
                for axis in range(3)
            },
        }
    )


def moved(mesh: Mesh, change: Callable[[Array], Array]) -> Mesh:
    return Mesh(
        {name: replace(each, points=change(each.points)) for name, each in mesh.bodies.items()}
    )


def solved(case: Any, mesh: Mesh) -> Result:
    return solve(MPI.COMM_WORLD, case, load=lambda: mesh)


def vectors(contact: ContactHistory) -> Array:
    """(T, N, 3) traction on body 2 in the axes of the case."""
    signed = np.asarray(contact.traction) * np.array([-1.0, 1.0, 1.0])
    return np.einsum("tnc,ncd->tnd", signed, contact.surface.frames)


@pytest.fixture(scope="module")
def original() -> Result:
    return solved(case(), pad_on_block())


def assert_same(found: Array, expected: Array, tolerance: float = 1e-8) -> None:
    np.testing.assert_allclose(found, expected, atol=tolerance * np.abs(expected).max())


def contact_of(result: Result) -> ContactHistory:
    assert result.failure is None
    for name in ("force", "moment"):
        parts = result.solution.certificates
        assert (parts[f"{name}_imbalance"] < 1e-8 * parts[f"{name}_scale"].max()).all()
    return result.solution.contacts[0]


def test_it_slips_in_part(original: Result) -> None:
    contact = contact_of(original)
    assert set(np.unique(contact.status[-1])) == {0, 1, 2}
    assert_same(original.contacts[0].shear_force[-1], np.array([0.9, 0.0, -0.4]), 1e-3)


def test_turned_as_a_whole(original: Result) -> None:
    turned = solved(case(TURN), moved(pad_on_block(), lambda x: x @ TURN.T + [3.0, -2.0, 1.0]))
    first, second = contact_of(original), contact_of(turned)
    assert_same(vectors(second), vectors(first) @ TURN.T)
    assert_same(np.asarray(second.gap), np.asarray(first.gap))
    assert_same(turned.contacts[0].force, original.contacts[0].force @ TURN.T)


def test_crystals_turned_with_their_bodies() -> None:
    def crystals(turn: Array) -> Any:
        axes = (bunge_rotation((20.0, 40.0, 70.0)) @ turn.T).tolist()
        elastic = {"cubic": [1350.0, 860.0, 700.0]}
        return case(turn, body={"elastic": elastic, "orientation": {"matrix": axes}})

    one = solved(crystals(UNITS), pad_on_block())
    other = solved(crystals(TURN), moved(pad_on_block(), lambda x: x @ TURN.T))
    first, second = contact_of(one), contact_of(other)
    assert set(np.unique(first.status[-1])) == {0, 1, 2}
    slips = [
        np.einsum("tnc,ncd->tnd", each.slip, each.surface.frames[:, 1:]) for each in (first, second)
    ]
    for found, expected in ((vectors(second), vectors(first)), (slips[1], slips[0])):
        assert np.abs(found - expected @ TURN.T).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("length", [1e-3, 1 / 25.4], ids=["metres", "inches"])
def test_in_other_units(original: Result, length: float) -> None:
    scaled = solved(case(length=length), moved(pad_on_block(), lambda x: length * x))
    assert_same(vectors(contact_of(scaled)) * length**2, vectors(contact_of(original)))


def test_moved_by_a_metre(original: Result) -> None:
    far = solved(case(), moved(pad_on_block(), lambda x: x + 1000.0))
    assert_same(vectors(contact_of(far)), vectors(contact_of(original)))


def test_bodies_in_another_order(original: Result) -> None:
    backwards = Mesh(dict(reversed(pad_on_block().bodies.items())))
    assert_same(vectors(contact_of(solved(case(), backwards))), vectors(contact_of(original)))


def test_mirrored(original: Result) -> None:
    """The bodies are their own image in z = 0.45; the loads along z are reversed."""
    image = np.diag([1.0, 1.0, -1.0])
    first, second = contact_of(original), contact_of(solved(case(image), pad_on_block()))
    distance, rows = cKDTree(first.surface.points @ image + [0.0, 0.0, 0.9]).query(
        second.surface.points
    )
    assert distance.max() < 1e-12
    assert_same(vectors(second), (vectors(first) @ image)[:, rows])


def test_exchanged_bodies_on_the_same_multipliers(original: Result) -> None:
    """The integrals run along the other surface: the same but for the error of the mesh."""
    exchanged = solved(case(surfaces=("block_top", "pad_bottom")), pad_on_block())
    first, second = contact_of(original), contact_of(exchanged)
    assert len(first.surface.points) == len(second.surface.points)
    order = (
        np.lexsort(first.surface.points.T.round(9)),
        np.lexsort(second.surface.points.T.round(9)),
    )
    difference = vectors(first)[:, order[0]] + vectors(second)[:, order[1]]
    assert np.abs(difference).max() < 0.02 * np.abs(vectors(first)).max()
    assert_same(-exchanged.contacts[0].force[-1], original.contacts[0].force[-1], 1e-3)
