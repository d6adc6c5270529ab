# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forces and moments of the loads about what nothing carries, before anything is condensed.

Bodies move as supports, platens, sides of sectors and contacts let them: with friction as if a
contact stuck, without as if it only slid. Loads must do no work in a motion that is left.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.definition import BodyDefinition, define_model
from fretfe.bodies.loads.spread import SpreadLoad, SurfaceTraction
from fretfe.bodies.rigid_modes import (
    TURNING,
    RigidMotions,
    free_motions,
    in_words,
    joined,
    rigid_motions,
)
from fretfe.case import Case, complaint
from fretfe.errors import CaseError
from fretfe.loads import History
from fretfe.mesh.mesh import Mesh
from fretfe.report.texts import rounded
from fretfe.surface.overlap import GAUSS_POINTS
from fretfe.surface.surface import Surface, boundary_surface, build_surface

# Work over that of the sizes of the forces, below which it is an error of the integration, or of
# numbers typed in.
NO_WORK = 1e-4


def require_carried(case: Case, mesh: Mesh, history: History) -> None:
    """Check that loads do not push or turn bodies where nothing resists.

    Raises:
        CaseError: names the loads, what they move and by which force or torque.
    """
    if not case.symmetry and all(each.rough for each in case.contacts.values()):
        return  # what only friction holds may be held
    definition, thickness = define_model(case, mesh), case.model.thickness
    values = dict(zip(history.channels, history.values.T, strict=True))
    for bodies in joined(case, definition, rough=True):
        sector = any(each.tie is not None for each in bodies)
        # In sectors forces on volumes are about the axis, or along it.
        if not sector and any(load.pushes for load in definition.loads):
            continue
        free = free_motions(bodies, mesh, _seats(case, mesh, bodies))
        works = {name: np.outer(values[name], own) for name, own in free.platens.items()}
        for load in definition.loads:
            amplitudes = load.amplitudes(values[load.channel]) * (1 if load.total else thickness)
            works[load.label] = np.outer(amplitudes, _work(load, free, bodies, mesh))
        every = np.array([*works.values()]) / thickness
        total = every.sum(axis=0)
        excess = np.linalg.norm(np.atleast_2d(total), axis=1)
        worst = int(np.argmax(excess))
        if excess[worst] > NO_WORK * np.abs(every).max(initial=0.0):
            names = [name for name, own in works.items() if own[worst].any()]
            remedy = 'a support with fix = ["tangential"]' if sector else "a support, or friction,"
            others = "".join(f" (with loads.{name})" for name in names[1:])
            found = _in_words(case, free, total[worst], bodies)
            text = f"expected {remedy} that carries {found}{others}"
            raise CaseError(complaint(case.source, ("loads", names[0]), text))


def _seats(case: Case, mesh: Mesh, bodies: Sequence[BodyDefinition]) -> list[Surface]:
    """The flatter surface of each contact without friction of some bodies."""
    own = {name for body in bodies for name in body.surfaces}
    owner = {name: body for body in mesh.bodies.values() for name in body.boundaries}
    pairs = [(c.surface1, c.surface2) for c in case.contacts.values() if not c.rough]
    seats = ([build_surface(owner[name], name) for name in pair] for pair in pairs if own & {*pair})
    return [min(each, key=lambda one: np.ptp(one.normals, axis=(0, 1)).max()) for each in seats]


def _work(
    load: SpreadLoad, free: RigidMotions, bodies: Sequence[BodyDefinition], mesh: Mesh
) -> Array:
    """(k,) work of a unit of a load in free motions of bodies that move as one."""
    given, work = load.traction, np.zeros(free.count)
    for body in (mesh.bodies[each.name] for each in bodies):
        if given is not None and given.boundary in body.boundaries:
            places, forces = _forces(given, boundary_surface(body, given.boundary))
            motions = rigid_motions((places - free.centre) / free.size, bodies[0].components)
            moved = motions[:, : forces.shape[1]] @ free.motions
            work = np.einsum("nc,nck->k", forces, moved)
            size = np.linalg.norm(forces, axis=1) @ np.linalg.norm(moved, axis=1)
            work[np.abs(work) < NO_WORK * size] = 0.0
    return work


def _forces(given: SurfaceTraction, surface: Surface) -> tuple[Array, Array]:
    """Places (n, d) and forces (n, c) of a traction."""
    places, vectors = surface.integration_points(GAUSS_POINTS)
    areas = np.linalg.norm(vectors, axis=1)
    if given.even:
        if given.radius:
            away = places - np.array(given.centre[: surface.dimension])
            areas = areas * (np.linalg.norm(away, axis=1) < given.radius)
        through = given.through[: surface.dimension] or areas @ places / areas.sum()
        return np.array([through]), np.array([given.direction])
    forces = np.outer(areas, given.direction) if given.direction else vectors
    return places, forces if given.factors is None else forces * given.factors.at(places)[:, None]


def _in_words(case: Case, free: RigidMotions, work: Array, bodies: Sequence[BodyDefinition]) -> str:
    """The force or torque that does some work (k,) in free motions of bodies, and the motion."""
    size, plane = float(np.linalg.norm(work)), len(free.centre) == 2
    motion = free.motions @ work / size
    moves, turns = np.split(motion, [-1 if plane else -3])
    turn, units = float(np.linalg.norm(turns)) / free.size, case.units
    carried = f"a force of {rounded(size / float(np.linalg.norm(moves)))} {units.force}"
    if turn * free.size > TURNING:
        carried = f"a torque of {rounded(size / turn)} {units.force}·{units.length}"
    carried += f"/{units.length}" * plane
    names = " and ".join(repr(each.name) for each in bodies)
    free = RigidMotions(motion[:, None], free.centre, free.size)
    return f"{carried}, or other loads that balance it, found {names} free {in_words(free)}"
