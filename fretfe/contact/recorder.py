# SPDX-License-Identifier: LGPL-3.0-or-later
"""Record of accepted steps, and the `Solution` in physical units that it makes.

States go to files while the history is solved; in memory are a few numbers for each of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.full_stick import Change, FullStickSolver, Increments, find_drivers
from fretfe.contact.interface import Interface, Place, digest_of
from fretfe.contact.march import March, Part, parts_by_turning
from fretfe.contact.state import Certificate, ContactState, StepLoads, StepTable, unloaded
from fretfe.history.solution import ContactHistory, FullStickUnits, Repeat, Solution
from fretfe.history.state_array import StateArray, blocks, mapped, part
from fretfe.history.stream import UNSEEN, Checkpoint, StateStream, Storage, write_checkpoint
from fretfe.loads import History
from fretfe.surface.friction import Friction

# Tractions and gaps below this fraction of what the motion of the bodies would cause are round-off.
ROUND_OFF = 1e-9
# Counts of a step, and violations of the contact conditions, as `Solution` has them.
COUNTS = ("iterations", "parts", "fallbacks")
VIOLATIONS = tuple(field.name for field in fields(Certificate))


@dataclass(frozen=True)
class StateBlock:
    """Some successive states with their loads, in the weighted quantities of the interface.

    Attributes:
        states: their numbers.
        traction: (n, N*d) y.
        coordinates: (n, m) c.
        forces: (n, m) R.
        amplitudes: (n, l) load amplitudes.
    """

    states: slice
    traction: Array
    coordinates: Array
    forces: Array
    amplitudes: Array


@dataclass(frozen=True)
class Accepted:
    """A state that was accepted by another history, and what it took.

    Attributes:
        state: the state.
        dissipation: (N,) friction work on the way to it, of its step or part of a step.
        step: number of the step in which it lies.
        share: of the step at which it is reached.
        counts: as of `COUNTS`.
        violations: as of `VIOLATIONS`, and the worst.
        friction: (N,) coefficient that acted on the way.
    """

    state: ContactState
    dissipation: Array
    step: int
    share: float
    counts: NDArray[Any]
    violations: Array
    friction: Array


@dataclass
class Extent:
    """Extremes over all states recorded so far.

    Attributes:
        smallest_gap: smallest nodal gap.
        largest_gap: largest nodal gap, without its sign.
        carried: largest ratio of what pressure deforms the bodies by in a state to the largest
            weighted displacement of a node by the coordinates in that state.
        first_gap: smallest nodal gap of the first one, which is without load.
    """

    smallest_gap: float = np.inf
    largest_gap: float = 0.0
    carried: float = 0.0
    first_gap: float = np.nan

    def add(self, interface: Interface, state: ContactState) -> None:
        """Extend it by a state."""
        gap = state.relative[:, 0] / interface.roots
        moved = np.abs(interface.motion * state.coordinates)
        self.smallest_gap = min(self.smallest_gap, float(gap.min()))
        self.first_gap = self.smallest_gap if np.isnan(self.first_gap) else self.first_gap
        self.largest_gap = max(self.largest_gap, float(np.abs(gap).max()))
        pressed = interface.compliance.level * float(state.traction[:, 0].max())
        motion = float(moved.max(initial=0.0))
        if pressed > 0:
            self.carried = max(self.carried, pressed / motion if motion else np.inf)


class Recorder:
    """All accepted states, and the full-stick increments of every contact area met.

    Args:
        march: advances the states; the full-stick increments share its interface operator.
        places: the contacts, in the order of the interface.
        steps: loads of all steps, the unloaded state first.
        channels: channel of each distributed load of the interface.
        degree: of the displacements.
        storage: where the states go, and whether those that are there already are continued.

    Attributes:
        places: the contacts.
        drivers: loads that have a full-stick increment.
        count: number of states recorded so far, those within steps included.
        last: the last one.
        marks: (T, 2) sums over tractions and displacements, the same for the same states.
        repeats: steps that were not solved because they repeat earlier ones.

    Raises:
        OutputError: if there is no place for the states, or those that are to be continued belong
            to something else.
    """

    def __init__(
        self,
        march: March,
        places: Sequence[Place],
        steps: StepTable,
        channels: list[str],
        degree: int,
        storage: Storage = UNSEEN,
    ) -> None:
        interface = march.interface
        self._interface: Interface = interface
        self.places = places
        self._degree = degree
        self._steps = steps
        self.drivers = find_drivers(interface, channels)
        self._full_stick = FullStickSolver(march.operator, self.drivers)
        self._storage = storage
        self._operator = march.operator
        self._identity = {
            **storage.identity,
            "contact surfaces": digest_of(places),
            "loads": steps.digest,
        }
        self._by_state = _room(len(steps))
        self._ends = np.zeros(len(steps), dtype=np.int64)
        self._areas: dict[bytes, int] = {}
        self._extent = Extent()
        self._solved = 0
        self.count = 0
        self.repeats: tuple[Repeat, ...] = ()
        known = storage.continued(self._identity)
        self._stream = StateStream(storage.directory, known.kinds if known else None)
        if known is None:
            nothing = np.zeros(interface.size)
            self._keep(unloaded(interface), nothing, 0, 1.0, nothing)
        else:
            self._recall(known.arrays)

    def note(self) -> None:
        """Write down all that it takes to continue from the last state, if there is a folder."""
        if self._storage.directory is None:
            return
        kinds = self._stream.flush()
        areas = [np.frombuffer(key, np.uint8) for key in self._areas]
        arrays: dict[str, NDArray[Any]] = {
            **{name: values[: self.count] for name, values in self._by_state.items()},
            "areas": np.array(areas) if areas else np.empty((0, 0), np.uint8),
            "extent": np.array(astuple(self._extent)),
            "solved": np.array(self._solved),
            "repeats": np.array([astuple(each) for each in self.repeats], np.int64).reshape(-1, 3),
            **self._operator.memory(),
        }
        write_checkpoint(self._storage.directory, Checkpoint(self._identity, kinds, arrays))

    def settle(self) -> None:
        """Write all states to their file: from now on it is only read, unless steps are added."""
        self._stream.settle()

    def _recall(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        self.count = len(arrays["rows"])
        self._make_room(self.count)
        for name, values in self._by_state.items():
            values[: self.count] = arrays[name]
        self._find_ends(slice(0, self.count))
        self._areas = {key.tobytes(): number for number, key in enumerate(arrays["areas"])}
        self._extent = Extent(*arrays["extent"].tolist())
        self._solved = int(arrays["solved"])
        self.repeats = tuple(Repeat(*each) for each in arrays["repeats"].tolist())
        self._operator.recall(arrays)
        self.last = self.state(self.count - 1)

    def begin_like(self, other: Recorder, last: int) -> None:
        """Record the states that another history has before the two differ.

        Args:
            other: a record of the same march.
            last: step after which its states may depend on more than loads.
        """
        self.begin_with(other._accepted(n) for n in range(1, self._alike(other, last) + 1))

    def begin_with(self, known: Iterable[Accepted]) -> None:
        """Record states that another history has, from the first step on."""
        for each in known:
            number = self.count
            self._keep(each.state, each.dissipation, each.step, each.share, each.friction)
            self._by_state["counts"][number] = each.counts
            self._by_state["violations"][number] = each.violations
            self._by_state["area_of_state"][number] = self._area_of(each.state)
        self._find_ends(slice(0, self.count))

    def _accepted(self, state: int) -> Accepted:
        row, known = self._by_state["rows"][state : state + 1], self._by_state
        return Accepted(
            self.state(state),
            self._stream.read("dissipation", row)[0],
            int(known["step"][state]),
            float(known["share"][state]),
            known["counts"][state],
            known["violations"][state],
            self._friction_at(state),
        )

    def _alike(self, other: Recorder, last: int) -> int:
        """The last state of another record that this history has too, in as many parts of steps."""
        last = min(last, other.steps_done, len(self._steps) - 1)
        if other.repeats:
            last = min(last, int(other._by_state["step"][other.repeats[0].first]) - 1)
        states = slice(0, int(other.ends[last]) + 1)
        steps, shares = (other._by_state[name][states] for name in ("step", "share"))
        turns = [parts_by_turning(each._steps)[steps] for each in (self, other)]
        one, two = (each._steps.divided(steps, shares) for each in (self, other))
        different = turns[0] != turns[1]
        for name in ("amplitudes", "values"):
            different |= (getattr(one, name) != getattr(two, name)).any(axis=1)
        for mine, others in zip(one.friction, two.friction, strict=True):
            different |= mine.differs(others)
        first = int(steps[different].min(initial=last + 1))
        return int(other.ends[first - 1]) if first else 0

    def add(self, step: int, parts: Sequence[Part]) -> None:
        """Record an accepted step with its parts."""
        for part_of_step in parts:
            result, share = part_of_step.result, part_of_step.share
            number = self.count
            self._keep(result.state, result.dissipation, step, share, result.friction)
            certificate, violations = result.certificate, self._by_state["violations"][number]
            self._by_state["counts"][number] = [getattr(result, name) for name in COUNTS]
            violations[:-1] = [getattr(certificate, name) for name in VIOLATIONS]
            violations[-1] = certificate.worst
            self._by_state["area_of_state"][number] = self._area_of(result.state)
        self._ends[step] = self.count - 1

    def _area_of(self, state: ContactState) -> int:
        """Number of the contact area of a state; -1 without."""
        if not state.closed.any():
            return -1
        return self._areas.setdefault(np.packbits(state.closed).tobytes(), len(self._areas))

    def _find_increments(self) -> None:
        """Find the increments of all areas met so far.

        Not before they are asked for: where a contact slides at first, each would take a
        factorisation, which the steps that stick make only later.
        """
        for area in range(self._stream.count("increments"), len(self._areas)):
            state = self.state(int(np.argmax(self._by_state["area_of_state"] == area)))
            increments = self._full_stick.increments(state.closed, state.relative[:, 0])
            self._stream.append(
                {"increments": increments.traction, "increment_motions": increments.coordinates}
            )

    def _keep(
        self, state: ContactState, dissipation: Array, step: int, share: float, friction: Array
    ) -> None:
        arrays = {field.name: getattr(state, field.name) for field in fields(ContactState)}
        own = {"friction": friction} if self._steps.by_pressure else {}
        self._stream.append({**arrays, **own, "dissipation": dissipation})
        self._extent.add(self._interface, state)
        self._make_room(self.count + 1)
        self._by_state["rows"][self.count] = self._solved
        marks = np.abs(state.traction).sum(), np.abs(state.relative).sum()
        self._by_state["marks"][self.count] = marks
        self._by_state["step"][self.count], self._by_state["share"][self.count] = step, share
        self._solved += 1
        self.count += 1
        self.last = state

    def _make_room(self, count: int) -> None:
        """Let there be room for so many states in memory."""
        have = len(self._by_state["rows"])
        if count > have:
            more = _room(max(count - have, have // 2))
            for name, values in self._by_state.items():
                self._by_state[name] = np.concatenate([values, more[name]])

    def repeat(self, repeat: Repeat) -> None:
        """Record the next steps, with their parts, as those that they repeat."""
        states = _states_of(repeat, self.ends)
        new, source = slice(states.first, states.last + 1), states.source
        self._make_room(new.stop)
        for each in self._by_state.values():
            each[new] = each[source]
        rounds = 1 + np.arange(len(source)) // states.period
        self._by_state["step"][new] += repeat.period * rounds
        self._find_ends(new)
        self.count = new.stop
        self.last = self.state(self.count - 1)
        self.repeats = (*self.repeats, repeat)

    @property
    def steps_done(self) -> int:
        """Number of the last step that is recorded."""
        return int(self._by_state["step"][self.count - 1])

    @property
    def ends(self) -> Indices:
        """(n + 1,) states at the ends of the n steps recorded so far, the unloaded one first."""
        return self._ends[: self.steps_done + 1]

    def _find_ends(self, states: slice) -> None:
        """Note which of some states are the ends of steps."""
        found = states.start + np.flatnonzero(self._by_state["share"][states] == 1.0)
        self._ends[self._by_state["step"][found]] = found

    def mark(self, state: int) -> Array:
        """(2,) sums over tractions and displacements, the same for the same states."""
        return np.asarray(self._by_state["marks"][state])

    def state(self, number: int) -> ContactState:
        """One of the states."""
        row = self._by_state["rows"][number : number + 1]
        names = [field.name for field in fields(ContactState)]
        return ContactState(**{name: self._stream.read(name, row)[0] for name in names})

    @property
    def last_loads(self) -> StepLoads:
        """Loads of the last state."""
        return self._steps[self.steps_done]

    @property
    def loads(self) -> StepTable:
        """Loads of the states recorded so far."""
        steps, shares = (self._by_state[name][: self.count] for name in ("step", "share"))
        if self._steps.by_pressure:
            return replace(self._steps.divided(steps, shares), friction=self._friction())
        if self.count == len(self._steps) and np.all(shares == 1.0):
            return self._steps
        return self._steps.divided(steps, shares)

    def _friction(self) -> tuple[Friction, ...]:
        """Coefficients that acted in the states recorded so far, of each contact."""
        found = self._stream.read("friction", np.arange(self._solved))
        rows = self._by_state["rows"][: self.count]
        return tuple(Friction(found[:, nodes], rows) for nodes in self._interface.contacts.values())

    def _friction_at(self, state: int) -> Array:
        """(N,) coefficients that acted in the step to a state."""
        if self._steps.by_pressure:
            row = self._by_state["rows"][state : state + 1]
            return np.asarray(self._stream.read("friction", row)[0])
        return self._steps[int(self._by_state["step"][state])].friction

    def nodes_of(self, contact: str) -> slice:
        """Range of the nodes of a contact among all nodes."""
        return self._interface.contacts[contact]

    def increments(self, area: int) -> Increments:
        """Full-stick increments of a contact area."""
        self._find_increments()
        row = np.array([area])
        traction, motions = (
            self._stream.read(name, row)[0] for name in ("increments", "increment_motions")
        )
        return Increments(traction, motions)

    def mean_increments(self, number: int, areas: Sequence[Bools]) -> Increments:
        """Mean of the full-stick increments in contact areas that resemble that of a state.

        Args:
            number: of the state.
            areas: for each area the nodes in contact (N,), of all contacts.
        """
        gap = self.state(number).relative[:, 0]
        return Increments.mean([self._full_stick.increments(area, gap) for area in areas])

    @property
    def has_cuts(self) -> bool:
        """True if another run moves a boundary."""
        return self._full_stick.has_cuts

    def both_ways(self, first: int, second: int) -> tuple[Array, Array]:
        """(N, d) weighted tractions of `FullStickSolver.both_ways` between two states."""
        one, two = self.state(first), self.state(second)
        loads = self.loads.amplitudes
        change = Change(
            two.forces - one.forces, two.coordinates - one.coordinates, loads[second] - loads[first]
        )
        return self._full_stick.both_ways(two.closed, two.relative[:, 0], change)

    def requests(self, steps: list[int]) -> list[tuple[ContactState, StepLoads]]:
        """States at the ends of some steps with their loads, to recover displacements from."""
        ends = self.ends
        return [(self.state(int(ends[number])), self._steps[number]) for number in steps]

    def relative(self, nodes: slice) -> StateArray:
        """(n + 1, N, d) weighted displacements w of body 2 relative to body 1 at some nodes.

        At the ends of the n steps recorded so far.
        """
        return self._stream.rows("relative", self._by_state["rows"][self.ends], nodes)

    def blocks(self) -> Iterator[StateBlock]:
        """All states recorded so far, block by block."""
        interface, amplitudes = self._interface, self.loads.amplitudes
        for states in blocks(self.count, interface.size * interface.components):
            rows = self._by_state["rows"][states]
            traction, coordinates, forces = (
                self._stream.read(name, rows) for name in ("traction", "coordinates", "forces")
            )
            yield StateBlock(
                states,
                traction.reshape(len(rows), -1),
                coordinates,
                forces,
                amplitudes[states],
            )

    @property
    def first_gap(self) -> float:
        """Smallest nodal gap without load."""
        return self._extent.first_gap

    @property
    def smallest_gap(self) -> float:
        """Smallest nodal gap over all states."""
        return self._extent.smallest_gap

    @property
    def gap_round_off(self) -> float:
        """Gap below which surfaces count as touching."""
        return ROUND_OFF * self._extent.largest_gap

    @property
    def contact_carries(self) -> bool:
        """True if any contact deforms the bodies by more than round-off of their motion.

        Of that in the same state: where bodies part, a force that is round-off itself may move them
        anywhere.
        """
        return self._extent.carried > ROUND_OFF

    @property
    def bodies_restrained_by_contact(self) -> list[str]:
        """Bodies with rigid modes restrained only by contact."""
        coordinates = self._interface.coordinates
        return sorted({c.body for c in coordinates if c.control == "free"})

    def solution(self, history: History, balance: dict[str, Array]) -> Solution:
        """Everything recorded so far, in physical units.

        Args:
            history: the loads.
            balance: (T,) measures of equilibrium by name, stored with the certificates.
        """
        count, interface = self.count, self._interface
        known = {name: values[:count] for name, values in self._by_state.items()}
        loads, table = history.divided(known["step"], known["share"]), self.loads
        forces, coordinates = (
            self._stream.read(name, known["rows"]) for name in ("forces", "coordinates")
        )
        complete = self.steps_done == len(history.times) - 1
        is_free = np.array([c.control == "free" for c in interface.coordinates], dtype=bool)
        named = np.flatnonzero(~is_free)
        violations = dict(zip((*VIOLATIONS, "worst"), known["violations"].T, strict=True))
        ends = self.ends
        return Solution(
            degree=self._degree,
            times=loads.times,
            channels=history.channels,
            values=loads.values,
            cycle=loads.cycle if complete else None,
            coordinates=tuple(interface.coordinates[j].label for j in named),
            amplitudes=coordinates[:, named],
            forces=forces[:, named],
            drivers=self.drivers.names,
            driver_values=self.drivers.values(forces, table.amplitudes),
            contacts=tuple(
                self._contact(*each) for each in zip(self.places, table.friction, strict=True)
            ),
            **dict(zip(COUNTS, known["counts"].T, strict=True)),
            certificates=violations | balance,
            between=loads.between if complete else None,
            repeats=tuple(_states_of(each, ends) for each in self.repeats),
            step=None if len(ends) == count else known["step"],
            choice=loads.choice if complete else None,
            free=coordinates[:, is_free],
        )

    def _contact(self, place: Place, friction: Friction) -> ContactHistory:
        interface = self._interface
        nodes = interface.contacts[place.name]
        roots = interface.roots[nodes]
        relative, averaging = self._part("relative", nodes), place.averaging
        traction = mapped(self._part("traction", nodes), lambda y, _: y / roots[:, None])
        return ContactHistory(
            name=place.name,
            pair=place.name,
            body1=place.body1,
            body2=place.body2,
            surface=place.surface,
            friction=friction,
            traction=traction,
            mean_traction=mapped(traction, lambda t, _: np.array([averaging @ each for each in t])),
            gap=mapped(part(relative, 0), lambda w, _: w / roots),
            slip=mapped(part(relative, slice(1, None)), lambda w, _: -w / roots[:, None]),
            status=self._part("status", nodes),
            dissipation=self._part("dissipation", nodes),
            full_stick=FullStickUnits(
                fields=self._unit_fields(nodes, roots),
                area=self._by_state["area_of_state"][: self.count],
            ),
        )

    def _part(self, name: str, nodes: slice) -> StateArray:
        """A data set of all states recorded so far at some nodes."""
        return self._stream.rows(name, self._by_state["rows"][: self.count], nodes)

    def _unit_fields(self, nodes: slice, roots: Array) -> StateArray | Array:
        """(U, n, d, J) full-stick tractions of all contact areas at some nodes."""
        if not self._areas:
            shape = (0, len(roots), self._interface.components, len(self.drivers.names))
            return np.zeros(shape)
        self._find_increments()
        areas: Indices = np.arange(len(self._areas))
        weighted = self._stream.rows("increments", areas, nodes)
        return mapped(weighted, lambda y, _: y / roots[:, None, None])


def _room(count: int) -> dict[str, NDArray[Any]]:
    """Arrays in memory for some states, by name; see `Recorder`."""
    return {
        "rows": np.zeros(count, dtype=np.int64),
        "step": np.zeros(count, dtype=np.int64),
        "share": np.zeros(count),
        "area_of_state": np.full(count, -1),
        "counts": np.zeros((count, len(COUNTS)), dtype=np.int32),
        "violations": np.zeros((count, len(VIOLATIONS) + 1)),
        "marks": np.zeros((count, 2)),
    }


def _states_of(repeat: Repeat, ends: Indices) -> Repeat:
    """Repeated steps as the states that they are made of.

    Args:
        repeat: of steps.
        ends: (n,) states at the ends of the steps before them at least.
    """
    before = repeat.first - 1
    begin, period = ends[before - repeat.period], ends[before] - ends[before - repeat.period]
    rounds, rest = divmod(repeat.last - before, repeat.period)
    count = rounds * period + ends[before - repeat.period + rest] - begin
    return Repeat(int(ends[before]) + 1, int(ends[before] + count), int(period))
