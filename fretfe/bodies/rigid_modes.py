# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid-body modes restrained only by contact, found from the geometry alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fretfe._typing import Array
from fretfe.bodies.definition import BodyDefinition, ModelDefinition
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.checks import place

# Singular values below this fraction of the largest belong to modes that no constraint restrains: a
# restrained one moves constrained nodes by about one.
UNRESTRAINED = 1e-6
# Components of a motion below this fraction of the largest are round-off.
ROUND_OFF = 1e-9


def modes_restrained_by_contact(definition: ModelDefinition, mesh: Mesh) -> dict[str, str]:
    """Rigid-body modes restrained only by contact, in words, for each body that has some.

    Supports and prescribed displacements restrain their boundary. A platen restrains it too, but
    for the directions in which a force acts on it. In space they are counted only.
    """
    found: dict[str, str] = {}
    for body in definition.bodies:
        own = mesh.bodies[body.name]
        motions = _modes(body, own)
        if motions.shape[1]:
            found[body.name] = _in_words(motions, own)
    return found


def _centre_and_size(body: BodyMesh) -> tuple[Array, float]:
    return body.points.mean(axis=0), float(np.ptp(body.points, axis=0).max())


def _modes(definition: BodyDefinition, body: BodyMesh) -> Array:
    """(3 or 6, k) modes in the order of `rigid_motions`, about the centre of the body."""
    count = rigid_motions(body.points[:1]).shape[2]
    driven = [i for i, c in enumerate(definition.coordinates) if c.control == "force"]
    rows = list(_constraint_rows(definition, body, driven))
    if not rows:
        return np.eye(count)
    _, values, directions = np.linalg.svd(np.array(rows))
    values = np.concatenate([values, np.zeros(len(directions) - len(values))])
    return directions[values < UNRESTRAINED * values[0], :count].T


def _constraint_rows(
    definition: BodyDefinition, body: BodyMesh, driven: list[int]
) -> Iterator[Array]:
    """Constraints (3 or 6 + forces,) on the rigid motion and the amplitudes of driven platens."""
    centre, size = _centre_and_size(body)
    holder: dict[tuple[int, int], str] = {}
    for constraint in definition.constraints:
        for node in np.unique(body.boundaries[constraint.boundary]).tolist():
            for component in constraint.components.tolist() if not constraint.roller else ():
                holder.setdefault((node, component), constraint.boundary)
    for (node, component), boundary in holder.items():
        point = body.points[[node]]
        motion = rigid_motions((point - centre) / size)[0, component]
        platen = [
            each.displacement(point)[0, component] if each.boundary == boundary else 0.0
            for each in (definition.constraints[i] for i in driven)
        ]
        yield np.concatenate([motion, -np.array(platen)])
    for constraint in definition.constraints:
        if constraint.roller:
            nodes = np.unique(body.boundaries[constraint.boundary])
            motions = rigid_motions((body.points[nodes] - centre) / size)
            along = np.einsum("d,ndk->nk", constraint.direction, motions)
            yield from np.pad(along, ((0, 0), (0, len(driven))))


def _in_words(motions: Array, body: BodyMesh) -> str:
    count = motions.shape[1]
    if count == len(motions):
        return "to move in every direction and to turn"
    if len(motions) == 6:
        return f"in {count} of its 6 rigid motions"
    turning = np.abs(motions[2]) > ROUND_OFF
    if motions.shape[1] == 2:
        return "to move in every direction" if not turning.any() else _two_motions(motions, body)
    return _one_motion(motions[:, 0], body)


def _two_motions(motions: Array, body: BodyMesh) -> str:
    """A pure translation is left over from two motions that turn the body."""
    mixed = motions @ np.array([motions[2, 1], -motions[2, 0]])
    return f"{_one_motion(mixed, body)} and to turn"


def _one_motion(motion: Array, body: BodyMesh) -> str:
    """Along a direction, or about the point that stays in its place."""
    if abs(motion[2]) <= ROUND_OFF * np.abs(motion).max():
        direction = motion[:2] / motion[np.abs(motion[:2]).argmax()]
        direction[np.abs(direction) < ROUND_OFF] = 0.0
        if np.count_nonzero(direction) == 1:
            return f"to move along {'xy'[int(np.flatnonzero(direction)[0])]}"
        return f"to move along ({direction[0]:.3g}, {direction[1]:.3g})"
    centre, size = _centre_and_size(body)
    # u = (a - c y, b + c x) vanishes at x = -b/c, y = a/c
    fixed = centre + size * np.array([-motion[1], motion[0]]) / motion[2]
    return f"to turn about {place(fixed, 4)}"


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
