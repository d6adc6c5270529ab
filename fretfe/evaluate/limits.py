# SPDX-License-Identifier: LGPL-3.0-or-later
"""Limits of the model, judged on a solved contact: sliding, strain, and the size of half-planes.

A limit compares a number without dimension, measured in the run, with the value from which the
small-displacement model, or the description of its edges, is wrong by about one per cent.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array
from fretfe.case import AnyBody
from fretfe.case.tables import Plane
from fretfe.caution import Caution, Subject, places
from fretfe.evaluate.contacts import Contact, Station
from fretfe.history.solution import OPEN, ContactHistory
from fretfe.history.state_array import blocks
from fretfe.materials.moduli import normal_modulus
from fretfe.reason import Kind, joined
from fretfe.report.texts import beyond
from fretfe.verdict import Verdict

# Not loaded by reports: SciPy comes with it.
if TYPE_CHECKING:
    from fretfe.contact.recorder import Recorder

# Sliding over the width of the contact: tractions act beside their places on one body by that part
# of it.
LARGEST_SLIDING = 0.1
# Dundurs' beta up to which the formulas for slip zones between unlike bodies were measured in the
# plane.
LARGEST_BETA = 0.25
# Linear elasticity leaves out terms of the order of the strain; 2 % is beyond the yield strain of
# nearly all metals.
LARGEST_STRAIN = 0.02
# Below 1e-5 of the plane modulus, 2 MPa between steels, and above a tenth units are doubted:
# fretting contacts have 1e-4 to 1e-2.
DOUBTED = (1e-5, 0.1)
# Limits beyond which units may be wrong.
CHECK_UNITS = (Kind.PRESSURE, Kind.SLOPE, Kind.STRETCH)
# Slip zones are as long as the mean of f over them is small: their formulas take that at the edge.
EVEN_FRICTION = 0.02
# Tractions next to an edge are far from roots over a layer's length E*/k: of a cylinder on one K_N
# by fits is 8 % off where that is a hundredth of the half-width.
LARGEST_LAYER = 0.01
# Gap that sliding along turned surfaces opens, over the approach of the bodies.
LARGEST_GAP = 0.01
FOLLOWED = (
    "; P is wrong by up to twice that and K_N by several times, unless that program kept the "
    "contact as it was before deformation (small sliding)"
)
# Error of K_N at stations of crystals, over f times their cross compliance. Where points slip,
# shear changes the pressure, and K_N with it, and fits reach from the slip zone to beyond. By
# half-spaces of nickel with the normal <111>, f times the cross compliance .07, K_N is 4.1 and
# 2.4 % above and below that of Hertz under .4 and .7 f P; fits with a/10 find 2.2 and 5.3 %.
CROSSED = 0.5
# Part of a contact, on either side of a station, in which tractions tell what its K_T is.
NEAR = 0.15


@dataclass(frozen=True)
class ModelLimit:
    """A quantity that must be small for the model to hold.

    Attributes:
        contact: name of the contact; "" for all bodies.
        kind: of the caution beyond the limit, which says what is wrong there and what to do.
        quantity: what is measured, over what.
        found: largest value in the run; NaN if it could not be measured.
        limit: value up to which the model holds.
        detail: what is particular in this run, a part of a sentence.
    """

    contact: str
    kind: Kind
    quantity: str
    found: float
    limit: float
    detail: str = ""

    @property
    def consequence(self) -> str:
        """Consequence of going beyond the limit, with what to do."""
        return joined(self.detail, self.kind.remedy)

    @property
    def exceeded(self) -> bool:
        """True if the quantity is known and too large."""
        return self.found > self.limit

    @property
    def used(self) -> float:
        """Part of the limit, which may be zero, that is found; NaN if it could not be measured."""
        if self.limit > 0:
            return self.found / self.limit
        return self.found * math.inf if self.found else 0.0

    @property
    def doubtful(self) -> bool:
        """True if the quantity is so small or large that a unit is likely to be wrong."""
        least, most = DOUBTED
        return self.kind is Kind.PRESSURE and (0 < self.found < least or self.found > most)

    @property
    def verdict(self) -> Verdict:
        """The quantity against its limit."""
        if math.isnan(self.found):
            return Verdict.NOT_MEASURED
        return Verdict.EXCEEDED if self.exceeded else Verdict.WITHIN

    @property
    def caution(self) -> Caution:
        """The quantity, and by how much it is too large or small."""
        kind, found = self.kind, beyond(self.found, self.limit)
        text = f"outside the model: {self.quantity} is {found}, expected at most {self.limit:g}"
        text = joined(text, self.detail)
        if self.doubtful:
            kind = Kind.UNITS
            text = (
                f"the {self.quantity} is {self.found:.2g}, where fretting contacts have 1e-4 to "
                "1e-2"
            )
        return Caution(kind, Subject(self.contact), text)


def with_limit_warnings(
    contacts: Iterable[Contact], limits: Iterable[ModelLimit]
) -> tuple[Contact, ...]:
    """The contacts with a caution for each of their limits that is exceeded.

    A unit that is doubted is told first, in place of those that say so as well.
    """
    told = [limit for limit in limits if limit.exceeded or limit.doubtful]

    def warned(contact: Contact) -> Contact:
        own = [limit for limit in told if limit.contact == contact.name]
        doubtful = tuple(limit.caution for limit in own if limit.doubtful)
        others = tuple(each.caution for each in own if not (doubtful and each.kind in CHECK_UNITS))
        return replace(contact, warnings=(*doubtful, *contact.warnings, *others))

    return tuple(warned(each) for each in contacts)


def contact_limits(
    bodies: Mapping[str, AnyBody], plane: Plane, contact: ContactHistory
) -> Iterator[ModelLimit]:
    """Limits that the history of a contact tells by itself; none if it never closes."""
    extent = contact_extent(contact)
    if extent.width == 0:
        return
    yield ModelLimit(
        contact.name,
        Kind.SLIDING,
        "sliding over the width of the contact",
        extent.sliding / extent.width,
        LARGEST_SLIDING,
    )
    modulus = min(
        normal_modulus(bodies[body], plane, contact.surface.mean_normal)
        for body in (contact.body1, contact.body2)
    )
    yield ModelLimit(
        contact.name,
        Kind.PRESSURE,
        "largest pressure over the plane modulus",
        extent.pressure / modulus,
        LARGEST_STRAIN,
    )
    if contact.friction.largest:
        words, beta = "Dundurs' beta of the bodies, with friction", abs(contact.surface.dundurs)
        yield ModelLimit(contact.name, Kind.DUNDURS, words, beta, LARGEST_BETA)
    if contact.surface.layer is not None:
        across, along = contact.surface.layer
        way = "across" if across >= along else "along"
        yield ModelLimit(
            contact.name,
            Kind.LAYER,
            f"length E*/k over which the layer gives {way} the surface, over the half-width",
            2 * max(across, along) / extent.width,
            LARGEST_LAYER,
        )


def friction_limits(
    contact: Contact, history: ContactHistory, cycle: tuple[int, int] | None
) -> Iterator[ModelLimit]:
    """Change of the coefficient of places in the slip zones over the cycle, if it varies.

    And half of that over the way of an edge, as `FrictionBehind` is that of one place of it: where
    f grows with the distance from an edge, a slice of hold has half of that of the place besides.
    """
    first, last = cycle or (0, len(history.status) - 1)
    fields = history.friction.among(slice(first + 1, last + 1))
    fields = fields[fields.any(axis=1)]
    if not fields.size or fields.min() == fields.max():
        return
    places = history.surface.points if contact.solid else history.surface.arc[:, None]
    changes = [0.0]
    for station in contact.stations:
        place = station.point if contact.solid else np.array([station.position[last]])
        zones = [(each.length, each.prediction) for each in station.slip_zones]
        away = np.linalg.norm(places - place, axis=1)
        reach = np.nan_to_num(np.ravel(zones)).max(initial=0.0)
        near = away <= max(reach, np.nanmin(away, initial=math.inf))
        if station.slides:
            near = np.asarray(history.status[last] != OPEN)
        if station.friction > 0 and near.any():
            over_time = float(np.ptp(fields[:, near], axis=0).max()) / station.friction
            behind, position = station.friction_behind, station.position[first : last + 1]
            way = station.inward * position[np.isfinite(position)]
            moved = float(np.ptp(behind.at(way))) / 2 if behind.varies else 0.0
            changes.append(over_time + moved)
    yield ModelLimit(
        contact.name,
        Kind.FRICTION_VARIES,
        "change of friction in the slip zones over the cycle, over that at the edge",
        max(changes),
        EVEN_FRICTION,
    )


def with_cut_spreads(
    contacts: Iterable[Contact], recorder: Recorder, cycle: tuple[int, int] | None
) -> tuple[Contact, ...]:
    """The contacts with what near cuts leave open in the error bars of their ranges of K_T.

    The displacements of a cut are those of a contact that has slipped, and full stick under them is
    not that of the whole bodies. The difference falls with the fourth power of the distance.
    """
    if not recorder.has_cuts or cycle is None:
        return tuple(contacts)
    first, last = cycle
    nodes = {
        place.name: (place.surface.points, recorder.nodes_of(place.name))
        for place in recorder.places
    }
    both = cache(recorder.both_ways)

    def widened(station: Station, points: Array, own: slice) -> Station:
        if not np.isfinite(station.k_range):
            return station
        k = station.k_along[first : last + 1]
        ends = sorted((first + int(np.argmin(k)), first + int(np.argmax(k))))
        by_forces, held = (each[own] for each in both(*ends))
        share = _difference_near(points, station.point[: points.shape[1]], by_forces, held)
        parts = station.k_range_parts
        wider = math.hypot(parts.discretisation, share * station.k_range)
        parts = replace(parts, discretisation=wider)
        return replace(station, k_range_parts=parts, k_range_spread=parts.total)

    return tuple(
        replace(
            contact,
            fronts=tuple(
                replace(
                    front,
                    stations=tuple(widened(each, *nodes[contact.pair]) for each in front.stations),
                )
                for front in contact.fronts
            ),
        )
        for contact in contacts
    )


def with_crossed_spreads(
    contacts: Iterable[Contact],
    histories: Iterable[ContactHistory],
    bodies: Mapping[str, AnyBody],
    plane: Plane,
) -> tuple[Contact, ...]:
    """The contacts of solids with what the cross compliance of crystals adds to the bars of K_N."""
    # Imported where it is needed: reports of plane contacts do without SciPy.
    from fretfe.idealise.bodies import cross_compliance

    found = []
    for contact, history in zip(contacts, histories, strict=True):
        if contact.solid:
            pair, normal = (history.body1, history.body2), history.surface.mean_normal
            body1, body2 = (bodies[each] for each in pair)
            cross = cross_compliance(body1, body2, plane, normal)
            contact = _crossed(contact, history, cross) if cross else contact
        found.append(contact)
    return tuple(found)


def _crossed(contact: Contact, history: ContactHistory, cross: float) -> Contact:
    """A contact with wider bars of K_N where pressure and shear displace across each other."""

    def widened(station: Station) -> Station:
        relative = CROSSED * cross * history.friction.acts * station.friction
        return replace(station, k_n_spread=np.hypot(station.k_n_spread, relative * station.k_n))

    fronts = (
        replace(front, stations=tuple(map(widened, front.stations))) for front in contact.fronts
    )
    return replace(contact, fronts=tuple(fronts))


def _difference_near(points: Array, place: Array, first: Array, second: Array) -> float:
    """Relative difference of shear (n, d) at points (n, d) in contact next to a place (d,)."""
    closed = first.any(axis=1)
    size = np.linalg.norm(np.ptp(points[closed], axis=0))
    away = np.linalg.norm(points - place, axis=1)
    near = closed & (away < NEAR * size)
    shear = first[near, 1:]
    square = np.sum(shear**2)
    return float(abs(np.sum(shear * (second - first)[near, 1:]) / square)) if square else 0.0


def surface_notes(
    bodies: Mapping[str, AnyBody],
    plane: Plane,
    histories: Iterable[ContactHistory],
    contacts: Collection[Contact],
    limits: Iterable[ModelLimit],
) -> Iterator[str]:
    """Difference that following the deformed surfaces makes in a run that moves cuts, in words.

    Sliding s along surfaces that have turned by θ opens or closes a gap s θ, of second order, which
    is left out here. It is compared with P/(E* w), w the width of the contact, of solids for P per
    length: about the displacement by which P presses the bodies together.

    Args:
        bodies: of a case whose cuts another program moves.
        plane: how it is plane.
        histories: of the contacts.
        contacts: their evaluation.
        limits: of the model.
    """
    forces = {each.name: float(each.normal_force.max()) for each in contacts}
    turns = {each.contact: each.found for each in limits if each.kind is Kind.ROTATION}
    for history in histories:
        extent, turn = contact_extent(history), turns.get(history.name, math.nan)
        pair, normal = (history.body1, history.body2), history.surface.mean_normal
        soft = sum(1 / normal_modulus(bodies[each], plane, normal) for each in pair)
        length = extent.width if history.surface.points.shape[1] == 3 else 1.0
        gap, pressed = extent.sliding * turn, forces[history.name] * soft / length
        if gap > 0 and pressed > 0:
            yield (
                f"{history.name}: the contact slides by up to {extent.sliding:.2g} and turns by up "
                f"to {turn:.2g}. A program that follows the deformed surfaces has them {gap:.2g} "
                f"nearer or farther than here, {gap / pressed:.2g} of what P presses them together "
                f"by{FOLLOWED if gap > LARGEST_GAP * pressed else ''}"
            )


def unlike_notes(chosen: float | None, contacts: Collection[Contact]) -> Iterator[str]:
    """A line for all fronts between alike pairs of unlike bodies, with the spans of their factors.

    Args:
        chosen: the length that a case asks for, or None.
        contacts: their evaluation.
    """
    if chosen and not any(each.oscillation for contact in contacts for each in contact.stations):
        yield (
            "edges.reference_length has no effect: there is no edge between unlike bodies with "
            "friction"
        )
    fronts: dict[tuple[str, str], dict[Subject, list[Station]]] = {}
    for contact in contacts:
        for front in contact.fronts:
            if stations := [each for each in front.stations if each.oscillation]:
                origin = "as edges.reference_length" if chosen else _origin(stations)
                alike = fronts.setdefault((origin, f"{stations[0].oscillation:.4f}"), {})
                alike[Subject(contact.name, front.name)] = stations
    for (origin, oscillation), alike in fronts.items():
        found = [each for stations in alike.values() for each in stations]
        exponents = np.array([each.exponent for each in found])
        lengths = _span(np.array([each.reference_length for each in found]), ".3g")
        fall = _span(10 ** (exponents - 0.5) - 1, "+.1%")
        turn = math.degrees(found[0].oscillation * math.log(10))
        yield (
            f"{places(alike)}: unlike bodies: K_N at the length {lengths} ({origin}), K_T at a "
            f"quarter and K_I at a twentieth of it; lambda = {_span(exponents, '.4f')}, epsilon = "
            f"{oscillation}: a length ten times as large changes K_N by {fall} and turns "
            f"(K_T, K_I) by {turn:.2g} degrees"
        )


def _origin(stations: Iterable[Station]) -> str:
    """Origin, in words, of reference lengths that are not chosen."""
    zones = (zone for each in stations for zone in each.slip_zones[-1:])
    if any(math.isfinite(zone.prediction) for zone in zones):
        return "the slip zone that they predict"
    return "a tenth of the half-width: no slip zone is predicted"


def _span(values: Array, form: str) -> str:
    """The smallest and the largest of the values that are known, as text; one if they are alike."""
    known = values[np.isfinite(values)]
    ends = (
        dict.fromkeys(format(each, form) for each in np.sort(known)[[0, -1]]) if len(known) else {}
    )
    return " to ".join(ends) or "unknown"


@dataclass(frozen=True)
class ContactExtent:
    """The largest of some quantities over all states of a contact.

    Attributes:
        sliding: tangential displacement between points of the two surfaces in contact.
        width: length over which the surfaces are in contact, of solids the root of the area; 0 if
            they never are.
        pressure: at a node.
    """

    sliding: float
    width: float
    pressure: float


def contact_extent(contact: ContactHistory) -> ContactExtent:
    """Largest sliding, width and pressure of a contact."""
    largest = np.zeros(3)
    for states in blocks(len(contact.status), contact.traction[0].size):
        closed = contact.status[states] != OPEN
        sliding = np.where(closed, np.linalg.norm(contact.slip[states], axis=2), 0.0)
        found = (
            sliding.max(),
            (closed @ contact.surface.weights).max() ** (1 / (contact.surface.points.shape[1] - 1)),
            contact.traction[states, :, 0].max(),
        )
        largest = np.maximum(largest, found)
    return ContactExtent(*map(float, largest))
