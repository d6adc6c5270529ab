# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the libraries call deprecated fails a test, in its own process and in those it starts."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from cases.b1 import PAD_ON_BLOCK
from cases.b1_meshes import write_b1
from harness import launch

TESTS = Path(__file__).parents[1]
# DOLFINx as it is when it deprecates a function that fretfe calls.
WITH_DEPRECATED_FUNCTION = """
import sys, warnings
import fretfe.fem
import dolfinx.mesh
create_mesh = dolfinx.mesh.create_mesh
def deprecated(*arguments):
    warnings.warn_explicit("create_mesh is old", DeprecationWarning, "mesh.py", 1, "dolfinx.mesh")
    return create_mesh(*arguments)
dolfinx.mesh.create_mesh = deprecated
from fretfe.cli.app import main
sys.argv[0] = "fretfe"
main()
"""
OLD_OPTION = "pc_factor_mat_solver_package"  # deprecated since PETSc 3.9
SETS_OLD_OPTION = f"""
from fretfe.fem._compat import PETSc
PETSc.Options()["{OLD_OPTION}"] = "mumps"
def test_factorisation() -> None:
    solver = PETSc.PC().create(PETSc.COMM_SELF)
    solver.setType("lu")
    solver.setFromOptions()
"""


@pytest.mark.parametrize("module", ["dolfinx.fem.petsc", "ufl.core.expr", "numpy", "petsc4py"])
@pytest.mark.parametrize("kind", [DeprecationWarning, FutureWarning, PendingDeprecationWarning])
def test_in_this_process(module: str, kind: type[Warning]) -> None:
    with pytest.raises(kind, match="old"):
        warnings.warn_explicit("old", kind, "library.py", 1, module)


def test_in_a_run_that_a_test_starts(tmp_path: Path) -> None:
    write_b1(tmp_path / "pad.msh", order=1, h=0.1, growth=0.3)
    (tmp_path / "case.toml").write_text(PAD_ON_BLOCK)
    case, out = str(tmp_path / "case.toml"), str(tmp_path / "out")
    options = ["run", case, "--no-report", "-o", out]
    done = launch.python("-c", WITH_DEPRECATED_FUNCTION, *options, timeout=300)
    assert done.returncode != 0
    assert "DeprecationWarning: create_mesh is old" in done.stderr


def test_what_petsc_prints_fails_a_test(tmp_path: Path) -> None:
    (tmp_path / "test_old.py").write_text(SETS_OLD_OPTION)
    plugin = ["-m", "pytest", "-p", "conftest", "-p", "no:cacheprovider", "--rootdir", tmp_path]
    done = subprocess.run(
        [sys.executable, *map(str, plugin), str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
        env={**launch.ENVIRONMENT, "PYTHONPATH": str(TESTS)},
    )
    assert done.returncode == pytest.ExitCode.TESTS_FAILED, done.stderr
    assert "printed: PETSc DEPRECATION WARNING" in done.stdout


def test_what_petsc_prints_in_a_process_that_a_test_starts() -> None:
    script = f"{SETS_OLD_OPTION}\ntest_factorisation()"
    with pytest.raises(AssertionError, match=OLD_OPTION):
        launch.python("-c", script, timeout=300)
