# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curvature of surfaces: mean, by facet, and how far facets are from the smooth surface.

In the plane these are the numbers of a `Chain`. In space they come from the turning of the normals
between the corners of each facet.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from fretfe._typing import Array, Positions
from fretfe.surface.reference import rim_nodes
from fretfe.surface.surface import STRAIGHT, Chain, Surface

# Corners at the ends of the sides along each reference direction.
SIDES = {
    "triangle": (((0, 1),), ((0, 2),)),
    "quadrilateral": (((0, 1), (3, 2)), ((0, 3), (1, 2))),
}
# Largest distance of a flat facet from a sphere over that of the longest of its edges.
MIDDLE_TO_EDGE = {"triangle": 4 / 3, "quadrilateral": 1.0}


def mean_curvature(surface: Surface) -> float:
    """Mean size of the curvature: turning of the normal, without sign, per length.

    In space the root of the sum of the squares of both principal curvatures.
    """
    if surface.dimension == 2:
        return Chain(surface).mean_curvature
    (a, b), (turn_a, turn_b) = _along_sides(surface)
    # |W| dA for the gradient W of the normal that maps a onto turn_a and b onto turn_b
    squares = _dot(turn_a, turn_a) * _dot(b, b) + _dot(turn_b, turn_b) * _dot(a, a)
    squares -= 2 * _dot(turn_a, turn_b) * _dot(a, b)
    share = 0.5 if surface.shape == "triangle" else 1.0
    turning = share * np.sqrt(np.maximum(squares, 0.0))
    return float(turning.sum() / surface.measures.sum())


def _along_sides(surface: Surface) -> tuple[list[Array], list[Array]]:
    """Mean sides of each facet along both reference directions, and how the normal turns there."""
    pairs = [np.array(ends) for ends in SIDES[surface.shape]]
    sides = [np.diff(surface.nodes[:, ends], axis=2)[:, :, 0].mean(axis=1) for ends in pairs]
    turns = [
        _turns(surface.normals[:, ends[:, 0]], surface.normals[:, ends[:, 1]]).mean(axis=1)
        for ends in pairs
    ]
    return sides, turns


def curvatures(surface: Surface) -> Array:
    """(f,) largest curvature of each facet, without sign; 0 for flat surfaces."""
    if surface.dimension == 2:
        return Chain(surface).curvatures
    lengths, turns = _between_corners(surface)
    return (turns / lengths).max(axis=1)


def deviations(surface: Surface) -> Array:
    """(f,) distance of each facet from the smooth surface through its nodes.

    First terms of series for an arc of length h that turns by θ: hθ/8 and, curved, hθ³/512; see
    `fretfe.surface.surface.Chain.deviations`.
    """
    if surface.dimension == 2:
        return Chain(surface).deviations
    lengths, turns = _between_corners(surface)
    if surface.degree == 1:
        turns *= _missing_at_rim(surface)
    parts = lengths * (turns / 8 if surface.degree == 1 else turns**3 / 512)
    return MIDDLE_TO_EDGE[surface.shape] * parts.max(axis=1)


def _between_corners(surface: Surface) -> tuple[Array, Array]:
    """(f, p) distances of all pairs of corners of each facet, angles between the normals there."""
    first, second = _pairs(surface)
    lengths = np.linalg.norm(surface.nodes[:, first] - surface.nodes[:, second], axis=2)
    turns = np.linalg.norm(_turns(surface.normals[:, first], surface.normals[:, second]), axis=2)
    return lengths, turns


def _pairs(surface: Surface) -> Positions:
    """(2, p) all pairs of corners of a facet."""
    return np.array(list(combinations(range(surface.corners.shape[1]), 2))).T


def _missing_at_rim(surface: Surface) -> Array:
    """(f, p) upper bound of the turning between pairs of corners over what the normals show.

    At the rim of a surface of flat facets the normal is that of one side: of the turning between
    there and a corner inside up to a half is missing.
    """
    first, second = _pairs(surface)
    at_rim = rim_nodes(surface.corners, len(surface.vertices))[surface.corners]
    return np.where(at_rim[:, first] != at_rim[:, second], 2.0, 1.0)


def _turns(before: Array, after: Array) -> Array:
    """(..., 3) changes of unit normals, as long as the angle between them; 0 if it is round-off."""
    change = after - before
    distance = np.linalg.norm(change, axis=-1, keepdims=True)
    sine = np.linalg.norm(np.cross(before, after), axis=-1, keepdims=True)
    angle = np.arcsin(np.clip(sine, 0.0, 1.0))
    scale = np.divide(angle, distance, out=np.zeros_like(angle), where=angle > STRAIGHT)
    return np.asarray(scale * change)


def _dot(first: Array, second: Array) -> Array:
    return np.asarray(np.sum(first * second, axis=-1))
