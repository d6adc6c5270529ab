# SPDX-License-Identifier: LGPL-3.0-or-later
"""Definition of the model: bodies with their materials, supports, loads and contact surfaces."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.bonds import bond_parts
from fretfe.bodies.constraints import Constraint, Driven, support_constraints
from fretfe.bodies.cyclic import Tie, tie_sides
from fretfe.bodies.loads.cut import Asked, Cut
from fretfe.bodies.loads.kinds import spread_loads
from fretfe.bodies.loads.motion import moved_boundaries, overlaps, read_all_cuts
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.bodies.loads.strain import require_temperatures
from fretfe.case import Case
from fretfe.contact.interface import Coordinate
from fretfe.errors import ModelError
from fretfe.loads import History
from fretfe.materials.material import Material
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.mortar import Coupling, couple
from fretfe.surface.surface import Surface, build_surface

# Part of an initial strain that may differ at the sides of a sector: values at points are
# interpolated, and constant across a line of points.
LARGEST_STEP = 0.02


@dataclass(frozen=True)
class BodyDefinition:
    """Definition of one body.

    Attributes:
        name: physical group of the body.
        material: elastic constants.
        constraints: constrained boundaries, in order of precedence.
        coordinates: one for each constraint.
        surfaces: contact surfaces of the body, in the order of the contacts.
        tie: of its sides, if it is a part of a sector.
        bond: of its parts, if it has some that are tied.
        cuts: boundaries of the body that another run moves.
        components: of the displacement, 3 in space; in the plane 2, or 3 with u_z(x, y).
    """

    name: str
    material: Material
    constraints: tuple[Constraint, ...]
    coordinates: tuple[Coordinate, ...]
    surfaces: tuple[str, ...]
    tie: Tie | None = None
    bond: Tie | None = None
    cuts: tuple[Cut, ...] = ()
    components: int = 2


@dataclass(frozen=True)
class ModelDefinition:
    """Definition of all bodies, and of the loads on whichever body has their boundary."""

    bodies: tuple[BodyDefinition, ...]
    loads: tuple[SpreadLoad, ...]

    @property
    def components(self) -> int:
        """Components of the displacement: 3 in space, in the plane 2, or 3 with u_z(x, y)."""
        return self.bodies[0].components

    @property
    def cuts(self) -> tuple[Cut, ...]:
        """All fields of other runs."""
        heated = {load.channel: load.run for load in self.loads if load.run is not None}
        return (*(cut for body in self.bodies for cut in body.cuts), *heated.values())

    @property
    def digest(self) -> str:
        """Text that is equal for loads with the same values at points."""
        given = [each for load in self.loads for each in load.given]
        shapes = [each.shape for body in self.bodies for each in body.constraints]
        found = hashlib.sha256()
        for each in (*given, *(shape for shape in shapes if shape is not None)):
            found.update(each.points.tobytes() + each.values.tobytes())
        return found.hexdigest()


def define_model(case: Case, mesh: Mesh) -> ModelDefinition:
    """Translate a case into bodies, coordinates and loads.

    Raises:
        ModelError: if a body has no contact surface.
        CaseError: if values at points cannot be read, or do not reach as far as the bodies, or
            sides of a sector are not images of one another.
    """
    loads, cuts = spread_loads(case, mesh), read_all_cuts(case, mesh)
    return ModelDefinition(
        bodies=tuple(_define_body(case, mesh, name, cuts) for name in case.bodies), loads=loads
    )


def _define_body(
    case: Case, mesh: Mesh, name: str, cuts: Mapping[str, tuple[Asked, Cut]]
) -> BodyDefinition:
    own, size = mesh.bodies[name].boundaries, case.components(mesh.dimension)
    surfaces = [
        surface
        for contact in case.contacts.values()
        for surface in (contact.surface1, contact.surface2)
        if surface in own
    ]
    if not surfaces:
        raise ModelError(
            f"body {name!r} has no contact surface: expected one of its boundaries "
            f"({', '.join(sorted(own)) or 'none'}) in a contact of the case."
        )
    own_cuts = [each for each in cuts.values() if each[0].body == name]
    tie = _tie(case, mesh.bodies[name])
    held = support_constraints(case, size, own, tie)
    constrained = moved_boundaries(case, mesh.bodies[name], own_cuts) + held
    pairs = [(each.constraint, _coordinate(name, each)) for each in constrained]
    bond = bond_parts(case, mesh.bodies[name], surfaces, pairs)
    constrained += overlaps(case, mesh.bodies[name], bond)
    return BodyDefinition(
        name=name,
        material=Material.of(case.bodies[name], case.model.plane),
        constraints=tuple(each.constraint for each in constrained),
        coordinates=tuple(_coordinate(name, each) for each in constrained),
        surfaces=tuple(surfaces),
        bond=bond,
        tie=tie,
        cuts=tuple(cut for _, cut in own_cuts),
        components=size,
    )


def _coordinate(body: str, each: Driven) -> Coordinate:
    constraint = each.constraint
    return Coordinate(
        constraint.label, body, each.control, each.channel, each.course, constraint.resultant
    )


def _tie(case: Case, body: BodyMesh) -> Tie | None:
    """Tie of the sides of a body; None if it has none."""
    for name, symmetry in case.symmetry.items():
        if symmetry.boundary1 in body.boundaries:
            key = ("symmetry", name)
            tie = tie_sides(symmetry, key, case.source, body, case.model.degree)
            return tie.moving(case.components(body.points.shape[1]))
    return None


def model_notes(case: Case, definition: ModelDefinition, mesh: Mesh) -> tuple[str, ...]:
    """Things that a reader of the results of a model should know, in words."""
    return (
        *_across_notes(case, mesh.dimension),
        *(note for load in definition.loads for note in load.notes(case, mesh)),
        *side_notes(definition),
        *(note for cut in definition.cuts for note in cut.notes),
    )


def _across_notes(case: Case, dimension: int) -> Iterator[str]:
    """Loads and bodies by which plane bodies move along z, in words."""
    keys = [".".join(map(str, key)) for key in case.moving_across()]
    if dimension == 2 and keys:
        yield (
            "plane bodies move along z, too: displacements u_z(x, y) are part of the model by "
            f"{', '.join(keys)}"
        )


def side_notes(definition: ModelDefinition) -> Iterator[str]:
    """Initial strains that neighbour sectors do not continue, in words."""
    for body in definition.bodies:
        tie = body.tie
        for load in definition.loads:
            if tie is None or not load.strains(body.name):
                continue
            found = tie.mismatch(partial(load.initial_strain, body.name, body.material))
            if found > LARGEST_STEP:
                yield (
                    f"loads.{load.channel}: from one sector to the next the strain of "
                    f"{body.name} jumps by {100 * found:.3g} % of the largest at its sides: every "
                    "sector has the load of this one, turned"
                )


def require_possible(case: Case, definition: ModelDefinition, history: History) -> None:
    """Check that loads are possible in a history, as far as its values and the loads tell.

    Raises:
        CaseError: names the first load that is not.
    """
    require_temperatures(case, definition.loads, history)
    for cut in definition.cuts:
        cut.require_steps(case, history)


@dataclass(frozen=True)
class Pair:
    """One contact: its name, its bodies, its coupling and the compliances (N, 2) of its layer.

    Those are the approach per pressure, and the displacement along the surface per shear. `law` is
    that of `Interface.laws`.
    """

    name: str
    body1: str
    body2: str
    coupling: Coupling
    layer: Array
    law: Array | None = None


def contact_surfaces(definition: ModelDefinition, mesh: Mesh) -> dict[str, Surface]:
    """All contact surfaces, oriented, by name."""
    return {
        name: build_surface(mesh.bodies[body.name], name)
        for body in definition.bodies
        for name in body.surfaces
    }


def couple_contacts(
    case: Case, surfaces: Mapping[str, Surface], components: int
) -> tuple[Pair, ...]:
    """The contact pairs of a case, in its order, for so many components of the displacement."""
    pairs = []
    for name, contact in case.contacts.items():
        first, second = surfaces[contact.surface1], surfaces[contact.surface2]
        coupling = couple(name, first, second, contact.multipliers, case.model.degree, components)
        even = (0.0, 0.0) if contact.layer is None else contact.layer.compliances
        layer = np.broadcast_to(even, (len(coupling.surface.weights), 2))
        curve = None if contact.layer is None else contact.layer.curve
        law = None if curve is None else np.array(curve)
        pairs.append(Pair(name, first.body, second.body, coupling, layer, law))
    return tuple(pairs)
