# SPDX-License-Identifier: LGPL-3.0-or-later
"""Singular edge factors at stations of contact fronts, from the displacement fields they need."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from dolfinx import fem

from fretfe._typing import Array, Bools
from fretfe.analytic.edges import oscillation
from fretfe.bodies.definition import Pair
from fretfe.case import Case
from fretfe.contact.full_stick import FRACTION, Increments
from fretfe.contact.recorder import Recorder
from fretfe.contact.state import ContactState
from fretfe.fem.interaction_integral import Forms, InteractionForm, Tip, Tube
from fretfe.fem.model import Model, Request, Share
from fretfe.idealise.bodies import coupled_beta
from fretfe.materials.material import Material
from fretfe.materials.moduli import half_plane

# Whether bodies 1 and 2 are above the interface.
UPPER = (True, False)


class Stations(Protocol):
    """Stations of the fronts of a solid contact, with their frames."""

    @property
    def points(self) -> Array:
        """(n, 3)."""

    @property
    def inward(self) -> Array:
        """(n, 3) unit vectors normal to the front in the tangent plane, into the contact."""

    @property
    def along(self) -> Array:
        """(n, 3) unit tangents of the front, `across` x `inward`."""

    @property
    def across(self) -> Array:
        """(n, 3) outward unit normals of body 2."""

    @property
    def curvature(self) -> Array:
        """(n,) of the front in the tangent plane, positive where the contact is convex."""


@dataclass(frozen=True)
class Probe:
    """Integrals wanted at places of a contact: at one or more stations, in one or more areas.

    Attributes:
        bodies: body 1 and body 2.
        tips: for each place: the station as body 1 and body 2 see it.
        frames: for each place: (d, d) frame of the contact, along which tractions are counted, in
            the order of `Factor`.
        fields: for each place: numbers of the fields it is to be multiplied with.
        tubes: for each place: R of them.
        oscillation: epsilon of full stick between unlike bodies; K_I and K_T are then those at the
            length 1. Zero between similar ones.
        excess: of the first Lamé constants of unlike bodies over the mean of both.
    """

    bodies: tuple[str, str]
    tips: tuple[tuple[Tip, Tip], ...]
    frames: tuple[Array, ...]
    fields: tuple[tuple[int, ...], ...]
    tubes: tuple[tuple[Tube, ...], ...]
    oscillation: float = 0.0
    excess: tuple[float, float] = (0.0, 0.0)

    def form_key(self, upper: bool) -> tuple[str, bool, float, float]:
        """Key of the form of body 1, the upper one, or of body 2."""
        number = 0 if upper else 1
        return self.bodies[number], upper, self.oscillation, self.excess[number]


def probe_stations(
    model: Model,
    pair: Pair,
    stations: Stations,
    tubes: Sequence[Sequence[Tube]],
    fields: Sequence[int],
) -> Probe:
    """The probe of stations of a solid contact, each of them multiplied with the same fields.

    Each body sees a station on its own surface: next to the contact the two are not parallel. The
    curvature of the front is taken for the same on both. A tube must not reach another front, the
    centre of curvature, or a boundary of a body that is not one of its contact surfaces.

    Args:
        model: the bodies.
        pair: the contact.
        stations: n of them.
        tubes: for each station R of them.
        fields: numbers of J of the requests that `measure` is called with.
    """
    contact = model.case.contacts[pair.name]
    frames = np.stack([stations.across, stations.inward, stations.along], axis=1)
    seen = [
        _seen_from(model, name, outward, stations, frames)
        for name, outward in ((contact.surface1, -1.0), (contact.surface2, 1.0))
    ]
    return Probe(
        bodies=(pair.body1, pair.body2),
        tips=tuple(zip(*seen, strict=True)),
        frames=tuple(frames),
        fields=(tuple(fields),) * len(frames),
        tubes=tuple(tuple(each) for each in tubes),
        **bond(model.case, pair),
    )


def bond(case: Case, pair: Pair) -> dict[str, Any]:
    """The constants of unlike bodies for probes of their contact, by the names of `Probe`."""
    epsilon = oscillation(coupled_beta(case, pair.name, pair.body1, pair.body2))
    if epsilon == 0:
        return {}
    first, second = (
        Material.of(case.bodies[name], case.model.plane).first_lame
        for name in (pair.body1, pair.body2)
    )
    return {"oscillation": epsilon, "excess": ((first - second) / 2, (second - first) / 2)}


def _seen_from(
    model: Model, surface: str, outward: float, stations: Stations, frames: Array
) -> list[Tip]:
    """Stations on the surface of one body."""
    places, normals = model.surfaces[surface].nearest(stations.points)
    tips = []
    for point, place, normal, frame, curvature in zip(
        stations.points, places, outward * normals, frames, stations.curvature, strict=True
    ):
        # Places are samples: the surface is their tangent plane.
        point = point + normal * (normal @ (place - point))
        inward = frame[1] - normal * (normal @ frame[1])
        inward /= np.linalg.norm(inward)
        tips.append(Tip(point, np.array([normal, inward, np.cross(normal, inward)]), curvature))
    return tips


def _nobody(_: str) -> None:
    """Tell nobody."""


def measure(
    model: Model,
    probes: Sequence[Probe],
    shares: Sequence[Share],
    say: Callable[[str], None] = _nobody,
) -> list[list[Array]]:
    """Singular edge factors of displacement fields. Collective.

    Args:
        model: the bodies.
        probes: what to integrate, the same on all ranks.
        shares: of the fields, the same on all ranks.
        say: told how many of the probes are done.

    Returns:
        For each place of each probe (R, d, J) factors of its J fields, in the order of `Factor`; on
        rank 0, nothing elsewhere. Per unit of the fields, as K in pressure or shear ~ K/sqrt(s).
    """
    fields = _displacements(model, model.recover_fields(shares))
    _add_forms(model, probes)
    # All bodies have the same loads.
    amplitudes = np.array([next(iter(share.values()))[2] for share in shares])
    found = []
    for number, probe in enumerate(probes, start=1):
        say(f"edge factors: {number} of {len(probes)}")
        found.append(_integrate(probe, model.forms, fields, amplitudes))
    gathered = model.comm.gather(found) or []
    return [
        _whole(model.case, probe, [sum(place) for place in zip(*of_probe, strict=True)])
        for probe, of_probe in zip(probes, zip(*gathered, strict=True), strict=False)
    ]


def _displacements(model: Model, fields: list[dict[str, fem.Function]]) -> dict[str, Array]:
    """(m, d, n) displacements by n fields of this rank's nodes of each body."""
    size = model.components
    return {
        name: np.stack([field[name].x.array.reshape(-1, size) for field in fields], axis=2)
        for name in (fields[0] if fields else {})
    }


def _add_forms(model: Model, probes: Sequence[Probe]) -> None:
    """Add the forms that probes need, of the bodies of this rank's group."""
    forms = model.forms
    for probe in probes:
        for upper in UPPER:
            key = name, _, epsilon, excess = probe.form_key(upper)
            if name in model.bodies and key not in forms:
                surfaces = list(model.body_definition(name).surfaces)
                body = model.bodies[name]
                forms[key] = InteractionForm(
                    body.elastic, surfaces, upper, body.loads, epsilon, excess
                )


def _integrate(
    probe: Probe, forms: Forms, fields: dict[str, Array], amplitudes: Array
) -> list[Array]:
    """For each place of a probe: (R, d, J) what this rank adds to its integrals.

    Args:
        probe: what to integrate.
        forms: of its bodies.
        fields: (m, d, n) displacements of the bodies by n fields.
        amplitudes: (n, l) of the loads in these fields.
    """
    results = []
    for tips, frame, numbers, tubes in zip(
        probe.tips, probe.frames, probe.fields, probe.tubes, strict=True
    ):
        integrals = np.zeros((len(tubes), len(frame), len(numbers)))
        for upper, name, tip in zip(UPPER, probe.bodies, tips, strict=True):
            key = probe.form_key(upper)
            if key not in forms:
                continue
            displacements = fields[name][..., list(numbers)]
            form, own = forms[key], amplitudes[list(numbers)]
            integrals += form.products(tip, tubes, displacements)
            integrals += form.load_products(tip, tubes) @ own.T
        results.append(integrals)
    return results


def _whole(case: Case, probe: Probe, sums: list[Array]) -> list[Array]:
    """For each place of a probe: (R, d, J) factors from integrals over both bodies.

    Between unlike bodies those of both modes in the plane by E* cosh^2(pi epsilon), that of shear
    along the front by the shear moduli alone: G = K_III^2 (1/G1 + 1/G2)/4.
    """
    size, grown = len(probe.frames[0]), math.cosh(math.pi * probe.oscillation) ** 2
    bonded = np.array([grown, grown, 1.0])[:size]
    results = []
    for integrals, tips, frame in zip(sums, probe.tips, probe.frames, strict=True):
        compliances = [
            half_plane(case.bodies[name], case.model.plane, tip.frame).compliance[:size, :size] / 2
            for name, tip in zip(probe.bodies, tips, strict=True)
        ]
        factors = np.linalg.solve(sum(compliances), integrals) / np.sqrt(2 * np.pi)
        shares = [np.linalg.solve(sum(compliances), each) for each in compliances]
        scaled = (_signs(size) * bonded)[:, None] * factors
        results.append(_turned(scaled, tips, frame, shares))
    return results


def _signs(size: int) -> Array:
    """(d,) signs by which factors are the components of a traction on body 2.

    Contact pressure is positive, stress that opens a crack is tension.
    """
    return np.array([-1.0, 1.0, 1.0])[:size]


def _turned(factors: Array, tips: tuple[Tip, Tip], frame: Array, shares: Sequence[Array]) -> Array:
    """Factors (R, d, J) in the frame of the contact instead of those of the two surfaces.

    Each body measures the traction of the ligament along its own surface; the two surfaces are not
    parallel before they are pressed together. Pressure and friction are counted along one normal.

    Args:
        factors: sums over both bodies.
        tips: the station as body 1 and body 2 see it.
        frame: (d, d) of the contact.
        shares: (d, d) of each body in the sum of the compliances; E*/E' of modes I and II.
    """
    signs = _signs(len(frame))
    turn = sum(share @ tip.frame @ frame.T for share, tip in zip(shares, tips, strict=True))
    return np.linalg.solve(signs[:, None] * turn * signs, factors)


def state_requests(recorder: Recorder, states: Sequence[int]) -> list[Request]:
    """Requests for the fields of solved states."""
    return [Request.of(state, loads) for state, loads in recorder.requests(list(states))]


class UnitFields:
    """Requests for the full-stick fields of contact areas, numbered; rank 0 only.

    Args:
        recorder: the solved history.

    Attributes:
        requests: the fields.
    """

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder
        self.requests: list[Request] = []
        self._known: dict[int, tuple[int, ...]] = {}

    def difference(self, low: ContactState, high: ContactState) -> int:
        """Number of the field by which two neighbours of the last state differ."""
        amplitudes = 2 * FRACTION * self._recorder.last_loads.amplitudes
        traction = (high.traction - low.traction).ravel()
        coordinates = high.coordinates - low.coordinates
        self.requests.append(Request(traction, coordinates, amplitudes))
        return len(self.requests) - 1

    def of_area(self, area: int) -> tuple[int, ...]:
        """Numbers of the fields of a contact area, one for each driver."""
        if area not in self._known:
            self._known[area] = self._add(self._recorder.increments(area))
        return self._known[area]

    def of_areas(self, state: int, areas: Sequence[Bools]) -> tuple[int, ...]:
        """Numbers of the mean fields of contact areas around that of a state, one per driver.

        Args:
            state: number of the state.
            areas: for each area the nodes in contact (N,), of all contacts.
        """
        return self._add(self._recorder.mean_increments(state, areas))

    def _add(self, increments: Increments) -> tuple[int, ...]:
        drivers, first = self._recorder.drivers, len(self.requests)
        for j, load in enumerate(drivers.loads):
            amplitudes = np.zeros(len(self._recorder.last_loads.amplitudes))
            if load >= 0:
                amplitudes[load] = 1.0
            traction = increments.traction[:, :, j].ravel()
            self.requests.append(Request(traction, increments.coordinates[:, j], amplitudes))
        return tuple(range(first, len(self.requests)))
