# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files of settings in the working folder and in home, which no library reads.

They are of PETSc, also that of Gmsh, DOLFINx, FFCx, setuptools, Matplotlib, Numba, UCX, Gmsh and
OpenCASCADE. Linux tells of each file whether anybody has opened it.
"""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest
import tomli_w
from cases.pad_cases import cylinder, pad_text
from cases.user_geometry import cad_geometry, case_of, write_cad
from harness.launch import ENVIRONMENT, python

from fretfe.libraries import cache_folder

# Of inotify.h: somebody opens a file, or asks for none but what has happened.
IN_OPEN = 0x20
NOT_BLOCKING = os.O_NONBLOCK
EVENT = struct.Struct("iIII")
# Each of them does harm if it is heeded: it writes a file, loads a library, or is no settings.
PETSC = "-log_view :heeded\n-dll_append /heeded.so\n"
HOSTILE = "heeded\0"
BOTH = (".petscrc", "matplotlibrc", "setup.cfg", "pyproject.toml", ".gmshrc", ".gmsh-options")
WORKING = (
    *BOTH,
    "petscrc",
    "dolfinx_jit_options.json",
    "ffcx_options.json",
    "ucx.conf",
    ".numba_config.yaml",
    "untitled.geo",
    "XSTEP.us",
    "SHAPE.us",
    # Modules that Python would take in place of those that are installed.
    "numpy.py",
    "gmsh.py",
    "dolfinx.py",
)
# UCX, as MPI, keeps what is in home.
HOME = (
    *BOTH,
    ".pydistutils.cfg",
    ".numba_config.yaml",
    ".config/dolfinx/dolfinx_jit_options.json",
    ".config/ffcx/ffcx_options.json",
    ".config/matplotlib/matplotlibrc",
    ".config/matplotlib/stylelib/own.mplstyle",
    ".matplotlib/matplotlibrc",
)


class Watched:
    """Files of which it is known whether they have been opened.

    Args:
        folder: the working folder; home is below it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.home = folder, folder / "home"
        self._libc = ctypes.CDLL(None, use_errno=True)
        self._inotify = self._libc.inotify_init1(NOT_BLOCKING)
        self._names: dict[int, str] = {}
        for name in (*WORKING, *(f"home/{each}" for each in HOME)):
            self.add(name, PETSC if name.endswith("petscrc") else HOSTILE)

    def add(self, name: str, text: str) -> None:
        """Write a file, and watch it from now on."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        number = self._libc.inotify_add_watch(self._inotify, os.fsencode(path), IN_OPEN)
        assert number > 0, os.strerror(ctypes.get_errno())
        self._names[number] = name

    def opened(self) -> set[str]:
        """Return the names of those that have been opened."""
        try:
            told = os.read(self._inotify, 1 << 16)
        except BlockingIOError:
            return set()
        return {self._names[number] for number, *_ in EVENT.iter_unpack(told)}

    def close(self) -> None:
        """Watch them no more."""
        os.close(self._inotify)


@pytest.fixture
def stranger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Watched]:
    """A working folder with a home, both full of settings."""
    watched = Watched(tmp_path)
    # What others have compiled saves a minute.
    monkeypatch.setitem(ENVIRONMENT, "XDG_CACHE_HOME", str(cache_folder()))
    monkeypatch.setitem(ENVIRONMENT, "HOME", str(watched.home))
    for name in ("XDG_CONFIG_HOME", "MPLCONFIGDIR", "MATPLOTLIBRC"):
        monkeypatch.delitem(ENVIRONMENT, name, raising=False)
    yield watched
    watched.close()


def write_pad(watched: Watched) -> None:
    (watched.folder / "pad.toml").write_text(pad_text(geometry=cylinder(size=0.1)))


def require_no_other(watched: Watched, *arguments: str, ranks: int = 1) -> None:
    """Run Python in the folder, and check that it ends well without having opened a file."""
    done = python(*arguments, ranks=ranks, folder=watched.folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert watched.opened() == set()
    assert not (watched.folder / "heeded").exists()


def test_the_files_are_watched(stranger: Watched) -> None:
    (stranger.folder / "petscrc").read_text()
    (stranger.home / ".petscrc").read_text()
    assert stranger.opened() == {"petscrc", "home/.petscrc"}


def test_a_run_reads_no_settings(stranger: Watched) -> None:
    write_pad(stranger)
    require_no_other(stranger, "-m", "fretfe", "run", "pad.toml", "-o", "pad", "--quiet")
    assert (stranger.folder / "pad" / "report.html").exists()


def test_processes_read_no_settings(stranger: Watched) -> None:
    write_pad(stranger)
    words = ("run", "pad.toml", "-o", "pad", "--quiet", "--no-report", "--ranks", "2")
    require_no_other(stranger, "-m", "fretfe", *words)


FIGURE = """
import fretfe
fretfe.verify
from fretfe.report import theme
theme.draw_in(None, 1, 1, 2.0, lambda panels: None)
import matplotlib
assert not matplotlib.rcParams["text.usetex"]
"""
FIELDS = "from fretfe.results.tables import require; require('pyvista').Sphere()"
# A form that nobody has compiled before is compiled.
COMPILED = """
import os, ufl
os.environ["XDG_CACHE_HOME"] = os.path.abspath("cache")
from fretfe.fem._compat import MPI, dolfinx
from fretfe.fem.elasticity import compiled
mesh = dolfinx.mesh.create_unit_interval(MPI.COMM_SELF, 1)
compiled(MPI.COMM_SELF, dolfinx.fem.form, 1.0 * ufl.dx(domain=mesh))
"""


@pytest.mark.parametrize("program", [FIGURE, FIELDS, COMPILED], ids=["figure", "fields", "form"])
def test_programs_read_no_settings(stranger: Watched, program: str) -> None:
    require_no_other(stranger, "-c", program)


def test_the_environment_is_the_users(stranger: Watched, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENVIRONMENT, "PETSC_OPTIONS", "-own_option 7")
    program = "from fretfe.fem._compat import PETSc; print(PETSc.Options().getInt('own_option'))"
    assert python("-c", program, folder=stranger.folder).stdout.split() == ["7"]


# A file of options beside a mesh or a geometry is a script for Gmsh.
SCRIPT = 'SystemCall "touch heeded";'


def test_no_options_beside_a_mesh_are_executed(stranger: Watched) -> None:
    write_pad(stranger)
    require_no_other(stranger, "-m", "fretfe", "mesh", "pad.toml", "-o", "pad.msh")
    names = {"file": "pad.msh"}
    (stranger.folder / "again.toml").write_text(tomli_w.dumps(case_of(names)))
    stranger.add("pad.msh.opt", SCRIPT)
    require_no_other(stranger, "-m", "fretfe", "check", "again.toml")


def test_no_options_beside_a_geometry_are_executed(stranger: Watched) -> None:
    write_cad(stranger.folder / "pad.step")
    geometry = cad_geometry(Path("pad.step"), size=0.5)
    (stranger.folder / "step.toml").write_text(tomli_w.dumps(case_of(geometry)))
    stranger.add("pad.step.opt", SCRIPT)
    require_no_other(stranger, "-m", "fretfe", "check", "step.toml")
