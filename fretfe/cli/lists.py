# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands that list what there is: backends, templates, versions, the schema of case files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import examples
from fretfe.environment import rank_from_environment

BACKENDS_EXAMPLES = examples("fretfe backends", "fretfe backends pad.toml")


def backends(
    case: Annotated[
        Path | None,
        typer.Argument(metavar="CASE", help="Say which backends can solve this case."),
    ] = None,
) -> None:
    """List the installed backends, and why one cannot be used."""
    from rich.console import Console

    from fretfe.backends import installed_backends
    from fretfe.case import load_case
    from fretfe.report.page.listings import backend_table

    # On every rank: a backend that starts MPI when it is imported waits for the others.
    installed = installed_backends()
    if rank_from_environment() > 0:
        return
    read = load_case(case) if case is not None else None
    Console().print(backend_table(installed, read))


TEMPLATES_EXAMPLES = examples("fretfe templates", "fretfe templates dovetail")


def templates(
    name: Annotated[
        str | None, typer.Argument(help="Template whose parameters are listed.")
    ] = None,
) -> None:
    """List the geometry templates, or the parameters of one of them."""
    from rich.console import Console

    from fretfe.mesh.templates import find_template, template_names
    from fretfe.report.page.listings import parameter_table, template_table

    if name is None:
        table = template_table([find_template(each) for each in template_names()])
    else:
        table = parameter_table(find_template(name, "NAME"))
    if rank_from_environment() == 0:
        Console().print(table)


INFO_EXAMPLES = examples("fretfe info", "mpirun -n 2 fretfe info")


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


SCHEMA_EXAMPLES = examples("fretfe schema > case.schema.json")


def schema() -> None:
    """Print the JSON schema of case files."""
    from fretfe.case import case_schema

    print(json.dumps(case_schema(), indent=2))
