# SPDX-License-Identifier: LGPL-3.0-or-later
"""Record of accepted steps, and the `Solution` in physical units that it makes.

States go to files while the history is solved; in memory are a few numbers for each of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.certificate import Certificate
from fretfe.contact.full_stick import FullStickSolver, Increments, find_drivers
from fretfe.contact.interface import Interface
from fretfe.contact.march import March, StepResult
from fretfe.contact.place import Place, digest_of
from fretfe.contact.state import ContactState, StepLoads, StepTable, unloaded
from fretfe.loads import History
from fretfe.results.checkpoint import UNSEEN, Checkpoint, Storage, write_checkpoint
from fretfe.results.solution import ContactHistory, FullStickUnits, Repeat, Solution
from fretfe.results.states import StateArray, blocks, mapped, part
from fretfe.results.stream import StateStream

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


@dataclass
class Extent:
    """Extremes over all states recorded so far.

    Attributes:
        smallest_gap: smallest nodal gap.
        largest_gap: largest nodal gap, without its sign.
        pressure: largest weighted pressure.
        motion: largest weighted displacement of a node by the coordinates.
    """

    smallest_gap: float = np.inf
    largest_gap: float = 0.0
    pressure: float = 0.0
    motion: float = 0.0

    def add(self, interface: Interface, state: ContactState) -> None:
        """Extend it by a state."""
        gap = state.relative[:, 0] / interface.roots
        moved = np.abs(interface.motion * state.coordinates)
        self.smallest_gap = min(self.smallest_gap, float(gap.min()))
        self.largest_gap = max(self.largest_gap, float(np.abs(gap).max()))
        self.pressure = max(self.pressure, float(state.traction[:, 0].max()))
        self.motion = max(self.motion, float(moved.max(initial=0.0)))


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
        drivers: loads that have a full-stick increment.
        count: number of states recorded so far.
        last: the last one.
        marks: (T, 2) sums over tractions and displacements, the same for the same states.
        repeats: states that were not solved because they repeat earlier ones.

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
        self._places = places
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
        # By state: its row in the file, its contact area.
        self._rows = np.zeros(len(steps), dtype=np.int64)
        self._area_of_state = np.full(len(steps), -1)
        self._areas: dict[bytes, int] = {}
        self._counts = np.zeros((len(steps), len(COUNTS)), dtype=np.int32)
        self._violations = np.zeros((len(steps), len(VIOLATIONS) + 1))
        self._extent = Extent()
        # What tells two states apart without reading them.
        self.marks = np.zeros((len(steps), 2))
        self._solved = 0
        self.count = 0
        self.repeats: tuple[Repeat, ...] = ()
        known = storage.continued(self._identity)
        self._stream = StateStream(storage.directory, known.kinds if known else None)
        if known is None:
            self._keep(unloaded(interface), np.zeros(interface.size))
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

    def _recall(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        for name, values in self._by_state.items():
            self.count = len(arrays[name])
            values[: self.count] = arrays[name]
        self._areas = {key.tobytes(): number for number, key in enumerate(arrays["areas"])}
        self._extent = Extent(*arrays["extent"].tolist())
        self._solved = int(arrays["solved"])
        self.repeats = tuple(Repeat(*each) for each in arrays["repeats"].tolist())
        self._operator.recall(arrays)
        self.last = self.state(self.count - 1)

    @property
    def _by_state(self) -> dict[str, NDArray[Any]]:
        """What is in memory for each state."""
        return {
            "rows": self._rows,
            "area_of_state": self._area_of_state,
            "counts": self._counts,
            "violations": self._violations,
            "marks": self.marks,
        }

    def add(self, result: StepResult) -> None:
        """Record an accepted step."""
        state, number = result.state, self.count
        self._keep(state, result.dissipation)
        self._counts[number] = [getattr(result, name) for name in COUNTS]
        certificate = result.certificate
        self._violations[number, :-1] = [getattr(certificate, name) for name in VIOLATIONS]
        self._violations[number, -1] = certificate.worst
        if not state.closed.any():
            return
        key = np.packbits(state.closed).tobytes()
        if key not in self._areas:
            self._areas[key] = len(self._areas)
            increments = self._full_stick.increments(state.closed, state.relative[:, 0])
            self._stream.append(
                {"increments": increments.traction, "increment_motions": increments.coordinates}
            )
        self._area_of_state[number] = self._areas[key]

    def _keep(self, state: ContactState, dissipation: Array) -> None:
        arrays = {field.name: getattr(state, field.name) for field in fields(ContactState)}
        self._stream.append({**arrays, "dissipation": dissipation})
        self._extent.add(self._interface, state)
        self._rows[self.count] = self._solved
        self.marks[self.count] = np.abs(state.traction).sum(), np.abs(state.relative).sum()
        self._solved += 1
        self.count += 1
        self.last = state

    def repeat(self, repeat: Repeat) -> None:
        """Record the next states as those that they repeat."""
        states, source = slice(repeat.first, repeat.last + 1), repeat.source
        for each in self._by_state.values():
            each[states] = each[source]
        self.count = repeat.last + 1
        self.last = self.state(repeat.last)
        self.repeats = (*self.repeats, repeat)

    def state(self, number: int) -> ContactState:
        """One of the states."""
        row = self._rows[number : number + 1]
        names = [field.name for field in fields(ContactState)]
        return ContactState(**{name: self._stream.read(name, row)[0] for name in names})

    @property
    def last_loads(self) -> StepLoads:
        """Loads of the last state."""
        return self._steps[self.count - 1]

    @property
    def loads(self) -> Array:
        """(T, m) values of the coordinates, as of `StepLoads`, in the states recorded so far."""
        return self._steps.values[: self.count]

    def nodes_of(self, contact: str) -> slice:
        """Range of the nodes of a contact among all nodes."""
        return self._interface.contacts[contact]

    def increments(self, area: int) -> Increments:
        """Full-stick increments of a contact area."""
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

    def requests(self, states: list[int]) -> list[tuple[ContactState, StepLoads]]:
        """Some of the states with their loads, to recover displacement fields from."""
        return [(self.state(number), self._steps[number]) for number in states]

    def relative(self, nodes: slice) -> StateArray:
        """(T, n, d) weighted displacements w of body 2 relative to body 1 at some nodes."""
        return self._part("relative", nodes)

    def blocks(self) -> Iterator[StateBlock]:
        """All states recorded so far, block by block."""
        interface = self._interface
        for states in blocks(self.count, interface.size * interface.components):
            rows = self._rows[states]
            traction, coordinates, forces = (
                self._stream.read(name, rows) for name in ("traction", "coordinates", "forces")
            )
            yield StateBlock(
                states,
                traction.reshape(len(rows), -1),
                coordinates,
                forces,
                self._steps.amplitudes[states],
            )

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
        """True if any contact deforms the bodies by more than round-off of their motion."""
        pressed = self._interface.compliance.level * self._extent.pressure
        return bool(pressed > ROUND_OFF * self._extent.motion)

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
        rows = self._rows[:count]
        forces, coordinates = (self._stream.read(name, rows) for name in ("forces", "coordinates"))
        complete = count == len(history.times)
        named = [j for j, c in enumerate(interface.coordinates) if c.control != "free"]
        violations = dict(zip((*VIOLATIONS, "worst"), self._violations[:count].T, strict=True))
        counts = dict(zip(COUNTS, self._counts[:count].T, strict=True))
        return Solution(
            degree=self._degree,
            times=history.times[:count],
            channels=history.channels,
            values=history.values[:count],
            cycle=history.cycle if complete else None,
            coordinates=tuple(interface.coordinates[j].label for j in named),
            amplitudes=coordinates[:, named],
            forces=forces[:, named],
            drivers=self.drivers.names,
            driver_values=self.drivers.values(forces, self._steps.amplitudes[:count]),
            contacts=tuple(
                self._contact(place, number) for number, place in enumerate(self._places)
            ),
            **counts,
            certificates=violations | balance,
            between=history.between if complete else None,
            repeats=self.repeats,
        )

    def _contact(self, place: Place, number: int) -> ContactHistory:
        interface = self._interface
        nodes = interface.contacts[place.name]
        roots = interface.roots[nodes]
        relative, averaging = self.relative(nodes), place.nodes.averaging
        traction = mapped(self._part("traction", nodes), lambda y, _: y / roots[:, None])
        return ContactHistory(
            name=place.name,
            pair=place.name,
            body1=place.body1,
            body2=place.body2,
            arc=place.nodes.arc,
            points=place.nodes.points,
            frames=place.nodes.frames,
            weights=place.nodes.weights,
            friction=self._steps.friction[: self.count, number],
            traction=traction,
            mean_traction=mapped(traction, lambda t, _: np.array([averaging @ each for each in t])),
            gap=mapped(part(relative, 0), lambda w, _: w / roots),
            slip=mapped(part(relative, slice(1, None)), lambda w, _: -w / roots[:, None]),
            status=self._part("status", nodes),
            dissipation=self._part("dissipation", nodes),
            full_stick=FullStickUnits(
                fields=self._unit_fields(nodes, roots), area=self._area_of_state[: self.count]
            ),
            facets=place.facets,
        )

    def _part(self, name: str, nodes: slice) -> StateArray:
        """A data set of all states recorded so far at some nodes."""
        return self._stream.rows(name, self._rows[: self.count], nodes)

    def _unit_fields(self, nodes: slice, roots: Array) -> StateArray | Array:
        """(U, n, d, J) full-stick tractions of all contact areas at some nodes."""
        if not self._areas:
            shape = (0, len(roots), self._interface.components, len(self.drivers.names))
            return np.zeros(shape)
        areas: Indices = np.arange(len(self._areas))
        weighted = self._stream.rows("increments", areas, nodes)
        return mapped(weighted, lambda y, _: y / roots[:, None, None])
