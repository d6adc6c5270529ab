# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe info`; the first process prints."""

from __future__ import annotations

from fretfe.cli.options import examples

EXAMPLES = examples("fretfe info", "mpirun -n 2 fretfe info")


def info() -> None:
    """Show versions, MPI and the linear-algebra library in use.

    Ends with an error that names what is missing if Gmsh does not load.
    """
    from rich.console import Console

    from fretfe.environment import blas_libraries, reference_blas, versions
    from fretfe.fem import _compat
    from fretfe.fem._compat import MPI
    from fretfe.mesh.gmsh import import_gmsh

    if MPI.COMM_WORLD.rank != 0:
        return
    console = Console()
    for name, version in {**versions(), **_compat.versions()}.items():
        console.print(f"{name:12s} {version}", highlight=False)
    console.print(f"{'MPI ranks':12s} {MPI.COMM_WORLD.size}", highlight=False)
    libraries = blas_libraries()
    for library in libraries:
        console.print(f"{'BLAS':12s} {library}", highlight=False, soft_wrap=True)
    for library in reference_blas(libraries):
        console.print(
            f"Warning: {library} is the reference BLAS, which makes factorisations about four "
            "times slower. Install OpenBLAS (Debian: libopenblas0-pthread).",
            highlight=False,
            soft_wrap=True,
        )
    import_gmsh()
