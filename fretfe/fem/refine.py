# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a case on meshes that refine themselves until the edge factors converge. Collective."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.case import Case
from fretfe.edges.refinement import Pass, Refinement, changes_by_kind
from fretfe.edges.sizes import Interval, needed_sizes, resolves, station_values
from fretfe.errors import FretfeError, StoppedError
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import on_root
from fretfe.fem.passes import Passes
from fretfe.fem.refine_solids import SolidPasses, is_solid
from fretfe.fem.run import solve
from fretfe.fem.stopping import agreed_stop
from fretfe.geometry.sizing import Source, apply_fine_sizes
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.results.solution import Solution
from fretfe.surface.load import load_mesh
from fretfe.surface.surface import build_surface

# Passes that may be needed to find the edges and to resolve their slip zones.
UNRESOLVED_PASSES = 3
# Largest growth of the element size per distance from the edges.
LARGEST_GROWTH = 0.3


def growth_for(tolerance: float, degree: int) -> float:
    """Growth of the element size per distance from an edge, for displacements of a degree.

    Elements g s long at a distance s interpolate √s with the relative error g²/32: a third of the
    tolerance. Linear displacements need half of that, found by trial.
    """
    return min(math.sqrt(32 * tolerance / 3), LARGEST_GROWTH) * degree / 2


def starting_mesh(case: Case) -> Mesh:
    """The first mesh of a case that refines itself. Serial.

    Raises:
        FretfeError: as for `load_mesh`.
    """
    return _passes_of(case, DEFAULTS).load()


def _passes_of(case: Case, options: RunOptions) -> Passes:
    kind = SolidPasses if is_solid(case) else _PlanePasses
    return kind(case, options.announce)


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
    passes = _passes_of(case, options)
    last = options.before if options.resume else None
    known = on_root(comm, partial(passes.recall, last, options.states))
    last = replace(last, failure=None) if last is not None and known else None
    while True:
        kept = _Kept(comm, passes, options, first=last is None)
        try:
            if last is not None and (number := agreed_stop(comm, options.observer)) is not None:
                raise StoppedError(number, "before the next mesh")
            result = solve(comm, case, passes.options(options, kept), passes.load)
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


class _PlanePasses(Passes):
    """Meshes that are finer where the one before showed contact edges and slip zones."""

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        super().__init__(case, announce)
        self._growth = growth_for(self._tolerance, case.model.degree)
        self._sources: tuple[Source, ...] = ()
        self._level = 0

    def _noted(self) -> dict[str, Any]:
        sources = [{"points": each.points.tolist(), "size": each.size} for each in self._sources]
        return {"level": self._level, "sources": sources}

    def _follow(self, note: dict[str, Any]) -> None:
        self._level = note["level"]
        self._sources = tuple(
            Source(np.array(each["points"]), each["size"]) for each in note["sources"]
        )

    def _make_mesh(self) -> Mesh:
        contacts = [(each.surface1, each.surface2) for each in self._case.contacts.values()]
        size = partial(apply_fine_sizes, contacts, self._growth, self._sources)
        return load_mesh(self._case, size)

    def _pass(self, result: Result, mesh: Mesh) -> Pass:
        solution, contacts = result.solution, result.contacts
        assert solution is not None
        values = station_values(solution, contacts)
        before = self._done[-1] if self._done else None
        return Pass(
            unknowns=self._unknowns(mesh),
            smallest_element=min(float(np.diff(c.arc).min()) for c in solution.contacts),
            stations=values,
            resolved=all(math.isfinite(each.k_n) for each in values)
            and resolves(solution, needed_sizes(solution, contacts, 0)),
            change=max(changes_by_kind(before.stations if before else (), values)),
        )

    def _make_finer(self, result: Result, mesh: Mesh) -> None:
        solution = result.solution
        assert solution is not None
        # A mesh that still does not show all of a slip zone must not keep the others waiting.
        self._level += self._done[-1].resolved or len(self._done) > UNRESOLVED_PASSES
        intervals = needed_sizes(solution, result.contacts, self._level)
        self._sources = tuple(_sources(self._case, mesh, solution, intervals))


def _sources(
    case: Case, mesh: Mesh, solution: Solution, intervals: Sequence[Interval]
) -> Iterator[Source]:
    """The intervals as places on the surfaces of both bodies."""
    contacts = {contact.name: contact for contact in solution.contacts}
    for each in intervals:
        history = contacts[each.contact]
        contact = case.contacts[history.pair]
        count = math.ceil((each.high - each.low) / each.size) + 1
        arc = np.linspace(each.low, each.high, count)
        points = np.stack([np.interp(arc, history.arc, x) for x in history.points.T], axis=1)
        for body, name in ((history.body1, contact.surface1), (history.body2, contact.surface2)):
            surface = build_surface(mesh.bodies[body], name)
            yield Source(surface.nearest(points)[0], each.size)
