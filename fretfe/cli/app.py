# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command line: `fretfe run`, `validate`, `verify`, `backends`, `check` and others."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path
from typing import Annotated

import typer

from fretfe.cli.options import (
    Backend,
    CaseFile,
    Overrides,
    Quiet,
    Results,
    TrustGeo,
    Verbose,
    verbosity_of,
)
from fretfe.environment import missing_package, rank_from_environment
from fretfe.errors import DependencyError, FretfeError


def _examples(*lines: str) -> str:
    """Text below the help of a command; the first character keeps the lines as they are."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)


HELP = """Fretting contacts by finite elements: edge factors and slip zones of two-body contacts.

\b
  fretfe check pad.toml           what would be solved
  fretfe run pad.toml -o pad      solve it
  fretfe COMMAND --help           options and examples
"""
EXIT_CODES = """\b
Exit codes:
  0  success
  1  unexpected error (a bug), or a comparison of validate or verify that fails
  2  the case file or the command line is wrong
  3  geometry, mesh or physical groups
  4  the model: a body that nothing holds, surfaces that never meet
  5  a load step has no solution; the steps before it are written
  6  results cannot be written
  7  a library is missing
  130, 143  Ctrl-C, SIGTERM
"""
app = typer.Typer(
    help=HELP,
    epilog=EXIT_CODES,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.command(
    epilog=_examples(
        "fretfe run pad.toml -o pad",
        "fretfe run pad.toml -o pad70 --set loads.shear.amplitude=70",
        "fretfe run pad.toml -o half --backend halfplane",
        "mpirun -n 4 fretfe run pad.toml -o pad",
    )
)
def run(
    case: CaseFile,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for the results; made if missing.")
    ],
    backend: Backend = "fem",
    overrides: Overrides = None,
    timings: Annotated[
        bool, typer.Option("--timings", help="Print the wall time of each phase.")
    ] = False,
    report: Annotated[
        bool, typer.Option("--report/--no-report", help="Make report.html in the folder.")
    ] = True,
    quiet: Quiet = False,
    verbose: Verbose = False,
    trust_geo: TrustGeo = False,
) -> None:
    """Solve a case and write its results."""
    from fretfe.cli.run import run_case

    run_case(
        case,
        output,
        backend,
        overrides or (),
        verbosity_of(quiet, verbose),
        timings=timings,
        report=report,
        trust_geo=trust_geo,
    )


@app.command(epilog=_examples("fretfe report pad"))
def report(directory: Results) -> None:
    """Make report.html again from the results in a folder."""
    from fretfe.cli.report import make_report

    make_report(directory)


@app.command(
    epilog=_examples(
        "fretfe sweep pad.toml -o mu --vary contacts.main.friction=0.3:0.8:11",
        "fretfe sweep pad.toml -o map --vary contacts.main.friction=0.4,0.6,0.8 \\",
        "    --vary loads.shear.amplitude=20:80:4",
    )
)
def sweep(
    case: CaseFile,
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=VALUES",
            help="START:STOP:COUNT or A,B,C; several times for all combinations.",
            show_default=False,
        ),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for table and picture; made if missing.")
    ],
    backend: Backend = "fem",
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    trust_geo: TrustGeo = False,
) -> None:
    """Solve a case with many values of some keys: a table, a picture.

    Friction and load histories need no new factorisation: they are cheap to vary.
    """
    from fretfe.cli.sweep import sweep_case

    sweep_case(
        case,
        vary,
        output,
        backend,
        overrides or (),
        verbosity_of(quiet, verbose),
        trust_geo=trust_geo,
    )


@app.command(epilog=_examples("fretfe backends", "fretfe backends pad.toml"))
def backends(
    case: Annotated[
        Path | None,
        typer.Argument(metavar="CASE", help="Say which backends can solve this one."),
    ] = None,
) -> None:
    """List the installed backends, and why one cannot be used."""
    from fretfe.cli.backends import show_backends

    show_backends(case)


@app.command(epilog=_examples("fretfe validate pad.toml", "fretfe validate pad.toml -o pad --json"))
def validate(
    case: CaseFile,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Folder for the results.")
    ] = None,
    backend: Backend = "fem",
    overrides: Overrides = None,
    quiet: Quiet = False,
    verbose: Verbose = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document in place of the table.")
    ] = False,
    trust_geo: TrustGeo = False,
) -> None:
    """Run a case and its companions: can its numbers be trusted?

    Exit code 1 if a comparison fails.
    """
    from fretfe.cli.validate import validate_case

    verbosity = verbosity_of(quiet, verbose)
    passed = validate_case(
        case,
        output,
        backend,
        overrides or (),
        verbosity,
        as_json=as_json,
        trust_geo=trust_geo,
    )
    if not passed:
        raise typer.Exit(1)


@app.command(
    epilog=_examples("fretfe verify", "fretfe verify --backend halfplane --backend analytic")
)
def verify(
    backend: Annotated[
        list[str] | None, typer.Option(help="Only this backend; can be given several times.")
    ] = None,
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON document in place of tables.")
    ] = False,
) -> None:
    """Run benchmarks with known answers.

    Exit code 1 if one of them fails.
    """
    from fretfe.cli.verify import verify_backends

    if not verify_backends(backend or (), as_json=as_json):
        raise typer.Exit(1)


@app.command(
    epilog=_examples(
        "fretfe check pad.toml", "fretfe check pad.toml --set geometry.parameters.size=0.02"
    )
)
def check(case: CaseFile, overrides: Overrides = None, trust_geo: TrustGeo = False) -> None:
    """Check a case and its mesh, and list what would be solved."""
    from fretfe.cli.check import check_case

    check_case(case, overrides or (), trust_geo=trust_geo)


@app.command(epilog=_examples("fretfe mesh pad.toml -o pad.msh"))
def mesh(
    case: CaseFile,
    output: Annotated[Path, typer.Option("--output", "-o", help="Mesh file to write (.msh).")],
    overrides: Overrides = None,
    trust_geo: TrustGeo = False,
) -> None:
    """Make the mesh of a case and write it for Gmsh.

    With its named groups, and a picture beside it.
    """
    from fretfe.cli.mesh import write_mesh_file

    write_mesh_file(case, output, overrides or (), trust_geo=trust_geo)


@app.command(epilog=_examples("fretfe templates", "fretfe templates dovetail"))
def templates(
    name: Annotated[str | None, typer.Argument(help="Template: list its parameters.")] = None,
) -> None:
    """List the geometry templates, or the parameters of one of them."""
    from fretfe.cli.templates import show_templates

    show_templates(name)


@app.command(
    epilog=_examples(
        "fretfe edges tractions.csv --friction 0.6",
        "fretfe edges tractions.csv --x arc --p pressure --q shear --json",
    )
)
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
    """Find edges, K_N and slip zones in tractions of any program."""
    from fretfe.cli.edges import Columns, analyse_file

    analyse_file(table, Columns(x, p, q, slip), friction, as_json=as_json)


@app.command(epilog=_examples("fretfe animate pad -o cycle.gif"))
def animate(
    results: Results,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write (.gif).")],
) -> None:
    """Draw the evaluated cycle of a run as an animation.

    The run needs the fields of all steps.
    """
    from fretfe.cli.pictures import animate

    animate(results, output)


@app.command(epilog=_examples("fretfe scene pad -o pad.gltf"))
def scene(
    results: Results,
    output: Annotated[Path, typer.Option("--output", "-o", help="File to write (.gltf).")],
) -> None:
    """Write the bodies and their last stress as a glTF scene."""
    from fretfe.cli.pictures import export

    export(results, output)


@app.command(epilog=_examples("fretfe info", "mpirun -n 2 fretfe info"))
def info() -> None:
    """Show versions, MPI and the linear-algebra library in use."""
    from fretfe.cli.info import show_info

    show_info()


@app.command(epilog=_examples("fretfe schema > case.schema.json"))
def schema() -> None:
    """Print the JSON schema of case files."""
    from fretfe.cli.schema import show_schema

    show_schema()


def main() -> None:
    """Entry point: every error of a user ends with one message and its exit code."""
    try:
        app()
    except FretfeError as error:
        _finish(error.exit_code, f"fretfe: error: {error}")
    except Exception as error:
        if reason := missing_package(error):
            _finish(DependencyError.exit_code, f"fretfe: error: {reason}")
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
