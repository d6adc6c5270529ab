# SPDX-License-Identifier: LGPL-3.0-or-later
"""New HDF5 files with checksums, on disks that may be full.

HDF5 ends the process if it cannot write what it still has when a file is closed. So it never learns
that a disk is full: what does not fit stays in memory until the file is closed or given up.

All that is in a file has checksums, of which HDF5 looks at those of what it reads: the values as
`store` and `room` write them, the rest by the version of the format.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fretfe.errors import OutputError

# The first version whose headers and indices have checksums and that is short for small arrays.
FORMAT = "v110"


class PatientFile(io.FileIO):
    """A new file whose writes never fail; `require` tells that one did.

    Args:
        path: of the file.

    Raises:
        OSError: if it cannot be made.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+")
        self._failure: OSError | None = None
        self._held: list[tuple[int, bytes]] = []

    def write(self, data: Any) -> int:
        """Write all of it, to memory after the first failure."""
        place, view = self.tell(), memoryview(data).cast("B")
        size = len(view)
        try:
            while view and self._failure is None:
                done = os.pwrite(self.fileno(), view, place)
                view, place = view[done:], place + done
        except OSError as error:
            self._failure = error
        if view:
            self._held.append((place, bytes(view)))
        self.seek(place + len(view))
        return size

    def readinto(self, buffer: Any) -> int:
        """Read what was written, wherever it is."""
        view, begin = memoryview(buffer).cast("B"), self.tell()
        super().readinto(view)
        for place, data in self._held:
            first, last = max(place, begin), min(place + len(data), begin + len(view))
            if first < last:
                view[first - begin : last - begin] = data[first - place : last - place]
        return len(view)

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file."""
        try:
            return super().truncate(size)
        except OSError as error:
            self._failure = self._failure or error
            return size or 0

    def require(self) -> None:
        """Raise the error of the first write that failed.

        Raises:
            OSError: if there is one.
        """
        if self._failure is not None:
            raise self._failure


@contextlib.contextmanager
def new_hdf5(path: Path) -> Iterator[h5py.File]:
    """A new HDF5 file.

    Raises:
        OSError: if it cannot be written.
    """
    with PatientFile(path) as raw:
        with h5py.File(raw, "w", libver=FORMAT) as file:
            yield file
        raw.require()


def store(group: h5py.Group, name: str, values: NDArray[Any]) -> None:
    """Store an array with checksums; no elements have none."""
    group.create_dataset(name, data=values, fletcher32=values.size > 0)


def room(
    group: h5py.Group, name: str, shape: tuple[int, ...], dtype: np.dtype[Any], rows: int
) -> h5py.Dataset:
    """A data set with checksums, for an array whose rows will be written.

    Args:
        group: to make it in.
        name: of the data set.
        shape: of the array.
        dtype: of its elements.
        rows: that a checksum is for, at most; what is written is best a multiple of these.
    """
    if 0 in shape:
        return group.create_dataset(name, shape, dtype)
    chunk = (min(rows, shape[0]), *shape[1:])
    return group.create_dataset(name, shape, dtype, chunks=chunk, fletcher32=True)


def read_fault(error: Exception) -> str:
    """Say why HDF5 cannot read something, which calls a wrong checksum a failure of a filter."""
    return "damaged values" if "filter returned failure" in str(error) else str(error)


def require_own(path: Path, file: h5py.File) -> None:
    """Check that all that is in a file is in it: it could name a pipe, or a file of others.

    Raises:
        OutputError: if it is not.
    """

    def look(name: str, link: object) -> str | None:
        return None if isinstance(link, h5py.HardLink) else name

    if (name := file.visititems_links(look)) is not None:
        raise OutputError(f"{path}: expected arrays of a run, found {name!r}, which is elsewhere")
