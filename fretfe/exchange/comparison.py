# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two results side by side: edge factors and slip zones, tractions, histories."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from fretfe._typing import Array
from fretfe.case.overrides import by_key
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import Contact, Front, Station, quantities
from fretfe.evaluate.partners import contact_partners
from fretfe.evaluate.refinement import at_places, numbers
from fretfe.exchange.overlays import (
    ContactPair,
    HistoryPair,
    TractionPair,
    history_pairs,
    traction_pairs,
)
from fretfe.results.model import Result
from fretfe.results.quantities import K_N, K_RANGE, WORK, ZONES, unit
from fretfe.verdict import Verdict

# Of edges; slip zones are those of the last two half cycles, in the order of time.
EDGE_NUMBERS = (K_N, replace(K_RANGE, symbol="ΔK_T"), *ZONES, WORK)
# Of fronts of solids.
FRONT_NUMBERS = tuple(
    replace(each, symbol=f"mean {each.symbol}") for each in (K_N, K_RANGE, *ZONES)
)
# Of contacts of solids in the last state.
SOLID_NUMBERS = {
    "P": "normal_force",
    "contact area": "contact_area",
    "stick area": "stick_area",
    "largest p": "largest_pressure",
}
CONTACT_NUMBERS = quantities(Contact)
# Times that differ by less than this fraction of the clock are the same.
SAME_TIME = 1e-6
# Share of the stations of a front that must have a number in both for its means.
KNOWN = 0.5
# Keys of the two cases that differ are listed up to this number.
MOST_KEYS = 12
# What a case says about itself only.
NOT_COMPARED = ("title", "output")


@dataclass(frozen=True)
class QuantityPair:
    """A number in both results.

    Attributes:
        contact: its name in the first result.
        edge: left or right; of solids a front, empty for a number of the whole contact.
        quantity: what it is.
        unit: of it.
        first, second: the two; NaN where unknown.
        first_spread, second_spread: error bars, half the width of a 95 % interval; NaN where
            unknown.
    """

    contact: str
    edge: str
    quantity: str
    unit: str
    first: float
    second: float
    first_spread: float = math.nan
    second_spread: float = math.nan

    @property
    def difference(self) -> float:
        """Of the second from the first one, relative to that; NaN if one is unknown or zero."""
        return self.second / self.first - 1 if self.first else math.nan

    @property
    def difference_spread(self) -> float:
        """Error bar of it by those of the two, as if they were independent."""
        if not self.first:
            return math.nan
        relative = self.second * self.first_spread / self.first
        return math.hypot(relative, self.second_spread) / abs(self.first)

    @property
    def verdict(self) -> Verdict:
        """Verdict on the difference by its error bar."""
        if not (math.isfinite(self.difference) and math.isfinite(self.difference_spread)):
            return Verdict.UNKNOWN
        agrees = abs(self.difference) <= self.difference_spread
        return Verdict.AGREES if agrees else Verdict.DIFFERS

    def record(self) -> dict[str, Any]:
        """Everything by name."""
        return {
            **vars(self),
            "difference": self.difference,
            "difference_spread": self.difference_spread,
            "verdict": self.verdict,
        }


class Number(NamedTuple):
    """A number of one result: what it is, its kind of quantity, its value, its error bar."""

    quantity: str
    kind: str
    value: float
    spread: float = math.nan


def quantity_pairs(first: Result, pairs: Sequence[ContactPair]) -> Iterator[QuantityPair]:
    """Numbers of all contacts that belong together."""
    for pair in pairs:
        one, two = pair.first, pair.second
        groups = [("", _contact(one), _contact(two))]
        if one.solid:
            groups += [(front.name, *_front(front, other)) for front, other in pair.fronts]
        else:
            edges = zip(one.stations, two.stations, strict=True)
            groups += [(edge.front, _edge(edge), _edge(partner)) for edge, partner in edges]
        for front, found, partners in groups:
            for mine, other in zip(found, partners, strict=True):
                if math.isfinite(mine.value) or math.isfinite(other.value):
                    label = unit(mine.kind, first.case.units, solid=one.solid)
                    yield QuantityPair(
                        one.name, front, mine.quantity, label,
                        mine.value, other.value, mine.spread, other.spread,
                    )  # fmt: skip


def _contact(contact: Contact) -> list[Number]:
    if not contact.solid:
        state = contact.stations[0].decisive
        return [Number("half-width", "length", float(contact.half_width[state]))]
    return [
        *(
            Number(quantity, CONTACT_NUMBERS[name].kind, float(getattr(contact, name)[-1]))
            for quantity, name in SOLID_NUMBERS.items()
        ),
        Number("friction work", "work", contact.reported_dissipation, contact.dissipation_spread),
    ]


def _edge(edge: Station) -> list[Number]:
    return [Number(each.symbol, each.kind, *each.read(edge)) for each in EDGE_NUMBERS]


def _front(front: Front, partner: Front) -> tuple[list[Number], list[Number]]:
    """Means along two fronts of solids, over the stations at whose places both have a number."""
    points = np.array([each.point for each in front.judged]).reshape(-1, 3)
    both: tuple[list[Number], list[Number]] = ([], [])
    for each in FRONT_NUMBERS:
        (others,) = at_places(partner, points, [each.value])
        means = _means(numbers(front.judged, each.value), others)
        for found, mean in zip(both, means, strict=True):
            found.append(Number(each.symbol, each.kind, mean))
    return both


def _means(values: Array, others: Array) -> tuple[float, float]:
    """Means of both where both are known; if that is less than half, of the first one alone."""
    mine, both = np.isfinite(values), np.isfinite(values + others)
    if both.any() and both.mean() >= KNOWN:
        return float(values[both].mean()), float(others[both].mean())
    alone = mine.any() and mine.mean() >= KNOWN
    return float(values[mine].mean()) if alone else math.nan, math.nan


def zone_notes(first: Result, second: Result, pairs: Sequence[ContactPair]) -> Iterator[str]:
    """Edges whose last slip zones are those of half cycles that end at other times."""
    clock = max(float(each.loads.times[-1]) for each in (first, second))
    for pair in pairs:
        for edge, partner in pair.stations:
            if not (edge.slip_zones and partner.slip_zones):
                continue
            ends = [
                float(result.loads.times[each.slip_zones[-1].end])
                for result, each in ((first, edge), (second, partner))
            ]
            if abs(ends[1] - ends[0]) > SAME_TIME * clock:
                yield (
                    f"{pair.first.name} {edge.front}: the last slip zones end at t = {ends[0]:g} "
                    f"and t = {ends[1]:g}"
                )


@dataclass(frozen=True)
class Comparison:
    """Two results side by side.

    Attributes:
        labels: the two, in words.
        results: the two.
        contacts: names of the contacts that belong together, in the first and the second result.
        quantities: numbers of edges and contacts with their bars.
        tractions: along contacts, at the two load extremes; empty where one result has no
            tractions.
        histories: of contacts and edges over time.
        notes: what differs between the cases, what has no partner, what is not compared and why.
    """

    labels: tuple[str, str]
    results: tuple[Result, Result]
    contacts: tuple[tuple[str, str], ...]
    quantities: tuple[QuantityPair, ...]
    tractions: tuple[TractionPair, ...]
    histories: tuple[HistoryPair, ...]
    notes: tuple[str, ...]

    def records(self) -> list[dict[str, Any]]:
        """One flat record for each compared quantity, ready for a table."""
        return [pair.record() for pair in self.quantities]


def compare(first: Result, second: Result) -> Comparison:
    """Compare two results of plane bodies, or two of solids.

    Differences are those of the second result from the first one.

    Raises:
        CaseError: if one is of plane bodies and the other of solids, their units differ, or no
            contact of one has a partner in the other.
    """
    _require_comparable(first, second)
    pairs, notes = _partners(first, second)
    tractions, traction_notes = traction_pairs(first, second, pairs)
    histories = tuple(history_pairs(first, second, pairs))
    return Comparison(
        labels=_labels(first, second),
        results=(first, second),
        contacts=tuple((each.first.name, each.second.name) for each in pairs),
        quantities=tuple(quantity_pairs(first, pairs)),
        tractions=tractions,
        histories=histories,
        notes=tuple(
            [
                *_incomplete(first, second),
                *_case_differences(first, second),
                *notes,
                *(text for each in pairs for text in _front_notes(each)),
                *zone_notes(first, second, pairs),
                *traction_notes,
                *_counted_notes(histories),
            ]
        ),
    )


def _counted_notes(histories: Sequence[HistoryPair]) -> Iterator[str]:
    for each in histories:
        if each.counted_from is not None:
            yield (
                f"{each.contact} {each.edge}: {each.quantity} over time is compared from "
                f"t = {each.counted_from:g} on, since when both know it"
            )


def _labels(first: Result, second: Result) -> tuple[str, str]:
    """Names of the two folders, or their paths if the names are the same."""
    folders = [each.directory for each in (first, second)]
    names = [folder.name if folder else "" for folder in folders]
    if all(names) and names[0] != names[1]:
        return names[0], names[1]
    if all(folders) and folders[0] != folders[1]:
        return str(folders[0]), str(folders[1])
    return "first", "second"


def _require_comparable(first: Result, second: Result) -> None:
    kinds = ["solids" if each.solid else "plane bodies" for each in (first, second)]
    if kinds[0] != kinds[1]:
        raise CaseError(
            f"expected two results of plane bodies or two of solids, found {kinds[0]} and "
            f"{kinds[1]}: fretfe report --station draws a station of solids with its plane problem"
        )
    units = [each.case.units for each in (first, second)]
    if units[0] != units[1]:
        texts = [", ".join(each.model_dump().values()) for each in units]
        raise CaseError(
            f"expected two results in the same units, found {texts[0]} and {texts[1]}: numbers "
            "are never converted"
        )


def _partners(first: Result, second: Result) -> tuple[list[ContactPair], list[str]]:
    """Contacts that belong together, and notes of those without a partner or of another name.

    Raises:
        CaseError: if there are none.
    """
    mine, theirs = first.contacts, second.contacts
    if len(mine) == len(theirs) == 1 and mine[0].pair != theirs[0].pair:
        text = f"contact {mine[0].name} is compared with {theirs[0].name}: each result has one "
        return [ContactPair(mine[0], theirs[0])], [text + "contact only"]
    found = contact_partners(mine, theirs)
    pairs = [ContactPair(one, two) for one, two in zip(mine, found, strict=True) if two is not None]
    if not pairs:
        names = (", ".join(each.name for each in contacts) or "none" for contacts in (mine, theirs))
        raise CaseError(
            "expected contacts of the same surface pair in the same place in both results, found "
            + " and ".join(names)
        )
    return pairs, [*_renamed(pairs), *_contacts_alone(first, second, pairs)]


def _renamed(pairs: Sequence[ContactPair]) -> Iterator[str]:
    for one, two in ((each.first.name, each.second.name) for each in pairs):
        if one != two:
            yield f"contact {one} is compared with {two}, which is in its place"


def _contacts_alone(first: Result, second: Result, pairs: Sequence[ContactPair]) -> Iterator[str]:
    paired = {id(each) for pair in pairs for each in (pair.first, pair.second)}
    for which, result in (("first", first), ("second", second)):
        for each in result.contacts:
            if id(each) not in paired:
                yield f"contact {each.name} is in the {which} result only"


def _front_notes(pair: ContactPair) -> Iterator[str]:
    """Fronts of solids of other names, and those without a partner."""
    if not pair.first.solid:
        return
    for front, partner in pair.fronts:
        if front.name != partner.name:
            yield (
                f"{pair.first.name} {front.name} is compared with {partner.name} of the second "
                "result, which is in its place"
            )
    paired = {id(each) for both in pair.fronts for each in both}
    for which, contact in (("first", pair.first), ("second", pair.second)):
        for front in contact.fronts:
            if id(front) not in paired:
                why = "no front of the other one is in its place"
                why = "nothing is known of it" if front.lost else why
                yield f"{contact.name} {front.name} of the {which} result has no partner: {why}"


def _incomplete(first: Result, second: Result) -> Iterator[str]:
    for which, result in (("first", first), ("second", second)):
        if result.failure is not None:
            yield f"the {which} run is not complete: {result.failure}"


def _case_differences(first: Result, second: Result) -> list[str]:
    """Keys whose values differ between the two cases, and the backends."""
    notes = []
    if first.backend != second.backend:
        notes.append(f"solved by {first.backend} and by {second.backend}")
    one, two = (
        by_key(each.case.model_dump(exclude_unset=True, by_alias=True)) for each in (first, second)
    )
    keys = [key for key in {**one, **two} if key.split(".")[0] not in NOT_COMPARED]
    texts = [
        f"{key}: {_value(one, key)} and {_value(two, key)}"
        for key in keys
        if one.get(key) != two.get(key)
    ]
    left_out = len(texts) - MOST_KEYS
    more = [f"{left_out} more keys of the cases differ"] if left_out > 0 else []
    return [*notes, *texts[:MOST_KEYS], *more]


def _value(values: Mapping[str, Any], key: str) -> str:
    return f"{values[key]}" if key in values else "not set"
