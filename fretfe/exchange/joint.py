# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts as joints: force against displacement of what is driven, and the part that slips.

Models of vibrations have the elastic bodies already, stuck together. By reciprocity (Betti) slip
Δs moves a driven boundary by ∫ τ·Δs over the contact, with the tractions τ of full stick under a
unit force on it; the rest of its displacement is that of the stuck bodies, exactly as long as the
contact area stays.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.files import replacing, writing
from fretfe.history.solution import OPEN, ContactHistory, Solution
from fretfe.results.model import Result

# Ranges below this part of the largest force do not drive.
DRIVES = 1e-6
# Work and slip with larger bars are unknown.
MOST_UNKNOWN = 0.5


@dataclass(frozen=True)
class Loop:
    """Force on a driven boundary and its displacement, over the evaluated cycle of n states.

    Attributes:
        driver: name of the load.
        times: (n,) of the states.
        force: (n,) of the whole thickness.
        displacement: (n,) of the boundary along the force; NaN of half-planes, which have none.
        slip: (n,) part of it by slip in each contact since the first state, by name; NaN from where
            bodies part.
        work: friction work of all contacts in the cycle; NaN if other loads drive as well, or where
            it is unknown.
        bar: of work and slip, over them; NaN where it is unknown.
    """

    driver: str
    times: Array
    force: Array
    displacement: Array
    slip: Mapping[str, Array]
    work: float
    bar: float

    def swing(self, values: Array) -> float:
        """Difference of values (n,) between the states of the largest and the smallest force."""
        return float(values[np.argmax(self.force)] - values[np.argmin(self.force)])

    @property
    def force_range(self) -> float:
        """Largest force less the smallest."""
        return self.swing(self.force)

    @property
    def displacement_range(self) -> float:
        """Difference of the displacements there."""
        return self.swing(self.displacement)

    @property
    def slip_range(self) -> float:
        """The part of it by slip in all contacts."""
        return sum(map(self.swing, self.slip.values()))

    @property
    def slip_bar(self) -> float:
        """Error bar of that."""
        return self.bar * abs(self.slip_range)

    @property
    def stiffness(self) -> float:
        """Secant stiffness, bodies and contacts together."""
        return self.force_range / self.displacement_range

    @property
    def stuck_stiffness(self) -> float:
        """Stiffness of the bodies stuck together: the tangent right after a reversal."""
        return self.force_range / (self.displacement_range - self.slip_range)

    @property
    def joint_stiffness(self) -> float:
        """Secant stiffness of a spring in series with the stuck bodies; NaN where slip is unknown.

        Infinite if nothing slips.
        """
        if not self.bar < MOST_UNKNOWN:
            return math.nan
        return self.force_range / self.slip_range if self.slip_range else math.inf

    @property
    def loss_factor(self) -> float:
        """Work of a cycle over 2 pi times the largest energy, F u/2 of the amplitudes."""
        return 4 * self.work / (np.pi * self.force_range * self.displacement_range)


def joint_loops(result: Result) -> tuple[Loop, ...]:
    """Loops of all boundaries whose force varies in the evaluated cycle.

    Raises:
        OutputError: there is no evaluated cycle, no such boundary, states were not kept, or a layer
            is not linear.
    """
    solution, thickness = result.solution, result.case.model.thickness
    if solution.cycle is None:
        raise OutputError("expected an evaluated cycle, found none")
    states = np.arange(solution.cycle[0], solution.cycle[1] + 1)
    if not solution.keeps(*solution.cycle):
        raise OutputError(
            "expected the states of the whole evaluated cycle, found those of a few: run the case "
            'with [output] tractions = "all"'
        )
    for name, contact in result.case.contacts.items():
        if contact.layer is not None and contact.layer.curve is not None:
            raise OutputError(
                f"contacts.{name}.layer: expected a linear layer, found a curve of pressures, by "
                "which bodies that are stuck together have no one stiffness"
            )
    places = {name: number for number, name in enumerate(solution.coordinates)}
    forces = thickness * solution.driver_values[states]
    largest = np.abs(forces).max(initial=0.0)
    varying = [
        number
        for number, name in enumerate(solution.drivers)
        if name in places and np.ptp(forces[:, number]) > DRIVES * largest
    ]
    if not varying:
        raise OutputError(
            "expected a platen or another boundary whose force varies in the evaluated cycle, "
            f"found none among {', '.join(solution.drivers) or 'no loads'}"
        )
    slips = {each.name: _moved_by_slip(each, states) for each in solution.contacts}
    work, bar = _friction_work(result)
    alone = _loads_that_vary(solution, states) == len(varying) == 1
    # Half-planes move by any constant under a force.
    known = 1.0 if result.bodies else math.nan
    return tuple(
        Loop(
            driver=solution.drivers[number],
            times=solution.times[states],
            force=forces[:, number],
            displacement=known * solution.amplitudes[states, places[solution.drivers[number]]],
            # Where no friction works slip is round-off.
            slip={name: moved[:, number] * (work > 0) for name, moved in slips.items()},
            work=thickness * work if alone and bar < MOST_UNKNOWN else math.nan,
            bar=bar,
        )
        for number in varying
    )


def _friction_work(result: Result) -> tuple[float, float]:
    """Friction work of all contacts in the cycle, and its error bar over it.

    Of solids the work by the plane problems next to their fronts has no bar: it is the difference.
    """
    work = sum(each.dissipation for each in result.contacts)
    bars = [
        abs(each.local_dissipation - each.dissipation) if each.solid else each.dissipation_spread
        for each in result.contacts
    ]
    if not work > 0:
        return work, 0.0 if sum(bars) == 0 else math.inf
    return work, sum(bars) / work


def _loads_that_vary(solution: Solution, states: Indices) -> int:
    """Number of loads of the case that vary in some states."""
    values = solution.values[states]
    return int(np.sum(np.ptp(values, axis=0) > DRIVES * np.abs(values).max(axis=0)))


def _moved_by_slip(contact: ContactHistory, states: Indices) -> Array:
    """(n, J) displacement of each driver by the slip in a contact since the first of n states.

    Where the contact area changes within a step the tractions are the mean of both, and nodes that
    touch at both of its ends slip. NaN from where nothing is left that sticks the bodies together.
    """
    weights = contact.surface.weights
    moved = np.zeros((len(states), contact.full_stick.fields.shape[-1]))
    for number in range(1, len(states)):
        before, after = int(states[number - 1]), int(states[number])
        areas = contact.full_stick.area[[before, after]]
        if areas.min() < 0:
            moved[number] = math.nan
            continue
        tractions = np.mean([contact.full_stick.fields[area] for area in areas], axis=0)[:, 1:]
        touches = (contact.status[before] != OPEN) & (contact.status[after] != OPEN)
        slip = contact.slip[after] - contact.slip[before]
        moved[number] = np.einsum("n,ncj,nc->j", weights * touches, tractions, slip)
    return np.cumsum(moved, axis=0)


def write_loops(path: Path, loops: Sequence[Loop]) -> None:
    """Write loops as CSV: driver, time, force, displacement, and slip in each contact.

    Raises:
        OutputError: if that is not possible.
    """
    names = list(dict.fromkeys(name for loop in loops for name in loop.slip))
    with writing(path, "the loops"), replacing(path) as new, new.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["driver", "time", "force", "displacement", *(f"slip {n}" for n in names)])
        for loop in loops:
            columns = loop.times, loop.force, loop.displacement, *(loop.slip[n] for n in names)
            rows.writerows(
                [loop.driver, *map(repr, row)] for row in np.column_stack(columns).tolist()
            )
