# SPDX-License-Identifier: LGPL-3.0-or-later
"""Interaction integrals at all stations of a solved history. Collective."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from dolfinx import fem

from fretfe._typing import Array, Indices
from fretfe.bodies.pairs import Pair
from fretfe.case import Case, contact_modulus, plane_modulus
from fretfe.contact.march import March
from fretfe.contact.neighbours import FRACTION, neighbour_states
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState
from fretfe.edges.pressure import FEWEST_NODES, fit_edge
from fretfe.edges.section import PLANE_FRONTS, PlaneFront, plane_sections
from fretfe.edges.separation import own_part
from fretfe.edges.slip_zones import cycle_states
from fretfe.fem.interaction_integral import MODES, InteractionForm, Tip
from fretfe.fem.model import Model, Request
from fretfe.results.solution import (
    ContactHistory,
    Factor,
    Neighbours,
    Solution,
    StationIntegrals,
)

# Whether bodies 1 and 2 are above the interface.
UPPER = (True, False)
# By body and whether it is body 1: it may be body 1 of one contact and body 2 of another one.
Forms = dict[tuple[str, bool], InteractionForm]

# Contact areas of the cycle at which the integrals are taken: smallest, middle, largest.
AREAS = 3
# Contact areas that differ by less than this fraction are one.
SAME_AREA = 0.02
# Radii of the circles, in half-widths of the contact, and how far the smallest and largest one are
# from elements and from the middle.
REACHES = (0.1, 0.15, 0.25)
FEWEST_ELEMENTS, LARGEST = 10.0, 0.5


@dataclass(frozen=True)
class Probe:
    """One station of one contact.

    Attributes:
        contact: name.
        front: number of its front.
        bodies: body 1 and body 2.
        tips: for each area, then for the last state: the station as body 1 and body 2 see it.
        normals: for each of `tips`: contact normal, along which pressure is counted.
        fields: for each of `tips`: numbers of the fields it is to be multiplied with.
        reaches: (R,) radii.
    """

    contact: str
    front: int
    bodies: tuple[str, str]
    tips: tuple[tuple[Tip, Tip], ...]
    normals: tuple[Array, ...]
    fields: tuple[tuple[int, ...], ...]
    reaches: Array


def add_integrals(
    model: Model,
    case: Case,
    recorder: Recorder | None,
    march: March | None,
    solution: Solution | None,
) -> Solution | None:
    """The solution with the interaction integrals of its contacts.

    Recorder, march and solution are those of rank 0, None elsewhere, like what is returned.
    """
    draft = _Draft(model, recorder, march, solution) if recorder and march and solution else None
    probes = model.comm.bcast(draft.probes if draft else None)
    fields = model.recover_fields(draft.requests if draft else None)
    forms = _forms(model, probes)
    parts = [_integrate(case, probe, forms, fields) for probe in probes]
    # Each body once, whatever the number of ranks that it is distributed over.
    gathered = model.comm.gather(parts if model.first_of_group else None)
    if draft is None or gathered is None:
        return None
    bodies = [part for part in gathered if part is not None]
    values = [
        _whole(case, probe, [sum(tip) for tip in zip(*of_probe, strict=True)])
        for probe, of_probe in zip(probes, zip(*bodies, strict=True), strict=True)
    ]
    return draft.finish(values)


def _integrate(
    case: Case, probe: Probe, forms: Forms, fields: list[dict[str, fem.Function]]
) -> list[Array]:
    """For each tip of a probe: the part of this rank's bodies in the factors; see `_whole`."""
    modulus, _ = _moduli(case, probe)
    # Contact pressure is positive, stress that opens a crack is tension.
    scale = modulus / np.sqrt(2 * np.pi)
    signs = np.empty(len(MODES))
    signs[Factor.K_I], signs[Factor.K_T] = -scale, scale
    results = []
    for tips, numbers in zip(probe.tips, probe.fields, strict=True):
        factors = np.zeros((len(probe.reaches), len(signs), len(numbers)))
        for upper, name, tip in zip(UPPER, probe.bodies, tips, strict=True):
            if (name, upper) not in forms:
                continue
            vectors = [fields[number][name].x.petsc_vec for number in numbers]
            for r, reach in enumerate(probe.reaches):
                functionals = forms[name, upper].functionals(tip, float(reach))
                products = [[each.dot(vector) for vector in vectors] for each in functionals]
                factors[r] += signs[:, None] * np.array(products)
        results.append(factors)
    return results


def _whole(case: Case, probe: Probe, sums: list[Array]) -> list[Array]:
    """For each tip of a probe: (R, d, n) singular factors of its n fields, as `Factor`."""
    _, shares = _moduli(case, probe)
    return [
        _turned(factors, tips, normal, shares)
        for factors, tips, normal in zip(sums, probe.tips, probe.normals, strict=True)
    ]


def _moduli(case: Case, probe: Probe) -> tuple[float, Array]:
    """Contact modulus of the bodies of a probe, and what each of them contributes to it."""
    bodies = [case.bodies[name] for name in probe.bodies]
    modulus = contact_modulus(bodies[0], bodies[1], case.model.plane)
    shares = modulus / np.array([plane_modulus(body, case.model.plane) for body in bodies])
    return modulus, shares


def _turned(factors: Array, tips: tuple[Tip, Tip], normal: Array, shares: Array) -> Array:
    """Factors (R, d, n) in the frame of the contact instead of those of the two surfaces.

    Each body measures the traction of the ligament along its own surface; the two surfaces are not
    parallel before they are pressed together. Pressure and friction are counted along one normal.

    Args:
        factors: singular ones, sums over both bodies.
        tips: the station as body 1 and body 2 see it.
        normal: (2,) of the contact.
        shares: (2,) share of each body in the sum, E*/E'.
    """
    across = np.array([tip.across for tip in tips])
    inward = np.array([normal[1], -normal[0]])
    inward *= np.sign(inward @ tips[1].inward)
    cosine, sine = shares @ (across @ normal), -shares @ (across @ inward)
    shear, pressure = factors[:, Factor.K_T], factors[:, Factor.K_I]
    turned = np.empty_like(factors)
    turned[:, Factor.K_T] = cosine * shear + sine * pressure
    turned[:, Factor.K_I] = cosine * pressure - sine * shear
    return np.asarray(turned / (cosine**2 + sine**2))


def _forms(model: Model, probes: tuple[Probe, ...]) -> Forms:
    """The forms that probes need, of the bodies of this rank's group."""
    forms = {}
    for probe in probes:
        for name, upper in zip(probe.bodies, UPPER, strict=True):
            if name in model.bodies and (name, upper) not in forms:
                surfaces = list(model.body_definition(name).surfaces)
                forms[name, upper] = InteractionForm(model.bodies[name].elastic, surfaces, upper)
    return forms


class _Draft:
    """Plans the integrals and gives the results their place; rank 0 only."""

    def __init__(self, model: Model, recorder: Recorder, march: March, solution: Solution) -> None:
        assert model.reduction is not None
        self._solution = solution
        self._recorder = recorder
        self.requests: list[Request] = []
        self._area_fields: dict[int, tuple[int, ...]] = {}
        states = neighbour_states(march, recorder.last, recorder.last_loads)
        self._neighbours = states
        self._difference = () if states is None else (self._request_difference(*states),)
        self._contacts: dict[str, _Areas] = {}
        probes: list[Probe] = []
        pairs = {pair.name: pair for pair in model.reduction.pairs}
        for contact in solution.contacts:
            areas = _choose_areas(solution, contact)
            if areas is not None:
                self._contacts[contact.name] = areas
                place = contact.name, pairs[contact.pair]
                probes += [self._probe(model, *place, areas, front) for front in PLANE_FRONTS]
        self.probes = tuple(probes)

    def finish(self, values: list[list[Array]]) -> Solution:
        """The solution with the integrals, one list of values for each probe."""
        found = {
            (probe.contact, probe.front): value
            for probe, value in zip(self.probes, values, strict=True)
        }
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

    def _request_difference(self, low: ContactState, high: ContactState) -> int:
        amplitudes = 2 * FRACTION * self._recorder.last_loads.amplitudes
        traction = (high.traction - low.traction).ravel()
        coordinates = high.coordinates - low.coordinates
        self.requests.append(Request(traction, coordinates, amplitudes))
        return len(self.requests) - 1

    def _fields_of(self, area: int) -> tuple[int, ...]:
        """Numbers of the fields of a contact area, one for each driver."""
        if area not in self._area_fields:
            increments, drivers = self._recorder.increments(area), self._recorder.drivers
            first, count = len(self.requests), len(drivers.names)
            loads = len(self._recorder.last_loads.amplitudes)
            for j in range(count):
                amplitudes = np.zeros(loads)
                if drivers.loads[j] >= 0:
                    amplitudes[drivers.loads[j]] = 1.0
                traction = increments.traction[:, :, j].ravel()
                request = Request(traction, increments.coordinates[:, j], amplitudes)
                self.requests.append(request)
            self._area_fields[area] = tuple(range(first, first + count))
        return self._area_fields[area]

    def _probe(
        self, model: Model, name: str, pair: Pair, areas: _Areas, front: PlaneFront
    ) -> Probe:
        number = front.number
        edges = [*areas.positions[:, number], *([areas.last[number]] if self._difference else [])]
        fields = [self._fields_of(int(area)) for area in areas.numbers]
        fields += [self._difference] if self._difference else []
        return Probe(
            contact=name,
            front=number,
            bodies=(pair.body1, pair.body2),
            tips=tuple(_tips(model, pair, float(edge), front) for edge in edges),
            normals=tuple(_at(pair, float(edge), pair.coupling.frames[:, 0]) for edge in edges),
            fields=tuple(fields),
            reaches=areas.reaches,
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
        across = outward * normals[0]
        tangent = np.array([across[1], -across[0]])
        tips.append(Tip(places[0], front.inward * tangent, across))
    return tips[0], tips[1]


def _at(pair: Pair, edge: float, values: Array) -> Array:
    """(d,) values (N, d) of the multiplier nodes at a place along the arc."""
    return np.array([np.interp(edge, pair.coupling.arc, column) for column in values.T])
