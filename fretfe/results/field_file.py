# SPDX-License-Identifier: LGPL-3.0-or-later
"""One file with displacement and stress of all bodies at some times, in the format VTKHDF.

ParaView 5.12 and PyVista with VTK 9.3, and what is newer, read it. All bodies are one grid, in
which each element has nodes of its own: fields may jump between elements. The grid is stored once;
values are appended time by time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretfe._typing import Array
from fretfe.errors import OutputError

# PyVista before 0.45 knows the format by this ending only.
FIELDS = "fields.hdf"
# Of the format: the first one with time steps.
FORMAT = (2, 0)
# VTK's number of a cell, by dimension and number of nodes.
CELL_TYPES = {
    (2, 3): 5, (2, 4): 9, (2, 6): 22, (2, 9): 28,
    (3, 4): 10, (3, 8): 12, (3, 10): 24, (3, 27): 29,
}  # fmt: skip
# Vectors, and symmetric tensors xx, yy, zz, xy, yz, xz.
COMPONENTS = {"displacement": 3, "stress": 6}
# Places and displacements of a node recur in the elements around it: found in whole numbers only.
# Stresses do not; their bytes are sorted by significance.
PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 1}
SHUFFLED = {"displacement": False, "stress": True}
# What is stored for each state, besides where its values begin: all states have the first grid.
SERIES: dict[str, tuple[type, int, tuple[int, ...]]] = {
    "PartOffsets": (np.int64, 0, ()),
    "NumberOfParts": (np.int64, 1, ()),
    "PointOffsets": (np.int64, 0, ()),
    "CellOffsets": (np.int64, 0, (1,)),
    "ConnectivityIdOffsets": (np.int64, 0, (1,)),
    "CellDataOffsets/body": (np.int64, 0, ()),
}
# States in a chunk of what is a number for each of them.
SERIES_CHUNK = 128


class FieldWriter:
    """Writes fields state by state. After each of them the file is complete.

    Args:
        path: file to write.
        nodes: (m, k, d) by body: places of the k nodes of each of m elements, in VTK's order;
            exactly the same place for a node that elements share.

    Raises:
        OSError: if the file cannot be written; so do all methods.
    """

    def __init__(self, path: Path, nodes: Mapping[str, Array]) -> None:
        self._file = h5py.File(path, "w")
        self._root = self._file.create_group("VTKHDF")
        self._root.attrs.update({"Version": FORMAT, "Type": np.bytes_("UnstructuredGrid")})
        self._count = sum(each.shape[0] * each.shape[1] for each in nodes.values())
        self._write_grid(nodes)
        self._steps = self._root.create_group("Steps")
        self._steps.attrs["NSteps"] = 0
        self._prepare_series("Values", np.float64, 0, ())
        for name, series in SERIES.items():
            self._prepare_series(name, *series)
        for name, components in COMPONENTS.items():
            self._prepare_series(f"PointDataOffsets/{name}", np.int64, 0, ())
            self._prepare(f"PointData/{name}", components, np.float32, shuffle=SHUFFLED[name])

    def close(self) -> None:
        """Finish the file."""
        self._file.close()

    def add(self, time: float, fields: Mapping[str, Sequence[Array]]) -> None:
        """Append a state.

        Args:
            time: of the state.
            fields: "displacement" and "stress": (m, k, c) for each body, in the order of its nodes;
                the components beyond c are zero.
        """
        number = int(self._steps.attrs["NSteps"])
        first = number * self._count
        for name, bodies in fields.items():
            stored = self._root["PointData"][name]
            stored.resize(first + self._count, axis=0)
            _fill(stored, first, bodies)
        for name in ("Values", *SERIES, *(f"PointDataOffsets/{each}" for each in fields)):
            self._steps[name].resize(number + 1, axis=0)
        self._steps["Values"][number] = time
        for name in fields:
            self._steps["PointDataOffsets"][name][number] = first
        self._steps.attrs["NSteps"] = number + 1
        self._file.flush()

    def _write_grid(self, nodes: Mapping[str, Array]) -> None:
        cells = [len(each) for each in nodes.values()]
        widths = np.repeat([each.shape[1] for each in nodes.values()], cells)
        types = [CELL_TYPES[each.shape[2], each.shape[1]] for each in nodes.values()]
        # In full: the smallest elements are tiny next to their distance from the origin.
        _fill(self._prepare("Points", 3, np.float64, self._count), 0, list(nodes.values()))
        for name, values in {
            "Connectivity": np.arange(self._count),
            "Offsets": np.concatenate([[0], np.cumsum(widths)]),
            "Types": np.repeat(types, cells).astype(np.uint8),
            "CellData/body": np.repeat(np.arange(len(nodes), dtype=np.int32), cells),
        }.items():
            self._root.create_dataset(name, data=values, shuffle=True, **PACKED)
        self._root["CellData/body"].attrs["names"] = list(nodes)
        for name, number in {
            "NumberOfPoints": self._count,
            "NumberOfCells": sum(cells),
            "NumberOfConnectivityIds": self._count,
        }.items():
            self._root[name] = np.array([number])

    def _prepare(
        self, name: str, components: int, kind: type, rows: int = 0, *, shuffle: bool = False
    ) -> h5py.Dataset:
        """A table in which each component of each state is a chunk, without room until written."""
        return self._root.create_dataset(
            name, (rows, components), kind,
            maxshape=(None, components), chunks=(self._count, 1), shuffle=shuffle, **PACKED,
        )  # fmt: skip

    def _prepare_series(self, name: str, kind: type, value: int, shape: tuple[int, ...]) -> None:
        self._steps.create_dataset(
            name, (0, *shape), kind,
            maxshape=(None, *shape), chunks=(SERIES_CHUNK, *shape), fillvalue=value,
        )  # fmt: skip


def _fill(table: h5py.Dataset, first: int, bodies: Sequence[Array]) -> None:
    """Write (m, k, c) values of each body into the rows from `first` on."""
    rows = np.concatenate([each.reshape(-1, each.shape[2]) for each in bodies])
    for component, column in enumerate(rows.T):
        table[first : first + len(column), component] = column


class FieldReader:
    """The fields of a file. Values are read when they are asked for.

    Args:
        path: file that a `FieldWriter` has written.

    Raises:
        OutputError: if it is none.
    """

    def __init__(self, path: Path) -> None:
        try:
            self._file = h5py.File(path, "r")
            self._root = self._file["VTKHDF"]
            self.times: Array = self._root["Steps/Values"][:]
            body = self._root["CellData/body"]
            names, cells = body.attrs["names"], np.bincount(body[:])
            ends = self._root["Offsets"][:][np.concatenate([[0], np.cumsum(cells)])]
        except (OSError, KeyError) as error:
            raise OutputError(f"{path}: expected fields of a run, found: {error}") from error
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
        """
        start = int(self._root["Steps/PointDataOffsets"][name][number])
        return self._read(f"PointData/{name}", body, start).astype(np.float64)

    def _read(self, table: str, body: str, start: int) -> Array:
        first, last, count = self._rows[body]
        values: Array = self._root[table][start + first : start + last]
        return values.reshape(count, -1, values.shape[-1])
