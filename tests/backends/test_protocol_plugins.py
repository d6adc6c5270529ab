# SPDX-License-Identifier: LGPL-3.0-or-later
"""Backends from other packages, backends that cannot be used, and what a user is told then."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from cases.pad_cases import HERTZ
from harness import launch
from harness.packages import write_package
from project.test_layers import FEM_ONLY

HAS_DOLFINX = importlib.util.find_spec("dolfinx") is not None
DEMOS = Path(__file__).parents[2] / "demos"
PLUGIN = DEMOS / "plugin_backend"


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run fretfe as it is installed, with lines so long that no message is broken."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(launch.ENVIRONMENT, "COLUMNS", "1000")
    monkeypatch.setenv("COLUMNS", "1000")
    (tmp_path / "case.toml").write_text(HERTZ)


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the package of demos/plugin_backend is installed."""
    folder = tmp_path_factory.mktemp("plugin")
    # A copy: the build leaves files beside the source.
    source = shutil.copytree(PLUGIN, folder / "source")
    options = ["--no-build-isolation", "--no-deps", "--no-index", "--no-compile", "--quiet"]
    target = folder / "installed"
    with pytest.MonkeyPatch.context() as patch:
        # pip and setuptools use what they themselves call deprecated.
        patch.delitem(launch.ENVIRONMENT, "PYTHONWARNINGS", raising=False)
        done = launch.python("-m", "pip", "install", *options, "--target", target, source)
    assert done.returncode == 0, done.stderr
    return target


@pytest.fixture
def plugin(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """fretfe finds the installed package."""
    monkeypatch.setitem(launch.ENVIRONMENT, "PYTHONPATH", str(package))
    monkeypatch.syspath_prepend(package)


def listing(done: subprocess.CompletedProcess[str]) -> dict[str, list[str]]:
    """Usable, package and text of each backend that `fretfe backends` printed, in their order."""
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    # Columns are aligned with the headers; a cell with several lines goes on below.
    header = next(line for line in lines if line.split()[:2] == ["backend", "usable"])
    starts = [header.index(word) for word in ("backend", "usable", "package", "what")]
    rows: dict[str, list[str]] = {}
    for line in lines[lines.index(header) + 2 :]:
        name, *cells = (
            line[start:end].strip() for start, end in zip(starts, [*starts[1:], None], strict=True)
        )
        if name:
            rows[name] = cells
        elif cells[-1]:
            rows[list(rows)[-1]][-1] += f"\n{cells[-1]}"
    return rows


@pytest.mark.usefixtures("plugin")
def test_installed_backend_is_listed() -> None:
    rows = listing(launch.python("-m", "fretfe", "backends"))
    assert list(rows) == ["halfplane", "fem", "two_terms"]
    usable, package, summary = rows["two_terms"]
    assert (usable, package) == ("yes", "fretfe-two-terms 0.1.0")
    assert summary.startswith("Hertz under a shear force")
    assert rows["halfplane"][0] == "yes"


@pytest.mark.usefixtures("plugin")
def test_installed_backend_solves_a_case(tmp_path: Path) -> None:
    for name in ("two_terms", "halfplane"):
        done = launch.fretfe("run", "--no-report", "case.toml", "--backend", name, "-o", name)
        assert done.returncode == 0, done.stderr
    formula, exact = (
        json.loads((tmp_path / name / "results.json").read_text())
        for name in ("two_terms", "halfplane")
    )
    assert (formula["backend"], exact["backend"]) == ("two_terms", "halfplane")
    assert "slip lengths by: two terms of the expansion in d/a" in formula["notes"]
    # Q1/(f P) = u; two terms d/a = u/2 + u²/8 against 1 - sqrt(1 - u), both in the steady cycle.
    u, a = 60 / (0.4 * 600), formula["contacts"]["main"]["half_width"][-1]
    edges = (
        [front["stations"][0] for front in run["contacts"]["main"]["fronts"]]
        for run in (formula, exact)
    )
    for edge, other in zip(*edges, strict=True):
        assert len(edge["slip_zones"]) == len(other["slip_zones"]) == 4
        for zone, reference in zip(edge["slip_zones"][::3], other["slip_zones"][::3], strict=True):
            # Half-planes: K_N, by a fit, to 6e-6, and the border to a tenth of an element.
            assert np.isclose(zone["length"], a * (u / 2 + u**2 / 8), rtol=1e-4)
            assert np.isclose(reference["length"], a * (1 - np.sqrt(1 - u)), rtol=5e-3)


@pytest.mark.usefixtures("plugin")
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("until = 1, steps = 4", "until = 1.5, steps = 6", "constant normal force"),
        ("amplitude = 60", "amplitude = 260", "the contact slides"),
    ],
    ids=["varying normal force", "sliding"],
)
def test_installed_backend_says_what_it_cannot_solve(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    assert old in HERTZ
    (tmp_path / "case.toml").write_text(HERTZ.replace(old, new))
    done = launch.fretfe("run", "--no-report", "case.toml", "--backend", "two_terms", "-o", "out")
    assert done.returncode == 2
    assert words in done.stderr and not (tmp_path / "out").exists()


@pytest.mark.usefixtures("plugin")
def test_listing_says_which_backends_can_solve_a_case() -> None:
    rows = listing(launch.fretfe("backends", DEMOS / "dovetail.toml"))
    assert rows["fem"][0] == ("yes" if HAS_DOLFINX else "no")
    for name in ("halfplane", "two_terms"):
        usable, _, reason = rows[name]
        assert usable == "no" and "found 'dovetail'" in reason


# Module, what its entry point names, and what a user must be told.
BROKEN = {
    "raises": ("raise RuntimeError('no licence found')", "BACKEND", ["no licence found"]),
    "incomplete": (
        "class Half:\n    summary = 'no solve'\nBACKEND = Half()",
        "BACKEND",
        ["fretfe.backends.Backend", "found Half"],
    ),
    "nameless": ("", "BACKEND", ["BACKEND"]),
    "absent": (None, "BACKEND", ["No module named 'absent'"]),
}


@pytest.fixture
def broken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Packages whose backends cannot be used are installed."""
    folder = tmp_path / "broken"
    for name, (source, attribute, _) in BROKEN.items():
        entry = f"{name} = {name}:{attribute}"
        write_package(folder, name, source, "fretfe.backends", entry)
    monkeypatch.syspath_prepend(folder)


@pytest.mark.usefixtures("broken")
def test_broken_backends_are_listed_with_the_reason() -> None:
    rows = listing(launch.fretfe("backends"))
    assert list(rows) == ["halfplane", "fem", *sorted(BROKEN)]
    assert rows["halfplane"][0] == "yes"
    for name, (*_, words) in BROKEN.items():
        usable, package, reason = rows[name]
        assert (usable, package) == ("no", f"{name} 1.0")
        assert all(word in reason for word in words), reason


@pytest.mark.usefixtures("broken")
def test_broken_backend_does_not_disturb_the_others() -> None:
    done = launch.fretfe("run", "--no-report", "case.toml", "--backend", "halfplane", "-o", "out")
    assert done.returncode == 0, done.stderr


@pytest.mark.usefixtures("broken")
@pytest.mark.parametrize("name", ["raises", "incomplete"])
def test_broken_backend_cannot_be_chosen(tmp_path: Path, name: str) -> None:
    done = launch.fretfe("run", "--no-report", "case.toml", "--backend", name, "-o", "out")
    assert done.returncode == 7
    assert "Traceback" not in done.stderr
    assert all(word in done.stderr for word in (repr(name), *BROKEN[name][-1])), done.stderr
    assert not (tmp_path / "out").exists()


def test_unknown_backend_is_answered_with_the_names(tmp_path: Path) -> None:
    done = launch.fretfe("run", "--no-report", "case.toml", "--backend", "halfplan", "-o", "out")
    assert done.returncode == 2
    assert "'halfplan'" in done.stderr and "halfplane, fem" in done.stderr
    assert not (tmp_path / "out").exists()


def test_the_backend_of_earlier_versions_names_what_takes_its_place(tmp_path: Path) -> None:
    done = launch.fretfe("run", "--no-report", "case.toml", "--backend", "analytic", "-o", "out")
    assert done.returncode == 2
    assert "no backend is called 'analytic'" in done.stderr
    assert "'halfplane' solves the same cases" in done.stderr
    assert not (tmp_path / "out").exists()


def test_case_that_is_no_half_plane_problem(tmp_path: Path) -> None:
    done = launch.fretfe(
        "run", "--no-report", DEMOS / "dovetail.toml", "--backend", "halfplane", "-o", "out"
    )
    assert done.returncode == 2
    assert all(word in done.stderr for word in ("'halfplane'", "cylinder", "found 'dovetail'"))
    assert not (tmp_path / "out").exists()


# An entry of None in sys.modules is what a package that is not installed looks like.
WITHOUT_DOLFINX = f"""
import sys
sys.modules.update(dict.fromkeys({sorted(FEM_ONLY)}))
from fretfe.cli.app import main
main()
"""


def without_dolfinx(*arguments: str) -> subprocess.CompletedProcess[str]:
    return launch.python("-c", WITHOUT_DOLFINX, *arguments)


def test_without_dolfinx_fem_says_why_it_cannot_be_used(tmp_path: Path) -> None:
    rows = listing(without_dolfinx("backends"))
    assert [row[0] for row in rows.values()] == ["yes", "no"]
    reason = rows["fem"][-1]
    assert "needs DOLFINx" in reason and "pip install" in reason
    done = without_dolfinx("run", "--no-report", "case.toml", "--backend", "fem", "-o", "out")
    assert done.returncode == 7
    assert reason in done.stderr and "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_without_dolfinx_half_planes_are_solved(tmp_path: Path) -> None:
    done = without_dolfinx("run", "--no-report", "case.toml", "--backend", "halfplane", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "out" / "results.json").read_text())["complete"]
