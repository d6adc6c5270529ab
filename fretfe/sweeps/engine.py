# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve the cases of a sweep one after the other, sharing what the backend can share."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from fretfe.backends import Backend, RunOptions
from fretfe.backends.protocol import Session, session_of
from fretfe.case import Units
from fretfe.errors import FretfeError, StoppedError
from fretfe.sweeps.variants import Variant


@dataclass(frozen=True)
class Solved:
    """One case of a sweep.

    Attributes:
        values: that distinguish it, by key.
        edges: a record for each contact edge, or contact of solids (see `Result.records`); none if
            it failed.
        failure: why it could not be solved; empty if it was.
        notes: what the backend assumed.
        seconds: wall time.
    """

    values: Mapping[str, Any]
    edges: tuple[Mapping[str, Any], ...]
    failure: str
    notes: tuple[str, ...]
    seconds: float

    def records(self) -> list[dict[str, Any]]:
        """A flat record for each edge; one without numbers if it failed."""
        last = {"seconds": self.seconds, "failure": self.failure}
        return [{**self.values, **edge, **last} for edge in self.edges or ({},)]


@dataclass(frozen=True)
class Sweep:
    """All cases, the last key varying fastest.

    Attributes:
        keys: that vary.
        units: labels, from the case.
        variants: the cases.
        stopped: the signal that ended it before all cases were solved, or None.
    """

    keys: tuple[str, ...]
    units: Units
    variants: tuple[Solved, ...]
    stopped: StoppedError | None = None

    @property
    def failures(self) -> tuple[Solved, ...]:
        """Cases that could not be solved."""
        return tuple(each for each in self.variants if each.failure)

    @property
    def notes(self) -> tuple[str, ...]:
        """All that the backend assumed, each once."""
        return tuple(dict.fromkeys(note for each in self.variants for note in each.notes))

    def records(self) -> list[dict[str, Any]]:
        """A flat record for each case and edge; one without numbers for a case that failed."""
        return [record for each in self.variants for record in each.records()]


def _forget(_: int, __: Solved) -> None:
    """Note nothing."""


def run_sweep(
    variants: Sequence[Variant],
    backend: Backend,
    options: RunOptions,
    known: Mapping[int, Solved] | None = None,
    note: Callable[[int, Solved], None] = _forget,
) -> Sweep:
    """Solve all cases. Collective if the backend is.

    Cases that share the most are solved in a row. One that cannot be solved does not keep the
    others from it; a signal to stop does.

    Args:
        variants: at least one.
        backend: solves them.
        options: observer of the steps of each case; each case is announced when it is solved.
            `states` is a folder for folders of all cases.
        known: cases that need not be solved, by number.
        note: called with the number of each case that is solved, on all ranks.
    """
    solved = dict(known or {})
    stopped: StoppedError | None = None
    with session_of(backend) as session:
        for number in _in_groups([session.group(variant.case) for variant in variants]):
            if number in solved:
                continue
            own = _own(options, number)
            try:
                if stopped is None:
                    solved[number] = _solve(variants[number], backend, session, own)
                    note(number, solved[number])
            except StoppedError as error:
                stopped = error
            if stopped is not None:
                solved[number] = Solved(variants[number].values, (), str(stopped), (), 0.0)
            options.announce(_told(len(solved), len(variants), solved[number]))
    first = variants[0]
    in_order = tuple(solved[number] for number in range(len(variants)))
    return Sweep(tuple(first.values), first.case.units, in_order, stopped)


def _own(options: RunOptions, number: int) -> RunOptions:
    """Options of one case, with a folder of its own."""
    states = options.states / f"variant-{number + 1}" if options.states is not None else None
    return replace(options, states=states)


def _in_groups(groups: Sequence[str]) -> list[int]:
    """Numbers of all entries: equal ones in a row, in the order of their first ones."""
    place = {group: number for number, group in reversed(list(enumerate(groups)))}
    return sorted(range(len(groups)), key=lambda number: place[groups[number]])


def _solve(variant: Variant, backend: Backend, session: Session, options: RunOptions) -> Solved:
    start = time.perf_counter()
    edges: tuple[Mapping[str, Any], ...] = ()
    notes: tuple[str, ...] = ()
    try:
        failure = "; ".join(backend.supports(variant.case))
        if not failure:
            result = session.solve(variant.case, options)
            if isinstance(result.failure, StoppedError):
                raise result.failure
            failure, notes = str(result.failure or ""), result.notes
            edges = () if failure else tuple(result.records())
    except StoppedError:
        raise
    except FretfeError as error:
        failure = str(error)
    return Solved(variant.values, edges, failure, notes, time.perf_counter() - start)


def _told(number: int, count: int, solved: Solved) -> str:
    values = ", ".join(f"{key} = {value}" for key, value in solved.values.items())
    outcome = f"failed: {solved.failure}" if solved.failure else f"{solved.seconds:.1f} s"
    return f"{number}/{count}: {values}: {outcome}"
