# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts as joints: force against displacement of what is driven, and the part that slips.

Models of vibrations have the elastic bodies already, stuck together. By reciprocity (Betti) slip
Δs moves a driven boundary by ∫ τ·Δs over the contact, with the tractions τ of full stick under a
unit force on it; the rest of its displacement is that of the stuck bodies, exactly as long as the
contact area stays.

Tractions of full stick are singular at the edges, and discrete ones have these a part of an element
away from those of the contact. By that alone slip would be wrong by 4 Δa/(u a) of it, u = Q/(f P).
They are stretched to the edges of the contact.
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
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.plane.full_stick_fit import (
    GALERKIN_OVERHANG,
    OVERHANG,
    OVERHANG_UNCERTAINTY,
    effective_edges,
)
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
        slip_farther: the same with the edges of the contact farther out by their error bars.
        work: friction work of all contacts in the cycle; NaN if other loads drive as well, or where
            it is unknown.
        bar: of work, over it; infinite where elements hide the slip.
    """

    driver: str
    times: Array
    force: Array
    displacement: Array
    slip: Mapping[str, Array]
    slip_farther: Mapping[str, Array]
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
        """Error bar of that; infinite where elements hide the slip."""
        if math.isinf(self.bar):
            return math.inf
        return sum(abs(self.swing(self.slip_farther[n] - each)) for n, each in self.slip.items())

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
        if not self.slip_bar <= MOST_UNKNOWN * abs(self.slip_range):
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
    for name, pair in result.case.contacts.items():
        if pair.layer is not None and pair.layer.curve is not None:
            raise OutputError(
                f"contacts.{name}.layer: expected a linear layer, found a curve of pressures, by "
                "which bodies that are stuck together have no one stiffness"
            )
    places = {name: number for number, name in enumerate(solution.coordinates)}
    forces = thickness * solution.driver_values[states]
    varying = [
        number
        for number, name in enumerate(solution.drivers)
        if name in places and np.ptp(forces[:, number]) > DRIVES * np.abs(forces).max()
    ]
    if not varying:
        raise OutputError(
            "expected a platen or another boundary whose force varies in the evaluated cycle, "
            f"found none among {', '.join(solution.drivers) or 'no loads'}"
        )
    work, bar = _friction_work(result)
    slips, farther = {}, {}
    for contact, history in zip(result.contacts, solution.contacts, strict=True):
        # Where no friction works slip is round-off.
        slips[history.name], farther[history.name] = (
            (work > 0) * each for each in _both_moved(result, contact, history, states, bar)
        )
    alone = _loads_that_vary(solution, states) == len(varying) == 1
    # Half-planes move by any constant under a force.
    known = 1.0 if result.bodies else math.nan
    return tuple(
        Loop(
            driver=solution.drivers[number],
            times=solution.times[states],
            force=forces[:, number],
            displacement=known * solution.amplitudes[states, places[solution.drivers[number]]],
            slip={name: moved[:, number] for name, moved in slips.items()},
            slip_farther={name: moved[:, number] for name, moved in farther.items()},
            work=thickness * work if alone and bar < MOST_UNKNOWN else math.nan,
            bar=bar,
        )
        for number in varying
    )


def _friction_work(result: Result) -> tuple[float, float]:
    """Friction work of all contacts in the cycle, and its error bar over it."""
    work = sum(each.dissipation for each in result.contacts)
    bar = sum(each.dissipation_spread for each in result.contacts)
    if not work > 0:
        return work, 0.0 if bar == 0 else math.inf
    return work, bar / work


def _loads_that_vary(solution: Solution, states: Indices) -> int:
    """Number of loads of the case that vary in some states."""
    values = solution.values[states]
    return int(np.sum(np.ptp(values, axis=0) > DRIVES * np.abs(values).max(axis=0)))


def _both_moved(
    result: Result, contact: Contact, history: ContactHistory, states: Indices, bar: float
) -> tuple[Array, Array]:
    """Displacements as of `_moved_by_slip`, and with the edges farther out by their error bars.

    Where no edge is fitted, the singularity is where the elements have it, give or take one of
    them; as well with a layer, which has none. Nothing is stretched on solids, whose bar has that
    of the work, and what the place of the edge leaves open.
    """
    arc = history.surface.arc
    if contact.solid:
        moved = _moved_by_slip(history, states)
        bar += _edge_uncertainty(contact, history, states)
        return moved, moved * (1 + bar if math.isfinite(bar) else math.nan)
    overhang = OVERHANG[result.solution.degree] if result.bodies else GALERKIN_OVERHANG
    edges, next_ones = (_discrete_edges(history, states, overhang + more) for more in (0.0, 1.0))
    position, spread = (
        np.array([getattr(each, name)[states] for each in contact.stations]).T
        for name in ("position", "position_spread")
    )
    fitted = np.isfinite(position) & (history.surface.layer is None)
    true = np.where(fitted, position, edges)
    outward = np.where(fitted, OVERHANG_UNCERTAINTY, 1.0) * (next_ones - edges)
    outward += np.where(fitted, spread, 0.0) * [-1.0, 1.0]

    def moved_to(ends: Array) -> Array:
        stretch = np.diff(ends) / np.diff(edges)
        places = ends[:, :1] + (arc - edges[:, :1]) * stretch
        places = np.clip(places, ends[:, :1], ends[:, 1:])  # a corner is in contact
        return _moved_by_slip(history, states, np.where(np.isnan(places), arc, places), ends)

    return moved_to(true), moved_to(true + outward)


def _edge_uncertainty(contact: Contact, history: ContactHistory, states: Indices) -> float:
    """Relative error 6 Δa/(u a) of slip between solids whose edges are off by Δa, u = Q/(f P).

    Of a sphere, by Mindlin: stuck displacement goes with 1/a, and slip adds u/6 of it.
    """
    found = [(e.size, e.position_spread[states[-1]], e.depth) for e in contact.stations]
    size, spread, depth = np.array(found).reshape(-1, 3).T
    off = np.hypot(OVERHANG_UNCERTAINTY * size, spread) / depth
    sums = np.einsum("n,tnc->tc", history.surface.weights, history.traction[states])
    share = float(np.linalg.norm(np.ptp(sums[:, 1:], axis=0))) / sums[:, 0].max()
    return 12 * history.friction.largest * max(off, default=math.nan) / max(share, 1e-300)


def _discrete_edges(history: ContactHistory, states: Indices, overhang: float) -> Array:
    """(n, 2) edges that tractions of full stick have in n states; NaN without such tractions."""
    edges, areas = np.full((len(states), 2), np.nan), history.full_stick.area[states]
    for area in np.unique(areas[areas >= 0]):
        fields = history.full_stick.fields[int(area)].transpose(1, 2, 0)
        if fields.any():
            edges[areas == area] = effective_edges(history.surface.arc, fields, overhang)
    return edges


def _moved_by_slip(
    contact: ContactHistory, states: Indices, places: Array | None = None, ends: Array | None = None
) -> Array:
    """(n, J) displacement of each driver by the slip in a contact since the first of n states.

    Where the contact area changes within a step it is the mean with the tractions of both, and
    what touches at both of its ends slips. NaN from where nothing is left that sticks the bodies
    together.

    Args:
        contact: the contact.
        states: (n,) successive ones.
        places: (n, N) along the arc, where the tractions of full stick of the nodes act; None at
            the nodes.
        ends: (n, 2) of the contact there.
    """
    arc, weights = contact.surface.arc, contact.surface.weights
    moved = np.zeros((len(states), contact.full_stick.fields.shape[-1]))
    for number in range(1, len(states)):
        before, after = int(states[number - 1]), int(states[number])
        if contact.full_stick.area[[before, after]].min() < 0:
            moved[number] = math.nan
            continue
        touches = (contact.status[before] != OPEN) & (contact.status[after] != OPEN)
        slip = at = contact.slip[after] - contact.slip[before]
        for end in (number - 1, number):
            tractions = contact.full_stick.fields[int(contact.full_stick.area[states[end]])][:, 1:]
            if places is not None and ends is not None:
                at = np.column_stack([np.interp(places[end], arc, each) for each in slip.T])
                first, last = ends[number - 1 : number + 1].T
                touches = (places[end] >= first.max()) & (places[end] <= last.min())
            moved[number] += np.einsum("n,ncj,nc->j", weights * touches, tractions, at) / 2
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
