# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solve a case on meshes that refine themselves until the edge factors converge. Collective."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from fretfe.backends.protocol import DEFAULTS, RunOptions
from fretfe.case import Case
from fretfe.edges.front import ContactSummary
from fretfe.edges.refinement import Pass, Refinement, changes_by_kind
from fretfe.edges.sizes import Interval, needed_sizes, resolves, station_values
from fretfe.errors import FretfeError, MeshError
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import on_root
from fretfe.fem.run import solve
from fretfe.geometry.sizing import Source, apply_fine_sizes
from fretfe.mesh.groups import count_unknowns
from fretfe.mesh.mesh import Mesh
from fretfe.results.model import Result
from fretfe.results.solution import Solution
from fretfe.surface.load import load_mesh
from fretfe.surface.surface import build_surface

# More passes than this do not help: the element size at the edges has been halved eight times.
MOST_PASSES = 12
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
    return _Passes(case, DEFAULTS.announce).load()


def refine(comm: MPI.Comm, case: Case, options: RunOptions) -> Result:
    """Solve a case on finer and finer meshes, the whole history on each. Collective.

    Args:
        comm: communicator.
        case: validated case that asks for an accuracy.
        options: as for `solve`; fields are those of the pass that counts, and each mesh is
            announced.

    Returns:
        The last pass that was solved to its end, with all meshes in its `refinement`.

    Raises:
        FretfeError: for whatever keeps the first pass from being started. A later pass that fails
            ends the refinement, and the one before counts.
    """
    passes, fields = _Passes(case, options.announce), options.fields
    last: Result | None = None
    # Fields of a pass take the place of those of the one before only when it counts.
    staged = fields.with_name(f"{fields.name}-of-next-mesh") if fields is not None else None
    while True:
        try:
            result = solve(comm, case, replace(options, fields=staged), passes.load)
            if result.failure is not None and last is not None:
                raise result.failure
        except FretfeError as error:
            if last is None or last.refinement is None:
                raise
            on_root(comm, partial(_drop, staged))
            return replace(last, refinement=replace(last.refinement, reason=str(error)))
        on_root(comm, partial(_keep, staged, fields))
        refinement = on_root(comm, partial(passes.judge, result))
        last = replace(result, refinement=refinement)
        if refinement.reason:
            return last


def _drop(staged: Path | None) -> None:
    if staged is not None:
        staged.unlink(missing_ok=True)


def _keep(staged: Path | None, fields: Path | None) -> None:
    """Put the fields that a pass has written, if any, in their place."""
    if staged is not None and fields is not None and staged.is_file():
        staged.replace(fields)


class _Passes:
    """The meshes of a case one after the other, and what they gave; rank 0 only."""

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        assert case.edges.tolerance is not None
        self._case = case
        self._announce = announce
        self._edges, self._tolerance = case.edges, case.edges.tolerance
        self._growth = growth_for(self._tolerance, case.model.degree)
        self._sources: tuple[Source, ...] = ()
        self._level = 0
        self._passes: tuple[Pass, ...] = ()
        self._mesh: Mesh | None = None

    def load(self) -> Mesh:
        """The next mesh.

        Raises:
            MeshError: if it is larger than the case allows, or as for `load_mesh`.
        """
        contacts = [(each.surface1, each.surface2) for each in self._case.contacts.values()]
        size = partial(apply_fine_sizes, contacts, self._growth, self._sources)
        mesh = load_mesh(self._case, size)
        unknowns = count_unknowns(mesh, self._case.model.degree)
        if unknowns > self._edges.unknowns:
            raise MeshError(
                f"{self._case.source}: edges.unknowns: mesh {len(self._passes) + 1} would have "
                f"{unknowns} unknowns, expected at most {self._edges.unknowns}"
            )
        self._announce(f"mesh {len(self._passes) + 1}: {unknowns} unknowns")
        self._mesh = mesh
        return mesh

    def judge(self, result: Result) -> Refinement:
        """All passes so far, this one included; without a reason to end there is another."""
        solution, mesh = result.solution, self._mesh
        assert solution is not None
        assert mesh is not None
        contacts = result.contacts
        if result.failure is not None:
            return self._refinement(reason=str(result.failure))
        before = self._passes[-1] if self._passes else None
        self._passes += (self._pass(solution, mesh, contacts),)
        last = self._passes[-1]
        self._announce(f"mesh {len(self._passes)}: {_change_text(before, last)}")
        if before is not None and before.resolved and self._fine_enough(last):
            return self._refinement("the results no longer change", converged=True)
        if len(self._passes) == MOST_PASSES:
            return self._refinement(f"{MOST_PASSES} meshes were not enough")
        # A mesh that still does not show all of a slip zone must not keep the others waiting.
        self._level += last.resolved or len(self._passes) > UNRESOLVED_PASSES
        intervals = needed_sizes(solution, contacts, self._level)
        self._sources = tuple(_sources(self._case, mesh, solution, intervals))
        return self._refinement("")

    def _pass(self, solution: Solution, mesh: Mesh, contacts: tuple[ContactSummary, ...]) -> Pass:
        values = station_values(solution, contacts)
        before = self._passes[-1] if self._passes else None
        return Pass(
            unknowns=count_unknowns(mesh, self._case.model.degree),
            smallest_element=min(float(np.diff(c.arc).min()) for c in solution.contacts),
            stations=values,
            resolved=all(math.isfinite(each.k_n) for each in values)
            and resolves(solution, needed_sizes(solution, contacts, 0)),
            change=max(changes_by_kind(before.stations if before else (), values)),
        )

    def _fine_enough(self, last: Pass) -> bool:
        return last.resolved and last.change <= self._tolerance

    def _refinement(self, reason: str, *, converged: bool = False) -> Refinement:
        return Refinement(self._tolerance, self._passes, converged, reason)


def _change_text(before: Pass | None, last: Pass) -> str:
    if before is None or not math.isfinite(last.change):
        return "shows where the contact edges are" if before is None else "no edge factors yet"
    return f"edge factors and slip zones changed by up to {last.change:.2%}"


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
