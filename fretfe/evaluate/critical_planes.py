# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fatigue parameters on critical planes, of stress histories at points of an elastic body.

Stresses are symmetric tensors in the axes of the case, components xx, yy, zz, xy, yz, xz. A plane
is known by its unit normal. On it act the normal stress sigma_n and, with Hooke's law, the normal
strain eps_n = ((1 + nu) sigma_n - nu tr sigma)/E and the engineering shear strain gamma = tau/G, a
vector in the plane.

The planes are searched over half a sphere: first on a grid of `COARSE` degrees, then around the
best one of the grid with steps that halve down to `FINEST` degrees.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.errors import CaseError

# Degrees between the planes of the first search, and the last step around the best of them.
COARSE = 10.0
FINEST = 0.1
# Directions in a plane along which the farthest states are looked for.
DIRECTIONS = 16
# Numbers that are held at the same time, of states, points and planes.
MOST_VALUES = 2_000_000
# Components of the tensor, by place in it.
PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


@dataclass(frozen=True)
class OnPlanes:
    """Stress and strain on planes in n states, one or more (P) planes for each of m points.

    Attributes:
        stress: (n, m, 6).
        strain: (n, m, 6), components of the tensor.
        normals: (m or 1, P, 3) unit normals.
    """

    stress: Array
    strain: Array
    normals: Array

    @property
    def largest_pull(self) -> Array:
        """(m, P) largest normal stress, zero on planes that are always pressed."""
        normal = _component(self.stress, self.normals, self.normals)
        return np.asarray(np.maximum(normal.max(axis=0), 0.0))

    def shear_range(self, tensor: Array) -> Array:
        """(m, P) largest distance between two places of the shear of a tensor (n, m, 6)."""
        along = _tangents(self.normals)
        x, y = (_component(tensor, self.normals, tangent) for tangent in along)
        return _longest_chord(x, y)


@dataclass(frozen=True)
class Critical:
    """The largest parameter over all planes at M points.

    Attributes:
        value: (M,) NaN where the stress is not known.
        normal: (M, 3) of the plane, with z >= 0.
    """

    value: Array
    normal: Array


Parameter = Callable[[OnPlanes], Array]


def smith_watson_topper(planes: OnPlanes) -> Array:
    """Return sigma_n,max * eps_n,a, zero where the plane is never pulled [stress].

    Smith, Watson and Topper (J. Materials 5, 1970) on the plane of its largest value (Socie, J.
    Eng. Mater. Technol. 109, 1987). eps_n,a is half the range of the normal strain. For cracks that
    grow under tension; uniaxial, push-pull or pulsating: sigma_max^2 (1 - R)/(2 E).
    """
    strain = _component(planes.strain, planes.normals, planes.normals)
    return planes.largest_pull * np.ptp(strain, axis=0) / 2


def fatemi_socie(k: float, yield_stress: float) -> Parameter:
    """Return gamma_a (1 + k sigma_n,max/sigma_y), of planes [1].

    Fatemi and Socie (Fatigue Fract. Eng. Mater. Struct. 11, 1988), on the plane of its largest
    value. gamma_a is half the longest chord of the shear strain; a plane that is always pressed
    counts as if nothing pressed it. For cracks that grow under shear; k is of the order of one and
    is found from tests, as sigma_y is. k = 0 leaves the amplitude of the shear strain.

    Args:
        k: weight of the normal stress.
        yield_stress: sigma_y.

    Raises:
        CaseError: if k is negative or the yield stress not positive.
    """
    if not (np.isfinite([k, yield_stress]).all() and k >= 0 and yield_stress > 0):
        raise CaseError(
            "expected k >= 0 and a yield stress > 0 for the parameter of Fatemi and Socie, found "
            f"{k:g} and {yield_stress:g}"
        )

    def parameter(planes: OnPlanes) -> Array:
        amplitude = planes.shear_range(planes.strain)
        return amplitude * (1 + k * planes.largest_pull / yield_stress) if k else amplitude

    return parameter


def findley(k: float) -> Parameter:
    """Return tau_a + k sigma_n,max, of planes [stress].

    Findley (J. Eng. Ind. 81, 1959), on the plane of its largest value, to be compared with a limit
    from tests: fully reversed torsion that endures tau gives sqrt(1 + k^2) tau, and tension
    (k + sqrt(1 + k^2)) sigma/2. A plane that is always pressed counts as if nothing pressed it.
    For many cycles; 0.2 to 0.3 is usual for k of ductile metals.

    Args:
        k: weight of the normal stress; >= 0.
    """
    return lambda planes: planes.shear_range(planes.stress) / 2 + k * planes.largest_pull


def find_critical(stress: Array, strain: Array, parameter: Parameter) -> Critical:
    """Find the plane of the largest parameter at every point.

    Args:
        stress: (n, M, 6) of n states, in their order.
        strain: (n, M, 6) elastic strain there, components of the tensor.
        parameter: `smith_watson_topper`, or one that `fatemi_socie` or `findley` gives.
    """
    count = stress.shape[1]
    value, normal = np.full(count, np.nan), np.full((count, 3), np.nan)
    known = np.flatnonzero(np.isfinite(stress).all(axis=(0, 2)))
    grid = _hemisphere(np.radians(COARSE))
    part = max(MOST_VALUES // (len(stress) * len(grid)), 1)
    for start in range(0, len(known), part):
        points = known[start : start + part]
        own = stress[:, points], strain[:, points]
        coarse = parameter(OnPlanes(*own, grid[None]))
        best = np.argmax(coarse, axis=1)
        value[points], normal[points] = _refined(
            own, coarse[np.arange(len(points)), best], grid[best], parameter
        )
    normal[normal[:, 2] < 0] *= -1
    return Critical(value, normal)


def _refined(
    own: tuple[Array, Array], value: Array, normal: Array, parameter: Parameter
) -> tuple[Array, Array]:
    """Walk from planes (m, 3) with the values (m,) uphill, in steps that get smaller."""
    step = np.radians(COARSE) / 2
    turns = np.linspace(0, 2 * np.pi, 8, endpoint=False)[:, None]
    cosines, sines = np.cos(turns), np.sin(turns)
    while step > np.radians(FINEST) / 2:
        for _ in range(2):
            first, second = _tangents(normal)
            around = cosines * first[:, None] + sines * second[:, None]
            tried = np.cos(step) * normal[:, None] + np.sin(step) * around
            found = parameter(OnPlanes(*own, tried))
            best, rows = np.argmax(found, axis=1), np.arange(len(normal))
            better = found[rows, best] > value
            value = np.where(better, found[rows, best], value)
            normal = np.where(better[:, None], tried[rows, best], normal)
        step /= 2
    return value, normal


def _component(stress: Array, one: Array, other: Array) -> Array:
    """(n, m, P) components of stresses (n, m, 6) along two directions (m or 1, P, 3)."""
    factors = np.stack(
        [
            (one[..., i] * other[..., j] + one[..., j] * other[..., i]) / (1 + (i == j))
            for i, j in PAIRS
        ],
        axis=-2,
    )
    # For each point one product of matrices: (n, 6) and (6, P).
    return np.asarray(np.matmul(stress.swapaxes(0, 1), factors).swapaxes(0, 1))


def _longest_chord(x: Array, y: Array) -> Array:
    """(m, P) largest distance between two of n places (x, y), (n, m, P).

    The distance of the two that are farthest apart along one of some directions: not less than
    cos(pi/32) = 0.995 times the largest one, and nearly always that one itself.
    """
    widest, best = np.full(x.shape[1:], -1.0), np.zeros(x.shape[1:])
    for angle in np.arange(DIRECTIONS) * np.pi / DIRECTIONS:
        width = np.ptp(np.cos(angle) * x + np.sin(angle) * y, axis=0)
        best[width > widest] = angle
        widest = np.maximum(width, widest)
    along = np.cos(best) * x + np.sin(best) * y
    low, high = np.argmin(along, axis=0)[None], np.argmax(along, axis=0)[None]
    dx, dy = (np.take_along_axis(v, high, 0) - np.take_along_axis(v, low, 0) for v in (x, y))
    return np.asarray(np.hypot(dx, dy)[0])


def _tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors in the plane of each normal (..., 3)."""
    axis = np.where(np.abs(normals[..., 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
    first = np.cross(normals, axis)
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return first, np.cross(normals, first)


def _hemisphere(spacing: float) -> Array:
    """(P, 3) unit vectors with z >= 0, about evenly spaced; those in the plane z = 0 evenly."""
    normals = []
    for height in np.linspace(0, np.pi / 2, round(np.pi / 2 / spacing) + 1):
        # On the rim a direction and its opposite are the same plane.
        turn = np.pi if height == 0 else 2 * np.pi
        count = max(round(turn * np.cos(height) / spacing), 1)
        angles = np.arange(count) * turn / count
        level = np.full(count, np.sin(height))
        normals.append(
            np.stack([np.cos(height) * np.cos(angles), np.cos(height) * np.sin(angles), level], 1)
        )
    return np.concatenate(normals)
