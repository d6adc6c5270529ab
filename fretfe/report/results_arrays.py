# SPDX-License-Identifier: LGPL-3.0-or-later
"""What pictures need of `results.h5`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import numpy.typing as npt

from fretfe._typing import Array
from fretfe.errors import OutputError
from fretfe.results.reader import StoredBody, read_body
from fretfe.results.writer import ARRAYS


@dataclass(frozen=True)
class StoredContact:
    """A contact; see `ContactHistory` for attributes of the same name."""

    body1: str
    body2: str
    arc: Array
    points: Array
    frames: Array
    weights: Array
    gap: Array
    slip: Array
    status: npt.NDArray[np.int8]


@dataclass(frozen=True)
class StoredArrays:
    """Bodies and contacts by name."""

    bodies: dict[str, StoredBody]
    contacts: dict[str, StoredContact]


def read_arrays(directory: Path) -> StoredArrays:
    """Read the arrays of a run.

    Raises:
        OutputError: if they are missing or are not those of a run.
    """
    path = directory / ARRAYS
    try:
        with h5py.File(path) as file:
            bodies = {name: read_body(group) for name, group in file.get("mesh", {}).items()}
            contacts = {name: _read_contact(group) for name, group in file["contacts"].items()}
    except (OSError, KeyError) as error:
        raise OutputError(f"{path}: expected the arrays of a run, found: {error}") from error
    return StoredArrays(bodies, contacts)


def _read_contact(group: h5py.Group) -> StoredContact:
    names = ("arc", "points", "frames", "weights", "gap", "slip", "status")
    arrays = {name: group[name][:] for name in names}
    return StoredContact(str(group.attrs["body1"]), str(group.attrs["body2"]), **arrays)
