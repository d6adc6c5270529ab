# SPDX-License-Identifier: LGPL-3.0-or-later
"""Load Gmsh, or say what its library lacks on this system and which command brings it."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

from fretfe.errors import DependencyError

# Debian and Ubuntu package of each library that libgmsh.so of the wheel needs and a small image may
# lack.
PACKAGES = {
    "libGL.so.1": "libgl1",
    "libGLU.so.1": "libglu1-mesa",
    "libX11.so.6": "libx11-6",
    "libXcursor.so.1": "libxcursor1",
    "libXext.so.6": "libxext6",
    "libXfixes.so.3": "libxfixes3",
    "libXft.so.2": "libxft2",
    "libXinerama.so.1": "libxinerama1",
    "libXrender.so.1": "libxrender1",
    "libfontconfig.so.1": "libfontconfig1",
    "libgomp.so.1": "libgomp1",
}
# What the loader says of a library for which there is no memory, and of one that is not there.
NO_ROOM = re.compile("failed to map segment|[Cc]annot allocate memory")
NOT_THERE = re.compile(r"^(lib\S+\.so\S*): cannot open shared object file")
# Gmsh's own build without windows, which needs no X libraries.
WITHOUT_ROOT = (
    "-m pip install --force-reinstall --no-deps -i https://gmsh.info/python-packages-dev-nox gmsh"
)


def import_gmsh() -> ModuleType:
    """Import gmsh.

    Raises:
        DependencyError: gmsh is not installed, or does not load; all shared libraries that it lacks
            are named.
        MemoryError: there is no room for a library.
    """
    try:
        import gmsh
    except ImportError as error:
        raise DependencyError(
            f"reading and making meshes needs the Python package gmsh, which does not import"
            f" ({error}). Install it with `pip install gmsh` or from your distribution (Debian:"
            " python3-gmsh)"
        ) from error
    except OSError as error:
        if NO_ROOM.search(str(error)):
            raise MemoryError from error
        raise DependencyError(_remedy(error)) from error
    return gmsh


def missing_libraries(library: Path) -> list[str]:
    """Names of the shared libraries that a library needs and the dynamic linker does not find."""
    try:
        listing = subprocess.run(["ldd", library], capture_output=True, text=True, check=False)
    except OSError:  # a system without ldd
        return []
    return sorted(set(re.findall(r"^\s*(\S+) => not found", listing.stdout, re.MULTILINE)))


def _gmsh_libraries() -> list[Path]:
    """Gmsh's library beside its Python module: pip puts it two folders above, conda may not."""
    spec = importlib.util.find_spec("gmsh")
    if spec is None or spec.origin is None:
        return []
    above = list(Path(spec.origin).resolve().parents)[:3]
    folders = [folder / sub for folder in above for sub in (".", "lib")]
    return [path for folder in folders for path in folder.glob("libgmsh.so*")]


def _remedy(error: OSError) -> str:
    """What Gmsh lacks, all of it, and the commands that bring it."""
    missing = [name for library in _gmsh_libraries() for name in missing_libraries(library)]
    # The loader stops at the first one.
    missing = sorted({*missing, *NOT_THERE.findall(str(error))})
    if not missing:
        return f"gmsh is installed but does not load ({error}). Install it anew"
    known = [PACKAGES[name] for name in missing if name in PACKAGES]
    unknown = [f"the package that has {name}" for name in missing if name not in PACKAGES]
    packages = " and ".join(filter(None, [" ".join(known), *unknown]))
    return (
        f"gmsh is installed but needs shared libraries that were not found: {', '.join(missing)}.\n"
        f"Debian, Ubuntu:  apt install {packages}\n"
        f"Without root:    {sys.executable} {WITHOUT_ROOT}"
    )
