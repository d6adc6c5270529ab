# SPDX-License-Identifier: LGPL-3.0-or-later
"""Columns with units and values, as they are reported of contacts, stations and counted cycles.

Units and meanings are those of the fields of `Contact` and `Station`; a column that is something
else than a field has its own. A new number of a station is a field there, and nothing here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from fretfe.case import Units
from fretfe.evaluate.contacts import (
    Contact,
    CountedCycles,
    LocalProblem,
    SlipZone,
    Station,
    StationHistory,
    histories,
    quantities,
)
from fretfe.evaluate.verdicts import longest_verdict
from fretfe.evaluate.withheld import withheld

AXES = "xyz"
# Kinds of quantities and their units, plane bodies per unit thickness. Solids differ in some.
UNITS = {
    "": "",
    "length": "{length}",
    "time": "{time}",
    "stress": "{stress}",
    "force": "{force}/{length}",
    "moment": "{force}",
    "work": "{force}·{length}/{length}",
    "work per length": "{force}·{length}/{length}",
    "density": "{force}·{length}/{length}²",
    "stress slip": "{stress}²·{length}",
    "area": "{length}",
    "curvature": "1/{length}",
    "angle": "deg",
    "k_n": "{stress}/√{length}",
    "k_t": "{stress}·√{length}",
}
SOLID_UNITS = UNITS | {
    "force": "{force}",
    "moment": "{force}·{length}",
    "work": "{force}·{length}",
    "area": "{length}²",
}


def unit(kind: str, units: Units, *, solid: bool, ascii_only: bool = False) -> str:
    """Unit of a kind of quantity; in ASCII as in the header of a file: ``MPa/mm^0.5``."""
    template = (SOLID_UNITS if solid else UNITS)[kind]
    if ascii_only:
        root = template.replace("√{length}", "{length}^0.5")
        template = root.replace("·", "*").replace("²", "^2")
    return template.format(**units.model_dump())


def axis_label(name: str, units: Units, *, solid: bool) -> str:
    """Symbol and unit of a number of a station or a contact: ``K_N [MPa/√mm]``."""
    declared = {**quantities(Contact), **NUMBERS}[name]
    return f"{declared.symbol} [{unit(declared.kind, units, solid=solid)}]"


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: without its unit.
        kind: of quantity, a key of `UNITS`.
        meaning: in words.
        value: in the row of a station, from its contact and it; of a contact, from it and None; of
            the counted cycles of a station, from the times and it; None in tables of other things.
        field: of a station that it shows; empty if it is something else.
    """

    name: str
    kind: str
    meaning: str
    value: Callable[[Any, Any], Any] | None = None
    field: str = ""

    def components(self, axes: str) -> list[Column]:
        """The columns of a vector along axes."""
        return [self._component(place, axis) for place, axis in enumerate(axes)]

    def _component(self, place: int, axis: str) -> Column:
        meaning, value = f"component {axis} of: {self.meaning}", self.value
        name = f"{self.name}_{axis}".removeprefix("_")
        if value is None:
            return Column(name, self.kind, meaning)
        return replace(
            self, name=name, meaning=meaning, value=lambda *row: float(value(*row)[place])
        )


def _fields(owner: type, names: Iterable[str]) -> list[Column]:
    """Fields of a contact or a station, with their units and meanings."""
    known = quantities(owner)
    return [Column(name, known[name].kind, known[name].meaning) for name in names]


CONTACTS = _fields(Contact, histories(Contact))
FACTORS = _fields(Station, histories(StationHistory))
HISTORIES = histories(StationHistory)
NUMBERS = quantities(Station)


def _number(name: str, meaning: str = "", read: str = "") -> Column:
    """A number of a station.

    Args:
        name: of the column.
        meaning: in words; empty for that of the field.
        read: attribute to read, of a history in the state that decides; empty for the field of this
            name.
    """
    attribute, field = read or name, NUMBERS[name if name in NUMBERS else read]

    def value(_: Contact, station: Station) -> Any:
        found = getattr(station, attribute)
        found = found[station.decisive] if attribute in HISTORIES else found
        return float(found) if isinstance(found, float) else found

    return Column(name, field.kind, meaning or field.meaning, value, attribute)


def _part(attribute: str, owner: type, name: str, prefix: str = "") -> Column:
    """A field of a part of a station, which is of the class `owner`."""
    read = attrgetter(f"{attribute}.{name}")
    return replace(
        _fields(owner, [name])[0], name=prefix + name, value=lambda _, station: read(station)
    )


def _last(name: str, read: str = "") -> Column:
    """A number of a contact by the attribute to read, of a history in the last state."""

    def value(contact: Contact, _: None) -> Any:
        found = getattr(contact, read or name)
        found = found[-1] if isinstance(found, np.ndarray) else found
        return float(found) if np.ndim(found) == 0 and isinstance(found, np.floating) else found

    return replace(_fields(Contact, [name])[0], value=value)


def _of_half_cycle(station: Station, number: int) -> SlipZone | None:
    """The first or second of the last two slip zones of a station, if it has it."""
    zones: list[SlipZone | None] = [None, None, *station.slip_zones]
    return zones[number - 3]


@dataclass(frozen=True)
class ZoneLength:
    """A length of the slip zones of a station, with a column for each half cycle.

    Attributes:
        stem, end: of the name, with the number of the half cycle between them: slip_1_spread.
        meaning: in words, with places for "longest ", for the half cycle, and for the name before
            `end`.
        read: the length.
        by: the one by which the longest zone is found; None for itself.
    """

    stem: str
    end: str
    meaning: str
    read: Callable[[Station, SlipZone], float]
    by: ZoneLength | None = None

    def of_half_cycle(self, number: int) -> Column:
        """Of the first or second of the last two zones; NaN without it."""

        def value(_: Contact, station: Station) -> float:
            zone = _of_half_cycle(station, number)
            return float(self.read(station, zone)) if zone else math.nan

        which = "last but one" if number == 1 else "last"
        return self._column(f"{self.stem}_{number}", "", f"of the {which} half cycle", value)

    def of_longest(self) -> Column:
        """Of the zone of the cycle of which the length is largest; NaN without any."""
        by = self.by or self

        def value(_: Contact, station: Station) -> float:
            zone = station.longest_by(partial(by.read, station))
            return float(self.read(station, zone)) if zone else math.nan

        return self._column(self.stem, "longest ", "of the cycle", value)

    def _column(self, stem: str, longest: str, of: str, value: Callable[..., float]) -> Column:
        return Column(stem + self.end, "length", self.meaning.format(longest, of, stem), value)


SLIP = ZoneLength("slip", "", "{}slip zone {}", lambda _, zone: zone.reported_length)
SLIP_SPREAD = ZoneLength("slip", "_spread", "error bar of {2}", lambda _, zone: zone.spread, SLIP)
SLIP_FROM = ZoneLength(
    "slip",
    "_from",
    "position of the edge from which {2} counts",
    lambda station, zone: station.position[zone.end],
    SLIP,
)
PREDICTED = ZoneLength(
    "predicted",
    "",
    "{}slip zone {} by the factors; empty without them or without a formula",
    Station.told_prediction,
)
LOCAL = ZoneLength(
    "local", "", "{}slip zone {} by the plane problem", lambda _, zone: zone.reported_local
)
LOCAL_SPREAD = ZoneLength(
    "local", "_spread", "error bar of {2}", lambda _, zone: zone.local_spread, LOCAL
)
CONTACT = Column(
    "contact", "", "name of the contact, or of one of its patches", lambda contact, _: contact.name
)
STEADY = Column("steady", "", "whether the cycle is steady", lambda c, _: bool(c.steady))
WARNINGS = Column(
    "warnings",
    "",
    "what a reader must know",
    lambda contact, _: "; ".join(each.sentence for each in contact.warnings),
)
EDGE = Column("edge", "", "left or right", lambda _, station: station.front)
STATION = (
    CONTACT,
    replace(EDGE, name="front", meaning="name of the front, in the plane left or right"),
    _number("station", "number of the station along the front, from 0; 0 in the plane", "number"),
)
EDGES = (
    CONTACT,
    EDGE,
    _number("position", "of the edge in the state that decides"),
    Column(
        "half_width",
        "length",
        "of the contact in the state that decides",
        lambda contact, station: float(contact.half_width[station.decisive]),
    ),
    _number(
        "k_n",
        "K_N in the state that decides; empty if its bar is more than half of it",
        "reported_k_n",
    ),
    _number("k_n_spread", "error bar of K_N"),
    _number(
        "k_t_range",
        "range of K_T, with displacements along z of (K_T, K_S), over the cycle, where P moves the "
        "edge the equivalent one; empty likewise",
        "reported_range",
    ),
    Column("k_t_range_spread", "k_t", "its error bar", lambda _, s: s.told_range[1]),
    *map(_number, ("k_i_range", "reference_length")),
    *(
        each.of_half_cycle(number)
        for each in (SLIP, SLIP_SPREAD, SLIP_FROM, PREDICTED)
        for number in (1, 2)
    ),
    Column("gross", "", "whether the whole contact slipped in one of them", lambda _, s: s.slides),
    Column(
        "resolved",
        "",
        "whether the mesh resolves both",
        lambda _, s: all(z.resolved for z in s.slip_zones[-2:]),
    ),
    _number("dissipation", read="reported_dissipation"),
    _number("dissipation_spread"),
    STEADY,
    WARNINGS,
)
STATION_LENGTHS = (SLIP, SLIP_SPREAD, PREDICTED, LOCAL, LOCAL_SPREAD)
CHOSEN = (
    *STATION,
    _number("arc"),
    *Column(
        "", "length", NUMBERS["point"].meaning, lambda _, station: station.point, "point"
    ).components(AXES),
    *Column(
        "inward", "", "direction into the contact", lambda _, station: station.frame.inward
    ).components(AXES),
    _number(
        "position", "along the arc in the state that decides; of solids from the point, inward"
    ),
    *map(_number, ("position_spread", "curvature", "to_end", "end")),
    _number("element_size", read="size"),
    _number("k_n", "K_N in the state that decides"),
    *map(_number, ("k_n_spread", "k_n_moved", "k_n_moved_spread", "k_n_moved_reason")),
    *(
        _number(name, f"{NUMBERS[name].symbol} in the state that decides")
        for name in ("k_t", "k_s", "k_i")
    ),
    *map(_number, ("k_t_range", "k_s_range", "k_i_range", "reference_length")),
    *map(_number, ("k_range", "k_range_spread", "k_angle", "turning")),
    *(each.of_longest() for each in STATION_LENGTHS),
    *(each.of_half_cycle(number) for number in (1, 2) for each in STATION_LENGTHS),
    _number("stick_border"),
    *(
        _part("local", LocalProblem, name, "local_")
        for name in ("slip", "work", "change", "reason")
    ),
    Column(
        "verdict", "", "comparison with what is predicted", lambda _, s: longest_verdict(s).verdict
    ),
    Column("reason", "", "why there is no verdict", lambda _, s: longest_verdict(s).reason),
    Column("withheld", "", "why a number is not told", lambda _, each: withheld(each).text),
)
# All that a station has: a new number of it is a column without further ado.
STATIONS = (
    *CHOSEN,
    *map(_number, (name for name in NUMBERS if name not in {each.field for each in CHOSEN})),
)
SOLIDS = (
    CONTACT,
    _last("normal_force"),
    *_last("shear_force").components(AXES),
    *map(_last, ("contact_area", "stick_area", "largest_pressure")),
    _last("dissipation", "reported_dissipation"),
    *map(_last, ("dissipation_spread", "local_dissipation", "local_share", "steady")),
    WARNINGS,
)
_of_cycles = partial(_part, "cycles", CountedCycles)
CYCLES = (
    *map(_of_cycles, ("start", "end")),
    Column("start_time", "time", "its time", lambda times, s: times[s.cycles.start]),
    Column("end_time", "time", "its time", lambda times, s: times[s.cycles.end]),
    _of_cycles("count"),
    Column(
        "k_t_start",
        "k_t",
        "K_T at the first reversal; with K_S along k_angle",
        lambda _, s: s.reversals[0],
    ),
    Column("k_t_end", "k_t", "K_T at the second reversal", lambda _, s: s.reversals[1]),
    *map(_of_cycles, ("k_t_range", "k_t_mean", "slip")),
    Column(
        "worst",
        "",
        "whether it is the worst cycle of its edge",
        lambda _, s: np.arange(len(s.cycles.count)) == s.cycles.worst,
    ),
)


@dataclass(frozen=True)
class Reported:
    """A number of a station with its error bar, which depends on that for being reported.

    Attributes:
        symbol: in tables and figures.
        kind: of quantity, a key of `UNITS`.
        read: number and bar; NaN for a number whose bar is unknown or more than half of it.
    """

    symbol: str
    kind: str
    read: Callable[[Station], tuple[float, float]]

    def value(self, station: Station) -> float:
        """The number alone."""
        return self.read(station)[0]

    def spread(self, station: Station) -> float:
        """The bar alone."""
        return self.read(station)[1]


def _last_zone(number: int) -> Reported:
    """Length of the first or second of the last two slip zones; NaN without, or if all slips."""

    def read(station: Station) -> tuple[float, float]:
        zone = _of_half_cycle(station, number)
        return zone.told if zone and not zone.gross else (math.nan, math.nan)

    return Reported(f"d_{number}", "length", read)


K_N = Reported("K_N", "k_n", lambda each: (each.reported_k_n, each.decisive_k_n[1]))
K_RANGE = Reported("ΔK", "k_t", lambda each: each.told_range)
ZONES = (_last_zone(1), _last_zone(2))
WORK = Reported(
    "friction work", "work", lambda each: (each.reported_dissipation, each.dissipation_spread)
)
