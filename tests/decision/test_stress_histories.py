# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories of stress for other programs: the same as of the field, in CSV and HDF5."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from cases.stored_runs import solved, write_run
from typer.testing import CliRunner

from fretfe.cli.app import app
from fretfe.decision.stress_histories import TENSOR_NAMES, edge_histories, parameter_table
from fretfe.errors import CaseError


def test_free_surface_and_equilibrium() -> None:
    """No traction outside of the contact, where there is stress along the surface."""
    (_, outside, *_) = edge_histories(solved("halfplane"), [0.0, 0.3], [0.0, -80.0])
    surface = outside.stress[:, outside.distances == 0]
    largest = np.abs(surface[..., 0]).max()
    assert largest > 10
    assert np.abs(surface[..., [1, 3]]).max() < 1e-3 * largest
    # Plane strain without tension: the stress along z follows from the others.
    below = outside.stress[:, outside.distances > 0]
    assert below[..., 2] == pytest.approx(0.3 * (below[..., 0] + below[..., 1]))
    assert not below[..., 4:].any()


def test_csv_and_hdf5_agree(tmp_path: Path) -> None:
    run, out = write_run(tmp_path / "run", "halfplane"), tmp_path / "out"
    words = [
        "export",
        str(run),
        "-o",
        str(out),
        "--depth",
        "0.1",
        "--depth",
        "0.1",
        "--angle",
        "20",
    ]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0 and "Note" not in done.output
    table = pd.read_csv(out / "edge_histories.csv")
    table.columns = table.columns.str.split(" ").str[0]
    assert set(table.groupby(["contact", "edge", "body"]).groups) == {
        ("main", edge, body) for edge in ("left", "right") for body in ("upper", "lower")
    }
    with h5py.File(out / "edge_histories.h5") as file:
        assert (file.attrs["schema"], file.attrs["stress"]) == ("fretfe-edge-histories", "MPa")
        assert list(file.attrs["components"]) == list(TENSOR_NAMES)
        for group in file.values():
            rows = table[(table.edge == group.attrs["edge"]) & (table.body == group.attrs["body"])]
            assert group["distances"][:].tolist() == [0.1] and group["angles"][:].tolist() == [20]
            assert group["stress"][:, 0] == pytest.approx(rows[list(TENSOR_NAMES)].to_numpy())
            assert group["starts"][:].tolist() == [0]
            assert group["times"][:] == pytest.approx(rows.time.to_numpy())
    assert pd.read_csv(out / "edge_parameters.csv").shape[0] == 4
    listed = pd.read_csv(out / "columns.csv")
    assert "S12" in set(listed[listed.file == "edge_histories.csv"].column)


def test_parameters_at_an_edge() -> None:
    """Trailing, 2 f p0 √(Q/(f P)) along the surface, and as much pressure, in plane strain."""
    result = solved("halfplane")
    table = parameter_table(result, edge_histories(result, [0.0, 0.1]), (0.5, 350.0))
    names = [each.name for each in table.headings]
    rows = [dict(zip(names, row, strict=True)) for row in table.rows]
    assert [each["distance"] for each in rows] == 4 * [0.0, 0.1]
    peak = np.sqrt(600 * 210e3 / (2 * 0.91) / (np.pi * 50))
    tension = 2 * 0.4 * peak * np.sqrt(60 / (0.4 * 600))
    for at_edge, below in zip(rows[::2], rows[1::2], strict=True):
        assert at_edge["swt"] == pytest.approx(tension**2 * 0.91 / 210e3, rel=0.02)
        # Largest shear strain between x and y: γ = (1 + ν) σ/E.
        assert at_edge["shear_strain"] == pytest.approx(tension * 1.3 / 210e3, rel=0.01)
        weight = at_edge["fatemi_socie"] / at_edge["shear_strain"]
        assert weight == pytest.approx(1 + 0.5 * tension / 2 / 350, rel=0.05)
        # Within an element 2 % of the stress and the bars of the factors, of E ε_a as much in MPa.
        assert 0.02 < at_edge["stress_spread"] / tension < 0.04
        twice = (1 + 1 / 0.91) * at_edge["stress_spread"] / tension
        assert at_edge["swt_spread"] / at_edge["swt"] == pytest.approx(twice, rel=0.02)
        # Pressed by more than its bar.
        assert below["swt"] == below["swt_spread"] == 0 < below["stress_spread"]


def test_numbers_that_are_none(tmp_path: Path) -> None:
    for wrong in ([-1.0], [np.nan], [np.inf]):
        with pytest.raises(CaseError, match="--depth"):
            edge_histories(solved("halfplane"), wrong)
    with pytest.raises(CaseError, match="--angle"):
        edge_histories(solved("halfplane"), [0.1], [90.0])
    assert all(each.reason for each in edge_histories(solved("incomplete"), [0.1]))
    result = solved("halfplane")
    bare = replace(result, contacts=(replace(result.contacts[0], fronts=()),))
    (found,) = edge_histories(bare, [0.1])
    assert found.contact == "main" and "no edge" in found.reason
    assert not list(parameter_table(bare, [found]).rows)
    with pytest.raises(CaseError, match=r"--depth: expected at most 2\.3\d* mm, .*, found 1000"):
        edge_histories(solved("halfplane"), [0.1, 1e3])
    for each in edge_histories(solved("halfplane"), [0.1, 0.1, 2.32], [0.0, -80.0, 0.0]):
        assert "places beyond" in each.reason and each.angles.tolist() == [0.0, -80.0, -80.0]
