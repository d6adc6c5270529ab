# SPDX-License-Identifier: LGPL-3.0-or-later
"""States of another run, with which a history begins: other loads, friction or layers follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Indices
from fretfe.case import Case, complaint
from fretfe.case.overrides import by_key
from fretfe.contact.interface import Interface, Place
from fretfe.contact.recorder import COUNTS, VIOLATIONS, Accepted
from fretfe.contact.state import SLIP, ContactState
from fretfe.errors import CaseError, ModelError, OutputError
from fretfe.history.solution import ContactHistory, Solution
from fretfe.history.state_array import blocks
from fretfe.loads import History
from fretfe.loads.history import SAME_TIME, SAME_VALUE
from fretfe.mesh.mesh import BodyMesh
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.results.writer import ARRAYS
from fretfe.surface.friction import Friction

# Keys of a case that may differ from those of the run; the mesh itself is compared.
FREE: dict[str, Any] = {
    **dict.fromkeys(("title", "units", "geometry", "cycle", "edges", "output", "start"), True),
    "contacts": {"__all__": {"friction", "friction_from", "layer", "gap"}},
    "loads": {"__all__": {"history"}},
}


@dataclass(frozen=True)
class Beginning:
    """The first steps of a history, as another run solved them.

    Attributes:
        place: of the run, for messages.
        solution: that run, at the ends of its steps.
        bodies: its meshes.
        last: its state from which the history goes on.
    """

    place: str
    solution: Solution
    bodies: Mapping[str, BodyMesh]
    last: int

    def friction(self, contact: str, own: Friction, steps: Indices) -> Friction:
        """Coefficients of a contact in states of steps (T,): those of the run until its end.

        Args:
            contact: its name.
            own: (T,) those of the case.
            steps: (T,) number of the step in which each state lies.
        """
        known = self._patches(contact)[0].friction
        before = known.number[np.minimum(steps, self.last)]
        return Friction(
            np.concatenate([known.fields, own.fields]),
            np.where(steps <= self.last, before, len(known.fields) + own.number),
            own.by_pressure,
        )

    def states(self, interface: Interface, places: Sequence[Place]) -> Iterator[Accepted]:
        """The states behind the unloaded one, in the weighted quantities of an interface."""
        named = np.array([each.control != "free" for each in interface.coordinates], dtype=bool)
        solution, free = self.solution, self.solution.free
        assert free is not None  # as of `read_beginning`
        violations = [solution.certificates[name] for name in (*VIOLATIONS, "worst")]
        for block in blocks(self.last, interface.size * interface.components):
            numbers = np.arange(block.start, block.stop) + 1
            arrays = [self._of_contact(interface, place.name, numbers) for place in places]
            whole = {key: np.concatenate([each[key] for each in arrays], 1) for key in arrays[0]}
            work, friction = whole.pop("dissipation"), whole.pop("friction")
            coordinates, forces = np.zeros((2, len(numbers), len(named)))
            coordinates[:, named], forces[:, named] = (
                each[numbers] for each in (solution.amplitudes, solution.forces)
            )
            coordinates[:, ~named] = free[numbers]
            whole |= {"coordinates": coordinates, "forces": forces}
            for place, number in enumerate(numbers.tolist()):
                yield Accepted(
                    ContactState(**{name: each[place] for name, each in whole.items()}),
                    work[place],
                    number,
                    1.0,
                    np.array([getattr(solution, name)[number] for name in COUNTS]),
                    np.array([each[number] for each in violations]),
                    friction[place],
                )

    def _patches(self, contact: str) -> list[ContactHistory]:
        """The patches of a pair, each of which carries nothing outside its own part."""
        return [each for each in self.solution.contacts if each.pair == contact]

    def _of_contact(
        self, interface: Interface, contact: str, states: Indices
    ) -> dict[str, NDArray[Any]]:
        """(n, N, ...) arrays of states at the nodes of a contact, as of `Accepted`."""
        patches, roots = self._patches(contact), interface.roots[interface.contacts[contact]]
        status = np.max([each.status[states] for each in patches], axis=0).astype(np.int8)
        traction = np.sum([each.traction[states] for each in patches], axis=0) * roots[:, None]
        relative = np.concatenate(
            [np.asarray(patches[0].gap[states])[..., None], -patches[0].slip[states]], axis=-1
        )
        shear = np.where((status == SLIP)[..., None], traction[..., 1:], 0.0)
        size = np.linalg.norm(shear, axis=-1, keepdims=True)
        return {
            "status": status,
            "direction": shear / np.where(size > 0, size, 1.0),
            "traction": traction,
            "relative": relative * roots[:, None],
            "dissipation": np.sum([each.dissipation[states] for each in patches], axis=0),
            "friction": patches[0].friction.at(states),
        }

    def require_same(
        self, bodies: Mapping[str, BodyMesh], interface: Interface, places: Sequence[Place]
    ) -> None:
        """Check that a model has the nodes and the rigid boundaries of the run.

        Raises:
            ModelError: it has others.
        """
        for name, body in bodies.items():
            known = self.bodies[name].points
            if known.shape != body.points.shape or not np.array_equal(known, body.points):
                raise ModelError(
                    f"{self.place}: expected the mesh of that run, found other nodes of {name} "
                    f"({len(body.points)}, there {len(known)}): use its mesh files, or the same "
                    "geometry and element sizes"
                )
        for place in places:
            if len(self._patches(place.name)[0].surface.weights) != len(place.surface.weights):
                raise ModelError(f"{self.place}: expected the nodes of {place.name} of that run")
        labels = tuple(each.label for each in interface.coordinates if each.control != "free")
        if labels != self.solution.coordinates:
            raise ModelError(
                f"{self.place}: expected the rigid boundaries of that run, "
                f"{', '.join(self.solution.coordinates) or 'none'}, found "
                f"{', '.join(labels) or 'none'}"
            )


def read_beginning(case: Case, history: History) -> Beginning | None:
    """The states from which a case goes on; None of one that begins unloaded.

    Args:
        case: the case.
        history: its loads.

    Raises:
        CaseError: there is no such run, state or tractions, or model or loads until then differ.
    """
    if case.start is None:
        return None
    path = case.resolve(case.start.results)
    try:
        stamp = (path / ARRAYS).stat() if (path / ARRAYS).exists() else None
        run = _loaded(path, stamp and (stamp.st_mtime_ns, stamp.st_size))
    except OutputError as error:
        raise CaseError(complaint(case.source, ("start", "from"), str(error))) from None
    if (problem := _difference(case, run)) is not None:
        raise CaseError(complaint(case.source, ("start", "from"), f"{path}: {problem}"))
    state = run.loads.step(case.start.time)
    if abs(run.loads.times[state] - case.start.time) > SAME_TIME * run.loads.times[-1]:
        text = f"expected the time of a state of {path}, found {case.start.time:.10g}; the "
        text += f"nearest one is at {run.loads.times[state]:.10g}"
        raise CaseError(complaint(case.source, ("start", "time"), text))
    _require_loads(case, history, run.loads, state)
    return Beginning(f"{case.source}: start.from: {path}", run.solution, run.bodies, state)


@lru_cache(maxsize=1)
def _loaded(path: Path, _stamp: tuple[int, int] | None) -> Result:
    """A run, read once for its check and its states."""
    return load_result(path)


def _difference(case: Case, run: Result) -> str | None:
    """The reason why a case cannot go on from a run, or None."""
    if run.root_solution is None or run.solution.free is None or run.backend != "fem":
        return "expected a run of the backend fem with its tractions, found none"
    assert case.start is not None
    state = run.loads.step(case.start.time)
    if not run.solution.keeps(0, state):
        return (
            f"expected its tractions in all states until {case.start.time:g}: "
            'run it with [output] tractions = "all"'
        )
    one, other = (
        by_key(each.model_dump(mode="json", exclude=FREE, by_alias=True))
        for each in (case, run.case)
    )
    # Loads that one of the two lacks act later, if at all.
    shared = case.loads.keys() & run.case.loads.keys()
    for key in dict.fromkeys([*one, *other]):
        table, name, *_ = *key.split("."), ""
        if one.get(key) != other.get(key) and (table != "loads" or name in shared):
            return f"expected {key} of that run, {other.get(key)}, found {one.get(key)}"
    return None


def _require_loads(case: Case, history: History, run: History, state: int) -> None:
    """Check that the loads until a state are those of a run.

    Raises:
        CaseError: names the first load and time that are not.
    """
    times = history.times[: state + 1]
    slack = SAME_TIME * float(run.times[-1])
    if len(times) <= state or np.abs(times - run.times[: state + 1]).max() > slack:
        text = f"expected the {state} steps of that run until then, found steps at other times"
        raise CaseError(complaint(case.source, ("start", "time"), text))
    own = dict(zip(history.channels, history.values.T, strict=True))
    known = dict(zip(run.channels, run.values.T, strict=True))
    for name in dict.fromkeys([*known, *own]):
        values, there = (each.get(name, np.zeros(state + 1))[: state + 1] for each in (own, known))
        apart = np.abs(values - there) > SAME_VALUE * np.abs(there).max(initial=0.0)
        if apart.any():
            first = int(np.argmax(apart))
            text = f"expected the loads of start.from until {run.times[state]:g}, "
            text += f"{there[first]:g} at {times[first]:g}, found {values[first]:g}"
            raise CaseError(complaint(case.source, ("loads", name, "history"), text))
