# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run a case and its companions, and collect the rows."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fretfe.backends import Backend, RunOptions
from fretfe.backends.protocol import DEFAULTS
from fretfe.case import Case
from fretfe.errors import FretfeError, StoppedError
from fretfe.quality.validate.compare import companion_rows
from fretfe.quality.validate.rows import Row, missing
from fretfe.quality.validate.single import limit_rows, own_rows
from fretfe.quality.validate.variants import Variant, make_variants
from fretfe.results.model import Result

SOLIDS = "there are no companions of solids yet: meshes, means and starts are not varied"


@dataclass(frozen=True)
class Validation:
    """The rows, and the run that they are about."""

    result: Result
    rows: tuple[Row, ...]

    @property
    def passed(self) -> bool:
        """True if no comparison failed and no number that matters is unknown."""
        return all(row.verdict not in ("FAIL", "unknown") for row in self.rows)


def validate(case: Case, backend: Backend, options: RunOptions = DEFAULTS) -> Validation:
    """Solve a case and its companions, each a phase. Collective if the backend is.

    Raises:
        FretfeError: if the case itself cannot be solved.
    """
    options.observer.phase("the case itself")
    result = backend.solve(case, options)
    if result.failure is not None:
        raise result.failure
    options.keep(result)
    rows = [*own_rows(result), *limit_rows(result)]
    if result.areas:
        return Validation(result, (*rows, missing("all", "", "companions", SOLIDS, "unknown")))
    variants, reasons = make_variants(case, result)
    rows += [missing("all", "", name, reason) for name, reason in reasons.items()]
    for variant in variants:
        options.observer.phase(variant.name)
        rows += _companion(variant, backend, result, companion_options(options, variant))
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


def _companion(
    variant: Variant, backend: Backend, result: Result, options: RunOptions
) -> list[Row]:
    """Rows of one companion; one that has no solution says so in a row of its own."""
    try:
        other = backend.solve(variant.case, options)
    except FretfeError as error:
        return [missing("all", "", variant.name, f"no solution: {error}")]
    if isinstance(other.failure, StoppedError):
        raise other.failure
    if other.failure is not None:
        return [missing("all", "", variant.name, f"no solution: {other.failure}")]
    return list(companion_rows(variant.name, result, other))
