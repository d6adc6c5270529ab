# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid motions that no support prevents, found from the geometry alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from fretfe._typing import Array, Bools
from fretfe.bodies.definition import BodyDefinition, ModelDefinition, define_model
from fretfe.bodies.motion_words import RigidMotions, in_words
from fretfe.case import Case
from fretfe.errors import ModelError
from fretfe.mesh.mesh import BodyMesh, Mesh

# Singular values below this fraction of the largest belong to modes that no constraint restrains: a
# restrained one moves constrained nodes by about one.
UNRESTRAINED = 1e-6
# A force drives a motion if that moves its platen by this fraction of the body's displacement.
DRIVEN = 0.01


def held_model(case: Case, mesh: Mesh) -> ModelDefinition:
    """Definition of a model that cannot move as a whole.

    Raises:
        ModelError: if a body has no contact surface, or nothing holds the bodies.
    """
    definition = define_model(case, mesh)
    _require_restraint(case, definition, mesh)
    return definition


def modes_restrained_by_contact(definition: ModelDefinition, mesh: Mesh) -> dict[str, str]:
    """Rigid-body modes restrained only by contact, in words, for each body that has some.

    Supports and prescribed displacements restrain their boundary. A platen restrains it too, but
    for the directions in which a force acts on it.
    """
    found: dict[str, str] = {}
    for body in definition.bodies:
        free, _ = _free_motions([body], mesh)
        if free.count:
            found[body.name] = in_words(free)
    return found


def _require_restraint(case: Case, definition: ModelDefinition, mesh: Mesh) -> None:
    """Check that bodies whose contacts are stuck cannot move rigidly.

    Raises:
        ModelError: names the bodies that could still move, and how.
    """
    for bodies in _joined(case, definition):
        free, pushed = _free_motions(bodies, mesh)
        if not free.count:
            continue
        names = sorted(body.name for body in bodies)
        hint = f" A force holds nothing: {', '.join(pushed)}." if pushed else ""
        raise ModelError(
            f"nothing holds {' and '.join(repr(name) for name in names)}: even if every contact "
            f"were stuck, {'they' if names[1:] else 'it'} would be free {in_words(free)}. Expected "
            "supports, or a platen under displacement control, that hold at least one body against "
            f"every translation and rotation.{hint}"
        )


def _joined(case: Case, definition: ModelDefinition) -> list[list[BodyDefinition]]:
    """Bodies that would move as one if every contact were stuck."""
    bodies = definition.bodies
    owner = {surface: number for number, body in enumerate(bodies) for surface in body.surfaces}
    ends = np.array([[owner[c.surface1], owner[c.surface2]] for c in case.contacts.values()])
    size = len(bodies)
    graph = sparse.coo_matrix((np.ones(len(ends)), ends.T), shape=(size, size))
    count, labels = connected_components(graph, directed=False)
    return [[bodies[i] for i in np.flatnonzero(labels == part)] for part in range(count)]


def _free_motions(bodies: Sequence[BodyDefinition], mesh: Mesh) -> tuple[RigidMotions, list[str]]:
    """Unrestrained motions of bodies that move as one, and the forces that drive them."""
    points = np.concatenate([mesh.bodies[body.name].points for body in bodies])
    centre, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
    count = rigid_motions(points[:1]).shape[2]
    parts, labels = [], []
    for body in bodies:
        driven = [i for i, each in enumerate(body.coordinates) if each.control == "force"]
        labels += [body.coordinates[i].label for i in driven]
        rows = [np.zeros((0, count + len(driven)))]
        rows += _constraint_rows(body, mesh.bodies[body.name], driven, centre, size)
        parts.append(np.concatenate(rows))
    held = np.concatenate([rows[:, :count] for rows in parts])
    by_force = linalg.block_diag(*(rows[:, count:] for rows in parts))
    # A unit of each coordinate moves its platen by one at most.
    by_force /= np.maximum(np.abs(by_force).max(axis=0, initial=1e-300), 1e-300)
    directions = _null_space(np.hstack([held, by_force]))
    motions, amplitudes = directions[:count], directions[count:]
    moving = np.abs(amplitudes).max(axis=1, initial=0.0) > DRIVEN
    pushed = [label for label, moves in zip(labels, moving, strict=True) if moves]
    return RigidMotions(motions, centre, size), pushed


def _null_space(rows: Array) -> Array:
    """(m, k) directions that rows (n, m) do not see."""
    if not len(rows):
        return np.eye(rows.shape[1])
    # The triangular factor has the singular values and directions of the tall matrix.
    _, values, directions = np.linalg.svd(np.linalg.qr(rows, mode="r"))
    values = np.concatenate([values, np.zeros(len(directions) - len(values))])
    return np.asarray(directions[values < UNRESTRAINED * values[0]].T)


def _constraint_rows(
    body: BodyDefinition, mesh: BodyMesh, driven: list[int], centre: Array, size: float
) -> Iterator[Array]:
    """Constraints (n, 3 or 6 + forces) on the rigid motion and the amplitudes of driven platens."""
    taken: Bools = np.zeros(mesh.points.shape, dtype=bool)
    for constraint in body.constraints:
        nodes = np.unique(mesh.boundaries[constraint.boundary])
        points = mesh.points[nodes]
        motions = rigid_motions((points - centre) / size)
        if constraint.roller:
            along = np.einsum("d,ndk->nk", constraint.direction, motions)
            yield np.pad(along, ((0, 0), (0, len(driven))))
            continue
        moved = [
            each.displacement(points) if each.boundary == constraint.boundary else 0 * points
            for each in (body.constraints[i] for i in driven)
        ]
        whole = np.concatenate([motions, -np.stack([*moved, 0 * points], axis=2)[..., :-1]], axis=2)
        for component in constraint.components:
            # The first constraint of a component at a node is the one that counts.
            new = ~taken[nodes, component]
            yield whole[new, component]
            taken[nodes, component] = True


def rigid_motions(points: Array) -> Array:
    """(n, gdim, k) translations and infinitesimal rotations at points (n, gdim)."""
    count, gdim = points.shape
    pairs = [(i, j) for i in range(gdim) for j in range(i + 1, gdim)]
    motions = np.zeros((count, gdim, gdim + len(pairs)))
    motions[:, range(gdim), range(gdim)] = 1.0
    for number, (i, j) in enumerate(pairs, start=gdim):
        motions[:, i, number] = -points[:, j]
        motions[:, j, number] = points[:, i]
    return motions
