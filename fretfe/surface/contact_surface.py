# SPDX-License-Identifier: LGPL-3.0-or-later
"""The surface of a contact as all later stages read it: made once, and carried whole."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Bools, Indices

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


@dataclass(frozen=True, eq=False)
class ContactSurface:
    """The N nodes of a contact, of the side that carries the tractions; d coordinates.

    Attributes:
        arc: (N,) arc length along the surface, increasing in +x; of solids (0,).
        points: (N, d) coordinates of the nodes before deformation.
        frames: (N, c, c) rows: outward normal of body 2, tangents; c components of tractions, those
            of plane bodies that move along z too are 3.
        weights: (N,) length, or area, that belongs to each node (integral of its hat function).
        facets: (F, 3 or 4) nodes of the facets of the surface, counter-clockwise seen from outside
            body 2; None in the plane.
        free: (N,) nodes on the rim of the surface at which both bodies end; None in the plane.
        continued: (N, d) unit normals of planes of symmetry behind which both of them go on, at
            nodes on that rim, in the plane at both ends; zero where the next sector continues
            them, NaN elsewhere. None in the plane if they end at both ends.
        dundurs: Dundurs' beta, body 1 above, of solids in plane strain; zero of similar bodies, and
            where it has no part in the evaluation: without friction, and of crystals.
        growth: of the elements of plane bodies with the distance from where they are fine; zero of
            half-planes, and of solutions that were read, whose evaluation is read too.
        layer: (2,) E* times the compliances of a layer to pressure and to shear, the largest all
            over the surface: lengths over which tractions next to an edge are rounded off; None
            without a layer.
        added_gap: (N,) E* times the gap that a case adds; None without one.
    """

    arc: Array
    points: Array
    frames: Array
    weights: Array
    facets: Indices | None = None
    free: Bools | None = None
    continued: Array | None = None
    dundurs: float = 0.0
    growth: float = 0.0
    layer: Array | None = None
    added_gap: Array | None = None

    def nodes_at(self, edge: Array) -> Indices:
        """(T,) node nearest to an edge in each state.

        Where its place is not known, that of the next state in which it is, or of the last one.

        Args:
            edge: (T,) its place along the arc; of solids (T, 3).
        """
        known = np.flatnonzero(np.isfinite(edge.reshape(len(edge), -1)).all(axis=1))
        if not len(known):
            return np.zeros(len(edge), dtype=np.int64)
        if self.facets is None:
            found = np.searchsorted((self.arc[1:] + self.arc[:-1]) / 2, edge[known])
        else:
            found = self.tree.query(edge[known])[1]
        following = np.searchsorted(known, np.arange(len(edge)))
        return np.asarray(found[np.minimum(following, len(known) - 1)])

    @cached_property
    def tree(self) -> cKDTree:
        """Of the nodes, for those next to a place."""
        # Imported where it is needed: reports of plane contacts do without SciPy.
        from scipy.spatial import cKDTree

        return cKDTree(self.points)

    @property
    def mean_normal(self) -> Array:
        """(d,) mean unit normal of body 2 over the surface, with as many components as points."""
        mean: Array = self.weights @ self.frames[:, 0, : self.points.shape[1]]
        return mean / np.linalg.norm(mean)
