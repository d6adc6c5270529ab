# SPDX-License-Identifier: LGPL-3.0-or-later
"""The firtree demo on a coarse mesh: factors at all edges, shares of the lobes, symmetry."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.history.solution import Solution

DEMO = Path(__file__).parents[2] / "demos" / "firtree.toml"
LOBES = ("1", "2", "3")


def run_firtree(**parameters: float) -> tuple[Solution, dict[str, Contact]]:
    data: dict[str, Any] = tomllib.loads(DEMO.read_text())
    data["geometry"]["parameters"] |= {"edge_size": 0.01, "growth": 0.3} | parameters
    data["output"] = {"fields": "none"}
    data["loads"]["pull"]["history"] = [
        {"ramp": 4000.0, "until": 1.0, "steps": 4},
        {"wave": "sine", "mean": 4000.0, "amplitude": 1000.0, "period": 1.0, "cycles": 1}
        | {"steps_per_cycle": 8},
    ]
    case = parse_case(data)
    outcome = solve(MPI.COMM_WORLD, case)
    assert outcome.failure is None
    return outcome.solution, {each.name: each for each in outcome.contacts}


@pytest.fixture(scope="module")
def touching() -> tuple[Solution, dict[str, Contact]]:
    return run_firtree()


@pytest.fixture(scope="module")
def apart() -> tuple[Solution, dict[str, Contact]]:
    # the pull lifts the blade by about .03
    return run_firtree(lobe_gap=0.004)


def forces(solution: Solution) -> dict[str, np.ndarray]:
    """Force (T, 2) on body 2 of each contact."""
    return {
        each.name: np.einsum(
            "n,tnc,ncd->td",
            each.surface.weights,
            each.traction * np.array([-1, 1]),
            each.surface.frames,
        )
        for each in solution.contacts
    }


def test_all_edges_have_factors(touching: tuple[Solution, dict[str, Contact]]) -> None:
    edges = [edge for contact in touching[1].values() for edge in contact.stations]
    assert len(edges) == 12
    for edge in edges:
        # at small loads the contact covers too few of the coarse elements beyond the flat
        assert np.isfinite(edge.k_n[4:]).all() and (edge.k_n[4:] > 0).all()
        # and K_T is not known there either; it is counted from where it is
        assert np.isfinite(edge.k_t[4:]).all() and edge.k_t_range > 0


def test_contacts_end_on_the_roundings(
    touching: tuple[Solution, dict[str, Contact]],
) -> None:
    # between the ends of the flat, 2.5 long, and the ends of the candidate contact
    reach = 1.25 + 2.0 * np.sin(np.radians(10))
    for contact in touching[1].values():
        for edge in contact.stations:
            assert 1.25 < abs(edge.position[-1]) < reach


@pytest.mark.parametrize("name", ["touching", "apart"])
def test_the_shares_of_the_lobes_add_up_to_the_pull(
    name: str, request: pytest.FixtureRequest
) -> None:
    solution: Solution = request.getfixturevalue(name)[0]
    pull = solution.values[1:, 0]
    total = np.sum(list(forces(solution).values()), axis=0)[1:]
    # the tolerance of the contact iteration; round-off
    np.testing.assert_allclose(total[:, 1], pull, rtol=1e-8)
    np.testing.assert_allclose(total[:, 0], 0.0, atol=1e-8 * pull.max())


@pytest.mark.parametrize("name", ["touching", "apart"])
def test_left_mirrors_right(name: str, request: pytest.FixtureRequest) -> None:
    solution, contacts = request.getfixturevalue(name)
    share = forces(solution)
    for lobe in LOBES:
        left, right = contacts[f"left_{lobe}"], contacts[f"right_{lobe}"]
        # meshes mirror each other to 1e-6 of the radii, edges are found to a part of an element
        np.testing.assert_allclose(
            share[left.name], share[right.name] * [-1, 1], rtol=1e-5, atol=1e-2
        )
        for one, other in zip(left.stations, right.stations[::-1], strict=True):
            np.testing.assert_allclose(one.k_n[4:], other.k_n[4:], rtol=0.01)
            assert one.k_t_range == pytest.approx(other.k_t_range, rel=0.01)
            np.testing.assert_allclose(one.position[1:], -other.position[1:], atol=1e-3)


def test_lobes_that_start_apart_carry_less(
    touching: tuple[Solution, dict[str, Contact]],
    apart: tuple[Solution, dict[str, Contact]],
) -> None:
    before, after = forces(touching[0]), forces(apart[0])
    # the uppermost lobe takes over from the lowest
    assert after["right_1"][4, 1] > 1.1 * before["right_1"][4, 1]
    assert after["right_3"][4, 1] < 0.9 * before["right_3"][4, 1]
