# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command line: help, commands and what becomes of errors.

The modules of the commands import what they need inside their functions: the help is quick.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys
import time
import traceback
from collections.abc import Callable
from typing import Annotated

import typer

from fretfe.cli import decision, exchange, laboratory, lists, meshes, other_models, run
from fretfe.environment import (
    memory_shortage,
    missing_folder,
    missing_package,
    rank_from_environment,
)
from fretfe.errors import CaseError, DependencyError, FretfeError, MemoryShortError, OutputError
from fretfe.files import disk_reason
from fretfe.terminal import patient_streams

HELP = """Edge factors and slip zones of two-body fretting contacts, by finite elements.

\b
  fretfe check pad.toml           what would be solved
  fretfe run pad.toml -o pad      solve it
  fretfe COMMAND --help           options and examples
"""
EXIT_CODES = """\b
Exit codes:
  0  success
  1  unexpected error (a bug), or a comparison of validate or verify, or a margin, fails
  2  the case file or the command line is wrong
  3  the geometry, the mesh or the physical groups are wrong
  4  the model is wrong: nothing holds a body, or surfaces never meet
  5  a load step has no solution, or equilibrium is lost; the steps before it are written
  6  results, or what is printed, cannot be written or read
  7  a library is missing
  8  there is not enough memory
  9  an error of fretfe (a bug) left something unknown; all else is written
  129, 130, 143  SIGHUP, Ctrl-C, SIGTERM
"""
HELP_OPTIONS = ["--help", "-h"]
# Options of which each process prints the same and ends.
PRINTING = {*HELP_OPTIONS, "--version"}
# Seconds in which processes come upon the same error.
ALIKE = 1.0
app = typer.Typer(
    help=HELP,
    epilog=EXIT_CODES,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": HELP_OPTIONS},
)


def _print_version(asked: bool) -> None:
    if asked:
        import fretfe

        print(f"fretfe {fretfe.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    pass


# In the order of the help.
COMMANDS: tuple[tuple[Callable[..., None], str], ...] = (
    (run.run, run.RUN_EXAMPLES),
    (lists.report, lists.REPORT_EXAMPLES),
    (run.sweep, run.SWEEP_EXAMPLES),
    (lists.backends, lists.BACKENDS_EXAMPLES),
    (run.validate, run.VALIDATE_EXAMPLES),
    (laboratory.match, laboratory.MATCH_EXAMPLES),
    (run.verify, run.VERIFY_EXAMPLES),
    (meshes.check, meshes.CHECK_EXAMPLES),
    (meshes.mesh, meshes.MESH_EXAMPLES),
    (lists.templates, lists.TEMPLATES_EXAMPLES),
    (lists.materials, lists.MATERIALS_EXAMPLES),
    (exchange.edges, exchange.EDGES_EXAMPLES),
    (exchange.compare, exchange.COMPARE_EXAMPLES),
    (exchange.export, exchange.EXPORT_EXAMPLES),
    (other_models.forces, other_models.FORCES_EXAMPLES),
    (other_models.joint, other_models.JOINT_EXAMPLES),
    (exchange.submodel, exchange.SUBMODEL_EXAMPLES),
    (laboratory.strength, laboratory.STRENGTH_EXAMPLES),
    (decision.assess, decision.ASSESS_EXAMPLES),
    (lists.info, lists.INFO_EXAMPLES),
    (lists.schema, lists.SCHEMA_EXAMPLES),
)
for command, command_examples in COMMANDS:
    app.command(epilog=command_examples)(command)


def main() -> None:
    """Entry point: every error of a user ends with one message and its exit code."""
    with patient_streams() as lost:
        try:
            _run()
        except SystemExit as ended:
            reason = lost()
            if reason is not None and not ended.code:
                text = f"the standard output cannot be written: {disk_reason(reason)}"
                print(f"fretfe: error: {text}", file=sys.stderr)
                ended = SystemExit(OutputError.exit_code)
            if isinstance(ended.code, int) and ended.code:
                _end_others(ended.code)
            elif PRINTING & {*sys.argv}:
                # Others that have the same option print the same too, in about the same time.
                _end_others(0, ALIKE)
            raise ended


def _run() -> None:
    """Do what the command line says.

    Raises:
        SystemExit: with the exit code, at its end.
    """
    try:
        _require_text()
        app()
    except FretfeError as error:
        short = isinstance(error, MemoryShortError)
        _finish(error.exit_code, f"fretfe: error: {error}", alone=short)
    except Exception as error:
        if reason := memory_shortage(error):
            _finish(MemoryShortError.exit_code, f"fretfe: error: {reason}", alone=True)
        if reason := missing_package(error):
            _finish(DependencyError.exit_code, f"fretfe: error: {reason}")
        if reason := missing_folder():
            _finish(OutputError.exit_code, f"fretfe: error: {reason}")
        _finish(1, traceback.format_exc(), alone=True)


def _require_text() -> None:
    """Check that names of files are UTF-8 text, as case files, results and libraries need them.

    Raises:
        CaseError: with the first word of the command line, or the working folder, that is not.
    """
    # Names of files are relative to the working folder, where there are any.
    named = len(sys.argv) > 2 and not PRINTING & {*sys.argv} and not missing_folder()
    for word in [*sys.argv[1:], *([os.getcwd()] if named else [])]:
        if any("\udc80" <= letter <= "\udcff" for letter in word):
            raise CaseError(f"expected names in UTF-8, found {word!a}: rename it, or link to it")


def _finish(code: int, message: str, *, alone: bool = False) -> None:
    """Print a message once and end this process, or all of them if only this one failed.

    An error of the user is raised on every rank, and the first one reports it. With `alone` it may
    have happened on one rank only, and the others would wait for it for ever.
    """
    communicator = _communicator()
    if communicator is None or communicator.size == 1:
        if rank_from_environment():
            # The first process, if it has this error too, prints it, and ends all.
            time.sleep(ALIKE)
        print(message, file=sys.stderr, flush=True)
        sys.exit(code)
    if alone:
        print(f"rank {communicator.rank}: {message}", file=sys.stderr, flush=True)
        communicator.Abort(code)
    if communicator.rank == 0:
        print(message, file=sys.stderr, flush=True)
    sys.exit(code)


def _end_others(code: int, wait: float = 0.0) -> None:
    """End all processes of MPICH's launcher if this one ends before MPI is in use.

    Those that use it wait for this one for ever: its launcher does not end them because a process
    has ended, but if that says so. Other launchers do.

    Args:
        code: exit code of all.
        wait: seconds that others may need to come to the same end.
    """
    channel = os.environ.get("PMI_FD", "")
    if _communicator() is not None or not channel.isdecimal():
        return
    time.sleep(wait + (ALIKE if rank_from_environment() else 0.0))
    with contextlib.suppress(OSError):
        # A process that this one was started by may have had the channel, and this one has not.
        if stat.S_ISSOCK(os.fstat(int(channel)).st_mode):
            os.write(int(channel), f"cmd=abort exitcode={code}\n".encode())


def _communicator():  # type: ignore[no-untyped-def]
    """The world communicator, if MPI is in use at all."""
    mpi = sys.modules.get("mpi4py.MPI")
    return mpi.COMM_WORLD if mpi is not None else None
