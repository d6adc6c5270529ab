# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads that supports carry themselves, and forces and moments that nothing carries.

Bodies move as supports, platens, sides of sectors and contacts let them: with friction as if a
contact stuck, without as if it only slid. Loads must do no work in a motion that is left, and each
some work in those of its boundary.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import compress, product

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.definition import BodyDefinition, ModelDefinition, define_model
from fretfe.bodies.free_motions import (
    DRIVEN,
    TURNING,
    Freedom,
    RigidMotions,
    Seat,
    free_motions,
)
from fretfe.bodies.loads.spread import SpreadLoad
from fretfe.bodies.rigid_modes import in_words, joined
from fretfe.case import Case, complaint
from fretfe.errors import CaseError
from fretfe.fields.rigid_motions import rigid_motions
from fretfe.loads import History
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.report.texts import rounded
from fretfe.surface.surface import boundary_surface, build_surface

# Work over that of the sizes of the forces, below which it is an error of the integration, or of
# numbers typed in.
NO_WORK = 1e-4

# Groups of bodies that move as one.
Groups = Sequence[Sequence[BodyDefinition]]


def require_carried(case: Case, mesh: Mesh, history: History) -> None:
    """Check that loads act on bodies, and do not push or turn them where nothing resists.

    Raises:
        CaseError: names the loads, and what holds their boundary, or what they move and by which
            force or torque.
    """
    loaded = _Loaded(case, mesh, history, define_model(case, mesh))
    loaded.require_felt()
    if not case.symmetry and all(each.rough for each in case.contacts.values()):
        return  # what only friction holds may be held
    groups = joined(case, loaded.definition, rough=True)
    alone = [[group] for group in groups]
    # What a group slides on may be free to go with it.
    for moving in (*alone, groups) if len(groups) > 1 else alone:
        loaded.require_balance(moving)


@dataclass(frozen=True)
class _Loaded:
    """Bodies with their loads."""

    case: Case
    mesh: Mesh
    history: History
    definition: ModelDefinition

    def require_felt(self) -> None:
        """Check that loads act on more than what holds, or moves, every node of their boundary.

        Raises:
            CaseError: names a load that does not, and what holds there.
        """
        loads = [(each.channel, each.traction) for each in self.definition.loads]
        for body, (name, given) in product(self.definition.bodies, loads):
            own = self.mesh.bodies[body.name]
            if given is None or given.boundary not in own.boundaries:
                continue
            places, forces = replace(given, even=False, factors=None).forces(
                boundary_surface(own, given.boundary)
            )
            left, size = forces, np.linalg.norm(forces, axis=1).sum()
            for held, coordinate in zip(body.constraints, body.coordinates, strict=True):
                nodes = own.boundaries[given.boundary], own.boundaries[held.boundary]
                if coordinate.control == "force" or held.overlap or not np.isin(*nodes).all():
                    continue
                along = held.along(places)[:, : forces.shape[1]]
                left = left - np.einsum("nc,nc->n", along, left)[:, None] * along
                free = (np.linalg.norm(left, axis=1).sum() / size) ** 2
                carried = np.abs(np.einsum("nc,nc->n", along, forces)).sum() / size
                # Directions about an axis turn along the boundary: what they leave may be meant.
                partly = held.around is None and carried > DRIVEN
                if held.shape is not None or partly or free < 2 * NO_WORK:
                    text = (
                        "expected a boundary that can move along its load, found "
                        f"{given.boundary!r}, whose nodes {held.label!r} holds or moves: let them "
                        "go there, or load another one"
                    )
                    raise CaseError(complaint(self.case.source, ("loads", name, "boundary"), text))

    def require_balance(self, groups: Groups) -> None:
        """Check that loads do no work in free motions of groups of bodies.

        Raises:
            CaseError: names the loads that do, and the motion.
        """
        free = free_motions(groups, self.mesh, self._seats(groups))
        works = dict(self._works(groups, free))
        every = np.array([*works.values()]) / self.case.model.thickness
        total = every.sum(axis=0)
        excess = np.linalg.norm(np.atleast_2d(total), axis=1)
        worst = int(np.argmax(excess))
        if excess[worst] <= NO_WORK * np.abs(every).max(initial=0.0):
            return
        shares = np.abs(every[:, worst] @ total[worst]) / excess[worst] ** 2
        names = [*compress(works, shares > NO_WORK)]
        remedy = "a support, or friction,"
        if any(body.tie is not None for group in groups for body in group):
            remedy = 'a support with fix = ["tangential"]'
        others = "".join(f" (with loads.{name})" for name in names[1:])
        found = _in_words(self.case, free, total[worst], groups)
        text = f"expected {remedy} that carries {found}{others}"
        raise CaseError(complaint(self.case.source, ("loads", names[0]), text))

    def _seats(self, groups: Groups) -> list[Seat]:
        """The flatter surface of each contact without friction of groups of bodies."""
        owner = {name: body for body in self.mesh.bodies.values() for name in body.boundaries}
        own = {name for group in groups for body in group for name in body.surfaces}
        pairs = [(c.surface1, c.surface2) for c in self.case.contacts.values() if not c.rough]
        found = []
        for pair in (each for each in pairs if own & {*each}):
            one, other = (build_surface(owner[name], name) for name in pair)
            flatter = min(one, other, key=lambda each: np.ptp(each.normals, axis=(0, 1)).max())
            found.append(Seat(flatter, (one.body, other.body)))
        return found

    def _works(self, groups: Groups, free: Freedom) -> Iterator[tuple[str, Array]]:
        """Names of loads, and their work (T, k) in free motions of groups of bodies."""
        values = dict(zip(self.history.channels, self.history.values.T, strict=True))
        for name, own in free.platens.items():
            yield name, np.outer(values[name], own)
        for load in self.definition.loads:
            amplitudes = load.amplitudes(values[load.channel])
            unit = 1 if load.total else self.case.model.thickness
            yield load.label, unit * np.outer(amplitudes, self._work(load, groups, free))

    def _work(self, load: SpreadLoad, groups: Groups, free: Freedom) -> Array:
        """(k,) work of a unit of a load in free motions of groups of bodies."""
        work, size = np.zeros(free.count), np.zeros(free.count)
        for group, own in zip(groups, np.split(free.motions, len(groups)), strict=True):
            for body, mesh in ((each, self.mesh.bodies[each.name]) for each in group):
                for places, forces in _acting(load, body, mesh):
                    motions = rigid_motions((places - free.centre) / free.size, body.components)
                    moved = motions[:, : forces.shape[1]] @ own
                    work += np.einsum("nc,nck->k", forces, moved)
                    size += np.linalg.norm(forces, axis=1) @ np.linalg.norm(moved, axis=1)
        return np.where(np.abs(work) < NO_WORK * size, 0.0, work)


def _acting(
    load: SpreadLoad, body: BodyDefinition, mesh: BodyMesh
) -> Iterator[tuple[Array, Array]]:
    """Places (n, d) and forces (n, c) of a unit of a load on a body."""
    given = load.traction
    if given is not None and given.boundary in mesh.boundaries:
        yield given.forces(boundary_surface(mesh, given.boundary))
    if load.pushes:
        places, volumes = mesh.volumes()
        yield places, load.body_force(body.material, places) * volumes[:, None]


def _in_words(case: Case, free: Freedom, work: Array, groups: Groups) -> str:
    """The force or torque that does some work (k,) in free motions of groups, and the motion."""
    size, plane = float(np.linalg.norm(work)), len(free.centre) == 2
    motions = np.split(free.motions @ work / size, len(groups))
    motion = max(motions, key=lambda each: float(np.linalg.norm(each)))
    moves, turns = (np.linalg.norm(each) for each in np.split(motion, [-1 if plane else -3]))
    amount, unit = size / moves if turns <= TURNING else size / turns * free.size, case.units.force
    kind, unit = ("force", unit) if turns <= TURNING else ("torque", f"{unit}·{case.units.length}")
    carried = f"a {kind} of {rounded(float(amount))} {unit}" + f"/{case.units.length}" * plane
    alike = [np.allclose(each, motion, atol=TURNING) for each in motions]
    names = " and ".join(repr(body.name) for group in compress(groups, alike) for body in group)
    words = in_words(RigidMotions(motion[:, None], free.centre, free.size))
    return f"{carried}, or other loads that balance it, found {names} free {words}"
