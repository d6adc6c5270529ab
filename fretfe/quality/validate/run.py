# SPDX-License-Identifier: LGPL-3.0-or-later
"""Run a case and its companions, and collect the rows."""

from __future__ import annotations

from dataclasses import dataclass, replace

from fretfe.backends import Backend, RunOptions
from fretfe.backends.protocol import DEFAULTS, Session, session_of
from fretfe.case import Case
from fretfe.errors import FretfeError, StoppedError
from fretfe.quality.validate.compare import companion_rows
from fretfe.quality.validate.plan import plan
from fretfe.quality.validate.rows import Row, missing
from fretfe.quality.validate.single import limit_rows, own_rows
from fretfe.quality.validate.solids import solid_companion_rows, solid_rows
from fretfe.quality.validate.variants import Variant, make_variants
from fretfe.results.model import Result


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

    What the companions will take is told before they begin; those on the mesh of the case share its
    condensed bodies.

    Raises:
        FretfeError: if the case itself cannot be solved.
    """
    with session_of(backend) as session:
        options.observer.phase("the case itself")
        result = session.solve(case, options)
        if result.failure is not None:
            raise result.failure
        options.keep(result)
        own = solid_rows(result) if result.areas else ()
        rows = [*own_rows(result), *own, *limit_rows(result)]
        variants, reasons = make_variants(case, result)
        rows += [missing("all", "", name, reason) for name, reason in reasons.items()]
        options.observer.phase(plan(variants, result))
        for variant in variants:
            options.observer.phase(variant.name)
            rows += _companion(variant, session, result, companion_options(options, variant))
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
    variant: Variant, session: Session, result: Result, options: RunOptions
) -> list[Row]:
    """Rows of one companion; one that has no solution says so in a row of its own."""
    try:
        other = session.solve(variant.case, options)
    except FretfeError as error:
        return [missing("all", "", variant.name, f"no solution: {error}")]
    if isinstance(other.failure, StoppedError):
        raise other.failure
    if other.failure is not None:
        return [missing("all", "", variant.name, f"no solution: {other.failure}")]
    rows = solid_companion_rows if result.areas else companion_rows
    return list(rows(variant.name, result, other))
