# SPDX-License-Identifier: LGPL-3.0-or-later
"""One contact solution per step of a load history: step cutting, the slow method, division.

Steps within which an edge moves far or loads turn are divided into parts. Slip, friction work and
the edge factors follow the way of the loads: a shear force that acts on a contact while it grows is
not the same as one that acts on the grown contact, and loads out of phase do not have all their
extremes at the ends of steps. Where edges move by more than a small part of the half-width within a
step, or loads turn, and friction acts, loads in between are solved too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.first_touch import displacement_at_first_touch
from fretfe.contact.interface import Interface, Place
from fretfe.contact.linear_operator import FactoredOperator
from fretfe.contact.newton import NO_RESISTANCE, Newton, NotConverged, status_by_fixed_point
from fretfe.contact.state import (
    OPEN,
    SLIP,
    STICK,
    Certificate,
    ContactState,
    Status,
    StepLoads,
    StepTable,
    certify,
    friction_work,
    lengths,
    turns,
    unit,
)
from fretfe.errors import ConvergenceError
from fretfe.history.solution import ROUND_OFF
from fretfe.surface.surface import edges_once

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
        friction: (N,) coefficient at each node in the step.
    """

    state: ContactState
    dissipation: Array
    iterations: int
    parts: int
    fallbacks: int
    certificate: Certificate
    friction: Array


def not_converged(number: int, count: int, failure: NotConverged) -> ConvergenceError:
    """The error that ends a history of some steps at one of them."""
    before = number - 1
    kept = f"the {before} steps before it are kept" if before else "it is the first one"
    return ConvergenceError(
        f"step {number} of {count} did not converge: {failure.reason} "
        f"(iteration {failure.iterations}, after halving the step {MAX_CUTS} times); {kept}."
    )


# What layers and profiles give has settled when it changes by less than this part of it, in so many
# rounds.
SETTLED = 1e-10
MOST_ROUNDS = 200
# Rounds that are combined: fewer take more rounds, many are no longer independent.
REMEMBERED = 12


class Mixing:
    """Anderson's acceleration of an iteration x -> g(x), J. ACM 12 (1965) 547.

    The next x combines the last ones so that their changes g - x would cancel if g were linear.
    """

    def __init__(self) -> None:
        self._values: list[Array] = []
        self._changes: list[Array] = []
        self.rounds = 0

    def next(self, value: Array, found: Array) -> Array:
        """The next x, after g(value) = found."""
        self.rounds += 1
        self._values = [*self._values[-REMEMBERED:], found]
        self._changes = [*self._changes[-REMEMBERED:], found - value]
        if len(self._values) == 1:
            return value + 0.5 * (found - value)
        changes, values = (np.diff(each, axis=0) for each in (self._changes, self._values))
        shares = np.linalg.lstsq(changes.T, self._changes[-1], rcond=1e-12)[0]
        return np.asarray(found - shares @ values)


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
        self.operator = FactoredOperator(interface)
        self._newton = Newton(self.operator)

    def advance(
        self,
        state: ContactState,
        start: StepLoads,
        end: StepLoads,
        cuts_left: int = MAX_CUTS,
        slow: bool = True,
        guess: ContactState | None = None,
    ) -> StepResult:
        """Go from one load to the next, in two halves if that is necessary.

        Args:
            state: at the start.
            start: loads.
            end: loads.
            cuts_left: how often the step may be halved.
            slow: whether the slow method is tried where Newton's fails.
            guess: a state that may resemble the one at the end; Newton's method starts from its
                status, and from full stick if that fails.

        Raises:
            NotConverged: if that fails however often the step is cut.
        """
        try:
            return self._attempt(state, end, slow, guess)
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

    def _attempt(
        self, state: ContactState, loads: StepLoads, slow: bool, guess: ContactState | None
    ) -> StepResult:
        reference = state.relative[:, 1:]
        fallbacks = spent = 0
        if self.interface.gives:
            given = self.interface.approach(state.traction, state.relative)
            loads = replace(loads, approach=given)
        try:
            solved, iterations, loads = self._settled(
                lambda loads, guess: self._newton_from(guess, state, loads), guess, loads
            )
        except NotConverged as failure:
            if not slow:
                raise
            fallbacks, spent = 1, failure.iterations
            status, direction = status_by_fixed_point(
                self.operator, loads, reference, state.traction
            )
            slipped = replace(state, status=status, direction=direction)

            def from_there(
                loads: StepLoads, guess: ContactState | None
            ) -> tuple[ContactState, int]:
                start = guess or slipped
                return self._newton.solve(loads, reference, start.status, start.direction)

            solved, iterations, loads = self._settled(from_there, None, loads)
        return StepResult(
            state=solved,
            dissipation=friction_work(
                state,
                solved,
                loads.friction,
                self.interface.contacts.values(),
                self.interface.roots,
            ),
            iterations=iterations + spent,
            parts=1,
            fallbacks=fallbacks,
            certificate=certify(self.interface, loads, solved, reference),
            friction=loads.friction,
        )

    def _settled(
        self,
        solve: Callable[[StepLoads, ContactState | None], tuple[ContactState, int]],
        guess: ContactState | None,
        loads: StepLoads,
    ) -> tuple[ContactState, int, StepLoads]:
        """Solve a step, again with what layers and profiles that slid give until that stays.

        Args:
            solve: from a guess, under loads with what they give.
            guess: to start from.
            loads: with what they give in the state before.

        Returns:
            The state, the iterations of all rounds, and the loads with what layers and profiles
            give.
        """
        spent, mixing = 0, Mixing()
        while True:
            solved, iterations = solve(loads, guess)
            spent += iterations
            if loads.approach is None:
                return solved, spent, loads
            given = self.interface.approach(solved.traction, solved.relative)
            missed, size = (float(np.abs(x).max()) for x in (given - loads.approach, given))
            # Closed surfaces are so far apart at most; lengths of round-off do not fall further.
            scale = SETTLED * max(size, float(np.abs(loads.approach).max()))
            if missed <= scale + self.interface.gap_round_off:
                return solved, spent, loads
            if mixing.rounds == MOST_ROUNDS:
                raise NotConverged("what layers or sliding profiles give does not settle", spent)
            loads = replace(loads, approach=mixing.next(loads.approach, given))
            guess = solved

    def _newton_from(
        self, guess: ContactState | None, state: ContactState, loads: StepLoads
    ) -> tuple[ContactState, int]:
        """Newton's method from a guess, and without one or where that fails from full stick.

        A contact that slides as a whole is likely to go on sliding. For it full stick is a bad
        start, and one with the most unknowns. A guess without contact is none: next to nothing then
        resists the loads, and a body may come to rest anywhere.
        """
        reference, spent = state.relative[:, 1:], 0
        if guess is not None and not guess.closed.any():
            guess = None
        if guess is None and slides_as_a_whole(state):
            guess = state
        for start in self._starts(guess, state, loads):
            try:
                solved, iterations = self._newton.solve(loads, reference, *start)
            except NotConverged as failure:
                spent, last = spent + failure.iterations, failure
            else:
                return solved, spent + iterations
        raise NotConverged(last.reason, spent)

    def _starts(
        self, guess: ContactState | None, state: ContactState, loads: StepLoads
    ) -> Iterator[tuple[Status, Array]]:
        """Status and directions of slip to start from, one after the other."""
        if guess is not None:
            yield guess.status, guess.direction
        yield self._start(state)
        if not self.interface.prescribed.all():
            touching = self._touching(state, loads)
            if touching is not None:
                yield touching

    def _start(self, state: ContactState) -> tuple[Status, Array]:
        """Every node in contact stuck; the nearest nodes if contact alone restrains a body."""
        closed = state.closed
        restrained_by_contact = not self.interface.prescribed.all()
        if restrained_by_contact and not closed.any():
            closed = self._nearest(state.relative[:, 0] / self.interface.roots)
        status = np.where(closed, STICK, OPEN).astype(np.int8)
        return status, np.zeros_like(state.direction)

    def _touching(self, state: ContactState, loads: StepLoads) -> tuple[Status, Array] | None:
        """Nodes where loose bodies touch first; slipping if they get there by sliding."""
        found = displacement_at_first_touch(self.interface, loads, state.closed)
        if found is None:
            return None
        increment = found[:, 1:] - state.relative[:, 1:]
        moved = lengths(increment)
        slides = moved > loads.friction * np.abs(state.relative[:, 0])
        closed = state.closed
        touches = self._nearest(found[:, 0] / self.interface.roots) & ~closed
        status = np.select([closed, touches & slides, touches], [STICK, SLIP, STICK], OPEN)
        slips = (status == SLIP) & (loads.friction > 0)
        return status.astype(np.int8), np.where(slips[:, None], -unit(increment, moved), 0.0)

    def _nearest(self, gap: Array) -> Bools:
        """The nodes of each contact whose gap is smallest."""
        closed = np.zeros(len(gap), bool)
        for nodes in self.interface.contacts.values():
            count = max(FIRST_TOUCH_NODES, int(FIRST_TOUCH_FRACTION * (nodes.stop - nodes.start)))
            closed[nodes.start + np.argsort(gap[nodes], kind="stable")[:count]] = True
        return closed


def slides_as_a_whole(state: ContactState) -> bool:
    """True if some nodes touch and none of them sticks."""
    return bool(state.closed.any()) and not np.any(state.status == STICK)


# Mean movement of the edges within a part, over the half-width, that is aimed at: increments by the
# mean of both ends are right to a few 1e-4 then.
LARGEST_MOVE = 0.05
# A part that exceeds it by this factor is solved again in smaller ones.
TOLERATED = 1.4
# Distance of the loads from the straight line between the ends of a part, over their ranges: more
# than that of two loads with 20 steps a cycle. With 10 slip zones out of phase are 10 % too short.
LARGEST_BEND = 0.009
# Under one load friction does little where the shear is less than this part of what it can take up:
# .03 are what a sphere on a block has that is pressed on, as bodies are no half-spaces.
LEAST_SHEAR = 0.05
# Parts of one step.
MOST_PARTS = 64
# Parts grow and shrink by this factor at most from one to the next.
FASTEST = 3.0


@dataclass(frozen=True)
class Part:
    """A solved part of a step.

    Attributes:
        share: of the step, in (0, 1], at its end.
        result: the state there, and what it took.
    """

    share: float
    result: StepResult


def summary(parts: Sequence[Part]) -> str:
    """Iterations, parts and largest violation of a step, in words."""
    results = [each.result for each in parts]
    iterations = sum(each.iterations for each in results)
    count = sum(each.parts for each in results)
    worst = max(each.certificate.worst for each in results)
    cut = f", cut into {count} parts" if count > 1 else ""
    return f"{iterations} iterations{cut}, violation {worst:.0e}"


class Division:
    """Solves steps, in parts where edges move far.

    Args:
        march: advances the states.
        steps: loads at the end of each step.
        places: the contacts.
    """

    def __init__(self, march: March, steps: StepTable, places: Sequence[Place]) -> None:
        self._march, self._steps = march, steps
        self._edges = {place.name: neighbouring_nodes(place) for place in places}
        self._turns = parts_by_turning(steps)
        self._places = places
        self._least_shear = _least_shear(steps)
        # (contacts,) P so far in the step.
        self._largest: Array = np.zeros(len(places))

    def solve(
        self, number: int, state: ContactState, guess: ContactState | None = None
    ) -> list[Part]:
        """Solve a step from the state before it; its end is that of the last part.

        Args:
            number: of the step.
            state: before it.
            guess: a state that may resemble the one at its end.

        Raises:
            ConvergenceError: if it has no solution.
        """
        try:
            return self._solve(number, state, guess)
        except NotConverged as failure:
            raise not_converged(number, len(self._steps) - 1, failure) from None

    def _solve(self, number: int, state: ContactState, guess: ContactState | None) -> list[Part]:
        begin, end = self._steps[number - 1], self._loads(number, 1.0, state)
        self._largest = self._forces(state)
        whole = self._march.advance(state, begin, end, guess=guess)
        fewest = self._turns[number] if end.friction.any() else 1
        moved = self._moved(number, state, whole.state, end)
        if moved <= TOLERATED and fewest == 1:
            return [Part(1.0, whole)]
        parts = list[Part]()
        with suppress(NotConverged):
            for part in self._parts(number, state, 1 / max(moved, fewest), 1 / fewest):
                parts.append(part)
            return parts
        # Loads on the way find no solution, as where all would slide, or nothing touches any more.
        if parts:
            with suppress(NotConverged):
                state = parts[-1].result.state
                end = self._loads(number, 1.0, state)
                return [*parts, Part(1.0, self._march.advance(state, begin, end))]
        return [Part(1.0, whole)]

    def _parts(
        self, number: int, state: ContactState, size: float, largest: float
    ) -> Iterator[Part]:
        """The parts of a step, as shares of it none larger than the largest.

        Args:
            number: of the step.
            state: before it.
            size: of the first one to be tried.
            largest: of all parts.
        """
        begin = self._steps[number - 1]
        done, count, guess = 0.0, 0, None
        while done < 1.0:
            # The first parts, next to no contact at all, may be smaller than there are parts.
            least = min(1.0, 0.25 + count / MOST_PARTS) * (1.0 - done) / (MOST_PARTS - count)
            share = _reached(done, min(max(size, least), largest))
            loads = self._loads(number, share, state)
            result = self._march.advance(state, begin, loads, guess=guess)
            moved = self._moved(number, state, result.state, loads)
            size = (share - done) / float(np.clip(moved, 1 / FASTEST, FASTEST))
            if moved > TOLERATED and share - done > 1.01 * least:
                guess = result.state
                continue
            yield Part(share, result)
            self._largest = np.maximum(self._largest, self._forces(result.state))
            state, begin, done, count, guess = result.state, loads, share, count + 1, None

    def _loads(self, number: int, share: float, before: ContactState) -> StepLoads:
        """Loads at a share of a step, with the friction that acts after a state."""
        steps, loads = self._steps, self._steps[number]
        if share < 1.0:
            loads = steps.divided(np.array([number]), np.array([share]))[0]
        return steps.after(loads, self._pressure(before)) if steps.by_pressure else loads

    def _pressure(self, state: ContactState) -> Array:
        """(N,) mean pressure around the nodes."""
        interface = self._march.interface
        nodal = state.traction[:, 0] / interface.roots
        means = [place.averaging @ nodal[interface.contacts[place.name]] for place in self._places]
        return np.maximum(np.concatenate(means), 0.0)

    def _forces(self, state: ContactState) -> Array:
        """P of each contact in a state."""
        interface = self._march.interface
        pressed = interface.roots * state.traction[:, 0]
        return np.array([pressed[nodes].sum() for nodes in interface.contacts.values()])

    def _moved(
        self, number: int, before: ContactState, after: ContactState, loads: StepLoads
    ) -> float:
        """Movement of edges over `LARGEST_MOVE`, of the contact with friction where it is largest.

        Less than one if they move by no more than an element: more parts would tell nothing new.
        At least `FASTEST` where a contact turns to another way of sliding, or parts.
        """
        interface, largest, least = self._march.interface, 0.0, float(self._least_shear[number])
        bound = loads.friction * before.traction[:, 0]
        normal = np.array([self._forces(before), self._forces(after), self._largest])
        for contact, (name, nodes) in enumerate(interface.contacts.items()):
            own = loads.friction[nodes], interface.roots[nodes], least
            if not any(_sheared(each.traction[nodes], *own) for each in (before, after)):
                continue
            if turns(before, after, bound, nodes, normal[:, contact]):
                largest = max(largest, FASTEST)
            closed = before.closed[nodes], after.closed[nodes]
            share = _movement(interface.roots[nodes] ** 2, *closed)
            elements = _elements(self._edges[name], *closed)
            largest = max(largest, min(share / LARGEST_MOVE, elements))
        return largest


def _least_shear(steps: StepTable) -> Array:
    """(T,) part of what friction can take up below which shear does little in each step.

    Another load that moves with P leaves its shear behind, however small that is.
    """
    loads = np.column_stack([steps.amplitudes, steps.values])
    moves = np.abs(np.diff(loads, axis=0, prepend=loads[:1])) > ROUND_OFF * np.ptp(loads, axis=0)
    return np.where(np.count_nonzero(moves, axis=1) > 1, ROUND_OFF, LEAST_SHEAR)


def parts_by_turning(steps: StepTable) -> Indices:
    """(T,) parts of each step within which the loads are next to straight lines.

    Loads that go up and down together follow one line, whose ends are ends of steps.
    """
    parts = np.ones(len(steps), dtype=np.int64)
    if steps.within is None or len(steps) < 2:
        return parts
    numbers = np.arange(1, len(steps))
    middle = steps.divided(numbers, np.full(len(numbers), 0.5))
    loads, between = (np.column_stack([each.amplitudes, each.values]) for each in (steps, middle))
    ranges = np.ptp(loads, axis=0)
    scale = np.where(ranges > 0, ranges, np.inf)
    chord = np.diff(loads, axis=0) / scale
    bulge = (between - (loads[1:] + loads[:-1]) / 2) / scale
    length = np.linalg.norm(chord, axis=1)
    unit = chord / np.where(length > 0, length, 1.0)[:, None]
    across = bulge - np.sum(bulge * unit, axis=1, keepdims=True) * unit
    bend = np.linalg.norm(across, axis=1)
    parts[1:] = np.clip(np.ceil(np.sqrt(bend / LARGEST_BEND) - 1e-9), 1, MOST_PARTS)
    return parts


def _sheared(traction: Array, friction: Array, roots: Array, least: float) -> bool:
    """True if the shear of tractions (n, 2 or 3) is a part of what friction can take up."""
    bound = friction @ (roots * traction[:, 0])
    return bool(roots @ lengths(traction[:, 1:]) > least * bound > 0)


def _reached(done: float, size: float) -> float:
    """Share at the end of the next part; a last one is not left much smaller than the others."""
    return 1.0 if done + 1.2 * size >= 1.0 else done + size


def _movement(weights: Array, before: Bools, after: Bools) -> float:
    """Part of the mean area of a contact that opens or closes between two states.

    In the plane the mean movement of its edges over the half-width: 2 da of 2 a. Of a circle twice
    that of the radius, with whose power 3/2 factors fall, and not 1/2.
    """
    area = (weights[before].sum() + weights[after].sum()) / 2
    return float(weights[before ^ after].sum() / area) if area > 0 else 0.0


def _elements(edges: Indices, before: Bools, after: Bools) -> float:
    """Mean movement of the edges in elements: nodes that open or close over those on the rim."""
    rim = max(_rim(edges, before), _rim(edges, after), 1)
    return float(np.count_nonzero(before ^ after)) / rim


def _rim(edges: Indices, closed: Bools) -> int:
    """Number of nodes in contact that have a neighbour which is not.

    Args:
        edges: (E, 2) neighbouring nodes.
        closed: (N,) nodes in contact.
    """
    ends = closed[edges]
    rim = np.zeros(len(closed), dtype=bool)
    rim[edges[ends & ~ends[:, ::-1]]] = True
    return int(np.count_nonzero(rim))


def neighbouring_nodes(place: Place) -> Indices:
    """(E, 2) neighbouring nodes of a contact: one after the other, or along the sides of facets."""
    if place.surface.facets is None:
        nodes = np.arange(len(place.surface.weights))
        return np.column_stack([nodes[:-1], nodes[1:]])
    return edges_once(place.surface.facets)
