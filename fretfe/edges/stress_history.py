# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress histories of both bodies next to a contact, through the evaluated or the worst cycle.

n is the number of states, N that of the nodes of the contact, D that of the depths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Indices
from fretfe.edges.front import ContactSummary, Station
from fretfe.edges.missions import worst_path
from fretfe.edges.slip_zones import cycle_states
from fretfe.results.solution import Solution


@dataclass(frozen=True)
class BodyStress:
    """Stress of one body below the nodes of a contact.

    Attributes:
        name: of the body.
        points: (D, N, d) places before deformation; NaN where they are not in the body.
        normals: (N, d) outward unit normals of the body, against which the depths are counted.
        stress: (n, D, N, 4) xx, yy, zz, xy in the axes of the case [stress].
    """

    name: str
    points: Array
    normals: Array
    stress: Array


@dataclass(frozen=True)
class EdgeStress:
    """Stress along the surface of one body at one edge.

    Attributes:
        contact: name of the contact, or of one of its patches.
        edge: "left" or "right".
        body: name of the body.
        value: (n,) sigma_t [stress]; NaN where it is not known.
        spread: (n,) its error bar [stress].
        reason: why it is known in no state; empty if it is in some.
    """

    contact: str
    edge: str
    body: str
    value: Array
    spread: Array
    reason: str

    @property
    def largest(self) -> tuple[float, float]:
        """The largest value and its error bar; NaN if none is known."""
        if self.reason:
            return np.nan, np.nan
        at = int(np.nanargmax(self.value))
        return float(self.value[at]), float(self.spread[at])


@dataclass(frozen=True)
class StressHistory:
    """The surroundings of a contact through a cycle.

    Attributes:
        contact: name of the contact in the case.
        depths: (D,) below the surfaces [length].
        states: (n,) numbers of the states.
        times: (n,) their times.
        arc: (N,) place along the contact [length].
        frames: (N, d, d) outward normal of body 2, tangent.
        traction: (n, N, d) p and q, means around the nodes [stress].
        slip: (n, N) of body 1 relative to body 2 [length].
        status: (n, N) as of `ContactHistory`.
        bodies: body 1 and body 2.
        edges: of both bodies.
    """

    contact: str
    depths: Array
    states: Indices
    times: Array
    arc: Array
    frames: Array
    traction: Array
    slip: Array
    status: npt.NDArray[np.int8]
    bodies: tuple[BodyStress, BodyStress]
    edges: tuple[EdgeStress, ...]

    def at(self, nodes: Indices) -> StressHistory:
        """The same at some of the nodes (m,)."""
        first, second = (
            BodyStress(
                each.name, each.points[:, nodes], each.normals[nodes], each.stress[:, :, nodes]
            )
            for each in self.bodies
        )
        return replace(
            self,
            arc=self.arc[nodes],
            frames=self.frames[nodes],
            traction=self.traction[:, nodes],
            slip=self.slip[:, nodes],
            status=self.status[:, nodes],
            bodies=(first, second),
        )


def judged_states(solution: Solution, contacts: Sequence[ContactSummary]) -> Indices:
    """(n,) states of the evaluated cycle, or of the whole history without one.

    Where loads are irregular, those on the way through the worst counted cycle of all edges.
    """
    worst = worst_states(solution, contacts)
    if len(worst):
        return worst
    first, last = solution.loads.evaluated
    return np.arange(first, last + 1)


def worst_states(solution: Solution, contacts: Sequence[ContactSummary]) -> Indices:
    """(n,) states on the way through the worst counted cycle of the edges of some contacts.

    Empty if the loads are regular.
    """
    histories = {each.name: each for each in solution.contacts}
    irregular = [
        (edge, histories[contact.name].friction)
        for contact in contacts
        for edge in contact.stations
        if edge.cycles.irregular
    ]
    if not irregular:
        return np.zeros(0, dtype=np.int64)
    edge, friction = max(irregular, key=lambda each: largest_range(each[0]))
    return worst_path(edge.cycles, cycle_states(solution.cycle), friction, edge)


def largest_range(edge: Station) -> float:
    """The range of the worst counted cycle of an edge."""
    return float(edge.cycles.effective_range.max(initial=0.0))
