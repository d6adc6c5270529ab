# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reported states of a history whose steps were divided: those at the ends of the steps.

Ranges, slip zones and friction work are those of all states, which have been evaluated before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.contact.march import LARGEST_MOVE, MOST_PARTS
from fretfe.evaluate.contacts import Contact, Front, SlipZone, Station, StationHistory, histories
from fretfe.faults import guarded
from fretfe.history.solution import ContactHistory, FullStickUnits, Repeat, Solution
from fretfe.history.state_array import picked, summed

# Histories (T, ...) of a contact.
CONTACT = (
    "normal_force", "shear_force", "force", "centre", "moment", "half_width", "contact_area",
    "stick_area", "largest_pressure", "effective_tension",
)  # fmt: skip
PATCH = ("normal_force", "shear_force", "contact_area")
# States of a station.
STATES = ("last", "decisive", "equivalent_end", "largest_start", "largest_end")
FIELDS = ("traction", "mean_traction", "gap", "slip", "status")


def step_ends(solution: Solution) -> StepEnds | None:
    """The ends of the steps of a solved history; None if there are no other states."""
    return None if solution.step is None else StepEnds(solution.times, solution.ends)


def at_step_ends(
    solution: Solution, contacts: tuple[Contact, ...]
) -> tuple[Solution, tuple[Contact, ...]]:
    """A solved history and its evaluated contacts without the states within steps.

    With these where fretfe fails in that.
    """
    ends = step_ends(solution)
    if ends is None:
        return solution, contacts
    return guarded(
        "ends of divided steps",
        lambda: (ends.solution(solution), ends.contacts(solution, contacts)),
        lambda _: (solution, contacts),
    )


def division_notes(solution: Solution) -> tuple[str, ...]:
    """Which steps of the evaluated cycle, or of all, were divided, in words.

    Steps before the cycle are no concern of a reader unless there may be no more parts.
    """
    parts, first = np.diff(solution.ends), 0
    if solution.cycle is not None and parts.max(initial=1) < MOST_PARTS:
        first = solution.step_of(solution.cycle[0])
    divided = first + np.flatnonzero(parts[first:] > 1) + 1
    divided = divided[divided > 1] if parts.max(initial=1) < MOST_PARTS else divided
    if not len(divided):
        return ()
    fewest, most = parts[divided - 1].min(), parts[divided - 1].max()
    number = f"{fewest}" if fewest == most else f"{fewest} to {most}"
    limit = ", the most there may be" if most == MOST_PARTS else ""
    return (
        f"{len(divided)} of {len(parts)} steps, the first one step {divided[0]}, were solved in "
        f"{number} parts{limit}: within them an edge moves by more than {LARGEST_MOVE:.0%} of the "
        "half-width, loads out of phase turn, or a contact begins to slide as a whole. Ranges, "
        "slip zones and friction work know the states in between, figures show the ends of steps",
    )


class StepEnds:
    """The ends of the steps among all states of a solved history.

    Args:
        times: (T,) of the states.
        ends: (n + 1,) states at the ends of the n steps, the unloaded one first.
    """

    def __init__(self, times: Array, ends: Indices) -> None:
        self._ends = ends
        self._begins = np.append(0, ends[:-1] + 1)
        # (T,) number of the step that ends nearest to each state.
        self._step = np.searchsorted((times[ends][1:] + times[ends][:-1]) / 2, times)

    def contacts(self, solution: Solution, contacts: Sequence[Contact]) -> tuple[Contact, ...]:
        """The contacts of a solution, but for patches that exist in no step's end."""
        there = {history.name for history in self._lasting(solution)}
        return tuple(self.contact(each) for each in contacts if each.name in there)

    def contact(self, contact: Contact) -> Contact:
        """One contact."""
        known = [name for name in CONTACT if len(getattr(contact, name))]
        work = np.add.reduceat(contact.work, self._begins) if len(contact.work) else contact.work
        return replace(
            contact,
            fronts=self._fronts(contact.fronts),
            patches=tuple(replace(one, **self._histories(one, PATCH)) for one in contact.patches),
            work=work,
            **self._histories(contact, known),
        )

    def solution(self, solution: Solution) -> Solution:
        """The arrays of the solved history."""
        ends, begins = self._ends, self._begins
        cycle = solution.cycle
        return replace(
            solution,
            times=solution.times[ends],
            values=solution.values[ends],
            cycle=(int(self._step[cycle[0]]), int(self._step[cycle[1]])) if cycle else None,
            amplitudes=solution.amplitudes[ends],
            forces=solution.forces[ends],
            free=solution.free[ends] if solution.free is not None else None,
            driver_values=solution.driver_values[ends],
            contacts=tuple(self._history(each) for each in self._lasting(solution)),
            iterations=np.add.reduceat(solution.iterations, begins),
            parts=np.add.reduceat(solution.parts, begins),
            fallbacks=np.add.reduceat(solution.fallbacks, begins),
            certificates={
                name: np.maximum.reduceat(values, begins)
                for name, values in solution.certificates.items()
            },
            between=None,
            repeats=tuple(self._repeat(each) for each in solution.repeats),
            step=None,
        )

    def _lasting(self, solution: Solution) -> tuple[ContactHistory, ...]:
        """The contacts of a solution, but for patches that never exist at the end of a step."""
        return tuple(each for each in solution.contacts if each.exists[self._ends].any())

    def _histories(self, owner: object, names: Sequence[str]) -> dict[str, Any]:
        return {name: getattr(owner, name)[self._ends] for name in names}

    def _fronts(self, fronts: tuple[Front, ...]) -> tuple[Front, ...]:
        return tuple(
            replace(front, stations=tuple(self._station(each) for each in front.stations))
            for front in fronts
        )

    def _station(self, station: Station) -> Station:
        cycles = station.cycles
        states: dict[str, Any] = {name: int(self._step[getattr(station, name)]) for name in STATES}
        return replace(
            station,
            first=int(self._step[station.first]) if station.first >= 0 else -1,
            cycles=replace(cycles, start=self._step[cycles.start], end=self._step[cycles.end]),
            **states,
            slip_zones=self._zones(station),
            **self._histories(station, histories(StationHistory)),
        )

    def _zones(self, station: Station) -> tuple[SlipZone, ...]:
        """Slip zones from one end of a step to a later one, in the evaluated cycle if they were."""
        found = []
        for zone in station.slip_zones:
            before = int(self._step[station.first]) if 0 <= station.first < zone.end else 0
            end = max(int(self._step[zone.end]), before + 1)
            # What ends as bodies part is told where the edge was last.
            end -= int(end - 1 > before and station.hold[self._ends[end]] <= 0)
            start = min(int(self._step[zone.start]), end - 1)
            found.append(replace(zone, start=start, end=end))
        return tuple(found)

    def _repeat(self, repeat: Repeat) -> Repeat:
        before = repeat.first - 1
        first, last = int(self._step[before]), int(self._step[repeat.last])
        return Repeat(first + 1, last, first - int(self._step[before - repeat.period]))

    def _history(self, contact: ContactHistory) -> ContactHistory:
        ends, units, integrals = self._ends, contact.full_stick, contact.integrals
        # The areas that are left get numbers of their own.
        areas = units.area[ends]
        known = areas if integrals is None else np.append(areas, integrals.areas)
        used = np.unique(known[known >= 0])
        if integrals is not None:
            integrals = replace(integrals, areas=np.searchsorted(used, integrals.areas))
        return replace(
            contact,
            friction=contact.friction.picked(ends),
            dissipation=summed(contact.dissipation, ends),
            full_stick=FullStickUnits(
                picked(units.fields, used), np.where(areas >= 0, np.searchsorted(used, areas), -1)
            ),
            integrals=integrals,
            node_range=None if contact.node_range is None else contact.node_range[ends],
            **self._fields(contact),
        )

    def _fields(self, contact: ContactHistory) -> dict[str, Any]:
        return {name: picked(getattr(contact, name), self._ends) for name in FIELDS}
