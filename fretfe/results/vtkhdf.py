# SPDX-License-Identifier: LGPL-3.0-or-later
"""Grids with values at some times, in the format VTKHDF.

ParaView 5.12 and PyVista with VTK 9.3, and what is newer, read it. The grid is stored once; values
are appended time by time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.results.hdf5_file import PatientFile

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
    """

    components: int = 1
    kind: type = np.float32
    shuffled: bool = True


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
        number = int(self._steps.attrs["NSteps"])
        first = number * self._count
        for name, parts in values.items():
            stored = self._root["PointData"][name]
            stored.resize(first + self._count, axis=0)
            _fill(stored, first, parts)
        for name in ("Values", *self._series, *(f"PointDataOffsets/{each}" for each in values)):
            self._steps[name].resize(number + 1, axis=0)
        self._steps["Values"][number] = time
        for name in values:
            self._steps["PointDataOffsets"][name][number] = first
        self._steps.attrs["NSteps"] = number + 1
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
        _fill(points, 0, [part.points for part in each])
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
            shuffle=column.shuffled, **PACKED,
        )  # fmt: skip

    def _prepare_series(self, name: str, kind: type, value: int, shape: tuple[int, ...]) -> None:
        self._steps.create_dataset(
            name, (0, *shape), kind,
            maxshape=(None, *shape), chunks=(SERIES_CHUNK, *shape), fillvalue=value,
            fletcher32=True,
        )  # fmt: skip


def _fill(table: h5py.Dataset, first: int, parts: Sequence[Array]) -> None:
    """Write (..., c) values of each part into the rows from `first` on."""
    rows = np.concatenate([each.reshape(-1, each.shape[-1]) for each in parts])
    for component, column in enumerate(rows.T):
        table[first : first + len(column), component] = column
