# SPDX-License-Identifier: LGPL-3.0-or-later
"""The model that finite elements would solve, from the case and its mesh, without DOLFINx."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.carried import require_carried
from fretfe.bodies.continued import coupled_contacts, half_middles
from fretfe.bodies.definition import (
    ModelDefinition,
    Pair,
    contact_surfaces,
    model_notes,
    require_possible,
)
from fretfe.bodies.expected import proposed_sizes, require_pressed
from fretfe.bodies.loads.files import checked_history
from fretfe.bodies.rigid_modes import held_model, modes_restrained_by_contact
from fretfe.case import Case, case_notes, stiffness_doubts
from fretfe.contact.march import MOST_PARTS
from fretfe.environment import rank_from_environment
from fretfe.loads import History, most_added
from fretfe.mesh.cost import Amount, BodySizes, Cost, estimate_cost, finer_model
from fretfe.mesh.load import section_of, size_key, sweep_of
from fretfe.mesh.mesh import Mesh, place_text
from fretfe.surface.checks import load_mesh

# Accuracy for which an element size is proposed; sizes up to this factor larger are as good.
PROPOSED = 0.03
LIKE = 1.05
# Elements that are so many times as large say nothing of what that takes.
MOST_FINER = 10
# Extremes of the loads in a cycle, and the last state.
EXTREMES = 3
# Cycles after which solids are steady in most cases: each leaves a tenth of the change before.
LIKELY_ADDED = 4


@dataclass(frozen=True)
class Checked:
    """A case that finite elements could solve.

    Attributes:
        case: as it was checked.
        history: its loads.
        mesh: of its bodies, the first one if it refines itself.
        definition: bodies, coordinates and loads of the model.
        pairs: coupled contact surfaces.
        restrained_modes: by body, a rigid motion that only contact prevents, in words.
    """

    case: Case
    history: History
    mesh: Mesh
    definition: ModelDefinition
    pairs: Sequence[Pair]
    restrained_modes: Mapping[str, str]

    @property
    def notes(self) -> tuple[str, ...]:
        """Things that a reader of its results should know, in words."""
        own = model_notes(self.case, self.definition, self.mesh)
        unit = self.case.units.length
        halves = (
            f"half model: contact {name} goes on behind the plane of symmetry at "
            f"{place_text(point + 0.0)} {unit}; P, Q and friction work are those of the half"
            for name, point in self.middles.items()
        )
        return (*case_notes(self.case), *own, *halves)

    @property
    def middles(self) -> dict[str, Array]:
        """(2,) places where plane contacts end in a plane of symmetry at one end, by contact."""
        return half_middles(self.pairs)

    @cached_property
    def cost(self) -> Cost:
        """Estimate of memory and time on one process, of the first mesh if it refines itself."""
        return self.cost_on(1)

    def most_ranks(self, cores: int) -> int:
        """Largest number of processes for which so many cores and this machine's memory suffice."""
        fitting = (ranks for ranks in range(cores, 0, -1) if self.cost_on(ranks).fits)
        return next(fitting, 0)

    @cached_property
    def _sizes(self) -> BodySizes:
        degree, components = self.case.model.degree, self.definition.components
        return BodySizes.of(self.mesh, degree, components)

    def cost_on(self, ranks: int) -> Cost:
        """The same on several processes."""
        nodes = sum(len(pair.coupling.surface.weights) for pair in self.pairs)
        steps, cycle = len(self.history.times) - 1, self.history.cycle
        if cycle is not None:
            more = most_added(self.case, self.history, self.mesh.dimension)
            steps += min(more, LIKELY_ADDED) * (cycle[1] - cycle[0])
        plane, along = self.mesh.dimension == 2, self.case.edges.stations
        # Sections and extrusions have two fronts; other solids two, or one that is closed.
        fronts = len(self.pairs) * (2 if plane or section_of(self.case) else 1.5)
        stations = round(fronts * (1 if plane else along))
        states = _field_states(self.case, steps, len(self.history.times) - 1)
        found = estimate_cost(self._sizes, nodes, Amount(steps, stations, states), ranks)
        added, unloaded = (
            steps - (len(self.history.times) - 1),
            unloaded_steps(self.case, self.history),
        )
        return replace(found, added=added, unloaded=unloaded, divided=MOST_PARTS)


def unloaded_steps(case: Case, history: History) -> int:
    """Number of steps with friction at whose beginning or end there is no load: they are divided.

    The first one is left out: mostly it presses bodies together without shear.
    """
    rough = [each.friction_from for each in case.contacts.values() if each.friction != 0]
    empty = ~history.values[1:].any(axis=1)
    with_friction = history.times[2:] > min(rough, default=np.inf)
    return int(np.count_nonzero((empty[1:] | empty[:-1]) & with_friction))


def _field_states(case: Case, steps: int, written: int) -> int:
    """About how many states have fields that are written, of all steps and those as written."""
    wanted = case.output.fields
    if isinstance(wanted, str):
        return min(steps, {"none": 0, "last": 1, "extremes": EXTREMES, "all": 2 * written}[wanted])
    return len(wanted)


def propose(checked: Checked) -> Iterator[str]:
    """The element size for an accuracy of K_N and |ΔK| at stations of solids, and its memory.

    The accuracy is the tolerance of the case, 3 % without one. Nothing is said in the plane, of CAD
    sections, whose sizes follow from the tolerance, nor of bodies whose stiffness is doubted.
    """
    case, mesh = checked.case, checked.mesh
    if mesh.dimension == 2 or _chooses_sizes(case) or any(stiffness_doubts(case)):
        return
    tolerance = case.edges.tolerance or PROPOSED
    sizes = []
    for each in proposed_sizes(case, mesh, checked.history, tolerance):
        if each.reason:
            yield f"contact {each.contact}: no element size is proposed, as {each.reason}"
        else:
            sizes.append(each)
    if not sizes:
        return
    least = min(sizes, key=lambda each: each.size)
    unit = case.units.length
    why = (
        f"for K_N and ΔK to {tolerance:.0%} at all stations: {least.length / least.size:.0f} over "
        f"the half-width of {least.length:.2g} {unit} expected in contact {least.contact} at P = "
        f"{least.force:.4g}"
    )
    key, now = size_key(case)
    if not key:
        yield f"make the elements {least.size:g} {unit} long at the fronts, {why}"
    elif now <= LIKE * least.size:
        yield f"{key} = {now:g} is likely to be small enough {why}"
    elif case.geometry.solid is None and section_of(case) is not None:
        yield f"leave {key} = {now:g} out, and the section that the bodies sweep is refined: {why}"
    elif now > MOST_FINER * least.size:
        yield (
            f"set {key} = {least.size:g} {why}: what that takes was not looked at, as {key} is "
            f"{now / least.size:.2g} times as large; check the units of lengths and loads, too"
        )
    else:
        taken = finer_model(mesh, checked.cost, case.surface_names, (now, least.size))
        yield f"set {key} = {least.size:g} {why}: {taken}"


def _chooses_sizes(case: Case) -> bool:
    """True if fretfe chooses the element sizes of solids before it has solved anything."""
    return case.geometry.solid is None and sweep_of(case) is not None


def check(case: Case) -> Checked | None:
    """Check a case and its mesh without solving it; None on processes other than 0.

    Raises:
        FretfeError: if there is no history, no mesh or no model for the case.
    """
    if rank_from_environment() > 0:
        return None
    history, mesh = checked_history(case), _first_mesh(case)
    definition = held_model(case, mesh)
    require_possible(case, definition, history)
    require_pressed(case, mesh, history)
    require_carried(case, mesh, history)
    pairs = coupled_contacts(case, definition, mesh, contact_surfaces(definition, mesh))
    restrained = modes_restrained_by_contact(definition, mesh)
    return Checked(case, history, mesh, definition, pairs, restrained)


def make_mesh(case: Case) -> Mesh | None:
    """Make the mesh of a case, the first one if it refines itself; None on processes other than 0.

    Raises:
        FretfeError: if there is no mesh for the case.
    """
    return None if rank_from_environment() > 0 else _first_mesh(case)


def _first_mesh(case: Case) -> Mesh:
    if case.edges.tolerance is None:
        return load_mesh(case)
    # Imported where it is needed: with results, of which other cases know nothing.
    from fretfe.backends.passes import starting_mesh

    return starting_mesh(case)
