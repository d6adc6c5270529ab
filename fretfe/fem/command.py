# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the commands of the command line do; rank 0 prints."""

from __future__ import annotations

import shutil
import time
from pathlib import Path

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from fretfe.case import Case, load_case
from fretfe.environment import blas_libraries, reference_blas_only, versions
from fretfe.evaluate import ContactSummary, evaluate
from fretfe.fem import _compat
from fretfe.fem._compat import MPI
from fretfe.fem.march import StepResult
from fretfe.fem.mesh_groups import mesh_summary
from fretfe.fem.mesh_writer import write_mesh
from fretfe.fem.meshing import Mesh
from fretfe.fem.model import contact_surfaces, couple_contacts
from fretfe.fem.parallel import on_root
from fretfe.fem.plan import plan_model
from fretfe.fem.run import Outcome, load_mesh, solve
from fretfe.loads import History, build_history
from fretfe.report.figures import write_tractions
from fretfe.report.tables import contact_table, edge_table, timing_table
from fretfe.results import Run, prepare_directory, write_results

COMM = MPI.COMM_WORLD
FIELDS, FIGURE, CASE_COPY = "fields", "tractions.png", "case.toml"


def run_case(path: Path, directory: Path, *, timings: bool) -> None:
    """Solve a case, write everything, print the edges. Collective."""
    start = time.perf_counter()
    case = _load(path)
    history = on_root(COMM, lambda: build_history(case))
    assert history is not None
    fields = None if case.output.fields == "none" else directory / FIELDS
    on_root(COMM, lambda: _prepare(directory, fields, path))
    with _StepReport() as report:
        outcome = solve(COMM, case, history, fields, report.step)
    on_root(COMM, lambda: _finish(case, outcome, directory, start, timings))
    if outcome.failure is not None:
        raise outcome.failure


def _load(path: Path) -> Case:
    case = on_root(COMM, lambda: load_case(path))
    assert case is not None
    return case


def _prepare(directory: Path, fields: Path | None, case_file: Path) -> None:
    prepare_directory(directory)
    if fields is not None:
        prepare_directory(fields)
    target = directory / CASE_COPY
    if target.resolve() != case_file.resolve():
        shutil.copyfile(case_file, target)


def _finish(case: Case, outcome: Outcome, directory: Path, start: float, timings: bool) -> None:
    """Evaluate, write and print; on rank 0."""
    solution = outcome.solution
    assert solution is not None and outcome.mesh is not None
    begin = time.perf_counter()
    contacts = evaluate(solution)
    seconds = {**outcome.seconds, "evaluation": time.perf_counter() - begin}
    run = Run(
        case=case,
        versions={**versions(), **_compat.versions()},
        seconds=seconds,
        ranks=COMM.size,
        failure=str(outcome.failure or ""),
        bodies=outcome.mesh.bodies,
    )
    begin = time.perf_counter()
    write_results(directory, run, solution, contacts)
    write_tractions(directory / FIGURE, case, solution, contacts)
    seconds["writing"] = time.perf_counter() - begin
    console = Console()
    console.print(contact_table(case, solution, contacts))
    console.print(edge_table(case, solution, contacts))
    _print_warnings(console, contacts)
    if timings:
        console.print(timing_table(seconds))
    worst = solution.certificates["worst"].max()
    console.print(
        f"{len(solution.times) - 1} steps, {solution.iterations[1:].mean():.1f} iterations a step, "
        f"largest violation of a contact condition {worst:.1e}, "
        f"{time.perf_counter() - start:.1f} s",
        highlight=False,
    )
    console.print(f"Results in {directory}", highlight=False, soft_wrap=True)


def _print_warnings(console: Console, contacts: tuple[ContactSummary, ...]) -> None:
    for contact in contacts:
        for warning in contact.warnings:
            console.print(f"Warning: {contact.name}: {warning}", highlight=False, markup=False)


class _StepReport:
    """Progress on rank 0: a bar on a terminal, a line per step otherwise."""

    def __init__(self) -> None:
        console = Console(stderr=True)
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        if console.is_terminal and COMM.rank == 0:
            columns = (
                TextColumn("steps"),
                BarColumn(),
                MofNCompleteColumn(),
                TimeRemainingColumn(),
            )
            self._bar = Progress(*columns, console=console, transient=True)

    def __enter__(self) -> _StepReport:
        if self._bar is not None:
            self._bar.start()
            self._task = self._bar.add_task("steps", total=None)
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def step(self, number: int, count: int, result: StepResult) -> None:
        """Report an accepted step."""
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=number, total=count)
            return
        cut = f", cut into {result.parts} parts" if result.parts > 1 else ""
        print(
            f"step {number}/{count}: {result.iterations} iterations{cut}, "
            f"violation {result.certificate.worst:.0e}",
            flush=True,
        )


def check_case(path: Path) -> None:
    """Print what a case would solve."""
    case = _load(path)
    history = on_root(COMM, lambda: build_history(case))
    assert history is not None
    on_root(COMM, lambda: _print_check(case, history, load_mesh(case)))


def _print_check(case: Case, history: History, mesh: Mesh) -> None:
    plan = plan_model(case, mesh)
    pairs = couple_contacts(case, contact_surfaces(plan, mesh))
    console = Console()
    console.print(_mesh_table(case, mesh))
    for body in plan.bodies:
        console.print(f"{body.name}: E = {body.material.young:g}, ν = {body.material.poisson:g}")
        for coordinate in body.coordinates:
            console.print(f"  {coordinate.label}: {coordinate.control}", highlight=False)
    for pair in pairs:
        gap = pair.coupling.gap / pair.coupling.weights
        console.print(
            f"contact {pair.name}: {pair.body1} (1) on {pair.body2} (2), "
            f"{len(gap)} multiplier nodes, smallest initial gap {gap.min():.3g} "
            f"{case.units.length}",
            highlight=False,
        )
    cycle = "no cycle to evaluate"
    if history.cycle is not None:
        first, last = (history.times[state] for state in history.cycle)
        cycle = f"evaluated cycle t = {first:g} to {last:g} {case.units.time}"
    console.print(f"{len(history.times) - 1} steps to t = {history.times[-1]:g}, {cycle}")
    console.print("The case is valid.")


def _mesh_table(case: Case, mesh: Mesh) -> Table:
    table = Table(title="Bodies", title_justify="left")
    for header in ("body", "elements", "nodes", "order", "smallest angle [°]"):
        table.add_column(header, justify="left" if header == "body" else "right")
    for body in mesh_summary(mesh):
        table.add_row(
            body.name,
            f"{body.elements} {body.cell}",
            str(body.nodes),
            str(body.order),
            f"{body.smallest_angle:.1f}",
        )
    return table


def write_mesh_file(path: Path, target: Path) -> None:
    """Write the mesh of a case."""
    case = _load(path)
    on_root(COMM, lambda: _write_mesh(case, target))


def _write_mesh(case: Case, target: Path) -> None:
    prepare_directory(target.parent)
    mesh = load_mesh(case)
    write_mesh(mesh, target)
    console = Console()
    console.print(_mesh_table(case, mesh))
    console.print(f"Mesh in {target}", highlight=False, soft_wrap=True)


def show_info() -> None:
    """Print versions and libraries."""
    if COMM.rank != 0:
        return
    console = Console()
    for name, version in {**versions(), **_compat.versions()}.items():
        console.print(f"{name:12s} {version}", highlight=False)
    console.print(f"{'MPI ranks':12s} {COMM.size}", highlight=False)
    libraries = blas_libraries()
    for library in libraries:
        console.print(f"{'BLAS':12s} {library}", highlight=False, soft_wrap=True)
    if reference_blas_only(libraries):
        console.print(
            "Warning: only the reference BLAS is in use, which makes factorisations about four "
            "times slower. Install OpenBLAS (Debian: libopenblas0-pthread)."
        )
