# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run a case and its companions, of a cost that is told before, and collect the rows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import chain
from typing import Any

from rich import box
from rich.markup import escape
from rich.measure import Measurement
from rich.table import Table

from fretfe.backends import Backend, RunOptions
from fretfe.backends.protocol import DEFAULTS, Session
from fretfe.case import Case
from fretfe.console import Console
from fretfe.environment import peak_memory
from fretfe.errors import FretfeError, StoppedError
from fretfe.faults import Fault, guarded
from fretfe.files import json_value
from fretfe.quality.companions import FINE, FINER, MESHES, Variant, companion_rows, make_variants
from fretfe.quality.global_run import carried_rows
from fretfe.quality.rows import EVERYWHERE, Row, hertz_rows, limit_rows, own_rows
from fretfe.report.texts import rounded
from fretfe.results.model import Result
from fretfe.verdict import Verdict

# Phases of a run that companions on the same mesh go through too.
REPEATED = ("steps", "edge integrals", "evaluation")
# Powers of the element size by which the time of a run falls on a coarser mesh.
POWERS = {False: 2, True: 4}
# The same of the memory of solids.
GROWING = 3
# Verdicts with which a validation fails.
FAILURES = (Verdict.DIFFERS, Verdict.UNKNOWN)
# Columns that a word of a name takes on a terminal.
WHOLE_WORDS = 12
# More than any terminal has.
WIDEST = 1000
# Rows that a run has without companions.
OWN_ROWS = {
    "this run": own_rows,
    "Hertz": hertz_rows,
    "limits": limit_rows,
    "the other run": carried_rows,
}


def plan(variants: Sequence[Variant], result: Result) -> str:
    """Number of companions, about the time of each, and the memory."""
    if not variants:
        return "no companions"
    seconds = [_seconds(variant, result) for variant in variants]
    each = ", ".join(
        f"{variant.name} {_time(time)}" for variant, time in zip(variants, seconds, strict=True)
    )
    total = f", {_time(sum(seconds))} together" if len(variants) > 1 else ""
    count = f"{len(variants)} companion{'s' if len(variants) > 1 else ''}"
    taken = peak_memory() / 1e9
    memory = f"{taken:.1f} GB at most, what the case itself took"
    if any(variant.name == FINE for variant in variants):
        memory = f"up to {taken / FINER**GROWING:.1f} GB, the case itself took {taken:.1f} GB"
    return f"{count}: {each}{total}, estimated; {memory}"


def _seconds(variant: Variant, result: Result) -> float:
    took = result.seconds
    if variant.name in MESHES:
        return sum(took.values()) / MESHES[variant.name] ** POWERS[result.solid]
    share = 1.0
    if variant.history is not None:
        share = len(variant.history.times) / max(len(result.loads.times), 1)
    # Integrals do not depend on the number of steps.
    return sum(
        time * (share if phase == "steps" else 1.0)
        for phase, time in took.items()
        if phase in REPEATED
    )


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


@dataclass(frozen=True)
class Validation:
    """The rows, and the run that they are about."""

    result: Result
    rows: tuple[Row, ...]

    @property
    def passed(self) -> bool:
        """True if no comparison failed and no number that matters is unknown."""
        return all(row.verdict not in FAILURES for row in self.rows)


def validate(case: Case, backend: Backend, options: RunOptions = DEFAULTS) -> Validation:
    """Solve a case and its companions, each a phase. Collective if the backend is.

    What the companions will take is told before they begin; those on the mesh of the case share its
    condensed bodies.

    Raises:
        FretfeError: if the case itself cannot be solved.
    """
    with closing(backend.session()) as session:
        options.phase("the case itself")
        result = session.solve(case, options)
        if result.failure is not None:
            raise result.failure
        options.keep(result)
        on_root = backend.processes.on_root
        rows = on_root(lambda: _own_rows(result))
        variants, reasons = on_root(lambda: make_variants(case, result))
        rows += [EVERYWHERE.missing(name, reason) for name, reason in reasons.items()]
        options.phase(plan(variants, result))
        for variant in variants:
            options.phase(variant.name)
            other = _companion(variant, session, companion_options(options, variant))
            rows += on_root(partial(_rows_of, variant.name, result, other))
    return Validation(result, tuple(rows))


def companion_options(options: RunOptions, variant: Variant) -> RunOptions:
    """Options of a companion: nothing of it is kept but its states, in a folder of its own."""
    states = options.states
    return replace(
        options,
        history=variant.history,
        states=states and states / variant.name.replace(" ", "-"),
        before=None,
        keep=DEFAULTS.keep,
    )


def _own_rows(result: Result) -> list[Row]:
    """Rows of the case itself; on the first process."""
    found = (_attempted(name, partial(find, result)) for name, find in OWN_ROWS.items())
    return list(chain.from_iterable(found))


def _companion(variant: Variant, session: Session, options: RunOptions) -> Result | str:
    """The result of a companion, or why there is none."""
    try:
        other = session.solve(variant.case, options)
    except FretfeError as error:
        return str(error)
    if isinstance(other.failure, StoppedError):
        raise other.failure
    return other if other.failure is None else str(other.failure)


def _rows_of(name: str, result: Result, other: Result | str) -> list[Row]:
    """Rows of one companion; one that has no solution says so in a row of its own."""
    if isinstance(other, str):
        return [EVERYWHERE.missing(name, f"no solution: {other}")]
    return _attempted(name, partial(companion_rows, name, result, other))


def _attempted(name: str, find: Callable[[], Iterable[Row]]) -> list[Row]:
    """Some rows, or the one that says why fretfe has not found them."""

    def failed(fault: Fault) -> list[Row]:
        return [EVERYWHERE.missing(name, fault.reason, Verdict.UNKNOWN)]

    return guarded(f"rows of {name}", lambda: list(find()), failed)


def print_validation(console: Console, validation: Validation) -> None:
    """Print a line per row, the reasons they refer to by number, and the summary."""
    reasons = list(dict.fromkeys(row.reason for row in validation.rows))
    table = Table(title="Validation", title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    # Long names take several lines where the terminal is narrow.
    table.add_column("", min_width=WHOLE_WORDS)
    for header in ("value", "reference", "difference", "tolerance", "why"):
        table.add_column(header, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    place = ""
    for row in validation.rows:
        if row.where != place:
            place = row.where
            table.add_row(f"[bold]{escape(place)}[/]")
        numbers = (row.value, row.reference, row.difference, row.tolerance)
        why = str(reasons.index(row.reason) + 1)
        style = "bold red" if row.verdict in FAILURES else ""
        name = escape(row.quantity)
        table.add_row(name, *map(rounded, numbers), why, row.verdict, style=style)
    width = console.width
    # Narrower terminals wrap whole lines: a cut verdict says nothing.
    wide = console.options.update(max_width=WIDEST)
    console.width = max(width, Measurement.get(console, wide, table).minimum)
    console.print(table)
    console.width = width
    for number, reason in enumerate(reasons, start=1):
        console.print(f"{number:3d}. {reason}", highlight=False, markup=False)
    console.print(summary(validation), highlight=False)


def summary(validation: Validation) -> str:
    """Numbers of rows by verdict, and their meaning."""
    counts = Counter(row.verdict for row in validation.rows)
    text = (
        f"{counts[Verdict.AGREES]} agree, {counts[Verdict.DIFFERS]} differ, "
        f"{counts[Verdict.OUTSIDE]} outside the range of a formula, "
        f"{counts[Verdict.DEPENDS]} depend on the start, {counts[Verdict.NO_VERDICT]} not "
        "applicable."
    )
    if unknown := counts[Verdict.UNKNOWN]:
        return f"{text} {unknown} unknown: nothing can be said of this case before they are known."
    if counts[Verdict.DIFFERS]:
        return f"{text} Do not use these numbers before the differences are understood."
    if counts[Verdict.OUTSIDE]:
        return f"{text} Use the computed numbers where a formula is outside its range."
    if not counts[Verdict.AGREES]:
        return f"{text} Nothing was compared."
    return f"{text} The edge description holds for this case."


def as_numbers(validation: Validation) -> dict[str, Any]:
    """The rows in plain types; numbers that do not exist are None."""
    return {
        "schema": {"name": "fretfe-validation", "version": 2},
        "passed": validation.passed,
        "rows": [
            json_value({**asdict(row), "difference": row.difference}) for row in validation.rows
        ],
    }
