# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patches of the contact area of solids, followed through the history.

A patch is a part of the area whose nodes hang together. From the reference state, the last one of
the evaluated cycle, they are looked for in the states before and after it, from one to the next: a
part of the area at the place that a patch has had is that patch, one elsewhere is a new patch.
Where it is at the places of several, these have merged, and nobody can tell what each carries.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.contacts import AreaPatch
from fretfe.evaluate.plane.patches_in_time import FEWEST_NODES, SHARE_OF_FEW, SMALLEST_PATCH
from fretfe.evaluate.space.sectors import triangles
from fretfe.history.solution import ContactHistory, Solution
from fretfe.surface.surface import edges_once

NONE = -1


def follow_patches(
    solution: Solution, contact: ContactHistory
) -> tuple[tuple[AreaPatch, ...], Indices]:
    """The patches of a contact through the history, and where they are.

    As in the plane, what carries hardly any force is no patch.

    Returns:
        The patches, that of the largest P in the reference state first; none where there is a
        single one. And (N,) for each node the number of the patch that it has belonged to, from 0;
        -1 if there is none.
    """
    assert contact.surface.facets is not None
    source, edges = solution.source, edges_once(triangles(contact.surface.facets))
    last = solution.cycle[1] if solution.cycle else len(source) - 1
    followed, states = _Followed(solution, contact, edges), np.unique(source)
    reference = int(source[last])
    for state in (*states[states <= reference][::-1], *states[states > reference]):
        followed.add(int(state))
    found = tuple(followed.patches(source, last))
    return found if len(found) > 1 else (), followed.owner


def _parts(edges: Indices, area: Bools) -> Indices:
    """(N,) number of the part that each node in contact (N,) hangs together with; else -1."""
    inside = edges[area[edges].all(axis=1)]
    count = len(area)
    graph = coo_array((np.ones(len(inside)), inside.T), shape=(count, count))
    labels = connected_components(graph, directed=False)[1]
    parts = np.full(count, NONE)
    parts[area] = np.unique(labels[area], return_inverse=True)[1]
    return parts


class _Followed:
    """Patches of a contact in the states that are added, one after the other from the reference.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        edges: (E, 2) between its nodes.
    """

    def __init__(self, solution: Solution, contact: ContactHistory, edges: Indices) -> None:
        self._solution, self._contact, self._edges = solution, contact, edges
        # (N,) patch that each node has belonged to, from 0.
        self.owner = np.full(len(contact.surface.weights), NONE)
        # P, Q and area in each state, and the patches that it is one with, by state.
        self._carried: list[Array] = []
        self._merged: list[dict[int, set[int]]] = []
        self._area, self._parts = np.zeros(len(self.owner), dtype=bool), self.owner

    def add(self, state: int) -> None:
        """Add a state."""
        traction = self._contact.traction[state]
        area = traction[:, 0] > 0
        if not np.array_equal(area, self._area):
            self._area, self._parts = area, _parts(self._edges, area)
        parts, inside = self._parts, self._parts >= 0
        loads = np.bincount(parts[inside], (self._contact.surface.weights * traction[:, 0])[inside])
        for part in np.argsort(-loads, kind="stable"):
            nodes = parts == part
            few = np.count_nonzero(nodes) < FEWEST_NODES
            trace = loads[part] < (SHARE_OF_FEW if few else SMALLEST_PATCH) * loads.sum()
            before = self.owner[nodes]
            owners, counts = np.unique(before[before >= 0], return_counts=True)
            if len(owners) > 1 and not trace:
                for owner in owners.tolist():
                    self._carried[owner][state] = np.nan
                    self._merged[owner][state] = set(owners.tolist()) - {owner}
                continue
            if not len(owners) and trace:
                continue
            owner = int(owners[counts.argmax()]) if len(owners) else self._begin()
            self.owner[nodes] = owner
            self._carried[owner][state] += self._carries(traction, nodes)

    def _begin(self) -> int:
        """Number of a new patch."""
        self._carried.append(np.zeros((len(self._solution.times), 5)))
        self._merged.append({})
        return len(self._carried) - 1

    def _carries(self, traction: Array, nodes: Bools) -> Array:
        """(5,) P, Q and area of some nodes."""
        surface = self._contact.surface
        weights, tangents = surface.weights[nodes], surface.frames[nodes, 1:]
        shear = np.einsum("n,nt,ntd->d", weights, traction[nodes, 1:], tangents)
        return np.concatenate([[weights @ traction[nodes, 0]], shear, [weights.sum()]])

    def patches(self, source: Indices, reference: int) -> Iterator[AreaPatch]:
        """The patches, in states that may repeat others (T,)."""
        names = [f"{self._contact.name}[{number + 1}]" for number in range(len(self._carried))]
        for name, carried, merged in zip(names, self._carried, self._merged, strict=True):
            rows, reasons = carried[source], []
            if rows[reference, 0] == 0:
                reasons.append("it does not touch at the end of the cycle, and has no fronts")
            if merged:
                others = sorted({other for each in merged.values() for other in each})
                there = np.flatnonzero(np.isin(source, list(merged)))
                step, time = self._solution.step_of(there[0]), self._solution.times[there[0]]
                reasons.append(
                    f"it is one with {' and '.join(names[other] for other in others)} in "
                    f"{len(there)} state{'s' * (len(there) > 1)}, first in step {step} (time "
                    f"{time:.6g}): P, Q and area are not known there"
                )
            yield AreaPatch(name, rows[:, 0], rows[:, 1:4], rows[:, 4], "; ".join(reasons))
