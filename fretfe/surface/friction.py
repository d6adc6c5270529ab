# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coulomb's coefficient on a contact surface; all stages ask here for it, by state and node."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.case.base import AXES
from fretfe.errors import CaseError
from fretfe.loads.friction import BEYOND, Coefficients
from fretfe.surface.contact_surface import ContactSurface


@dataclass(frozen=True, eq=False)
class Friction:
    """Coefficient in T states at the N nodes of a contact.

    That of a state acts in the step that ends there. Within a step it does not change, so that each
    step is an exact Coulomb problem.

    Attributes:
        fields: (U, N) coefficients at the nodes, for U different states of the surfaces.
        number: (T,) which of them each state has.
    """

    fields: Array
    number: Indices

    @classmethod
    def of(cls, given: Coefficients, times: Array, surface: ContactSurface) -> Friction:
        """That of a contact of a case, for states at times (T,), which covers the surface."""
        if given.even:
            return cls.uniform(given.over(times), len(surface.weights))
        own = _along(given, surface)
        return cls(np.array([np.zeros_like(own), own]), (times > given.begins).astype(np.int64))

    @classmethod
    def uniform(cls, coefficients: Array, nodes: int) -> Friction:
        """The same coefficient (T,) at all of some nodes."""
        found, number = np.unique(coefficients, return_inverse=True)
        return cls(np.broadcast_to(found[:, None], (len(found), nodes)), number)

    def at(self, states: Any, nodes: Any = slice(None)) -> Array:
        """(S, N) coefficients in states (S,) at nodes (N,) or at all; (N,) in one state."""
        return np.asarray(self.fields[self.number[states]][..., nodes])

    def among(self, states: Any) -> Array:
        """(U, N) different coefficients of all nodes in some states."""
        return self.fields[np.unique(self.number[states])]

    def at_edge(self, nodes: Indices) -> Array:
        """(T,) coefficient at an edge that is at a node (T,) in each state."""
        return np.asarray(self.fields[self.number, nodes])

    def picked(self, states: Any) -> Friction:
        """Those of some states."""
        return replace(self, number=self.number[states])

    def of_nodes(self, nodes: Indices) -> Friction:
        """Those of some nodes, in their order."""
        return replace(self, fields=self.fields[:, nodes])

    def differs(self, other: Friction) -> Bools:
        """(T,) states in which the other one is different at some node."""
        pairs, place = np.unique([self.number, other.number], axis=1, return_inverse=True)
        differ = (self.fields[pairs[0]] != other.fields[pairs[1]]).any(axis=1)
        return np.asarray(differ[place.ravel()])

    @property
    def acts(self) -> Bools:
        """(T,) states in whose step there is friction at some node."""
        return np.asarray(self.fields.any(axis=1)[self.number])

    @property
    def largest(self) -> float:
        """Largest coefficient in any state."""
        return float(self.fields[self.number].max())


def require_covered(given: Coefficients, surface: ContactSurface) -> None:
    """Check that coefficients are given all over a surface.

    Raises:
        CaseError: they are not, or those along an arc are for a surface of solids.
    """
    if given.even:
        return
    try:
        _along(given, surface)
    except CaseError as error:
        raise CaseError(f"{given.key}: {error}") from None


def _along(table: Coefficients, surface: ContactSurface) -> Array:
    """(N,) coefficients of a table at the nodes of a surface."""
    dimension = surface.points.shape[1]
    if table.arc is not None:
        if dimension == 3:
            raise CaseError("expected places x, y and z on a surface of solids, found arc lengths")
        return _on_arc(table.arc, table.values, surface.arc)
    assert table.points is not None
    if table.points.shape[1] != dimension:
        raise CaseError(
            f"expected the columns {', '.join(AXES[:dimension])}, found "
            f"{', '.join(AXES[: table.points.shape[1]])}"
        )
    return table.values[_nearest(table.points, surface.points)]


def _on_arc(places: Array, values: Array, arc: Array) -> Array:
    """(N,) values at arc lengths (N,) of the nodes, straight lines between those at some places."""
    slack = BEYOND * float(np.ptp(arc))
    if places[0] > arc[0] + slack or places[-1] < arc[-1] - slack:
        raise CaseError(
            f"expected coefficients over the whole surface, arc lengths {arc[0]:.6g} to "
            f"{arc[-1]:.6g}, found them from {places[0]:g} to {places[-1]:g}"
        )
    return np.interp(arc, places, values)


def _nearest(points: Array, nodes: Array) -> Indices:
    """(N,) number of the point nearest to each node, none farther than points are apart."""
    # Imported where it is needed: reports of plane contacts do without SciPy.
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    away, nearest = tree.query(nodes)
    gaps = tree.query(points, k=2)[0][:, 1]
    farthest, apart = int(np.argmax(away)), float(gaps[np.isfinite(gaps)].max(initial=0.0))
    if away[farthest] > apart:
        place = ", ".join(f"{each:.6g}" for each in nodes[farthest])
        raise CaseError(
            f"expected points over the whole surface, found none nearer to ({place}) than "
            f"{away[farthest]:.3g}, where points are up to {apart:.3g} apart"
        )
    return np.asarray(nearest)
