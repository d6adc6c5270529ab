# SPDX-License-Identifier: LGPL-3.0-or-later
"""One contact solution per step of a load history: step cutting, the slow method, certificates."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools
from fretfe.contact.admm import status_by_fixed_point
from fretfe.contact.certificate import Certificate, certify, dissipation
from fretfe.contact.factored import FactoredOperator
from fretfe.contact.interface import Interface
from fretfe.contact.newton import NO_RESISTANCE, Newton, NotConverged
from fretfe.contact.operator import InterfaceOperator
from fretfe.contact.state import OPEN, STICK, ContactState, StepLoads
from fretfe.errors import ConvergenceError

# A step is halved at most this often before the run gives up.
MAX_CUTS = 6
# Nodes taken as closed when contact alone restrains a body and none is in contact yet.
FIRST_TOUCH_FRACTION = 0.05
FIRST_TOUCH_NODES = 3


@dataclass(frozen=True)
class StepResult:
    """One accepted step.

    Attributes:
        state: contact state at the end of the step.
        dissipation: (N,) friction work done at each node in the step, per unit thickness.
        iterations: Newton iterations, of all parts of the step together.
        parts: number of parts that the step was cut into; 1 if it converged at first attempt.
        fallbacks: number of times that the slow method was needed.
        certificate: violations of the contact conditions.
    """

    state: ContactState
    dissipation: Array
    iterations: int
    parts: int
    fallbacks: int
    certificate: Certificate

    @property
    def summary(self) -> str:
        """Iterations and largest violation, in words."""
        cut = f", cut into {self.parts} parts" if self.parts > 1 else ""
        return f"{self.iterations} iterations{cut}, violation {self.certificate.worst:.0e}"


def not_converged(number: int, count: int, failure: NotConverged) -> ConvergenceError:
    """The error that ends a history of some steps at one of them."""
    before = number - 1
    kept = f"the {before} steps before it are kept" if before else "it is the first one"
    return ConvergenceError(
        f"step {number} of {count} did not converge: {failure.reason} "
        f"(iteration {failure.iterations}, after halving the step {MAX_CUTS} times); {kept}."
    )


class March:
    """Advances a contact from one state to the next; a step counts once it is accepted.

    Args:
        interface: the interface problem.

    Attributes:
        interface: the interface problem.
        operator: solves its linear systems.
    """

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        self.operator: InterfaceOperator = FactoredOperator(interface)
        self._newton = Newton(self.operator)

    def advance(
        self,
        state: ContactState,
        start: StepLoads,
        end: StepLoads,
        cuts_left: int = MAX_CUTS,
        slow: bool = True,
    ) -> StepResult:
        """Go from one load to the next, in two halves if that is necessary.

        Args:
            state: at the start.
            start: loads.
            end: loads.
            cuts_left: how often the step may be halved.
            slow: whether the slow method is tried where Newton's fails.

        Raises:
            NotConverged: if that fails however often the step is cut.
        """
        try:
            return self._attempt(state, end, slow)
        except NotConverged as failure:
            if not cuts_left:
                raise
            # Loads that found no resistance hardly find one from nearer by: not before the last
            # cut is it worth the slow method's thousands of iterations.
            resisted = failure.reason != NO_RESISTANCE
        middle = start.between(end, 0.5)
        first = self.advance(state, start, middle, cuts_left - 1)
        slow = resisted or cuts_left == 1
        second = self.advance(first.state, middle, end, cuts_left - 1, slow)
        return replace(
            second,
            dissipation=first.dissipation + second.dissipation,
            iterations=first.iterations + second.iterations,
            parts=first.parts + second.parts,
            fallbacks=first.fallbacks + second.fallbacks,
        )

    def _attempt(self, state: ContactState, loads: StepLoads, slow: bool) -> StepResult:
        reference = state.relative[:, 1:]
        status, direction = self._start(state)
        fallbacks = 0
        try:
            solved, iterations = self._newton.solve(loads, reference, status, direction)
        except NotConverged as failure:
            if not slow:
                raise
            fallbacks, spent = 1, failure.iterations
            status, direction = status_by_fixed_point(
                self.operator, loads, reference, state.traction
            )
            solved, iterations = self._newton.solve(loads, reference, status, direction)
            iterations += spent
        return StepResult(
            state=solved,
            dissipation=dissipation(solved, reference),
            iterations=iterations,
            parts=1,
            fallbacks=fallbacks,
            certificate=certify(self.interface, loads, solved, reference),
        )

    def _start(self, state: ContactState) -> tuple[npt.NDArray[np.int8], Array]:
        """Every node in contact stuck; the nearest nodes if contact alone restrains a body."""
        closed = state.closed
        restrained_by_contact = not self.interface.prescribed.all()
        if restrained_by_contact and not closed.any():
            closed = self._nearest(state.relative[:, 0] / self.interface.roots)
        status = np.where(closed, STICK, OPEN).astype(np.int8)
        return status, np.zeros_like(state.direction)

    def _nearest(self, gap: Array) -> Bools:
        """The nodes of each contact whose gap is smallest."""
        closed = np.zeros(len(gap), bool)
        for nodes in self.interface.contacts.values():
            count = max(FIRST_TOUCH_NODES, int(FIRST_TOUCH_FRACTION * (nodes.stop - nodes.start)))
            closed[nodes.start + np.argsort(gap[nodes], kind="stable")[:count]] = True
        return closed
