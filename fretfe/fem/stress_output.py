# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of plane bodies near their contacts through the evaluated cycle."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.case import IS_CRYSTAL, isotropic
from fretfe.contact.recorder import Recorder
from fretfe.errors import OutputError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.stress import judged_states, tension
from fretfe.evaluate.surface_stress import (
    EdgeValue,
    SurfaceLaw,
    SurfaceStrain,
    along_surface,
    edge_stress,
    near_edge,
)
from fretfe.fem.elasticity import stress_pairs
from fretfe.fem.fields import FieldSource, Places
from fretfe.fem.model import Model
from fretfe.fem.probes import state_requests
from fretfe.files import disk_reason
from fretfe.history.solution import ContactHistory, Solution
from fretfe.results.hdf5_file import StressSite, StressWriter
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.surface import Surface

# A contact node is above the other surface if the nearest place of that is no farther away along
# the surface than this part of the largest facet.
BESIDE = 0.5
# Least depth over the size of an element, but for what sizes differ from those asked for.
SHALLOWEST = 0.95
# Elements beside an edge in which that counts.
NEAR_EDGE = 2.0


@dataclass(frozen=True)
class _Site:
    """A contact with its patches, and the surfaces of its bodies.

    Attributes:
        patches: of the contact.
        summaries: of the patches.
        surfaces: of body 1 and body 2.
        strains: along them.
        initial: (l, g, 3) initial strains there by a unit of each load: tt, zz, 2 tz.
        laws: of the bodies at their surfaces.
        depths: at which the stress is looked at.
        place: what the file knows of the contact.
    """

    patches: tuple[ContactHistory, ...]
    summaries: tuple[Contact, ...]
    surfaces: tuple[Surface, Surface]
    strains: tuple[SurfaceStrain, SurfaceStrain]
    initial: tuple[Array, Array]
    laws: tuple[SurfaceLaw, SurfaceLaw]
    depths: Array
    place: StressSite

    @property
    def contact(self) -> str:
        """Its name in the case."""
        return self.place.contact

    @property
    def edges(self) -> Iterator[tuple[ContactHistory, Station, int]]:
        """Patch, station and number of the body of each edge value."""
        for patch, summary in zip(self.patches, self.summaries, strict=True):
            for station in summary.edges:
                for body in (0, 1):
                    yield patch, station, body


def write_stress(
    model: Model,
    fields: FieldSource,
    recorder: Recorder,
    solution: Solution,
    contacts: Sequence[Contact],
    path: Path,
) -> None:
    """Write the stress near all contacts; on rank 0.

    Args:
        model: plane bodies.
        fields: answers with displacements and stress.
        recorder: holds the solved states.
        solution: the same states.
        contacts: their evaluation.
        path: of the file.

    Raises:
        OutputError: if the file cannot be written.
    """
    writer = _Writer(model, solution, contacts, path)
    writer.open()
    length = fields.states_at_once()
    for start in range(0, len(writer.states), length):
        block = [int(each) for each in writer.states[start : start + length]]
        requests = state_requests(recorder, block)
        found = fields.stress(writer.places, requests)
        for state, request, (moved, inner) in zip(block, requests, found, strict=True):
            writer.add(state, request.amplitudes, moved, inner)
    writer.close()


class _Writer:
    """Places, the stress at the surface, the file."""

    def __init__(
        self, model: Model, solution: Solution, contacts: Sequence[Contact], path: Path
    ) -> None:
        self._case, self._path, self._solution = model.case, path, solution
        self._depths = np.array(model.case.output.stress_depths)
        self._components = len(stress_pairs(model.components))
        summaries = {each.name: each for each in contacts}
        self.states = judged_states(solution, contacts)
        self._sites = [
            _site(model, tuple(patches), summaries, self._depths, self.states)
            for _, patches in groupby(solution.contacts, key=lambda each: each.pair)
        ]
        self._reasons: dict[str, list[Counter[str]]] = {
            site.contact: [Counter() for _ in site.edges] for site in self._sites
        }

    @property
    def places(self) -> Places:
        """Points below the surfaces (m, d), by contact and number of the body."""
        below = self._depths > 0
        return {
            (site.contact, number): (name, site.place.points[number][below].reshape(-1, 2))
            for site in self._sites
            for number, name in enumerate(site.place.bodies)
        }

    def open(self) -> None:
        """Begin the file."""
        times = self._solution.times[self.states]
        try:
            self._file = StressWriter(
                self._path, self._depths, self.states, times, [site.place for site in self._sites]
            )
        except OSError as error:
            raise self._error(error) from error

    def add(
        self,
        state: int,
        amplitudes: Array,
        moved: dict[str, Array],
        inner: dict[tuple[str, int], Array],
    ) -> None:
        """Write a state.

        Args:
            state: its number.
            amplitudes: (l,) of the distributed loads.
            moved: displacements of all surfaces.
            inner: stress at `places`.
        """
        self._file.add(
            {
                site.contact: self._values(site, state, amplitudes, moved, inner)
                for site in self._sites
            }
        )

    def close(self) -> None:
        """Finish the file."""
        reasons = {
            contact: [count.most_common(1)[0][0] if count else "" for count in counts]
            for contact, counts in self._reasons.items()
        }
        try:
            self._file.close(reasons)
        except OSError as error:
            raise self._error(error) from error

    def _values(
        self,
        site: _Site,
        state: int,
        amplitudes: Array,
        moved: dict[str, Array],
        inner: dict[tuple[str, int], Array],
    ) -> dict[str, Any]:
        """Values of a state at a contact; as of `StressWriter.add`."""
        first = site.patches[0]
        traction: Array = np.sum([each.mean_traction[state] for each in site.patches], axis=0)
        status = np.max([each.status[state] for each in site.patches], axis=0)
        size, below = self._components, self._depths > 0
        nodes = len(first.surface.arc)
        stress = np.full((2, len(self._depths), nodes, size), np.nan)
        smooth = []
        for number, (surface, strain) in enumerate(zip(site.surfaces, site.strains, strict=True)):
            law = site.laws[number]
            found = strain.values(moved[surface.name])
            found -= np.tensordot(amplitudes, site.initial[number], axes=1)
            tractions, frames = _at(first, strain.arc, traction)
            own = tension(law.stress(found, tractions, frames), frames[:, 1])
            smooth.append(own + tractions[:, 0])
            stress[number, below] = inner[site.contact, number].reshape(-1, nodes, size)
            if not below.all():
                at_nodes = _interpolated(first.surface.arc, strain.arc, found)
                at_surface = law.stress(at_nodes, traction, first.surface.frames)
                stress[number, ~below] = at_surface[:, :size]
        slip = np.asarray(first.slip[state])
        edges = [self._edge(site, state, smooth, *edge) for edge in site.edges]
        for count, (each, _) in zip(self._reasons[site.contact], edges, strict=True):
            count.update([each.reason] if each.reason else [])
        return {
            "traction": traction,
            "slip": slip if slip.shape[1] > 1 else slip[:, 0],
            "status": status,
            "stress": stress,
            "edge_stress": [each.value for each, _ in edges],
            "edge_spread": [each.spread for each, _ in edges],
            "edge_near": [near for _, near in edges],
        }

    def _edge(
        self,
        site: _Site,
        state: int,
        smooth: list[Array],
        patch: ContactHistory,
        station: Station,
        body: int,
    ) -> tuple[EdgeValue, float]:
        if isotropic(self._case.bodies[site.place.bodies[body]]) is None:
            # Pressure alone does not make sigma_t = -p: there is another singular part.
            return EdgeValue(np.nan, np.nan, IS_CRYSTAL), np.nan
        arc, inward = site.strains[body].arc, station.inward
        edge = arc, smooth[body], float(station.position[state]), inward, patch.surface.arc
        return edge_stress(*edge, np.asarray(patch.status[state])), near_edge(*edge)

    def _error(self, error: OSError) -> OutputError:
        return OutputError(
            f"{self._path}: the stress near the contacts cannot be written: {disk_reason(error)}"
        )


def _site(
    model: Model,
    patches: tuple[ContactHistory, ...],
    summaries: dict[str, Contact],
    depths: Array,
    states: Indices,
) -> _Site:
    """A contact and where the stress around it is looked at."""
    pair = patches[0]
    contact = model.case.contacts[pair.pair]
    surfaces = model.surfaces[contact.surface1], model.surfaces[contact.surface2]
    seen = [
        below(surface, pair.surface.points, depths, BESIDE * surface.sizes.max())
        for surface in surfaces
    ]
    own = tuple(summaries[each.name] for each in patches)
    bodies = pair.body1, pair.body2
    edges = [
        (summary.name, station.front, body)
        for summary in own
        for station in summary.stations
        for body in bodies
    ]
    points, normals = (np.array(each) for each in zip(*seen, strict=True))
    places = np.array([station.position[states] for each in own for station in each.stations])
    for each, surface in zip(points, surfaces, strict=True):
        if len(places):
            each[untold(surface, pair.surface, depths, places)] = np.nan
    degree = model.case.model.degree
    strains = [SurfaceStrain.of(surface, degree, pair.surface) for surface in surfaces]
    laws = [SurfaceLaw.of(model.case.bodies[name], model.case.model.plane) for name in bodies]
    initial = [_initial_strains(model, *each) for each in zip(bodies, strains, strict=True)]
    arc, frames = pair.surface.arc, pair.surface.frames
    place = StressSite(pair.pair, arc, frames, bodies, points, normals, edges)
    return _Site(
        patches,
        own,
        surfaces,
        (strains[0], strains[1]),
        (initial[0], initial[1]),
        (laws[0], laws[1]),
        depths,
        place,
    )


def _at(contact: ContactHistory, arc: Array, traction: Array) -> tuple[Array, Array]:
    """(g, c) p, q, q_z, and (g, c, c) normal, tangent, z, at places (g,) along the arc."""
    size = traction.shape[1]
    values = np.concatenate([traction, contact.surface.frames.reshape(-1, size**2)], axis=1)
    found = np.stack([np.interp(arc, contact.surface.arc, each) for each in values.T], axis=1)
    frames = found[:, size:].reshape(-1, size, size)
    return found[:, :size], frames / np.linalg.norm(frames, axis=2, keepdims=True)


def _interpolated(arc: Array, places: Array, values: Array) -> Array:
    """(N, k) values (g, k) at places (g,) along the arc, NaN beyond their ends."""
    parts = [np.interp(arc, places, each, left=np.nan, right=np.nan) for each in values.T]
    return np.stack(parts, axis=1)


def _initial_strains(model: Model, body: str, strain: SurfaceStrain) -> Array:
    """(l, g, 3) initial strains at a surface, as of `_Site`."""
    loads, material = model.reduction.definition.loads, model.body_definition(body).material
    found = np.zeros((len(loads), len(strain.arc), 3))
    for own, load in zip(found, loads, strict=True):
        if load.strains(body):
            initial = load.initial_strain(body, material, strain.places)
            own[:] = along_surface(initial, strain.tangents)
    return found


def below(
    surface: Surface, points: Array, depths: Array, beside: float | Array
) -> tuple[Array, Array]:
    """Places (D, N, d) at depths below a surface, and (N, d) outward normals; next to points.

    NaN where the surface ends farther before a point than `beside`, of all or of each (N,).
    """
    nearest, normals = surface.nearest(points)
    # Places are samples: the surface is their tangent plane.
    across = np.sum(normals * (nearest - points), axis=1, keepdims=True)
    places = points + across * normals
    places[np.linalg.norm(places - nearest, axis=1) > beside] = np.nan
    return places - depths[:, None, None] * normals, normals


def untold(surface: Surface, pair: ContactSurface, depths: Array, edges: Array) -> Bools:
    """(D, N) places inside of the outermost elements and next to an edge.

    Tractions end there, and the stress is as much a matter of the mesh.

    Args:
        surface: of the body.
        pair: nodes of the contact.
        depths: (D,).
        edges: (e, n) places of all edges along the arc; NaN where there is none.
    """
    size = surface.sizes[cKDTree(surface.nodes.mean(axis=1)).query(pair.points)[1]]
    known = edges[np.isfinite(edges).any(axis=1)]
    low, high = np.nanmin(known, axis=1), np.nanmax(known, axis=1)
    arc, aside = pair.arc[:, None], NEAR_EDGE * size[:, None]
    beside = ((arc > low - aside) & (arc < high + aside)).any(axis=1)
    shallow = (depths[:, None] > 0) & (depths[:, None] < SHALLOWEST * size)
    return np.asarray(shallow & beside)
