# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of both bodies across the fronts of solids, at each station, as a file.

n is the number of states, S that of the stations, D that of the depths, X that of the places across
the front. docs/results-files.md has the schema.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import OutputError
from fretfe.files import replacing
from fretfe.results.hdf5_file import new_hdf5, read_fault, require_own, store

STATION_STRESSES = "station_stress.h5"
SCHEMA = {"name": "fretfe-station-stress", "version": 2}
ARRAYS = ("depths", "states", "numbers", "mouths", "places", "stress")


@dataclass(frozen=True)
class StationStress:
    """Stress around the stations of the fronts of a contact, by elements.

    Attributes:
        contact: its name.
        depths: (S, D) below the surfaces, as of `evaluate.stress.station_depths` [length].
        states: (n,) numbers of the states.
        fronts: (S,) names of the fronts of the stations.
        numbers: (S,) of the stations on them.
        mouths: (S,) outermost place of the front, inward from the point of the station [length].
        places: (S, X) distances from there inward [length].
        stress: (2, S, n, D, X, 6) of body 1 and 2: xx, yy, zz, xy, yz, xz with x along the surface
            inward, y along the outward normal of the body, z along the front; NaN outside [stress].
    """

    contact: str
    depths: Array
    states: Indices
    fronts: tuple[str, ...]
    numbers: Indices
    mouths: Array
    places: Array
    stress: Array

    def row(self, front: str, number: int) -> int | None:
        """Number of a station among these; None if it is not one of them."""
        names = zip(self.fronts, self.numbers.tolist(), strict=True)
        return next((row for row, name in enumerate(names) if name == (front, number)), None)


def write_station_stress(path: Path, found: list[StationStress]) -> None:
    """Write the stress at the stations of all contacts of a run.

    Raises:
        OSError: if the file cannot be written.
    """
    with replacing(path) as new, new_hdf5(new, SCHEMA) as file:
        for each in found:
            group = file.create_group(f"contacts/{each.contact}")
            group.attrs["fronts"] = list(each.fronts)
            for name in ARRAYS:
                values = getattr(each, name)
                store(group, name, values.astype(np.float32) if name == "stress" else values)


def read_station_stress(directory: Path, contact: str) -> StationStress:
    """Read the stress at the stations of a contact from a results folder.

    Raises:
        OutputError: if there is no such file or contact, or it cannot be read.
    """
    path = directory / STATION_STRESSES
    try:
        with h5py.File(path, "r") as file:
            require_own(path, file, SCHEMA)
            return _read(file[f"contacts/{contact}"], contact)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise OutputError(
            f"{path}: expected the stress at the stations of {contact}, found: {read_fault(error)}"
        ) from error


def _read(group: h5py.Group, contact: str) -> StationStress:
    arrays = {name: group[name][:] for name in ARRAYS}
    fronts = tuple(str(each) for each in group.attrs["fronts"])
    (count, depths), (_, places) = arrays["depths"].shape, arrays["places"].shape
    expected = (2, count, len(arrays["states"]), depths, places, 6)
    if arrays["stress"].shape != expected or not count == len(arrays["numbers"]) == len(fronts):
        raise ValueError(f"stress of the shape {arrays['stress'].shape} in place of {expected}")
    arrays["stress"] = arrays["stress"].astype(np.float64)
    return StationStress(contact=contact, fronts=fronts, **arrays)
