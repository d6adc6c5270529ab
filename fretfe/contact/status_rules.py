# SPDX-License-Identifier: LGPL-3.0-or-later
"""Status of the contact nodes from one Newton iteration to the next.

The augmented-Lagrangian conditions at a node with pressure p, shear q, gap g, increment of the
tangential displacement Δ and friction coefficient f (Alart and Curnier, 1991) are

    p = max(0, p − r g),        q = projection of q − r Δ on the disc of radius f max(0, p − r g)

Because the compliance is dense, an iteration that follows them alone can throw every node into slip
and cycle. Three rules prevent it:

* a step starts with every node in contact stuck;
* a node never passes from slip to slip in the opposite direction without being stuck in between;
* a node that closes takes its status from the augmented-Lagrangian formula: stuck if
  |Δ| ≤ f |g|, otherwise slipping against Δ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.contact.interface import Interface
from fretfe.contact.state import OPEN, SLIP, STICK, Status

# Violations below this fraction of the largest traction or displacement are round-off.
ROUND_OFF = 1e-11
# So are those below this fraction of the displacements that cancel in w: bodies that move together
# leave gaps of 1e-13 of their motion (measured on meshes up to 330 000 unknowns).
CANCELLATION = 1e-12


@dataclass(frozen=True)
class Guess:
    """Status of the nodes in one iteration.

    Attributes:
        status: (N,) OPEN, STICK or SLIP.
        direction: (N, d-1) unit shear direction of slipping nodes, else zero.
        turning: (N,) resistance of a slipping node's direction to turning, f p / |q − r Δ|; only
            used in three dimensions.
    """

    status: Status
    direction: Array
    turning: Array

    @property
    def closed(self) -> Bools:
        """(N,) nodes in contact."""
        return self.status != OPEN

    def key(self) -> bytes:
        """Equal for two iterations with the same status and directions."""
        return self.status.tobytes() + np.round(self.direction, 6).tobytes()


@dataclass(frozen=True)
class LinearSolution:
    """Solution of the conditions linearised at a guess.

    Attributes:
        traction: (N, d) y.
        relative: (N, d) gap and increment Δ; where they are released or stuck as the linearised
            conditions have it, not as the bodies' displacements give it.
        coordinates: (m,) c.
        motion: largest of the displacements (lengths, not weighted) that add up to `relative`.
    """

    traction: Array
    relative: Array
    coordinates: Array
    motion: float


class StatusRules:
    """The conditions and rules of the module's docstring for one interface problem.

    Attributes:
        penalty: (N,) r: the stiffness of the bodies against the shear of one node.
    """

    def __init__(self, interface: Interface) -> None:
        nodal = interface.compliance.diagonal.reshape(interface.size, interface.components)
        self.penalty = 1 / nodal[:, 1:].mean(axis=1)
        self._largest_gap = np.abs(interface.gap).max()
        self._roots = interface.roots

    def cancellation(self, motion: float) -> tuple[Array, Array]:
        """(N,) tractions and gaps that may remain where displacements of a size cancel."""
        gap = CANCELLATION * motion * self._roots
        return self.penalty * gap, gap

    def following(self, guess: Guess, solution: LinearSolution, friction: Array) -> Guess:
        """Status and directions by which the next iteration linearises.

        Args:
            guess: status in this iteration.
            solution: its solution.
            friction: (N,) coefficient.
        """
        small_force, small_gap = self._round_off(solution)
        pressure, shear = solution.traction[:, 0], solution.traction[:, 1:]
        gap, increment = solution.relative[:, 0], solution.relative[:, 1:]
        bound = friction * np.maximum(pressure, 0.0)
        was_open, was_stuck, was_slipping = (guess.status == s for s in (OPEN, STICK, SLIP))

        status = guess.status.copy()
        slides = was_stuck & (lengths(shear) > bound + small_force)
        trial = shear - self.penalty[:, None] * np.where(was_slipping[:, None], increment, 0.0)
        length = lengths(trial)
        backwards = was_slipping & (dot(increment, guess.direction) > small_gap)
        turn = slides | (was_slipping & ~backwards & (friction > 0))
        direction = np.where(turn[:, None], _unit(trial, length), guess.direction)
        status[slides] = SLIP
        status[backwards] = STICK
        status[~was_open & (pressure < -small_force)] = OPEN
        turning = np.minimum(1.0, bound / np.where(length > 0, length, 1.0))

        closes = was_open & (gap < -small_gap)
        if closes.any():
            moved = lengths(increment)
            far = (moved > friction * np.abs(gap)) | (friction == 0)
            status[closes] = np.where(far[closes], SLIP, STICK)
            held_back = closes & (friction > 0)
            direction[held_back] = -_unit(increment, moved)[held_back]
            turning[held_back] = 1.0
        direction[status != SLIP] = 0.0
        return Guess(status, direction, turning)

    def _round_off(self, solution: LinearSolution) -> tuple[Array, Array]:
        """(N,) tractions and gaps that count as zero."""
        small_force, small_gap = self.cancellation(solution.motion)
        largest_gap = max(np.abs(solution.relative).max(), self._largest_gap)
        return (
            np.maximum(small_force, ROUND_OFF * np.abs(solution.traction).max()),
            np.maximum(small_gap, ROUND_OFF * largest_gap),
        )


def lengths(vectors: Array) -> Array:
    """(n,) lengths of vectors (n, k); for few vectors faster than `np.linalg.norm`."""
    return np.sqrt(dot(vectors, vectors))


def dot(first: Array, second: Array) -> Array:
    """(n,) products of vectors (n, k) with each other."""
    return np.asarray(np.einsum("ij,ij->i", first, second))


def _unit(vectors: Array, length: Array) -> Array:
    """(n, k) vectors divided by their lengths; zero stays zero."""
    return vectors / np.where(length > 0, length, 1.0)[:, None]
