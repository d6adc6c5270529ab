# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arrays of a solved history, which every later stage reads, whoever computed them.

T is the number of states (steps plus the unloaded state 0), N the number of nodes of a contact, d
the number of space dimensions. Tractions are in the stress unit, lengths in the length unit, forces
and work per unit thickness. Components of vectors in a contact's frame are ordered normal, then
tangents; in the plane the one tangent is the x axis of the contact (see the theory guide).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.history.state_array import StateArray, blocks
from fretfe.loads import CycleChoice, History
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction

OPEN = 0
STICK = 1
SLIP = 2
# Forces below this fraction of the largest one in the history are not compared with themselves:
# what round-off leaves of a balance is 1e-12 of the largest one.
NO_FORCE = 1e-6
# Violations of contact conditions below this fraction of the largest traction or displacement are
# round-off.
ROUND_OFF = 1e-11


class Factor(IntEnum):
    """Order of the singular edge factors of full stick: that of the components of a traction.

    The pressure has K_I, the shear along a station's `inward` K_T, that along its `along` K_S. Axes
    of this order have d entries: in the plane K_S vanishes and is left out.
    """

    K_I = 0
    K_T = 1
    K_S = 2


@dataclass(frozen=True)
class Repeat:
    """States that were not solved, because loads and contact were those of earlier ones.

    Attributes:
        first, last: of these states.
        period: number of states before `first` that they repeat, again and again.
    """

    first: int
    last: int
    period: int

    @property
    def source(self) -> Indices:
        """(n,) the state that each of them is the same as."""
        start = self.first - self.period
        return start + np.arange(self.last - self.first + 1) % self.period

    @property
    def text(self) -> str:
        """Steps that were not solved, and the reason, in words."""
        return (
            f"steps {self.first} to {self.last} repeat steps {self.first - self.period} to "
            f"{self.first - 1}, which left the contact as they found it: not solved again"
        )


@dataclass(frozen=True)
class FullStickUnits:
    """Full-stick traction increments, one field for each driver, by contact area.

    A driver is a load that moves the bodies: a platen or prescribed displacement (by its force, per
    unit thickness) or a distributed load (by its amplitude).

    Attributes:
        fields: (U, N, d, J) traction per unit of each of J drivers, for U different areas.
        area: (T,) which of the U areas a state has, -1 where nothing is in contact.
    """

    fields: StateArray | Array
    area: Indices


@dataclass(frozen=True)
class StationIntegrals:
    """Edge factors from displacements around the stations of a contact, by interaction integrals.

    Attributes:
        areas: (S,) contact areas, as counted in `FullStickUnits`.
        positions: (S, stations) along the arc, at these areas; of solids, whose stations are those
            of all fronts in a row, inward from the front of the reference state.
        reaches: (R,) radii of the circles; of solids numbers of the tubes.
        factors: (S, R, stations, d, J) in the order of `Factor`, for a unit of each driver.
    """

    areas: Indices
    positions: Array
    reaches: Array
    factors: Array


@dataclass(frozen=True)
class NearbyLoads:
    """A lower and a higher load than that of a state.

    Attributes:
        pressure: (2, N) at these loads; of solids means around the nodes.
        k_i: (R, stations) K_I of the difference between them, determined in R ways.
        state: its number.
    """

    pressure: Array
    k_i: Array
    state: int = -1


@dataclass(frozen=True)
class ContactHistory:
    """One contact through the whole history.

    Of a solved history the arrays over states are read from a file where they are needed.

    It is a pair of surfaces, or one of several patches of a pair. A patch has the nodes of the pair
    and carries nothing outside its own part of the surface.

    Attributes:
        name: that of the pair; with a number in brackets for one of several patches.
        pair: name of the surface pair, the contact in the case.
        body1, body2: names of the bodies.
        surface: its nodes.
        friction: at its nodes, in the step that ends at each state.
        traction: (T, N, d) pressure, then shear that body 1 exerts on body 2: nodal values of the
            piecewise-linear multiplier field.
        mean_traction: (T, N, d) mean of that field around each node: the nodal force over the
            length that belongs to the node. The better point value: where the traction has a
            square root or a kink, nodal values of the field alternate about it.
        gap: (T, N) mean gap at the node.
        slip: (T, N, d-1) tangential displacement of body 1 relative to body 2.
        status: (T, N) OPEN, STICK or SLIP in the step that ends at each state.
        dissipation: (T, N) friction work in that step.
        full_stick: full-stick increments.
        integrals: edge factors from displacements; None where there are no displacements.
        nearby_loads: two load levels that tell how the edges move; None if they have no solution.
        node_range: (T, 2) first and last node of the part of the surface that belongs to a patch,
            which reaches half-way to its neighbours; -1 where the patch does not exist. None if the
            pair has one patch only.
        events: where a patch comes from and where it goes, in words; a text for each kind of event.
        beside: (T, N) pressure of the other patches of the pair; None without any, and of solutions
            that were read.
    """

    name: str
    pair: str
    body1: str
    body2: str
    surface: ContactSurface
    friction: Friction
    traction: StateArray | Array
    mean_traction: StateArray | Array
    gap: StateArray | Array
    slip: StateArray | Array
    status: StateArray | npt.NDArray[np.int8]
    dissipation: StateArray | Array
    full_stick: FullStickUnits
    integrals: StationIntegrals | None = None
    nearby_loads: NearbyLoads | None = None
    node_range: Indices | None = None
    events: tuple[str, ...] = ()
    beside: StateArray | Array | None = None

    def edge_friction(self, edge: Array) -> Array:
        """(T,) coefficient at an edge, that of the node nearest to it in each state.

        All that is found at an edge has this one: formulas and slip zones of its half cycles.
        Where nodes keep theirs that of its last place: `FrictionBehind` tells others.

        Args:
            edge: (T,) its place along the arc; of solids (T, 3).
        """
        nodes = self.surface.nodes_at(edge)
        stays = self.friction.at_edge(np.full_like(nodes, nodes[-1]))
        return stays if len(np.unique(stays[stays > 0])) == 1 else self.friction.at_edge(nodes)

    @property
    def exists(self) -> Bools:
        """(T,) states in which the patch exists; a pair with one patch only always does."""
        if self.node_range is None:
            return np.ones(len(self.traction), dtype=bool)
        return np.asarray(self.node_range[:, 0] >= 0)

    @property
    def pressed_nodes(self) -> Indices:
        """(T,) number of nodes under pressure."""
        return self.nodes_pressed_in(np.arange(len(self.traction)))

    def nodes_pressed_in(self, states: Indices) -> Indices:
        """(n,) number of nodes under pressure in some states (n,)."""
        found = [
            np.count_nonzero(self.traction[states[block], :, 0] > 0, axis=1)
            for block in blocks(len(states), self.traction[0].size)
        ]
        return np.concatenate(found)

    @property
    def intervals(self) -> tuple[tuple[int, int], ...]:
        """First and last state of each run of states in which the patch exists."""
        ends = np.flatnonzero(np.diff(self.exists, prepend=False, append=False)).reshape(-1, 2)
        return tuple((int(begin), int(end) - 1) for begin, end in ends)


@dataclass(frozen=True, repr=False)
class Solution:
    """A solved load history.

    Attributes:
        degree: polynomial degree of the displacements.
        times: (T,) clock.
        channels: names of the loads.
        values: (T, C) value of each load.
        cycle: first and last state of the evaluated cycle, or None.
        between: (T-1, S, C) value of each load within each step, as of `History`.
        coordinates: names of the rigid boundaries' amplitudes.
        amplitudes: (T, m) amplitude of each coordinate.
        forces: (T, m) force on each coordinate, per unit thickness.
        drivers: names of the drivers.
        driver_values: (T, J) force or amplitude of each driver.
        contacts: contacts in the order of the case.
        iterations: (T,) Newton iterations of each step; 0 for state 0.
        parts: (T,) number of parts that a step was cut into.
        fallbacks: (T,) how often the slow method was needed.
        certificates: (T,) arrays by name; see the results guide.
        repeats: states that were not solved, as they are the same as earlier ones.
        kept: (K,) states whose arrays along the contacts are there, increasing; None for all.
        step: (T,) number of the step in which each state lies, if states within steps are among
            them; None if each state is the end of a step.
        choice: the reason for the evaluated cycle, as of `History`.
        free: (T, k) amplitudes of rigid motions that only contact prevents.
    """

    degree: int
    times: Array
    channels: tuple[str, ...]
    values: Array
    cycle: tuple[int, int] | None
    coordinates: tuple[str, ...]
    amplitudes: Array
    forces: Array
    drivers: tuple[str, ...]
    driver_values: Array
    contacts: tuple[ContactHistory, ...]
    iterations: Indices
    parts: Indices
    fallbacks: Indices
    certificates: dict[str, Array]
    between: Array | None = None
    repeats: tuple[Repeat, ...] = ()
    kept: Indices | None = None
    step: Indices | None = None
    choice: CycleChoice | None = None
    free: Array | None = None

    def __repr__(self) -> str:
        """One line: how many states, and the contacts."""
        names = ", ".join(each.name for each in self.contacts)
        return f"<Solution of {len(self.times)} states, contacts {names}>"

    @property
    def ends(self) -> Indices:
        """(n + 1,) states at the ends of the n steps, the unloaded one first."""
        if self.step is None:
            return np.arange(len(self.times))
        return np.flatnonzero(np.diff(self.step, append=self.step[-1] + 1))

    def step_of(self, state: int) -> int:
        """Number of the step in which a state lies."""
        return state if self.step is None else int(self.step[state])

    def keeps(self, first: int, last: int) -> bool:
        """True if the arrays along the contacts are there in all states from one to another."""
        if self.kept is None:
            return True
        inside = (self.kept >= first) & (self.kept <= last)
        return int(np.count_nonzero(inside)) == last - first + 1

    def imbalance(self, kind: str) -> Array:
        """(T,) sum of the forces or moments on a body over that of their sizes.

        States whose forces are nothing beside those of the history, as after the bodies have
        parted, have round-off in place of forces: it is compared with what there was before.

        Args:
            kind: "force" or "moment".
        """
        scale = self.certificates[f"{kind}_scale"]
        least = max(NO_FORCE * float(scale.max()), float(np.finfo(float).tiny))
        return np.asarray(self.certificates[f"{kind}_imbalance"] / np.maximum(scale, least))

    @property
    def least_slip(self) -> Array:
        """(T,) length below which the slip of a node in a step is zero to the solver.

        Nodes that reach f p but are not driven on, as where P and Q grow together, have such slip.
        """
        return ROUND_OFF * self.certificates["gap_scale"]

    @property
    def dimension(self) -> int:
        """Number of coordinates, d."""
        return self.contacts[0].surface.points.shape[1]

    @property
    def source(self) -> Indices:
        """(T,) the solved state that each state is the same as: itself, unless it repeats one."""
        source = np.arange(len(self.times))
        for each in self.repeats:
            source[each.first : each.last + 1] = source[each.source]
        return source

    @property
    def loads(self) -> History:
        """The loads of the states that were solved."""
        return History(
            self.channels, self.times, self.values, self.cycle, self.between, self.choice
        )
