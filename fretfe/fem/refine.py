# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a case on meshes that refine themselves until edge factors change little. Collective."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from fretfe.backends.meshes import Passes
from fretfe.backends.passes import SweptPasses, passes_of
from fretfe.backends.protocol import RunOptions
from fretfe.case import Case
from fretfe.errors import FretfeError, StoppedError
from fretfe.evaluate.refinement import Refinement
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import agreed_stop, on_root
from fretfe.fem.run import solve
from fretfe.results.model import Result


def refine(comm: MPI.Comm, case: Case, options: RunOptions) -> Result:
    """Solve a case on finer and finer meshes, the whole history on each. Collective.

    Args:
        comm: communicator.
        case: validated case that asks for an accuracy.
        options: as for `solve`; numbers and then fields are written for each pass, and each mesh
            is announced.

    Returns:
        The last pass that was solved to its end, with all meshes in its `refinement`.

    Raises:
        FretfeError: for whatever keeps the first pass from being started. A later pass that fails
            ends the refinement, and the one before counts; so does a signal, as its `failure`.
    """
    passes = passes_of(case, options)
    last = options.before if options.resume else None
    known = on_root(comm, partial(passes.recall, last, options.states))
    last = replace(last, failure=None) if last is not None and known else None
    if last is None and isinstance(passes, SweptPasses):
        solve_section(comm, passes, options)
    return _refined(comm, passes, last, options)


def solve_section(comm: MPI.Comm, passes: SweptPasses, options: RunOptions) -> None:
    """Solve the section of swept bodies, whose edges make their first mesh fine. Collective.

    Raises:
        StoppedError: for a signal. Whatever else prevents it, the mesh is that without it.
    """
    quiet = RunOptions(history=options.history, observer=options.observer)
    try:
        section = passes.section()
        found = _refined(comm, section, None, quiet)
        if found.failure is not None:
            raise found.failure
        on_root(comm, partial(passes.follow, section, found))
    except FretfeError as error:
        if isinstance(error, StoppedError):
            raise
        on_root(comm, partial(options.announce, f"the section was not solved: {error}"))


def _refined(comm: MPI.Comm, passes: Passes, last: Result | None, options: RunOptions) -> Result:
    """The last of the meshes that a case is solved on, after those of an earlier run."""
    while True:
        kept = _Kept(comm, passes, options, first=last is None)
        try:
            if last is not None and (number := agreed_stop(comm, options.observer)) is not None:
                raise StoppedError(number, "before the next mesh")
            result = solve(comm, passes.case, passes.options(options, kept), passes.load)
        except FretfeError as error:
            if last is None or last.refinement is None:
                raise
            return _ended(last, last.refinement, error)
        last = replace(result, refinement=kept.refinement)
        if kept.refinement.reason:
            return last
        on_root(comm, partial(passes.note, options.states))


class _Kept:
    """Keeps the numbers of a pass before its fields are written, if it is solved to its end.

    Args:
        comm: communicator.
        passes: that judge it.
        options: of the refinement.
        first: whether no pass was solved before: then the steps up to a failure count.
    """

    def __init__(self, comm: MPI.Comm, passes: Passes, options: RunOptions, *, first: bool) -> None:
        self._comm, self._passes, self._options, self._first = comm, passes, options, first
        self.refinement: Refinement

    def __call__(self, result: Result) -> None:
        """Judge the result of the pass and keep it. Collective.

        Raises:
            FretfeError: the failure of the pass, if the one before is to count.
        """
        if result.failure is not None and not self._first:
            raise result.failure
        self.refinement = on_root(self._comm, partial(self._passes.judge, result))
        # Those of the mesh before do not belong to these numbers.
        for path in (self._options.fields, self._options.stress):
            on_root(self._comm, partial(_drop, path))
        self._options.keep(replace(result, refinement=self.refinement))


def _ended(last: Result, refinement: Refinement, error: FretfeError) -> Result:
    """The last pass as the result, after an error in the next one."""
    failure, done = None, len(refinement.passes)
    if isinstance(error, StoppedError):
        where = f"on the way to mesh {done + 1}; the results are those of mesh {done}"
        failure = StoppedError(error.signal, where)
    refinement = replace(refinement, reason=str(failure or error))
    return replace(last, refinement=refinement, failure=failure)


def _drop(path: Path | None) -> None:
    if path is not None:
        path.unlink(missing_ok=True)
