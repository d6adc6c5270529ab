# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that loads name: values at points, and a look at all files before there is a mesh."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case, complaint
from fretfe.case.base import ABSOLUTE_ZERO, AXES
from fretfe.case.loads import (
    EigenstrainLoad,
    LoadAtPoints,
    OtherRun,
    ShapeLoad,
    TemperatureLoad,
    TractionLoad,
)
from fretfe.errors import CaseError, DependencyError
from fretfe.loads import History, build_history
from fretfe.loads.csv_file import read_table, require_units
from fretfe.plugins import LOAD_FUNCTIONS, PlugIn, plug_in, plug_ins, what

# What reads files is imported where it is needed: most cases have none, and SciPy and HDF5 take a
# while.
if TYPE_CHECKING:
    from fretfe.bodies.point_values import PointValues
    from fretfe.fields.field import Field, Names, Quantity

# Endings of tables of a field, which have no other check that is quick.
TABLES = (".csv", ".txt")

PointLoad = LoadAtPoints | EigenstrainLoad


def values_at_points(case: Case, name: str, load: PointLoad, dimension: int) -> PointValues:
    """Values that a load has at points, or in columns of its file.

    Args:
        case: of the load.
        name: of the load.
        load: a load with points or a file.
        dimension: number of coordinates, 2 or 3.

    Raises:
        CaseError: file, line and column of what is not as expected.
    """
    from fretfe.bodies.point_values import PointValues, read_points

    if load.file is None:
        assert isinstance(load, LoadAtPoints)
        assert load.points is not None and load.values is not None
        return PointValues(np.array(load.points), np.array(load.values))
    least = ABSOLUTE_ZERO if isinstance(load, TemperatureLoad) else -np.inf
    try:
        columns, units = load.columns[dimension], _units(case, load)
        return read_points(case.resolve(load.file), dimension, columns, units, least)
    except CaseError as error:
        raise CaseError(complaint(case.source, ("loads", name, "file"), str(error))) from None


def factors_by(case: Case, name: str, function: str, places: Array) -> Array:
    """(m,) factors of a traction at places (m, d), by a function of another package.

    Raises:
        CaseError: there is none of that name.
        DependencyError: it cannot be used, or gives something else.
    """
    plugged = _function(case, name, function)
    values = plugged.call(places.copy())
    if not (isinstance(values, np.ndarray) and values.shape == (len(places),)
            and values.dtype.kind in "fiu" and np.isfinite(values).all()):  # fmt: skip
        expected = f"expected an array of the shape ({len(places)},) of finite numbers"
        raise DependencyError(f"{plugged.title}: {expected}, found {what(values)}")
    return values.astype(float)


def _function(case: Case, name: str, function: str) -> PlugIn:
    plugged = plug_in(LOAD_FUNCTIONS, function)
    if plugged is None:
        names = ", ".join(each.name for each in plug_ins(LOAD_FUNCTIONS)) or "none"
        text = f"expected a plug-in of the group {LOAD_FUNCTIONS} ({names}), found {function!r}"
        raise CaseError(complaint(case.source, ("loads", name, "function"), text))
    return plugged


def checked_history(case: Case) -> History:
    """The load history of a case, after a look at the files of its loads.

    Nothing has been meshed then: what is wrong with a file is told before any work. Of tables all
    numbers are read that are sure to be needed; of other files it is told whether they are there.

    Raises:
        CaseError: file and key, and line and column of a table, of what is not as expected.
    """
    for name, load in case.loads.items():
        if isinstance(load, TractionLoad) and load.function is not None:
            _function(case, name, load.function)
        try:
            if isinstance(load, OtherRun):
                _require_field(case, load)
            elif isinstance(load, PointLoad) and load.file is not None:
                # Whether the bodies of a mesh file are solid is not known yet.
                dimension = 2 if case.geometry.solid is None else 3
                names = (*AXES[:dimension], *load.columns[dimension])
                read_table(case.resolve(load.file), names).require_units(_units(case, load))
        except CaseError as error:
            raise CaseError(complaint(case.source, ("loads", name, "file"), str(error))) from None
    history = build_history(case)
    if case.start is not None:
        from fretfe.bodies.beginning import read_beginning

        read_beginning(case, history)
    return history


def _units(case: Case, load: PointLoad | OtherRun) -> dict[str, str]:
    """Units of the columns that a file of a load may have: factors and strains are numbers.

    The factor of a load converts lengths of any unit, and times are those of the other run.
    """
    factor = load.factor if isinstance(load, OtherRun | ShapeLoad) else 1.0
    lengths = (*AXES, *(f"u{axis}" for axis in AXES)) if factor == 1 else ()
    values = () if isinstance(load, OtherRun | ShapeLoad) else load.columns[3]
    return dict.fromkeys(values, "1") | dict.fromkeys(lengths, case.units.length) | {"T": "°C"}


def _require_field(case: Case, load: OtherRun) -> None:
    from fretfe.fields.field import field_file

    path = field_file(case.resolve(load.file), load.quantity)
    if path.suffix.lower() in TABLES:
        stamp = path.stat()
        arrays = load.arrays or ()
        field = _read_once(path, load.quantity, arrays, stamp.st_mtime_ns, stamp.st_size)
        require_units(path, field.stated, _units(case, load))


@lru_cache
def _read_once(path: Path, quantity: Quantity, arrays: Names, modified: int, size: int) -> Field:
    """Read a table if that was not done before: several loads have the same one."""
    from fretfe.fields.field import read_field

    return read_field(path, quantity, arrays)
