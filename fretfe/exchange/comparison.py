# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two results side by side: edge factors and slip zones, tractions, histories."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from fretfe.case.overrides import by_key
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import Contact, SlipZone, Station, quantities
from fretfe.evaluate.refinement import StationValues, front_means
from fretfe.exchange.overlays import HistoryPair, TractionPair, history_pairs, traction_pairs
from fretfe.results.model import Result
from fretfe.results.tables import unit

# Slip zones are those of the last two half cycles, in the order of time.
K_N, K_T, ZONES = "K_N", "ΔK_T", ("d_1", "d_2")
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
Pairs = Sequence[tuple[Any, Any]]
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
    def agrees(self) -> bool | None:
        """True if the difference is within its error bar; None if that cannot be told."""
        if not (math.isfinite(self.difference) and math.isfinite(self.difference_spread)):
            return None
        return abs(self.difference) <= self.difference_spread

    def record(self) -> dict[str, Any]:
        """Everything by name."""
        return {
            **vars(self),
            "difference": self.difference,
            "difference_spread": self.difference_spread,
            "agrees": self.agrees,
        }


class Number(NamedTuple):
    """A number of one result: what it is, its kind of quantity, its value, its error bar."""

    quantity: str
    kind: str
    value: float
    spread: float = math.nan


def quantity_pairs(first: Result, second: Result, pairs: Pairs) -> Iterator[QuantityPair]:
    """Numbers of all contacts that belong together."""
    means = [_means(each) for each in (first, second)]
    for one, two in pairs:
        groups = [("", _contact(one), _contact(two))]
        if one.solid:
            fronts, others = means[0].get(one.name, {}), means[1].get(two.name, {})
            both = [name for name in fronts if name in others]
            groups += [(name, _front(fronts[name]), _front(others[name])) for name in both]
        else:
            edges = zip(one.stations, two.stations, strict=True)
            groups += [(edge.front, _edge(edge), _edge(partner)) for edge, partner in edges]
        for front, numbers, partners in groups:
            for mine, other in zip(numbers, partners, strict=True):
                if math.isfinite(mine.value) or math.isfinite(other.value):
                    label = unit(mine.kind, first.case.units, solid=one.solid)
                    yield QuantityPair(
                        one.name, front, mine.quantity, label,
                        mine.value, other.value, mine.spread, other.spread,
                    )  # fmt: skip


def _contact(contact: Contact) -> list[Number]:
    if not contact.solid:
        last = contact.stations[0].last
        return [Number("half-width", "length", float(contact.half_width[last]))]
    return [
        *(
            Number(quantity, CONTACT_NUMBERS[name].kind, float(getattr(contact, name)[-1]))
            for quantity, name in SOLID_NUMBERS.items()
        ),
        Number("friction work", "work", contact.dissipation),
    ]


def _edge(edge: Station) -> list[Number]:
    zones: list[SlipZone | None] = [None, None, *edge.slip_zones][-2:]
    return [
        Number(K_N, "k_n", edge.reported_k_n, edge.last_k_n[1]),
        Number(K_T, "k_t", edge.reported_range, edge.k_range_spread),
        *(
            Number(name, "length", zone.reported_length, zone.spread)
            if zone
            else Number(name, "length", math.nan)
            for name, zone in zip(ZONES, zones, strict=True)
        ),
        Number("friction work", "work", edge.dissipation),
    ]


def _means(result: Result) -> dict[str, dict[str, StationValues]]:
    """Means along the fronts of solids, by contact and front."""
    found: dict[str, dict[str, StationValues]] = {}
    if result.solid and result.solution is not None:
        for each in front_means(result.contacts, result.solution):
            found.setdefault(each.contact, {})[each.front] = each
    return found


def _front(values: StationValues) -> list[Number]:
    slip = values.slip or (math.nan, math.nan)
    return [
        Number(f"mean {K_N}", "k_n", values.k_n),
        Number("mean ΔK", "k_t", values.k_t),
        *(Number(f"mean {name}", "length", d) for name, d in zip(ZONES, slip, strict=True)),
    ]


def zone_notes(first: Result, second: Result, pairs: Pairs) -> Iterator[str]:
    """Edges whose last slip zones are those of half cycles that end at other times."""
    clock = max(float(each.loads.times[-1]) for each in (first, second))
    for one, two in pairs:
        if one.solid:
            continue
        for edge, partner in zip(one.stations, two.stations, strict=True):
            if not (edge.slip_zones and partner.slip_zones):
                continue
            ends = [
                float(result.loads.times[each.slip_zones[-1].end])
                for result, each in ((first, edge), (second, partner))
            ]
            if abs(ends[1] - ends[0]) > SAME_TIME * clock:
                yield (
                    f"{one.name} {edge.front}: the last slip zones end at t = {ends[0]:g} and "
                    f"t = {ends[1]:g}"
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
        contacts=tuple((one.name, two.name) for one, two in pairs),
        quantities=tuple(quantity_pairs(first, second, pairs)),
        tractions=tractions,
        histories=histories,
        notes=tuple(
            [
                *_incomplete(first, second),
                *_case_differences(first, second),
                *notes,
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
            f"{kinds[1]}: fretfe station compares a station of solids with a plane problem"
        )
    units = [each.case.units for each in (first, second)]
    if units[0] != units[1]:
        texts = [", ".join(each.model_dump().values()) for each in units]
        raise CaseError(
            f"expected two results in the same units, found {texts[0]} and {texts[1]}: numbers "
            "are never converted"
        )


def _partners(first: Result, second: Result) -> tuple[list[tuple[Any, Any]], list[str]]:
    """Contacts of the same name, and notes of those without a partner.

    Raises:
        CaseError: if there are none.
    """
    mine: dict[str, Contact] = {each.name: each for each in first.contacts}
    other: dict[str, Contact] = {each.name: each for each in second.contacts}
    both = [name for name in mine if name in other]
    if both:
        alone = [
            f"contact {name} is in the {which} result only"
            for which, names, others in (("first", mine, other), ("second", other, mine))
            for name in names
            if name not in others
        ]
        return [(mine[name], other[name]) for name in both], alone
    if len(mine) == len(other) == 1:
        (one,), (two,) = mine.values(), other.values()
        text = f"contact {one.name} is compared with {two.name}: each result has one contact only"
        return [(one, two)], [text]
    raise CaseError(
        f"expected contacts of the same name in both results, found {', '.join(mine) or 'none'} "
        f"and {', '.join(other) or 'none'}"
    )


def _incomplete(first: Result, second: Result) -> Iterator[str]:
    for which, result in (("first", first), ("second", second)):
        if result.failure is not None:
            yield f"the {which} run is not complete: {result.failure}"


def _case_differences(first: Result, second: Result) -> list[str]:
    """Keys whose values differ between the two cases, and the backends."""
    notes = []
    if first.backend != second.backend:
        notes.append(f"solved by {first.backend} and by {second.backend}")
    one, two = (by_key(each.case.model_dump(exclude_unset=True)) for each in (first, second))
    keys = [key for key in {**one, **two} if key.split(".")[0] not in NOT_COMPARED]
    texts = [
        f"{key}: {_told(one, key)} and {_told(two, key)}"
        for key in keys
        if one.get(key) != two.get(key)
    ]
    left_out = len(texts) - MOST_KEYS
    more = [f"{left_out} more keys of the cases differ"] if left_out > 0 else []
    return [*notes, *texts[:MOST_KEYS], *more]


def _told(values: Mapping[str, Any], key: str) -> str:
    return f"{values[key]}" if key in values else "not set"
