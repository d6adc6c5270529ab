# SPDX-License-Identifier: LGPL-3.0-or-later
"""Boundaries that move by an amplitude, and supports, which hold them."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.cyclic import Tie
from fretfe.bodies.point_values import FLAT
from fretfe.case import Case, complaint, unit_vector
from fretfe.case.base import AXES
from fretfe.contact.interface import Course, Resultant
from fretfe.errors import CaseError


@dataclass(frozen=True, eq=False)
class NodalShape:
    """A displacement of the nodes of a boundary.

    Attributes:
        points: (n, d) the nodes.
        values: (n, d) their displacement.
    """

    points: Array
    values: Array

    def at(self, points: Array) -> Array:
        """(m, d) displacement of some of the nodes, given by their places (m, d)."""
        if not len(points):
            return np.zeros_like(points)
        distance, nearest = cKDTree(self.points).query(points)
        assert distance.max() < FLAT * np.ptp(self.points, axis=0).max(), "not one of the nodes"
        return np.asarray(self.values[nearest])


@dataclass(frozen=True)
class Constraint:
    """A boundary that moves by one amplitude: along a direction, about an axis, or by a shape.

    Attributes:
        label: name used in results and messages.
        boundary: physical group.
        direction: unit vector with the components of the displacement; (0, ...) of a tilt or a
            shape.
        roller: true if only the displacement along `direction` is constrained, false if each of its
            non-zero components is.
        axis: unit vector (3,) of the axis of a tilt; empty otherwise.
        centre: (gdim,) a point on that axis.
        shape: displacement of each node of the boundary, if it is no rigid motion.
        at: (gdim,) place of the only node of the boundary that it holds; empty for all of them.
        within: distance up to which a node is at that place.
        resultant: force or moment that it gives where it holds what moves by a shape.
        overlap: true of tied parts of which its boundary moves against the one that it follows.
        around: unit vectors (n, c) at points (n, gdim) of a roller along directions about the axis
            of a sector; None of one along `direction`.
    """

    label: str
    boundary: str
    direction: tuple[float, ...]
    roller: bool = False
    axis: tuple[float, ...] = ()
    centre: tuple[float, ...] = ()
    shape: NodalShape | None = None
    at: tuple[float, ...] = ()
    within: float = 0.0
    resultant: Resultant | None = None
    overlap: bool = False
    around: Callable[[Array], Array] | None = None

    def along(self, points: Array) -> Array:
        """(n, c) directions at points (n, gdim) along which a roller holds them."""
        if self.around is not None:
            return self.around(points)
        return np.tile(np.array(self.direction), (len(points), 1))

    def holds(self, points: Array) -> Bools:
        """(n,) which nodes of its boundary, at points (n, gdim), it constrains."""
        if not self.at:
            return np.ones(len(points), dtype=bool)
        return np.asarray(np.linalg.norm(points - np.array(self.at), axis=1) < self.within)

    @property
    def components(self) -> Indices:
        """Components of the displacement that it constrains, unless it is a roller."""
        if self.axis or self.shape is not None:
            return np.arange(len(self.direction))
        return np.flatnonzero(self.direction)

    def displacement(self, points: Array) -> Array:
        """(n, c) displacement of points (n, gdim) by a unit amplitude."""
        if self.shape is not None:
            return self.shape.at(points)
        if not self.axis:
            return np.tile(np.array(self.direction), (len(points), 1))
        arms = np.zeros((len(points), 3))
        arms[:, : points.shape[1]] = points - np.array(self.centre)
        return np.cross(self.axis, arms)[:, : len(self.direction)]


class Driven(NamedTuple):
    """A constraint and what its coordinate has to know."""

    constraint: Constraint
    control: str = "fixed"
    channel: str = ""
    course: Course | None = None


def support_constraints(
    case: Case, size: int, boundaries: Container[str], tie: Tie | None
) -> list[Driven]:
    """Components that are held, then the inclined rollers: those go last at a common node.

    Args:
        case: the case.
        size: components of the displacement.
        boundaries: of the body.
        tie: of the sides of a sector, if the body has some.

    Raises:
        CaseError: if a body that has no sides of a sector is held along a direction about its axis.
    """
    fixed, rollers = list[Driven](), list[Driven]()
    for name, support in case.supports.items():
        on, rest = support.boundary, (0.0,) * size
        if on not in boundaries:
            continue
        if support.direction is not None:
            along = unit_vector(support.direction, size)
            rollers.append(Driven(Constraint(name, on, along, roller=True)))
        sided = " and ".join(repr(axis) for axis in support.fix if axis not in AXES)
        if sided and tie is None:
            text = f"expected {sided} at a body with sides of a sector, found one without"
            raise CaseError(complaint(case.source, ("supports", name, "fix"), text))
        for axis in support.fix:
            label = f"{name} {axis}"
            if axis in AXES[:size]:
                fixed.append(Driven(Constraint(label, on, unit_vector(axis, size))))
            elif tie is not None and axis not in AXES:
                around = tie.radial if axis == "radial" else tie.tangential
                rollers.append(Driven(Constraint(label, on, rest, roller=True, around=around)))
    return fixed + rollers
