# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Python interface: ``fretfe.load_case``, ``fretfe.run``, ``fretfe.sweep``.

Under MPI every process calls these functions, with the same arguments. All get the same numbers and
histories; tractions, meshes and files are those of process 0.
"""

from __future__ import annotations

import html
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from fretfe._typing import Array
from fretfe.backends import EdgeHistories, Processes, RunOptions, find_backend
from fretfe.backends.protocol import Announce, Progress, mute, silent
from fretfe.case import Case, load_case
from fretfe.cli.run import (
    FIELDS,
    OneProcess,
    draw_report,
    prepare,
    processes_of,
    require_supported,
    write_case,
    write_numbers,
)
from fretfe.cli.sweep import write_files
from fretfe.errors import CaseError, OutputError
from fretfe.report.figures import draw_tractions
from fretfe.report.histories import draw_factors, draw_loads
from fretfe.results.records import edge_records
from fretfe.sweeps import Sweep, make_variants, run_sweep

__all__ = ["Result", "load_case", "run", "sweep"]


@dataclass(frozen=True)
class Result:
    """A solved case.

    Attributes:
        case: as it was run.
        backend: name of what solved it.
        histories: everything that it returned; see docs/backends.md.
    """

    case: Case
    backend: str
    histories: EdgeHistories

    def edges(self) -> list[dict[str, Any]]:
        """One flat record of numbers and texts for each contact edge."""
        return edge_records(self.histories)

    def history(self, contact: str, edge: str) -> dict[str, Array]:
        """Histories of one edge, T numbers each.

        Args:
            contact: name of the contact.
            edge: "left" or "right".

        Returns:
            ``time``, ``k_n``, ``k_t``, ``k_i``, ``position`` and each load as ``loads.NAME``.

        Raises:
            CaseError: if there is no such edge.
        """
        edges = {
            f"{each.name} {one.front}": one
            for each in self.histories.contacts
            for one in each.stations
        }
        wanted = f"{contact} {edge}"
        if wanted not in edges:
            known = ", ".join(edges)
            raise CaseError(
                f"{self.case.source}: expected one of the edges {known}, found {wanted}"
            )
        one, loads = edges[wanted], self.histories.history
        return {
            "time": loads.times,
            **{f"loads.{name}": loads.values[:, n] for n, name in enumerate(loads.channels)},
            "k_n": one.k_n,
            "k_t": one.k_t,
            "k_i": one.k_i,
            "position": one.position,
        }

    def plot_tractions(self) -> Figure:
        """Pressure and shear along every contact at the two load extremes.

        Raises:
            OutputError: if the backend has no tractions, or this is not process 0.
        """
        solution = self.histories.solution
        if solution is None:
            raise OutputError(
                f"expected tractions, found none: {self.backend!r} has none, or this process is "
                "not the first one"
            )
        return draw_tractions(self.case, solution, self.histories.contacts)

    def plot_factors(self) -> Figure:
        """K_N and K_T of every edge over time."""
        return draw_factors(self.case, self.histories.history, self.histories.contacts)

    def plot_loads(self) -> Figure:
        """All loads over time."""
        return draw_loads(self.case, self.histories.history)

    def _repr_html_(self) -> str:
        """The edges as a table, for notebooks."""
        records = self.edges()
        head = "".join(f"<th>{html.escape(name)}</th>" for name in records[0])
        rows = "".join(
            "<tr>" + "".join(f"<td>{_cell(value)}</td>" for value in record.values()) + "</tr>"
            for record in records
        )
        title = html.escape(f"{self.case.title or self.case.source.name} ({self.backend})")
        return f"<table><caption>{title}</caption><tr>{head}</tr>{rows}</table>"


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.5g}" if np.isfinite(value) else "–"
    return html.escape(str(value))


def run(
    case: Case,
    backend: str = "fem",
    output: Path | str | None = None,
    progress: Progress = silent,
) -> Result:
    """Solve a case.

    Args:
        case: from `load_case`.
        backend: name of what solves it.
        output: folder for what `fretfe run` writes; None writes nothing.
        progress: called with each finished step: its number, their count, and a text.

    Raises:
        FretfeError: if the case cannot be solved; what was solved is written before. Its message
            is that of the command line.
    """
    solver = find_backend(backend)
    processes = processes_of(solver)
    processes.on_root(lambda: require_supported(solver, backend, case))
    options = RunOptions(progress=progress)
    if output is not None:
        directory = Path(output)
        _write(processes, lambda: prepare(directory, case))
        fields = None if case.output.fields == "none" else directory / FIELDS
        options = RunOptions(progress=progress, fields=fields)
    result = solver.solve(case, options)
    if output is not None:
        _write(processes, lambda: write_numbers(case, backend, result, directory))
        _write(processes, lambda: _draw(directory))
    if result.failure is not None:
        raise result.failure
    return Result(case, backend, result)


def _draw(directory: Path) -> None:
    for problem in draw_report(directory).problems:
        warnings.warn(problem, stacklevel=4)


def sweep(
    case: Case,
    vary: Mapping[str, Sequence[Any]],
    backend: str = "fem",
    output: Path | str | None = None,
    announce: Announce = mute,
) -> Sweep:
    """Solve all combinations of values of some keys; what they share is computed once.

    Args:
        case: with all that does not vary.
        vary: values by key, such as ``{"contacts.main.friction": [0.4, 0.6]}``.
        backend: name of what solves them.
        output: folder for what `fretfe sweep` writes; None writes nothing.
        announce: called with a text for each case that is done.

    Returns:
        All cases, the last key varying fastest; one that could not be solved says why.

    Raises:
        FretfeError: before any work, if a combination is not a valid case.
    """
    solver = find_backend(backend)
    processes = processes_of(solver)
    variants = processes.on_root(lambda: make_variants(case, vary))
    assert variants is not None
    if output is not None:
        _write(processes, lambda: write_case(Path(output), case))
    told = announce if processes.rank == 0 else mute
    result = run_sweep(variants, solver, RunOptions(announce=told))
    if output is not None:
        _write(processes, lambda: write_files(result, Path(output)))
    return result


def _write(processes: Processes, work: Callable[[], object]) -> None:
    """Do `work` on the first process; a backend that runs on one runs on each of them here."""
    if isinstance(processes, OneProcess) and processes.rank > 0:
        return
    processes.on_root(work)
