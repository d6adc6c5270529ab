# SPDX-License-Identifier: LGPL-3.0-or-later
"""Partial slip of many edges at once, under pressures that are known.

Between bodies whose pressure does not follow from the shear, a step of a load history is a convex
problem: the slip γ of the nodes, in two directions x and z, minimises

    γ·Kγ/2 + γ·q + Σ b_i |γ_i|

with the shear q that all stuck nodes would have, the friction bound b = f p of each node, and the
positive semi-definite change Kγ of the shear by slip. A node sticks, γ = 0 with |q| <= b, or slips
against the shear, |q| = b. Newton's method for semi-smooth equations finds which of both in two to
four iterations, here for S edges with the same nodes but other materials, bounds and loads. Nodes
outside of all contacts, which carry nothing, are eliminated before: they are the first ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices

# Newton's method gives up after so many iterations; of 10 000 steps of cycles with pressure and
# shear in and out of phase none took more than 14.
MOST_ITERATIONS = 40
# Nodes that all slip resist their motion together by this fraction of what one alone does: there is
# no solution then, but iterations must come to their end.
LEAST_RESISTANCE = 1e-13
# Shear beyond the bound by less than this fraction of it is on the bound.
ROUND_OFF = 1e-10
# Friction bound of edges that are given up.
UNBOUNDED = 1e200


@dataclass(frozen=True)
class Stiffness:
    """Change of the shear by slip on n nodes of S edges, and its share of a force.

    Attributes:
        change: (n, n) of the shear by slip in one direction between bodies of a unit compliance,
            times the length that belongs to each node.
        stiffness: (S, 2, 2) inverse compliance of the bodies to shear along x and z.
        stuck: (n,) the shear by a unit force while all nodes stick.
    """

    change: Array
    stiffness: Array
    stuck: Array

    @property
    def penalty(self) -> Array:
        """(S, n) r: resistance of a node against its own slip, in the mean of both directions."""
        mean = np.trace(self.stiffness, axis1=1, axis2=2) / 2
        return np.asarray(mean[:, None] * np.diagonal(self.change))

    def of(self, edges: Indices) -> Stiffness:
        """That of some edges."""
        return replace(self, stiffness=self.stiffness[edges])

    def behind(self, outside: int) -> tuple[Array, Array]:
        """Change of the shear behind some first nodes whose slip keeps their own shear as wanted.

        Args:
            outside: number o of these nodes.

        Returns:
            (n-o, n-o) of the shear by slip behind them, and (o, n) inverse of their own change
            times the change of their shear by slip of all.
        """
        own, mixed = self.change[:outside, :outside], self.change[:outside, outside:]
        inverse = np.linalg.solve(own, np.hstack([np.eye(outside), mixed]))
        return self.change[outside:, outside:] - mixed.T @ inverse[:, outside:], inverse


@dataclass(frozen=True)
class Bound:
    """Friction bounds of S edges.

    Attributes:
        friction: (S, n) coefficient.
        lost: (S,) edges that are given up: nothing slips, and nothing is told of them.
    """

    friction: Array
    lost: Bools

    def of(self, pressure: Array) -> Array:
        """(S, n) from pressures (S, n)."""
        return np.where(self.lost[:, None], UNBOUNDED, self.friction * pressure)


@dataclass(frozen=True)
class Slipped:
    """A solved step of S edges.

    Attributes:
        shear: (S, n, 2).
        slip: (S, n, 2) in the step, times the length that belongs to the node.
        slipping: (S, n) nodes that slip, or carry nothing.
        unsolved: (k,) edges that did not converge.
    """

    shear: Array
    slip: Array
    slipping: Bools
    unsolved: Indices


def partial_slip(
    stiffness: Stiffness, bound: Array, stuck: Array, before: Bools, tolerance: float
) -> Slipped:
    """Solve a step.

    Args:
        stiffness: of the bodies.
        bound: (S, n) f p; nodes with none carry nothing.
        stuck: (S, n, 2) shear if no node slips in the step.
        before: (S, n) nodes that slipped in the step before: a first guess.
        tolerance: error of the shear.
    """
    shear, slip, trial = stuck.copy(), np.zeros_like(stuck), stuck.copy()
    # Of the outermost nodes some may have so little pressure that nothing is left to be solved.
    free, edge = bound <= tolerance, bound * (1 + ROUND_OFF) + tolerance
    slipping = free | before | (_length(trial) > edge)
    # Not all nodes: nothing resists their common slip.
    outside = int(np.argmin(np.append(free.all(axis=0)[:-1], False)))
    behind = stiffness.behind(outside)
    remaining = np.arange(len(stuck))
    for _ in range(MOST_ITERATIONS):
        now, own = slipping[remaining], stiffness.of(remaining)
        count = int(np.max(np.flatnonzero(now.any(axis=0)), initial=0)) + 1  # behind it all stick
        now, b = now[:, :count], bound[remaining, :count]
        direction = unit(trial[remaining, :count])
        turning = _turning(trial[remaining, :count], direction, b, free[remaining, :count])
        found = _slip(own, behind, now, b, stuck[remaining, :count], direction, turning)
        q = stuck[remaining]
        stiffer = found @ own.stiffness  # which is symmetric
        for axis in (0, 1):
            q[..., axis] += stiffer[..., axis] @ stiffness.change[:count]
        ahead = q.copy()
        ahead[:, :count] -= own.penalty[:, :count, None] * found
        excess = _length(ahead) > bound[remaining]
        limited = bound[remaining][..., None] * unit(ahead)
        residual = np.abs(q - np.where(excess[..., None], limited, ahead)).max(axis=(1, 2))
        shear[remaining], slip[remaining] = q, 0.0
        slip[remaining, :count] = found
        # What would slip along its shear sticks first: from one direction straight to the opposite
        # one iterations may run in circles.
        backward = np.zeros(q.shape[:2], dtype=bool)
        along = np.sum(found * direction, axis=-1) > 0
        backward[:, :count] = now & along & ~free[remaining, :count]
        slipping[remaining] = free[remaining] | (_length(ahead) > edge[remaining]) & ~backward
        trial[remaining] = np.where(backward[..., None], q, ahead)
        remaining = remaining[residual >= tolerance]
        if not len(remaining):
            break
    return Slipped(shear, slip, slipping, remaining)


def _turning(trial: Array, direction: Array, bound: Array, free: Bools) -> Array:
    """(3, S, k) derivative of the shear on the bound by the trial shear: its xx, zz and xz."""
    length = _length(trial)
    share = np.where(free, 0.0, np.minimum(1.0, bound / np.where(length > 0, length, 1.0)))
    x, z = direction[..., 0], direction[..., 1]
    return np.asarray(share * np.array([1 - x**2, 1 - z**2, -x * z]))


def _slip(
    stiffness: Stiffness, behind: tuple[Array, Array], slipping: Bools, bound: Array, stuck: Array,
    direction: Array, turning: Array,
) -> Array:  # fmt: skip
    """(S, k, 2) slip that brings the shear of the slipping nodes to the linearised bound."""
    (change, inverse), outside = behind, len(behind[1])
    # What carries nothing has its bound as its shear, whatever slips behind it.
    wanted = bound[:, :outside, None] * direction[:, :outside] - stuck[:, :outside]
    passed_on = inverse[:, outside : slipping.shape[1]]
    inner = slice(outside, None)
    found = np.empty(stuck.shape)
    found[:, inner] = _linearised(
        stiffness.stiffness, change, stiffness.penalty[:, outside : slipping.shape[1]],
        slipping[:, inner], bound[:, inner], stuck[:, inner] + passed_on.T @ wanted,
        direction[:, inner], turning[:, :, inner],
    )  # fmt: skip
    stiffer = found[:, inner] @ stiffness.stiffness
    free = inverse[:, :outside] @ wanted - passed_on @ stiffer
    found[:, :outside] = np.linalg.solve(stiffness.stiffness, free.swapaxes(1, 2)).swapaxes(1, 2)
    return found


def _linearised(
    stiffness: Array, change: Array, resistance: Array, slipping: Bools, bound: Array,
    stuck: Array, direction: Array, turning: Array,
) -> Array:  # fmt: skip
    """(S, k, 2) the same of nodes that are not eliminated, k of them.

    Args:
        stiffness: (S, 2, 2) as of `Stiffness`.
        change: (n, n) of the shear by slip.
        resistance: (S, k) as `Stiffness.penalty`.
        slipping: (S, k).
        bound: (S, k).
        stuck: (S, k, 2).
        direction: (S, k, 2).
        turning: (3, S, k).
    """
    edges, count = slipping.shape
    slips, (xx, zz, xz) = slipping.astype(float), turning
    held = slips * np.array([[1 - xx, -xz], [-xz, 1 - zz]])
    shares = np.einsum("acsk,scb->absk", held, stiffness)
    matrix = np.empty((edges, 2, count, 2, count))
    for row, column in np.ndindex(2, 2):
        within = change[:count, :count]
        np.multiply(shares[row, column][..., None], within, out=matrix[:, row, :, column])
    node, penalty = np.arange(count), slips * resistance
    least = LEAST_RESISTANCE * penalty
    matrix[:, 0, node, 0, node] += penalty * xx + least + 1 - slips
    matrix[:, 1, node, 1, node] += penalty * zz + least + 1 - slips
    matrix[:, 0, node, 1, node] += penalty * xz
    matrix[:, 1, node, 0, node] += penalty * xz
    wanted = bound[..., None] * direction - stuck
    wanted[..., 0] += xx * stuck[..., 0] + xz * stuck[..., 1]
    wanted[..., 1] += xz * stuck[..., 0] + zz * stuck[..., 1]
    right = (slips[..., None] * wanted).transpose(0, 2, 1).reshape(edges, 2 * count, 1)
    solved = np.linalg.solve(matrix.reshape(edges, 2 * count, 2 * count), right)
    return np.asarray(solved.reshape(edges, 2, count).transpose(0, 2, 1))


def _length(vectors: Array) -> Array:
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))


def unit(vectors: Array) -> Array:
    """(..., 2) vectors divided by their lengths; zero stays zero."""
    length = _length(vectors)[..., None]
    return np.asarray(vectors / np.where(length > 0, length, 1.0))
