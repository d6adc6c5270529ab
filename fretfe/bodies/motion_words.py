# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rigid motions in words: along which directions, about which axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.surface.checks import place

# Components of a motion below this fraction of the largest are round-off.
ROUND_OFF = 1e-9
# The same for motions in space, which are told apart by their turning.
TURNING = 1e-6


@dataclass(frozen=True)
class RigidMotions:
    """Rigid motions that some bodies are free to make.

    Attributes:
        motions: (3 or 6, k) in the order of `rigid_motions`, for lengths over `size`.
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


def in_words(free: RigidMotions) -> str:
    """All motions, in words that follow "is free"."""
    if free.count == len(free.motions):
        return "to move in every direction and to turn"
    return _in_space(free) if len(free.motions) == 6 else _in_plane(free)


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
    fixed = free.centre + free.size * np.array([-motion[1], motion[0]]) / motion[2]
    return f"to turn about {place(fixed, 4)}"


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
