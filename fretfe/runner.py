# SPDX-License-Identifier: LGPL-3.0-or-later
"""The steps that the runs of every backend have in common: processes, case, folder, report."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from fretfe.backends import Backend, EdgeHistories, ParallelBackend, Processes
from fretfe.case import Case, as_written, case_text, load_case, parse_assignments
from fretfe.environment import rank_from_environment
from fretfe.errors import ModelError, OutputError
from fretfe.report.page import REPORT, write_report
from fretfe.report.pictures import make_pictures, remove_pictures
from fretfe.results.writer import prepare_directory, remove_fields, write_results

T = TypeVar("T")
CASE_COPY = "case.toml"


class OneProcess:
    """A backend that runs on one process; others that a launcher started have nothing to do."""

    @property
    def rank(self) -> int:
        """Number of this process, as the launcher announces it."""
        return rank_from_environment()

    def on_root(self, work: Callable[[], T]) -> T | None:
        """Do `work`."""
        return work()


def processes_of(backend: Backend | None) -> Processes:
    """The processes that a backend runs on."""
    return backend.processes if isinstance(backend, ParallelBackend) else OneProcess()


def require_supported(backend: Backend, name: str, case: Case) -> None:
    """Check that a backend can solve a case.

    Raises:
        ModelError: with all reasons why not.
    """
    reasons = backend.supports(case)
    if reasons:
        raise ModelError(
            f"{case.source}: the backend {name!r} cannot solve this case:\n"
            + "\n".join(f"  {reason}" for reason in reasons)
        )


def read_case(path: Path, overrides: Sequence[str], *, trust_geo: bool = False) -> Case:
    """Read a case file, with values like ``loads.shear.amplitude=120`` in place of its own."""
    return load_case(path, parse_assignments(overrides), trust_geo=trust_geo)


def prepare_folder(directory: Path, case: Case) -> None:
    """Make the folder for results, without pictures and fields of an earlier run.

    Raises:
        OutputError: as for `write_case`.
    """
    write_case(directory, case)
    # They would not belong to these results.
    remove_pictures(directory)
    remove_fields(directory)


def write_case(directory: Path, case: Case) -> None:
    """Write the case as it is run into a folder, so that it can be run again; make the folder.

    Raises:
        OutputError: if that is not possible, or another case would be written over the case file.
    """
    prepare_directory(directory)
    target = directory / CASE_COPY
    if target.resolve() != case.source.resolve():
        target.write_text(case_text(case), encoding="utf-8")
    elif not as_written(case):
        raise OutputError(
            f"{directory}: expected another folder than that of the case file, found {target}, "
            "which the case with other values would replace"
        )


@dataclass(frozen=True)
class Drawn:
    """How drawing went.

    Attributes:
        seconds: wall time of each phase.
        problems: what is missing and why, in words.
    """

    seconds: dict[str, float]
    problems: tuple[str, ...]


def write_numbers(case: Case, backend: str, result: EdgeHistories, directory: Path) -> None:
    """Write results.json and results.h5; on rank 0."""
    # A report of an earlier run would not belong to these results.
    (directory / REPORT).unlink(missing_ok=True)
    write_results(directory, case, backend, result)


def draw_report(directory: Path) -> Drawn:
    """Draw the pictures of results and write their report; on rank 0.

    What cannot be made takes nothing away from the results.
    """
    seconds, problems = {}, []
    for phase, make in {"pictures": make_pictures, "report": write_report}.items():
        begin = time.perf_counter()
        try:
            make(directory)
        except Exception as error:
            problems.append(f"no {phase}: {type(error).__name__}: {error}")
        seconds[phase] = time.perf_counter() - begin
    return Drawn(seconds, tuple(problems))
