# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interaction integrals at all stations of a solved history. Collective."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.bodies.pairs import Pair
from fretfe.contact.march import March
from fretfe.contact.neighbours import neighbour_states
from fretfe.contact.recorder import Recorder
from fretfe.edges.pressure import FEWEST_NODES, fit_edge
from fretfe.edges.section import PLANE_FRONTS, PlaneFront, plane_sections
from fretfe.edges.separation import own_part
from fretfe.edges.slip_zones import cycle_states
from fretfe.fem.interaction_integral import Tip, Tube
from fretfe.fem.model import Model, Request
from fretfe.fem.probes import Probe, measure
from fretfe.fem.unit_fields import UnitFields
from fretfe.results.solution import (
    ContactHistory,
    Factor,
    Neighbours,
    Solution,
    StationIntegrals,
)
from fretfe.surface.surface import perpendicular

# Contact areas of the cycle at which the integrals are taken: smallest, middle, largest.
AREAS = 3
# Contact areas that differ by less than this fraction are one.
SAME_AREA = 0.02
# Radii of the circles, in half-widths of the contact, and how far the smallest and largest one are
# from elements and from the middle.
REACHES = (0.1, 0.15, 0.25)
FEWEST_ELEMENTS, LARGEST = 10.0, 0.5


def add_integrals(
    model: Model,
    recorder: Recorder | None,
    march: March | None,
    solution: Solution | None,
) -> Solution | None:
    """The solution of a plane history with the interaction integrals of its contacts. Collective.

    Recorder, march and solution are those of rank 0, None elsewhere, like what is returned.
    """
    draft = _Draft(model, recorder, march, solution) if recorder and march and solution else None
    probes, requests = (draft.probes, draft.requests) if draft else (None, None)
    values = measure(model, probes, requests)
    return draft.finish(values) if draft and values is not None else None


class _Draft:
    """Plans the integrals and gives the results their place; rank 0 only."""

    def __init__(self, model: Model, recorder: Recorder, march: March, solution: Solution) -> None:
        assert model.reduction is not None
        self._solution = solution
        self._recorder = recorder
        self._fields = UnitFields(recorder)
        states = neighbour_states(march, recorder.last, recorder.last_loads)
        self._neighbours = states
        self._difference = () if states is None else (self._fields.difference(*states),)
        self._contacts: dict[str, _Areas] = {}
        self._places: list[tuple[str, int]] = []
        probes: list[Probe] = []
        pairs = {pair.name: pair for pair in model.reduction.pairs}
        for contact in solution.contacts:
            areas = _choose_areas(solution, contact)
            if areas is not None:
                self._contacts[contact.name] = areas
                self._places += [(contact.name, front.number) for front in PLANE_FRONTS]
                pair = pairs[contact.pair]
                probes += [self._probe(model, pair, areas, front) for front in PLANE_FRONTS]
        self.probes = tuple(probes)

    @property
    def requests(self) -> list[Request]:
        """The fields that the probes are multiplied with."""
        return self._fields.requests

    def finish(self, values: list[list[Array]]) -> Solution:
        """The solution with the integrals, one list of values for each probe."""
        found = dict(zip(self._places, values, strict=True))
        contacts = []
        for contact in self._solution.contacts:
            areas = self._contacts.get(contact.name)
            if areas is not None:
                stations = [found[contact.name, front.number] for front in PLANE_FRONTS]
                contact = replace(
                    contact,
                    integrals=_integrals(areas, stations),
                    neighbours=self._neighbour_history(contact, stations),
                )
            contacts.append(contact)
        return replace(self._solution, contacts=tuple(contacts))

    def _neighbour_history(
        self, contact: ContactHistory, stations: list[list[Array]]
    ) -> Neighbours | None:
        if self._neighbours is None:
            return None
        nodes = self._recorder.nodes_of(contact.pair)
        tractions = np.array([state.traction[nodes, 0] for state in self._neighbours])
        if contact.territory is not None:
            tractions = own_part(tractions, contact.territory[-1])
            if np.any(tractions[:, _borders(contact, -1)] > 0):  # merges with its neighbour
                return None
        normal = np.stack([values[-1][:, Factor.K_I, 0] for values in stations], axis=1)
        return Neighbours(tractions / np.sqrt(contact.weights), normal)

    def _probe(self, model: Model, pair: Pair, areas: _Areas, front: PlaneFront) -> Probe:
        last = [areas.last[front.number]] if self._difference else []
        edges = [*areas.positions[:, front.number], *last]
        fields = [self._fields.of_area(int(area)) for area in areas.numbers]
        fields += [self._difference] if self._difference else []
        tubes = tuple(Tube(float(reach)) for reach in areas.reaches)
        return Probe(
            bodies=(pair.body1, pair.body2),
            tips=tuple(_tips(model, pair, float(edge), front) for edge in edges),
            frames=tuple(
                _frame(_at(pair, float(edge), pair.coupling.frames[:, 0]), front) for edge in edges
            ),
            fields=tuple(fields),
            tubes=(tubes,) * len(edges),
        )


@dataclass(frozen=True)
class _Areas:
    """Some contact areas of one contact.

    Attributes:
        numbers: (S,) the areas.
        positions: (S, stations) there.
        last: (stations,) in the last state.
        reaches: (R,) radii.
    """

    numbers: Indices
    positions: Array
    last: Array
    reaches: Array


def _integrals(areas: _Areas, stations: list[list[Array]]) -> StationIntegrals:
    values = [station[: len(areas.numbers)] for station in stations]
    # (stations, S, R, d, J) to (S, R, stations, d, J)
    factors = np.array(values).transpose(1, 2, 0, 3, 4)
    return StationIntegrals(areas.numbers, areas.positions, areas.reaches, factors)


def _choose_areas(solution: Solution, contact: ContactHistory) -> _Areas | None:
    """Smallest, middle and largest contact area of the cycle; None if edges cannot be fitted."""
    cycle = cycle_states(solution.cycle)
    states = cycle if len(cycle) else np.array([len(solution.times) - 1])
    sizes = contact.nodes_pressed_in(states)
    if sizes.min() < FEWEST_NODES or contact.full_stick.area[states].min() < 0:
        return None
    numbers, firsts = np.unique(contact.full_stick.area[states], return_index=True)
    order = np.argsort(sizes[firsts], kind="stable")
    # Areas that differ by a node or two have the same factors but for that difference.
    count = AREAS if np.ptp(sizes) > SAME_AREA * sizes.max() else 1
    chosen = order[np.unique(np.linspace(0, len(order) - 1, count).round().astype(int))]
    pressure = contact.traction[[*states[firsts[chosen]], states[-1]], :, 0]
    sections = plane_sections(contact.arc, pressure)
    edges = np.stack([fit_edge(section).position for section in sections], axis=1)
    if not np.isfinite(edges).all():
        return None
    room = _room(contact, edges, [*states[firsts[chosen]], states[-1]])
    reaches = _reaches(contact, edges[-1], room)
    return _Areas(numbers[chosen], edges[:-1], edges[-1], reaches) if len(reaches) else None


def _room(contact: ContactHistory, edges: Array, states: Sequence[int]) -> float:
    """Smallest distance of edges (S, stations) of S states from the half-way to another patch."""
    distances = [
        np.abs(contact.arc[node] - edge).min()
        for edge, state in zip(edges, states, strict=True)
        for node in _borders(contact, state)
    ]
    return min(distances, default=np.inf)


def _borders(contact: ContactHistory, state: int) -> list[int]:
    """Ends of a patch's part of the surface, behind which there is another patch."""
    if contact.territory is None:
        return []
    ends = (0, len(contact.arc) - 1)
    pairs = zip(contact.territory[state], ends, strict=True)
    return [int(node) for node, end in pairs if node != end]


def _reaches(contact: ContactHistory, edges: Array, room: float) -> Array:
    """(R,) radii: some elements at least, and not as far as the other edge or another patch.

    None (R = 0) where there is no room for some elements between this patch and another one.
    """
    half_width = (edges[1] - edges[0]) / 2
    sizes = np.diff(contact.arc)
    element = max(sizes[np.searchsorted(contact.arc[1:-1], edge)] for edge in edges)
    smallest = max(REACHES[0] * half_width, FEWEST_ELEMENTS * element)
    largest = min(REACHES[-1] / REACHES[0] * smallest, LARGEST * half_width, room)
    if largest == room < FEWEST_ELEMENTS * element:
        return np.array([])
    return np.array(REACHES) / REACHES[-1] * largest


def _tips(model: Model, pair: Pair, edge: float, front: PlaneFront) -> tuple[Tip, Tip]:
    """A station on the surfaces of body 1 and body 2, each with its own tangent."""
    point = _at(pair, edge, pair.coupling.points)
    contact = model.case.contacts[pair.name]
    tips = []
    for name, outward in ((contact.surface1, -1.0), (contact.surface2, 1.0)):
        places, normals = model.surfaces[name].nearest(point[None])
        tips.append(Tip(places[0], _frame(outward * normals[0], front)))
    return tips[0], tips[1]


def _frame(across: Array, front: PlaneFront) -> Array:
    """(2, 2) normal, and the tangent from a front into the contact."""
    return np.array([across, front.inward * perpendicular(across[None])])


def _at(pair: Pair, edge: float, values: Array) -> Array:
    """(d,) values (N, d) of the multiplier nodes at a place along the arc."""
    return np.array([np.interp(edge, pair.coupling.arc, column) for column in values.T])
