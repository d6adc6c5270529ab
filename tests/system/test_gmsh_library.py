# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gmsh that does not load: all libraries that it lacks are named at once, with the commands."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from harness.launch import python

from fretfe.errors import DependencyError
from fretfe.mesh.gmsh import PACKAGES, import_gmsh, missing_libraries

LACKING = ("libGLU.so.1", "libXft.so.2", "libnobody.so.3")


def library(path: Path, needs: tuple[Path, ...] = ()) -> Path:
    """An empty shared library that needs others."""
    command = ["gcc", "-shared", "-Wl,--no-as-needed", f"-Wl,-soname,{path.name}", "-o", str(path)]
    subprocess.run([*command, "-x", "c", os.devnull, "-x", "none", *needs], check=True)
    return path


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """A folder with a gmsh.py and its library, which needs three that are gone."""
    gone = tuple(library(tmp_path / name) for name in LACKING)
    own = library(tmp_path / "libgmsh.so.4.99", gone)
    for path in gone:
        path.unlink()
    (tmp_path / "gmsh.py").write_text(f"import ctypes\nctypes.CDLL({str(own)!r})\n")
    return tmp_path


@pytest.fixture
def instead(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of a module that is imported in place of gmsh."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    return tmp_path / "gmsh.py"


def test_all_that_is_missing_is_found(broken: Path) -> None:
    # libraries of X that this machine has are found there: those under these names may be real
    found = missing_libraries(broken / "libgmsh.so.4.99")
    assert "libnobody.so.3" in found and set(found) <= set(LACKING)
    assert missing_libraries(Path(sys.executable)) == []


def test_libraries_and_commands_are_told(
    broken: Path, monkeypatch: pytest.MonkeyPatch, instead: Path
) -> None:
    monkeypatch.setattr("fretfe.mesh.gmsh.missing_libraries", lambda _: sorted(LACKING))
    with pytest.raises(DependencyError) as caught:
        import_gmsh()
    told = str(caught.value).splitlines()
    assert told[0].endswith("not found: libGLU.so.1, libXft.so.2, libnobody.so.3.")
    packages = "libglu1-mesa libxft2 and the package that has libnobody.so.3"
    assert told[1] == f"Debian, Ubuntu:  apt install {packages}"
    assert told[2].startswith("Without root:") and sys.executable in told[2]


@pytest.mark.parametrize(
    ("command", "exit_code"), [(["info"], 0), (["mesh", "case.toml", "-o", "case.msh"], 7)]
)
def test_commands_tell_what_is_missing(broken: Path, command: list[str], exit_code: int) -> None:
    (broken / "case.toml").write_text(
        '[geometry]\ntemplate = "cylinder"\n'
        "[bodies]\nupper = { young = 1e5, poisson = 0.3 }\nlower = { young = 1e5, poisson = 0.3 }\n"
        '[contacts.main]\nsurface1 = "upper_contact"\nsurface2 = "lower_contact"\nfriction = 0.4\n'
        '[supports]\nbase = { boundary = "lower_bottom", fix = ["x", "y"] }\n'
        '[loads.press]\ntype = "platen"\nboundary = "upper_top"\ndirection = "y"\n'
        'control = "force"\nhistory = [{ ramp = -600, until = 1, steps = 5 }]\n'
    )
    code = (
        f"import os, sys; os.chdir({str(broken)!r}); sys.path.insert(0, os.getcwd());"
        f"sys.argv = {['fretfe', *command]}; from fretfe.__main__ import main; main()"
    )
    done = python("-c", code)
    assert done.returncode == exit_code, done.stderr
    told = done.stdout + done.stderr
    assert told.count("libnobody.so.3") == 2  # in the list, and as a package
    assert "apt install" in told and "Traceback" not in told
    assert ("BLAS" in done.stdout) == (command == ["info"])


def test_the_first_library_is_named_where_there_is_no_more_to_see(instead: Path) -> None:
    instead.write_text('raise OSError("libGLU.so.1: cannot open shared object file: No such file")')
    with pytest.raises(DependencyError, match=r"not found: libGLU\.so\.1\.\n.*libglu1-mesa"):
        import_gmsh()


@pytest.mark.parametrize(
    ("cause", "message"),
    [
        ('OSError("libgmsh.so: invalid ELF header")', r"not load \(libgmsh\.so: invalid ELF"),
        ('ImportError("broken")', "pip install gmsh"),
    ],
    ids=["damaged", "not installed"],
)
def test_other_reasons(instead: Path, cause: str, message: str) -> None:
    instead.write_text(f"raise {cause}")
    with pytest.raises(DependencyError, match=message):
        import_gmsh()


def test_no_memory(instead: Path) -> None:
    instead.write_text('raise OSError("libX11.so.6: failed to map segment from shared object")')
    with pytest.raises(MemoryError):
        import_gmsh()


def test_the_page_of_installation_names_the_packages() -> None:
    page = Path(__file__).parents[2] / "docs" / "install.md"
    assert all(package in page.read_text("utf-8") for package in PACKAGES.values())
