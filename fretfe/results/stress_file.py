# SPDX-License-Identifier: LGPL-3.0-or-later
"""One file with the stress of the bodies near their contacts, state by state.

The schema is described in docs/results.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.evaluate.stress import BodyStress, EdgeStress, StressHistory
from fretfe.files import replacing
from fretfe.results.hdf5_file import new_hdf5, read_fault, require_own, room, store

STRESSES = "stress.h5"
SCHEMA = {"name": "fretfe-stress", "version": 1}
# Rows of a data set that a checksum is for.
ROWS = 1


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
            self._file = stack.enter_context(new_hdf5(new))
            self._file.attrs.update({"schema": SCHEMA["name"], "version": SCHEMA["version"]})
            for name, values in (("depths", depths), ("states", states), ("times", times)):
                store(self._file, name, values)
            for site in sites:
                _make_room(self._file.create_group(f"contacts/{site.contact}"), site, len(states))
            self._stack = stack.pop_all()

    def close(self, reasons: Mapping[str, Sequence[str]]) -> None:
        """Finish the file; after an error there is none.

        Args:
            reasons: for each contact and edge value why it is never known, or an empty text.
        """
        for contact, texts in reasons.items():
            self._file[f"contacts/{contact}"].attrs["edge_reasons"] = list(texts)
        self._stack.close()

    def add(self, values: Mapping[str, Mapping[str, Any]]) -> None:
        """Write a state.

        Args:
            values: for each contact: `traction` (N, 2), `slip` (N,), `status` (N,), `stress`
                (2, D, N, 4), `edge_stress` (e,) and `edge_spread` (e,).
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
    for name, shape, kind in (
        ("traction", (nodes, 2), float),
        ("slip", (nodes,), float),
        ("status", (nodes,), np.int8),
        ("stress", (2, depths, nodes, 4), float),
        ("edge_stress", (len(names),), float),
        ("edge_spread", (len(names),), float),
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
            require_own(path, file)
            found = {"name": file.attrs.get("schema"), "version": file.attrs.get("version")}
            if found != SCHEMA:
                raise OutputError(f"{path}: expected schema {SCHEMA}, found {found}")
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
    values, spreads = group["edge_stress"][:], group["edge_spread"][:]
    shape = len(file["states"]), 2, len(file["depths"]), len(group["arc"]), 4
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
            EdgeStress(of, edge, body, values[:, i], spreads[:, i], reason)
            for i, (of, edge, body, reason) in enumerate(zip(*names, strict=True))
        ),
    )
