# SPDX-License-Identifier: LGPL-3.0-or-later
"""What `fretfe validate` does; rank 0 prints."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from fretfe.backends import RunOptions, find_backend
from fretfe.cli.progress import StepReport
from fretfe.cli.verbosity import Verbosity
from fretfe.quality.validate import Validation, validate
from fretfe.quality.validate.report import as_numbers, print_validation
from fretfe.results.writer import prepare_directory, write_results
from fretfe.runner import OneProcess, processes_of, read_case, require_supported

ROWS = "validation.json"
NARROWEST = 100


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
    """Validate a case, print the rows, and say whether all is well. Collective like the backend.

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
    backend = find_backend(name)
    processes = processes_of(backend)
    if isinstance(processes, OneProcess) and processes.rank > 0:
        return True
    case = processes.on_root(lambda: read_case(path, overrides, trust_geo=trust_geo))
    assert case is not None
    processes.on_root(lambda: require_supported(backend, name, case))
    if directory is not None:
        processes.on_root(lambda: prepare_directory(directory))
    quiet = processes.rank > 0 or verbosity is Verbosity.QUIET
    shown = Console(stderr=True, quiet=quiet)
    with StepReport(processes.rank, verbosity, steps=False) as report:
        validation = validate(
            case,
            backend,
            lambda text: shown.print(f"{path.name}: {text}", highlight=False),
            RunOptions(progress=report.step),
        )
    if processes.rank == 0:
        if directory is not None:
            write_results(directory, case, name, validation.result)
            text = json.dumps(as_numbers(validation), indent=1, allow_nan=False)
            (directory / ROWS).write_text(text + "\n", encoding="utf-8")
        if as_json or not (verbosity is Verbosity.QUIET and validation.passed):
            _print(validation, as_json)
    return validation.passed


def _print(validation: Validation, as_json: bool) -> None:
    if as_json:
        print(json.dumps(as_numbers(validation), indent=1, allow_nan=False), flush=True)
    else:
        # Wide enough for all columns: a narrow terminal wraps lines rather than cuts numbers.
        print_validation(Console(width=max(Console().width, NARROWEST)), validation)
