# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two bumps on one surface of a user's geometry: each patch is a contact of its own."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases import two_bumps

from fretfe.case import parse_case
from fretfe.fem.backend import BACKEND
from fretfe.quality.companions import MEAN, companion_rows
from fretfe.quality.rows import own_rows
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
            assert station.k_range_parts.extraction < 2e-3 * station.k_t_range


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
        assert found.node_range is not None
        assert history.node_range is not None
        assert np.array_equal(found.node_range, history.node_range)
        assert np.array_equal(found.traction, history.traction)
    assert [each["contact"] for each in run.edges()] == ["pad[1]"] * 2 + ["pad[2]"] * 2


def test_patches_that_merge_and_part_again(merging: Result) -> None:
    """K_N by the closed form of half-planes, which these bodies are to 5 %."""
    left, right, merged = merging.contacts
    load = two_bumps.MERGING
    assert left.normal_force == pytest.approx(load * np.array([0, 1, 0, 1, 0, 1]) / 4, rel=1e-3)
    assert right.normal_force == pytest.approx(left.normal_force, rel=1e-3)
    assert merged.normal_force == pytest.approx(load * np.array([0, 0, 1.5, 0, 1.5, 0]), rel=1e-6)
    inner, outer = np.sqrt(1 - np.sqrt(0.5)), np.sqrt(1 + np.sqrt(0.5))
    assert [each.position[5] for each in left.stations] == pytest.approx([-outer, -inner], abs=0.01)
    assert [each.position[5] for each in right.stations] == pytest.approx([inner, outer], abs=0.01)
    slope = two_bumps.SHALLOWNESS * two_bumps.E_STAR
    near, far = (slope * e * np.sqrt(2 * e * (outer**2 - inner**2)) for e in (inner, outer))
    found = [each.k_n[5] for contact in (left, right) for each in contact.stations]
    assert found == pytest.approx([far, near, near, far], rel=0.05)
    edge = np.sqrt((1 + np.sqrt(5.5)) * 2 / 3)
    assert merged.half_width[4] == pytest.approx(edge, abs=0.01)
    k_n = slope * (1.5 * edge**2 - 1) * np.sqrt(2 * edge)
    assert [each.k_n[4] for each in merged.stations] == pytest.approx([k_n, k_n], rel=0.05)
    assert np.isnan(merged.half_width[[1, 3, 5]]).all()
    assert np.isnan(left.half_width[[2, 4]]).all()


def test_what_happens_to_patches_is_told(merging: Result) -> None:
    texts = ["; ".join(one.text for one in each.warnings) for each in merging.contacts]
    for text, other in zip(texts, ("pad[2]", "pad[1]"), strict=False):
        assert f"it merges with {other} into pad[3] in step 2 (time 2, x = " in text
        assert "it arises where pad[3] parts in step 3 (time 3, x = " in text
    assert "it arises where pad[1] and pad[2] merge in step 2 (time 2, x = " in texts[2]
    assert "it parts into pad[1] and pad[2] in step 3 (time 3, x = " in texts[2]


def test_validation_compares_patch_with_patch(sheared: Result) -> None:
    rows = [*own_rows(sheared), *companion_rows(MEAN, sheared, sheared)]
    places = {(row.contact, row.edge) for row in rows if row.verdict == "agrees"}
    assert {(name, side) for name in ("pad[1]", "pad[2]") for side in ("left", "right")} < places
    assert not [row for row in rows if row.verdict in ("differs", "unknown")]
    # They may have other names in a companion; one that is missing is no agreement.
    first, second = sheared.contacts
    renamed = (replace(first, name="pad[2]"), replace(second, name="pad[1]"))
    swapped = replace(sheared, contacts=renamed[::-1])
    assert {row.verdict for row in companion_rows(MEAN, sheared, swapped)} == {"agrees"}
    lost = list(companion_rows(MEAN, sheared, replace(sheared, contacts=(first,))))
    assert [row.contact for row in lost if row.verdict == "unknown"] == ["pad[2]"]


def test_a_mesh_that_refines_itself_resolves_all_edges(tmp_path: Path) -> None:
    case = two_bumps.cylinders(tmp_path, NORMAL, SHEAR)
    tables = case.model_dump(mode="json", exclude_unset=True) | {"edges": {"tolerance": 0.02}}
    result = BACKEND.solve(parse_case(tables, case.source, trust_geo=True))
    assert result.refinement is not None
    assert result.refinement.converged
    assert {each.contact for each in result.refinement.passes[-1].stations} == {"pad[1]", "pad[2]"}
    k_n = hertz(NORMAL / 2)[1]
    found = [each.k_n[-1] for contact in result.contacts for each in contact.stations]
    assert found == pytest.approx([k_n] * 4, rel=0.01)
