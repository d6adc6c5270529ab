# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interaction integrals at all stations of a solved history, of edges and of fronts."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.definition import Pair
from fretfe.case import isotropic
from fretfe.contact.full_stick import neighbour_states
from fretfe.contact.march import March
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState
from fretfe.evaluate.evaluate import Tracks
from fretfe.evaluate.loaded import (
    evaluated_states,
    hardly_loaded,
    moving_state,
    normal_force,
    with_own_cycle,
)
from fretfe.evaluate.plane.edge_fits import with_gap
from fretfe.evaluate.plane.patches_in_time import own_part
from fretfe.evaluate.plane.pressure_fit import FEWEST_NODES, fit_edge
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront, plane_sections
from fretfe.evaluate.plane.symmetry import whole_contact
from fretfe.evaluate.slip import cycle_states
from fretfe.fem.fields import FieldSource
from fretfe.fem.interaction_integral import Tip, Tube
from fretfe.fem.limits import oscillates
from fretfe.fem.model import Model
from fretfe.fem.probes import Probe, UnitFields, bond, probe_stations
from fretfe.history.solution import ContactHistory, Factor, NearbyLoads, Solution, StationIntegrals
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.surface import perpendicular

# Not loaded by whoever loads this module: SciPy's interpolation takes a second.
if TYPE_CHECKING:
    from fretfe.evaluate.space.fronts import FrontTrack, SpaceFront

# Contact areas of the cycle at which the integrals are taken: smallest, middle, largest.
AREAS = 3
# Contact areas that differ by less than this fraction are one.
SAME_AREA = 0.02
# Radii of the circles, in half-widths of the contact, and how far the smallest and largest one are
# from elements and from the middle.
REACHES = (0.1, 0.15, 0.25)
FEWEST_ELEMENTS = 10.0
LARGEST = 0.5
# Distances from the front, in elements across it, as far as which is integrated, and half-lengths
# along it in elements across it or along it, whichever is longer. The last way tells how much the
# half-length matters. They are compared in one area; elsewhere the usual one does.
TUBES = ((4.0, 8.0), (6.0, 8.0), (9.0, 8.0), (6.0, 5.0))
USUAL = 1
ROWS = 1.5
# Along the front no farther than this part of the way to its end.
NEAREST_END = 0.95
# The frame of a station turns along a bent front, but a crystal does not: the fields of the station
# are solutions at the station alone. Largest half-length over the radius of curvature between them:
# around a nickel sphere with elements of a/10 and Q along <110> |dK| is off by -2 % at 90 degrees
# and -.3 % at 63, where half-lengths of .5 of the radius leave -5 and +3 %.
TURN = 0.3


def add_integrals(
    model: Model,
    fields: FieldSource,
    recorder: Recorder,
    march: March,
    solution: Solution,
    tracks: Tracks | None,
    say: Callable[[str], None],
) -> Solution:
    """The solution of a history with the interaction integrals of its contacts; on rank 0.

    Args:
        model: the bodies.
        fields: answers with the integrals.
        recorder: holds the solved states.
        march: solved them.
        solution: the same states in physical units.
        tracks: of the fronts of solids; None in the plane.
        say: told how many of the integrals are done.
    """
    moving = moving_state(solution) if tracks is None else _reference(solution, tracks)
    common = _Common(model, recorder, march, solution, moving)
    draft: _Draft[Any] = _PlaneDraft(common) if tracks is None else _SolidDraft(common, tracks)
    draft.plan()
    return draft.finish(fields.integrals(draft.probes, draft.fields.requests, say))


class _Common:
    """A solved history, from which integrals of both dimensions are planned.

    Around the state `moving` loads are changed to see how edges move.
    """

    def __init__(
        self, model: Model, recorder: Recorder, march: March, solution: Solution, moving: int
    ) -> None:
        self.model, self.recorder, self.solution = model, recorder, solution
        self.fields = UnitFields(recorder)
        self.pairs = {pair.name: pair for pair in model.reduction.pairs}
        self.moving = moving
        state = recorder.state(moving), recorder.loads[moving]
        self.nearby_loads = neighbour_states(march, *state)
        self.difference = self.fields.difference(*self.nearby_loads) if self.nearby_loads else None


def _reference(solution: Solution, tracks: Tracks) -> int:
    """State whose fronts have the stations of solids: in the cycle, or the last one."""
    states = [track.state for each in tracks.values() for track in each]
    return states[0] if states else moving_state(solution)


Plan = TypeVar("Plan")


class _Draft(Generic[Plan]):
    """Plans the integrals of all contacts and gives the results their place."""

    def __init__(self, common: _Common) -> None:
        self._common = common
        self.fields = common.fields
        self.probes: list[Probe] = []
        # For each contact that has integrals its plan and the number of its probes.
        self._plans: dict[str, tuple[Plan, int]] = {}

    def plan(self) -> None:
        """Choose states and stations, and make their probes."""
        for contact in self._common.solution.contacts:
            plan = self._plan(contact)
            if plan is not None:
                probes = self._probes(contact, plan)
                self._plans[contact.name] = plan, len(probes)
                self.probes += probes

    def finish(self, values: list[list[Array]]) -> Solution:
        """The solution with the integrals, one list of values for each probe."""
        rest, contacts = iter(values), []
        for contact in self._common.solution.contacts:
            if contact.name in self._plans:
                plan, count = self._plans[contact.name]
                integrals, neighbours = self._factors(contact, plan, list(islice(rest, count)))
                contact = replace(contact, integrals=integrals, nearby_loads=neighbours)
            contacts.append(contact)
        return replace(self._common.solution, contacts=tuple(contacts))

    def _plan(self, contact: ContactHistory) -> Plan | None:
        """States and stations of a contact; None if its edges or fronts are not known."""
        raise NotImplementedError

    def _probes(self, contact: ContactHistory, plan: Plan) -> list[Probe]:
        raise NotImplementedError

    def _factors(
        self, contact: ContactHistory, plan: Plan, values: list[list[Array]]
    ) -> tuple[StationIntegrals, NearbyLoads | None]:
        raise NotImplementedError


class _PlaneDraft(_Draft["_Areas"]):
    """A probe for each edge in all chosen states, the difference of the neighbours last."""

    def _plan(self, contact: ContactHistory) -> _Areas | None:
        whole = whole_contact(contact)
        if whole.endless:
            return None
        return _choose_areas(self._common.solution, whole.contact, self._common.moving)

    def _probes(self, contact: ContactHistory, plan: _Areas) -> list[Probe]:
        images, pair = whole_contact(contact).images, self._common.pairs[contact.pair]
        surface = contact.surface
        return [
            self._probe(pair, surface, plan, each) for each in PLANE_FRONTS if each not in images
        ]

    def _probe(
        self, pair: Pair, surface: ContactSurface, areas: _Areas, front: PlaneFront
    ) -> Probe:
        model, difference = self._common.model, self._common.difference
        edges = [float(edge) for edge in areas.positions[:, front.number]]
        fields = [self.fields.of_area(int(area)) for area in areas.numbers]
        if difference is not None:
            edges.append(float(areas.last[front.number]))
            fields.append((difference,))
        tubes = tuple(Tube(float(reach)) for reach in areas.reaches)
        normals = surface.frames[:, 0, :2]
        points = [_at(surface, edge, surface.points) for edge in edges]
        return Probe(
            bodies=(pair.body1, pair.body2),
            tips=tuple(_tips(model, pair, point, front) for point in points),
            frames=tuple(
                _frame(_at(surface, edge, normals), front, model.components) for edge in edges
            ),
            fields=tuple(fields),
            tubes=(tubes,) * len(edges),
            **bond(model.case, pair),
        )

    def _factors(
        self, contact: ContactHistory, plan: _Areas, values: list[list[Array]]
    ) -> tuple[StationIntegrals, NearbyLoads | None]:
        # The image of an edge has its factors.
        values = values * (len(PLANE_FRONTS) // len(values))
        of_areas = [station[: len(plan.numbers)] for station in values]
        # (stations, S, R, d, J) to (S, R, stations, d, J)
        factors = np.array(of_areas).transpose(1, 2, 0, 3, 4)
        integrals = StationIntegrals(plan.numbers, plan.positions, plan.reaches, factors)
        return integrals, self._neighbour_history(contact, values)

    def _neighbour_history(
        self, contact: ContactHistory, stations: list[list[Array]]
    ) -> NearbyLoads | None:
        if self._common.nearby_loads is None:
            return None
        nodes = self._common.recorder.nodes_of(contact.pair)
        tractions = np.array([state.traction[nodes, 0] for state in self._common.nearby_loads])
        if contact.node_range is not None:
            state = self._common.moving
            tractions = own_part(tractions, contact.node_range[state])
            if np.any(tractions[:, _borders(contact, state)] > 0):  # merges with its neighbour
                return None
        normal = np.stack([values[-1][:, Factor.K_I, 0] for values in stations], axis=1)
        if oscillates(self._common.model.case, contact):
            normal = np.full_like(normal, np.nan)
        pressure = tractions / np.sqrt(contact.surface.weights)
        return NearbyLoads(pressure, normal, self._common.moving)


@dataclass(frozen=True)
class _Areas:
    """Some contact areas of one contact.

    Attributes:
        numbers: (S,) the areas.
        positions: (S, stations) there.
        last: (stations,) in the state around which loads are changed.
        reaches: (R,) radii.
    """

    numbers: Indices
    positions: Array
    last: Array
    reaches: Array


def _choose_areas(solution: Solution, contact: ContactHistory, moving: int) -> _Areas | None:
    """Smallest, middle and largest contact area of the cycle; None if edges cannot be fitted."""
    states = evaluated_states(with_own_cycle(solution, contact), contact)
    sizes = contact.nodes_pressed_in(states)
    # What carries little and is too small for fits takes the factors of the states beside it.
    kept = (sizes >= FEWEST_NODES) | ~hardly_loaded(contact, normal_force(contact))[states]
    states, sizes = states[kept], sizes[kept]
    if not len(sizes) or sizes.min() < FEWEST_NODES or contact.full_stick.area[states].min() < 0:
        return None
    numbers, firsts = np.unique(contact.full_stick.area[states], return_index=True)
    order = np.argsort(sizes[firsts], kind="stable")
    # Areas that differ by a node or two have the same factors but for that difference.
    count = AREAS if np.ptp(sizes) > SAME_AREA * sizes.max() else 1
    chosen = order[np.unique(np.linspace(0, len(order) - 1, count).round().astype(int))]
    # Of several patches one may not be there in that state.
    at = moving if contact.traction[moving, :, 0].max() > 0 else states[-1]
    looked = np.append(states[firsts[chosen]], at)
    pressure = contact.traction[looked, :, 0]
    sections = plane_sections(contact.surface.arc, pressure)
    fits = with_gap([fit_edge(section) for section in sections], contact, pressure)
    edges = np.stack([fit.position for fit in fits], axis=1)
    # The pressures of a flat under little load do not show its edges.
    known = np.isfinite(edges).all(axis=1)
    if not known[:-1].any():
        return None
    last = edges[-1] if known[-1] else edges[:-1][known[:-1]][-1]
    room = _room(contact, edges[known], looked[known].tolist())
    reaches, own = _reaches(contact, last, room), edges[:-1][known[:-1]]
    kept = numbers[chosen[known[:-1]]]
    return _Areas(kept, own, last, reaches) if len(reaches) else None


def _room(contact: ContactHistory, edges: Array, states: Sequence[int]) -> float:
    """Smallest distance of edges (S, stations) of S states from the half-way to another patch."""
    distances = [
        np.abs(contact.surface.arc[node] - edge).min()
        for edge, state in zip(edges, states, strict=True)
        for node in _borders(contact, state)
    ]
    return min(distances, default=np.inf)


def _borders(contact: ContactHistory, state: int) -> list[int]:
    """Ends of a patch's part of the surface, behind which there is another patch."""
    if contact.node_range is None:
        return []
    ends = (0, len(contact.surface.arc) - 1)
    pairs = zip(contact.node_range[state], ends, strict=True)
    return [int(node) for node, end in pairs if node != end]


def _reaches(contact: ContactHistory, edges: Array, room: float) -> Array:
    """(R,) radii: some elements at least, and not as far as the other edge or another patch.

    None (R = 0) where there is no room for some elements between this patch and another one.
    """
    half_width = (edges[1] - edges[0]) / 2
    sizes = np.diff(contact.surface.arc)
    element = max(sizes[np.searchsorted(contact.surface.arc[1:-1], edge)] for edge in edges)
    smallest = max(REACHES[0] * half_width, FEWEST_ELEMENTS * element)
    largest = min(REACHES[-1] / REACHES[0] * smallest, LARGEST * half_width, room)
    if largest == room < FEWEST_ELEMENTS * element:
        return np.array([])
    return np.array(REACHES) / REACHES[-1] * largest


def _tips(model: Model, pair: Pair, point: Array, front: PlaneFront) -> tuple[Tip, Tip]:
    """A station at a point (2,), on the surfaces of both bodies, each with its own tangent."""
    contact = model.case.contacts[pair.name]
    tips = []
    for name, outward in ((contact.surface1, -1.0), (contact.surface2, 1.0)):
        places, normals = model.surfaces[name].nearest(point[None])
        tips.append(Tip(places[0], _frame(outward * normals[0], front, model.components)))
    return tips[0], tips[1]


def _frame(across: Array, front: PlaneFront, components: int) -> Array:
    """(c, c) normal (2,), tangent from a front into the contact, and unless c is 2 `along`."""
    rows = np.zeros((2, 3))
    rows[:, :2] = across, front.inward * perpendicular(across[None])
    return np.vstack([rows, np.cross(*rows)])[:components, :components]


def _at(surface: ContactSurface, edge: float, values: Array) -> Array:
    """(d,) values (N, d) of the nodes at a place along the arc."""
    return np.array([np.interp(edge, surface.arc, column) for column in values.T])


class _SolidDraft(_Draft["_Plan"]):
    """A probe for each front in each chosen state."""

    def __init__(self, common: _Common, tracks: Tracks) -> None:
        super().__init__(common)
        self._tracks = tracks
        self._fields_of: dict[int, tuple[int, ...]] = {}

    def _plan(self, contact: ContactHistory) -> _Plan | None:
        tracks = self._tracks.get(contact.name, ())
        return _plan(self._common.solution, contact, tracks, self._common.moving)

    def _of_state(self, state: int) -> tuple[int, ...]:
        """Numbers of the mean fields of areas around that of a state, one for each driver."""
        # Imported where it is needed: SciPy's interpolation takes a second.
        from fretfe.evaluate.space.fronts import AREAS, nested_areas

        if state not in self._fields_of:
            recorder = self._common.recorder
            closed = recorder.state(state).closed
            areas = np.tile(closed, (AREAS, 1))
            for contact in self._common.solution.contacts:
                nodes = recorder.nodes_of(contact.pair)
                tracks = self._tracks.get(contact.name, ())
                places = [track.fit.place[state] for track in tracks]
                areas[:, nodes] = nested_areas(
                    contact.surface.points, closed[nodes], tracks, places
                )
            self._fields_of[state] = self.fields.of_areas(state, list(areas))
        return self._fields_of[state]

    def _probes(self, contact: ContactHistory, plan: _Plan) -> list[Probe]:
        pair, difference = self._common.pairs[contact.pair], self._common.difference
        probes, first = [], 0
        for track in self._tracks[contact.name]:
            stations = slice(first, first + len(track.front.sectors))
            first = stations.stop
            tubes = _tubes(track.front, self._crystals(contact))
            for row, (state, places) in enumerate(zip(plan.states, plan.positions, strict=True)):
                own = np.where(np.isfinite(places), places, 0.0)[stations]
                fields, ways = self._of_state(int(state)), tubes
                if row != plan.last:
                    ways = [[each[USUAL]] for each in tubes]
                elif difference is not None:
                    fields = (*fields, difference)
                frames = track.front.frames.moved(own).slid(track.front.aside)
                probes.append(probe_stations(self._common.model, pair, frames, ways, fields))
        return probes

    def _crystals(self, contact: ContactHistory) -> bool:
        bodies = self._common.model.case.bodies
        return not all(isotropic(bodies[name]) for name in (contact.body1, contact.body2))

    def _factors(
        self, contact: ContactHistory, plan: _Plan, values: list[list[Array]]
    ) -> tuple[StationIntegrals, NearbyLoads | None]:
        """Factors of all stations, of the difference of the neighbours behind those of the drivers.

        Args:
            contact: the contact.
            plan: S states and n stations.
            values: for each front, S lists with (R, d, J) for each of its stations in the state
                of `_Plan.last`, (1, d, J) in the others.
        """
        count = len(plan.states)
        states = [
            np.concatenate([np.stack(each, axis=1) for each in values[row::count]], axis=1)
            for row in range(count)
        ]
        drivers, whole = self._common.solution.driver_values.shape[1], states[plan.last]
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
        neighbours = self._common.nearby_loads
        if neighbours is None or oscillates(self._common.model.case, contact):
            return integrals, None
        k_i = whole[..., Factor.K_I, drivers]
        k_i = np.where(np.isfinite(plan.positions[plan.last]), k_i, np.nan)
        pressure = np.array([self._mean_pressure(contact, each) for each in neighbours])
        return integrals, NearbyLoads(pressure, k_i, self._common.moving)

    def _mean_pressure(self, contact: ContactHistory, state: ContactState) -> Array:
        """(N,) means around the nodes of a contact."""
        nodes = self._common.recorder.nodes_of(contact.pair)
        averaging = self._common.pairs[contact.pair].coupling.averaging
        return np.asarray(averaging @ (state.traction[nodes, 0] / np.sqrt(contact.surface.weights)))


@dataclass(frozen=True)
class _Plan:
    """States of one contact and its stations there.

    Attributes:
        states: (S,) their numbers.
        areas: (S,) numbers of their contact areas.
        positions: (S, n) of all stations, inward from the reference.
        last: which of the areas is nearest to that of the state around which loads are changed.
    """

    states: Indices
    areas: Indices
    positions: Array
    last: int


def _plan(
    solution: Solution, contact: ContactHistory, tracks: Sequence[FrontTrack], moving: int
) -> _Plan | None:
    """States of the cycle with the smallest and largest area whose K_N is known, if any."""
    if not tracks:
        return None
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([tracks[0].state])
    # One state for each area, the same for all contacts.
    areas, first = np.unique(contact.full_stick.area[states], return_index=True)
    states = states[first]
    places = np.concatenate([track.fit.place[states] for track in tracks], axis=1)
    # A contact whose pressure has no fits is too small for integrals too.
    k_n = np.concatenate([track.fit.k_n[states] for track in tracks], axis=1)
    known = np.isfinite(k_n).any(axis=1) & (areas >= 0)
    if not known.any():
        return None
    states, areas, places = states[known], areas[known], places[known]
    sizes = contact.nodes_pressed_in(states)
    chosen = [int(np.argmin(sizes)), int(np.argmax(sizes))]
    if np.ptp(sizes) <= SAME_AREA * sizes.max():
        chosen = chosen[1:]
    size = contact.nodes_pressed_in(np.array([moving]))
    last = int(np.argmin(np.abs(sizes[chosen] - size)))
    return _Plan(states[chosen], areas[chosen], places[chosen], last)


def _tubes(front: SpaceFront, crystals: bool) -> list[list[Tube]]:
    """For each station of a front its tubes; those between crystals are shorter where it bends."""
    # Imported where it is needed: SciPy's interpolation takes a second.
    from fretfe.evaluate.space.range_spread import farthest

    tubes, frames = [], front.frames.slid(front.aside)
    most = max(along for _, along in TUBES)
    for sector, depth, to_end in zip(front.sectors, front.depth, frames.to_end, strict=True):
        radius = 1 / max(abs(sector.curvature), 1e-300)
        widest, longest = farthest(depth, radius), min(radius, NEAREST_END * to_end)
        bent = max(TURN * radius, ROWS * sector.along_size) if crystals else math.inf
        tubes.append(
            [
                Tube(
                    reach=min(reach * sector.size, widest),
                    half_length=min(
                        max(along * sector.size, ROWS * sector.along_size),
                        longest,
                        along / most * bent,
                    ),
                )
                for reach, along in TUBES
            ]
        )
    return tubes
