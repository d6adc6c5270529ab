# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that solve nothing import nothing that solves, optimises or draws."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import pytest
from launch import python
from pad_cases import cylinder, pad_text

WATCHED = """
import json, sys
from fretfe.cli.app import main
sys.argv = ["fretfe", *sys.argv[1:]]
try:
    main()
except SystemExit as ended:
    assert not ended.code, ended.code
slow = {"dolfinx", "h5py", "jinja2", "matplotlib", "mpi4py", "numpy", "pydantic", "scipy.optimize"}
print(json.dumps(sorted(slow & set(sys.modules))))
"""


@pytest.mark.parametrize(
    ("arguments", "allowed"),
    [
        (["--help"], []),
        (["run", "--help"], ["pydantic"]),
        (["templates"], ["pydantic"]),
        # DOLFINx shows whether it can be used.
        (["backends"], ["dolfinx", "h5py", "mpi4py", "numpy", "pydantic"]),
    ],
    ids=["help", "help of a command", "templates", "backends"],
)
def test_imports(arguments: list[str], allowed: list[str]) -> None:
    assert set(imported(*arguments)) <= set(allowed)


@pytest.mark.skipif(find_spec("gmsh") is None, reason="Gmsh is not installed")
def test_imports_of_a_check(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(pad_text(geometry=cylinder(size=0.05)))
    assert set(imported("check", str(tmp_path / "case.toml"))) == {"h5py", "numpy", "pydantic"}


def imported(*arguments: str) -> list[str]:
    """Those of the slow libraries that a command has imported at its end."""
    done = python("-c", WATCHED, *arguments)
    assert done.returncode == 0, done.stderr
    return list(json.loads(done.stdout.splitlines()[-1]))
