# SPDX-License-Identifier: LGPL-3.0-or-later
"""New HDF5 files with checksums, on disks that may be full; the one with the stress near contacts.

HDF5 ends the process if it cannot write what it still has when a file is closed. So it never learns
that a disk is full: what does not fit stays in memory until the file is closed or given up.

All that is in a file has checksums, of which HDF5 looks at those of what it reads: the values as
`store` and `room` write them, the rest by the version of the format.

The stress of the bodies near their contacts is written state by state; docs/results-files.md has
the schema.
"""

from __future__ import annotations

import contextlib
import io
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.evaluate.stress import BodyStress, EdgeStress, StressHistory
from fretfe.files import open_own, replacing

# The first version whose headers and indices have checksums and that is short for small arrays.
FORMAT = "v110"
STRESSES = "stress.h5"
SCHEMA = {"name": "fretfe-stress", "version": 1}
# Components of a stress by those of the displacement.
TENSOR = {2: 4, 3: 6}
# Rows of a data set that a checksum is for.
ROWS = 1


class PatientFile(io.FileIO):
    """A new file whose writes never fail; `require` tells that one did.

    Args:
        path: of the file.

    Raises:
        OSError: if it cannot be made.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, "w+", opener=open_own)
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
def new_hdf5(path: Path, schema: Mapping[str, Any]) -> Iterator[h5py.File]:
    """A new HDF5 file of a schema, which has a name and a version.

    Raises:
        OSError: if it cannot be written.
    """
    with PatientFile(path) as raw:
        with h5py.File(raw, "w", libver=FORMAT) as file:
            file.attrs.update({"schema": schema["name"], "version": schema["version"]})
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


def require_own(path: Path, file: h5py.File, schema: Mapping[str, Any]) -> None:
    """Check that all that is in a file is in it, and is of a schema.

    It could name a pipe, or a file of others.

    Raises:
        OutputError: if it is not.
    """

    def look(name: str, link: object) -> str | None:
        return None if isinstance(link, h5py.HardLink) else name

    if (name := file.visititems_links(look)) is not None:
        raise OutputError(f"{path}: expected arrays of a run, found {name!r}, which is elsewhere")
    found = {"name": file.attrs.get("schema"), "version": file.attrs.get("version")}
    if found != schema:
        raise OutputError(f"{path}: expected schema {schema}, found {found}")


@dataclass(frozen=True)
class StressSite:
    """Places at which the stress of a contact is written; as of `StressHistory`.

    Attributes:
        contact: its name.
        arc: (N,).
        frames: (N, d, d).
        bodies: names of body 1 and 2.
        points: (2, D, N, d) places in both bodies.
        normals: (2, N, d).
        edges: contact, edge and body of each edge value.
    """

    contact: str
    arc: Array
    frames: Array
    bodies: tuple[str, str]
    points: Array
    normals: Array
    edges: Sequence[tuple[str, str, str]]


class StressWriter:
    """Takes the stress of one state after the other; the file is there when it is closed.

    Args:
        path: of the file.
        depths: (D,).
        states: (n,) numbers of the states that will be written.
        times: (n,) their times.
        sites: the contacts.

    Raises:
        OSError: if the file cannot be written; so do all methods.
    """

    def __init__(
        self, path: Path, depths: Array, states: Indices, times: Array, sites: Sequence[StressSite]
    ) -> None:
        self._stack, self._row = ExitStack(), 0
        with ExitStack() as stack:
            new = stack.enter_context(replacing(path))
            self._file = stack.enter_context(new_hdf5(new, SCHEMA))
            for name, values in (("depths", depths), ("states", states), ("times", times)):
                store(self._file, name, values)
            for site in sites:
                _make_room(self._file.create_group(f"contacts/{site.contact}"), site, len(states))
            self._stack = stack.pop_all()

    def close(self, reasons: Mapping[str, Sequence[str]]) -> None:
        """Finish the file; after an error there is none.

        Args:
            reasons: for each contact and edge value why it is mostly not known, or an empty text.
        """
        for contact, texts in reasons.items():
            self._file[f"contacts/{contact}"].attrs["edge_reasons"] = list(texts)
        self._stack.close()

    def add(self, values: Mapping[str, Mapping[str, Any]]) -> None:
        """Write a state.

        Args:
            values: for each contact `traction`, `slip`, `status`, `stress` (2, D, N, k) and, (e,),
                `edge_stress`, `edge_spread`, `edge_near`, of one state of a `StressHistory`.
        """
        for contact, tables in values.items():
            for name, table in tables.items():
                self._file[f"contacts/{contact}/{name}"][self._row] = table
        self._row += 1


def _make_room(group: h5py.Group, site: StressSite, count: int) -> None:
    group.attrs["bodies"] = list(site.bodies)
    names = np.array(site.edges, dtype=object).reshape(-1, 3)
    for name, column in zip(("edge_contacts", "edges", "edge_bodies"), names.T, strict=True):
        group.attrs[name] = list(column)
    for name in ("arc", "frames", "points", "normals"):
        store(group, name, getattr(site, name))
    nodes, depths = len(site.arc), site.points.shape[1]
    size = site.frames.shape[1]
    for name, shape, kind in (
        ("traction", (nodes, size), float),
        ("slip", (nodes, 2)[: size - 1], float),
        ("status", (nodes,), np.int8),
        ("stress", (2, depths, nodes, TENSOR[size]), float),
        ("edge_stress", (len(names),), float),
        ("edge_spread", (len(names),), float),
        ("edge_near", (len(names),), float),
    ):
        room(group, name, (count, *shape), np.dtype(kind), ROWS)


def read_stress(directory: Path, contact: str) -> StressHistory:
    """Read the stress near a contact from a results folder.

    Raises:
        OutputError: if there is no such file or contact, or it cannot be read.
    """
    path = directory / STRESSES
    if not path.is_file():
        raise OutputError(
            f"{path}: expected the stress near the contacts, found no such file: run the case with "
            "the backend fem and [output] stress_depths"
        )
    try:
        with h5py.File(path, "r") as file:
            require_own(path, file, SCHEMA)
            if contact not in file["contacts"]:
                known = ", ".join(file["contacts"])
                raise OutputError(
                    f"{path}: expected one of the contacts {known}, found {contact!r}"
                )
            return _read(file, contact)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, IndexError) as error:
        raise OutputError(
            f"{path}: expected the stress near the contacts, found: {read_fault(error)}"
        ) from error


def _read(file: h5py.File, contact: str) -> StressHistory:
    group = file[f"contacts/{contact}"]
    stress, points, normals = (group[name][:] for name in ("stress", "points", "normals"))
    names = [
        [str(each) for each in group.attrs[n]]
        for n in ("edge_contacts", "edges", "edge_bodies", "edge_reasons")
    ]
    edges = [group[name][:].T for name in ("edge_stress", "edge_spread")]
    # Files of earlier versions do not tell what is near the edges.
    near = group["edge_near"][:].T if "edge_near" in group else np.full_like(edges[0], np.nan)
    edges.append(near)
    size = TENSOR[group["frames"].shape[1]]
    shape = len(file["states"]), 2, len(file["depths"]), len(group["arc"]), size
    if stress.shape != shape:
        raise ValueError(f"stress of the shape {stress.shape} in place of {shape}")
    bodies = [
        BodyStress(str(name), points[i], normals[i], stress[:, i])
        for i, name in enumerate(group.attrs["bodies"])
    ]
    return StressHistory(
        contact=contact,
        depths=file["depths"][:],
        states=file["states"][:],
        times=file["times"][:],
        **{name: group[name][:] for name in ("arc", "frames", "traction", "slip", "status")},
        bodies=(bodies[0], bodies[1]),
        edges=tuple(
            EdgeStress(of, edge, body, value, spread, near, reason)
            for of, edge, body, value, spread, near, reason in zip(
                *names[:3], *edges, names[3], strict=True
            )
        ),
    )
