# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interaction integrals at the stations of the fronts of solids. Collective."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.pairs import Pair
from fretfe.contact.march import March
from fretfe.contact.neighbours import neighbour_states
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState
from fretfe.edges.slip_zones import cycle_states
from fretfe.fem.interaction_integral import Tube
from fretfe.fem.limits import oscillates
from fretfe.fem.model import Model
from fretfe.fem.probes import Probe, measure, probe_stations
from fretfe.fem.unit_fields import UnitFields
from fretfe.results.solution import ContactHistory, Factor, Neighbours, Solution, StationIntegrals

if TYPE_CHECKING:
    # Not loaded by whoever loads this module: SciPy's interpolation takes a second.
    from fretfe.edges.sectors import Sector
    from fretfe.edges.tracks_in_space import FrontTrack

# Contact areas of the cycle at which the integrals are taken, smallest and largest; those that
# differ by less than this fraction are one.
SAME_AREA = 0.02
# Distances from the front, in elements across it, as far as which is integrated, and half-lengths
# along it in elements across it or along it, whichever is longer. The last way tells how much the
# half-length matters.
TUBES = ((4.0, 8.0), (6.0, 8.0), (9.0, 8.0), (6.0, 5.0))
ROWS = 1.5
# No farther than these parts of the half of the width of the contact, of the radius of curvature of
# the front, and along it of the way to its end.
WIDEST, NARROWEST, NEAREST_END = 0.4, 0.4, 0.95

# The fronts of each contact, followed through the history.
Tracks = Mapping[str, "tuple[FrontTrack, ...]"]


def add_solid_integrals(
    model: Model,
    recorder: Recorder | None,
    march: March | None,
    solution: Solution | None,
    tracks: Tracks | None,
) -> Solution | None:
    """The solution of solids with the interaction integrals at their stations. Collective.

    Recorder, march, solution and tracks are those of rank 0, None elsewhere, like what is returned.
    """
    draft = None
    if recorder and march and solution is not None and tracks is not None:
        draft = _Draft(model, recorder, march, solution, tracks)
    probes, requests = (draft.probes, draft.fields.requests) if draft else (None, None)
    values = measure(model, probes, requests)
    return draft.finish(values) if draft and values is not None else None


class _Draft:
    """Plans the integrals and gives the results their place; rank 0 only."""

    def __init__(
        self, model: Model, recorder: Recorder, march: March, solution: Solution, tracks: Tracks
    ) -> None:
        assert model.reduction is not None
        self.fields = UnitFields(recorder)
        self._case, self._recorder, self._solution = model.case, recorder, solution
        self._neighbours = neighbour_states(march, recorder.last, recorder.last_loads)
        self._difference = self.fields.difference(*self._neighbours) if self._neighbours else None
        self._plans: dict[str, _Plan] = {}
        self.probes: list[Probe] = []
        self._pairs = {pair.name: pair for pair in model.reduction.pairs}
        for contact in solution.contacts:
            plan = _plan(solution, contact, tracks[contact.name])
            if plan is not None:
                self._plans[contact.name] = plan
                pair = self._pairs[contact.pair]
                self.probes += self._probes(model, pair, plan, tracks[contact.name])

    def _probes(
        self, model: Model, pair: Pair, plan: _Plan, tracks: Sequence[FrontTrack]
    ) -> list[Probe]:
        """A probe for each station in each area, stations of all fronts in a row."""
        probes = []
        for row, (number, places) in enumerate(zip(plan.numbers, plan.positions, strict=True)):
            fields, first = self.fields.of_area(int(number)), 0
            if row == plan.last and self._difference is not None:
                fields = (*fields, self._difference)
            for track in tracks:
                frames, count = track.front.frames, len(track.front.sectors)
                own = np.where(np.isfinite(places), places, 0.0)[first : first + count]
                moved = frames.moved(own)
                for station, sector in enumerate(track.front.sectors):
                    tubes = _tubes(
                        sector, track.front.depth[station], float(frames.to_end[station])
                    )
                    probes.append(probe_stations(model, pair, moved.only(station), tubes, fields))
                first += count
        return probes

    def finish(self, values: list[list[Array]]) -> Solution:
        """The solution with the integrals, a list of one value for each probe."""
        rest = iter(values)
        contacts = []
        for contact in self._solution.contacts:
            plan = self._plans.get(contact.name)
            if plan is not None:
                contact = self._with_integrals(
                    contact,
                    plan,
                    [np.stack([next(rest)[0] for _ in row], axis=1) for row in plan.positions],
                )
            contacts.append(contact)
        return replace(self._solution, contacts=tuple(contacts))

    def _with_integrals(
        self, contact: ContactHistory, plan: _Plan, areas: Sequence[Array]
    ) -> ContactHistory:
        """A contact with (R, n, d, J) factors in each area, those of the neighbours behind them."""
        drivers = self._solution.driver_values.shape[1]
        known = np.isfinite(plan.positions)[:, None, :, None, None]
        factors = np.where(known, np.array([each[..., :drivers] for each in areas]), np.nan)
        integrals = StationIntegrals(
            plan.numbers, plan.positions, np.arange(len(TUBES), dtype=np.float64), factors
        )
        neighbours = None
        if self._neighbours is not None and not oscillates(self._case, contact):
            k_i = areas[plan.last][..., Factor.K_I, drivers]
            k_i = np.where(np.isfinite(plan.positions[plan.last]), k_i, np.nan)
            pressure = np.array([self._mean_pressure(contact, each) for each in self._neighbours])
            neighbours = Neighbours(pressure, k_i)
        return replace(contact, integrals=integrals, neighbours=neighbours)

    def _mean_pressure(self, contact: ContactHistory, state: ContactState) -> Array:
        """(N,) means around the nodes of a contact."""
        nodes = self._recorder.nodes_of(contact.pair)
        averaging = self._pairs[contact.pair].coupling.averaging
        return np.asarray(averaging @ (state.traction[nodes, 0] / np.sqrt(contact.weights)))


@dataclass(frozen=True)
class _Plan:
    """Areas of one contact and its stations there.

    Attributes:
        numbers: (S,) the areas.
        positions: (S, n) of all stations, inward from the reference.
        last: which of the areas is nearest to that of the last state.
    """

    numbers: Indices
    positions: Array
    last: int


def _plan(
    solution: Solution, contact: ContactHistory, tracks: Sequence[FrontTrack]
) -> _Plan | None:
    """Smallest and largest contact area of the cycle in which fronts are known; None without."""
    if not tracks:
        return None
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    places = np.concatenate([track.fit.place[states] for track in tracks], axis=1)
    known = np.isfinite(places).any(axis=1) & (contact.full_stick.area[states] >= 0)
    if not known.any():
        return None
    states, places = states[known], places[known]
    sizes = contact.nodes_pressed_in(states)
    chosen = [int(np.argmin(sizes)), int(np.argmax(sizes))]
    if np.ptp(sizes) <= SAME_AREA * sizes.max():
        chosen = chosen[1:]
    size = contact.nodes_pressed_in(np.array([len(solution.times) - 1]))
    last = int(np.argmin(np.abs(np.sort(sizes)[[0, -1]] - size))) if len(chosen) > 1 else 0
    return _Plan(contact.full_stick.area[states[chosen]], places[chosen], last)


def _tubes(sector: Sector, depth: float, to_end: float) -> list[Tube]:
    radius = 1 / max(abs(sector.curvature), 1e-300)
    tubes = []
    for reach, along in TUBES:
        half_length = max(along * sector.size, ROWS * sector.along_size)
        tubes.append(
            Tube(
                reach=min(reach * sector.size, WIDEST * depth, NARROWEST * radius),
                half_length=min(half_length, radius, NEAREST_END * to_end),
            )
        )
    return tubes
