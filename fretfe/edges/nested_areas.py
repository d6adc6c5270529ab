# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact areas of solids whose borders pass the nodes next to a front one after the other.

The nodes that stick end in a ragged line, and increments of full stick follow it: factors of single
stations scatter by some per cent. Their mean over areas that grow by an element altogether has a
front where the curve through the fitted places runs.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools
from fretfe.edges.tracks_in_space import FEWEST, FrontTrack, finer

AREAS = 6
# How far outside its nodes the front of an area lies, in elements across it: where it is in bonded
# circles by their factors under a force along, a force across and a moment, by .25, .22 and .2.
OUTSIDE = 0.21
# Nodes within this distance of a front, in elements across it, are in an area or not by it, unless
# the nearest station is not known; others are as they were. Beyond its last station a front goes on
# straight, as far as that many times the spacing of stations.
BAND, BEYOND = 2.0, 3.0


def nested_areas(
    points: Array, area: Bools, tracks: Sequence[FrontTrack], places: Sequence[Array]
) -> list[Bools]:
    """Contact areas around the fronts of one, smallest first; each N nodes.

    Args:
        points: (N, 3) nodes of the contact.
        area: (N,) nodes in contact.
        tracks: its fronts.
        places: for each front the places (n,) of its stations, inward from the reference; NaN where
            they are not known.
    """
    inside = np.full(len(points), np.nan)
    nearest = np.full(len(points), np.inf)
    for track, place in zip(tracks, places, strict=True):
        if np.count_nonzero(np.isfinite(place)) < FEWEST:
            continue
        distance, depth = _elements_inside(points, track, place)
        closer = distance < nearest
        inside[closer], nearest[closer] = depth[closer], distance[closer]
    near = np.abs(inside) < BAND
    borders = OUTSIDE + 0.5 - (np.arange(AREAS) + 0.5) / AREAS
    return [np.where(near, inside > border, area) for border in borders]


def _elements_inside(points: Array, track: FrontTrack, place: Array) -> tuple[Array, Array]:
    """(N,) distances from a front, and (N,) how many elements inward; NaN where it is unknown."""
    front, known = track.front, np.isfinite(place)
    stations = front.frames.moved(np.where(known, place, 0.0)).points
    unknown = ~known[cKDTree(stations).query(points)[1]]
    values = np.column_stack([front.frames.inward, front.sizes])
    line, values = finer(front.frames, place, values)
    distance, row = cKDTree(line).query(points)
    inward = values[row, :3] / np.linalg.norm(values[row, :3], axis=1)[:, None]
    offset = points - line[row]
    depth = np.einsum("nd,nd->n", offset, inward)
    spacing = front.frames.length / len(place)
    beyond = np.linalg.norm(offset - depth[:, None] * inward, axis=1) > BEYOND * spacing
    return distance, np.where(beyond | unknown, np.nan, depth / values[row, 3])
