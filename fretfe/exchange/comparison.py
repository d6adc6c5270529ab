# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two results side by side: edge factors and slip zones, tractions along contacts, histories.

The two may have other meshes, steps, backends, loads or materials. Contacts and edges of the same
name belong together; nothing is converted or resampled in silence.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fretfe.edges.area import AreaSummary
from fretfe.edges.front import ContactSummary
from fretfe.errors import CaseError
from fretfe.exchange.compared import HistoryPair, QuantityPair, TractionPair
from fretfe.exchange.overlays import history_pairs, traction_pairs
from fretfe.exchange.quantities import quantity_pairs, zone_notes
from fretfe.results.model import Result

# Keys of the two cases that differ are listed up to this number.
MOST_KEYS = 12
# What a case says about itself only.
NOT_COMPARED = ("title", "output")

Summary = ContactSummary | AreaSummary


@dataclass(frozen=True)
class Comparison:
    """Two results side by side.

    Attributes:
        labels: the two, in words.
        results: the two.
        contacts: names of the contacts that belong together, in the first and the second result.
        quantities: numbers of edges and contacts with their bars.
        tractions: along contacts in the plane, at the two load extremes; empty where one result
            has no tractions.
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
    return Comparison(
        labels=_labels(first, second),
        results=(first, second),
        contacts=tuple((one.name, two.name) for one, two in pairs),
        quantities=tuple(quantity_pairs(first, second, pairs)),
        tractions=tractions,
        histories=tuple(history_pairs(first, second, pairs)),
        notes=tuple(
            [
                *_incomplete(first, second),
                *_case_differences(first, second),
                *notes,
                *zone_notes(first, second, pairs),
                *traction_notes,
            ]
        ),
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
    kinds = ["solids" if each.areas else "plane bodies" for each in (first, second)]
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
    mine: dict[str, Summary] = {each.name: each for each in first.summaries}
    other: dict[str, Summary] = {each.name: each for each in second.summaries}
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
    one, two = (_flat(each.case.model_dump(exclude_unset=True)) for each in (first, second))
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


def _flat(table: Any, key: str = "") -> dict[str, Any]:
    """Values by keys with dots; items of lists are numbered from 1, as with --set."""
    if isinstance(table, Mapping):
        items: Sequence[tuple[Any, Any]] = list(table.items())
    elif isinstance(table, list | tuple):
        items = list(enumerate(table, start=1))
    else:
        return {key: table}
    found: dict[str, Any] = {}
    for name, value in items:
        found |= _flat(value, f"{key}.{name}" if key else str(name))
    return found
