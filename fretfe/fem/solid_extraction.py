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
    from fretfe.edges.space_fronts import SpaceFront
    from fretfe.edges.tracks_in_space import FrontTrack

# Contact areas of the cycle at which the integrals are taken, smallest and largest; those that
# differ by less than this fraction are one.
SAME_AREA = 0.02
# Distances from the front, in elements across it, as far as which is integrated, and half-lengths
# along it in elements across it or along it, whichever is longer. The last way tells how much the
# half-length matters. They are compared in one area; elsewhere the usual one does.
TUBES = ((4.0, 8.0), (6.0, 8.0), (9.0, 8.0), (6.0, 5.0))
USUAL = 1
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
        self._solution, self._tracks, self._recorder = solution, tracks, recorder
        self.fields = UnitFields(recorder)
        self._case = model.case
        self._neighbours = neighbour_states(march, recorder.last, recorder.last_loads)
        self._difference = self.fields.difference(*self._neighbours) if self._neighbours else None
        self._plans: dict[str, _Plan] = {}
        self._fields_of: dict[int, tuple[int, ...]] = {}
        self.probes: list[Probe] = []
        self._pairs = {pair.name: pair for pair in model.reduction.pairs}
        for contact in solution.contacts:
            plan = _plan(solution, contact, tracks[contact.name])
            if plan is not None:
                self._plans[contact.name] = plan
                pair = self._pairs[contact.pair]
                self.probes += self._probes(model, pair, plan, tracks[contact.name])

    def _of_state(self, state: int) -> tuple[int, ...]:
        """Numbers of the mean fields of areas around that of a state, one for each driver."""
        # Imported where it is needed: SciPy's interpolation takes a second.
        from fretfe.edges.nested_areas import AREAS, nested_areas

        if state not in self._fields_of:
            closed = self._recorder.state(state).closed
            areas = np.tile(closed, (AREAS, 1))
            for contact in self._solution.contacts:
                nodes, tracks = self._recorder.nodes_of(contact.pair), self._tracks[contact.name]
                places = [track.fit.place[state] for track in tracks]
                areas[:, nodes] = nested_areas(contact.points, closed[nodes], tracks, places)
            self._fields_of[state] = self.fields.of_areas(state, list(areas))
        return self._fields_of[state]

    def _probes(
        self, model: Model, pair: Pair, plan: _Plan, tracks: Sequence[FrontTrack]
    ) -> list[Probe]:
        """A probe for each front in each state."""
        probes, first = [], 0
        for track in tracks:
            stations = slice(first, first + len(track.front.sectors))
            first = stations.stop
            tubes = _tubes(track.front)
            for row, (state, places) in enumerate(zip(plan.states, plan.positions, strict=True)):
                own = np.where(np.isfinite(places), places, 0.0)[stations]
                fields, ways = self._of_state(int(state)), tubes
                if row != plan.last:
                    ways = [[each[USUAL]] for each in tubes]
                elif self._difference is not None:
                    fields = (*fields, self._difference)
                frames = track.front.frames.moved(own)
                probes.append(probe_stations(model, pair, frames, ways, fields))
        return probes

    def finish(self, values: list[list[Array]]) -> Solution:
        """The solution with the integrals, a list of values of all stations for each probe."""
        rest = iter(values)
        contacts = []
        for contact in self._solution.contacts:
            plan = self._plans.get(contact.name)
            if plan is not None:
                fronts = [
                    [np.stack(next(rest), axis=1) for _ in plan.states]
                    for _ in self._tracks[contact.name]
                ]
                states = [np.concatenate(each, axis=1) for each in zip(*fronts, strict=True)]
                contact = self._with_integrals(contact, plan, states)
            contacts.append(contact)
        return replace(self._solution, contacts=tuple(contacts))

    def _with_integrals(
        self, contact: ContactHistory, plan: _Plan, states: Sequence[Array]
    ) -> ContactHistory:
        """A contact with its factors, those of the difference of the neighbours behind them.

        Args:
            contact: the contact.
            plan: S states and n stations.
            states: (R, n, d, J) of the state nearest to the last one, (1, n, d, J) of the others.
        """
        drivers, whole = self._solution.driver_values.shape[1], states[plan.last]
        # The ways differ by the same everywhere.
        ways = (whole - whole[USUAL])[..., :drivers]
        factors = np.array(
            [
                whole[..., :drivers] if each is whole else each[..., :drivers] + ways
                for each in states
            ]
        )
        known = np.isfinite(plan.positions)[:, None, :, None, None]
        integrals = StationIntegrals(
            plan.areas,
            plan.positions,
            np.arange(len(TUBES), dtype=np.float64),
            np.where(known, factors, np.nan),
        )
        neighbours = None
        if self._neighbours is not None and not oscillates(self._case, contact):
            k_i = whole[..., Factor.K_I, drivers]
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
    """States of one contact and its stations there.

    Attributes:
        states: (S,) their numbers.
        areas: (S,) numbers of their contact areas.
        positions: (S, n) of all stations, inward from the reference.
        last: which of the areas is nearest to that of the last state.
    """

    states: Indices
    areas: Indices
    positions: Array
    last: int


def _plan(
    solution: Solution, contact: ContactHistory, tracks: Sequence[FrontTrack]
) -> _Plan | None:
    """States of the cycle with the smallest and largest area whose fronts are known, if any."""
    if not tracks:
        return None
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    # One state for each area, the same for all contacts.
    areas, first = np.unique(contact.full_stick.area[states], return_index=True)
    states = states[first]
    places = np.concatenate([track.fit.place[states] for track in tracks], axis=1)
    known = np.isfinite(places).any(axis=1) & (areas >= 0)
    if not known.any():
        return None
    states, areas, places = states[known], areas[known], places[known]
    sizes = contact.nodes_pressed_in(states)
    chosen = [int(np.argmin(sizes)), int(np.argmax(sizes))]
    if np.ptp(sizes) <= SAME_AREA * sizes.max():
        chosen = chosen[1:]
    size = contact.nodes_pressed_in(np.array([len(solution.times) - 1]))
    last = int(np.argmin(np.abs(sizes[chosen] - size)))
    return _Plan(states[chosen], areas[chosen], places[chosen], last)


def _tubes(front: SpaceFront) -> list[list[Tube]]:
    """For each station of a front its tubes."""
    tubes = []
    for sector, depth, to_end in zip(front.sectors, front.depth, front.frames.to_end, strict=True):
        radius = 1 / max(abs(sector.curvature), 1e-300)
        farthest = min(WIDEST * depth, NARROWEST * radius)
        longest = min(radius, NEAREST_END * to_end)
        tubes.append(
            [
                Tube(
                    reach=min(reach * sector.size, farthest),
                    half_length=min(max(along * sector.size, ROWS * sector.along_size), longest),
                )
                for reach, along in TUBES
            ]
        )
    return tubes
