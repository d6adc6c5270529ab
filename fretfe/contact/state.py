# SPDX-License-Identifier: LGPL-3.0-or-later
"""State of the contact nodes, loads of a step, how a status changes, and what a state violates."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import overload

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Interface
from fretfe.history.solution import OPEN, ROUND_OFF, SLIP, STICK
from fretfe.loads.history import within_steps
from fretfe.surface.friction import Friction

Status = npt.NDArray[np.int8]

__all__ = ["OPEN", "SLIP", "STICK", "ContactState", "StepLoads", "StepTable", "unloaded"]
# Violations below this fraction of the displacements that cancel in w are round-off: bodies that
# move together leave gaps of 1e-13 of their motion (measured on meshes up to 330 000 unknowns).
CANCELLATION = 1e-12
# Parts of the pressures before and after that act while a node slips. Slip that goes on is even. Of
# a zone that grows evenly from an edge inward with p ~ √s, each node slips as (t - s/d)^(3/2): on
# the mean over the zone, weighted with the work, 3/4 of the change of p has passed by then.
GOING_ON = 0.5
BEGINNING = 0.75
# An edge that moves evenly passes nodes between here and there: with p ~ √s behind it and even slip
# they do 2/5 of the work of the pressure they have at the end at which they are in contact.
PASSED_BY = 0.4
# Changes of P below this part of it are none, and so much of what P was is no load.
SAME_FORCE = 1e-6
# Sliding goes on if the shear before did so much of the work that friction may do on the way.
GOES_ON = 0.99
# Part of the largest P from which on a contact may lose all of it at once.
LAST_FORCE = 0.03


@dataclass(frozen=True)
class StepLoads:
    """Loads, prescribed amplitudes, friction and unloaded gap at the end of a step.

    An `Interface` is shared by histories; what may differ between their states is here.

    Attributes:
        amplitudes: (l,) load amplitudes.
        values: (m,) amplitude of each prescribed coordinate, force on each of the others.
        friction: (N,) coefficient at each node.
        approach: (N,) what layers and profiles that slid give beyond the compliance, as of
            `Interface.approach`; None without such, and where it is not known yet.
    """

    amplitudes: Array
    values: Array
    friction: Array
    approach: Array | None = None

    def without_traction(self, interface: Interface) -> Array:
        """(N, d) gap and tangential displacement w0 + L a without tractions and coordinates."""
        free = interface.gap + interface.loads @ self.amplitudes
        free = free.reshape(interface.size, interface.components)
        if self.approach is not None:
            free[:, 0] += self.approach
        return free

    def between(self, later: StepLoads, fraction: float) -> StepLoads:
        """Loads at a fraction of the way to a later step, with the later step's friction."""
        return replace(
            later,
            amplitudes=(1 - fraction) * self.amplitudes + fraction * later.amplitudes,
            values=(1 - fraction) * self.values + fraction * later.values,
        )


@dataclass(frozen=True)
class StepTable(Sequence[StepLoads]):
    """Loads of all T steps, the unloaded state first.

    Attributes:
        amplitudes: (T, l) load amplitudes.
        values: (T, m) as of `StepLoads`.
        friction: of each contact.
        within: gives the loads at shares (n,) of steps (n,); None if they are straight lines there.
    """

    amplitudes: Array
    values: Array
    friction: tuple[Friction, ...]
    within: Callable[[Indices, Array], StepTable] | None = field(default=None, compare=False)

    def divided(self, steps: Indices, shares: Array) -> StepTable:
        """Loads of n states within steps.

        Args:
            steps: (n,) number of the step in which each of them lies.
            shares: (n,) of the step, in (0, 1], at which it is reached: 1 at its end.
        """
        if self.within is not None:
            return self.within(steps, shares)
        amplitudes, values = (
            within_steps(each, None, steps, shares) for each in (self.amplitudes, self.values)
        )
        return StepTable(amplitudes, values, tuple(each.picked(steps) for each in self.friction))

    def __len__(self) -> int:
        """T."""
        return len(self.values)

    @property
    def by_pressure(self) -> bool:
        """True if friction depends on the pressure before the step."""
        return any(each.by_pressure is not None for each in self.friction)

    def after(self, loads: StepLoads, pressure: Array) -> StepLoads:
        """Loads with the coefficients that act after a pressure (N,) at the nodes."""
        ends = np.cumsum([each.fields.shape[1] for each in self.friction])
        own = zip(self.friction, np.split(pressure, ends[:-1]), strict=True)
        shares = [each.share(here) for each, here in own]
        return replace(loads, friction=loads.friction * np.concatenate(shares))

    @property
    def digest(self) -> str:
        """Text that is equal for the same loads."""
        found = hashlib.sha256(repr((self.amplitudes.shape, self.values.shape)).encode())
        friction = (
            array
            for each in self.friction
            for array in (each.fields, each.number, each.by_pressure)
            if array is not None
        )
        for each in (self.amplitudes, self.values, *friction):
            found.update(np.ascontiguousarray(each).tobytes())
        return found.hexdigest()

    @overload
    def __getitem__(self, number: int) -> StepLoads: ...

    @overload
    def __getitem__(self, number: slice) -> StepTable: ...

    def __getitem__(self, number: int | slice) -> StepLoads | StepTable:
        """Loads of one step, or of some."""
        parts = self.amplitudes[number], self.values[number]
        if isinstance(number, slice):
            friction = tuple(each.picked(number) for each in self.friction)
            return StepTable(*parts, friction, self.within)
        return StepLoads(*parts, np.concatenate([each.at(number) for each in self.friction]))


@dataclass(frozen=True)
class ContactState:
    """Solution of the interface problem, in the weighted quantities of `interface`.

    Attributes:
        status: (N,) OPEN, STICK or SLIP.
        direction: (N, d-1) unit vector of the shear traction at slipping nodes, else zero.
        traction: (N, d) y: pressure, then shear on body 2.
        relative: (N, d) w: gap, then tangential displacement of body 2 relative to body 1.
        coordinates: (m,) c.
        forces: (m,) R.
    """

    status: Status
    direction: Array
    traction: Array
    relative: Array
    coordinates: Array
    forces: Array

    @property
    def closed(self) -> Bools:
        """(N,) nodes in contact."""
        return self.status != OPEN


def unloaded(interface: Interface) -> ContactState:
    """The state before the first step: bodies in place, no traction anywhere."""
    n, d, m = interface.size, interface.components, len(interface.coordinates)
    return ContactState(
        status=np.full(n, OPEN, np.int8),
        direction=np.zeros((n, d - 1)),
        traction=np.zeros((n, d)),
        relative=interface.gap.reshape(n, d),
        coordinates=np.zeros(m),
        forces=np.zeros(m),
    )


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
        direction = np.where(turn[:, None], unit(trial, length), guess.direction)
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
            direction[held_back] = -unit(increment, moved)[held_back]
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


def unit(vectors: Array, length: Array) -> Array:
    """(n, k) vectors divided by their lengths; zero stays zero."""
    return vectors / np.where(length > 0, length, 1.0)[:, None]


@dataclass(frozen=True)
class Certificate:
    """Largest violations of the contact conditions in one step; zero is perfect.

    Lengths in the length unit, tractions in the stress unit.

    Attributes:
        penetration: largest penetration of a nodal mean gap.
        adhesion: largest tension at a node.
        open_traction: largest traction at an open node.
        closed_gap: largest gap at a node in contact.
        cone: largest excess of the shear over f times the pressure.
        stuck_drift: largest movement of a stuck node in this step.
        slip_with_traction: largest slip increment along, or across, the traction it should oppose.
        dissipation: work of the slip of the step against the shear at its end, per unit thickness
            (must not be negative).
        pressure_scale: largest pressure, the scale of the tractions.
        gap_scale: largest gap, or displacement by a coordinate or loads: the scale of the lengths.
    """

    penetration: float
    adhesion: float
    open_traction: float
    closed_gap: float
    cone: float
    stuck_drift: float
    slip_with_traction: float
    dissipation: float
    pressure_scale: float
    gap_scale: float

    @property
    def worst(self) -> float:
        """Largest violation relative to its scale."""
        tractions = max(0.0, self.adhesion, self.open_traction, self.cone)
        lengths = max(self.penetration, self.closed_gap, self.stuck_drift, self.slip_with_traction)
        return max(tractions / self.pressure_scale, lengths / self.gap_scale)


def certify(
    interface: Interface, loads: StepLoads, state: ContactState, reference: Array
) -> Certificate:
    """Check a state against the contact conditions.

    Args:
        interface: the interface problem.
        loads: loads of the step.
        state: solution at the end of the step.
        reference: (N, d-1) tangential displacement before the step.
    """
    roots = interface.roots[:, None]
    traction, relative = state.traction / roots, state.relative / roots
    relative_slip = state.relative[:, 1:] - reference
    increment = relative_slip / roots
    pressure, shear = traction[:, 0], np.linalg.norm(traction[:, 1:], axis=1)
    gap = relative[:, 0]
    motion = (interface.motion * state.coordinates).reshape(*relative.shape, -1) / roots[..., None]
    by_loads = (interface.loads @ loads.amplitudes).reshape(relative.shape) / roots
    missed = np.zeros(len(state.status))
    if loads.approach is not None:
        missed = (
            interface.approach(state.traction, state.relative) - loads.approach
        ) / interface.roots
    opened, stuck, slipping = (state.status == s for s in (OPEN, STICK, SLIP))
    along = np.einsum("ij,ij->i", increment, state.direction)
    directed = np.any(state.direction != 0, axis=1)  # without friction there is no direction
    across = np.linalg.norm(increment - along[:, None] * state.direction, axis=1)
    astray = np.where(directed, np.maximum(along, across), 0.0)
    return Certificate(
        penetration=_largest(-gap),
        adhesion=_largest(-pressure),
        open_traction=_largest(np.abs(traction[opened]).ravel()),
        closed_gap=_largest(np.abs(gap + missed)[~opened]),
        cone=_largest(shear - loads.friction * np.maximum(pressure, 0.0)),
        stuck_drift=_largest(np.abs(increment[stuck]).ravel()),
        slip_with_traction=_largest(astray[slipping]),
        dissipation=-np.einsum("ij,ij->", state.traction[:, 1:], relative_slip),
        pressure_scale=max(_largest(pressure), np.finfo(float).tiny),
        gap_scale=max(
            _largest(np.abs(relative).ravel()),
            _largest(np.abs(motion).ravel()),
            _largest(np.abs(by_loads).ravel()),
            np.finfo(float).tiny,
        ),
    )


def friction_work(
    before: ContactState,
    after: ContactState,
    friction: Array,
    contacts: Iterable[slice],
    roots: Array,
) -> Array:
    """(N,) friction work done at each node on the way between two states, per unit thickness.

    A node slips while its shear is on the bound, so that it loses the integral of f p over its
    slip, whatever way it takes. The pressure is taken as linear in time.

    Args:
        before: the state before.
        after: the state after.
        friction: (N,) coefficient on the way.
        contacts: nodes of each contact.
        roots: (N,) roots of the weights, by which lengths and tractions are multiplied.
    """
    slip = lengths(after.relative[:, 1:] - before.relative[:, 1:])
    pressures = np.maximum([before.traction[:, 0], after.traction[:, 0]], 0.0)
    stays = before.closed & after.closed
    # It slips all of the way if it did so before, in the same sense.
    goes_on = (before.status == SLIP) & (dot(before.direction, after.direction) > 0)
    late = np.where(goes_on, GOING_ON, BEGINNING)
    works = np.where(
        stays, (1 - late) * pressures[0] + late * pressures[1], PASSED_BY * pressures.sum(axis=0)
    )
    for nodes in contacts:
        # Motion before a node touches, or after it has parted, is no slip: nodes in contact tell.
        true = slip[nodes] / roots[nodes]
        largest = true[stays[nodes]].max(initial=0.0)
        slip[nodes] = np.minimum(true, largest) * roots[nodes]
    return np.where(after.status == STICK, 0.0, friction * works * slip)


def _largest(values: Array) -> float:
    return float(max(values.max(initial=0.0), 0.0))


def turns(
    before: ContactState, after: ContactState, bound: Array, nodes: slice, normal: Array
) -> bool:
    """True if a contact begins to slide as a whole between two states, or parts, while P changes.

    A flank that slid under its load jams when that falls: it sticks, P grows, and only then does it
    slide back. Both ends of the step know nothing of that. Where P is constant they know all of it.

    Args:
        before: weighted tractions and displacements.
        after: the later ones.
        bound: (N,) weighted f p before.
        nodes: of the contact.
        normal: (3,) P before and after, and the largest one.
    """
    begin, end, largest = normal
    if abs(end - begin) <= SAME_FORCE * max(begin, end):
        return False
    if end <= SAME_FORCE * largest:
        return bool(begin > LAST_FORCE * largest)
    if np.any(after.status[nodes] == STICK):
        return False
    way = before.relative[nodes, 1:] - after.relative[nodes, 1:]
    done, possible = np.sum(before.traction[nodes, 1:] * way), bound[nodes] @ lengths(way)
    return bool(not done >= GOES_ON * possible > 0)
