# SPDX-License-Identifier: LGPL-3.0-or-later
"""Initial gap of two contact surfaces, and how much of an overlap their facets explain.

The gap is the one that the contact conditions see: along the contact normal of
`fretfe.surface.overlap`, positive where the surfaces are apart and negative where bodies overlap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.surface.curvature import deviations
from fretfe.surface.overlap import overlap_points
from fretfe.surface.reference import shape_values
from fretfe.surface.surface import Surface

# An interpenetration of this fraction of a facet is not resolved by the mesh and does no harm.
INTERPENETRATION_PER_FACET = 0.01
# Coordinates in mesh files may be rounded to this fraction of the size of the surfaces.
FILE_ROUNDING = 1e-6


@dataclass(frozen=True)
class InitialGap:
    """Initial gap at n places of surface 2 that lie opposite surface 1.

    Attributes:
        surface1: surface of body 1.
        surface2: surface of body 2.
        points: (n, d) coordinates of the places.
        gap: (n,) distance to surface 1 along the contact normal; negative: interpenetration.
        weights: (n,) arc length or area that a place stands for.
        facet1: (n,) facets of surface 1 that the places meet.
        facet2: (n,) facets of surface 2 that the places are on.
    """

    surface1: Surface
    surface2: Surface
    points: Array
    gap: Array
    weights: Array
    facet1: Indices
    facet2: Indices

    def allowed_interpenetration(self) -> Array:
        """(n,) depth that comes with facets and rounding, not with the shape of the bodies."""
        sides = ((self.surface1, self.facet1), (self.surface2, self.facet2))
        size = max(float(np.ptp(surface.vertices, axis=0).max()) for surface, _ in sides)
        coarsest = np.maximum(*(surface.sizes[facets] for surface, facets in sides))
        deviation = np.add(*(deviations(surface)[facets] for surface, facets in sides))
        return deviation + INTERPENETRATION_PER_FACET * coarsest + FILE_ROUNDING * size


def initial_gap(surface1: Surface, surface2: Surface) -> InitialGap:
    """Initial gap of two surfaces; without any place if they do not lie opposite each other."""
    overlap = overlap_points(surface1, surface2)
    values = shape_values(surface2.shape, surface2.degree, overlap.at2)
    points = np.einsum("nk,nkd->nd", values, surface2.nodes[overlap.facet2])
    return InitialGap(
        surface1, surface2, points, overlap.gap, overlap.weights, overlap.facet1, overlap.facet2
    )
