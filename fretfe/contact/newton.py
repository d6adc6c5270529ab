# SPDX-License-Identifier: LGPL-3.0-or-later
"""Semi-smooth Newton method for one load step of frictional contact.

The augmented-Lagrangian conditions at a node with pressure p, shear q, gap g, increment of the
tangential displacement Δ and friction coefficient f (Alart and Curnier, 1991) are

    p = max(0, p − r g),        q = projection of q − r Δ on the disc of radius f max(0, p − r g)

The radius moves with the pressure: no lagged friction bound. In each iteration a node is open
(p = 0, q = 0), stuck (g = 0, Δ = 0) or slipping (g = 0, q = f p × direction), and the linearised
conditions are solved exactly for all nodes at once. Because the compliance is dense, a bare
iteration can throw every node into slip and cycle. Three rules prevent it:

* a step starts with every node in contact stuck;
* a node never passes from slip to slip in the opposite direction without being stuck in between;
* a node that closes takes its status from the augmented-Lagrangian formula: stuck if
  |Δ| ≤ f |g|, otherwise slipping against Δ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Interface
from fretfe.contact.state import OPEN, SLIP, STICK, ContactState, Status, StepLoads
from fretfe.contact.stick_operator import StuckOperator

MAX_ITERATIONS = 60
# Violations below this fraction of the largest traction or displacement are round-off.
ROUND_OFF = 1e-11
# So are those below this fraction of the displacements that cancel in w: bodies that move together
# leave gaps of 1e-13 of their motion (measured on meshes up to 330 000 unknowns).
CANCELLATION = 1e-12
# A motion this many times that of the stuck contact is a division by round-off: nothing resists it.
RUNAWAY = 1e7
NO_RESISTANCE = "the loads find no resistance: the contact slides or opens as a whole"
# Directions of slip (in three dimensions) are converged when they change by less than this.
DIRECTION_TOLERANCE = 1e-10
# Open nodes that the stuck operator keeps ready, as a fraction of those in contact.
MARGIN = 0.05
SMALLEST_MARGIN = 8


class NotConverged(Exception):
    """The iteration found no solution; `reason` says how it ended, in words."""

    def __init__(self, reason: str, iterations: int) -> None:
        super().__init__(reason)
        self.reason = reason
        self.iterations = iterations


@dataclass(frozen=True)
class Guess:
    """Status of the nodes in one iteration.

    Attributes:
        status: (N,) OPEN, STICK or SLIP.
        direction: (N, d-1) unit shear direction of slipping nodes, else zero.
        turning: (N,) how much a slipping node's direction resists turning, f p / |q − r Δ|; only
            used in three dimensions.
    """

    status: Status
    direction: Array
    turning: Array

    def key(self) -> bytes:
        """What two iterations have in common when they are the same."""
        return self.status.tobytes() + np.round(self.direction, 6).tobytes()


@dataclass(frozen=True)
class _Solution:
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


class _Step:
    """What stays the same in all iterations of a step.

    Attributes:
        loads: loads at the end of the step.
        free: (N, d) gap and increment Δ without tractions and coordinates.
    """

    def __init__(self, interface: Interface, loads: StepLoads, reference: Array) -> None:
        self._interface = interface
        self._operator: StuckOperator | None = None
        self._held = np.empty(0)
        self._held_motion = 0.0
        self.loads = loads
        self.free = (interface.gap + interface.loads @ loads.amplitudes).reshape(len(reference), -1)
        self.free[:, 1:] -= reference

    def held(self, operator: StuckOperator) -> tuple[Array, float]:
        """(n + m,) unknowns of the operator with every node stuck, and what they move."""
        if operator is not self._operator:
            self._operator = operator
            self._held = operator.inverse @ self._known(operator)
            coordinates = self._held[len(operator.rows) :]
            prescribed = self._interface.prescribed
            self._held_motion = self.motion(np.where(prescribed, self.loads.values, coordinates))
        return self._held, self._held_motion

    def motion(self, coordinates: Array) -> float:
        """Largest displacement of a node (length) by loads or by one coordinate."""
        d, roots = self._interface.components, self._interface.roots
        moved = np.abs(self._interface.motion * coordinates).max(axis=1, initial=0.0)
        moved = np.maximum(np.abs(self.free).ravel(), moved).reshape(-1, d).max(axis=1)
        return float((moved / roots).max())

    def _known(self, operator: StuckOperator) -> Array:
        """Right-hand side with every node of the operator stuck."""
        interface, loads = self._interface, self.loads
        forces = interface.coordinate_loads @ loads.amplitudes
        forces = forces + np.where(interface.prescribed, 0.0, loads.values)
        return np.concatenate([-self.free.ravel()[operator.rows], -forces])


class Newton:
    """Solver of load steps; keeps the stuck operator from one step to the next.

    Args:
        interface: the interface problem.
        memory: bytes for stuck operators of other contact areas, which the next history that is
            solved meets again.
    """

    def __init__(self, interface: Interface, memory: int = 0) -> None:
        self.interface = interface
        self._memory = memory
        self._operators: list[StuckOperator] = []  # the one used last stands last
        n, d = interface.size, interface.components
        self._penalty = 1 / np.diagonal(interface.compliance).reshape(n, d)[:, 1:].mean(axis=1)

    def solve(
        self, loads: StepLoads, reference: Array, status: Status, direction: Array
    ) -> tuple[ContactState, int]:
        """Solve one step.

        Args:
            loads: loads at the end of the step.
            reference: (N, d-1) tangential displacement that stuck nodes keep.
            status: (N,) status to start from.
            direction: (N, d-1) shear direction of slipping nodes.

        Returns:
            The state at the end of the step, and the number of iterations.

        Raises:
            NotConverged: if the iteration cycles, becomes singular or takes too long.
        """
        # Without friction nothing sticks: a closed node slips without resistance.
        status = np.where((status == STICK) & (loads.friction == 0), SLIP, status).astype(np.int8)
        guess = Guess(status, direction, np.where(loads.friction > 0, 1.0, 0.0))
        step = _Step(self.interface, loads, reference)
        seen: set[bytes] = set()
        for iteration in range(1, MAX_ITERATIONS + 1):
            solution = self._linear_solution(step, guess, iteration)
            following = self._update(guess, solution, loads.friction)
            turned = np.abs(following.direction - guess.direction).max()
            settled = np.array_equal(following.status, guess.status)
            if settled and turned < DIRECTION_TOLERANCE:
                return self._state(guess, solution, step, reference), iteration
            # Directions that still turn, ever less, are not a cycle.
            if not settled and following.key() in seen:
                raise NotConverged("the status of the nodes repeats in a cycle", iteration)
            seen.add(following.key())
            guess = following
        raise NotConverged(f"no solution after {MAX_ITERATIONS} iterations", MAX_ITERATIONS)

    def operator_for(self, closed: Bools, gap: Array) -> StuckOperator:
        """The stuck operator on the closed nodes and those most likely to close next."""
        nodes = np.flatnonzero(closed)
        margin = int(SMALLEST_MARGIN + MARGIN * len(nodes))
        for operator in reversed(self._operators):
            spare = len(operator.nodes) - len(nodes)
            if 0 <= spare <= 2 * margin and np.isin(nodes, operator.nodes).all():
                self._operators.remove(operator)
                self._operators.append(operator)
                return operator
        others = np.flatnonzero(~closed)
        nearest = others[np.argsort(gap[others], kind="stable")[:margin]]
        operator = StuckOperator(self.interface, np.sort(np.concatenate([nodes, nearest])))
        self._operators.append(operator)
        while sum(kept.bytes for kept in self._operators[:-1]) > self._memory:
            self._operators.pop(0)
        return operator

    def _linear_solution(self, step: _Step, guess: Guess, iteration: int) -> _Solution:
        interface, free = self.interface, step.free
        operator = self.operator_for(guess.status != OPEN, free[:, 0])
        held, held_motion = step.held(operator)
        split = len(operator.rows)
        try:
            unknowns, released = _release(
                interface, operator, guess, step.loads, held, self._penalty
            )
        except np.linalg.LinAlgError:
            raise NotConverged(NO_RESISTANCE, iteration) from None
        coordinates = unknowns[split:]
        motion = step.motion(coordinates)
        if motion > RUNAWAY * held_motion:
            raise NotConverged(NO_RESISTANCE, iteration)
        traction, relative = np.zeros(free.size), np.zeros(free.size)
        traction[operator.rows] = unknowns[:split]
        relative[operator.rows] = released
        relative[operator.others] = free.ravel()[operator.others] + operator.effect @ unknowns
        return _Solution(
            traction.reshape(free.shape), relative.reshape(free.shape), coordinates, motion
        )

    def _update(self, guess: Guess, solution: _Solution, friction: Array) -> Guess:
        """Status that the augmented-Lagrangian conditions give, with the three rules above."""
        traction, relative = solution.traction, solution.relative
        small_force, small_gap = self._cancellation(solution)
        small_force = np.maximum(small_force, ROUND_OFF * np.abs(traction).max())
        largest_gap = max(np.abs(relative).max(), np.abs(self.interface.gap).max())
        small_gap = np.maximum(small_gap, ROUND_OFF * largest_gap)
        status, direction = guess.status.copy(), guess.direction.copy()
        pressure, shear = traction[:, 0], traction[:, 1:]
        gap, increment = relative[:, 0], relative[:, 1:]
        bound = friction * np.maximum(pressure, 0.0)
        was_open, was_stuck, was_slipping = (guess.status == s for s in (OPEN, STICK, SLIP))

        slides = was_stuck & (np.linalg.norm(shear, axis=1) > bound + small_force)
        trial = shear - self._penalty[:, None] * np.where(was_slipping[:, None], increment, 0.0)
        backwards = np.einsum("ij,ij->i", increment, guess.direction) > small_gap
        status[slides] = SLIP
        turn = slides | (was_slipping & ~backwards & (friction > 0))
        direction[turn] = _unit(trial[turn])
        status[was_slipping & backwards] = STICK
        status[~was_open & (pressure < -small_force)] = OPEN

        closes = was_open & (gap < -small_gap)
        far = np.linalg.norm(increment, axis=1) > friction * np.abs(gap)
        status[closes] = np.where(far[closes] | (friction[closes] == 0), SLIP, STICK)
        direction[closes & (friction > 0)] = -_unit(increment[closes & (friction > 0)])
        direction[status != SLIP] = 0.0
        length = np.linalg.norm(trial, axis=1)
        turning = np.minimum(1.0, bound / np.where(length > 0, length, 1.0))
        return Guess(status, direction, np.where(closes & (friction > 0), 1.0, turning))

    def _cancellation(self, solution: _Solution) -> tuple[Array, Array]:
        """(N,) tractions and gaps that may be left where displacements cancel."""
        gap = CANCELLATION * solution.motion * self.interface.roots
        return self._penalty * gap, gap

    def _state(
        self, guess: Guess, solution: _Solution, step: _Step, reference: Array
    ) -> ContactState:
        interface = self.interface
        # Exactly zero, not round-off: later stages ask which nodes carry a pressure.
        nothing = np.abs(solution.traction) <= self._cancellation(solution)[0][:, None]
        nothing |= guess.status[:, None] == OPEN
        traction = np.where(nothing, 0.0, solution.traction)
        # As the displacements give it: the certificate sees what the linear solution left undone.
        relative = interface.compliance @ solution.traction.ravel()
        relative += interface.motion @ solution.coordinates
        relative = step.free + relative.reshape(step.free.shape)
        relative[:, 1:] += reference
        forces = (
            interface.stiffness @ solution.coordinates
            - interface.motion.T @ traction.ravel()
            - interface.coordinate_loads @ step.loads.amplitudes
        )
        return ContactState(
            status=guess.status,
            direction=guess.direction,
            traction=traction,
            relative=relative,
            coordinates=solution.coordinates,
            forces=forces,
        )


def _release(
    interface: Interface,
    operator: StuckOperator,
    guess: Guess,
    loads: StepLoads,
    held: Array,
    penalty: Array,
) -> tuple[Array, Array]:
    """Let go of what is open, slipping or prescribed.

    Args:
        interface: the interface problem.
        operator: stuck operator.
        guess: status of the nodes.
        loads: loads of the step.
        held: solution with everything stuck and prescribed coordinates held by their springs.
        penalty: (N,) r.

    Returns:
        (n + m,) unknowns of the operator, and (n,) the gaps and increments of its nodes: what their
        right-hand sides were changed by.
    """
    d, nodes = interface.components, operator.nodes
    status = guess.status[nodes]
    start = np.arange(len(nodes)) * d
    opened = (start[status == OPEN][:, None] + np.arange(d)).ravel()
    normal = start[status == SLIP]
    sliding = (normal[:, None] + np.arange(1, d)).ravel()
    prescribed = len(operator.rows) + np.flatnonzero(interface.prescribed)
    released = np.concatenate([opened, sliding, prescribed])
    response = operator.inverse[released].T  # the operator is symmetric; rows are contiguous
    matrix, target = response[released], -held[released]
    rows = slice(len(opened), len(opened) + len(sliding))
    slipping = nodes[status == SLIP]
    pull = (loads.friction[slipping, None] * guess.direction[slipping]).ravel()
    bound = np.repeat(normal, d - 1)
    matrix[rows] -= pull[:, None] * response[bound]
    target[rows] += pull * held[bound]
    if d > 2:
        sideways = _sideways(guess, slipping)
        free = response[sliding]
        free[np.arange(len(sliding)), np.arange(rows.start, rows.stop)] -= np.repeat(
            penalty[slipping], d - 1
        )
        matrix[rows] -= _by_node(sideways, free)
        target[rows] += _by_node(sideways, held[sliding])
    target[rows.stop :] += loads.values[interface.prescribed]
    changes = np.linalg.solve(matrix, target)
    relative = np.zeros(len(operator.rows))
    relative[released[: rows.stop]] = changes[: rows.stop]
    return held + response @ changes, relative


def _by_node(blocks: Array, values: Array) -> Array:
    """Products of (n, k, k) blocks with values (n * k, ...)."""
    parts = values.reshape(*blocks.shape[:2], *values.shape[1:])
    return np.einsum("nij,nj...->ni...", blocks, parts).reshape(values.shape)


def _sideways(guess: Guess, slipping: Indices) -> Array:
    """(n, d-1, d-1) derivative of the slip direction times the friction bound; zero in the plane.

    Blocks are f p / |q − r Δ| times the projection across the direction, so that the linearised
    condition turns the shear of a slipping node towards its slip.
    """
    across = np.eye(guess.direction.shape[1]) - np.einsum(
        "ni,nj->nij", guess.direction[slipping], guess.direction[slipping]
    )
    return guess.turning[slipping, None, None] * across


def _unit(vectors: Array) -> Array:
    """(n, k) vectors divided by their lengths; zero stays zero."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
