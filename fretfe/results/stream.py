# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays that go to files row by row while a history is solved, and are read back from them.

What is in memory does not grow with the number of rows. Each array has a file of its own with
nothing but its rows: whatever ends the process, the rows before are there.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from fretfe._typing import Indices
from fretfe.errors import OutputError
from fretfe.results.files import disk_reason
from fretfe.results.states import StateArray, states_in_block

# Folder of the files in that of the results, and how their names end.
STATES, ENDING = "states", ".rows"
# Part of a block that waits to be written, as one over this.
PENDING = 8


@dataclass(frozen=True)
class RowKind:
    """Rows of an array, all of one shape and type, and how many there are."""

    shape: tuple[int, ...]
    dtype: str
    count: int = 0

    @property
    def size(self) -> int:
        """Bytes of a row."""
        return int(np.prod(self.shape, dtype=int)) * np.dtype(self.dtype).itemsize


@dataclass
class _Rows:
    """An array that grows; the last rows wait to be written."""

    file: BinaryIO
    kind: RowKind
    written: int
    waiting: list[Any] = field(default_factory=list)

    @property
    def count(self) -> int:
        return self.written + len(self.waiting)

    def flush(self) -> None:
        """Write what waits; what a full disk cuts off is written again."""
        data = memoryview(b"".join(row.tobytes() for row in self.waiting))
        place = self.written * self.kind.size
        while data:
            done = os.pwrite(self.file.fileno(), data, place)
            data, place = data[done:], place + done
        self.written += len(self.waiting)
        self.waiting.clear()

    def read(self, begin: int, end: int) -> Any:
        """Rows one after the other."""
        self.flush()
        size = self.kind.size
        data = bytearray((end - begin) * size)
        view, place = memoryview(data), begin * size
        while view:
            done = os.preadv(self.file.fileno(), [view], place)
            if not done:
                raise OSError(f"expected {size} bytes in each row, found the end of the file")
            view, place = view[done:], place + done
        return np.frombuffer(data, self.kind.dtype).reshape(end - begin, *self.kind.shape)


class StateStream:
    """Growing arrays in the files of a folder.

    Args:
        directory: folder for the files, made if missing; None for files without a name, which take
            no care.
        kinds: arrays that are there and are continued behind their first `count` rows, by name.

    Raises:
        OutputError: if there is no place to write; so do all methods.
    """

    def __init__(
        self, directory: Path | None = None, kinds: Mapping[str, RowKind] | None = None
    ) -> None:
        self._directory = directory
        self._rows: dict[str, _Rows] = {}
        try:
            if directory is not None:
                directory.mkdir(parents=True, exist_ok=True)
                for path in directory.glob(f"*{ENDING}"):
                    if kinds is None or path.stem not in kinds:
                        path.unlink()
            for name, kind in (kinds or {}).items():
                self._continue(name, kind)
        except OSError as error:
            raise self._error(error) from error

    def _continue(self, name: str, kind: RowKind) -> None:
        file = self._open(name, "r+b")
        if os.fstat(file.fileno()).st_size < kind.count * kind.size:
            raise OutputError(
                f"{file.name}: expected {kind.count} rows of {kind.size} bytes, found fewer: the "
                "run cannot be continued"
            )
        file.truncate(kind.count * kind.size)
        self._rows[name] = _Rows(file, kind, kind.count)

    def _open(self, name: str, mode: str) -> BinaryIO:
        if self._directory is None:
            return tempfile.TemporaryFile(buffering=0)  # type: ignore[return-value]
        return (self._directory / f"{name}{ENDING}").open(mode, buffering=0)  # type: ignore[return-value]

    def append(self, rows: Mapping[str, Any]) -> None:
        """Add a row to each of some arrays."""
        try:
            for name, row in rows.items():
                row = np.ascontiguousarray(row)
                if name not in self._rows:
                    kind = RowKind(row.shape, row.dtype.str)
                    self._rows[name] = _Rows(self._open(name, "w+b"), kind, 0)
                each = self._rows[name]
                each.waiting.append(row)
                if len(each.waiting) == states_in_block(PENDING * row.nbytes):
                    each.flush()
        except OSError as error:
            raise self._error(error) from error

    def flush(self) -> dict[str, RowKind]:
        """Write all rows; return what there is then."""
        try:
            for each in self._rows.values():
                each.flush()
        except OSError as error:
            raise self._error(error) from error
        return {
            name: RowKind(each.kind.shape, each.kind.dtype, each.count)
            for name, each in self._rows.items()
        }

    def read(self, name: str, rows: Indices, part: slice = slice(None)) -> Any:
        """Return (n, ...) some rows, in any order, of one array.

        Args:
            name: of the array.
            rows: (n,) their numbers.
            part: of the axis behind that of the rows.
        """
        each = self._rows[name]
        try:
            return select_rows(_Reader(each), rows, part)
        except OSError as error:
            raise self._error(error) from error

    def rows(self, name: str, rows: Indices, part: slice) -> StateArray:
        """Return some rows of an array as one that is read where it is needed.

        Args:
            name: of the array.
            rows: (T,) their numbers.
            part: of the axis behind that of the rows.
        """
        kind = self._rows[name].kind
        shape = (len(rows), len(range(*part.indices(kind.shape[0]))), *kind.shape[1:])
        return StateArray(
            shape, np.dtype(kind.dtype), lambda states: self.read(name, rows[states], part)
        )

    def _error(self, error: OSError) -> OutputError:
        place = self._directory or tempfile.gettempdir()
        return OutputError(
            f"{place}: expected a place for the states of the history, found that "
            f"{disk_reason(error)}"
        )


@dataclass(frozen=True)
class _Reader:
    """Rows that are read like those of a data set of HDF5."""

    rows: _Rows

    def __getitem__(self, key: tuple[slice, slice]) -> Any:
        """Rows one after the other, and a part of the axis behind."""
        where, part = key
        begin, end, _ = where.indices(self.rows.count)
        found = self.rows.read(begin, end)
        return found if part == slice(None) else found[:, part]


def select_rows(dataset: Any, rows: Indices, part: slice = slice(None)) -> Any:
    """Return (n, ...) some rows, in any order, of a data set.

    Args:
        dataset: of a file of HDF5 that is open, or what is read like one.
        rows: (n,) their numbers.
        part: of the axis behind that of the rows.
    """
    wanted, places = np.unique(rows, return_inverse=True)
    runs = np.split(wanted, np.flatnonzero(np.diff(wanted) > 1) + 1)
    found = [dataset[run[0] : run[-1] + 1, part] for run in runs if len(run)]
    if not found:
        return dataset[:0, part]
    values = found[0] if len(found) == 1 else np.concatenate(found)
    same = len(wanted) == len(rows) and np.array_equal(wanted, rows)
    return values if same else values[places]
