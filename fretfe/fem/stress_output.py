# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of plane bodies near their contacts through the evaluated cycle. Collective."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from dolfinx import fem
from scipy import sparse

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.body import Material
from fretfe.case import Body, Case
from fretfe.case.tables import Plane
from fretfe.contact.recorder import Recorder
from fretfe.errors import CaseError, OutputError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.plane.section import plane_front
from fretfe.evaluate.stress import judged_states
from fretfe.evaluate.surface_stress import (
    EdgeValue,
    SurfaceStrain,
    edge_stress,
    surface_tensor,
    tangential_stress,
)
from fretfe.fem._compat import cells_around
from fretfe.fem.elasticity import COMPONENTS, ElasticBody
from fretfe.fem.model import Model
from fretfe.fem.parallel import on_root
from fretfe.fem.probes import state_requests
from fretfe.files import disk_reason
from fretfe.history.solution import ContactHistory, Solution
from fretfe.results.stress_file import StressSite, StressWriter
from fretfe.surface.surface import Surface

# Of a plane body: xx, yy, zz, xy, which is what `ElasticBody.element_stresses` has.
IN_PLANE = ((0, 0), (1, 1), (2, 2), (0, 1))
# Reference coordinates may leave an element by this much; bounding boxes grow by this part.
TOLERANCE = 1e-8
NEWTON_STEPS = 12
# Bytes of the displacements that are recovered together.
MOST_BYTES = 1 << 26
# A contact node is above the other surface if the nearest place of that is no farther away along
# the surface than this part of the largest facet.
BESIDE = 0.5

Places = dict[tuple[str, int], tuple[str, Array]]


class StressPoints:
    """Stress at those of some points that lie in this rank's elements.

    Args:
        elastic: the body.
        points: (m, d) places, the same on all ranks of the body.

    Attributes:
        found: (f,) numbers of the points that this rank has.
    """

    def __init__(self, elastic: ElasticBody, points: Array) -> None:
        self._pairs = IN_PLANE if elastic.gdim == 2 else COMPONENTS
        cells, reference, self.found = _locate(elastic, points)
        self._operator = _operator(elastic, cells, reference, self._pairs)

    def stress(self, displacement: fem.Function) -> Array:
        """(f, 4 or 6) stress xx, yy, zz, xy, yz, xz of a displacement, that of the element."""
        values = self._operator @ displacement.x.array
        return np.asarray(values.reshape(len(self.found), len(self._pairs)))


def _locate(elastic: ElasticBody, points: Array) -> tuple[Indices, Array, Indices]:
    """Own elements (f,), reference coordinates (f, d) in them, and numbers (f,) of points."""
    mesh, space = elastic.mesh, _geometry(elastic)
    dim = mesh.topology.dim
    own = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    extent = float(np.nanmax(np.abs(points), initial=0.0))
    places = np.zeros((len(points), 3))
    places[:, :dim] = points
    cells, numbers = cells_around(mesh, own, places, TOLERANCE * extent)
    nodes = space.tabulate_dof_coordinates()[space.dofmap.list[cells], :dim]
    reference = _pulled_back(space, nodes, points[numbers])
    inside = np.flatnonzero(_inside(elastic, reference))
    # A point on the border of elements is in the first of them.
    found, first = np.unique(numbers[inside], return_index=True)
    chosen = inside[first]
    return cells[chosen].astype(np.int64), reference[chosen], found


def _geometry(elastic: ElasticBody) -> Any:
    """The space in which the places of a body's elements lie."""
    if elastic.order == elastic.degree:
        return elastic.space
    return fem.functionspace(elastic.mesh, ("Lagrange", elastic.order, (elastic.gdim,)))


def _tabulated(space: Any, at: Array) -> tuple[Array, Array]:
    """(n, k) basis functions and their slopes (n, k, d) at reference coordinates (n, d)."""
    if not len(at):
        count = space.element.basix_element.dim
        return np.zeros((0, count)), np.zeros((0, count, at.shape[1]))
    table = space.element.basix_element.tabulate(1, np.ascontiguousarray(at))[..., 0]
    return table[0], np.moveaxis(table[1:], 0, 2)


def _pulled_back(space: Any, nodes: Array, points: Array) -> Array:
    """(n, d) reference coordinates of points (n, d) in elements with nodes (n, k, d), by Newton."""
    at = np.full(points.shape, 1 / (points.shape[1] + 1))
    for _ in range(NEWTON_STEPS):
        values, slopes = _tabulated(space, at)
        missing = points - np.einsum("nk,nkd->nd", values, nodes)
        jacobians = np.einsum("nkd,nke->nde", nodes, slopes)
        # Elements that a point only seems to be in: what is far outside stays there.
        step = np.clip(np.linalg.solve(jacobians, missing[..., None])[..., 0], -1.0, 1.0)
        at = at + step
        if np.abs(step).max(initial=0.0) < TOLERANCE**2:
            break
    return np.asarray(at)


def _inside(elastic: ElasticBody, at: Array) -> Bools:
    """(n,) whether reference coordinates lie in the element."""
    low = (at >= -TOLERANCE).all(axis=1)
    simplex = elastic.mesh.topology.cell_name() in ("triangle", "tetrahedron")
    high = at.sum(axis=1) if simplex else at.max(axis=1, initial=0.0)
    return np.asarray(low & (high <= 1 + TOLERANCE))


def _operator(
    elastic: ElasticBody, cells: Indices, at: Array, pairs: tuple[tuple[int, int], ...]
) -> sparse.csr_matrix:
    """(f * c, n) stress at the points from all displacements of this rank."""
    space, dim = _geometry(elastic), elastic.gdim
    nodes = space.tabulate_dof_coordinates()[space.dofmap.list[cells], :dim]
    jacobians = np.einsum("nkd,nke->nde", nodes, _tabulated(space, at)[1])
    slopes = np.einsum("nke,ned->nkd", _tabulated(elastic.space, at)[1], np.linalg.inv(jacobians))
    rows = np.stack([_row(elastic.material, slopes, pair) for pair in pairs], axis=1)
    unknowns = elastic.space.dofmap.list[cells][..., None] * dim + np.arange(dim)
    count, width = len(cells) * len(pairs), unknowns.shape[1] * dim
    columns = np.repeat(unknowns.reshape(len(cells), width), len(pairs), axis=0)
    indptr = np.arange(count + 1) * width
    shape = count, len(elastic.space.tabulate_dof_coordinates()) * dim
    return sparse.csr_matrix((rows.ravel(), columns.ravel(), indptr), shape=shape)


def _row(material: Material, slopes: Array, pair: tuple[int, int]) -> Array:
    """(n, k, d) factors of a stress component from slopes (n, k, d): Hooke's law."""
    i, j = pair
    row = np.zeros_like(slopes)
    if i == j and not (material.plane == "stress" and i >= slopes.shape[2]):
        row += material.first_lame * slopes
    if max(i, j) < slopes.shape[2]:
        row[..., i] += material.shear_modulus * slopes[..., j]
        row[..., j] += material.shear_modulus * slopes[..., i]
    return row


@dataclass(frozen=True)
class _Site:
    """A contact with its patches, and the surfaces of its bodies; rank 0 only."""

    patches: tuple[ContactHistory, ...]
    summaries: tuple[Contact, ...]
    surfaces: tuple[Surface, Surface]
    strains: tuple[SurfaceStrain, SurfaceStrain]
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
            for station in summary.stations:
                for body in (0, 1):
                    yield patch, station, body


def write_stress(
    model: Model,
    recorder: Recorder | None,
    solution: Solution | None,
    contacts: Sequence[Contact],
    path: Path,
) -> None:
    """Write the stress near all contacts. Collective.

    Args:
        model: plane bodies.
        recorder: holds the solved states; on rank 0, None elsewhere.
        solution: the same states; on rank 0, None elsewhere.
        contacts: their evaluation, on rank 0.
        path: of the file.

    Raises:
        OutputError: if the file cannot be written.
    """
    writer = _Writer(model, solution, contacts, path) if solution is not None else None
    places: Places = model.comm.bcast(writer.places if writer else None)
    states: Indices = model.comm.bcast(writer.states if writer else None)
    points = {
        key: StressPoints(model.bodies[body].elastic, at)
        for key, (body, at) in places.items()
        if body in model.bodies
    }
    on_root(model.comm, lambda: writer.open() if writer else None, share=False)
    length = _states_at_once(model)
    for start in range(0, len(states), length):
        block = [int(each) for each in states[start : start + length]]
        fields = model.recover_fields(state_requests(recorder, block))
        surfaces = model.gather_surfaces(fields)
        for number, field in enumerate(fields):
            inner = _gather(model, places, points, field)
            if writer is not None and surfaces is not None and inner is not None:
                writer.add(block[number], surfaces[number], inner)
    on_root(model.comm, lambda: writer.close() if writer else None, share=False)


def _states_at_once(model: Model) -> int:
    """Number of displacement fields that are held together; the same on all ranks."""
    sizes = [body.elastic.space.dofmap.index_map.size_global for body in model.bodies.values()]
    largest = max(model.comm.allgather(sum(sizes) * model.dimension * 8))
    return int(np.clip(MOST_BYTES // largest, 1, 64))


def _gather(
    model: Model,
    places: Places,
    points: dict[tuple[str, int], StressPoints],
    field: dict[str, fem.Function],
) -> dict[tuple[str, int], Array] | None:
    """(m, 4) stress at the points below the surfaces, NaN outside the bodies; on rank 0."""
    own = {key: (at.found, at.stress(field[places[key][0]])) for key, at in points.items()}
    gathered = model.comm.gather(own)
    if gathered is None:
        return None
    whole = {key: np.full((len(at), 4), np.nan) for key, (_, at) in places.items()}
    for part in gathered:
        for key, (found, values) in part.items():
            whole[key][found] = values
    return whole


class _Writer:
    """The part of rank 0: places, the stress at the surface, the file."""

    def __init__(
        self, model: Model, solution: Solution, contacts: Sequence[Contact], path: Path
    ) -> None:
        self._case, self._path, self._solution = model.case, path, solution
        self._depths = np.array(model.case.output.stress_depths)
        summaries = {each.name: each for each in contacts}
        self._sites = [
            _site(model, tuple(patches), summaries, self._depths)
            for _, patches in groupby(solution.contacts, key=lambda each: each.pair)
        ]
        self.states = judged_states(solution, contacts)
        self._reasons: dict[str, list[Counter[str]]] = {
            site.contact: [Counter() for _ in site.edges] for site in self._sites
        }
        self._known = {site.contact: np.zeros(len(list(site.edges)), bool) for site in self._sites}

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

    def add(self, state: int, moved: dict[str, Array], inner: dict[tuple[str, int], Array]) -> None:
        """Write a state.

        Args:
            state: its number.
            moved: displacements of all surfaces.
            inner: stress at `places`.
        """
        self._file.add(
            {site.contact: self._values(site, state, moved, inner) for site in self._sites}
        )

    def close(self) -> None:
        """Finish the file."""
        reasons = {
            contact: [
                "" if known else count.most_common(1)[0][0]
                for known, count in zip(self._known[contact], counts, strict=True)
            ]
            for contact, counts in self._reasons.items()
        }
        try:
            self._file.close(reasons)
        except OSError as error:
            raise self._error(error) from error

    def _values(
        self, site: _Site, state: int, moved: dict[str, Array], inner: dict[tuple[str, int], Array]
    ) -> dict[str, Any]:
        """Values of a state at a contact; as of `StressWriter.add`."""
        first = site.patches[0]
        traction: Array = np.sum([each.mean_traction[state] for each in site.patches], axis=0)
        status = np.max([each.status[state] for each in site.patches], axis=0)
        stress = np.full((2, len(self._depths), len(first.arc), 4), np.nan)
        smooth = []
        for number, (surface, strain) in enumerate(zip(site.surfaces, site.strains, strict=True)):
            found = strain.values(moved[surface.name])
            own = self._tangential(site, number, strain.arc, found, traction)
            smooth.append(own + np.interp(strain.arc, first.arc, traction[:, 0]))
            below = self._depths > 0
            stress[number, below] = inner[site.contact, number].reshape(-1, len(first.arc), 4)
            if not below.all():
                at_nodes = np.interp(first.arc, strain.arc, found, left=np.nan, right=np.nan)
                tangential = self._tangential(site, number, first.arc, at_nodes, traction)
                stress[number, ~below] = surface_tensor(
                    tangential, traction, first.frames, self._body(site, number), self._plane
                )
        edges = [self._edge(site, state, smooth, *edge) for edge in site.edges]
        self._note(site, edges)
        return {
            "traction": traction,
            "slip": np.asarray(first.slip[state])[:, 0],
            "status": status,
            "stress": stress,
            "edge_stress": [each.value for each in edges],
            "edge_spread": [each.spread for each in edges],
        }

    def _tangential(
        self, site: _Site, number: int, arc: Array, strain: Array, traction: Array
    ) -> Array:
        """Stress along the surface of a body at places along the arc."""
        pressure = np.interp(arc, site.patches[0].arc, traction[:, 0])
        return tangential_stress(strain, pressure, self._body(site, number), self._plane)

    def _edge(
        self,
        site: _Site,
        state: int,
        smooth: list[Array],
        patch: ContactHistory,
        station: Station,
        body: int,
    ) -> EdgeValue:
        return edge_stress(
            site.strains[body].arc,
            smooth[body],
            float(station.position[state]),
            plane_front(station.front).inward,
            patch,
            np.asarray(patch.status[state]),
        )

    def _note(self, site: _Site, edges: list[EdgeValue]) -> None:
        self._known[site.contact] |= [not each.reason for each in edges]
        for count, each in zip(self._reasons[site.contact], edges, strict=True):
            count[each.reason] += bool(each.reason)

    def _body(self, site: _Site, number: int) -> Body:
        return self._case.bodies[site.place.bodies[number]]

    @property
    def _plane(self) -> Plane:
        return self._case.model.plane

    def _error(self, error: OSError) -> OutputError:
        return OutputError(
            f"{self._path}: the stress near the contacts cannot be written: {disk_reason(error)}"
        )


def _site(
    model: Model,
    patches: tuple[ContactHistory, ...],
    summaries: dict[str, Contact],
    depths: Array,
) -> _Site:
    """A contact and where the stress around it is looked at."""
    pair = patches[0]
    contact = model.case.contacts[pair.pair]
    surfaces = model.surfaces[contact.surface1], model.surfaces[contact.surface2]
    seen = [_below(surface, pair.points, depths) for surface in surfaces]
    own = tuple(summaries[each.name] for each in patches)
    bodies = pair.body1, pair.body2
    edges = [
        (summary.name, station.front, body)
        for summary in own
        for station in summary.stations
        for body in bodies
    ]
    points, normals = (np.array(each) for each in zip(*seen, strict=True))
    degree = model.case.model.degree
    strains = [SurfaceStrain.of(surface, degree, pair) for surface in surfaces]
    place = StressSite(pair.pair, pair.arc, pair.frames, bodies, points, normals, edges)
    return _Site(patches, own, surfaces, (strains[0], strains[1]), depths, place)


def _below(surface: Surface, points: Array, depths: Array) -> tuple[Array, Array]:
    """(D, N, d) places at depths below a surface, and (N, d) outward normals; next to points.

    NaN where the surface ends before a point.
    """
    nearest, normals = surface.nearest(points)
    # Places are samples: the surface is their tangent plane.
    across = np.sum(normals * (nearest - points), axis=1, keepdims=True)
    places = points + across * normals
    beside = np.linalg.norm(places - nearest, axis=1) > BESIDE * surface.sizes.max()
    places[beside] = np.nan
    return places - depths[:, None, None] * normals, normals


def refuse_solids(case: Case, dimension: int) -> None:
    """Check that the stress near contacts is asked of plane bodies only.

    Raises:
        CaseError: if it is asked of solids.
    """
    if case.output.stress_depths and dimension == 3:
        raise CaseError(
            f"{case.source}: output.stress_depths: expected plane bodies, found solids: the stress "
            "near the contacts is computed in the plane only"
        )
