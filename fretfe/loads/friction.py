# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coefficients of friction that change, as a case has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, complaint
from fretfe.case.friction import InFile, OverArc, OverHeat, OverPressure, OverTime
from fretfe.case.messages import key_path
from fretfe.errors import CaseError
from fretfe.loads.csv_file import read_table
from fretfe.loads.over_surface import OVER, places_in, require_whole

# Column of the coefficients in a file.
COEFFICIENT = "friction"
# Columns over which they may be that are no places: attribute of `Coefficients`, and quantity.
UNPLACED = {
    "time": ("times", "time"),
    "pressure": ("pressure", "stress"),
    "temperature": ("temperature", ""),
}
# A surface or a history may reach this fraction of a table beyond its ends.
BEYOND = 1e-6


@dataclass(frozen=True)
class Coefficients:
    """Those of a contact of a case: one, or over one of times, pressures and so on.

    Attributes:
        key: file and key that have them, for messages.
        begins: time after which friction acts.
        values: (n,) coefficients.
        times: (n,) times at which they hold, with straight lines between them.
        pressure: (n,) contact pressures, from 0 on, likewise.
        temperature: (n,) mean temperatures of both surfaces, likewise.
        arc: (n,) arc lengths along the surface, likewise.
        points: (n, 2 or 3) places: a node has the coefficient of the nearest one.
    """

    key: str
    begins: float
    values: Array
    times: Array | None = None
    pressure: Array | None = None
    temperature: Array | None = None
    arc: Array | None = None
    points: Array | None = None

    @property
    def even(self) -> bool:
        """True if they are the same all over the surface."""
        others = self.arc, self.points, self.pressure, self.temperature
        return all(each is None for each in others)

    @property
    def by_place(self) -> bool:
        """True if they depend on the place alone."""
        return self.arc is not None or self.points is not None

    def over(self, times: Array) -> Array:
        """(T,) coefficients in the steps that end at some times (T,), if they are even.

        Of those over pressure the largest.
        """
        found = self.values.max() if self.pressure is not None else self.values[0]
        if self.times is not None:
            found = np.interp(times, self.times, self.values)
        return np.where(times > self.begins, found, 0.0)

    def require_times(self, end: float) -> None:
        """Check that those over time are given from when friction acts to the end of loading.

        Raises:
            CaseError: they are not.
        """
        if self.times is None:
            return
        first, last = self.times[[0, -1]]
        slack = BEYOND * end
        if first > self.begins + slack or last < end - slack:
            raise CaseError(
                f"{self.key}: expected coefficients from {self.begins:g}, from when friction acts, "
                f"to {end:g}, the end of the loading, found times from {first:g} to {last:g}"
            )


def read_coefficients(case: Case, name: str) -> Coefficients:
    """The coefficients of a contact.

    Raises:
        CaseError: a file cannot be read, or has other columns or numbers than expected.
    """
    contact, key = case.contacts[name], ("contacts", name, "friction")
    found: dict[str, Any]
    match contact.friction:
        case OverTime() as table:
            found = {"values": np.array(table.values), "times": np.array(table.times)}
        case OverArc() as table:
            found = {"values": np.array(table.values), "arc": np.array(table.arc)}
        case OverPressure() as table:
            found = {"values": np.array(table.values), "pressure": np.array(table.pressure)}
        case OverHeat() as table:
            temperature = np.array(table.temperature)
            found = {"values": np.array(table.values), "temperature": temperature}
        case InFile() as table:
            try:
                found = _in_file(case, table)
            except CaseError as error:
                raise CaseError(complaint(case.source, (*key, "csv"), str(error))) from None
        case number:
            found = {"values": np.array([number])}
    place = f"{case.source}: {key_path(key)}"
    if "arc" in found:
        require_whole(case, place)
    return Coefficients(place, contact.friction_from, **found)


def _in_file(case: Case, given: InFile) -> dict[str, Array]:
    """Coefficients, and what they are over."""
    path = case.resolve(given.csv)
    table = read_table(path, (COEFFICIENT,), (*UNPLACED, *OVER), given.separator)
    found = places_in(table, tuple(UNPLACED))
    units = {name: getattr(case.units, unit) for name, (_, unit) in UNPLACED.items() if unit}
    table.require_units({each: case.units.length for each in found} | units)
    values = table.columns[COEFFICIENT]
    if (wrong := np.flatnonzero(values < 0)).size:
        table.complain(int(wrong[0]), COEFFICIENT, "a coefficient >= 0")
    places = [table.columns[each] for each in found]
    if len(found) > 1:
        return {"values": values, "points": np.column_stack(places)}
    table.require_increasing(found[0], "value")
    if found == ("pressure",) and places[0][0] != 0:
        table.complain(0, "pressure", "pressures from 0 on")
    name, _ = UNPLACED.get(found[0], (found[0], ""))
    return {"values": values, name: places[0]}
