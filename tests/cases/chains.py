# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of contact surfaces made directly from arrays: no bodies, no elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.mesh.mesh import BodyMesh
from fretfe.surface.surface import Surface, build_surface


def surface(name: str, points: Array, curved: bool) -> Surface:
    """Chain through points in order (with every second one the middle of a curved facet)."""
    order = 2 if curved else 1
    number = np.arange(len(points))
    ends = [number[:-order:order], number[order::order]]
    facets = np.stack([*ends, number[1::2]] if curved else ends, axis=1)
    cells = np.empty((0, 3), dtype=np.int64)
    mesh = BodyMesh(f"body of {name}", points, cells, "triangle", order, {name: facets})
    return build_surface(mesh, name)


@dataclass(frozen=True)
class Placement:
    """Turned by an angle (degrees), scaled, then moved."""

    angle: float = 0.0
    scale: float = 1.0
    origin: tuple[float, float] = (0.0, 0.0)

    def __call__(self, points: Array) -> Array:
        c, s = np.cos(np.radians(self.angle)), np.sin(np.radians(self.angle))
        return self.scale * points @ np.array([[c, s], [-s, c]]) + np.array(self.origin)

    def vector(self, v: tuple[float, float]) -> Array:
        """A direction, turned only."""
        return Placement(self.angle)(np.array([v]))[0]


def stations(rng: np.random.Generator, start: float, end: float, facets: int) -> Array:
    """Facet ends at random distances of each other, none much smaller than the rest."""
    sizes = rng.uniform(0.5, 1.5, facets)
    return start + (end - start) * np.concatenate([[0.0], np.cumsum(sizes)]) / sizes.sum()


def with_middles(x: Array, shift: Array) -> Array:
    """Facet ends and, between them, middles displaced by a fraction of half the facet."""
    middles = (x[:-1] + x[1:]) / 2 + shift * np.diff(x) / 2
    return np.insert(x, np.arange(1, len(x)), middles)


def random_pair(seed: int, curved: bool, place: Placement) -> tuple[Surface, Surface]:
    """Surface of body 1 (upper) and 2 (lower): random nodes, partial overlap, gap of both signs."""
    rng = np.random.default_rng(seed)

    def wavy(x: Array, level: float) -> Array:
        middles = rng.uniform(-0.1, 0.1, len(x) - 1)
        x = with_middles(x, middles) if curved else x
        y = level + 0.05 * np.sin(1.3 * x + seed) + 0.01 * rng.uniform(-1, 1, len(x))
        return np.stack([x, y], axis=1)

    upper = wavy(stations(rng, -2.0, 1.5, 7), 0.02)
    lower = wavy(stations(rng, -1.4, 2.3, 10), 0.0)
    return surface("upper", place(upper), curved), surface("lower", place(lower[::-1]), curved)


def straight_pair(
    seed: int, curved: bool, place: Placement, gap: float = 0.0
) -> tuple[Surface, Surface]:
    """Flat, parallel surfaces [-2, 1.5] (body 1) and [-1.4, 2.3] (body 2) that do not match."""
    rng = np.random.default_rng(seed)

    def flat(x: Array, level: float) -> Array:
        x = with_middles(x, np.zeros(len(x) - 1)) if curved else x
        return np.stack([x, np.full_like(x, level)], axis=1)

    upper = flat(stations(rng, -2.0, 1.5, 7), gap)
    lower = flat(stations(rng, -1.4, 2.3, 10), 0.0)
    return surface("upper", place(upper), curved), surface("lower", place(lower[::-1]), curved)


#: Overlap of the surfaces of `straight_pair` along the interface.
OVERLAP = (-1.4, 1.5)
