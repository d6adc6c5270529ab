# SPDX-License-Identifier: LGPL-3.0-or-later
"""Options and arguments that several commands share, and how much the commands print."""

from __future__ import annotations

import re
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

CaseFile = Annotated[
    Path, typer.Argument(metavar="CASE", help="Case file (TOML).", show_default=False)
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Replace a value of the case file; can be given several times.",
        show_default=False,
    ),
]
Backend = Annotated[str, typer.Option(help="halfplane, fem, or one of `fretfe backends`.")]
Resume = Annotated[
    bool, typer.Option("--resume", help="Continue the same run in the folder, if there is one.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only warnings and errors.")]
Verbose = Annotated[
    bool, typer.Option("--verbose", "-v", help="Print every step, on terminals too, and timings.")
]
TrustGeo = Annotated[
    bool,
    typer.Option(
        "--trust-geo", help="Run the Gmsh script (.geo) of the case: it can start any program."
    ),
]
Results = Annotated[
    Path, typer.Argument(metavar="DIR", help="Folder with results.", show_default=False)
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document in place of tables.")]


class Verbosity(Enum):
    """Warnings and errors only, the usual, or every step and all timings."""

    QUIET = "quiet"
    NORMAL = "normal"
    VERBOSE = "verbose"


def decimal(text: str | float) -> float:
    """Return a number of the command line, or a default, as a case may have it.

    Raises:
        BadParameter: if it is none, or not within the limits of a case.
    """
    from fretfe.case.base import LARGEST, written_number

    if abs(value := written_number(str(text))) <= LARGEST:
        return value
    raise typer.BadParameter(f"expected a number like 3, -0.5 or 1e-3, found {text!r}")


def positive(text: str | float) -> float:
    """Return a number of the command line, as a case may have it where it has to be > 0.

    Raises:
        BadParameter: if it is none, or not within the limits of a case.
    """
    from fretfe.case.base import SMALLEST

    if (value := decimal(text)) >= SMALLEST:
        return value
    raise typer.BadParameter(f"expected a number > 0, {SMALLEST:g} or more, found {text!r}")


def count(text: str | int) -> int:
    """Return a whole number of the command line, or a default, that is 1 or more.

    Raises:
        BadParameter: if it is none.
    """
    if re.fullmatch("0*[1-9][0-9]*", str(text)):
        return int(text)
    raise typer.BadParameter(f"expected a whole number of 1 or more, found {text!r}")


def verbosity_of(quiet: bool, verbose: bool) -> Verbosity:
    """Return how much is printed.

    Raises:
        BadParameter: if both options are given.
    """
    if quiet and verbose:
        raise typer.BadParameter("expected --quiet or --verbose, found both")
    if quiet:
        return Verbosity.QUIET
    return Verbosity.VERBOSE if verbose else Verbosity.NORMAL


def examples(*lines: str) -> str:
    """Text below the help of a command; the first character keeps the lines as they are."""
    return "\b\nExamples:\n" + "\n".join(f"  {line}" for line in lines)
