# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fields over the bodies, and tractions on contact surfaces of solids: a file each, as VTKHDF."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.history.solution import ContactHistory, Solution
from fretfe.results.hdf5_file import read_fault
from fretfe.results.vtkhdf import Column, GridWriter, Part

# The ending by which PyVista knows the format.
SURFACES = "contacts.hdf"
# VTK's number of a facet, by number of nodes.
FACET_TYPES = {3: 5, 4: 9}
CONTACT_COLUMNS = {
    "pressure": Column(),
    "shear": Column(3),
    "slip": Column(3),
    "gap": Column(),
    "status": Column(kind=np.uint8),
    "dissipation": Column(),
}
# PyVista before 0.45 knows the format by this ending only.
FIELDS = "fields.hdf"
# VTK's number of a cell, by dimension and number of nodes.
CELL_TYPES = {
    (2, 3): 5, (2, 4): 9, (2, 6): 22, (2, 9): 28,
    (3, 4): 10, (3, 8): 12, (3, 10): 24, (3, 27): 29,
}  # fmt: skip
# Vectors, and symmetric tensors xx, yy, zz, xy, yz, xz. Displacements of a node recur in the
# elements around it: found in whole numbers only. Stresses do not.
COLUMNS = {"displacement": Column(3, shuffled=False), "stress": Column(6)}


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
        for state in states:
            values = [_values(contact, int(state)) for contact in solution.contacts]
            columns = {name: [each[name] for each in values] for name in CONTACT_COLUMNS}
            writer.add(float(solution.times[state]), columns)


def _contact_part(contact: ContactHistory) -> Part:
    assert contact.facets is not None
    return Part(contact.points, contact.facets, FACET_TYPES[contact.facets.shape[1]])


def _values(contact: ContactHistory, state: int) -> dict[str, Array]:
    """(N, c) values of each column; vectors in the axes of the case, work per area."""
    traction = contact.mean_traction[state]
    scalars = {
        "pressure": traction[:, 0],
        "gap": contact.gap[state],
        "status": contact.status[state],
        "dissipation": contact.dissipation[state] / contact.weights,
    }
    return {
        **{name: np.asarray(values)[:, None] for name, values in scalars.items()},
        "shear": in_space(contact, traction[:, 1:]),
        "slip": in_space(contact, contact.slip[state]),
    }


def in_space(contact: ContactHistory, components: Array) -> Array:
    """(N, 3) vectors in the axes of the case, from components (N, 2) along the tangents."""
    return np.asarray(np.einsum("nt,ntd->nd", components, contact.frames[:, 1:]))


class FieldWriter(GridWriter):
    """Writes "displacement" and "stress" of the bodies state by state.

    Args:
        path: file to write.
        nodes: (m, k, d) by body: places of the k nodes of each of m elements, in VTK's order;
            exactly the same place for a node that elements share.

    Raises:
        OSError: if the file cannot be written; so do all methods.
    """

    def __init__(self, path: Path, nodes: Mapping[str, Array]) -> None:
        super().__init__(path, {name: _part(each) for name, each in nodes.items()}, "body", COLUMNS)


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
            names, cells = body.attrs["names"], np.bincount(body[:])
            ends = self._root["Offsets"][:][np.concatenate([[0], np.cumsum(cells)])]
        except (OSError, KeyError, RuntimeError) as error:
            raise OutputError(
                f"{path}: expected fields of a run, found: {read_fault(error)}"
            ) from error
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
        start = int(self._stored(f"Steps/PointDataOffsets/{name}", slice(number, number + 1))[0])
        return self._read(f"PointData/{name}", body, start).astype(np.float64)

    def _read(self, table: str, body: str, start: int) -> Array:
        first, last, count = self._rows[body]
        values = self._stored(table, slice(start + first, start + last))
        return values.reshape(count, -1, values.shape[-1])

    def _stored(self, table: str, rows: slice) -> Array:
        try:
            values: Array = self._root[table][rows]
        except (OSError, RuntimeError) as error:
            raise OutputError(f"{self._path}: cannot read {table}: {read_fault(error)}") from error
        return values
