# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe validate`; the first process prints."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.cli.progress import StepReport
from fretfe.cli.verbosity import Verbosity
from fretfe.quality.validate import Validation
from fretfe.quality.validate.report import as_numbers, print_validation
from fretfe.runner import Runner

NARROWEST = 100


class _PhaseReport(StepReport):
    """Progress of several runs of a case: each is named where it begins."""

    def __init__(self, name: str, rank: int, verbosity: Verbosity) -> None:
        super().__init__(rank, verbosity, steps=False)
        self._name = name
        self._console = Console(stderr=True, quiet=rank > 0 or verbosity is Verbosity.QUIET)

    def phase(self, text: str) -> None:
        """Name the run that begins."""
        self._console.print(f"{self._name}: {text}", highlight=False)

    def announce(self, text: str) -> None:
        """Leave out the meshes."""


def validate_case(
    path: Path,
    directory: Path | None,
    name: str,
    overrides: Sequence[str] = (),
    verbosity: Verbosity = Verbosity.NORMAL,
    *,
    as_json: bool,
    trust_geo: bool = False,
) -> bool:
    """Validate a case, print the rows, and return True if all is well. Collective like the backend.

    Args:
        path: of the case file.
        directory: for results and rows; None writes nothing.
        name: of the backend.
        overrides: values in place of those of the file, like ``loads.shear.amplitude=120``.
        verbosity: if quiet, nothing is printed unless a comparison fails; if verbose, every step
            of every run too.
        as_json: print one JSON document in place of the table.
        trust_geo: whether a .geo file of the case may run.
    """
    runner = Runner.find(name)
    if runner.idle:
        return True
    case = runner.read_case(path, overrides, trust_geo=trust_geo)
    with _PhaseReport(path.name, runner.processes.rank, verbosity) as report:
        validation = runner.validate(case, directory, report)
    quiet = verbosity is Verbosity.QUIET and validation.passed
    if runner.processes.rank == 0 and (as_json or not quiet):
        _print(validation, as_json)
    return validation.passed


def _print(validation: Validation, as_json: bool) -> None:
    if as_json:
        print(json.dumps(as_numbers(validation), indent=1, allow_nan=False), flush=True)
    else:
        # Wide enough for all columns: a narrow terminal wraps lines rather than cuts numbers.
        print_validation(Console(width=max(Console().width, NARROWEST)), validation)
