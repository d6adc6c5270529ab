# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields over the bodies, and tractions on contact surfaces of solids: a file each, as VTKHDF.

ParaView 5.12 and PyVista with VTK 9.3, and what is newer, read the format. The grid is stored once;
values are appended time by time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.history.solution import ContactHistory, Solution
from fretfe.history.state_array import blocks
from fretfe.results.hdf5_file import PatientFile, read_fault

# Of the format: the first one with time steps.
FORMAT = (2, 0)
# Places of a node recur in the elements around it. What does not get smaller is stored as it is,
# without the checksum of the compression.
PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "fletcher32": True}
# What is stored for each state, besides where its values begin: all states have the first grid.
SERIES: dict[str, tuple[type, int, tuple[int, ...]]] = {
    "PartOffsets": (np.int64, 0, ()),
    "NumberOfParts": (np.int64, 1, ()),
    "PointOffsets": (np.int64, 0, ()),
    "CellOffsets": (np.int64, 0, (1,)),
    "ConnectivityIdOffsets": (np.int64, 0, (1,)),
}
# States in a chunk of what is a number for each of them.
SERIES_CHUNK = 128
# The ending by which PyVista knows the format.
SURFACES = "contacts.hdf"
# PyVista before 0.45 knows the format by this ending only.
FIELDS = "fields.hdf"
# Displacements alone, of the states that drive parts around free ends.
DISPLACEMENTS = "displacements.hdf"
# VTK's number of a cell, by dimension and number of nodes.
CELL_TYPES = {
    (2, 3): 5, (2, 4): 9, (2, 6): 22, (2, 9): 28,
    (3, 4): 10, (3, 8): 12, (3, 10): 24, (3, 27): 29,
}  # fmt: skip


@dataclass(frozen=True)
class Part:
    """A part of a grid.

    Attributes:
        points: (n, d) its nodes.
        cells: (m, k) nodes of each cell, in VTK's order.
        shape: VTK's number of the cells.
    """

    points: Array
    cells: Indices
    shape: int


@dataclass(frozen=True)
class Column:
    """Values at the nodes.

    Attributes:
        components: of each value.
        kind: type of the numbers.
        shuffled: True to sort the bytes by significance, which packs what does not recur.
        packed: False for what is read again at once: packing takes longer than all else.
    """

    components: int = 1
    kind: type = np.float32
    shuffled: bool = True
    packed: bool = True


CONTACT_COLUMNS = {
    "pressure": Column(),
    "shear": Column(3),
    "slip": Column(3),
    "gap": Column(),
    "status": Column(kind=np.uint8),
    "dissipation": Column(),
}
# Vectors, and symmetric tensors xx, yy, zz, xy, yz, xz. Displacements of a node recur in the
# elements around it: found in whole numbers only. Stresses do not.
COLUMNS = {"displacement": Column(3, shuffled=False), "stress": Column(6)}


class GridWriter:
    """Writes values at the nodes of a grid state by state. After each of them the file is complete.

    Args:
        path: file to write.
        parts: of the grid, by name.
        label: name of the cell data with the number of the part.
        columns: of the values, by name.

    Raises:
        OSError: if the file cannot be written; so do all methods.
    """

    def __init__(
        self, path: Path, parts: Mapping[str, Part], label: str, columns: Mapping[str, Column]
    ) -> None:
        self._raw = PatientFile(path)
        self._file = h5py.File(self._raw, "w")
        self._root = self._file.create_group("VTKHDF")
        self._root.attrs.update({"Version": FORMAT, "Type": np.bytes_("UnstructuredGrid")})
        self._count = sum(len(part.points) for part in parts.values())
        self._series = {**SERIES, f"CellDataOffsets/{label}": (np.int64, 0, ())}
        self._write_grid(parts, label)
        self._steps = self._root.create_group("Steps")
        self._steps.attrs["NSteps"] = 0
        self._prepare_series("Values", np.float64, 0, ())
        for name, series in self._series.items():
            self._prepare_series(name, *series)
        for name, column in columns.items():
            self._prepare_series(f"PointDataOffsets/{name}", np.int64, 0, ())
            self._prepare(f"PointData/{name}", column)

    def close(self) -> None:
        """Finish the file."""
        self._file.close()
        self._raw.close()

    def add(self, time: float, values: Mapping[str, Sequence[Array]]) -> None:
        """Append a state.

        Args:
            time: of the state.
            values: (..., c) of each part for each column, in the order of its nodes; the components
                beyond c are zero.
        """
        one = {name: [each[None] for each in parts] for name, parts in values.items()}
        self.add_states(np.array([time]), one)

    def add_states(self, times: Array, values: Mapping[str, Sequence[Array]]) -> None:
        """Append n states; values (n, ..., c) as of `add`."""
        number, count = int(self._steps.attrs["NSteps"]), len(times)
        firsts = self._count * np.arange(number, number + count)
        for name, parts in values.items():
            stored = self._root["PointData"][name]
            stored.resize(self._count * (number + count), axis=0)
            rows = [each.reshape(count, -1, each.shape[-1]) for each in parts]
            _fill(stored, int(firsts[0]), np.concatenate(rows, axis=1))
        for name in ("Values", *self._series, *(f"PointDataOffsets/{each}" for each in values)):
            self._steps[name].resize(number + count, axis=0)
        self._steps["Values"][number:] = times
        for name in values:
            self._steps["PointDataOffsets"][name][number:] = firsts
        self._steps.attrs["NSteps"] = number + count
        self._file.flush()
        self._raw.require()

    def _write_grid(self, parts: Mapping[str, Part], label: str) -> None:
        each = list(parts.values())
        cells = [len(part.cells) for part in each]
        widths = np.repeat([part.cells.shape[1] for part in each], cells)
        starts = np.cumsum([0, *(len(part.points) for part in each)])
        nodes = [start + part.cells.ravel() for start, part in zip(starts, each, strict=False)]
        # In full: the smallest elements are tiny next to their distance from the origin.
        points = self._prepare("Points", Column(3, np.float64, shuffled=False), self._count)
        _fill(points, 0, np.concatenate([part.points for part in each]))
        for name, values in {
            "Connectivity": np.concatenate(nodes),
            "Offsets": np.concatenate([[0], np.cumsum(widths)]),
            "Types": np.repeat([part.shape for part in each], cells).astype(np.uint8),
            f"CellData/{label}": np.repeat(np.arange(len(each), dtype=np.int32), cells),
        }.items():
            self._root.create_dataset(name, data=values, shuffle=True, **PACKED)
        self._root[f"CellData/{label}"].attrs["names"] = list(parts)
        for name, number in {
            "NumberOfPoints": self._count,
            "NumberOfCells": sum(cells),
            "NumberOfConnectivityIds": int(widths.sum()),
        }.items():
            self._root[name] = np.array([number])

    def _prepare(self, name: str, column: Column, rows: int = 0) -> h5py.Dataset:
        """A table in which each component of each state is a chunk, without room until written."""
        return self._root.create_dataset(
            name, (rows, column.components), column.kind,
            maxshape=(None, column.components), chunks=(self._count, 1),
            shuffle=column.shuffled, **(PACKED if column.packed else {"fletcher32": True}),
        )  # fmt: skip

    def _prepare_series(self, name: str, kind: type, value: int, shape: tuple[int, ...]) -> None:
        self._steps.create_dataset(
            name, (0, *shape), kind,
            maxshape=(None, *shape), chunks=(SERIES_CHUNK, *shape), fillvalue=value,
            fletcher32=True,
        )  # fmt: skip


def _fill(table: h5py.Dataset, first: int, values: Array) -> None:
    """Write (..., c) values into the rows from `first` on."""
    for component, column in enumerate(values.reshape(-1, values.shape[-1]).T):
        table[first : first + len(column), component] = column


def write_surfaces(path: Path, solution: Solution, states: Indices) -> None:
    """Write the contacts of solids before deformation, with their values in some states.

    Args:
        path: file to write.
        solution: of solids.
        states: (K,) states, increasing.

    Raises:
        OSError: if the file cannot be written.
    """
    parts = {contact.name: _contact_part(contact) for contact in solution.contacts}
    with closing(GridWriter(path, parts, "contact", CONTACT_COLUMNS)) as writer:
        for block in blocks(len(states), sum(part.points.size for part in parts.values())):
            some = states[block]
            values = [_values(contact, some) for contact in solution.contacts]
            columns = {name: [each[name] for each in values] for name in CONTACT_COLUMNS}
            writer.add_states(solution.times[some], columns)


def _contact_part(contact: ContactHistory) -> Part:
    points, facets = contact.surface.points, contact.surface.facets
    assert facets is not None
    return Part(points, facets, CELL_TYPES[2, facets.shape[1]])


def _values(contact: ContactHistory, states: Indices) -> dict[str, Array]:
    """(n, N, c) values of each column in n states; vectors in axes of the case, work per area."""
    traction = np.asarray(contact.mean_traction[states])
    scalars = {
        "pressure": traction[..., 0],
        "gap": contact.gap[states],
        "status": contact.status[states],
        "dissipation": contact.dissipation[states] / contact.surface.weights,
    }
    return {
        **{name: np.asarray(values)[..., None] for name, values in scalars.items()},
        "shear": in_space(contact, traction[..., 1:]),
        "slip": in_space(contact, contact.slip[states]),
    }


def in_space(contact: ContactHistory, components: Array) -> Array:
    """(..., N, 3) vectors in the axes of the case, from components (..., N, 2) along tangents."""
    return np.asarray(np.einsum("...nt,ntd->...nd", components, contact.surface.frames[:, 1:]))


class FieldWriter(GridWriter):
    """Writes "displacement" and "stress" of the bodies state by state.

    Args:
        path: file to write.
        nodes: (m, k, d) by body: places of the k nodes of each of m elements, in VTK's order;
            exactly the same place for a node that elements share.
        names: of the values; without any both. Displacements alone, which drive parts, are not
            packed.

    Raises:
        OSError: if the file cannot be written; so do all methods.
    """

    def __init__(
        self, path: Path, nodes: Mapping[str, Array], names: Sequence[str] = tuple(COLUMNS)
    ) -> None:
        parts = {body: _part(each) for body, each in nodes.items()}
        packed = "stress" in names
        columns = {name: replace(COLUMNS[name], packed=packed) for name in names}
        super().__init__(path, parts, "body", columns)


def _part(nodes: Array) -> Part:
    count, width, dimension = nodes.shape
    cells = np.arange(count * width).reshape(count, width)
    return Part(nodes.reshape(-1, dimension), cells, CELL_TYPES[dimension, width])


class FieldReader:
    """The fields of a file. Values are read when they are asked for.

    Args:
        path: file that a `FieldWriter` has written.

    Raises:
        OutputError: if it is none.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file = h5py.File(path, "r")
            self._root = self._file["VTKHDF"]
            self.times: Array = self._root["Steps/Values"][:]
            body = self._root["CellData/body"]
            names, numbers = body.attrs["names"], body[:]
            if not len(numbers) or numbers.min() < 0 or numbers.max() + 1 != len(names):
                raise ValueError(f"elements of other bodies than {', '.join(map(str, names))}")
            cells = np.bincount(numbers)
            ends = self._root["Offsets"][:][np.concatenate([[0], np.cumsum(cells)])]
        except (OSError, KeyError, RuntimeError, ValueError, IndexError, TypeError) as error:
            raise OutputError(
                f"{path}: expected fields of a run, found: {read_fault(error)}"
            ) from error
        self._starts: dict[str, Indices] = {}
        self._rows = {
            str(name): (int(first), int(last), int(count))
            for name, first, last, count in zip(names, ends[:-1], ends[1:], cells, strict=True)
        }

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies."""
        return tuple(self._rows)

    def nodes(self, body: str) -> Array:
        """(m, k, 3) places of the nodes of each element, in VTK's order."""
        return self._read("Points", body, 0)

    def values(self, name: str, body: str, number: int) -> Array:
        """(m, k, 3 or 6) displacement or stress at the nodes of each element.

        Args:
            name: "displacement" or "stress".
            body: its name.
            number: of the state among `times`.

        Raises:
            OutputError: if they are damaged; so does `nodes`.
        """
        if name not in self._starts:  # of all states at once: one by one takes as long as values
            stored = self._stored(f"Steps/PointDataOffsets/{name}", slice(None))
            self._starts[name] = stored.astype(np.int64)
        starts = self._starts[name]
        if number >= len(starts) or starts[number] < 0:
            raise OutputError(f"{self._path}: expected the start of state {number + 1}, found none")
        return self._read(f"PointData/{name}", body, int(starts[number])).astype(np.float64)

    def _read(self, table: str, body: str, start: int) -> Array:
        first, last, count = self._rows[body]
        values = self._stored(table, slice(start + first, start + last))
        if values.ndim != 2 or not 0 < len(values) == last - first or len(values) % count:
            raise OutputError(
                f"{self._path}: expected {last - first} rows of {table} for {count} elements, "
                f"found {values.shape}"
            )
        return values.reshape(count, -1, values.shape[-1])

    def _stored(self, table: str, rows: slice) -> Array:
        try:
            values: Array = self._root[table][rows]
        except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
            raise OutputError(f"{self._path}: cannot read {table}: {read_fault(error)}") from error
        return values
