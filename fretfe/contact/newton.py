# SPDX-License-Identifier: LGPL-3.0-or-later
"""Semi-smooth Newton method for one load step of frictional contact, and the slow one behind it.

In each iteration a node is open (p = 0, q = 0), stuck (g = 0, Δ = 0) or slipping (g = 0, shear on
the friction bound f p, which moves with the pressure: no lagged bound). The conditions are
linearised and solved exactly for all nodes at once, and the solution gives every node its next
status: see `fretfe.contact.state`.

Where that does not converge, a fixed point on the friction bound does: with the bound f p taken
from the last pressure, the step is a convex problem (pressures not negative, shear within a fixed
disc), which the alternating direction method of multipliers solves from any start in any dimension.
The bound is then renewed until it settles. The result serves as a start for Newton, which makes it
exact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.contact.interface import Interface, unresisted_motions
from fretfe.contact.linear_operator import (
    Conditions,
    FactoredOperator,
    NestedArea,
    Response,
    StuckSolution,
)
from fretfe.contact.state import (
    OPEN,
    SLIP,
    STICK,
    ContactState,
    Guess,
    LinearSolution,
    Status,
    StatusRules,
    StepLoads,
)

MAX_ITERATIONS = 60
# A motion this many times that in full stick is a division by round-off: nothing resists it.
RUNAWAY = 1e7
# Loads are in equilibrium if a motion that nothing resists leaves this part of them.
EQUILIBRIUM = 1e-11
NO_RESISTANCE = "the loads find no resistance: the contact slides or opens as a whole"
# Directions of slip (in three dimensions) are converged when the shear changes by less than this
# part of its largest bound; or by less than the second, and no more by far less than before, as the
# method would without round-off.
DIRECTION_TOLERANCE = 1e-10
ROUND_OFF = 1e-7
FALLS = 0.1


class NotConverged(Exception):
    """The iteration found no solution; `reason` tells in words how it ended."""

    def __init__(self, reason: str, iterations: int) -> None:
        super().__init__(reason)
        self.reason = reason
        self.iterations = iterations


class LoadedStep:
    """Loads of a step, and the interface in full stick under them.

    Args:
        interface: the interface problem.
        loads: loads at the end of the step.
        reference: (N, d-1) tangential displacement before the step.

    Attributes:
        loads: loads at the end of the step.
        free: (N, d) gap and increment Δ without tractions and coordinates.
    """

    def __init__(self, interface: Interface, loads: StepLoads, reference: Array) -> None:
        self._interface = interface
        self._area: NestedArea | None = None
        self._stuck: StuckSolution
        self.loads = loads
        self.free = loads.without_traction(interface)
        self.free[:, 1:] -= reference
        roots = interface.roots
        self._free_motion = float((np.abs(self.free).max(axis=1) / roots).max())
        self._reach = interface.reach
        self._least_motion = self.motion(np.where(interface.prescribed, loads.values, 0.0))
        forces = interface.coordinate_loads @ loads.amplitudes
        self._forces = forces + np.where(interface.prescribed, 0.0, loads.values)

    def stuck(self, area: NestedArea) -> StuckSolution:
        """Full stick in a contact area under the loads of the step."""
        if area is not self._area:
            self._area = area
            self._stuck = area.stuck(self.free[..., None], self._forces[:, None])
        return self._stuck

    def resists(self, motion: float) -> bool:
        """Tell whether a motion is not out of all proportion to that in full stick."""
        # In full stick bodies move at least by loads and prescribed motions alone.
        if motion <= RUNAWAY * self._least_motion:
            return True
        coordinates = np.where(
            self._interface.prescribed, self.loads.values, self._stuck.coordinates[:, 0]
        )
        return motion <= RUNAWAY * self.motion(coordinates)

    def motion(self, coordinates: Array) -> float:
        """Largest displacement of a node (length) by loads or by one coordinate."""
        return float((self._reach * np.abs(coordinates)).max(initial=self._free_motion))


class Newton:
    """Solver of load steps.

    Args:
        operator: solves linear systems of the interface problem.
    """

    def __init__(self, operator: FactoredOperator) -> None:
        self._operator = operator
        self._rules = StatusRules(operator.interface)

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
        step = LoadedStep(self._operator.interface, loads, reference)
        seen: set[bytes] = set()
        before = np.inf
        for iteration in range(1, MAX_ITERATIONS + 1):
            try:
                solution = self._linear_solution(step, guess)
            except np.linalg.LinAlgError:
                raise NotConverged(NO_RESISTANCE, iteration) from None
            following = self._rules.following(guess, solution, loads.friction)
            bound = loads.friction * np.abs(solution.traction[:, 0])
            turn = np.abs(following.direction - guess.direction).max(axis=1) * bound
            turned = float(turn.max() / max(bound.max(), np.finfo(float).tiny))
            settled = np.array_equal(following.status, guess.status)
            stays = turned < DIRECTION_TOLERANCE or FALLS * before < turned < ROUND_OFF
            if settled and stays:
                return self._state(guess, solution, step, reference), iteration
            # Directions that still turn, ever less, are not a cycle.
            if not settled and following.key() in seen:
                raise NotConverged("the status of the nodes repeats in a cycle", iteration)
            seen.add(following.key())
            guess, before = following, turned if settled else np.inf
        raise NotConverged(f"no solution after {MAX_ITERATIONS} iterations", MAX_ITERATIONS)

    def _linear_solution(self, step: LoadedStep, guess: Guess) -> LinearSolution:
        """Solve the conditions linearised at a guess.

        Raises:
            numpy.linalg.LinAlgError: if the loads find no resistance.
        """
        stuck = step.stuck(self._operator.area(guess.closed, step.free[:, 0]))
        conditions = self._linearised(guess, step.loads)
        response = None
        if self._glides(guess, step.loads):
            response = stuck.release(replace(conditions, floating=True))
        if response is None or response.residual > EQUILIBRIUM:
            try:
                response = stuck.release(conditions)
            except np.linalg.LinAlgError:
                return self._least_slip(step, stuck, guess, conditions)
        solution = _solution(step, response)
        if not step.resists(solution.motion):
            return self._least_slip(step, stuck, guess, conditions)
        return solution

    def _least_slip(
        self, step: LoadedStep, stuck: StuckSolution, guess: Guess, conditions: Conditions
    ) -> LinearSolution:
        """Solve conditions under which a body slides on all sides while loads push it no way.

        A body that slips to the left on one side and to the right on the other one is in
        equilibrium at many places: it takes that to which it slips least.

        Raises:
            numpy.linalg.LinAlgError: if the loads find no resistance.
        """
        interface = self._operator.interface
        drift = self._unresisted(np.column_stack([guess.closed, guess.status == STICK]))
        slides = np.repeat(guess.status == SLIP, interface.components - 1)
        sliding = (interface.motion @ drift).reshape(interface.size, interface.components, -1)
        sliding = sliding[:, 1:].reshape(len(slides), -1)[slides]
        # A body that no friction touches is free.
        if not step.loads.friction.all() or np.linalg.matrix_rank(sliding) < drift.shape[1]:
            raise np.linalg.LinAlgError
        response = stuck.release(replace(conditions, floating=True))
        if not drift.shape[1] or response.residual > EQUILIBRIUM:
            raise np.linalg.LinAlgError
        found = _solution(step, response)
        slip, shear = (each.ravel()[slides] for each in (found.relative[:, 1:], guess.direction))
        back = drift @ least_motion_back(sliding, slip, shear)
        moved = (interface.motion @ back).reshape(found.relative.shape)
        coordinates = found.coordinates - back
        return LinearSolution(
            found.traction, found.relative - moved, coordinates, step.motion(coordinates)
        )

    def _glides(self, guess: Guess, loads: StepLoads) -> bool:
        """Tell whether a body is free to move along contacts without friction.

        Where no load pushes it that way it stays; round-off would move it any distance.
        """
        interface = self._operator.interface
        if loads.friction.all() or interface.prescribed.all():
            return False
        resisting = np.column_stack([guess.closed, guess.closed & (loads.friction > 0)])
        return self._unresisted(resisting).shape[1] > 0

    def _unresisted(self, resisting: Bools) -> Array:
        """(m, k) motions that nothing resists.

        Args:
            resisting: (N, 2) whether a node resists along its normal, and along the surface.
        """
        interface = self._operator.interface
        columns = [0, *[1] * (interface.components - 1)]
        released = ~interface.prescribed
        return unresisted_motions(interface, released, resisting[:, columns].ravel())

    def _linearised(self, guess: Guess, loads: StepLoads) -> Conditions:
        """Contact conditions linearised at a guess.

        A slipping node keeps its shear on the bound, q = f p t with the direction t. In three
        dimensions t follows the trial shear q − r Δ: its derivative times the bound is
        f p / |q − r Δ| times the projection across t, which turns the shear towards the slip.
        """
        prescribed = self._operator.interface.prescribed
        return Conditions(
            status=guess.status,
            pull=loads.friction[:, None] * guess.direction,
            turning=guess.turning,
            penalty=self._rules.penalty,
            known=prescribed,
            amplitudes=loads.values[prescribed, None],
        )

    def _state(
        self, guess: Guess, solution: LinearSolution, step: LoadedStep, reference: Array
    ) -> ContactState:
        interface = self._operator.interface
        # Exactly zero, not round-off: later stages ask which nodes carry a pressure.
        nothing = np.abs(solution.traction) <= self._rules.cancellation(solution.motion)[0][:, None]
        nothing |= guess.status[:, None] == OPEN
        traction = np.where(nothing, 0.0, solution.traction)
        # As the displacements give it: the certificate sees what the linear solution left undone.
        relative = interface.compliance.apply(solution.traction.ravel())
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


def _solution(step: LoadedStep, response: Response) -> LinearSolution:
    """The one case of a response."""
    coordinates = response.coordinates[:, 0]
    return LinearSolution(
        traction=response.traction[..., 0],
        relative=response.relative[..., 0],
        coordinates=coordinates,
        motion=step.motion(coordinates),
    )


def least_motion_back(sliding: Array, slip: Array, shear: Array) -> Array:
    """(k,) amplitudes of motions to take back, so that nodes slip least and against their shear.

    If not all can slip against it, they slip least only: those that do not will stick. Least
    distance programming of Lawson and Hanson, Solving Least Squares Problems (1974), ch. 23.

    Args:
        sliding: (n, k) slip by the motions, of full rank.
        slip: (n,) found.
        shear: (n,) its direction on the same surface.
    """
    # Imported where it is needed: few runs need SciPy's optimisation, which takes long.
    from scipy.optimize import nnls

    units, lengths = np.linalg.qr(sliding)
    least = units.T @ slip
    rows, bounds = shear[:, None] * units, shear * (slip - units @ least)
    size = float(np.abs(bounds).max())
    wanted = np.append(np.zeros(len(least)), 1.0)
    constraints = np.vstack([rows.T, bounds / (size or 1.0)])
    left = constraints @ nnls(constraints, wanted)[0] - wanted
    # Minus the square of what is left, which is round-off where no place meets all constraints.
    met = left[-1] < -np.sqrt(np.finfo(float).eps)
    further = -size * left[:-1] / left[-1] if met else 0.0
    return np.linalg.solve(lengths, least + further)


MAX_BOUNDS = 40
ITERATIONS_PER_BOUND = 150
# The status of the nodes is all that Newton needs; it settles long before the tractions do.
TRACTION_TOLERANCE = 1e-5
OVER_RELAXATION = 1.6


def status_by_fixed_point(
    operator: FactoredOperator, loads: StepLoads, reference: Array, start: Array
) -> tuple[Status, Array]:
    """Status and shear direction of all nodes at the end of a step, to the method's tolerance.

    Args:
        operator: solves linear systems of the interface problem.
        loads: loads at the end of the step.
        reference: (N, d-1) tangential displacement before the step.
        start: (N, d) tractions to start from.
    """
    solve = _Proximal(operator, loads, reference)
    traction, multiplier = start.copy(), np.zeros_like(start)
    # Stuck at first: with a bound too low for the loads the convex problem has no solution, and its
    # iteration drifts away.
    bound = np.where(loads.friction > 0, np.inf, 0.0)
    for _ in range(MAX_BOUNDS):
        before = traction.copy()
        for _ in range(ITERATIONS_PER_BOUND):
            free = solve(traction - multiplier)
            relaxed = OVER_RELAXATION * free + (1 - OVER_RELAXATION) * traction
            traction = _project(relaxed + multiplier, bound)
            multiplier += relaxed - traction
        used, bound = bound, loads.friction * traction[:, 0]
        scale = np.abs(traction).max(initial=np.finfo(float).tiny)
        if np.isfinite(used).all() and np.abs(traction - before).max() < TRACTION_TOLERANCE * scale:
            break
    shear = np.linalg.norm(traction[:, 1:], axis=1)
    # Where pressures still change, only the bound that it was held within tells who reached it.
    on_bound = shear >= used * (1 - TRACTION_TOLERANCE)
    status = np.where(traction[:, 0] <= 0, OPEN, np.where(on_bound, SLIP, STICK)).astype(np.int8)
    direction = np.zeros_like(traction[:, 1:])
    moving = (status == SLIP) & (shear > 0)
    direction[moving] = traction[moving, 1:] / shear[moving, None]
    return status, direction


class _Proximal:
    """Minimiser of the elastic energy plus a quadratic penalty on the distance to a target."""

    def __init__(self, operator: FactoredOperator, loads: StepLoads, reference: Array) -> None:
        interface = operator.interface
        known, released = interface.prescribed, ~interface.prescribed
        free = loads.without_traction(interface)
        free[:, 1:] -= reference
        free = free.ravel() + interface.motion[:, known] @ loads.values[known]
        forces = (interface.coordinate_loads @ loads.amplitudes)[released]
        forces += loads.values[released]
        forces -= interface.stiffness[np.ix_(released, known)] @ loads.values[known]
        self._penalty = interface.compliance.level
        self._layer = operator.regularised(self._penalty)
        self._offset = self._layer.tractions(-free, -forces)
        self._no_forces = np.zeros_like(forces)

    def __call__(self, target: Array) -> Array:
        stretch = self._penalty * target.ravel()
        elastic = self._layer.tractions(stretch, self._no_forces)
        return (elastic + self._offset).reshape(target.shape)


def _project(traction: Array, bound: Array) -> Array:
    """Nearest tractions with no tension and shear within the bound."""
    projected = traction.copy()
    projected[:, 0] = np.maximum(traction[:, 0], 0.0)
    length = np.linalg.norm(traction[:, 1:], axis=1)
    excess = length > bound
    projected[excess, 1:] *= (bound[excess] / length[excess])[:, None]
    return projected
