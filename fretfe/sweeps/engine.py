# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that differ in a few values, solved one after the other, sharing what the backend can."""

from __future__ import annotations

import itertools
import math
import re
import time
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fretfe._typing import Array
from fretfe.backends import Backend, Observer, RunOptions
from fretfe.backends.protocol import Session
from fretfe.bodies.input_files import input_digests
from fretfe.bodies.loads.files import checked_history
from fretfe.case import Case, Units, changed, parse_assignments
from fretfe.case.base import written_number
from fretfe.case.overrides import parse_value, split_assignment, with_overrides
from fretfe.case.toml_file import plain_value, read_tables
from fretfe.caution import Caution
from fretfe.errors import CaseError, FretfeError, StoppedError
from fretfe.faults import Fault, faults_so_far, guarded
from fretfe.results.model import Result
from fretfe.sweeps.copies import in_copies

MOST_VARIANTS = 10_000
# Values of a range are typed numbers: without the last digits of their round-off.
DIGITS = 12
OPTION = "--vary"


@dataclass(frozen=True)
class Variant:
    """One case of a sweep.

    Attributes:
        values: that distinguish it, by key.
        case: the case.
        inputs: digests of the files that it reads, by their names, when the sweep began.
    """

    values: Mapping[str, Any]
    case: Case
    inputs: Mapping[str, str]


def parse_ranges(texts: Iterable[str]) -> dict[str, tuple[Any, ...]]:
    """Keys and values of texts like ``contacts.main.friction=0.1:0.6:11``.

    Args:
        texts: ``KEY=START:STOP:COUNT``, evenly spaced with both ends, or ``KEY=A,B,C``.

    Raises:
        CaseError: a text is not of this form, or a key is there twice.
    """
    ranges: dict[str, tuple[Any, ...]] = {}
    for text in texts:
        key, values = split_assignment(text, OPTION)
        if key in ranges:
            raise CaseError(f"{OPTION}: expected each key once, found {key!r} twice")
        ranges[key] = _values(key, values)
    return ranges


def require_apart(path: Path, fixed: Sequence[str], varied: Mapping[str, Any]) -> None:
    """Check that what varies is not set as well.

    Args:
        path: of the case file.
        fixed: assignments, like ``loads.shear.amplitude=120``.
        varied: a value for each key that varies.

    Raises:
        CaseError: if a key, or another one for the same value, is among both.
    """
    assigned = parse_assignments(fixed)
    if both := sorted(assigned.keys() & varied.keys()):
        raise CaseError(
            f"{OPTION}: expected keys that --set does not set, found {both[0]!r} in both"
        )
    if assigned:
        with_overrides(read_tables(path, "a case file (TOML)"), {**assigned, **varied}, path)


def _values(key: str, text: str) -> tuple[Any, ...]:
    if ":" in text and not re.search(r"""["'\[{]""", text):
        return _spaced(key, text)
    try:
        found = tuple(tomllib.loads(f"values = [{text}]")["values"])
    except tomllib.TOMLDecodeError:  # bare words
        found = tuple(parse_value(part.strip()) for part in text.split(","))
    if not found or "" in found:
        raise CaseError(f"{OPTION} {key}: expected A,B,C or START:STOP:COUNT, found {text!r}")
    return found


def _spaced(key: str, text: str) -> tuple[Any, ...]:
    parts = text.split(":")
    start, stop, number = (*map(written_number, parts), math.nan, math.nan)[:3]
    count = int(number) if number.is_integer() else 0
    if not (len(parts) == 3 and count >= 2 and math.isfinite(start) and math.isfinite(stop)):
        raise CaseError(
            f"{OPTION} {key}: expected START:STOP:COUNT, two numbers and a count of 2 or more, "
            f"found {text!r}"
        )
    if count > MOST_VARIANTS:
        raise CaseError(_too_many(count))
    values = [float(f"{value:.{DIGITS}g}") for value in np.linspace(start, stop, count)]
    whole_numbers = all(re.fullmatch(r"[+-]?\d+", part) for part in parts)
    if whole_numbers and all(value.is_integer() for value in values):
        return tuple(int(value) for value in values)
    return tuple(values)


class Points(dict[str, tuple[float, ...]]):
    """Values of keys that belong together: a case for each place in them, no combinations."""


def sample(
    bounds: Mapping[str, tuple[float, float]],
    count: int,
    method: Literal["latin", "sobol"] = "latin",
    seed: int = 0,
) -> Points:
    """Points that fill the space between bounds evenly, for `sweep`.

    Args:
        bounds: smallest and largest value by key.
        count: of points; of Sobol's sequence a power of 2 is best.
        method: a Latin hypercube, or Sobol's sequence, both scrambled.
        seed: another one gives other points.

    Raises:
        CaseError: without keys, points, or finite bounds that increase.
    """
    from scipy.stats import qmc

    engines = {"latin": qmc.LatinHypercube, "sobol": qmc.Sobol}
    if method not in engines:
        raise CaseError(f"method: expected {' or '.join(engines)}, found {method!r}")
    if not bounds or count < 1:
        raise CaseError(f"expected keys and points, found {len(bounds)} and {count}")
    for key, pair in bounds.items():
        if len(pair) != 2 or not -math.inf < pair[0] < pair[1] < math.inf:
            raise CaseError(f"{key}: expected finite bounds that increase, found {pair}")
    engine = engines[method](len(bounds), seed=seed)
    low, high = np.array(list(bounds.values()), dtype=float).T
    places = low + (high - low) * engine.random(count)
    return Points(zip(bounds, map(tuple, places.T.tolist()), strict=True))


def make_variants(case: Case, ranges: Mapping[str, Sequence[Any] | Array]) -> tuple[Variant, ...]:
    """All combinations, the last key varying fastest; of `Points` these.

    Args:
        case: the case with all that does not vary.
        ranges: values by key.

    Raises:
        CaseError: nothing varies, points differ in number, there are too many combinations, or one
            of them is not a valid case with a valid load history.
    """
    values = {key: tuple(map(plain_value, sequence)) for key, sequence in ranges.items()}
    if not values or not all(values.values()):
        raise CaseError(f"{case.source}: a sweep needs a key that varies, and a value for each key")
    lengths = [len(each) for each in values.values()]
    points = isinstance(ranges, Points)
    if points and len(set(lengths)) > 1:
        raise CaseError(f"{case.source}: expected as many values of each key, found {lengths}")
    count = lengths[0] if points else math.prod(lengths)
    if count > MOST_VARIANTS:
        raise CaseError(_too_many(count))
    variants = []
    columns = values.values()
    for combination in zip(*columns, strict=True) if points else itertools.product(*columns):
        chosen = dict(zip(values, combination, strict=True))
        own = changed(case, chosen)
        checked_history(own)
        variants.append(Variant(chosen, own, input_digests(own)))
    return tuple(variants)


def _too_many(count: int) -> str:
    return f"{OPTION}: expected at most {MOST_VARIANTS} variants, found {count}"


@dataclass(frozen=True)
class Solved:
    """One case of a sweep.

    Attributes:
        values: that distinguish it, by key.
        edges: a record for each contact edge, or contact of solids (see `Result.records`); none if
            it failed.
        failure: why it could not be solved; empty if it was.
        warnings: what a reader must know of it.
        notes: what the backend assumed.
        seconds: wall time.
        faults: errors of fretfe itself that left something unknown, and are in no other case.
        inputs: digests of the files that it was computed from, by their names.
    """

    values: Mapping[str, Any]
    edges: tuple[Mapping[str, Any], ...]
    failure: str
    warnings: tuple[Caution, ...]
    notes: tuple[str, ...]
    seconds: float
    faults: tuple[Fault, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)

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
        late_faults: errors of fretfe itself in what is made of all cases.
    """

    keys: tuple[str, ...]
    units: Units
    variants: tuple[Solved, ...]
    stopped: StoppedError | None = None
    late_faults: tuple[Fault, ...] = ()

    @property
    def failures(self) -> tuple[Solved, ...]:
        """Cases that could not be solved."""
        return tuple(each for each in self.variants if each.failure)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Errors of fretfe itself that left something unknown, each once."""
        own = (fault for each in self.variants for fault in each.faults)
        return tuple(dict.fromkeys((*own, *self.late_faults)))

    @property
    def notes(self) -> tuple[str, ...]:
        """All that the backend assumed, each once."""
        return tuple(dict.fromkeys(note for each in self.variants for note in each.notes))

    def records(self) -> list[dict[str, Any]]:
        """A flat record for each case and edge; one without numbers for a case that failed."""
        return [record for each in self.variants for record in each.records()]


def run_sweep(
    variants: Sequence[Variant],
    backend: Backend,
    options: RunOptions,
    known: Mapping[int, Solved] | None = None,
    note: Callable[[int, Solved], None] = lambda *_: None,
) -> Sweep:
    """Solve all cases. Collective if the backend is.

    Cases that share the most are solved in a row, or beside one another on idle cores. One that
    cannot be solved does not keep the others from it; a signal to stop does.

    Args:
        variants: at least one.
        backend: solves them.
        options: observer of the steps of each case but those that are solved beside others; each
            case is announced when it is solved. `states` is a folder for folders of all cases.
        known: cases that need not be solved, by number.
        note: called with the number of each case that is solved, on all ranks.
    """
    solved = dict(known or {})
    stopped: StoppedError | None = None
    with closing(backend.session()) as session:

        def solve(number: int, observer: Observer) -> Solved:
            folder = options.states and options.states / f"variant-{number + 1}"
            own = replace(options, states=folder, observer=observer)
            return _solve(variants[number], backend, session, own)

        groups = _in_groups([session.group(variant.case) for variant in variants])
        left = ([number for number in group if number not in solved] for group in groups)
        found = chain.from_iterable(_solve_group(each, session, solve, options) for each in left)
        try:
            for number, outcome in found:
                solved[number] = outcome
                note(number, outcome)
                options.announce(_told(len(solved), variants, outcome))
        except StoppedError as error:
            stopped = error
            for number, variant in enumerate(variants):
                if number not in solved:
                    solved[number] = Solved(variant.values, (), str(error), (), (), 0.0)
                    options.announce(_told(len(solved), variants, solved[number]))
    first = variants[0]
    in_order = tuple(solved[number] for number in range(len(variants)))
    return Sweep(tuple(first.values), first.case.units, in_order, stopped)


def _in_groups(groups: Sequence[str]) -> list[list[int]]:
    """Numbers of all entries by equal ones, in the order of their first ones."""
    numbers: dict[str, list[int]] = {}
    for number, group in enumerate(groups):
        numbers.setdefault(group, []).append(number)
    return list(numbers.values())


def _solve_group(
    numbers: Sequence[int],
    session: Session,
    solve: Callable[[int, Observer], Solved],
    options: RunOptions,
) -> Iterator[tuple[int, Solved]]:
    """Solve cases that share the most: the first one here, the others on all idle cores."""
    left = list(numbers)
    while left:
        number = left.pop(0)
        yield number, solve(number, options.observer)
        copies = session.copies() if len(left) > 1 else 1
        if copies > 1:
            options.doing(f"{len(left)} cases, {min(copies, len(left))} at a time")
            # Neighbours in one copy: they may begin alike.
            shares = [each.tolist() for each in np.array_split(left, min(copies, len(left)))]
            for number, outcome in in_copies(shares, solve, options.observer.stop):
                left.remove(number)
                yield number, outcome


def _solve(variant: Variant, backend: Backend, session: Session, options: RunOptions) -> Solved:
    start, before = time.perf_counter(), len(faults_so_far())
    edges: tuple[Mapping[str, Any], ...] = ()
    warnings: tuple[Caution, ...] = ()
    notes: tuple[str, ...] = ()
    try:
        failure = "; ".join(backend.supports(variant.case)) or _changed_files(variant, backend)
        if not failure:
            result = session.solve(variant.case, options)
            if isinstance(result.failure, StoppedError):
                raise result.failure
            failure, notes = str(result.failure or ""), result.notes
            if not failure:
                edges, failure = _records(result)
                warnings = result.warnings
    except StoppedError:
        raise
    except FretfeError as error:
        failure = str(error)
    seconds, faults = time.perf_counter() - start, faults_so_far()[before:]
    return Solved(variant.values, edges, failure, warnings, notes, seconds, faults, variant.inputs)


def _records(result: Result) -> tuple[tuple[Mapping[str, Any], ...], str]:
    """The records of a case, or the reason why there are none."""

    def made() -> tuple[tuple[Mapping[str, Any], ...], str]:
        return tuple(result.records()), ""

    return guarded("row of a sweep", made, lambda fault: ((), fault.text))


def _changed_files(variant: Variant, backend: Backend) -> str:
    """Say that files are no longer those with which the sweep began; empty if they are."""
    now = backend.processes.on_root(lambda: input_digests(variant.case))
    then = variant.inputs
    names = [path for path in {**then, **now} if then.get(path) != now.get(path)]
    return f"{', '.join(names)}: changed since the sweep began" if names else ""


def _told(number: int, variants: Sequence[Variant], solved: Solved) -> str:
    values = ", ".join(f"{key} = {value}" for key, value in solved.values.items())
    outcome = f"failed: {solved.failure}" if solved.failure else f"{solved.seconds:.1f} s"
    return f"{number}/{len(variants)}: {values}: {outcome}"
