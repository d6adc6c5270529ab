# SPDX-License-Identifier: LGPL-3.0-or-later
"""Check that DOLFINx and Gmsh load, and say which system libraries are missing if not.

The Gmsh wheel brings its own library, but that needs a few libraries of the X window system.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
from pathlib import Path

# Debian and Ubuntu package of each library that libgmsh.so needs and a small image may lack.
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
REMEDY = """\
Gmsh is installed but does not load: {error}
Missing system libraries: {missing}
Debian, Ubuntu:  apt install {packages}
Without root:    {python} -m pip install --force-reinstall --no-deps \\
                     -i https://gmsh.info/python-packages-dev-nox gmsh
                 (Gmsh's own build that needs no X libraries), then run make again"""


def missing_libraries() -> list[str]:
    """Return the sonames that the dynamic linker does not find for libgmsh."""
    missing = []
    for library in Path(sys.prefix, "lib").glob("libgmsh.so*"):
        listing = subprocess.run(["ldd", library], capture_output=True, text=True, check=False)
        lines = listing.stdout.splitlines()
        missing += [line.split()[0] for line in lines if "not found" in line]
    return sorted(set(missing))


def main() -> None:
    """Import what the finite-element part needs; exit with a message if something fails."""
    # dolfinx_solver first: it loads the MPI library that the others are linked with.
    for name in ("dolfinx_solver", "mpi4py.MPI", "petsc4py.PETSc", "dolfinx"):
        importlib.import_module(name)
    try:
        importlib.import_module("gmsh")
    except OSError as error:
        missing = missing_libraries()
        packages = [PACKAGES.get(name, f"<the package with {name}>") for name in missing]
        sys.exit(
            REMEDY.format(
                error=error,
                missing=" ".join(missing) or "unknown",
                packages=" ".join(packages or PACKAGES.values()),
                python=sys.executable,
            )
        )


if __name__ == "__main__":
    main()
