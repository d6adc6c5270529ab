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
from fretfe.evaluate.contacts import Station
from fretfe.files import replacing
from fretfe.results.hdf5_file import new_hdf5, read_fault, require_own, store

STATION_STRESSES = "station_stress.h5"
SCHEMA = {"name": "fretfe-station-stress", "version": 2}
ARRAYS = ("depths", "states", "numbers", "mouths", "places", "stress")


# Elements above which the stress of elements is not used: half of the least largest depth.
SHALLOW = 2.0
# Largest depth over the smaller of the contact's half-width and the radius of the front.
PART_OF_WIDTH = 0.4
ROWS = 5


def station_depths(station: Station) -> Array:
    """(D,) depths at which the stress of elements around a station tells what bodies add.

    Shallower the stress is that of tractions between nodes. Deeper the bend of the front is no
    polynomial any more: on a sphere its error grows from 0.7 % of p0 with depths to 0.35 a to 2 and
    5 % with 0.8 and 2 a, of which a residual does not tell.
    """
    curved = abs(station.curvature)
    width = min(station.depth, 1 / curved if curved > 0 else station.depth)
    deepest = max(PART_OF_WIDTH * width, 2 * SHALLOW * station.size)
    return np.linspace(SHALLOW * station.size, deepest, ROWS)


@dataclass(frozen=True)
class StationStress:
    """Stress around the stations of the fronts of a contact, by elements.

    Attributes:
        contact: its name.
        depths: (S, D) below the surfaces, as of `station_depths` [length].
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
