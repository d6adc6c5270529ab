# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sections of plane contacts: values along a line that runs from a contact front inward.

Fits know no front, they are given distances s >= 0 inward from it. Here a plane contact is cut into
sections, one at each of its two fronts: left and right, and their signs, stand nowhere else but in
``fretfe.analytic``. A patch is a run of nodes in contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Indices, Positions
from fretfe.analytic._numerics import Side
from fretfe.evaluate.contacts import Frame
from fretfe.evaluate.numerics import pressure_moments

Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, slots=True)
class Patch:
    """A run of nodes in contact, first to last (both included), and the force it carries."""

    first: int
    last: int
    force: float


@dataclass(frozen=True)
class Resultants:
    """P, Q (force per thickness) and the moment of the pressure about the given centre."""

    normal_force: float
    shear_force: float
    moment: float


def contact_patches(x: Array, p: Array, tol: float = 0.0) -> list[Patch]:
    """Return the runs of nodes with p > tol (a pressure), from left to right; x, p (n,)."""
    ends = np.flatnonzero(np.diff(p > tol, prepend=False, append=False)).reshape(-1, 2)
    share = p * _node_lengths(x)
    return [Patch(int(i), int(j) - 1, float(share[i:j].sum())) for i, j in ends]


def main_patch(x: Array, p: Array, tol: float = 0.0) -> Patch:
    """Return the patch that carries most force.

    Raises:
        ValueError: if no node has p > tol.
    """
    patches = contact_patches(x, p, tol)
    if not patches:
        raise ValueError(f"p must exceed tol = {tol:g} at one node at least, found none")
    return max(patches, key=lambda patch: patch.force)


def resultants(x: Array, p: Array, q: Array, centre: float) -> Resultants:
    """Return the exact resultants of piecewise-linear tractions; x, p, q (n,).

    A positive moment presses on the side x > centre.
    """
    length, moment = _node_lengths(x), pressure_moments(x, p[None], np.array([centre]))
    return Resultants(float(length @ p), float(length @ q), float(moment[0]))


def _node_lengths(x: Array) -> Array:
    """Return the integrals of the hat functions of all nodes."""
    h = np.diff(x, prepend=x[0], append=x[-1])
    return (h[1:] + h[:-1]) / 2


@dataclass(frozen=True)
class Section:
    """Values of T states at the nodes in contact, from the outermost one inward.

    Attributes:
        s: (T, m) distances from the outermost node; NaN behind the last node in contact.
        values: (T, m) pressures, or what vanishes at a border like a pressure; zero behind that.
        nodes: (T,) numbers of nodes in contact.
        origin: (T,) places of the outermost nodes along the arc.
        inward: direction of the section along the arc, 1 or -1.
    """

    s: Array
    values: Array
    nodes: Positions
    origin: Array
    inward: int

    def place(self, s: Array) -> Array:
        """Return (T,) places along the arc from (T,) distances."""
        return np.asarray(self.origin + self.inward * s)

    def of_states(self, states: Positions) -> Section:
        """Return the section in some of its states."""
        s, values = self.s[states], self.values[states]
        return Section(s, values, self.nodes[states], self.origin[states], self.inward)


@dataclass(frozen=True)
class PlaneFront:
    """A front of a plane contact.

    Attributes:
        number: place in ``PLANE_FRONTS``.
        name: "left" or "right".
        inward: direction into the contact along the arc, 1 or -1.
    """

    number: int
    name: Side
    inward: int

    def section(self, x: Array, values: Array, patches: Sequence[Patch]) -> Section:
        """Return the section of T states through one patch each.

        Args:
            x: (n,) positions along the arc, increasing.
            values: (T, n).
            patches: one for each state.
        """
        origin = np.array([self.outermost(patch) for patch in patches], dtype=np.intp)
        nodes = np.array([patch.last - patch.first + 1 for patch in patches], dtype=np.intp)
        count = np.arange(nodes.max(initial=1))
        inside = count < nodes[:, None]
        index = origin[:, None] + self.inward * np.minimum(count, nodes[:, None] - 1)
        s = np.where(inside, self.inward * (x[index] - x[origin][:, None]), np.nan)
        along = np.where(inside, np.take_along_axis(values, index, axis=1), 0.0)
        return Section(s, along, nodes, x[origin], self.inward)

    def outermost(self, patch: Patch) -> int:
        """Return the node of a patch that is next to this front."""
        return patch.first if self.inward > 0 else patch.last

    def from_front(self, values: NDArray[Scalar]) -> NDArray[Scalar]:
        """Return (..., n) values at nodes along the arc in the order in which they lie inward."""
        return values[..., :: self.inward]

    def distances(self, x: Array, position: float) -> Array:
        """Return (n,) distances inward of places along the arc, in the order of ``from_front``."""
        return self.from_front(self.inward * (x - position))

    def axis(self, line: Array, size: int) -> Array:
        """Return the direction (size,) of shear along the arc and, if there are two, along z.

        Args:
            line: (2,) by `inward` and `along`, which is -z at the left front.
            size: number of tangential components.
        """
        return np.asarray(self.inward * (line * [1.0, -1.0])[:size])

    def frame(self, across: Array, tangent: Array) -> Frame:
        """Return the frame of the front's station.

        Args:
            across: (2,) outward normal of body 2, of any length.
            tangent: (2,) direction of the arc, of any length.
        """
        normal, inward = (
            np.append(vector / np.linalg.norm(vector), 0.0)
            for vector in (across, self.inward * tangent)
        )
        return Frame(inward=inward, along=np.cross(normal, inward), across=normal)


PLANE_FRONTS = (PlaneFront(0, "left", 1), PlaneFront(1, "right", -1))


def plane_front(name: str) -> PlaneFront:
    """Return a front of a plane contact.

    Raises:
        ValueError: if the name is neither "left" nor "right".
    """
    for front in PLANE_FRONTS:
        if front.name == name:
            return front
    raise ValueError(f"front must be 'left' or 'right', found {name!r}")


def plane_sections(x: Array, values: Array, along: Array | None = None) -> tuple[Section, ...]:
    """Return the sections of T states at both fronts of the main patches; x (n,), values (T, n).

    Args:
        x: (n,) positions along the arc, increasing.
        values: (T, n) pressures, which tell the patches.
        along: (T, n) the values of the sections; None for the pressures.

    Raises:
        ValueError: if nothing is in contact in a state.
    """
    patches = [main_patch(x, state) for state in values]
    along = values if along is None else along
    return tuple(front.section(x, along, patches) for front in PLANE_FRONTS)


def hats(arc: Array) -> tuple[Array, Array]:
    """Return (N,) centres of the hat functions over which means are taken, and their variances.

    On uneven meshes the centres are not at the nodes.

    Args:
        arc: (N,) of the nodes.
    """
    before, after = (np.diff(arc, prepend=arc[0]), np.diff(arc, append=arc[-1]))
    return arc + (after - before) / 3, (before**2 + before * after + after**2) / 18


def nearest_front(x: Array, centre: float) -> Indices:
    """Return (n,) the number of the front that each place (n,) along the arc belongs to."""
    return (~(x < centre)).astype(np.int64)
