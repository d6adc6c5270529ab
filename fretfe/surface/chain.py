# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane surfaces as open chains of facets: order, arc length, turning of the normal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.errors import MeshError, ModelError
from fretfe.surface.reference import shape_slopes

if TYPE_CHECKING:
    from fretfe.surface.surface import Surface

# Facets whose normal turns by less than this angle (radians) are straight.
STRAIGHT = 1e-9


@dataclass(frozen=True)
class Chain:
    """View of a plane surface as a curve of f facets, the body on the left of the direction.

    Attributes:
        surface: in the plane.

    Raises:
        ModelError: The surface is not in the plane.
    """

    surface: Surface

    def __post_init__(self) -> None:
        """Refuse surfaces in space."""
        if self.surface.dimension != 2:
            raise ModelError(
                f"surface {self.surface.name!r} of body {self.surface.body!r}: expected a curve in"
                " the plane, which has an arc length, found a surface in space."
            )

    @property
    def arc(self) -> Array:
        """(f + 1,) arc length at the facet ends, zero at the middle of the chain."""
        arc = np.concatenate([[0.0], np.cumsum(self.surface.measures)])
        return arc - arc[-1] / 2

    @property
    def mean_curvature(self) -> float:
        """Turning of the normal, without regard to its sign, per arc length."""
        return float(np.abs(self._turns()).sum() / self.surface.measures.sum())

    def _turns(self) -> Array:
        """(f,) angle by which the normal turns over each facet."""
        sine = _cross(self.surface.normals[:, 0], self.surface.normals[:, 1])
        turns = np.arcsin(np.clip(sine, -1.0, 1.0))
        # A straight surface has no curvature, not that of the round-off in its nodes.
        return np.where(np.abs(turns) > STRAIGHT, turns, 0.0)

    @property
    def curvatures(self) -> Array:
        """(f,) largest curvature of each facet, without sign; 0 for straight surfaces.

        Curved facets: |x' × x''|/|x'|³ at the nodes. Straight facets: the angle between two of them
        over the distance of their middles, the larger at both ends.
        """
        curvatures = self._inside() if self.surface.degree == 2 else self._between()
        # The round-off in the nodes of a straight surface is no curvature.
        return np.where(curvatures * self.surface.measures > STRAIGHT, curvatures, 0.0)

    def _inside(self) -> Array:
        nodes = self.surface.nodes
        slopes = shape_slopes("interval", 2, np.array([[0.0], [0.5], [1.0]]))[:, 0]
        first = np.einsum("qk,fkd->fqd", slopes, nodes)
        second = 4 * (nodes[:, :1] + nodes[:, 1:2] - 2 * nodes[:, 2:])
        return (np.abs(_cross(first, second)) / np.linalg.norm(first, axis=2) ** 3).max(axis=1)

    def _between(self) -> Array:
        chords = np.diff(self.surface.vertices, axis=0)
        before, after = chords[:-1], chords[1:]
        turns = np.abs(np.arctan2(_cross(before, after), np.sum(before * after, axis=1)))
        lengths = self.surface.measures
        at_ends = np.concatenate([[0.0], 2 * turns / (lengths[:-1] + lengths[1:]), [0.0]])
        return np.maximum(at_ends[:-1], at_ends[1:])

    @property
    def deviations(self) -> Array:
        """(f,) distance of each facet from the smooth curve through its nodes.

        A facet of length h turns by the angle θ = h/R. Straight: the sagitta hθ/8 of an arc.
        Curved: hθ³/512, the deviation of a parabola through both ends and the middle of
        an arc at a quarter of its length. Both are the first terms of series, wrong by less than
        7 % for θ < 30°.
        """
        lengths = self.surface.measures
        turns = lengths * self.curvatures
        return lengths * (turns / 8 if self.surface.degree == 1 else turns**3 / 512)


def _cross(first: Array, second: Array) -> Array:
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]


def chain_order(facets: Indices, where: str) -> Indices:
    """Order (f,) in which facets (f, 2 or 3) follow each other from the first end to the last.

    Args:
        facets: node numbers, ends first.
        where: what they belong to, for messages.

    Raises:
        MeshError: The facets do not form one open chain.
    """
    by_start = {int(start): i for i, start in enumerate(facets[:, 0])}
    firsts = np.setdiff1d(facets[:, 0], facets[:, 1])
    order = [by_start[int(first)] for first in firsts[:1]]
    for _ in facets[1:]:
        following = by_start.get(int(facets[order[-1], 1])) if order else None
        if following is None:
            break
        order.append(following)
    if len(set(order)) != len(facets):
        pieces = {0: "a closed curve", 1: "an open and a closed curve"}
        kind = pieces.get(len(firsts), f"{len(firsts)} separate pieces")
        raise MeshError(
            f"{where}: a contact surface must be one open curve, but its facets form {kind}. "
            "Give each piece a physical group and a contact of its own."
        )
    return np.array(order)
