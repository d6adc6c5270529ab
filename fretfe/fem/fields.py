# SPDX-License-Identifier: LGPL-3.0-or-later
"""Displacement fields of requested states, and what evaluation and files take of them."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from dolfinx import fem
from scipy import sparse

from fretfe._typing import Array, Bools, Indices
from fretfe.contact.interface import Compliance
from fretfe.fem._compat import cells_around
from fretfe.fem.elasticity import ElasticBody, stress_pairs
from fretfe.fem.model import Model, Request, Share
from fretfe.fem.parallel import Lead, agreed
from fretfe.fem.probes import Probe, measure
from fretfe.files import writing
from fretfe.local.batches import Batch
from fretfe.local.problem import EdgeSlip
from fretfe.mesh.shares import share_out
from fretfe.results.field_files import FieldWriter

# Reference coordinates may leave an element by this much; bounding boxes grow by this part.
TOLERANCE = 1e-8
NEWTON_STEPS = 12
# Bytes of the displacements that are recovered together.
MOST_BYTES = 1 << 26

# Points (m, d) of a body, by contact and number of the body.
Places = dict[tuple[str, int], tuple[str, Array]]
# Displacements (p, d) of the nodes of all contact surfaces, by surface.
Moved = dict[str, Array]


class FieldSource:
    """Brings questions of rank 0, which evaluates a history alone, to all ranks and answers back.

    Args:
        model: the condensed bodies.
        lead: brings the questions to all ranks.
    """

    def __init__(self, model: Model, lead: Lead[Recovery]) -> None:
        self._model, self._lead = model, lead

    def surface_displacements(self, requests: Sequence[Request]) -> list[Moved]:
        """Displacements of the nodes of all contact surfaces, for each request."""
        return self._lead.ask(
            partial(Recovery.surface_displacements, shares=self._shares(requests))
        )

    def integrals(
        self, probes: Sequence[Probe], requests: Sequence[Request], say: Callable[[str], None]
    ) -> list[list[Array]]:
        """Singular edge factors of the requested fields, as `measure` returns them."""
        question = partial(Recovery.integrals, probes=probes, shares=self._shares(requests))
        return self._lead.ask(question, say=say)

    def states_at_once(self) -> int:
        """Number of displacement fields that may be held together."""
        return self._lead.ask(Recovery.states_at_once)

    def edge_slip(self, batches: Sequence[Batch]) -> list[list[EdgeSlip]]:
        """Solutions of batches of plane problems, shared out among the ranks."""
        return self._lead.ask(partial(Recovery.edge_slip, batches=batches))

    def stress(
        self, places: Places, requests: Sequence[Request]
    ) -> list[tuple[Moved, dict[tuple[str, int], Array]]]:
        """For each request the displacements of all surfaces, and stress (m, 4 or 6) at points.

        Points are the same in every call. The stress is NaN outside the bodies.
        """
        question = partial(Recovery.stress, places=places, shares=self._shares(requests))
        return self._lead.ask(question)

    def element_nodes(self) -> dict[str, Array]:
        """(m, k, 3) nodes of the elements of each body."""
        return self._lead.ask(Recovery.element_nodes)

    def element_values(
        self, requests: Sequence[Request], stress: bool
    ) -> list[dict[str, list[Array]]]:
        """Displacement, and stress, at the nodes of the elements, a list over the bodies each."""
        shares = self._shares(requests)
        question = partial(Recovery.element_values, shares=shares, stress=stress)
        return self._lead.ask(question)

    def displacements(self, requests: Sequence[Request]) -> Iterator[dict[str, list[Array]]]:
        """As `element_values` without stress, by combinations of the fields that states share."""
        modes, shares = common_modes(requests, self._model.reduction.interface.compliance)
        at_once = max(self.states_at_once() // 3, 1)
        found = [  # as exact as they are written
            [part.astype(np.float32) for part in each["displacement"]]
            for first in range(0, len(modes), at_once)
            for each in self.element_values(modes[first : first + at_once], stress=False)
        ]
        bodies = [np.stack(each) for each in zip(*found, strict=True)]
        for first in range(0, len(requests), at_once):
            some = shares.T[first : first + at_once].astype(np.float32)
            for moved in zip(*(np.tensordot(some, each, 1) for each in bodies), strict=True):
                yield {"displacement": list(moved)}

    def _shares(self, requests: Sequence[Request]) -> list[Share]:
        return [self._model.share(each) for each in requests]


class Recovery:
    """The part of each rank in the answers of `FieldSource`, which rank 0 gets. Collective.

    Args:
        model: the condensed bodies.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._points: dict[tuple[str, int], StressPoints] | None = None

    def surface_displacements(self, shares: Sequence[Share]) -> list[Moved]:
        """Displacements of the nodes of all contact surfaces, by surface."""
        return self._surfaces(self._model.recover_fields(shares))

    def integrals(
        self, probes: Sequence[Probe], shares: Sequence[Share], **own: Callable[[str], None]
    ) -> list[list[Array]]:
        """Singular edge factors."""
        return measure(self._model, probes, shares, **own)

    def states_at_once(self) -> int:
        """Number of displacement fields that are held together; the same on all ranks."""
        model = self._model
        sizes = [body.elastic.space.dofmap.index_map.size_global for body in model.bodies.values()]
        largest = max(model.comm.allgather(sum(sizes) * model.dimension * 8))
        return int(np.clip(MOST_BYTES // largest, 1, 64))

    def edge_slip(self, batches: Sequence[Batch]) -> list[list[EdgeSlip]]:
        """Solutions of batches of plane problems, of which each rank takes its share."""
        comm = self._model.comm
        # More ranks than batches: the last ones have nothing to do.
        groups = share_out([batch.work for batch in batches], min(comm.size, len(batches)))
        mine = groups[comm.rank][0] if comm.rank < len(groups) else ()
        own = agreed(comm, lambda: {number: batches[number].solve() for number in mine})
        found = dict(ChainMap(*(comm.gather(own) or [])))
        return [found[number] for number in range(len(batches)) if found]

    def stress(
        self, places: Places, shares: Sequence[Share]
    ) -> list[tuple[Moved, dict[tuple[str, int], Array]]]:
        """Displacements of all surfaces, and stress at points of the bodies."""
        if self._points is None:  # the same points in every call
            self._points = {
                key: StressPoints(self._model.bodies[body].elastic, at)
                for key, (body, at) in places.items()
                if body in self._model.bodies
            }
        fields = self._model.recover_fields(shares)
        inner = [
            self._stress(places, self._points, *each) for each in zip(fields, shares, strict=True)
        ]
        return list(zip(self._surfaces(fields), inner, strict=False))

    def element_nodes(self) -> dict[str, Array]:
        """Nodes of the elements."""
        bodies = self._model.bodies
        return self._gather({name: body.elastic.element_nodes() for name, body in bodies.items()})

    def element_values(self, shares: Sequence[Share], stress: bool) -> list[dict[str, list[Array]]]:
        """Displacement, and stress if wanted, at the nodes of the elements, for each share."""
        fields = self._model.recover_fields(shares)
        return [self._element_values(*each, stress) for each in zip(fields, shares, strict=True)]

    def _element_values(
        self, field: Mapping[str, fem.Function], share: Share, stress: bool
    ) -> dict[str, list[Array]]:
        bodies = {name: (self._model.bodies[name].elastic, u) for name, u in field.items()}
        moved = self._gather({b: e.element_displacements(u) for b, (e, u) in bodies.items()})
        found = {"displacement": list(moved.values())}
        if stress:
            initial = self._initial(share)
            own = {b: e.element_stresses(u, initial[b]) for b, (e, u) in bodies.items()}
            found["stress"] = list(self._gather(own).values())
        return found

    def _initial(self, share: Share) -> dict[str, fem.Function | None]:
        """Stress of the initial strain of each body of this rank's group."""
        return {
            name: body.initial_stress(share[name][2]) for name, body in self._model.bodies.items()
        }

    def _surfaces(self, fields: Sequence[dict[str, fem.Function]]) -> list[Moved]:
        model, found = self._model, []
        for field in fields:
            own: Moved = {}
            for name, displacement in field.items():
                moved = model.bodies[name].surface_displacement(displacement)
                surfaces = model.body_definition(name).surfaces
                degree = model.case.model.degree
                counts = [len(model.surfaces[s].displacement_points(degree)) for s in surfaces]
                parts = np.split(moved, np.cumsum(counts)[:-1])
                own |= dict(zip(surfaces, parts, strict=True))
            found.append(own)
        gathered = model.comm.gather(found) or []
        return [dict(ChainMap(*parts)) for parts in zip(*gathered, strict=True)]

    def _stress(
        self,
        places: Places,
        points: Mapping[tuple[str, int], StressPoints],
        field: Mapping[str, fem.Function],
        share: Share,
    ) -> dict[tuple[str, int], Array]:
        initial, own = self._initial(share), {}
        for key, at in points.items():
            body = places[key][0]
            own[key] = at.found, at.stress(field[body], initial[body])
        size = len(stress_pairs(self._model.components))
        whole = {key: np.full((len(at), size), np.nan) for key, (_, at) in places.items()}
        for part in self._model.comm.gather(own) or []:
            for key, (found, values) in part.items():
                whole[key][found] = values
        return whole

    def _gather(self, parts: Mapping[str, Array]) -> dict[str, Array]:
        """Parts of bodies (m, k, c) put together on rank 0, in the order of the case."""
        own = {}
        for name, part in parts.items():
            gathered = self._model.bodies[name].elastic.comm.gather(part)
            if gathered is not None:
                own[name] = np.concatenate(gathered)
        whole: dict[str, Array] = {}
        for each in self._model.comm.gather(own) or []:
            whole |= each
        return {name: whole[name] for name in self._model.case.bodies if name in whole}


class FieldOutput:
    """A file that takes the fields of one state after the other; on rank 0.

    Displacement and stress are those of each element, polynomials of the displacement's degree;
    nothing is smoothed between elements.

    Args:
        fields: answers with them.
        path: file to write.
        names: of the values, "displacement" and "stress".

    Raises:
        OutputError: if the file cannot be written; so does `add`.
    """

    def __init__(self, fields: FieldSource, path: Path, names: Sequence[str]) -> None:
        self._fields, self._path, self._stress = fields, path, "stress" in names
        nodes = fields.element_nodes()
        with writing(self._path, "the fields"):
            self._writer = FieldWriter(path, nodes, names)

    @property
    def states_at_once(self) -> int:
        """Number of states to add together: at the nodes of each element a field is larger."""
        if not self._stress:  # the more states there are, the fewer fields each of them takes
            return 1024
        return max(self._fields.states_at_once() // 8, 1)

    def close(self) -> None:
        """Finish the file."""
        self._writer.close()

    def add(self, times: Sequence[float], requests: Sequence[Request]) -> None:
        """Append states, whose fields are recovered together."""
        fields = self._fields
        found: Iterable[dict[str, list[Array]]] = (
            fields.element_values(requests, True)
            if self._stress
            else fields.displacements(requests)
        )
        for time, values in zip(times, found, strict=True):
            with writing(self._path, "the fields"):
                self._writer.add(time, values)


def common_modes(
    requests: Sequence[Request], compliance: Compliance
) -> tuple[list[Request], Array]:
    """Fields of which all those of a history are combinations, but for a ten thousandth.

    Displacements are linear in what makes them: tractions, in the norm of their elastic energy, and
    each coordinate and load, as part of its largest value.

    Args:
        requests: n of the history.
        compliance: of the contact nodes.

    Returns:
        r requests, and shares (r, n) of them.
    """
    traction, *rest = parts = [
        np.array([getattr(each, name) for each in requests]).T
        for name in ("traction", "coordinates", "amplitudes")
    ]
    energy = traction.T @ np.array([compliance.apply(each) for each in traction.T]).T
    rows = np.concatenate(rest)
    rows = rows / np.maximum(np.abs(rows).max(axis=1, keepdims=True), 1e-300)
    gram = energy / max(float(np.diag(energy).max()), 1e-300) + rows.T @ rows
    squares, vectors = np.linalg.eigh((gram + gram.T) / 2)
    kept = vectors[:, squares > 1e-8 * squares[-1]]
    modes = [Request(*each) for each in zip(*((part @ kept).T for part in parts), strict=True)]
    return modes, kept.T


class StressPoints:
    """Stress at those of some points that lie in this rank's elements.

    Args:
        elastic: the body.
        points: (m, d) places, the same on all ranks of the body.

    Attributes:
        found: (f,) numbers of the points that this rank has.
    """

    def __init__(self, elastic: ElasticBody, points: Array) -> None:
        self._pairs = stress_pairs(elastic.components)
        cells, reference, self.found = _locate(elastic, points)
        self._cells, self._reference = cells, reference
        self._operator = _operator(elastic, cells, reference, self._pairs)

    def stress(self, displacement: fem.Function, initial: fem.Function | None = None) -> Array:
        """(f, 4 or 6) stress xx, yy, zz, xy, yz, xz of a displacement, that of the element.

        Args:
            displacement: of the body.
            initial: stress (3, 3) of initial strains, which is taken off.
        """
        values = (self._operator @ displacement.x.array).reshape(len(self.found), len(self._pairs))
        if initial is not None:
            shares = _tabulated(initial.function_space, self._reference)[0]
            nodes = initial.function_space.dofmap.list[self._cells]
            tensors = initial.x.array.reshape(-1, 3, 3)[nodes]
            here = np.einsum("fn,fnij->fij", shares, tensors)
            values = values - np.stack([here[:, i, j] for i, j in self._pairs], axis=1)
        return np.asarray(values)


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
    space, dim, size = _geometry(elastic), elastic.gdim, elastic.components
    nodes = space.tabulate_dof_coordinates()[space.dofmap.list[cells], :dim]
    jacobians = np.einsum("nkd,nke->nde", nodes, _tabulated(space, at)[1])
    slopes = np.einsum("nke,ned->nkd", _tabulated(elastic.space, at)[1], np.linalg.inv(jacobians))
    stiffness = np.array([elastic.material.tensor[pair] for pair in pairs])[..., :size, :dim]
    rows = np.einsum("cij,nkj->ncki", stiffness, slopes)
    unknowns = elastic.space.dofmap.list[cells][..., None] * size + np.arange(size)
    count, width = len(cells) * len(pairs), unknowns.shape[1] * size
    columns = np.repeat(unknowns.reshape(len(cells), width), len(pairs), axis=0)
    indptr = np.arange(count + 1) * width
    shape = count, len(elastic.node_points) * size
    return sparse.csr_matrix((rows.ravel(), columns.ravel(), indptr), shape=shape)
