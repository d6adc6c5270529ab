# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays that go to an HDF5 file row by row while a history is solved, and are read back from it.

What is in memory does not grow with the number of rows.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.results.states import StateArray, states_in_block

STREAM = "states.h5"
# Part of a block that waits to be written, as one over this.
PENDING = 8


class StateStream:
    """Growing data sets of one HDF5 file.

    Args:
        directory: folder in which the file, `STREAM`, is to be seen, so that it is left if the
            process is killed; None for a file without a name, which takes no care.

    Raises:
        OutputError: if there is no place to write.
    """

    def __init__(self, directory: Path | None = None) -> None:
        try:
            with tempfile.TemporaryDirectory() as unseen:
                self._path = (directory or Path(unseen)) / STREAM
                self._path.unlink(missing_ok=True)
                # Whole chunks are written; a cache of them for each data set would be idle memory.
                self._file = h5py.File(self._path, "w", rdcc_nbytes=0)
                if directory is None:
                    self._path.unlink()
        except OSError as error:
            place = directory or tempfile.gettempdir()
            raise OutputError(
                f"{place}: expected a place for the states of the history, found: {error}"
            ) from error
        self._datasets: dict[str, h5py.Dataset] = {}
        self._lengths: dict[str, int] = {}
        self._pending: dict[str, list[Any]] = {}
        self._counts: dict[str, int] = {}

    def append(self, rows: Mapping[str, Any]) -> None:
        """Add a row to each of some data sets.

        Raises:
            OutputError: if it cannot be written.
        """
        for name, row in rows.items():
            row = np.asarray(row)
            if name not in self._counts:
                self._create(name, row)
            self._counts[name] += 1
            waiting = self._pending[name]
            waiting.append(row)
            if len(waiting) == self._lengths[name]:
                self._write(name)

    def _create(self, name: str, row: Array) -> None:
        length = states_in_block(PENDING * row.nbytes)
        # An empty axis has no chunks.
        chunks = (length, *(max(size, 1) for size in row.shape))
        shape, most = (0, *row.shape), (None, *(size or None for size in row.shape))
        self._datasets[name] = self._file.create_dataset(
            name, shape, row.dtype, chunks=chunks, maxshape=most
        )
        self._lengths[name], self._counts[name], self._pending[name] = length, 0, []

    def _write(self, name: str) -> None:
        dataset, rows = self._datasets[name], self._pending[name]
        if not rows:
            return
        try:
            dataset.resize(self._counts[name], axis=0)
            dataset[self._counts[name] - len(rows) :] = np.array(rows)
            self._file.flush()
        except OSError as error:
            raise OutputError(f"{self._path}: cannot write the states: {error}") from error
        rows.clear()

    def read(self, name: str, rows: Indices, part: slice = slice(None)) -> Any:
        """Return (n, ...) some rows, in any order, of one data set.

        Args:
            name: of the data set.
            rows: (n,) their numbers.
            part: of the axis behind that of the rows.
        """
        self._write(name)
        return select_rows(self._datasets[name], rows, part)

    def rows(self, name: str, rows: Indices, part: slice) -> StateArray:
        """Return some rows of a data set as an array that is read where it is needed.

        Args:
            name: of the data set.
            rows: (T,) their numbers.
            part: of the axis behind that of the rows.
        """
        dataset = self._datasets[name]
        shape = (len(rows), len(range(*part.indices(dataset.shape[1]))), *dataset.shape[2:])
        return StateArray(shape, dataset.dtype, lambda states: self.read(name, rows[states], part))


def select_rows(dataset: h5py.Dataset, rows: Indices, part: slice = slice(None)) -> Any:
    """Return (n, ...) some rows, in any order, of a data set.

    Args:
        dataset: in a file that is open.
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
