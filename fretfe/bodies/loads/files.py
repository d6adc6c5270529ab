# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that loads name: values at points, and a look at all files before there is a mesh."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fretfe.case import Case, complaint
from fretfe.case.base import ABSOLUTE_ZERO, AXES
from fretfe.case.loads import EigenstrainLoad, LoadAtPoints, OtherRun, TemperatureLoad
from fretfe.errors import CaseError
from fretfe.loads import History, build_history
from fretfe.loads.csv_file import read_table

# What reads files is imported where it is needed: most cases have none, and SciPy and HDF5 take a
# while.
if TYPE_CHECKING:
    from fretfe.bodies.point_values import PointValues
    from fretfe.fields.field import Names, Quantity

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
        return read_points(case.resolve(load.file), dimension, load.columns[dimension], least)
    except CaseError as error:
        raise CaseError(complaint(case.source, ("loads", name, "file"), str(error))) from None


def checked_history(case: Case) -> History:
    """The load history of a case, after a look at the files of its loads.

    Nothing has been meshed then: what is wrong with a file is told before any work. Of tables all
    numbers are read that are sure to be needed; of other files it is told whether they are there.

    Raises:
        CaseError: file and key, and line and column of a table, of what is not as expected.
    """
    for name, load in case.loads.items():
        try:
            if isinstance(load, OtherRun):
                _require_field(case.resolve(load.file), load.quantity, load.arrays or ())
            elif isinstance(load, PointLoad) and load.file is not None:
                # Whether the bodies of a mesh file are solid is not known yet.
                dimension = 2 if case.geometry.solid is None else 3
                names = (*AXES[:dimension], *load.columns[dimension])
                read_table(case.resolve(load.file), names)
        except CaseError as error:
            raise CaseError(complaint(case.source, ("loads", name, "file"), str(error))) from None
    history = build_history(case)
    if case.start is not None:
        from fretfe.bodies.beginning import read_beginning

        read_beginning(case, history)
    return history


def _require_field(path: Path, quantity: Quantity, arrays: Names) -> None:
    from fretfe.fields.field import field_file

    path = field_file(path, quantity)
    if path.suffix.lower() in TABLES:
        stamp = path.stat()
        _read_once(path, quantity, arrays, stamp.st_mtime_ns, stamp.st_size)


@lru_cache
def _read_once(path: Path, quantity: Quantity, arrays: Names, modified: int, size: int) -> None:
    """Read a table if that was not done before: several loads have the same one."""
    from fretfe.fields.field import read_field

    read_field(path, quantity, arrays)
