# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of solids around the stations of their fronts through the evaluated cycle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.contact.recorder import Recorder
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.loaded import loaded
from fretfe.evaluate.stress import ROWS, judged_states, station_depths
from fretfe.fem.elasticity import stress_pairs
from fretfe.fem.fields import FieldSource, common_modes
from fretfe.fem.model import Model
from fretfe.fem.probes import state_requests
from fretfe.fem.stress_output import below
from fretfe.files import writing
from fretfe.history.solution import ContactHistory, Solution
from fretfe.results.station_stress import (
    STATION_STRESSES,
    StationStress,
    write_station_stress,
)


@dataclass(frozen=True)
class _Site:
    """The stations of a contact, and where the stress around them is looked at.

    Attributes:
        contact: its name.
        bodies: names of body 1 and 2.
        stations: (S,) those whose place is known in all states with contact.
        depths, mouths, places: as of `StationStress`.
        points: (2, D, S, X, 3) in both bodies; NaN beside them.
        axes: (2, S, X, 3, 3) along the surface inward, the outward normal, along the front.
    """

    contact: str
    bodies: tuple[str, str]
    stations: tuple[Station, ...]
    depths: Array
    mouths: Array
    places: Array
    points: Array
    axes: Array

    @classmethod
    def of(cls, model: Model, contact: Contact, pair: ContactHistory, states: Indices) -> _Site:
        """That of a contact."""
        carrying = states[loaded(contact.normal_force)[states]]
        stations = tuple(
            each
            for each in contact.stations
            if not each.no_edge and np.isfinite(each.position[carrying]).all()
        )
        table = model.case.contacts[contact.pair]
        mouths = np.array([each.position[carrying].min() for each in stations])
        # As far to both sides as the stress is looked at in depth.
        depths = np.array([station_depths(each) for each in stations]).reshape(-1, ROWS)
        deepest = depths[:, -1]
        places = deepest[:, None] * np.linspace(-1, 1, 17)
        inward, along = (
            np.array([getattr(each.frame, name) for each in stations]).reshape(-1, 1, 3)
            for name in ("inward", "along")
        )
        points = np.array([each.point for each in stations]).reshape(-1, 1, 3)
        points = points + (mouths.reshape(-1, 1) + places)[..., None] * inward
        shape, found, axes = points.shape, [], []
        for name in (table.surface1, table.surface2):
            # The body goes on where its part that may touch ends, and cracks go there.
            flat, beside = points.reshape(-1, 3), np.repeat(deepest, shape[1])
            at, normals = below(model.surfaces[name], flat, np.zeros(1), beside)
            normals = normals.reshape(shape)
            ahead = inward - np.sum(inward * normals, axis=2, keepdims=True) * normals
            ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
            third = np.cross(normals, ahead)
            third *= np.sign(np.sum(third * along, axis=2, keepdims=True))
            found.append(at.reshape(shape) - depths.T[..., None, None] * normals)
            axes.append(np.stack([ahead, normals, third], axis=2))
        return cls(
            contact.pair, (pair.body1, pair.body2), stations, depths, mouths, places,
            np.array(found), np.array(axes),
        )  # fmt: skip

    def turned(self, modes: Array, number: int, shares: Array) -> Array:
        """(S, n, D, X, 6) stress of a body in all states, in the axes of the stations.

        Args:
            modes: (r, D * S * X, 6) stress by common fields.
            number: of the body, 0 or 1.
            shares: (r, n) of these fields in the states.
        """
        tensors = np.empty((*modes.shape[:2], 3, 3))
        for place, (i, j) in enumerate(stress_pairs(3)):
            tensors[..., i, j] = tensors[..., j, i] = modes[..., place]
        tensors = tensors.reshape(len(modes), *self.points.shape[1:4], 3, 3)
        own = np.einsum("sxai,rdsxij,sxbj->srdxab", *(
            self.axes[number], tensors, self.axes[number]
        ), optimize=True)  # fmt: skip
        by_state = np.einsum("rn,srdxab->sndxab", shares, own)
        return np.stack([by_state[..., i, j] for i, j in stress_pairs(3)], axis=-1)


def write_stations(
    model: Model,
    fields: FieldSource,
    recorder: Recorder,
    solution: Solution,
    contacts: Sequence[Contact],
    path: Path,
) -> None:
    """Write the stress around all stations whose place is known, beside a file; on rank 0.

    Displacements of all states are combinations of those of a few.

    Args:
        model: solids.
        fields: answers with stress.
        recorder: holds the solved states.
        solution: the same states.
        contacts: their evaluation.
        path: of the file of plane bodies.

    Raises:
        OutputError: if the file cannot be written.
    """
    states = judged_states(solution, contacts)
    sites = [
        _Site.of(model, each, pair, states)
        for each in contacts
        for pair in solution.contacts
        if pair.pair == each.pair
    ]
    requests = state_requests(recorder, [int(each) for each in states])
    modes, shares = common_modes(requests, model.reduction.interface.compliance)
    places = {
        (site.contact, number): (name, site.points[number].reshape(-1, 3))
        for site in sites
        if site.stations
        for number, name in enumerate(site.bodies)
    }
    at_once = fields.states_at_once()
    parts = [
        inner
        for first in range(0, len(modes) if places else 0, at_once)
        for _, inner in fields.stress(places, modes[first : first + at_once])
    ]
    found = [
        StationStress(
            contact=site.contact,
            depths=site.depths,
            states=states,
            fronts=tuple(each.front for each in site.stations),
            numbers=np.array([each.number for each in site.stations], dtype=np.int64),
            mouths=site.mouths,
            places=site.places,
            stress=_stress(site, parts, shares),
        )
        for site in sites
    ]
    file = path.with_name(STATION_STRESSES)
    with writing(file, "the stress at stations"):
        write_station_stress(file, found)


def _stress(site: _Site, parts: Sequence[Mapping[tuple[str, int], Array]], shares: Array) -> Array:
    """As of `StationStress`; empty without stations."""
    if not site.stations:
        return np.zeros((2, 0, shares.shape[1], *site.points.shape[1:2], site.places.shape[1], 6))
    modes = [np.array([part[site.contact, number] for part in parts]) for number in (0, 1)]
    return np.array([site.turned(each, number, shares) for number, each in enumerate(modes)])
