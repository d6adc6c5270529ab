# SPDX-License-Identifier: LGPL-3.0-or-later
"""The linear algebra of contact as named operations, by one factorisation for many areas.

Newton's method, its fallback and the full-stick increments state conditions on nodes and
coordinates. `FactoredOperator` decides how the linear systems behind them are factorised and
solved, and what is kept from one contact area to the next.

Right-hand sides and solutions have a last axis of J cases that are solved at once. N, d and m are
those of `fretfe.contact.interface`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from fretfe._typing import Array, Bools, Indices
from fretfe.contact import dense
from fretfe.contact.interface import Interface, coordinate_scale
from fretfe.contact.nested_inverse import (
    READING,
    InverseRows,
    MatrixSystem,
    NestedInverse,
    SimilarSystems,
    UnitRows,
)
from fretfe.contact.state import OPEN, SLIP, STICK, Status
from fretfe.errors import ModelError


@dataclass(frozen=True)
class Conditions:
    """Linear conditions that take the place of full stick.

    A node with pressure p, shear q, gap g and increment Δ is

    * open: p = 0, q = 0;
    * stuck: g = 0, Δ = 0;
    * slipping: g = 0, q = p `pull` + T (q − r Δ) with the matrix T of `turning`.

    Attributes:
        status: (N,) OPEN, STICK or SLIP.
        pull: (N, d-1) friction coefficient times direction of the shear; read at slipping nodes.
        turning: (N,) t of the derivative t (1 - direction x direction) of the direction times the
            friction bound; read at slipping nodes, in three dimensions only: in the plane a
            direction cannot turn. Without a direction, the derivative is t.
        penalty: (N,) r.
        known: (m,) coordinates of known amplitude; on the others the force is known.
        amplitudes: (k, J) the known amplitudes.
        floating: True if bodies can move without any resistance. The loads must then be in
            equilibrium, and the solution is one of many that differ in such motions only.
    """

    status: Status
    pull: Array
    turning: Array
    penalty: Array
    known: Bools
    amplitudes: Array
    floating: bool = False

    def turned(self, nodes: Indices) -> Array:
        """(n, d-1, d-1) T of some nodes."""
        t = self._directions(nodes)
        across = np.eye(t.shape[1]) - t[:, :, None] * t[:, None, :]
        return np.asarray(self.turning[nodes][:, None, None] * across)

    def across(self, nodes: Indices) -> tuple[Indices, Array]:
        """Which nodes of solids can turn, once for each (n, 2) unit vector along which they do."""
        t = self._directions(nodes)
        turns, directed = self.turning[nodes] > 0, t.any(axis=1)
        one, any_way = nodes[turns & directed], nodes[turns & ~directed]
        around = t[turns & directed][:, ::-1] * np.array([-1.0, 1.0])
        both = np.repeat(np.eye(2), len(any_way), axis=0)
        return np.concatenate([one, any_way, any_way]), np.vstack([around, both])

    def _directions(self, nodes: Indices) -> Array:
        pull = self.pull[nodes]
        length = np.linalg.norm(pull, axis=1, keepdims=True)
        return np.asarray(pull / np.where(length > 0, length, 1.0))


@dataclass(frozen=True)
class Response:
    """Solution of linear contact conditions.

    Attributes:
        traction: (N, d, J) y.
        relative: (N, d, J) gap and increment Δ; where they are released or stuck as the conditions
            have it, not as the bodies' displacements give it.
        coordinates: (m, J) c.
        residual: what is left of the right-hand sides, relative to them: zero but for round-off, or
            if bodies can move without any resistance and the loads are not in equilibrium.
    """

    traction: Array
    relative: Array
    coordinates: Array
    residual: float = 0.0


# Leading blocks end at multiples of this fraction of all nodes: most changes of the contact area
# leave the block as it is.
STEP = 1 / 64
# Nodes that are factorised: at least so many, and so many times those in contact.
FEWEST = 300
SPARE = 1.25
# Work of opening a component among those of a block, for each of them, over that of a factorisation
# for each cube of an unknown (measured: 18 ns, .03 ns).
OPENING = 600
# Unknown tractions for each released component up to which a contact slides: its factors serve many
# conditions.
SLIDES = 1.2
# What tells conditions of sliding contacts from one another; the columns of their border, over the
# unknowns, from which on they are factorised; the residual, over displacements, that no border may
# leave.
SLIDING = ("status", "pull", "known")
WIDEST_BORDER = 0.5
BORDER_ERROR = 1e-11
# Singular values below this fraction of the largest belong to motions that nothing resists.
UNRESISTED = 1e-10


class RegularisedFactor:
    """The bodies with an elastic layer between them, every node sticking to it, factorised.

    Prescribed coordinates do not move; the layer's compliance is the penalty.

    Args:
        interface: the interface problem; its prescribed coordinates are left out.
        penalty: compliance of the layer.
    """

    def __init__(self, interface: Interface, penalty: float) -> None:
        released = np.flatnonzero(~interface.prescribed)
        everything = np.arange(interface.size * interface.components)
        matrix = interface.compliance.block(everything, everything).T  # Fortran's order
        matrix[everything, everything] += penalty
        self._inverse = NestedInverse(matrix)
        scale = coordinate_scale(interface)[released] * interface.compliance.level
        self._scale = scale
        self._motion = interface.motion[:, released] * scale
        self._response = self._inverse.solve(len(everything), self._motion)
        stiffness = interface.stiffness[np.ix_(released, released)] * np.outer(scale, scale)
        self._flexibility = linalg.pinvh(stiffness + self._motion.T @ self._response)

    def tractions(self, displacement: Array, forces: Array) -> Array:
        """(N*d,) tractions that give a displacement.

        Args:
            displacement: (N*d,) w − w0 of bodies and layer together.
            forces: (k,) forces on the k coordinates that are not prescribed, −(R + H a).
        """
        held = self._inverse.solve(len(displacement), displacement[:, None])[:, 0]
        moved = self._flexibility @ (self._motion.T @ held - forces * self._scale)
        return np.asarray(held - self._response @ moved)


class DirectSystem:
    """Linear contact conditions of solids for as few unknowns as they leave, without any inverse.

    These are all components of the traction of a stuck node; of a slipping one its pressure, which
    pulls a shear behind it, and the shear across that, along which its direction turns.

    Args:
        interface: the interface problem, d = 3.
        conditions: contact conditions; bodies do not float.

    Attributes:
        count: number of unknown tractions; coordinates follow.
        numbers: the same for unknowns of the same kind in other systems.
    """

    def __init__(self, interface: Interface, conditions: Conditions) -> None:
        stuck, slipping = (np.flatnonzero(conditions.status == each) for each in (STICK, SLIP))
        turning, across = conditions.across(slipping)
        first, weight = np.unique(turning, return_index=True)[1], conditions.turning[turning]
        self._interface, self._conditions = interface, conditions
        self._level, self._scale = interface.compliance.level, coordinate_scale(interface)
        # Of each unknown the node, the tractions there by a unit of it, and what its condition is
        # about of the displacements.
        self._nodes = np.concatenate([np.repeat(stuck, 3), slipping, turning])
        self.count, own = len(self._nodes), slice(3 * len(stuck) + len(slipping), None)
        self._trial = np.zeros((self.count, 3))
        self._trial[: 3 * len(stuck)] = np.tile(np.eye(3), (len(stuck), 1))
        self._trial[3 * len(stuck) : own.start, 0] = 1.0
        self._tested = self._trial.copy()
        self._held = 3 * self._nodes[: own.start] + self._tested[: own.start].argmax(axis=1)
        self._trial[3 * len(stuck) : own.start, 1:] = conditions.pull[slipping]
        self._trial[own, 1:], self._tested[own, 1:] = across, weight[:, None] * across
        self._own = np.zeros(self.count)
        self._own[own] = (1 - weight) / (conditions.penalty[turning] * self._level)
        kinds = np.repeat([3, 5], [len(slipping), len(turning)])
        kinds[len(slipping) + first] = 4
        kinds = np.concatenate([np.tile(np.arange(3), len(stuck)), kinds])
        known = 2 * np.arange(len(self._scale)) + conditions.known
        self.numbers = np.concatenate([6 * self._nodes + kinds, -1 - known])

    @cached_property
    def _motion(self) -> Array:
        """(count, 3, m) displacements of the nodes of the unknowns by coordinates."""
        motion = (self._interface.motion * self._scale).reshape(self._interface.size, 3, -1)
        return np.asarray(motion[self._nodes])

    def solve(self, systems: SimilarSystems, free: Array, forces: Array) -> Response:
        """Solve the system; see `StuckSolution.release`.

        Args:
            systems: solves it.
            free: (N, d, J) gap and increment without tractions and coordinates.
            forces: (m, J) forces on the coordinates, R + H a.

        Raises:
            numpy.linalg.LinAlgError: if the conditions leave a motion without any resistance.
        """
        interface, count = self._interface, self.count
        target = np.vstack([-self._tests(free), -forces * self._unit[:, None]])
        known = self._known
        target[known] = self._conditions.amplitudes / self._scale[self._conditions.known, None]
        solved = systems.solve(self.numbers, self, target)
        coordinates = solved[count:] * self._scale[:, None]
        traction = self._tractions(solved[:count]) / self._level
        relative = interface.motion @ coordinates + free.reshape(traction.shape)
        for case, column in enumerate(traction.T):
            relative[:, case] += interface.compliance.apply(np.ascontiguousarray(column))
        relative[self._held] = 0.0
        return Response(traction.reshape(free.shape), relative.reshape(free.shape), coordinates)

    @property
    def entries(self) -> float:
        """Half of the compliance, which is symmetric."""
        return len(self._interface.gap) ** 2 / 2

    @property
    def _unit(self) -> Array:
        """(m,) of the forces on the coordinates."""
        return self._scale * self._level

    @property
    def _known(self) -> Indices:
        """Numbers of the unknowns that are known amplitudes."""
        return self.count + np.flatnonzero(self._conditions.known)

    def apply(self, vector: Array) -> Array:
        """(k,) the matrix times a vector (k,), without the matrix."""
        interface, count = self._interface, self.count
        coordinates, traction = vector[count:] * self._scale, self._tractions(vector[:count, None])
        moved = interface.compliance.apply(traction[:, 0]) / self._level
        moved += interface.motion @ coordinates
        found = np.empty(len(vector))
        found[:count] = self._tests(moved.reshape(-1, 3, 1))[:, 0] + self._own * vector[:count]
        forces = interface.stiffness @ coordinates * self._level
        found[count:] = (interface.motion.T @ traction[:, 0] - forces) * self._scale
        found[self._known] = vector[self._known]
        return found

    def matrix(self, precision: type[np.floating[Any]] = np.float64) -> NDArray[Any]:
        """(k, k) of the unknown tractions, then the coordinates."""
        everything = np.arange(self.count + len(self._scale))
        return self.block(everything, everything, precision)

    def block(
        self, rows: Indices, columns: Indices, precision: type[np.floating[Any]] = np.float64
    ) -> NDArray[Any]:
        """(r, c) of the matrix; rows and columns in increasing order."""
        found = np.zeros((len(rows), len(columns)), precision)
        (own, forces), (tractions, coordinates) = (
            np.split(each, [np.searchsorted(each, self.count)]) for each in (rows, columns)
        )
        split, width = len(own), len(tractions)
        self._interface.compliance.combine(
            (self._nodes[own], self._tested[own] / self._level),
            (self._nodes[tractions], self._trial[tractions]),
            found[:split, :width],
        )
        _, here, there = np.intersect1d(own, tractions, assume_unique=True, return_indices=True)
        found[here, there] += self._own[own[here]]
        forces, coordinates = forces - self.count, coordinates - self.count
        moved, pushed = (
            np.einsum("ij,ijk->ik", directions[chosen], self._motion[chosen])
            for directions, chosen in ((self._tested, own), (self._trial, tractions))
        )
        found[:split, width:], found[split:, :width] = moved[:, coordinates], pushed[:, forces].T
        stiffness = -self._interface.stiffness * np.outer(self._scale, self._unit)
        found[split:, width:] = stiffness[np.ix_(forces, coordinates)]
        known = np.flatnonzero(self._conditions.known[forces])
        found[split + known] = (forces[known] + self.count)[:, None] == columns
        return found

    def _tests(self, moved: Array) -> Array:
        """(count, J) what conditions are about of displacements (N, 3, J)."""
        return np.asarray(np.einsum("ij,ijk->ik", self._tested, moved[self._nodes]))

    def _tractions(self, solved: Array) -> Array:
        """(N*3, J) tractions by the unknown ones (count, J)."""
        traction = np.zeros((self._interface.size, 3, solved.shape[1]))
        np.add.at(traction, self._nodes, self._trial[:, :, None] * solved[:, None])
        return traction.reshape(-1, solved.shape[1])


class SlidingContact:
    """Solver of plane conditions under which most nodes slide, by the factors of earlier ones.

    Slip is eliminated: a slipping node has one unknown, its pressure. Components that are held or
    released other than in the factorised conditions border the system.

    Args:
        interface: the interface problem, d = 2.
    """

    def __init__(self, interface: Interface) -> None:
        self._interface = interface
        self._level, self._scale = interface.compliance.level, coordinate_scale(interface)
        self._base: Conditions | None = None
        self._held: Indices
        self._factors: tuple[Array, NDArray[np.int32]]
        self._columns: dict[tuple[int, float], Array]  # of the border so far

    def memory(self) -> dict[str, NDArray[Any]]:
        """The factorised conditions by name; see `recall`."""
        if self._base is None:
            return {}
        return {f"sliding_{name}": getattr(self._base, name) for name in SLIDING}

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on with the factors of `memory`."""
        if f"sliding_{SLIDING[0]}" in memory:
            status, pull, known = (memory[f"sliding_{name}"] for name in SLIDING)
            unread = np.zeros(0)
            self._factorise(Conditions(status, pull, unread, unread, known, unread))

    def solve(self, conditions: Conditions, free: Array, forces: Array) -> Response:
        """Solve contact conditions; arguments and errors as `StuckSolution.release`.

        Args:
            conditions: contact conditions; bodies do not float.
            free: (N, 2, J) gap and increment without tractions and coordinates.
            forces: (m, J) forces on the coordinates, R + H a.
        """
        if self._resembles(conditions):
            with suppress(np.linalg.LinAlgError):
                response = self._solve(conditions, free, forces)
                if response.residual < BORDER_ERROR:
                    return response
        self._factorise(conditions)
        return self._solve(conditions, free, forces)

    def _resembles(self, conditions: Conditions) -> bool:
        """Tell whether the border of the factorised conditions is narrow."""
        base = self._base
        if base is None or not np.array_equal(base.known, conditions.known):
            return False
        both = (base.status == SLIP) & (conditions.status == SLIP)
        changes = np.count_nonzero(_held(base) ^ _held(conditions)) + len(self._columns)
        few = changes < WIDEST_BORDER * len(self._held)
        return bool(few and np.array_equal(base.pull[both], conditions.pull[both]))

    def _factorise(self, conditions: Conditions) -> None:
        self._base, self._held, self._columns = None, np.flatnonzero(_held(conditions)), {}
        split, scale = len(self._held), self._scale
        matrix = np.empty((split + len(scale), split + len(scale)), order="F")
        matrix[:, :split] = self._effects(self._held, self._held, conditions)
        matrix[:split, split:] = self._interface.motion[self._held] * scale
        matrix[split:, split:] = -self._interface.stiffness * np.outer(scale, scale) * self._level
        known = split + np.flatnonzero(conditions.known)
        matrix[known] = 0.0
        matrix[known, known] = 1.0
        factors, pivots, info = dense.factorise(matrix)
        if info:
            raise np.linalg.LinAlgError(f"row {info} of the matrix depends on those before it")
        self._base, self._factors = conditions, (factors, pivots)

    def _effects(self, unknowns: Indices, rows: Indices, conditions: Conditions) -> Array:
        """(r + m, k) displacements of some components, then forces on coordinates, by tractions.

        The pressure of a slipping node brings its shear.
        """
        compliance, motion = self._interface.compliance, self._interface.motion * self._scale
        nodes = unknowns // 2
        pull = np.where(conditions.status[nodes] == SLIP, conditions.pull[nodes, 0], 0.0)
        pulled = np.flatnonzero((unknowns % 2 == 0) & (pull != 0))
        shear, pull = unknowns[pulled] + 1, pull[pulled]
        # Symmetric: long parts of few rows are copied faster.
        moved, sheared = (
            compliance.block(rows, each)
            if len(rows) < len(each)
            else compliance.block(each, rows).T
            for each in (unknowns, shear)
        )
        pushed = motion[unknowns]
        moved[:, pulled] += pull * sheared
        pushed[pulled] += pull[:, None] * motion[shear]
        return np.vstack([moved / self._level, pushed.T])

    def _border(self, added: Indices, removed: Indices, conditions: Conditions) -> Array:
        """(n + m, k) effects of added tractions and of released displacements, solved for."""
        slips, pull = conditions.status == SLIP, conditions.pull[:, 0]
        keys = [
            *((int(each), float(slips[each // 2] * pull[each // 2])) for each in added),
            *((int(each), 0.0) for each in removed),
        ]
        missing = [number for number, key in enumerate(keys) if key not in self._columns]
        if missing:
            new = np.concatenate([added, removed])[missing]
            count = int(np.count_nonzero(np.array(missing) < len(added)))
            columns = np.zeros((len(self._factors[1]), len(new)))
            columns[:, :count] = self._effects(new[:count], self._held, conditions)
            assert self._base is not None
            columns[len(self._held) + np.flatnonzero(self._base.known)] = 0.0
            columns[np.searchsorted(self._held, new[count:]), np.arange(count, len(new))] = -1.0
            solved = linalg.lu_solve(self._factors, columns, check_finite=False).T
            self._columns |= {
                keys[number]: own for number, own in zip(missing, solved, strict=True)
            }
        if not keys:
            return np.zeros((len(self._factors[1]), 0))
        return np.stack([self._columns[key] for key in keys], axis=1)

    def _solve(self, conditions: Conditions, free: Array, forces: Array) -> Response:
        base, held, interface = self._base, self._held, self._interface
        assert base is not None
        now, before, flat = _held(conditions), _held(base), free.reshape(-1, free.shape[-1])
        added, removed = np.flatnonzero(now & ~before), np.flatnonzero(before & ~now)
        target = np.vstack([-flat[held], -forces * self._scale[:, None] * self._level])
        known = len(held) + np.flatnonzero(base.known)
        target[known] = conditions.amplitudes / self._scale[base.known, None]
        found = linalg.lu_solve(self._factors, target, check_finite=False)
        columns = self._border(added, removed, conditions)
        # No displacement where tractions are added; where a component is released none of its own.
        rows = np.zeros((len(added) + len(removed), len(target)))
        rows[: len(added), : len(held)] = self._effects(held, added, base)[: len(added)]
        rows[: len(added), len(held) :] = interface.motion[added] * self._scale
        numbers, places = len(added) + np.arange(len(removed)), np.searchsorted(held, removed)
        rows[numbers, places] = 1.0
        shear = (removed % 2 == 1) & (conditions.status[removed // 2] == SLIP)
        rows[numbers[shear], places[shear] - 1] = -conditions.pull[removed[shear] // 2, 0]
        corner = np.zeros((len(rows), len(rows)))
        corner[: len(added), : len(added)] = self._effects(added, added, conditions)[: len(added)]
        missing = -rows @ found
        missing[: len(added)] -= flat[added]
        bordered = np.linalg.solve(corner - rows @ columns, missing)
        found -= columns @ bordered
        traction = np.zeros_like(flat)
        traction[held] = found[: len(held)] / self._level
        traction[added] = bordered[: len(added)] / self._level
        return self._response(conditions, traction, found[len(held) :] * self._scale[:, None], free)

    def _response(
        self, conditions: Conditions, traction: Array, coordinates: Array, free: Array
    ) -> Response:
        interface, base = self._interface, self._base
        assert base is not None
        stays = 2 * np.flatnonzero((base.status == SLIP) & (conditions.status == STICK))
        traction[stays + 1] += base.pull[stays // 2] * traction[stays]
        slips, opened = (np.flatnonzero(conditions.status == each) for each in (SLIP, OPEN))
        traction[2 * slips + 1] = conditions.pull[slips] * traction[2 * slips]
        traction[2 * opened] = traction[2 * opened + 1] = 0.0
        relative = interface.motion @ coordinates + free.reshape(traction.shape)
        size = float(np.abs(relative).max(initial=np.finfo(np.float64).tiny))
        for case, column in enumerate(traction.T):
            relative[:, case] += interface.compliance.apply(np.ascontiguousarray(column))
        held = _held(conditions)
        left = float(np.abs(relative[held]).max(initial=0.0)) / size
        relative[held] = 0.0
        return Response(
            traction.reshape(free.shape), relative.reshape(free.shape), coordinates, left
        )


def unknown_tractions(conditions: Conditions) -> int:
    """Number of traction components of a plane contact that are unknown without slip."""
    return int(np.count_nonzero(_held(conditions)))


def _held(conditions: Conditions) -> Bools:
    """(2 N,) components with an unknown traction once slip is eliminated."""
    status = conditions.status
    return np.column_stack([status != OPEN, status == STICK]).ravel()


class FactoredOperator:
    """Solves linear systems of an interface problem, factorised in the order of contact.

    Args:
        interface: the interface problem.
    """

    def __init__(self, interface: Interface) -> None:
        self.interface = interface
        self._order: ContactOrder | None = None
        self._count = FEWEST
        self._met = np.zeros(interface.size, dtype=np.int64)  # how often a node was in contact
        self._sliding = SlidingContact(interface)

    def area(self, closed: Bools, gap: Array) -> NestedArea:
        """Leading block that includes a contact area; the same object while it serves this one too.

        Args:
            closed: (N,) nodes in contact.
            gap: (N,) tells which of the other nodes are likely to close next.
        """
        self._met += closed
        if self._order is None or self._order.is_worn(closed):
            keys = gap / self.interface.roots, -self._met, ~closed  # the last one counts most
            if self._order is not None and self._order.factorised:
                # Never fewer than before: a contact that shrank will grow again.
                self._count = len(self._order.nodes)
            self._order = None  # its matrices make room for those of the next
            count = max(self._count, math.ceil(SPARE * int(closed.sum())))
            nodes = np.lexsort(keys)[:count]
            self._order = ContactOrder(self.interface, nodes, self._sliding)
        return self._order.area(closed)

    def memory(self) -> dict[str, NDArray[Any]]:
        """Numbers by name on which the next order, and so the round-off, depends; see `recall`."""
        found = {"operator_count": np.array(self._count), "operator_met": self._met}
        found |= self._sliding.memory()
        if self._order is None:
            return found
        order = self._order
        found["operator_order"] = order.nodes
        found["operator_cost"] = np.array([order.cost, order.rent])
        return {**found, **order.rows.memory()} if order.factorised else found

    def recall(self, memory: Mapping[str, NDArray[Any]]) -> None:
        """Go on as the operator, of the same interface, that `memory` is of: with its round-off."""
        self._count, self._met = int(memory["operator_count"]), memory["operator_met"]
        self._sliding.recall(memory)
        if "operator_order" in memory:
            self._order = ContactOrder(self.interface, memory["operator_order"], self._sliding)
            self._order.cost, self._order.rent = memory["operator_cost"].tolist()
            if "operator_rows" in memory:
                self._order.rows.recall(memory)

    def regularised(self, penalty: float) -> RegularisedFactor:
        """Bodies with an elastic layer between them.

        Args:
            penalty: compliance of the layer, in the unit of A.
        """
        return RegularisedFactor(self.interface, penalty)


class ContactOrder:
    """The compliance of the nodes that come into contact first, factorised in this order.

    It is not factorised before that pays: a contact that slides as a whole has no use for it.

    Args:
        interface: the interface problem.
        nodes: (K,) these nodes; the others do not touch.
        sliding: solves the conditions of plane problems most of whose nodes slide.

    Attributes:
        interface: the interface problem.
        sliding: as given.
        nodes: (K,) these nodes.
        components: (K*d,) theirs.
        others: components of the other nodes.
        level: mean compliance, the unit of tractions.
        scale: (m,) unit of each coordinate.
        motion: (K*d, m) G in these units and this order.
        stiffness: (m, m) K in these units.
        cost: of opening nodes out of order so far.
        rent: what direct solutions have cost so far beyond those with the factors.
    """

    def __init__(self, interface: Interface, nodes: Indices, sliding: SlidingContact) -> None:
        d = interface.components
        self.interface, self.sliding = interface, sliding
        self.nodes = nodes
        self.components = (nodes[:, None] * d + np.arange(d)).ravel()
        self._rank = np.full(interface.size, len(nodes))
        self._rank[nodes] = np.arange(len(nodes))
        self._step = max(1, round(STEP * len(nodes)))
        self._area: NestedArea | None = None
        self.cost = self.rent = 0.0
        self.level = interface.compliance.level
        self.scale = coordinate_scale(interface)
        self.motion = interface.motion[self.components] * self.scale
        self.others = np.delete(np.arange(interface.size * d), self.components)
        self.stiffness = interface.stiffness * np.outer(self.scale, self.scale) * self.level

    @cached_property
    def effect(self) -> tuple[Array, Array]:
        """Displacements of the others by tractions, then by coordinates, in these units."""
        tractions = self.interface.compliance.block(self.others, self.components)
        tractions /= self.level
        return tractions, self.interface.motion[self.others] * self.scale

    @cached_property
    def inverse(self) -> NestedInverse:
        """Inverses of the leading blocks of A.

        Raises:
            ModelError: if A is not positive definite.
        """
        # In Fortran's order: a symmetric matrix.
        matrix = self.interface.compliance.block(self.components, self.components).T
        matrix /= self.level
        try:
            return NestedInverse(matrix)
        except np.linalg.LinAlgError as error:
            raise ModelError(
                "expected a compliance of the contact nodes that is positive definite, found that "
                f"{error}: some nodes of the surface that carries the multipliers face nothing, or "
                "round-off has destroyed the stiffness of a body"
            ) from None

    @cached_property
    def rows(self) -> InverseRows:
        """Rows of these inverses, and G times them."""
        return InverseRows(self.inverse, self.motion)

    @property
    def factorised(self) -> bool:
        """True once the inverses are there."""
        return "rows" in vars(self)

    def direct_pays(self, direct: int, size: int, released: Indices) -> bool:
        """Tell whether to solve a system directly, until what that costs would pay for the inverse.

        Args:
            direct: number of unknowns of the direct system.
            size: of the leading block.
            released: (k,) components whose rows of the inverse the other system takes.
        """
        whole, count = self.interface.size * self.interface.components, len(released)
        extra = (direct**3 - count**3) / 3 + READING * (
            direct**2 + whole**2 / 2 - count * size - len(self.others) * size
        )
        if self.factorised:
            price = self.rows.missing(released) * size**2 / 2
        else:
            price = count * size**2 / 2 + len(self.components) ** 3 / 3
        if extra > price - self.rent:
            self.rent = 0.0
            return False
        self.rent += max(extra, 0.0)
        return True

    def is_worn(self, closed: Bools) -> bool:
        """Tell whether another order is needed, or has been paid by opening nodes out of order.

        Counts the contact area as solved once more.
        """
        if self._last(closed) > len(self.nodes):
            return True
        opened = self._last(closed) - int(closed.sum())
        if not self.factorised:  # another one costs nothing
            return opened > 0
        size, released = len(self.components), opened * self.interface.components
        self.cost += OPENING * released * int(closed.sum()) + released**3
        return opened > 0 and self.cost > size**3

    def area(self, closed: Bools) -> NestedArea:
        """The leading block that includes a contact area."""
        count = min(-(-self._last(closed) // self._step) * self._step, len(self.nodes))
        if self._area is None or self._area.count != count:
            self._area = NestedArea(self, count)
        return self._area

    def _last(self, closed: Bools) -> int:
        """Number of nodes up to the last one in contact."""
        return int(self._rank[closed].max(initial=-1)) + 1


class NestedArea:
    """The first nodes of an order.

    Args:
        order: of the nodes.
        count: how many take part; all others have no traction.
    """

    def __init__(self, order: ContactOrder, count: int) -> None:
        self.order = order
        self.count = count
        self.size = count * order.interface.components

    def stuck(self, free: Array, forces: Array) -> StuckSolution:
        """Full stick of the area under loads.

        Args:
            free: (N, d, J) gap and increment without tractions and coordinates.
            forces: (m, J) forces on the coordinates, R + H a; where the amplitude is known they
                make no difference.
        """
        return StuckSolution(self, free, forces)


class StuckSolution:
    """Solution with every node of an area stuck, from which nodes and coordinates are released.

    Args:
        area: the leading block.
        free: (N, d, J) displacements without tractions and coordinates.
        forces: (m, J) on the coordinates.
    """

    def __init__(self, area: NestedArea, free: Array, forces: Array) -> None:
        order = area.order
        self._area = area
        self._given = free, forces
        self._free = free.reshape(-1, free.shape[-1])
        self._forces = forces * order.scale[:, None] * order.level
        # Not kept from one step to the next: a run that is continued has the same round-off.
        self._direct = SimilarSystems()

    @cached_property
    def _missing(self) -> Array:
        """(m, J) forces that the tractions leave over with all coordinates at rest."""
        order, size = self._area.order, self._area.size
        left = order.rows.vectors(size) @ self._free[order.components[:size]]
        return np.asarray(left - self._forces)

    @cached_property
    def _traction(self) -> Array:
        """(n*d, J) tractions with all coordinates at rest."""
        order, size = self._area.order, self._area.size
        return order.inverse.solve(size, -self._free[order.components[:size]])

    @property
    def coordinates(self) -> Array:
        """(m, J) c with the prescribed ones at rest; of many solutions the smallest."""
        order, size = self._area.order, self._area.size
        moving = np.flatnonzero(~order.interface.prescribed)
        resistance = order.stiffness + order.rows.vectors(size) @ order.motion[:size]
        found = np.zeros_like(self._forces)
        # Too few nodes in contact may leave some motions free: the smallest motion.
        moved = linalg.pinvh(resistance[np.ix_(moving, moving)]) @ -self._missing[moving]
        found[moving] = moved
        return found * order.scale[:, None]

    def release(self, conditions: Conditions) -> Response:
        """Let go of what is open, slipping or without known amplitude.

        Args:
            conditions: stick or slip within the contact area only.

        Raises:
            numpy.linalg.LinAlgError: if the conditions leave a motion without any resistance. Where
                round-off resists it, it is out of all proportion to that in full stick.
        """
        area, order = self._area, self._area.order
        released = _Released(area, conditions)
        count = len(released.all)
        if not conditions.floating and order.interface.components == 2:
            if unknown_tractions(conditions) <= SLIDES * count:
                return order.sliding.solve(conditions, *self._given)
        elif not conditions.floating:
            system = DirectSystem(order.interface, conditions)
            if order.direct_pays(system.count, area.size, released.all):
                return system.solve(self._direct, *self._given)
        # Tractions by unit displacements of the released components, less those by coordinates.
        units, vectors = order.rows.units(area.size, released.all), order.rows.vectors(area.size)
        matrix = np.empty((count + len(vectors), count + len(vectors)))
        # Symmetric.
        units.block(released.all, matrix[:count, :count])
        matrix[count:, :count] = vectors[:, released.all]
        matrix[:count, count:] = -matrix[count:, :count].T
        matrix[count:, count:] = -(vectors @ order.motion[: area.size]).T - order.stiffness
        target = np.vstack([-self._traction[released.all], self._missing])
        released.let_slip(conditions, matrix, target, (units, vectors), self._traction)
        known = count + np.flatnonzero(conditions.known)
        matrix[known] = 0.0
        matrix[known, known] = 1.0
        target[known] = conditions.amplitudes / order.scale[conditions.known, None]
        residual = 0.0
        if conditions.floating:
            changes, residual = _least_motion(matrix, target, count)
        else:
            # Factors of another one would leave too much: gaps are large against what slips.
            changes = SimilarSystems().solve(released.all, MatrixSystem(matrix), target)
        solved = self._traction + units.combined(changes[:count])
        solved -= vectors.T @ changes[count:]
        return self._response(solved, released, changes, residual)

    def _response(
        self, solved: Array, released: _Released, changes: Array, residual: float
    ) -> Response:
        order, size = self._area.order, self._area.size
        count = len(released.all)
        traction, relative = np.zeros_like(self._free), np.zeros_like(self._free)
        traction[order.components[:size]] = solved / order.level
        relative[order.components[released.all]] = changes[:count]
        beyond, coordinates = order.components[size:], changes[count:]
        relative[beyond] = self._free[beyond]
        relative[beyond] += dense.multiply(order.inverse.beyond(size).T, solved)
        relative[beyond] += order.motion[size:] @ coordinates
        tractions, motion = order.effect
        relative[order.others] = self._free[order.others]
        relative[order.others] += dense.multiply(tractions[:, :size], solved)
        relative[order.others] += motion @ coordinates
        shape = (order.interface.size, order.interface.components, -1)
        return Response(
            traction.reshape(shape),
            relative.reshape(shape),
            coordinates * order.scale[:, None],
            residual,
        )


class _Released:
    """Components of an area whose displacements conditions leave open.

    Attributes:
        all: their numbers in the order of the area: open nodes, then the shear of slipping ones.
        sliding: the range of the latter in `all`.
    """

    def __init__(self, area: NestedArea, conditions: Conditions) -> None:
        order, d = area.order, area.order.interface.components
        nodes = order.nodes[: area.count]
        status = conditions.status[nodes]
        start = np.arange(area.count) * d
        opened = (start[status == OPEN][:, None] + np.arange(d)).ravel()
        self._level = order.level
        self._slipping = nodes[status == SLIP]
        self._normal = start[status == SLIP]
        shear = (self._normal[:, None] + np.arange(1, d)).ravel()
        self.all = np.concatenate([opened, shear])
        self.sliding = slice(len(opened), len(self.all))

    def let_slip(
        self,
        conditions: Conditions,
        matrix: Array,
        target: Array,
        tractions: tuple[UnitRows, Array],
        stuck: Array,
    ) -> None:
        """Replace "no shear" in the rows of slipping nodes by the conditions of slip.

        Args:
            conditions: conditions.
            matrix: (k, k) changed in place: released tractions by all unknowns.
            target: (k, J) changed in place.
            tractions: all by the released components, and (m, n*d) less those by coordinates.
            stuck: (n*d, J) tractions in full stick.
        """
        nodes, normal = self._slipping, self._normal
        shape = len(nodes), conditions.pull.shape[1]
        rows, targets = (
            each[self.sliding].reshape(*shape, each.shape[1]) for each in (matrix, target)
        )
        if shape[1] > 1:
            turning = conditions.turned(nodes)
            for values in (rows, targets):
                values -= turning @ values
            # Of q − r Δ; Δ is an unknown itself.
            own = self.sliding.start + np.arange(rows[..., 0].size).reshape(*shape, 1)
            penalty = conditions.penalty[nodes, None, None] * self._level
            matrix[own, own.swapaxes(1, 2)] += turning * penalty
        count = len(self.all)
        units, vectors = tractions
        pressures, beside = units.block(normal).T, vectors[:, normal].T
        for direction, pull in enumerate(conditions.pull[nodes].T[..., None]):
            rows[:, direction, :count] -= pull * pressures
            rows[:, direction, count:] += pull * beside
            targets[:, direction] += pull * stuck[normal]


def _least_motion(matrix: Array, target: Array, count: int) -> tuple[Array, float]:
    """Smallest solution of a system that leaves some motions free, and its relative residual.

    Args:
        matrix: (k, k) released components by all unknowns, then forces by all unknowns.
        target: (k, J) right-hand sides.
        count: number of released components; coordinates follow.
    """
    # Rows and columns are of different units: they are brought to one size first.
    # A coordinate that nothing resists has none.
    rows = np.linalg.norm(matrix, axis=1)[:, None]
    rows[rows == 0] = 1.0
    matrix, target = matrix / rows, target / rows
    columns = np.linalg.norm(matrix, axis=0)[:, None]
    columns[columns == 0] = 1.0
    matrix = matrix / columns.T
    solve = _floating_solver(matrix, count)
    # The second time for what the first one leaves, a small difference of large tractions.
    changes = solve(target)
    changes += solve(target - matrix @ changes)
    size = max(float(np.linalg.norm(target)), np.finfo(np.float64).tiny)
    return changes / columns, float(np.linalg.norm(matrix @ changes - target)) / size


def _floating_solver(matrix: Array, count: int) -> Callable[[Array], Array]:
    """Function that solves a system whose coordinates alone, after the first `count`, may float.

    What moves without resistance is found among the few coordinates, once the released components
    are eliminated: a rank-revealing decomposition of the whole system would take far longer.
    """
    factor = linalg.lu_factor(matrix[:count, :count])
    coupling, forces = matrix[:count, count:], matrix[count:, :count]
    moved = linalg.lu_solve(factor, coupling)
    moved += linalg.lu_solve(factor, coupling - matrix[:count, :count] @ moved)
    resistance = matrix[count:, count:] - forces @ moved
    left, values, right = np.linalg.svd(resistance)
    # Of the size that the terms of the difference have.
    rank = int(np.sum(values > UNRESISTED * np.linalg.norm(matrix[count:, count:], 2)))
    free = np.vstack([-moved @ right[rank:].T, right[rank:].T])

    def solve(target: Array) -> Array:
        released = linalg.lu_solve(factor, target[:count])
        missing = left[:, :rank].T @ (target[count:] - forces @ released)
        found = right[:rank].T @ (missing / values[:rank, None])
        changes = np.vstack([released - moved @ found, found])
        return np.asarray(changes - free @ np.linalg.lstsq(free, changes, rcond=None)[0])

    return solve
