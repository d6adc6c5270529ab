# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interaction integrals at the stations of the fronts of solids. Collective."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.pairs import Pair
from fretfe.contact.recorder import Recorder
from fretfe.edges.slip_zones import cycle_states
from fretfe.fem.interaction_integral import Tube
from fretfe.fem.model import Model
from fretfe.fem.probes import Probe, measure, probe_stations
from fretfe.fem.unit_fields import UnitFields
from fretfe.results.solution import ContactHistory, Solution, StationIntegrals

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
    model: Model, recorder: Recorder | None, solution: Solution | None, tracks: Tracks | None
) -> Solution | None:
    """The solution of solids with the interaction integrals at their stations. Collective.

    Recorder, solution and tracks are those of rank 0, None elsewhere, like what is returned.
    """
    draft = None
    if recorder is not None and solution is not None and tracks is not None:
        draft = _Draft(model, recorder, solution, tracks)
    probes, requests = (draft.probes, draft.fields.requests) if draft else (None, None)
    values = measure(model, probes, requests)
    return draft.finish(values) if draft and values is not None else None


class _Draft:
    """Plans the integrals and gives the results their place; rank 0 only."""

    def __init__(
        self, model: Model, recorder: Recorder, solution: Solution, tracks: Tracks
    ) -> None:
        assert model.reduction is not None
        self.fields = UnitFields(recorder)
        self._solution = solution
        self._plans: dict[str, _Plan] = {}
        self.probes: list[Probe] = []
        pairs = {pair.name: pair for pair in model.reduction.pairs}
        for contact in solution.contacts:
            plan = _plan(solution, contact, tracks[contact.name])
            if plan is not None:
                self._plans[contact.name] = plan
                self.probes += self._probes(model, pairs[contact.pair], plan, tracks[contact.name])

    def _probes(
        self, model: Model, pair: Pair, plan: _Plan, tracks: Sequence[FrontTrack]
    ) -> list[Probe]:
        """A probe for each station in each area, stations of all fronts in a row."""
        probes = []
        for number, places in zip(plan.numbers, plan.positions, strict=True):
            fields, first = self.fields.of_area(int(number)), 0
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
                areas = [np.stack([next(rest)[0] for _ in row], axis=1) for row in plan.positions]
                factors = np.where(
                    np.isfinite(plan.positions)[:, None, :, None, None], areas, np.nan
                )
                reaches = np.arange(len(TUBES), dtype=np.float64)
                integrals = StationIntegrals(plan.numbers, plan.positions, reaches, factors)
                contact = replace(contact, integrals=integrals)
            contacts.append(contact)
        return replace(self._solution, contacts=tuple(contacts))


@dataclass(frozen=True)
class _Plan:
    """Areas of one contact and its stations there.

    Attributes:
        numbers: (S,) the areas.
        positions: (S, n) of all stations, inward from the reference.
    """

    numbers: Indices
    positions: Array


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
    return _Plan(contact.full_stick.area[states[chosen]], places[chosen])


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
