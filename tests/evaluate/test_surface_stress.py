# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress near contacts without finite elements: its file, its fits at edges, its key in a case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from cases.pad_cases import pad
from cases.stored_runs import solved
from reference.elliptical_stress import elliptical_stress

from fretfe._typing import Array
from fretfe.case import parse_case
from fretfe.errors import CaseError, OutputError
from fretfe.evaluate.stress import EdgeStress
from fretfe.evaluate.surface_stress import EdgeValue, edge_stress, near_edge
from fretfe.results.hdf5_file import STRESSES, StressSite, StressWriter, read_stress
from fretfe.runner import Runner

NODES, DEPTHS = 5, np.array([0.0, 0.1])


def write(path: Path) -> dict[str, Array]:
    """Two states of a contact; returns the last one."""
    random = np.random.default_rng(0)
    site = StressSite(
        contact="main",
        arc=np.arange(NODES, dtype=float),
        frames=random.normal(size=(NODES, 2, 2)),
        bodies=("pad", "block"),
        points=random.normal(size=(2, 2, NODES, 2)),
        normals=random.normal(size=(2, NODES, 2)),
        edges=[("main", "left", "pad"), ("main", "left", "block")],
    )
    writer = StressWriter(path / STRESSES, DEPTHS, np.array([3, 4]), np.array([0.3, 0.4]), [site])
    for _ in range(2):
        values: dict[str, Any] = {
            "traction": random.normal(size=(NODES, 2)),
            "slip": random.normal(size=NODES),
            "status": np.arange(NODES) % 3,
            "stress": random.normal(size=(2, 2, NODES, 4)),
            "edge_stress": np.array([7.0, np.nan]),
            "edge_spread": np.array([0.5, np.nan]),
            "edge_near": np.array([6.0, np.nan]),
        }
        writer.add({"main": values})
    assert not (path / STRESSES).exists()  # whole or not there
    writer.close({"main": ["", "nothing slips"]})
    return values


def test_what_is_written_is_read(tmp_path: Path) -> None:
    last = write(tmp_path)
    found = read_stress(tmp_path, "main")
    assert found.states.tolist() == [3, 4]
    assert found.times == pytest.approx([0.3, 0.4])
    assert [each.name for each in found.bodies] == ["pad", "block"]
    assert np.array_equal(found.bodies[1].stress[1], last["stress"][1])
    assert np.array_equal(found.status[1], last["status"])
    first, second = found.edges
    assert (first.edge, first.body, first.largest) == ("left", "pad", EdgeValue(7.0, 0.5))
    assert second.largest.reason == "nothing slips" and np.isnan(second.largest.value)
    some = found.at(np.array([1, 3]))
    assert np.array_equal(some.bodies[0].stress, found.bodies[0].stress[:, :, [1, 3]])
    assert some.arc.tolist() == [1, 3]


def test_other_contacts_and_damaged_files_are_told(tmp_path: Path) -> None:
    write(tmp_path)
    with pytest.raises(OutputError, match="expected one of the contacts main, found 'other'"):
        read_stress(tmp_path, "other")
    path = tmp_path / STRESSES
    whole = path.read_bytes()
    with h5py.File(path, "a") as file:
        del file["depths"]
        file["depths"] = [0.0]
    with pytest.raises(OutputError, match=r"stress of the shape \(2, 2, 2, 5, 4\)"):
        read_stress(tmp_path, "main")
    with h5py.File(path, "a") as file:
        file["elsewhere"] = h5py.ExternalLink("/etc/passwd", "x")
    with pytest.raises(OutputError, match="'elsewhere', which is elsewhere"):
        read_stress(tmp_path, "main")
    path.write_bytes(whole[:1000])
    with pytest.raises(OutputError, match="expected the stress near the contacts, found"):
        read_stress(tmp_path, "main")


@pytest.mark.parametrize(
    ("depths", "problem"),
    [
        ([0.1, 0.1], r"expected increasing depths, found \[0\.1, 0\.1\]"),
        ([-0.1], "expected a number >= 0, found -0.1"),
        (list(range(11)), "10"),
    ],
)
def test_depths_are_checked(depths: list[float], problem: str) -> None:
    with pytest.raises(CaseError, match=problem) as caught:
        parse_case(pad(output={"stress_depths": depths}))
    assert "output.stress_depths" in str(caught.value)


def test_backends_without_bodies_refuse() -> None:
    case = parse_case(pad(output={"stress_depths": [0.0]}))
    with pytest.raises(CaseError, match=r"output\.stress_depths: only the backend 'fem'"):
        Runner.find("halfplane").run(case)


def test_a_run_without_a_folder_has_none() -> None:
    result = solved("halfplane")
    assert not result.has_stress
    with pytest.raises(OutputError, match="with an output folder"):
        result.stress_history("main")


@pytest.mark.parametrize("inward", [1, -1], ids=["left", "right"])
@pytest.mark.parametrize(("elements", "error"), [(40, 2e-3), (15, 3e-3), (8, 3e-3)])
def test_edge_value_of_the_exact_stress(inward: int, elements: int, error: float) -> None:
    """A root at the border of the stick zone, which is known to half an element only.

    That makes nearly all of the error: 0.07 to 0.24 % measured.
    """
    a, c, shear = 1.0, 0.87, -0.4
    size = (a - c) / elements
    arc = np.arange(-1.2, 1.2, size)
    places = (arc[:, None] + size * np.array([0.2113, 0.7887])).ravel()

    def stress(x: Array) -> Array:
        # The left edge trails under a shear towards positive x.
        slip, stick = (elliptical_stress(x, 0.0, b, 0.0, -inward * shear * b) for b in (a, c))
        return np.asarray((slip - stick)[:, 0])

    status = np.where(np.abs(arc) < c, 1, np.where(np.abs(arc) < a, 2, 0))
    found = edge_stress(places, stress(places), -inward * a, inward, arc, status)
    expected = stress(np.array([-inward * a]))[0]
    assert expected > 0
    assert found.value == pytest.approx(expected, rel=error)
    assert abs(found.value - expected) < found.spread


@pytest.mark.parametrize("inward", [1, -1], ids=["left", "right"])
@pytest.mark.parametrize("trailing", [True, False])
def test_the_largest_edge_value_is_one_that_no_unknown_state_exceeds(
    inward: int, trailing: bool
) -> None:
    """A shear that is taken off again: the zone that slips back is too short for a fit.

    The stress of the trailing edge falls from the one state in which it is known, that of the
    leading edge rises from there by two thirds.
    """
    a, c = 1.0, 0.87
    size = (a - c) / 8
    arc = np.arange(-1.2, 1.2, size)
    places = (arc[:, None] + size * np.array([0.2113, 0.7887])).ravel()

    def partial(x: Array, border: float) -> Array:
        shear = 0.4 * inward * (1 if trailing else -1)
        slip, stick = (elliptical_stress(x, 0.0, b, 0.0, shear * b) for b in (a, border))
        return np.asarray((slip - stick)[:, 0])

    values, near = [], []
    for taken_off in (0.0, 0.1, 0.3, 0.6, 1.0):
        border = np.sqrt(1 - taken_off * (1 - c**2) / 2) if taken_off else c
        stress = partial(places, c) - 2 * partial(places, border) * (taken_off > 0)
        status = np.where(np.abs(arc) < border, 1, np.where(np.abs(arc) < a, 2, 0))
        edge = places, stress, -inward * a, inward, arc
        values.append(edge_stress(*edge, status))
        near.append(near_edge(*edge))
    assert [not each.reason for each in values] == [True] + 4 * [False]
    found = EdgeStress(
        "main",
        "left",
        "pad",
        value=np.array([each.value for each in values]),
        spread=np.array([each.spread for each in values]),
        near=np.array(near),
        reason="too short",
    ).largest
    if trailing:
        assert found.value == pytest.approx(partial(np.array([-inward * a]), c)[0], rel=3e-3)
    else:
        assert np.isnan(found.value)
        assert found.reason.startswith("known in 1 of 5 states only, and may be larger in others")


def test_edge_values_that_are_unknown_have_reasons() -> None:
    arc = np.linspace(-1, 1, 21)
    inside = np.abs(arc) < 0.75

    def reason(status: Array, position: float = -0.8) -> str:
        return edge_stress(arc, arc, position, 1, arc, status).reason

    assert reason(np.where(inside, 1, 0)) == "nothing slips next to the edge"
    assert reason(np.where(inside, 2, 0)) == "the whole contact slips"
    partly = np.where(inside, np.where(np.abs(arc) < 0.45, 1, 2), 0)
    assert reason(partly) == "the slip zone has 3 elements, too few for a fit"
    assert reason(partly, np.nan) == "the place of the edge is not known"
