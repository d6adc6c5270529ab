# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where two contact surfaces face each other at the start, how far apart, and how curved they are.

The distance is the one that the contact conditions see: along the contact normal of
`fretfe.surface.mortar`, positive where the surfaces are apart and negative where they overlap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.surface.mortar import facing_points
from fretfe.surface.surface import STRAIGHT, Surface, shape_slopes, shape_values

# An overlap of this fraction of an element is not resolved by the mesh and does no harm.
OVERLAP_PER_FACET = 0.01
# Coordinates in mesh files may be rounded to this fraction of the size of the surfaces.
FILE_ROUNDING = 1e-6


@dataclass(frozen=True)
class Facing:
    """Places where two surfaces face each other; n places on the surface of body 2, in the mesh.

    Attributes:
        surface1: surface of body 1.
        surface2: surface of body 2.
        points: (n, 2) coordinates of the places.
        gap: (n,) distance to the surface of body 1 along the contact normal; negative: overlap.
        length: (n,) arc length that a place stands for.
        facet1: (n,) facets of surface 1 that the places meet.
        facet2: (n,) facets of surface 2 that the places are on.
    """

    surface1: Surface
    surface2: Surface
    points: Array
    gap: Array
    length: Array
    facet1: Indices
    facet2: Indices

    def allowed_overlap(self) -> Array:
        """(n,) overlap that comes with facets and rounding, not with the shape of the bodies."""
        sides = ((self.surface1, self.facet1), (self.surface2, self.facet2))
        size = max(float(np.ptp(surface.vertices, axis=0).max()) for surface, _ in sides)
        coarsest = np.maximum(*(surface.lengths[facets] for surface, facets in sides))
        deviation = np.add(*(shape_deviation(surface)[facets] for surface, facets in sides))
        return deviation + OVERLAP_PER_FACET * coarsest + FILE_ROUNDING * size


def face(surface1: Surface, surface2: Surface) -> Facing:
    """Find where two surfaces face each other; there may be no place."""
    pairs = facing_points(surface1, surface2)
    facet1, facet2 = (pairs[key].astype(np.int64) for key in ("other_facet", "facet"))
    values = shape_values(surface2.nodes.shape[1] - 1, pairs["xi"])
    points = np.einsum("nk,nkd->nd", values, surface2.nodes[facet2])
    return Facing(surface1, surface2, points, pairs["gap"], pairs["weight"], facet1, facet2)


def facet_curvatures(surface: Surface) -> Array:
    """(facets,) largest curvature of each facet, without sign; 0 for straight surfaces.

    Curved facets: |x' × x''|/|x'|³ at the nodes. Straight facets: the angle between two of them
    over the distance of their middles, the larger at both ends.
    """
    lengths = surface.lengths
    curvatures = _inside(surface) if surface.nodes.shape[1] == 3 else _between(surface)
    # The round-off in the nodes of a straight surface is no curvature.
    return np.where(curvatures * lengths > STRAIGHT, curvatures, 0.0)


def _inside(surface: Surface) -> Array:
    first = np.einsum("qk,fkd->fqd", shape_slopes(2, np.array([0.0, 0.5, 1.0])), surface.nodes)
    second = 4 * (surface.nodes[:, :1] + surface.nodes[:, 1:2] - 2 * surface.nodes[:, 2:])
    cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return (np.abs(cross) / np.linalg.norm(first, axis=2) ** 3).max(axis=1)


def _between(surface: Surface) -> Array:
    chords = surface.nodes[:, 1] - surface.nodes[:, 0]
    before, after = chords[:-1], chords[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turns = np.abs(np.arctan2(cross, np.sum(before * after, axis=1)))
    lengths = surface.lengths
    at_ends = np.concatenate([[0.0], 2 * turns / (lengths[:-1] + lengths[1:]), [0.0]])
    return np.maximum(at_ends[:-1], at_ends[1:])


def shape_deviation(surface: Surface) -> Array:
    """(facets,) distance of each facet from the smooth curve through its nodes.

    A facet of length h turns by the angle θ = h/R. Straight: the sagitta hθ/8 of an arc.
    Curved: hθ³/512, the deviation of a parabola through both ends and the middle of
    an arc at a quarter of its length. Both are the first terms of series, wrong by less than
    7 % for θ < 30°.
    """
    lengths = surface.lengths
    turns = lengths * facet_curvatures(surface)
    return lengths * (turns / 8 if surface.nodes.shape[1] == 2 else turns**3 / 512)
