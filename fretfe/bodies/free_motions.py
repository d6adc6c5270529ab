# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid motions that supports, platens, sides of sectors and seats leave to bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import compress

import numpy as np
from scipy import linalg

from fretfe._typing import Array, Bools
from fretfe.bodies.definition import BodyDefinition
from fretfe.fields.rigid_motions import rigid_motions
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.surface import Surface

# Components of a motion in space below this fraction of the largest are round-off: such motions
# are told apart by their turning.
TURNING = 1e-6
# Singular values below this fraction of the largest belong to modes that no constraint restrains: a
# restrained one moves constrained nodes by about one.
UNRESTRAINED = TURNING
# A force drives a motion if that moves its platen by this fraction of the body's displacement.
DRIVEN = 0.01


@dataclass(frozen=True)
class RigidMotions:
    """Rigid motions that some bodies are free to make.

    Attributes:
        motions: (3, 4 or 6, k) in the order of `rigid_motions`, for lengths over `size`.
        centre: (gdim,) the origin of these lengths.
        size: of the bodies.
    """

    motions: Array
    centre: Array
    size: float

    @property
    def count(self) -> int:
        """Number of independent motions."""
        return int(self.motions.shape[1])


@dataclass(frozen=True)
class Freedom(RigidMotions):
    """Motions that nothing resists, `motions` those of each group of bodies one below the other.

    Attributes:
        pushed: labels of the forces that drive some of them.
        platens: (k,) amplitudes of the platens of all forces in the motions, by label.
    """

    pushed: list[str]
    platens: dict[str, Array]


@dataclass(frozen=True)
class Seat:
    """A surface on which bodies slide without parting from those opposite.

    Attributes:
        surface: with the normals across which they do not move against each other.
        bodies: names of both.
    """

    surface: Surface
    bodies: tuple[str, str]

    def across(self, centre: Array, size: float, components: int) -> Array:
        """(n, k) rigid motions across the surface, about a centre, for lengths over a size."""
        dimension = self.surface.dimension
        nodes, normals = (
            each.reshape(-1, dimension) for each in (self.surface.nodes, self.surface.normals)
        )
        motions = rigid_motions((nodes - centre) / size, components)[:, :dimension]
        return np.asarray(np.einsum("nd,ndk->nk", normals, motions))


def free_motions(
    groups: Sequence[Sequence[BodyDefinition]], mesh: Mesh, seats: Sequence[Seat] = ()
) -> Freedom:
    """Unrestrained motions of groups of bodies, each of which moves as one.

    Args:
        groups: of bodies that move.
        mesh: of all bodies.
        seats: surfaces on which they slide, if at all; bodies of no group stay where they are.
    """
    owner = {body.name: number for number, group in enumerate(groups) for body in group}
    points = np.concatenate([mesh.bodies[name].points for name in owner])
    centre, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
    components, columns = groups[0][0].components, np.eye(len(groups))
    count = rigid_motions(points[:1], components).shape[2]
    parts, forces, labels = [np.zeros((0, len(groups) * count))], [], []
    for body in (each for group in groups for each in group):
        driven = [
            i for i, each in enumerate(body.coordinates)
            if each.control == "force" and not body.constraints[i].overlap
        ]  # fmt: skip
        labels += [body.coordinates[i].label for i in driven]
        rows = [np.zeros((0, count + len(driven)))]
        rows += constraint_rows(body, mesh.bodies[body.name], driven, centre, size)
        if body.tie is not None:
            tied = body.tie.violation(
                lambda points: rigid_motions((points - centre) / size, components)
            )
            rows.append(np.pad(tied, ((0, 0), (0, len(driven)))))
        own, by_force = np.split(np.concatenate(rows), [count], axis=1)
        parts.append(np.kron(columns[owner[body.name]], own))
        forces.append(by_force)
    for seat in seats:
        one, other = (columns[owner[name]] if name in owner else 0.0 for name in seat.bodies)
        parts.append(np.kron(one - other, seat.across(centre, size, components)))
    held, by_force = np.concatenate(parts), linalg.block_diag(*forces)
    by_force = np.pad(by_force, ((0, len(held) - len(by_force)), (0, 0)))
    # A unit of each coordinate moves its platen by one at most.
    units = np.maximum(np.abs(by_force).max(axis=0, initial=1e-300), 1e-300)
    directions = null_space(np.hstack([held, by_force / units]))
    motions, amplitudes = np.split(directions, [len(held.T)])
    amplitudes[np.abs(amplitudes) < TURNING] = 0.0
    moving = np.abs(amplitudes).max(axis=1, initial=0.0) > DRIVEN
    pushed = list(compress(labels, moving))
    platens = dict(zip(labels, amplitudes / units[:, None], strict=True))
    return Freedom(motions, centre, size, pushed, platens)


def null_space(rows: Array) -> Array:
    """(m, k) directions that rows (n, m) do not see."""
    if not len(rows):
        return np.eye(rows.shape[1])
    # The triangular factor has the singular values and directions of the tall matrix.
    _, values, directions = np.linalg.svd(np.linalg.qr(rows, mode="r"))
    values = np.concatenate([values, np.zeros(len(directions) - len(values))])
    return np.asarray(directions[values < UNRESTRAINED * values[0]].T)


def constraint_rows(
    body: BodyDefinition, mesh: BodyMesh, driven: list[int], centre: Array, size: float
) -> Iterator[Array]:
    """Constraints (n, 3, 4 or 6 + forces) on the rigid motion and the amplitudes of platens."""
    taken: Bools = np.zeros((len(mesh.points), body.components), dtype=bool)
    for constraint in body.constraints:
        if constraint.overlap:
            continue
        nodes = np.unique(mesh.boundaries[constraint.boundary])
        nodes = nodes[constraint.holds(mesh.points[nodes])]
        points = mesh.points[nodes]
        motions = rigid_motions((points - centre) / size, body.components)
        if constraint.roller:
            along = np.einsum("nd,ndk->nk", constraint.along(points), motions)
            yield np.pad(along, ((0, 0), (0, len(driven))))
            continue
        rest = 0 * motions[..., 0]
        moved = [
            each.displacement(points) if each.boundary == constraint.boundary else rest
            for each in (body.constraints[i] for i in driven)
        ]
        whole = np.concatenate([motions, -np.stack([*moved, rest], axis=2)[..., :-1]], axis=2)
        for component in constraint.components:
            # The first constraint of a component at a node is the one that counts.
            new = ~taken[nodes, component]
            yield whole[new, component]
            taken[nodes, component] = True
