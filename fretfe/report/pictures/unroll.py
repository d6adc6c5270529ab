# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces of solids laid into a plane.

A surface that is bent about one direction only, such as a flank, is unrolled: lengths and angles
stay. One that is flat, or bent about two directions, is projected onto its plane.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array
from fretfe.history.solution import ContactHistory
from fretfe.report.texts import direction_text

# Cosine of the angle that the normals of a surface may have to their mean if it is called flat.
FLAT = 0.99
# Of a surface that can be unrolled: that cosine at least; tilt of the normals out of the plane in
# which they turn, over their turning, at most.
STEEPEST = 0.15
TWIST = 0.15


@dataclass(frozen=True)
class Unrolled:
    """A surface in a plane, seen from outside body 2.

    Attributes:
        places: (N, 2) of the nodes, from the middle of the surface.
        axes: (N, 2, 3) unit vectors along the surface that lie along the axes of the plane.
        directions: (2, 3) of the axes in the middle.
        middle: (3,) centre of the surface.
        how: it came into the plane, in words.
    """

    places: Array
    axes: Array
    directions: Array
    middle: Array
    how: str

    @property
    def names(self) -> tuple[str, str]:
        """Names of the axes: the axes of the case that they come nearest to, with their signs."""
        first, second = (towards(direction) for direction in self.directions)
        return first, second

    def at(self, contact: ContactHistory, points: Array) -> Array:
        """(n, 2) where points (n, 3) on the surface, or close to it, lie in the plane.

        NaN where they are. Measured from the nearest node of the contact, along the surface there.
        """
        # Imported where it is needed: plane contacts are not unrolled.
        from scipy.spatial import cKDTree

        places = np.full((len(points), 2), np.nan)
        known = np.isfinite(points).all(axis=1)
        nearest = cKDTree(contact.surface.points).query(points[known])[1]
        offsets = points[known] - contact.surface.points[nearest]
        moved = np.einsum("nad,nd->na", self.axes[nearest], offsets)
        places[known] = self.places[nearest] + moved
        return places

    def turned(self) -> Unrolled:
        """The same, turned by a quarter so that the second axis points to the right."""
        return replace(
            self,
            places=_quarter(self.places, 1),
            axes=_quarter(self.axes, 1),
            directions=_quarter(self.directions, 0),
        )


def towards(direction: Array) -> str:
    """The axis of the case that a direction (3,) comes nearest to, with its sign."""
    place = int(np.abs(direction).argmax())
    return f"{'' if direction[place] > 0 else '−'}{'xyz'[place]}"


def _quarter(values: Array, axis: int) -> Array:
    """The second of two components first, then the negative of the first one."""
    first, second = np.moveaxis(values, axis, 0)
    return np.stack([second, -first], axis=axis)


def unroll(contact: ContactHistory) -> Unrolled:
    """Lay the surface of a contact of solids into a plane, its first tangent to the right."""
    shares = contact.surface.weights / contact.surface.weights.sum()
    normals = contact.surface.frames[:, 0]
    middle = shares @ contact.surface.points
    normal = _unit(shares @ normals)
    first = shares @ contact.surface.frames[:, 1]
    first = _unit(first - (first @ normal) * normal)
    directions = np.stack([first, np.cross(normal, first)])
    offsets = contact.surface.points - middle
    flattest = float((normals @ normal).min())
    axis, twist = _axis(normals, shares)
    if flattest < FLAT and flattest > STEEPEST and twist < TWIST:
        places, axes = _along_arc(offsets, normals, normal, axis, directions)
        how = f"unrolled along the arc about {direction_text(axis)}"
    else:
        places = offsets @ directions.T
        axes = np.broadcast_to(directions, (len(places), 2, 3))
        how = "as it lies, nearly flat"
        if flattest < FLAT:
            shorter = "much" if flattest < STEEPEST else f"up to {1 - flattest:.0%}"
            how = "curved in two directions and projected: on its slopes lengths appear "
            how += f"{shorter} shorter"
    return Unrolled(places, axes, directions, middle, how)


def _axis(normals: Array, shares: Array) -> tuple[Array, float]:
    """The direction that the normals turn about, and how far they leave the plane across it."""
    squares, vectors = np.linalg.eigh((normals * shares[:, None]).T @ normals)
    return vectors[:, 0], float(np.sqrt(max(squares[0], 0.0) / max(squares[1], 1e-300)))


def _along_arc(
    offsets: Array, normals: Array, normal: Array, axis: Array, directions: Array
) -> tuple[Array, Array]:
    """Places (N, 2) and axes (N, 2, 3) of a surface that is bent about an axis."""
    upright = _unit(normal - (normal @ axis) * axis)
    across = np.cross(axis, upright)
    flat = normals - (normals @ axis)[:, None] * axis
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    distance, slope = offsets @ across, np.arctan2(flat @ across, flat @ upright)
    order = np.argsort(distance, kind="stable")
    sorted_distance, sorted_slope = distance[order], slope[order]
    # Circles between the nodes: their arc over the distance across.
    middle, half = (sorted_slope[1:] + sorted_slope[:-1]) / 2, np.diff(sorted_slope) / 2
    steps = np.diff(sorted_distance) / (np.cos(middle) * np.sinc(half / np.pi))
    arc = np.concatenate([[0.0], np.cumsum(steps)])
    arc -= np.interp(0.0, sorted_distance, arc)
    places = np.empty((len(offsets), 2))
    places[order, 0] = arc
    places[:, 1] = offsets @ axis
    turn = directions @ np.stack([across, axis], axis=1)
    local = np.stack([np.cross(axis, flat), np.broadcast_to(axis, flat.shape)], axis=1)
    return places @ turn.T, np.einsum("ij,njd->nid", turn, local)


def _unit(vector: Array) -> Array:
    return np.asarray(vector / np.linalg.norm(vector))
