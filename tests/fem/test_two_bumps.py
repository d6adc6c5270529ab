# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two bumps on one surface of a user's geometry: each patch is a contact of its own."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import two_bumps

from fretfe.cli.run import _print_numbers
from fretfe.fem.backend import BACKEND
from fretfe.quality.validate import validate
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import write_results

NORMAL, SHEAR = 900.0, 120.0


@pytest.fixture(scope="module")
def sheared(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """Two cylinders under P = 900 N and a cycle of Q."""
    case = two_bumps.cylinders(tmp_path_factory.mktemp("cylinders"), NORMAL, SHEAR)
    return replace(BACKEND.solve(case), backend="fem")


@pytest.fixture(scope="module")
def merging(tmp_path_factory: pytest.TempPathFactory) -> Result:
    """Waves whose patches merge in the second step, part in the third and merge in the fourth."""
    forces = [factor * two_bumps.MERGING for factor in (0.5, 1.5, 0.5, 1.5, 0.5)]
    return BACKEND.solve(two_bumps.waves(tmp_path_factory.mktemp("waves"), forces))


def hertz(normal: float) -> tuple[float, float]:
    """Half-width and K_N."""
    half_width = np.sqrt(4 * normal * two_bumps.RADIUS / (np.pi * two_bumps.E_STAR))
    return half_width, 2 * normal / (np.pi * half_width) * np.sqrt(2 / half_width)


def test_two_patches_with_four_edges(sheared: Result) -> None:
    half_width, k_n = hertz(NORMAL / 2)
    assert [each.name for each in sheared.contacts] == ["pad[1]", "pad[2]"]
    assert [each.pair for each in sheared.contacts] == ["pad", "pad"]
    for contact, centre in zip(sheared.contacts, (-3.0, 3.0), strict=True):
        assert contact.warnings == ()
        assert contact.normal_force[-1] == pytest.approx(NORMAL / 2, rel=1e-3)
        assert contact.half_width[-1] == pytest.approx(half_width, rel=0.01)
        # Each bump tilts the other one a little.
        assert contact.centre[-1] == pytest.approx(centre, abs=0.02)
        for station in contact.stations:
            assert station.k_n[-1] == pytest.approx(k_n, rel=0.01)
            assert station.k_n_moved == pytest.approx(k_n, rel=0.01)


def test_factors_of_full_stick_at_four_edges(sheared: Result) -> None:
    """By integrals, with circles about the tips of each patch, and by fits; Q divides in halves."""
    expected = SHEAR / (np.pi * np.sqrt(2 * hertz(NORMAL / 2)[0]))
    ranges = [each.k_t_range for contact in sheared.contacts for each in contact.stations]
    assert np.mean(ranges) == pytest.approx(expected, rel=0.01)
    # The shear of each bump is a bulk tension for the other one.
    assert ranges == pytest.approx([expected] * 4, rel=0.06)
    assert ranges == pytest.approx(ranges[::-1], rel=2e-3)
    for contact in sheared.contacts:
        assert contact.shear_mismatch == pytest.approx(0.0, abs=0.01)
        for station in contact.stations:
            assert station.k_t_range_fitted == pytest.approx(station.k_t_range, rel=4e-3)
            assert station.k_t_range_spread < 2e-3 * station.k_t_range


def test_results_and_tables_have_both_patches(sheared: Result, tmp_path: Path) -> None:
    write_results(tmp_path, sheared)
    numbers = json.loads((tmp_path / "results.json").read_text())
    assert {name: each["pair"] for name, each in numbers["contacts"].items()} == {
        "pad[1]": "pad",
        "pad[2]": "pad",
    }
    run = load_result(tmp_path)
    for contact, patch in zip(run.contacts, sheared.contacts, strict=True):
        assert (contact.name, contact.pair) == (patch.name, "pad")
        found, history = run.contact_history(patch.name), sheared.contact_history(patch.name)
        assert found.pair == "pad"
        assert np.array_equal(found.territory, history.territory)
        assert np.array_equal(found.traction, history.traction)
    assert [each["contact"] for each in run.edges()] == ["pad[1]"] * 2 + ["pad[2]"] * 2
