# SPDX-License-Identifier: LGPL-3.0-or-later
"""The model that finite elements would solve, from the case and its mesh, without DOLFINx."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fretfe.backends.meshes import starting_mesh
from fretfe.bodies.definition import ModelDefinition, Pair, contact_surfaces, couple_contacts
from fretfe.bodies.rigid_modes import held_model, modes_restrained_by_contact
from fretfe.case import Case
from fretfe.environment import rank_from_environment
from fretfe.loads import History, build_history
from fretfe.mesh.cost import Cost, estimate_cost
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import load_mesh

# Extremes of the loads in a cycle, and the last state.
EXTREMES = 3


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
    def cost(self) -> Cost:
        """Estimate of memory and time, of the first mesh if it refines itself."""
        nodes = sum(len(pair.coupling.weights) for pair in self.pairs)
        steps = len(self.history.times) - 1
        plane = self.mesh.dimension == 2
        # Two fronts, or one that is closed.
        stations = 2 * len(self.pairs) * (1 if plane else self.case.edges.stations)
        states = _field_states(self.case, steps)
        return estimate_cost(self.mesh, self.case.model.degree, nodes, steps, stations, states)


def _field_states(case: Case, steps: int) -> int:
    """About how many states have fields that are written."""
    wanted = case.output.fields
    if isinstance(wanted, str):
        return min(steps, {"none": 0, "last": 1, "extremes": EXTREMES, "all": steps}[wanted])
    return len(wanted)


def check(case: Case) -> Checked | None:
    """Check a case and its mesh without solving it; None on processes other than 0.

    Raises:
        FretfeError: if there is no history, no mesh or no model for the case.
    """
    if rank_from_environment() > 0:
        return None
    history, mesh = build_history(case), _first_mesh(case)
    definition = held_model(case, mesh)
    pairs = couple_contacts(case, contact_surfaces(definition, mesh))
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
    return starting_mesh(case)
