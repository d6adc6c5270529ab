# SPDX-License-Identifier: LGPL-3.0-or-later
"""The independent solver: all displacements and multipliers at once, nothing condensed.

It solves the same discrete problem as the condensed path by other means, so that each checks the
other. Shared are only the meshes, the elastic operators and the mortar coupling. With x the
unknowns of `full_system`, λ_i = (p_i, q_i) the nodal tractions and w_i the nodal means
of gap and tangential displacement, a step is

    K x − F a − R − Bᵀ λ = 0
    λ_i − Π(λ_i − r_i Δw_i) = 0        Δw_i: w_i, its tangential part since the step before

with the projection Π of a trial traction (p, q) on the friction cone: pressure max(0, p), shear on
the disc of radius f max(0, p) (Alart and Curnier, 1991). Newton's method takes one element of the
generalised derivative of Π as it is: no node carries a status from one iteration to the next.

Two measures make it converge from the solution of the step before:

* The penalty is small against the stiffness of the bodies at the interface: r = E / (2 h), with E
  the moduli of both bodies in series and h the width of a hat function. The larger r, the sooner
  the iteration cycles, first where a contact that slides as a whole reverses.
* Newton steps are halved until the contact residual decreases. Equilibrium is linear: the first
  step, always a full one, establishes it for good.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from reference.full_system import assemble_system
from scipy import sparse

from fretfe._typing import Array
from fretfe.contact.state import StepLoads
from fretfe.errors import ConvergenceError, FretfeError
from fretfe.fem._compat import PETSc
from fretfe.fem.model import Model

MAX_ITERATIONS = 60
# Residuals below this fraction of the largest displacement or gap are round-off; of one beyond the
# size of the contact, that size counts: it shows that nothing resists the loads.
ROUND_OFF = 1e-12
# The shortest fraction of a Newton step, taken even if it does not help: the residual has kinks.
SHORTEST_STEP = 1 / 64
# Fraction of the decrease of a linear residual that counts as a decrease.
SUFFICIENT_DECREASE = 1e-4
# Where nothing is in contact this share of the nodes, the nearest, starts with a pressure: a body
# that only contact holds has no other first tangent.
FIRST_TOUCH = 0.05
# MUMPS controls: the fill-reducing ordering and its value for approximate minimum degree; how much
# more memory than expected pivoting may need, in per cent.
ORDERING_CONTROL, MINIMUM_DEGREE = 7, 0
MEMORY_CONTROL, SPARE_MEMORY = 14, 100


@dataclass(frozen=True)
class MonolithicStep:
    """Solution of one step; N multiplier nodes, d space dimensions.

    Attributes:
        traction: (N, d) nodal pressure, then shear on body 2 (stress).
        relative: (N, d) nodal mean of the gap, then of the tangential displacement of body 2
            relative to body 1 since the unloaded state (length).
        displacements: (n_b,) degrees of freedom by body, in the order of its displacement space.
        coordinates: (m,) amplitude of each constraint (length), body after body: the coordinates of
            the interface problem without the rigid modes.
        forces: (m,) force on each of these coordinates, per unit thickness in the plane.
        iterations: Newton iterations; each is one factorisation.
    """

    traction: Array
    relative: Array
    displacements: dict[str, Array]
    coordinates: Array
    forces: Array
    iterations: int


@dataclass(frozen=True)
class Iterate:
    """Unknowns and residuals. All are lengths: tractions are over r, forces over a modulus.

    Attributes:
        x: (n,) unknowns, prescribed amplitudes included.
        scaled: (N, d) tractions over r.
        equilibrium: (k,) residual of the k unknowns in x that are not prescribed.
        contact: (N, d) residual of the contact conditions.
        derivative: (N, d, d) derivative of the projection at the trial traction.
    """

    x: Array
    scaled: Array
    equilibrium: Array
    contact: Array
    derivative: Array


def cone_projection(trial: Array, friction: Array) -> tuple[Array, Array]:
    """Projection of trial tractions on the friction cone, and its derivative.

    The radius of the disc moves with the trial pressure, so the derivative is not symmetric. At the
    kinks (no trial pressure, shear on the bound) it is that of the open or stuck side.

    Args:
        trial: (N, d) pressure, then shear; any unit.
        friction: (N,) coefficient.

    Returns:
        (N, d) projection and its (N, d, d) derivative with respect to `trial`.
    """
    d = trial.shape[1]
    pressure, shear = np.maximum(trial[:, 0], 0.0), trial[:, 1:]
    bound, length = friction * pressure, np.linalg.norm(shear, axis=1)
    closed, slides = trial[:, 0] > 0, length > bound
    direction = np.where(slides, 1 / np.where(slides, length, 1.0), 0.0)[:, None] * shear
    shrink = np.where(slides, bound / np.where(slides, length, 1.0), 1.0)[:, None]
    derivative = np.zeros((len(trial), d, d))
    derivative[:, 0, 0] = closed
    derivative[:, 1:, 0] = (friction * closed)[:, None] * direction
    across = np.eye(d - 1) - direction[:, :, None] * direction[:, None, :]
    derivative[:, 1:, 1:] = shrink[:, :, None] * across
    return np.hstack([pressure[:, None], shrink * shear]), derivative


class MonolithicSolver:
    """Solves load steps with all unknowns at once, on one process.

    Args:
        model: its bodies, coupling and definition are used; of its interface problem only the
            numbers that the coordinates have in `StepLoads`.

    Raises:
        FretfeError: on more than one MPI rank.
    """

    def __init__(self, model: Model) -> None:
        """Assemble the system."""
        if model.comm.size > 1:
            raise FretfeError(
                "the monolithic solver runs on one process: expected 1 MPI rank, found "
                f"{model.comm.size}."
            )
        self.system = system = assemble_system(model.bodies, model.reduction)
        prescribed = system.constraints[system.prescribed]
        #: (k,) unknowns in x that are not prescribed.
        self.free = np.setdiff1d(np.arange(system.stiffness.shape[0]), prescribed)
        d = system.gap.shape[1]
        #: (N,) r (stress over length).
        self.penalty = system.modulus / (2 * system.weights ** (1 / (d - 1)))
        self._modulus = system.modulus.max()
        self._size = system.weights.sum() ** (1 / (d - 1))
        means, pull = np.repeat([1 / system.weights, self.penalty / self._modulus], d, axis=1)
        self._stiffness = system.stiffness[self.free][:, self.free] / self._modulus
        self._means = (sparse.diags(means) @ system.coupling)[:, self.free]
        self._pull = (sparse.diags(pull) @ system.coupling)[:, self.free].T

    def run(self, steps: Sequence[StepLoads]) -> Iterator[MonolithicStep]:
        """Solve steps one after the other, each from the solution of the one before.

        Args:
            steps: loads at the end of each step; the first entry is the unloaded state.

        Raises:
            ConvergenceError: if no solution of a step is found; what was yielded before stands.
        """
        x = np.zeros(self.system.stiffness.shape[0])
        scaled = np.zeros_like(self.system.gap)
        for number, loads in enumerate(steps[1:], start=1):
            reference = self.system.relative(x)[:, 1:]
            start = self._touching(x, scaled)
            solved, iterations = self._solve(loads, reference, x, start)
            if solved is None:
                raise ConvergenceError(
                    f"step {number} of {len(steps) - 1} of the monolithic solver did not converge "
                    f"in {iterations} iterations; the {number - 1} steps before it are kept."
                )
            x, scaled = solved.x, solved.scaled
            yield self._result(loads, solved, iterations)

    def evaluate(self, loads: StepLoads, reference: Array, x: Array, scaled: Array) -> Iterate:
        """Residuals of given unknowns.

        Args:
            loads: loads at the end of the step.
            reference: (N, d-1) tangential displacement before the step.
            x: (n,) unknowns, prescribed amplitudes included.
            scaled: (N, d) tractions over r.
        """
        system = self.system
        forces = system.loads @ loads.amplitudes
        driven = ~system.prescribed
        forces[system.constraints[driven]] += loads.values[system.numbers[driven]]
        unbalanced = (system.stiffness @ x - forces)[self.free] / self._modulus
        increment = system.relative(x)
        increment[:, 1:] -= reference
        projected, derivative = cone_projection(scaled - increment, loads.friction)
        equilibrium = unbalanced - self._pull @ scaled.ravel()
        return Iterate(x, scaled, equilibrium, scaled - projected, derivative)

    def tangent(self, iterate: Iterate) -> sparse.csr_matrix:
        """(k + N*d, k + N*d) derivative of both residuals by free unknowns and tractions over r."""
        count, d = iterate.contact.shape
        pattern = np.arange(count), np.arange(count + 1)
        contact = sparse.bsr_matrix((iterate.derivative, *pattern))
        rest = sparse.bsr_matrix((np.eye(d) - iterate.derivative, *pattern))
        rows = [[self._stiffness, -self._pull], [contact @ self._means, rest]]
        return sparse.bmat(rows, format="csr")

    def _solve(
        self, loads: StepLoads, reference: Array, x: Array, scaled: Array
    ) -> tuple[Iterate | None, int]:
        """Solution of a step, or None, and the number of iterations."""
        system = self.system
        x = x.copy()
        x[system.constraints[system.prescribed]] = loads.values[system.numbers[system.prescribed]]
        current = self.evaluate(loads, reference, x, scaled)
        for iteration in range(1, MAX_ITERATIONS + 1):
            rhs = -np.concatenate([current.equilibrium, current.contact.ravel()])
            change = _solve_sparse(self.tangent(current), rhs)
            if not np.all(np.isfinite(change)):
                return None, iteration
            shortest = SHORTEST_STEP if iteration > 1 else 1.0
            current = self._search(loads, reference, current, change, shortest)
            largest = max(np.abs(current.x).max(), np.abs(system.relative(current.x)).max())
            residual = max(np.abs(current.equilibrium).max(), np.abs(current.contact).max())
            if residual <= ROUND_OFF * min(largest, self._size):
                return current, iteration
        return None, MAX_ITERATIONS

    def _search(
        self, loads: StepLoads, reference: Array, start: Iterate, change: Array, shortest: float
    ) -> Iterate:
        """The first iterate along a Newton step that reduces the contact residual."""
        step = np.zeros_like(start.x)
        step[self.free] = change[: len(self.free)]
        step_scaled = change[len(self.free) :].reshape(start.scaled.shape)
        length = 1.0
        while True:
            x, scaled = start.x + length * step, start.scaled + length * step_scaled
            reached = self.evaluate(loads, reference, x, scaled)
            enough = (1 - SUFFICIENT_DECREASE * length) * self._norm(start)
            if self._norm(reached) <= enough or length <= shortest:
                return reached
            length /= 2

    def _norm(self, iterate: Iterate) -> float:
        return float(np.sqrt(self.system.weights @ (iterate.contact**2).sum(axis=1)))

    def _touching(self, x: Array, scaled: Array) -> Array:
        """(N, d) the tractions over r to start from: `scaled`, unless nothing is in contact."""
        gap = self.system.relative(x)[:, 0]
        if np.any(scaled[:, 0] > gap):
            return scaled
        nearest = [np.quantile(gap[nodes], FIRST_TOUCH) for nodes in self.system.contacts]
        sizes = [nodes.stop - nodes.start for nodes in self.system.contacts]
        closes = gap <= np.repeat(nearest, sizes)
        # Any pressure above r gap will do: the first step depends on nothing but what is closed.
        start = np.zeros_like(scaled)
        start[closes, 0] = gap[closes] + (self._modulus / self.penalty)[closes]
        return start

    def _result(self, loads: StepLoads, solved: Iterate, iterations: int) -> MonolithicStep:
        system = self.system
        traction = solved.scaled * self.penalty[:, None]
        forces = system.stiffness @ solved.x - system.loads @ loads.amplitudes
        forces -= system.coupling.T @ traction.ravel()
        return MonolithicStep(
            traction=traction,
            relative=system.relative(solved.x),
            displacements={name: field @ solved.x for name, field in system.fields.items()},
            coordinates=solved.x[system.constraints],
            forces=forces[system.constraints],
            iterations=iterations,
        )


def _solve_sparse(matrix: sparse.csr_matrix, rhs: Array) -> Array:
    """Solution by an unsymmetric MUMPS factorisation; not finite if the matrix is singular."""
    rows, columns = (part.astype(PETSc.IntType) for part in (matrix.indptr, matrix.indices))
    operator = PETSc.Mat().createAIJ(matrix.shape, csr=(rows, columns, matrix.data))
    solver = PETSc.PC().create(operator.comm)
    solver.setOperators(operator)
    solver.setType("lu")
    solver.setFactorSolverType("mumps")
    solver.setFactorSetUpSolverType()
    factor = solver.getFactorMatrix()
    factor.setMumpsIcntl(ORDERING_CONTROL, MINIMUM_DEGREE)
    factor.setMumpsIcntl(MEMORY_CONTROL, SPARE_MEMORY)
    right = PETSc.Vec().createWithArray(rhs, comm=operator.comm)
    solution = right.duplicate()
    solver.apply(right, solution)
    values = solution.array.copy()
    for thing in (solution, right, solver, operator):
        thing.destroy()
    return values
