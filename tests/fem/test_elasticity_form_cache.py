# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forms are compiled once and kept; what a killed compilation left is no reason to wait."""

from __future__ import annotations

import fcntl
from pathlib import Path
from typing import Any

import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import create_unit_square

from fretfe.fem import elasticity as form_cache
from fretfe.fem._compat import MPI
from fretfe.fem.elasticity import FOLDER, LOCK, compiled


@pytest.fixture(name="folder")
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(form_cache, "cache_folder", lambda: tmp_path)
    folder = tmp_path / FOLDER
    folder.parent.mkdir(exist_ok=True)
    return folder


def area(factor: float = 1.0) -> Any:
    """The area of a square times a factor, which is a part of the form."""
    mesh = create_unit_square(MPI.COMM_SELF, 2, 2)
    return compiled(MPI.COMM_SELF, fem.form, factor * ufl.dx(domain=mesh))


def test_a_form_is_compiled_once(folder: Path) -> None:
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    (library,) = folder.glob("*.so")
    made = library.stat().st_mtime_ns
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    assert library.stat().st_mtime_ns == made
    assert len(list(folder.glob("*.c"))) == 1


def test_other_flags_of_the_compiler_make_another_library(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    monkeypatch.setattr(form_cache, "COMPILER_FLAGS", ("-O1", "-g0"))
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    assert len(list(folder.glob("*.so"))) == 2


def test_what_a_killed_compilation_left_is_removed(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A source without the mark of its end: FFCx would wait for it."""
    area()
    (mark,) = folder.glob("*.c.cached")
    mark.unlink()
    # FFCx would end with an error after that time; compiling may take long on a busy machine.
    monkeypatch.setattr(form_cache, "TIMEOUT", 1)
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    assert mark.exists()


def test_a_process_that_compiles_is_left_alone(folder: Path) -> None:
    area()
    other = folder / "libffcx_forms_of_another_process.c"
    other.touch()
    with (folder / LOCK).open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_SH)
        assert fem.assemble_scalar(area(2.0)) == pytest.approx(2.0)
        assert other.exists()
    area(3.0)
    assert not other.exists()


def test_without_a_folder_that_can_be_used_another_is_made(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    form_cache._own_folder.cache_clear()
    monkeypatch.setattr("tempfile.tempdir", str(folder.parent))
    folder.write_text("a file where the folder would be")
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    assert fem.assemble_scalar(area()) == pytest.approx(1.0)
    (other,) = folder.parent.glob("fretfe-*")
    assert len(list(other.glob("*.so"))) == 1
    form_cache._own_folder.cache_clear()
