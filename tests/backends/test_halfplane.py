# SPDX-License-Identifier: LGPL-3.0-or-later
"""`fretfe run` without finite elements: files, their keys, and a message for each mistake."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from cases.pad_cases import HERTZ
from harness import launch

from fretfe.analytic.edges import tangential_factor
from fretfe.analytic.profiles import Hertz, composite_modulus, edge_factor_k_n

DESCRIPTION = Path(__file__).parents[2] / "docs" / "results.md"
STATES = 21


@pytest.fixture(scope="module", autouse=True)
def _elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Run fretfe as it is installed, with lines so long that no message is broken."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("elsewhere"))
        patch.setitem(launch.ENVIRONMENT, "COLUMNS", "1000")
        patch.setenv("COLUMNS", "1000")
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a case, its results, and what was printed."""
    path = tmp_path_factory.mktemp("run")
    (path / "pad.toml").write_text(HERTZ)
    command = ("-m", "fretfe", "run", path / "pad.toml", "--backend", "halfplane")
    done = launch.python(*command, "-o", path / "halfplane")
    assert done.returncode == 0, done.stderr
    (path / "halfplane.txt").write_text(done.stdout)
    return path


def numbers(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "results.json").read_text()))


def described(section: str) -> set[str]:
    """Keys in the table below a heading of docs/results.md."""
    text = DESCRIPTION.read_text("utf-8").split(f"\n### {section}\n")[1]
    first_cells = re.findall(r"^\|([^|]*)\|", re.split(r"\n##", text)[0], re.MULTILINE)
    return {key for cell in first_cells for key in re.findall(r"`(\w+)`", cell)}


def test_files(folder: Path) -> None:
    assert {path.name for path in (folder / "halfplane").iterdir()} == {
        "results.json", "results.h5", "stations.csv", "report.html", "pictures", "case.toml",
        "run.json",
    }  # fmt: skip
    assert (folder / "halfplane" / "case.toml").read_text() == HERTZ


def test_keys_are_those_of_the_document(folder: Path) -> None:
    data = numbers(folder / "halfplane")
    assert set(data) == described("Top level")
    contact = data["contacts"]["main"]
    assert set(contact) == described("`contacts.NAME`")
    for front in contact["fronts"]:
        (edge,) = front["stations"]
        assert set(edge) == described("`contacts.NAME.fronts[i].stations[0]`")
        for zone in edge["slip_zones"]:
            assert set(zone) == described("`contacts.NAME.fronts[i].stations[0].slip_zones[j]`")


def test_run_is_described(folder: Path) -> None:
    data = numbers(folder / "halfplane")
    assert data["backend"] == "halfplane"
    assert data["complete"] is True and data["failure"] == ""
    assert (len(data["times"]), data["cycle"], data["ranks"]) == (STATES, [12, 20], 1)
    assert data["mesh"] == {}
    assert "the platen does not turn: the pressure is symmetric, M = 0" in data["notes"]
    printed = (folder / "halfplane.txt").read_text()
    assert all(f"Note: {note}" in printed for note in data["notes"])


def test_with_tractions_the_steps_are_described(folder: Path) -> None:
    data = numbers(folder / "halfplane")
    assert list(data["drivers"]) == ["shear", "normal", "moment", "tension"]
    assert set(data["coordinates"]) == {"shear", "normal", "moment"}
    assert set(data["steps"]["certificate"]) == described("`steps.certificate`")
    assert max(data["steps"]["certificate"]["worst"]) < 1e-9
    with h5py.File(folder / "halfplane" / "results.h5") as arrays:
        group = arrays["contacts/main"]
        nodes = len(group["arc"])
        assert group["traction"].shape == (STATES, nodes, 2)
        assert "mesh" not in arrays
        force = group["weights"][:] @ group["traction"][-1]
    # The resultants are prescribed: they are met to the tolerance of the contact iteration.
    assert np.allclose(force, [600, 0], atol=1e-8 * 600)


def test_numbers_are_those_of_hertz_and_cattaneo(folder: Path) -> None:
    # The half-plane solution is discretised: 300 nodes, fits of K_N, a slip border between nodes.
    tolerance = 5e-3
    contact = numbers(folder / "halfplane")["contacts"]["main"]
    profile = Hertz(50.0, composite_modulus(210e3, 0.3, 210e3, 0.3))
    a = float(profile.half_width(600.0))
    assert np.allclose(contact["normal_force"][4:], 600, rtol=1e-8)
    assert np.isclose(contact["half_width"][-1], a, rtol=tolerance)
    for front in contact["fronts"]:
        (edge,) = front["stations"]
        sign = -1 if edge["front"] == "left" else 1
        k_t = tangential_factor(60.0, 0.0, a, edge["front"])
        assert np.isclose(edge["position"][-1], sign * a, rtol=tolerance)
        assert np.isclose(edge["k_n"][-1], edge_factor_k_n(profile, a), rtol=tolerance)
        # State 6 is the first peak of the shear force.
        assert np.isclose(edge["k_t"][6], k_t, rtol=tolerance)
        assert np.isclose(edge["k_t_range"], 2 * abs(k_t), rtol=tolerance)
        # Q1 = f P/4: c = a sqrt(1 - 1/4)
        length = edge["slip_zones"][-1]["length"]
        assert np.isclose(length, a * (1 - np.sqrt(0.75)), rtol=tolerance)


def test_files_of_an_earlier_run_that_do_not_belong_to_it_go(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for options in ((), ("--no-report",)):
        case = folder / "pad.toml"
        done = launch.fretfe("run", case, "--backend", "halfplane", "-o", out, *options)
        assert done.returncode == 0, done.stderr
        assert (out / "report.html").exists() == (not options)


# What a user gets wrong: edit of the case, exit code, words that the message must contain.
MISTAKES = {
    "misspelt key": (("friction = 0.4", "frction = 0.4"), 2, ["main.frction", "'friction'"]),
    "parameter out of range": (("upper_radius = 50", "upper_radius = 0"), 2, ["upper_radius"]),
    "sliding": (
        ("amplitude = 60", "amplitude = 300"),
        5,
        ["expected |Q| < f P", "Q = 300", "f P = 240", "at time 1.25"],
    ),
    "opening": (("ramp = -600", "ramp = 600"), 4, ["P > 0", "-150", "time 0.25", "holds"]),
    "prescribed approach": (('"force"', '"displacement"'), 2, ["loads.press", "'displacement'"]),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_gets_a_clear_message_before_any_work(tmp_path: Path, mistake: str) -> None:
    (old, new), code, words = MISTAKES[mistake]
    assert old in HERTZ
    (tmp_path / "case.toml").write_text(HERTZ.replace(old, new, 1))
    arguments = ("--backend", "halfplane", "-o", tmp_path / "out")
    done = launch.fretfe("run", tmp_path / "case.toml", *arguments)
    assert done.returncode == code, done.stdout + done.stderr
    assert "Traceback" not in done.stderr and "step" not in done.stdout
    assert all(word in done.stderr for word in words), done.stderr
    assert not (tmp_path / "out").exists()
