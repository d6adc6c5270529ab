# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that solve nothing import nothing that solves, optimises or draws."""

from __future__ import annotations

import ast
import json
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from cases.pad_cases import cylinder, pad_text
from harness.launch import python
from project.test_layers import MODULES

WATCHED = """
import json, sys
from fretfe.cli.app import main
sys.argv = ["fretfe", *sys.argv[1:]]
try:
    main()
except SystemExit as ended:
    assert not ended.code, ended.code
print(json.dumps(sorted(sys.modules)))
"""
SLOW = {
    *("dolfinx", "h5py", "jinja2", "matplotlib", "mpi4py", "numpy", "pydantic"),
    *("rich.progress", "scipy.interpolate", "scipy.optimize"),
}
# A case is read with pydantic.
READS = {"pydantic"}
SOLVES = """
import fretfe.cli.progress, fretfe.fem.backend, fretfe.report.page.tables, fretfe.runner
import json, sys
print(json.dumps(sorted(sys.modules)))
"""


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        (["--help"], set()),
        (["run", "--help"], READS),
        (["templates"], READS),
        # DOLFINx shows whether it can be used.
        (["backends"], READS | {"dolfinx", "h5py", "mpi4py", "numpy"}),
    ],
    ids=["help", "help of a command", "templates", "backends"],
)
def test_imports(arguments: list[str], allowed: set[str]) -> None:
    assert imported(WATCHED, *arguments) <= allowed


@pytest.mark.skipif(find_spec("gmsh") is None, reason="Gmsh is not installed")
@pytest.mark.parametrize(
    ("tables", "allowed"),
    [
        ({"geometry": cylinder(size=0.05)}, READS | {"numpy"}),
        ({"geometry": cylinder(), "edges": {"tolerance": 0.1}}, READS | {"h5py", "numpy"}),
    ],
    ids=["a mesh", "the first mesh"],
)
def test_imports_of_a_check(tmp_path: Path, tables: dict[str, Any], allowed: set[str]) -> None:
    (tmp_path / "case.toml").write_text(pad_text(**tables))
    assert imported(WATCHED, "check", str(tmp_path / "case.toml")) == allowed


def test_a_mesh_is_begun_without_scipy() -> None:
    begun = "import fretfe.cli.app, fretfe.surface.ahead, sys; print('scipy' in sys.modules)"
    done = python("-c", begun)
    assert done.stdout.split() == ["False"], done.stderr


@pytest.mark.skipif(find_spec("dolfinx") is None, reason="DOLFINx is not installed")
def test_imports_of_a_plane_run() -> None:
    assert imported(SOLVES) == READS | {"dolfinx", "h5py", "mpi4py", "numpy"}


@pytest.mark.skipif(find_spec("matplotlib") is None, reason="Matplotlib is not installed")
@pytest.mark.parametrize("module", ["fretfe.report.page.html", "fretfe.report.pictures.folder"])
def test_a_plane_report_imports_no_scipy(module: str) -> None:
    done = python("-c", f"import {module}, sys; print('scipy' in sys.modules)")
    assert done.stdout.split() == ["False"], done.stderr


def test_matplotlib_is_imported_in_one_place() -> None:
    # It reads settings where it is imported first; what only types need is never imported.
    importing = {
        name
        for name, path in MODULES.items()
        if any(
            each.startswith("matplotlib") for each in packages_on_loading(path.read_text("utf-8"))
        )
    }
    assert importing == {"fretfe.report.plotting"}


def packages_on_loading(source: str) -> Iterator[str]:
    """Yield the packages that a module imports as it is loaded."""
    for node in ast.parse(source).body:
        for inner in ast.walk(node) if isinstance(node, ast.With) else [node]:
            if isinstance(inner, ast.Import):
                yield from (alias.name.partition(".")[0] for alias in inner.names)
            elif isinstance(inner, ast.ImportFrom):
                yield (inner.module or "").partition(".")[0]


def imported(program: str, *arguments: str) -> set[str]:
    """Those of the slow libraries that a program has imported at its end."""
    done = python("-c", program, *arguments)
    assert done.returncode == 0, done.stderr
    return SLOW & set(json.loads(done.stdout.splitlines()[-1]))


INTERRUPTED = """
import fretfe.__main__ as entry

def command_line():
    raise KeyboardInterrupt

entry._load = lambda: command_line
entry.main()
"""


def test_ctrl_c_between_loading_and_listening_ends_quietly() -> None:
    done = python("-c", INTERRUPTED)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "")
