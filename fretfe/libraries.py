# SPDX-License-Identifier: LGPL-3.0-or-later
"""The start of libraries, which find no settings in the working folder, nor, but for MPI, in home.

PETSc, DOLFINx, FFCx, Matplotlib, Gmsh, OpenCASCADE, UCX and Numba look for files of settings in the
working folder, which may be a stranger's: such files name libraries to load, commands to run, and
tolerances. Variables of the environment stay the user's own.
"""

from __future__ import annotations

import ctypes
import importlib
import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

# From Linux's sched.h: what threads have in common of folders.
CLONE_FS = getattr(os, "CLONE_FS", 0x200)  # Python 3.12 names it
_LOCK = threading.RLock()


@contextmanager
def elsewhere(*, home: bool = False) -> Iterator[None]:
    """Work in another folder, in which libraries look for settings in vain; one thread at a time.

    Args:
        home: whether those in the home folder are not found either. MPI and what it is linked with
            keep theirs: on a cluster they say which network is used.
    """
    with _LOCK:
        # It may have no name any more, or one that cannot be read.
        back = os.open(".", os.O_PATH | os.O_CLOEXEC)
        variables = _no_home() if home else {}
        before = {name: os.environ.get(name) for name in variables}
        os.chdir(Path(__file__).parent)
        os.environ.update(variables)
        try:
            yield
        finally:
            os.fchdir(back)
            os.close(back)
            for name, value in before.items():
                os.environ.pop(name) if value is None else os.environ.update({name: value})


def _no_home() -> dict[str, str]:
    """Variables by which libraries find no settings in a home folder, but their caches."""
    cache = str(cache_folder())
    return {
        # A file, in which no library can make a folder; and a folder that is on no machine.
        "HOME": __file__,
        "XDG_CONFIG_HOME": "/nonexistent",
        "XDG_CACHE_HOME": cache,
        "MATPLOTLIBRC": os.devnull,
        # Without it Matplotlib would make one in the home folder, and says so if it cannot.
        "MPLCONFIGDIR": os.environ.get("MPLCONFIGDIR", f"{cache}/matplotlib"),
    }


def cache_folder() -> Path:
    """The folder for what can be made again, by the XDG Base Directory Specification."""
    return Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")).absolute()


def started(name: str) -> ModuleType:
    """A library, imported without settings of a folder if it has not been imported before.

    Raises:
        ImportError: if it cannot be.
    """
    if (known := sys.modules.get(name)) is not None:
        return known
    with elsewhere(home=True):
        module = importlib.import_module(name)
        # PyVista imports it too. It looks for its folder once.
        if drawing := sys.modules.get("matplotlib"):
            drawing.get_configdir()
    return module


def has_own_folder() -> bool:
    """Give this thread a working folder that others do not change; False if that is forbidden.

    In containers it often is.
    """
    return ctypes.CDLL(None).unshare(CLONE_FS) == 0
