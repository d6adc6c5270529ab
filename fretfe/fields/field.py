# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacements or temperatures of a run, of this program or another one, by the kind of file.

A new kind of file has a function in `READERS`, by the ending of its name, which returns a `Field`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case.base import AXES, LARGEST
from fretfe.errors import CaseError, OutputError
from fretfe.fields.frd import read_frd
from fretfe.fields.sizes import require_sizes
from fretfe.files import require_file
from fretfe.loads.csv_file import Table, read_table
from fretfe.mesh.mesh import place_text
from fretfe.plugins import PlugIn, plug_in, plug_ins, what
from fretfe.results.field_files import CELL_TYPES, FIELDS, FieldReader

# Entry points of other readers: functions as in `READERS`, by the endings of files without dots.
GROUP = "fretfe.readers"
# What a file is read for.
Quantity = Literal["displacements", "temperatures"]
# Names of values at nodes.
Names = tuple[str, ...]
# The time of the only step of a file that names none.
ONLY_STEP = 1.0
# Rounding of numbers in single precision.
SINGLE = float(np.finfo(np.float32).eps) / 2
# Significant digits that a program may have written, and of how many values that is found.
DIGITS = range(4, 10)
SAMPLE = 1000

# Numbers of nodes of the elements whose shape functions VTK knows, by its number of their kind.
# Those of polygons and polyhedra do not reproduce linear fields, and others have none.
NODES = {
    3: (2,), 5: (3,), 8: (4,), 9: (4,), 10: (4,), 11: (8,), 12: (8,), 13: (6,), 14: (5,), 21: (3,),
    22: (6,), 23: (8,), 24: (10,), 25: (20,), 26: (15,), 27: (13,), 28: (9,), 29: (27,), 30: (6,),
    31: (12,), 32: (18,), 33: (24,), 34: (7,), 68: (2, 3, 4, 5), 69: (3, 6, 10, 15),
    70: (4, 9, 16, 25), 71: (4, 10, 20, 35), 72: (8, 27, 64, 125), 73: (6, 18, 40, 75),
}  # fmt: skip


@dataclass(frozen=True)
class Cells:
    """Elements between the points of a field, as VTK has them.

    Attributes:
        nodes: (c,) numbers of the points of each element, one element after the other.
        offsets: (m + 1,) where they begin, and the end.
        shapes: (m,) VTK's number of each element.
        parts: (m,) number of the part of each element among `names`.
        names: of the parts; () if the file has none.
    """

    nodes: Indices
    offsets: Indices
    shapes: Indices
    parts: Indices
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Field:
    """Displacements, or temperatures, at points, in the steps of a run.

    Attributes:
        points: (n, 3), z = 0 in the plane.
        times: (T,) of the steps, increasing; their numbers where the file has no times.
        values: (n, 3) displacements or (n, 1) temperatures in a step, by its number from 0.
        cells: elements between the points; None if the file has none.
        rounding: of the values, relative; 0 if it is not known.
        numbered: whether the times are numbers of steps.
        stated: units of columns of a table by their names, where it states them.
    """

    points: Array
    times: Array
    values: Callable[[int], Array]
    cells: Cells | None = None
    rounding: float = 0.0
    numbered: bool = False
    stated: Mapping[str, str] = MappingProxyType({})


def rounding_of(values: Array) -> float:
    """Relative rounding of values (n, ...) as their file has them; 0 if it has all their digits.

    It is that of single precision, or of the digits of a text.
    """
    found = values[np.isfinite(values)]
    found = found[np.abs(found) > 0]
    chosen = found[:: 1 + len(found) // SAMPLE]
    # Few values may have few digits by themselves.
    if len(np.unique(chosen)) < SAMPLE // 10:
        return 0.0
    if (chosen == chosen.astype(np.float32)).all():
        return SINGLE
    for digits in DIGITS:
        if all(float(f"{value:.{digits - 1}e}") == value for value in chosen.tolist()):
            return 0.5 * 10.0 ** (1 - digits)
    return 0.0


def field_file(path: Path, quantity: Quantity) -> Path:
    """The file of a field, which is there; that in the results folder of a run.

    Raises:
        CaseError: if there is none that can be read.
    """
    if path.is_dir():
        path = path / FIELDS
    require_file(path, f"a file with {quantity}, or a results folder with fields", CaseError)
    if path.suffix.lower() not in READERS and _other_reader(path) is None:
        others = (f".{each.name}" for each in plug_ins(GROUP))
        raise CaseError(
            f"{path}: expected a file of {quantity} whose name ends in one of "
            f"{', '.join((*READERS, *others))}, or a results folder"
        )
    return path


def _other_reader(path: Path) -> PlugIn | None:
    """The reader of another package whose name is the ending of a file; None without one."""
    ending = path.suffix.lower().removeprefix(".")
    return plug_in(GROUP, ending)


def read_field(path: Path, quantity: Quantity = "displacements", arrays: Names = ()) -> Field:
    """A field in a file, or in the results folder of a run.

    Args:
        path: of the file or folder.
        quantity: that is read.
        arrays: the values at nodes that are it, by their names in a file that VTK reads: a vector,
            or a number for each component; without any, those that are usual.

    Raises:
        CaseError: if it is not as expected.
        DependencyError: if what reads it is not installed.
    """
    path = field_file(path, quantity)
    require_sizes(path)
    read = READERS.get(path.suffix.lower()) or _by_other
    found = read(path, quantity, arrays)
    _require_good(path, found)

    def values(step: int) -> Array:
        read = found.values(step)
        _require_usual(path, f"values in step {step + 1}", read)
        return read

    return replace(found, values=values)


def _require_usual(path: Path, what: str, values: Array) -> None:
    """Check that numbers (n, ...) at points are as a case may have them; NaN is none."""
    rows = np.flatnonzero((np.abs(values) > LARGEST).reshape(len(values), -1).any(axis=1))
    if rows.size:
        raise CaseError(
            f"{path}: expected {what} from {-LARGEST:g} to {LARGEST:g}, found {values[rows[0]]} "
            f"(point {rows[0]})"
        )


def _by_other(path: Path, quantity: Quantity, arrays: Names) -> Field:
    """A field by the reader of another package; each step is read by it too."""
    reader = _other_reader(path)
    assert reader is not None, "field_file has found it"
    found = reader.call(path, quantity, arrays)
    if not isinstance(found, Field):
        raise CaseError(f"{path}: expected a Field of {reader.title}, found {what(found)}")
    return replace(found, values=lambda step: reader.guard(found.values, step))


def _require_good(path: Path, found: Field) -> None:
    """Check what no reader has to: finite points, and times that increase."""
    if not np.isfinite(found.points).all():
        row = int(np.flatnonzero(~np.isfinite(found.points).all(axis=1))[0])
        raise CaseError(
            f"{path}: expected finite coordinates, found {found.points[row]} (point {row})"
        )
    _require_usual(path, "coordinates", found.points)
    if not len(found.times) or not len(found.points):
        missing = "steps" if len(found.points) else "points"
        raise CaseError(f"{path}: expected values of at least one step, found no {missing}")
    if found.cells is not None:
        _require_elements(path, found.cells, found.points)
    back = np.flatnonzero(np.diff(found.times) <= 0)
    if back.size or found.times[0] < 0 or not np.isfinite(found.times).all():
        raise CaseError(
            f"{path}: expected times of steps that are not negative and increase, found "
            f"{', '.join(f'{time:g}' for time in found.times[:10])}"
        )


def _require_elements(path: Path, cells: Cells, points: Array) -> None:
    """Check that elements are known, made of points that are there, and not all in one of them."""
    count, ends = len(points), cells.offsets
    good = len(cells.nodes) and 0 <= cells.nodes.min() and cells.nodes.max() < count
    if not good or len(ends) != len(cells.shapes) + 1 or (np.diff(ends) <= 0).any():
        raise CaseError(f"{path}: expected elements between its {count} points, found others")
    if ends[0] != 0 or ends[-1] != len(cells.nodes):
        raise CaseError(f"{path}: expected {len(cells.nodes)} nodes of elements, found {ends[-1]}")
    for shape in np.unique(cells.shapes).tolist():
        own = np.flatnonzero(cells.shapes == shape)
        if shape not in NODES:
            raise CaseError(
                f"{path}: expected elements of VTK's kinds {', '.join(map(str, NODES))}, whose "
                f"displacement is known by that of their nodes, found element {own[0]} (from 0) of "
                f"kind {shape}"
            )
        sizes = np.diff(ends)[own]
        if (wrong := ~np.isin(sizes, NODES[shape])).any():
            raise CaseError(
                f"{path}: expected {' or '.join(map(str, NODES[shape]))} nodes of elements of "
                f"VTK's kind {shape}, found element {own[wrong][0]} (from 0) of {sizes[wrong][0]}"
            )
    places = points[cells.nodes]
    low, high = (each.reduceat(places, ends[:-1], axis=0) for each in (np.minimum, np.maximum))
    if (point := ~(high > low).any(axis=1)).any():
        element = int(np.flatnonzero(point)[0])
        raise CaseError(
            f"{path}: expected elements with an extent, found element {element} (from 0) with all "
            f"nodes at {place_text(low[element])}"
        )


def elements_of_part(path: Path, cells: Cells, part: str | None, body: str) -> Indices:
    """Numbers of the elements of a part, or of that with the name of a body; all without parts.

    Raises:
        CaseError: if the field has no such part.
    """
    chosen = body if part is None else part
    if chosen in cells.names:
        return np.flatnonzero(cells.parts == cells.names.index(chosen))
    if part is not None or cells.names:
        raise CaseError(
            f"{path}: expected one of its parts {', '.join(map(repr, cells.names)) or '(none)'}, "
            f"found {chosen!r}"
        )
    return np.arange(len(cells.shapes))


def _require_unnamed(path: Path, arrays: Names) -> None:
    """Check that no names are given for a file that has only one field of each kind."""
    if arrays:
        raise CaseError(
            f"{path}: expected no 'arrays' but of a file that VTK reads, found "
            f"{', '.join(map(repr, arrays))}"
        )


def _read_csv(path: Path, quantity: Quantity, arrays: Names) -> Field:
    """Columns x, y (z), ux, uy (uz) or T, and time or step, the same in all rows of a step."""
    _require_unnamed(path, arrays)
    heated = quantity == "temperatures"
    names = ("x", "y", "T") if heated else ("x", "y", "ux", "uy")
    others = ("z", "time", "step") if heated else ("z", "uz", "time", "step")
    table = read_table(path, names, others)
    columns = table.columns
    if not heated and ("z" in columns) != ("uz" in columns):
        raise CaseError(f"{path}: line 1: expected both or none of the columns 'z' and 'uz'")
    if "time" in columns and "step" in columns:
        raise CaseError(
            f"{path}: line 1: expected one of the columns 'time' and 'step', found both"
        )
    clock = columns.get("time", columns.get("step"))
    zero = np.zeros(len(columns["x"]))
    places = np.stack([columns.get(axis, zero) for axis in AXES], axis=1)
    listed = ["T"] if heated else [f"u{axis}" for axis in AXES]
    values = np.stack([columns.get(name, zero) for name in listed], axis=1)
    if clock is None:
        clock = np.full(len(zero), ONLY_STEP)
    times, number = np.unique(clock, return_inverse=True)
    rows = [
        _sorted_rows(table, places, np.flatnonzero(number == step)) for step in range(len(times))
    ]
    for time, own in zip(times[1:], rows[1:], strict=True):
        if len(own) != len(rows[0]) or (places[own] != places[rows[0]]).any():
            raise CaseError(
                f"{path}: expected the same points in every step, found others at {time:g} than at "
                f"{times[0]:g}"
            )
    return Field(
        places[rows[0]],
        times,
        lambda step: values[rows[step]],
        rounding=rounding_of(values),
        numbered="step" in columns,
        stated=table.stated,
    )


def _sorted_rows(table: Table, places: Array, rows: Indices) -> Indices:
    """Rows of a step in the order of their points, of which there are no two."""
    order = rows[np.lexsort(places[rows].T)]
    again = np.flatnonzero((np.diff(places[order], axis=0) == 0).all(axis=1))
    if again.size:
        table.complain(
            int(order[again[0] + 1]), "x", "a point of its own in each step, not one twice"
        )
    return order


def _read_results(path: Path, quantity: Quantity) -> Field:
    """Displacements of a run of this program."""
    if quantity != "displacements":
        raise CaseError(f"{path}: expected {quantity}, found a run that has displacements only")
    return run_field(path, "displacement")


def run_field(path: Path, name: str) -> Field:
    """A field of a run of this program; the parts are its bodies.

    Args:
        path: of its `fields.hdf`.
        name: "displacement", or "stress", whose values are (n, 6), xx, yy, zz, xy, yz, xz.

    Raises:
        CaseError: if it is not as expected.
    """
    try:
        reader = FieldReader(path)
        nodes = {body: reader.nodes(body) for body in reader.bodies}
    except OutputError as error:
        raise CaseError(str(error)) from None
    kinds = {(each.shape[-1], each.shape[1]) for each in nodes.values()}
    if {axes for axes, _ in kinds} != {3}:
        raise CaseError(f"{path}: expected coordinates x, y, z, found others")
    points = np.concatenate([each.reshape(-1, 3) for each in nodes.values()])
    dimension = 3 if np.ptp(points[:, 2]) > 0 else 2
    if wrong := [width for _, width in kinds if (dimension, width) not in CELL_TYPES]:
        raise CaseError(f"{path}: expected elements as a run has them, found some of {wrong} nodes")
    widths = np.concatenate([np.full(len(each), each.shape[1]) for each in nodes.values()])
    counts = [len(each) for each in nodes.values()]
    shapes = [CELL_TYPES[dimension, each.shape[1]] for each in nodes.values()]
    cells = Cells(
        nodes=np.arange(len(points)),
        offsets=np.concatenate([[0], np.cumsum(widths)]),
        shapes=np.repeat(shapes, counts),
        parts=np.repeat(np.arange(len(counts)), counts),
        names=tuple(nodes),
    )

    def values(step: int) -> Array:
        try:
            each = [reader.values(name, body, step) for body in reader.bodies]
        except OutputError as error:
            raise CaseError(str(error)) from None
        width = 3 if name == "displacement" else 6
        shapes = [(*own.shape[:2], width) for own in nodes.values()]
        if [own.shape for own in each] != shapes:
            raise CaseError(f"{path}: expected a {name} at each node, found others")
        return np.concatenate([own.reshape(-1, width) for own in each])

    return Field(points, reader.times, values, cells, SINGLE)


def _read_hdf(path: Path, quantity: Quantity, arrays: Names) -> Field:
    """Fields of this program, or of another one that writes VTKHDF."""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            own = "VTKHDF/CellData/body" in file and "VTKHDF/Steps" in file
    except (OSError, RuntimeError) as error:
        raise CaseError(f"{path}: expected a VTKHDF file, found: {error}") from None
    if not own:
        return _read_vtk(path, quantity, arrays)
    _require_unnamed(path, arrays)
    return _read_results(path, quantity)


def _read_calculix(path: Path, quantity: Quantity, arrays: Names) -> Field:
    """Steps of a result file of CalculiX; nodes without a displacement are those of beams."""
    _require_unnamed(path, arrays)
    found = read_frd(path, "NDTEMP" if quantity == "temperatures" else "DISP")
    count = len(found.shapes)
    cells = Cells(found.nodes, found.offsets, found.shapes, np.zeros(count, dtype=np.int64))
    rounding = max(rounding_of(found.values(0)), SINGLE)
    return Field(found.points, found.times, found.values, cells if count else None, rounding)


def _read_vtk(path: Path, quantity: Quantity, arrays: Names) -> Field:
    """Steps of a file that VTK reads, which takes a while to load."""
    from fretfe.fields.vtk import read_grid

    times, read = read_grid(path, quantity, arrays)
    points, cells, first = read(0)

    def values(step: int) -> Array:
        places, _, moved = read(step)
        if places.shape != points.shape or (places != points).any():
            raise CaseError(
                f"{path}: expected the same points in every step, found others in step {step + 1}"
            )
        return moved

    return Field(points, times, values, cells, rounding_of(first))


READERS: Mapping[str, Callable[[Path, Quantity, Names], Field]] = {
    ".csv": _read_csv,
    ".txt": _read_csv,
    ".hdf": _read_hdf,
    ".vtkhdf": _read_hdf,
    ".frd": _read_calculix,
    ".vtu": _read_vtk,
    ".vtk": _read_vtk,
    ".pvd": _read_vtk,
}
