# SPDX-License-Identifier: LGPL-3.0-or-later
"""The meshes of a case that refines itself, one after the other, without what solves on them."""

from __future__ import annotations

import json
import math
import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.backends.protocol import RunOptions
from fretfe.bodies.free_ends import graded
from fretfe.case import Case
from fretfe.errors import MeshError, OutputError
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.refinement import (
    Pass,
    Refinement,
    edge_changes,
    names_before,
    solid_values,
    station_changes,
)
from fretfe.evaluate.resolution import (
    Interval,
    edges_of_section,
    fine_places,
    hopeless,
    needed_sizes,
    resolves,
    station_values,
)
from fretfe.faults import guarded
from fretfe.files import replace_text, writing
from fretfe.history.solution import ContactHistory, Solution
from fretfe.mesh.load import sweep_of
from fretfe.mesh.mesh import Mesh, count_unknowns
from fretfe.mesh.sizing import FinePlaces, Source, apply_fine_sizes, refine_near
from fretfe.mesh.templates import find_template
from fretfe.results.model import Result
from fretfe.results.run_folder import are_unchanged, with_digest
from fretfe.surface.checks import load_mesh
from fretfe.surface.surface import build_surface

# More passes than this do not help: the element size at the edges has been halved eight times. Of
# solids each pass takes minutes, and one and a half to twice the memory of the one before.
MOST_PASSES = 12
MOST_SOLID_PASSES = 6
# In the folder of the states: what makes the next mesh.
NOTE = "refinement.json"
# Layers of swept bodies over those of the mesh before; what a template calls their thickness.
FINER = 1.4
SWEPT = "length_size"
# Passes that may be needed to find the edges and to resolve their slip zones.
UNRESOLVED_PASSES = 3
# Part of an element that is not counted: intervals often are multiples of their elements, but for
# round-off.
ROUND_OFF = 1e-6
# Elements by which an interval may begin or end elsewhere on the next mesh: edges under small loads
# are known to a few.
WANDERING = 4
# Largest growth of the element size per distance from the edges.
LARGEST_GROWTH = 0.3
# Elements along the shorter surface of a plane contact where nothing else makes them finer.
ALONG_CONTACT = 40


class Passes(ABC):
    """The meshes of a case one after the other, and what they gave; rank 0 only.

    Args:
        case: that asks for an accuracy.
        announce: told of each mesh.
    """

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        assert case.edges.tolerance is not None
        self._case = case
        self._announce = announce
        self._edges, self._tolerance = case.edges, case.edges.tolerance
        self._done: tuple[Pass, ...] = ()
        # Passes of an earlier run, of which one may follow those that are done.
        self._recorded: tuple[Pass, ...] = ()
        self._mesh: Mesh | None = None

    # Largest number of meshes.
    most = MOST_PASSES

    @property
    def case(self) -> Case:
        """The case that is solved on them."""
        return self._case

    @property
    def _largest(self) -> int:
        """Number of unknowns of the largest mesh that is solved."""
        return self._edges.unknowns

    @abstractmethod
    def _make_mesh(self) -> Mesh:
        """The next mesh."""

    @abstractmethod
    def _pass(self, result: Result, mesh: Mesh) -> Pass:
        """The results of a mesh."""

    @abstractmethod
    def _make_finer(self, result: Result, mesh: Mesh) -> None:
        """Plan the next mesh after a pass."""

    @abstractmethod
    def _noted(self) -> dict[str, Any]:
        """The sizes that make the next mesh, for JSON."""

    @abstractmethod
    def _follow(self, note: dict[str, Any], last: Result) -> None:
        """Plan the next mesh as noted, after a last result."""

    def options(self, options: RunOptions, keep: Callable[[Result], None]) -> RunOptions:
        """Options of the next pass, which has a folder of its own for its states."""
        states = options.states
        states = states / f"mesh-{len(self._done) + 1}" if states is not None else None
        return replace(options, states=states, before=None, keep=keep)

    def note(self, states: Path | None) -> None:
        """Write down what makes the next mesh, and remove the states of the last pass.

        Raises:
            OutputError: if that is not possible.
        """
        if states is None:
            return
        count = len(self._done)
        note = with_digest({"passes": count, **self._noted()})
        with writing(states / NOTE, "the sizes of the next mesh"):
            replace_text(states / NOTE, json.dumps(note))
            shutil.rmtree(states / f"mesh-{count}", ignore_errors=True)

    def recall(self, last: Result | None, states: Path | None) -> bool:
        """Go on after the passes that an earlier run has noted; return False if there are none.

        Args:
            last: result of the last pass or, if the run ended between the two, one later.
            states: folder of the note.

        Raises:
            OutputError: if the note is not as it was written.
        """
        refinement = last.refinement if last is not None else None
        if states is None or last is None or refinement is None:
            return False
        if not (states / NOTE).is_file():
            return False
        note = _read_note(states / NOTE)
        self._done, self._recorded = refinement.passes[: note["passes"]], refinement.passes
        self._follow(note, last)
        return True

    def load(self) -> Mesh:
        """The next mesh.

        Raises:
            MeshError: if it is larger than the case allows, or as for `load_mesh`.
        """
        mesh = self._make_mesh()
        unknowns = self._unknowns(mesh)
        if unknowns > self._largest:
            raise MeshError(
                f"{self._case.source}: edges.unknowns: mesh {len(self._done) + 1} would have "
                f"{unknowns} unknowns, expected at most {self._largest}: set it larger for them"
            )
        self._announce(f"mesh {len(self._done) + 1}: {unknowns} unknowns")
        self._mesh = mesh
        return mesh

    def _unknowns(self, mesh: Mesh) -> int:
        size = self._case.components(mesh.dimension)
        return count_unknowns(mesh, self._case.model.degree, size)

    def judge(self, result: Result) -> Refinement:
        """All passes so far, this one included; without a reason to end there is another.

        It is the last one if fretfe fails in telling what the next mesh needs.
        """
        return guarded(
            "next mesh",
            lambda: self._judge(result),
            lambda fault: self._refinement(fault.text),
        )

    def _judge(self, result: Result) -> Refinement:
        mesh = self._mesh
        assert mesh is not None
        if result.failure is not None:
            return self._refinement(reason=str(result.failure))
        before = self._done[-1] if self._done else None
        number = len(self._done)
        known = number < len(self._recorded)
        last = self._recorded[number] if known else self._pass(result, mesh)
        self._done += (last,)
        self._announce(f"mesh {len(self._done)}: {_change_text(before, last)}")
        if why := self._fine_enough(before, last, result):
            return self._refinement(why, converged=True)
        if len(self._done) == self.most:
            return self._refinement(f"{self.most} meshes were not enough")
        if reason := self._hopeless(result):
            return self._refinement(reason)
        self._make_finer(result, mesh)
        return self._refinement("")

    def _hopeless(self, result: Result) -> str:
        """Reason why finer meshes cannot help; empty if they may."""
        return ""

    def _fine_enough(self, before: Pass | None, last: Pass, _result: Result) -> str:
        """Reason why no finer mesh is needed; empty if one is."""
        compared = before is not None and before.resolved and last.resolved
        fine = compared and last.change <= self._tolerance
        return "the results no longer change" if fine else ""

    def _refinement(self, reason: str, *, converged: bool = False) -> Refinement:
        return Refinement(self._tolerance, self._done, converged, reason)


def _read_note(path: Path) -> dict[str, Any]:
    try:
        note = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise OutputError(f"{path}: expected what makes the next mesh, found: {error}") from error
    if not isinstance(note, dict) or not are_unchanged(note):
        raise OutputError(
            f"{path}: expected what makes the next mesh, found changed values. Run the case again "
            "without --resume"
        )
    return note


def _change_text(before: Pass | None, last: Pass) -> str:
    if before is None and last.stations:
        return "shows where the contact edges are"
    if last.worst is None:
        return "nothing to compare with yet" if last.stations else "no edge factors yet"
    resolved = "" if last.resolved else "; its elements do not resolve all edges and slip zones"
    return f"largest change: {last.worst.text}{resolved}"


class SolidPasses(Passes):
    """Meshes of solids: the first is that of the case, later ones are finer along the fronts."""

    most = MOST_SOLID_PASSES
    # Of the element size per distance from the fronts.
    growth = LARGEST_GROWTH

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        super().__init__(case, announce)
        self._places = FinePlaces(np.empty((0, 3)), np.empty(0))
        self._before: tuple[Contact, ...] = ()

    def _noted(self) -> dict[str, Any]:
        return {"points": self._places.points.tolist(), "sizes": self._places.sizes.tolist()}

    def _follow(self, note: dict[str, Any], last: Result) -> None:
        points = np.reshape(note["points"], (-1, 3))
        self._places, self._before = FinePlaces(points, np.array(note["sizes"])), last.contacts

    def _make_mesh(self) -> Mesh:
        size, factor = partial(refine_near, self._places, self.growth), FINER ** len(self._done)
        with_ends = graded(self._case)
        mesh = load_mesh(finer_sweep(with_ends, factor), size)
        if with_ends is self._case or self._unknowns(mesh) <= self._largest:
            return mesh
        # Elements at free ends are as short as stations there need only if there is room.
        return load_mesh(finer_sweep(self._case, factor), size)

    def _pass(self, result: Result, mesh: Mesh) -> Pass:
        before, now = (fronts_told(each) for each in (self._before, result.contacts))
        if now < before:
            raise MeshError(
                f"mesh {len(self._done) + 1} tells K_N along {now} fronts, expected the {before} "
                "of the mesh before: its results are not taken"
            )
        values = solid_values(result.contacts, result.solution)
        changes = station_changes(self._before, result.contacts, result.solution, values)
        sizes = [station.size for each in result.contacts for station in each.stations]
        return Pass(
            unknowns=self._unknowns(mesh),
            smallest_element=min(sizes, default=math.nan),
            stations=values,
            resolved=bool(values) and all(math.isfinite(x) for each in values for x in each.values),
            changes=changes,
        )

    def _make_finer(self, result: Result, mesh: Mesh) -> None:
        self._before = result.contacts
        self._places = _front_places(self._case, mesh, result.solution, result.contacts)


def fronts_told(contacts: Sequence[Contact]) -> int:
    """Number of fronts with K_N at any station."""
    fronts = (front for each in contacts for front in each.fronts)
    return sum(any(math.isfinite(e.reported_k_n) for e in front.stations) for front in fronts)


def finer_sweep(case: Case, factor: float) -> Case:
    """The same case with thinner layers by a factor where its bodies are swept.

    The layers of a template are thinner if the elements of its sections are smaller, too.
    """
    geometry, changed = case.geometry, dict[str, Any]()
    if geometry.solid is not None:
        changed["solid"] = geometry.solid.finer(factor)
    elif geometry.template is not None:
        known = find_template(geometry.template, length=case.units.length).parameters
        sizes = {each.name: each.default for each in known if each.is_size}
        if SWEPT in sizes:
            sizes |= {name: x for name, x in geometry.parameters.items() if name in sizes}
            finer = {name: size / factor for name, size in sizes.items()}
            changed["parameters"] = {**geometry.parameters, **finer}
    return case.model_copy(update={"geometry": geometry.model_copy(update=changed)})


def _front_places(
    case: Case, mesh: Mesh, solution: Solution, contacts: Sequence[Contact]
) -> FinePlaces:
    """Fine places of the next mesh on both surfaces, or in the plane mesh that is extruded."""
    histories = {each.name: each for each in solution.contacts}
    points, sizes = [np.empty((0, 3))], [np.empty(0)]
    for contact in contacts:
        history = histories[contact.pair]
        for places in fine_places(solution, history, contact, case.edges.tolerance or 0.0):
            for on_body in _on_bodies(case, mesh, history, places.points):
                points.append(on_body)
                sizes.append(places.sizes)
    together, sweep = np.vstack(points), sweep_of(case)
    if sweep is not None:
        together = sweep.in_plane(together)
    return FinePlaces(*without_round_off(together, np.concatenate(sizes)))


def _on_bodies(case: Case, mesh: Mesh, history: ContactHistory, points: Array) -> Iterator[Array]:
    """Places (n, d) of both surfaces of a contact that are nearest to points (n, d)."""
    contact = case.contacts[history.pair]
    for body, name in ((history.body1, contact.surface1), (history.body2, contact.surface2)):
        yield build_surface(mesh.bodies[body], name).nearest(points)[0]


def without_round_off(points: Array, sizes: Array) -> tuple[Array, Array]:
    """Places (n, d) and element sizes (m,) without the digits that round-off reaches.

    Gmsh turns a change in the last digit into other meshes, whose slip zones differ by tenths of a
    per cent: runs of one case on other numbers of processes or another BLAS would not agree.
    Sizes keep three digits, places lie on multiples of a hundredth of the smallest size or less.
    """
    if not sizes.size:
        return points, sizes
    powers = 10.0 ** np.floor(np.log10(sizes))
    unit = 0.01 * float(powers.min())
    return np.round(points / unit) * unit, np.round(sizes / powers, 2) * powers


def growth_for(tolerance: float, degree: int) -> float:
    """Growth of the element size per distance from an edge, for displacements of a degree.

    Elements g s long at a distance s interpolate √s with the relative error g²/32: a third of the
    tolerance. Linear displacements need half of that, found by trial.
    """
    return min(math.sqrt(32 * tolerance / 3), LARGEST_GROWTH) * degree / 2


class PlanePasses(Passes):
    """Meshes that are finer where the one before showed contact edges and slip zones."""

    def __init__(self, case: Case, announce: Callable[[str], None]) -> None:
        super().__init__(case, announce)
        self._growth = growth_for(self._tolerance, case.model.degree)
        self._sources: tuple[Source, ...] = ()
        self._level = 0
        self._before: tuple[Contact, ...] = ()

    def _noted(self) -> dict[str, Any]:
        sources = [{"points": each.points.tolist(), "size": each.size} for each in self._sources]
        return {"level": self._level, "sources": sources}

    def _follow(self, note: dict[str, Any], last: Result) -> None:
        self._level, self._before = note["level"], last.contacts
        self._sources = tuple(
            Source(np.array(each["points"]), each["size"]) for each in note["sources"]
        )

    def _make_mesh(self) -> Mesh:
        contacts = [(each.surface1, each.surface2) for each in self._case.contacts.values()]
        size = partial(apply_fine_sizes, contacts, self._growth, self._sources, ALONG_CONTACT)
        return load_mesh(self._case, size, section=True)

    def _pass(self, result: Result, mesh: Mesh) -> Pass:
        solution, contacts = result.solution, result.contacts
        values = station_values(solution, contacts)
        before = self._done[-1] if self._done else None
        return Pass(
            unknowns=self._unknowns(mesh),
            smallest_element=min(float(np.diff(c.surface.arc).min()) for c in solution.contacts),
            stations=values,
            resolved=all(math.isfinite(each.k_n) for each in values)
            and resolves(solution, needed_sizes(solution, contacts, 0)),
            changes=edge_changes(
                before.stations if before else (), values, names_before(self._before, contacts)
            ),
        )

    def edges(self, result: Result) -> FinePlaces:
        """Edges of the last mesh, with elements for solids that have it as their section."""
        assert self._mesh is not None
        solution = result.solution
        intervals = tuple(edges_of_section(solution, result.contacts))
        found = tuple(_sources(self._case, self._mesh, solution, intervals))
        points = np.pad(np.vstack([each.points for each in found]), ((0, 0), (0, 1)))
        return FinePlaces(
            points, np.repeat([x.size for x in found], [len(x.points) for x in found])
        )

    def _hopeless(self, result: Result) -> str:
        return hopeless(result.solution, result.contacts, self._done)

    def _make_finer(self, result: Result, mesh: Mesh) -> None:
        solution, self._before = result.solution, result.contacts
        # A mesh that still does not show all of a slip zone must not keep the others waiting. Where
        # they change no more, ever smaller elements would only lose the root in round-off.
        last, late = self._done[-1], len(self._done) > UNRESOLVED_PASSES
        open_yet = last.change > self._tolerance or any(
            station.uncertain for each in result.contacts for station in each.stations
        )
        self._level += last.resolved or (late and open_yet)
        intervals = needed_sizes(solution, result.contacts, self._level)
        self._sources = tuple(_sources(self._case, mesh, solution, intervals))


def _sources(
    case: Case, mesh: Mesh, solution: Solution, intervals: Sequence[Interval]
) -> Iterator[Source]:
    """The intervals as places on the surfaces of both bodies."""
    contacts = {contact.name: contact for contact in solution.contacts}
    for each in intervals:
        history = contacts[each.contact]
        beside = WANDERING * each.size if each.high > each.low else 0.0
        low, high = each.low - beside, each.high + beside
        count = math.ceil((high - low) / each.size - ROUND_OFF) + 1
        arc = np.linspace(low, high, count)
        surface = history.surface
        points = np.stack([np.interp(arc, surface.arc, x) for x in surface.points.T], axis=1)
        for places in _on_bodies(case, mesh, history, points):
            kept, sizes = without_round_off(places, np.array([each.size]))
            yield Source(kept, float(sizes[0]))
