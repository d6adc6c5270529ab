# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid motions that no support prevents, found from the geometry alone, and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.constraints import Constraint
from fretfe.bodies.cyclic import SAME, Tie
from fretfe.bodies.definition import BodyDefinition, ModelDefinition, define_model
from fretfe.bodies.free_motions import (
    TURNING,
    RigidMotions,
    constraint_rows,
    free_motions,
    null_space,
)
from fretfe.case import Case
from fretfe.contact.interface import Coordinate
from fretfe.errors import CaseError, ModelError
from fretfe.fields.rigid_motions import rigid_motions
from fretfe.mesh.mesh import BodyMesh, Mesh, place_text
from fretfe.mesh.pieces import connected_groups, point_pieces
from fretfe.surface.checks import place
from fretfe.surface.surface import boundary_surface

# Components of a motion below this fraction of the largest are round-off.
ROUND_OFF = 1e-9


def in_words(free: RigidMotions) -> str:
    """All motions, in words that follow "is free"."""
    if free.count == len(free.motions):
        return "to move in every direction and to turn"
    if len(free.motions) == 3:
        return _in_plane(free)
    return _in_space(_completed(free) if len(free.motions) == 4 else free)


def _completed(free: RigidMotions) -> RigidMotions:
    """Motions of plane bodies with displacements along z, as those in space."""
    motions = np.zeros((6, free.count))
    motions[:4] = free.motions
    return RigidMotions(motions, np.append(free.centre, 0.0), free.size)


def _in_plane(free: RigidMotions) -> str:
    motions = free.motions
    if free.count == 1:
        return _one_in_plane(motions[:, 0], free)
    if not (np.abs(motions[2]) > ROUND_OFF).any():
        return "to move in every direction"
    # A pure translation is left over from two motions that turn the body.
    mixed = motions @ np.array([motions[2, 1], -motions[2, 0]])
    return f"{_one_in_plane(mixed, free)} and to turn"


def _one_in_plane(motion: Array, free: RigidMotions) -> str:
    """Along a direction, or about the point that stays in its place."""
    if abs(motion[2]) <= ROUND_OFF * np.abs(motion).max():
        return f"to move along {_direction(motion[:2])}"
    # u = (a - c y, b + c x) vanishes at x = -b/c, y = a/c
    return f"to turn about {_place(np.array([-motion[1], motion[0]]) / motion[2], free)}"


def _in_space(free: RigidMotions) -> str:
    moves, turns = _separated(free.motions)
    words = []
    if len(moves) == 3:
        words.append("to move in every direction")
    elif len(moves):
        words.append(f"to move along {' and '.join(map(_direction, moves))}")
    if len(turns):
        words.append(f"to turn about {_axes(turns, moves, free)}")
    return " and ".join(words)


def _separated(motions: Array) -> tuple[Array, Array]:
    """Directions (a, 3) of pure translations; (b, 6) other motions: at the centre, and turning."""
    # The order of `rigid_motions` is that of the planes xy, xz, yz.
    turning = np.stack([motions[5], -motions[4], motions[3]])
    _, values, combinations = np.linalg.svd(turning)
    rank = int(np.sum(values > TURNING))
    moves = _echelon((motions[:3] @ combinations[rank:].T).T)
    both = _echelon((np.vstack([turning, motions[:3]]) @ combinations[:rank].T).T)
    turns = np.hstack([both[:, 3:], both[:, :3]])
    # Translations that are free anyway say nothing about an axis.
    basis, _ = np.linalg.qr(moves.T)
    turns[:, :3] -= turns[:, :3] @ basis @ basis.T
    return moves, turns


def _echelon(rows: Array) -> Array:
    """Combinations of rows (n, ≥ 3) along the axes if there are such, by their first 3 columns."""
    rows, done = rows.copy(), 0
    for column in range(3):
        if done == len(rows):
            break
        best = done + int(np.abs(rows[done:, column]).argmax())
        if abs(rows[best, column]) > TURNING:
            rows[[done, best]] = rows[[best, done]]
            rows[done] /= rows[done, column]
            others = np.arange(len(rows)) != done
            rows[others] -= np.outer(rows[others, column], rows[done])
            done += 1
    return rows


def _axes(turns: Array, moves: Array, free: RigidMotions) -> str:
    """Axes of motions, each with a point on it if it has a place."""
    axes = [_direction(turn[3:]) for turn in turns]
    every = "every axis" if len(turns) == 3 else " and ".join(axes)
    if np.linalg.norm(np.cross(turns[:, None, 3:], moves), axis=2).max(initial=0.0) > TURNING:
        return every
    point = _fixed_point(turns)
    if point is not None:
        return f"{every} through {_place(point, free)}"
    return " and about ".join(
        _one_axis(axis, turn, free) for axis, turn in zip(axes, turns, strict=True)
    )


def _one_axis(axis: str, turn: Array, free: RigidMotions) -> str:
    move, turning = turn[:3], turn[3:]
    along = turning * (move @ turning) / (turning @ turning)
    point = _fixed_point(np.concatenate([move - along, turning])[None])
    assert point is not None
    screw = ", moving along it" if np.abs(along).max() > TURNING else ""
    return f"{axis} through {_place(point, free)}{screw}"


def _fixed_point(turns: Array) -> Array | None:
    """(3,) the point nearest to the centre that no motion moves; None if there is none."""
    # u = t + ω × x: the columns of the matrix are ω × e.
    matrix = np.concatenate([np.cross(turn[3:], np.eye(3)).T for turn in turns])
    moved = turns[:, :3].ravel()
    point = np.linalg.lstsq(matrix, -moved, rcond=TURNING)[0]
    return point if np.abs(matrix @ point + moved).max() < TURNING else None


def _place(point: Array, free: RigidMotions) -> str:
    rounded = np.where(np.abs(point) < TURNING, 0.0, point)
    fixed = free.centre + free.size * rounded
    return place(np.where(np.abs(fixed) < TURNING * free.size, 0.0, fixed), 4)


def _direction(vector: Array) -> str:
    """The name of an axis, or components of which the largest is 1."""
    vector = vector / vector[np.abs(vector).argmax()]
    vector[np.abs(vector) < ROUND_OFF] = 0.0
    if np.count_nonzero(vector) == 1:
        return "xyz"[int(np.flatnonzero(vector)[0])]
    return f"({', '.join(f'{value:.3g}' for value in vector)})"


def held_model(case: Case, mesh: Mesh) -> ModelDefinition:
    """Definition of a model that cannot move as a whole.

    Raises:
        ModelError: if a body has no contact surface, or nothing holds the bodies or their pieces.
        CaseError: as `define_model`, and if both sides of a sector are not constrained alike.
    """
    definition = _with_held_sector(case, define_model(case, mesh), mesh)
    for body in definition.bodies:
        if body.tie is not None:
            _require_alike(case, body, body.tie, mesh.bodies[body.name])
        if mesh.bodies[body.name].pieces > 1:
            _require_held_pieces(body, mesh.bodies[body.name])
    _require_restraint(case, definition, mesh)
    return definition


def _with_held_sector(case: Case, definition: ModelDefinition, mesh: Mesh) -> ModelDefinition:
    """Hold sectors that nothing keeps from turning about their axis, each at one node.

    Loads that balance do not turn them: the node exerts no force then.
    """
    for group in joined(case, definition):
        body = next((each for each in group if each.tie is not None), None)
        if body is None or body.tie is None:
            continue
        tie, others = body.tie, [each for each in group if each is not body]
        point = tie.leaders[np.linalg.norm(tie.from_axis(tie.leaders), axis=1).argmax()]
        # Corners of elements come first, and one is at the end of a side.
        constraint = Constraint(
            f"{body.name} rotation",
            tie.source,
            tuple(tie.tangential(point[None])[0].tolist()),
            roller=True,
            at=tuple(point.tolist()),
            within=SAME * tie.size,
        )
        held = replace(
            body,
            constraints=(*body.constraints, constraint),
            coordinates=(*body.coordinates, Coordinate(constraint.label, body.name, "fixed", "")),
        )
        if free_motions([[held, *others]], mesh).count < free_motions([group], mesh).count:
            bodies = tuple(held if each is body else each for each in definition.bodies)
            definition = replace(definition, bodies=bodies)
    return definition


def _require_alike(case: Case, body: BodyDefinition, tie: Tie, mesh: BodyMesh) -> None:
    """Check that both sides of a sector are constrained alike, and end away from contacts.

    Raises:
        CaseError: names the boundary at which they are not.
    """
    degree = case.model.degree
    for name in body.surfaces:
        points = boundary_surface(mesh, name).displacement_points(degree)
        sides = (tie.followers, tie.leaders, tie.on_axis)
        if any(tie.among(side, points).any() for side in sides):
            raise CaseError(
                f"{case.source}: expected sides of the sector that are nowhere at a contact, found "
                f"the contact surface {name!r} of {body.name!r} at one of them: cut the sector "
                "where nothing touches"
            )
    names = dict.fromkeys(each.boundary for each in body.constraints if not each.at)
    for name in names:
        points = boundary_surface(mesh, name).displacement_points(degree)
        own = [
            (constraint, coordinate)
            for constraint, coordinate in zip(body.constraints, body.coordinates, strict=True)
            if constraint.boundary == name
        ]
        if (why := _unlike(own, tie, points)) is not None:
            raise CaseError(
                f"{case.source}: expected the boundary {name!r}, which is at a side of the sector "
                f"of {body.name!r}, to be held or moved alike in all sectors, found {why}"
            )


def _unlike(
    constraints: Sequence[tuple[Constraint, Coordinate]], tie: Tie, points: Array
) -> str | None:
    """The difference between both sides, in words; None if they are alike.

    Args:
        constraints: of one boundary.
        tie: of the sides.
        points: (n, d) of the nodes of the boundary.
    """
    at_followers, at_leaders = (tie.among(s, points) for s in (tie.followers, tie.leaders))
    at_axis = tie.among(tie.on_axis, points).any()
    shares = abs(tie.weights)
    share = (shares @ at_leaders) / shares.sum(axis=1).A1
    if ((share > 1 - SAME) != at_followers).any():
        return "it at one side only"
    rows = [np.zeros((0, len(tie.turn)))]
    rows += [
        np.array(each.direction)[None] if each.roller else np.eye(len(tie.turn))[each.components]
        for each, _ in constraints
        if each.around is None
    ]
    held = np.linalg.pinv(np.concatenate(rows)) @ np.concatenate(rows)
    if at_followers.any() and np.abs(tie.turn @ held @ tie.turn.T - held).max() > SAME:
        return "a direction that does not turn with the sectors"
    for constraint, coordinate in constraints:
        if coordinate.control == "fixed" or constraint.roller:
            continue
        moved = constraint.displacement(tie.leaders)
        off = (constraint.displacement(tie.followers) - tie.image(moved))[at_followers]
        off_axis = constraint.displacement(tie.on_axis) @ tie.across.T
        largest = max(np.abs(off).max(initial=0.0), np.abs(off_axis).max(initial=0.0) * at_axis)
        if largest > SAME * max(1.0, np.abs(moved).max()):
            return f"that {constraint.label} moves it in a direction that does not turn with them"
    return None


def _require_held_pieces(body: BodyDefinition, mesh: BodyMesh) -> None:
    """Check that no piece of a body can move by itself: contact holds bodies, not their pieces.

    Raises:
        ModelError: names the first piece that can, and how.
    """
    labels = _tied_pieces(body, mesh)
    count = int(labels.max()) + 1
    for number in range(count) if count > 1 else ():
        own = {
            name: facets[labels[facets[:, 0]] == number] for name, facets in mesh.boundaries.items()
        }
        points = mesh.points[labels == number]
        centre, size = points.mean(axis=0), float(np.ptp(points, axis=0).max())
        piece = replace(mesh, boundaries=own)
        rows = [np.zeros((0, rigid_motions(points[:1], body.components).shape[2]))]
        rows += constraint_rows(body, piece, [], centre, size)
        motions = null_space(np.concatenate(rows))
        if motions.shape[1]:
            named = ", ".join(name for name, facets in own.items() if len(facets)) or "none"
            raise ModelError(
                f"piece {number + 1} of {count} of the body {body.name!r}, around "
                f"{place_text(centre)} with the boundaries {named}, is not joined to the others "
                f"and free {in_words(RigidMotions(motions, centre, size))}. Expected supports or "
                "a platen that hold it, a mesh in which it is joined to the others, or a body of "
                "its own"
            )


def _tied_pieces(body: BodyDefinition, mesh: BodyMesh) -> Indices:
    """(n,) number of the piece that each node is in, where pieces that are tied are one."""
    labels = point_pieces(mesh)
    if body.bond is None:
        return labels
    ends = [
        np.unique(labels[mesh.boundaries[side]])
        for pair in zip(*body.bond.groups, strict=True)
        for side in pair
    ]
    first = np.concatenate([np.full(len(each), own[0]) for own, other in zip(ends[::2], ends[1::2],
                            strict=True) for each in (own, other)])  # fmt: skip
    return connected_groups(mesh.pieces, first, np.concatenate(ends))[labels]


def modes_restrained_by_contact(definition: ModelDefinition, mesh: Mesh) -> dict[str, str]:
    """Rigid-body modes restrained only by contact, in words, for each body that has some.

    Supports and prescribed displacements restrain their boundary. A platen restrains it too, but
    for the directions in which a force acts on it.
    """
    found: dict[str, str] = {}
    for body in definition.bodies:
        free = free_motions([[body]], mesh)
        if free.count:
            found[body.name] = in_words(free)
    return found


def _require_restraint(case: Case, definition: ModelDefinition, mesh: Mesh) -> None:
    """Check that bodies whose contacts are stuck cannot move rigidly.

    Raises:
        ModelError: names the bodies that could still move, and how.
    """
    for bodies in joined(case, definition):
        free = free_motions([bodies], mesh)
        if not free.count:
            continue
        names = sorted(body.name for body in bodies)
        hint = f" A force holds nothing: {', '.join(free.pushed)}." if free.pushed else ""
        raise ModelError(
            f"nothing holds {' and '.join(repr(name) for name in names)}: even if every contact "
            f"were stuck, {'they' if names[1:] else 'it'} would be free {in_words(free)}. Expected "
            "supports, or a platen under displacement control, that hold at least one body against "
            f"every translation and rotation.{hint}"
        )


def joined(
    case: Case, definition: ModelDefinition, *, rough: bool = False
) -> list[list[BodyDefinition]]:
    """Bodies that would move as one if every contact, or every rough one, were stuck."""
    bodies = definition.bodies
    owner = {surface: number for number, body in enumerate(bodies) for surface in body.surfaces}
    held = [c for c in case.contacts.values() if c.rough or not rough]
    ends = np.array([[owner[c.surface1], owner[c.surface2]] for c in held], dtype=np.int64)
    labels = connected_groups(len(bodies), *ends.reshape(-1, 2).T)
    return [[bodies[i] for i in np.flatnonzero(labels == part)] for part in range(labels.max() + 1)]
