# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command line: `fretfe run`, `validate`, `verify`, `backends`, `check` and others.

Exit codes: 0 success, 1 unexpected error, 2 case file or usage, 3 geometry or mesh, 4 model,
5 no convergence, 6 output, 7 missing dependency.
"""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from typing import Annotated

import typer

from fretfe.environment import rank_from_environment
from fretfe.errors import FretfeError

app = typer.Typer(
    help="Fretting contacts by finite elements: edge factors and slip zones of two-body contacts.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

CaseFile = Annotated[Path, typer.Argument(help="Case file (TOML).", show_default=False)]


@app.command()
def run(
    case: CaseFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for the results; made if missing.")
    ],
    backend: Annotated[
        str, typer.Option(help="analytic, halfplane, fem, or one of `fretfe backends`.")
    ] = "fem",
    timings: Annotated[bool, typer.Option(help="Print the wall time of each phase.")] = False,
    report: Annotated[
        bool, typer.Option("--report/--no-report", help="Make report.html in the folder.")
    ] = True,
) -> None:
    """Solve a case and write its results.

    Under MPI: mpirun -n 4 fretfe run CASE -o DIR
    """
    from fretfe.command import run_case

    run_case(case, output, backend, timings=timings, report=report)


@app.command("report")
def make_report(
    directory: Annotated[
        Path, typer.Argument(help="Folder with the results of a run.", show_default=False)
    ],
) -> None:
    """Make report.html from the results in a folder, as `fretfe run` does at its end."""
    from fretfe.report.page import write_report

    if rank_from_environment() == 0:
        typer.echo(f"Report in {write_report(directory)}")


@app.command()
def backends(
    case: Annotated[
        Path | None, typer.Argument(help="Case file: say which backends can solve it.")
    ] = None,
) -> None:
    """List the installed backends, and why one of them cannot be used."""
    from fretfe.command import show_backends

    show_backends(case)


@app.command()
def validate(
    case: CaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results.")
    ] = None,
    backend: Annotated[str, typer.Option(help="As for `fretfe run`.")] = "fem",
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document in place of the table.")
    ] = False,
) -> None:
    """Run a case and its companions: does the edge description hold for this geometry?

    Exit code 1 if a comparison fails.
    """
    from fretfe.validate_command import validate_case

    if not validate_case(case, output, backend, as_json=as_json):
        raise typer.Exit(1)


@app.command()
def verify(
    backend: Annotated[
        list[str] | None, typer.Option(help="Only this backend; can be given several times.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document in place of tables.")
    ] = False,
) -> None:
    """Run benchmarks with known answers; exit code 1 if one of them fails."""
    from fretfe.command import verify_backends

    if not verify_backends(backend or (), as_json=as_json):
        raise typer.Exit(1)


@app.command()
def check(case: CaseFile) -> None:
    """Validate a case and its mesh and list what would be solved, without solving it."""
    from fretfe.fem.command import check_case

    check_case(case)


@app.command()
def mesh(
    case: CaseFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Mesh file to write (.msh).")],
) -> None:
    """Make the mesh of a case and write it in Gmsh's format, with its named groups."""
    from fretfe.fem.command import write_mesh_file

    write_mesh_file(case, output)


@app.command()
def edges(
    table: Annotated[Path, typer.Argument(help="CSV file with a header.", show_default=False)],
    friction: Annotated[float | None, typer.Option(help="Friction coefficient.")] = None,
    x: Annotated[str, typer.Option(help="Column with the positions along the contact.")] = "x",
    p: Annotated[str, typer.Option(help="Column with the pressure, positive.")] = "p",
    q: Annotated[str | None, typer.Option(help="Column with the shear (default: q).")] = None,
    slip: Annotated[str | None, typer.Option(help="Column with the slip (default: slip).")] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document in place of tables.")
    ] = False,
) -> None:
    """Find edge positions, K_N and slip zones in tractions that any program computed."""
    from fretfe.edges_command import Columns, analyse_file

    analyse_file(table, Columns(x, p, q, slip), friction, as_json=as_json)


@app.command()
def info() -> None:
    """Show versions, MPI and the linear-algebra library in use."""
    from fretfe.fem.command import show_info

    show_info()


@app.command()
def schema() -> None:
    """Print the JSON schema of case files."""
    from fretfe.case import case_schema

    typer.echo(json.dumps(case_schema(), indent=2))


def main() -> None:
    """Entry point: every error of a user ends with one message and its exit code."""
    try:
        app()
    except FretfeError as error:
        _finish(error.exit_code, f"fretfe: error: {error}")
    except Exception:
        _finish(1, traceback.format_exc())


def _finish(code: int, message: str) -> None:
    """Print a message once and end this process, or all of them if only this one failed.

    An error of the user is raised on every rank, and the first one reports it. Anything else may
    have happened on one rank alone, and the others would wait for it for ever.
    """
    communicator = _communicator()
    if communicator is None or communicator.size == 1:
        if rank_from_environment() == 0:
            print(message, file=sys.stderr, flush=True)
        sys.exit(code)
    if code == 1:
        print(f"rank {communicator.rank}: {message}", file=sys.stderr, flush=True)
        communicator.Abort(code)
    if communicator.rank == 0:
        print(message, file=sys.stderr, flush=True)
    sys.exit(code)


def _communicator():  # type: ignore[no-untyped-def]
    """The world communicator, if MPI is in use at all."""
    mpi = sys.modules.get("mpi4py.MPI")
    return mpi.COMM_WORLD if mpi is not None else None
