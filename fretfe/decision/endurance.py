# SPDX-License-Identifier: LGPL-3.0-or-later
"""Multiaxial criteria of endurance, and stress at critical distances.

Stresses are symmetric tensors (n, M, 6) of n states at M points, components as of
`evaluate.critical_planes.PAIRS`: xx, yy, zz, xy, yz, xz. The criteria on critical planes, of Smith,
Watson and Topper, of Fatemi and Socie, and of Findley, are in that module. All are for many cycles
in which the body stays elastic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fretfe._typing import Array

Distance = Literal["point", "line", "area"]


@dataclass(frozen=True)
class ShearAndPressure:
    """A criterion shear + weight times hydrostatic stress <= limit.

    Attributes:
        weight: of the hydrostatic stress.
        limit: amplitude of the shear stress that is endured in fully reversed torsion.
    """

    weight: float
    limit: float

    @classmethod
    def crossland(cls, tension: float, torsion: float) -> ShearAndPressure:
        """From limits σ₋₁ and τ₋₁, amplitudes under reversed tension or bending, and torsion.

        Valid for τ₋₁/σ₋₁ >= 1/√3: otherwise the weight is negative.
        """
        return cls(3 * torsion / tension - math.sqrt(3), torsion)

    @classmethod
    def dang_van(cls, tension: float, torsion: float) -> ShearAndPressure:
        """The same for `dang_van`; valid for τ₋₁/σ₋₁ >= 1/2."""
        return cls(3 * torsion / tension - 1.5, torsion)


def crossland(stress: Array, law: ShearAndPressure) -> Array:
    """(M,) √J₂,a + weight σ_H,max, over the limit: endured up to 1.

    Crossland (Int. Conf. on Fatigue of Metals, London 1956). √J₂,a is the radius of the smallest
    ball around the way of the deviator, over √2 (Papadopoulos et al., Int. J. Fatigue 19, 1997, for
    loads out of phase); σ_H,max the largest hydrostatic stress, of either sign.
    """
    deviator, hydrostatic = _split(stress)
    radius = smallest_ball(deviator)[1]
    return np.asarray((radius / math.sqrt(2) + law.weight * hydrostatic.max(axis=0)) / law.limit)


def dang_van(stress: Array, law: ShearAndPressure) -> Array:
    """(M,) largest τ(t) + weight σ_H(t) through the cycle, over the limit: endured up to 1.

    Dang Van (ASTM STP 1191, 1993). τ is half the difference of the largest and the smallest
    principal value of the deviator less the middle of the smallest ball around its way: the
    residual stress of a grain that has shaken down.
    """
    deviator, hydrostatic = _split(stress)
    rest = deviator - smallest_ball(deviator)[0]
    xx, yy, zz, *shears = np.moveaxis(rest, -1, 0)
    xy, yz, xz = (each / math.sqrt(2) for each in shears)
    rows = (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)
    principal = np.linalg.eigvalsh(np.stack([np.stack(row, axis=-1) for row in rows], axis=-2))
    shear = (principal[..., 2] - principal[..., 0]) / 2
    return np.asarray((shear + law.weight * hydrostatic).max(axis=0) / law.limit)


def _split(stress: Array) -> tuple[Array, Array]:
    """Deviator (n, M, 6), whose length is that of the tensor, and hydrostatic stress (n, M)."""
    hydrostatic = stress[..., :3].mean(axis=-1)
    deviator = stress * np.array([1, 1, 1, *[math.sqrt(2)] * 3])
    deviator[..., :3] -= hydrostatic[..., None]
    return deviator, hydrostatic


def smallest_ball(ways: Array) -> tuple[Array, Array]:
    """Middle (M, k) and radius (M,) of the smallest balls around n places each, (n, M, k).

    The middle is a mean of places by weights that maximise the mean square of the distance from it;
    weight is moved from the nearest place that has some to the farthest one, in the best amount,
    until the mean and the largest distance agree (Wolfe's method with steps between two vertices).
    """
    count = ways.shape[1]
    columns = np.arange(count)
    weights = np.full(ways.shape[:2], 1 / len(ways))
    for _ in range(2000):
        middle = np.einsum("nm,nmk->mk", weights, ways)
        squares = np.sum((ways - middle) ** 2, axis=2)
        far = np.argmax(squares, axis=0)
        near = np.argmin(np.where(weights > 0, squares, np.inf), axis=0)
        largest, mean = squares[far, columns], np.sum(weights * squares, axis=0)
        if np.all(largest - mean <= 2e-5 * largest):  # 1e-5 of the radius
            break
        apart = np.sum((ways[far, columns] - ways[near, columns]) ** 2, axis=1)
        best = (largest - squares[near, columns]) / np.where(apart > 0, 2 * apart, 1.0)
        moved = np.minimum(best, weights[near, columns])
        weights[far, columns] += moved
        weights[near, columns] -= moved
    return middle, np.sqrt(largest)


def distance_points(method: Distance, length: float) -> tuple[Array, Array]:
    """Points (m, 2) below a place at the surface and weights (m,) whose sum is 1.

    Of the stress there the mean is to be taken: at the depth L/2 (point), over the depth 2 L (line;
    both Tanaka, Int. J. Fract. 22, 1983, and Taylor, Int. J. Fatigue 21, 1999), over half a disc of
    the radius L (area, Taylor). Valid where the stress falls from the surface over lengths that L
    resolves, long cracks of the length of a few L being small against the body.

    Args:
        method: of the three.
        length: L, as of `critical_length`.

    Returns:
        x along the surface, y along the outward normal, so never positive; and weights.
    """
    if method == "point":
        return np.array([[0.0, -length / 2]]), np.ones(1)
    places, weights = np.polynomial.legendre.leggauss(12)
    places, weights = (1 + places) / 2, weights / 2
    if method == "line":
        return np.stack([np.zeros_like(places), -2 * length * places], axis=1), weights
    turns = np.pi * places
    radii = length * np.sqrt(places)
    points = np.stack([np.outer(radii, np.cos(turns)), -np.outer(radii, np.sin(turns))], axis=-1)
    return points.reshape(-1, 2), np.outer(weights, weights).ravel()
