# SPDX-License-Identifier: LGPL-3.0-or-later
"""Load paths: exact extremes of the edge formulas over closed ones, and rainflow counting.

A load state has the components (P, M, Q, sigma0), in this order: normal force, moment, shear force
and bulk tension, per unit thickness and with the signs of ``fretfe.analytic.edges``. What happens
at an edge of a contact between half-planes depends on the extremes of linear functionals of the
loads: they are found exactly, no path is sampled.

Rainflow counting is that of ASTM E1049-85, sections 5.4.4 and 5.4.5. A cycle is a pair of reversals
that a closed loop of the history runs between. Ranges are compared without tolerance: of a plateau
the first point counts, and a range that is as large as the one before it closes that one.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fretfe._typing import Array, Indices
from fretfe.analytic._numerics import Side, check_positive
from fretfe.analytic.edges import normal_increment_factor, tangential_factor

COMPONENTS = 4
# Variation of a load, and excess of |Q| over f P, that count as round-off.
ROUND_OFF = 1e-12
FULL = 1.0
HALF = 0.5


class LoadPath(Protocol):
    """A closed path of loads."""

    def extremes(self, weights: ArrayLike) -> tuple[Array, Array]:
        """Return the least and the greatest value of weights . loads; weights (..., 4)."""


@dataclass(frozen=True, eq=False)
class PolygonPath:
    """Straight lines between load states; the last one leads back to the first.

    Attributes:
        vertices: (V, 4) load states, V >= 1.

    Raises:
        ValueError: if ``vertices`` has another shape or an entry is not finite.
    """

    vertices: Array

    def __post_init__(self) -> None:
        """Check the shape."""
        vertices = np.asarray(self.vertices, dtype=np.float64)
        _check_states("vertices", vertices)
        object.__setattr__(self, "vertices", vertices)

    def extremes(self, weights: ArrayLike) -> tuple[Array, Array]:
        """Return least and greatest weights . loads, each (...): they are at vertices.

        Args:
            weights: (..., 4).

        Raises:
            ValueError: if the last axis of ``weights`` does not have 4 entries.
        """
        values = _check_weights(weights) @ self.vertices.T
        return np.min(values, axis=-1), np.max(values, axis=-1)


@dataclass(frozen=True, eq=False)
class HarmonicPath:
    """Loads mean + Re sum_k harmonics[k - 1] exp(i k t), t from 0 to 2 pi.

    Qa cos(t) is an entry Qa in the first row, sa cos(t - phase) an entry sa exp(-i phase).

    Attributes:
        mean: (4,) mean loads.
        harmonics: (H, 4) complex amplitudes of the harmonics k = 1 ... H, H >= 1.

    Raises:
        ValueError: if an argument has another shape or an entry is not finite.
    """

    mean: Array
    harmonics: NDArray[np.inexact]

    def __post_init__(self) -> None:
        """Check the shapes."""
        mean = np.asarray(self.mean, dtype=np.float64)
        harmonics = np.asarray(self.harmonics, dtype=np.complex128)
        _check_load_state("mean", mean)
        _check_states("harmonics", harmonics)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "harmonics", harmonics)

    def loads(self, t: ArrayLike) -> Array:
        """Return the loads (..., 4) at the phase angles t (...) in radians."""
        orders = np.arange(1, len(self.harmonics) + 1)
        waves = np.exp(1j * np.asarray(t, dtype=np.float64)[..., None] * orders)
        return self.mean + np.real(waves @ self.harmonics)

    def extremes(self, weights: ArrayLike) -> tuple[Array, Array]:
        """Return least and greatest weights . loads, each (...).

        Mean -+ modulus for one harmonic; else among the real zeros of the derivative, from the
        roots of a polynomial of degree 2H in exp(i t). Exact to round-off.

        Args:
            weights: (..., 4).

        Raises:
            ValueError: if the last axis of ``weights`` does not have 4 entries.
        """
        checked = _check_weights(weights)
        centre = checked @ self.mean
        amplitudes = checked @ self.harmonics.T
        if len(self.harmonics) == 1:
            modulus = np.abs(amplitudes[..., 0])
            return centre - modulus, centre + modulus
        swing = np.apply_along_axis(_swing, -1, amplitudes)
        return centre + swing[..., 0], centre + swing[..., 1]


def factor_range(path: LoadPath, half_width: ArrayLike, side: Side) -> Array:
    """Return the range of K_T over the path, for ``edges.slip_length_cyclic``.

    Exact for the stuck contact of similar half-planes whose half-width does not change over the
    path: P and M of the path play no role.

    Args:
        path: closed path.
        half_width: a > 0, any shape.
        side: "left" or "right".

    Returns:
        Range of K_T, zero or more, in the shape of ``half_width``.

    Raises:
        ValueError: if ``half_width`` is not positive or ``side`` is unknown.
    """
    low, high = path.extremes(_tangential_weights(half_width, side))
    return high - low


def slip_length_over_path(
    path: LoadPath,
    k_n: ArrayLike,
    friction: ArrayLike,
    half_width: ArrayLike,
    side: Side,
    reference: ArrayLike,
) -> Array:
    """Return the inner end of the steady slip zone if the normal load varies as well.

    d = [max(K_T - f K_I) - min(K_T + f K_I)]/(f K_N), as ``edges.slip_length_loop`` does for
    sampled factors, but exact over the path. K_T and K_I count from the reference loads, d inward
    from the edge as it is under them. First order in the excursions of P and M about the reference:
    the half-width in the functionals is that of the reference. Half-planes; slip of one sign per
    half cycle. (Factor range)/(f K_N) if P and M are constant and those of the reference.

    Args:
        path: closed path.
        k_n: K_N under the reference loads; this and the next two of any shapes that broadcast.
        friction: coefficient f.
        half_width: a > 0 under the reference loads.
        side: "left" or "right".
        reference: (4,) loads. On the path d >= 0; elsewhere only P and M matter, and d < 0 says
            that the edge stays outside of its place in the reference.

    Raises:
        ValueError: if ``k_n``, ``friction`` or ``half_width`` is not positive, ``side`` is unknown
            or ``reference`` not four finite numbers.
    """
    origin = np.asarray(reference, dtype=np.float64)
    _check_load_state("reference", origin)
    f = check_positive("friction", friction)
    tangential = _tangential_weights(half_width, side)
    normal = f[..., None] * _functional(
        normal_force=normal_increment_factor(1.0, 0.0, half_width, side),
        moment=normal_increment_factor(0.0, 1.0, half_width, side),
    )
    high = path.extremes(tangential - normal)[1] - (tangential - normal) @ origin
    low = path.extremes(tangential + normal)[0] - (tangential + normal) @ origin
    return (high - low) / (f * check_positive("k_n", k_n))


def permanent_stick_load(path: LoadPath, friction: ArrayLike) -> Array:
    """Return P* = [min(Q + f P) - max(Q - f P)]/(2 f) (Barber, Davies and Hills 2011).

    In the steady state the zone that never slips is the contact area at the normal load P*, that is
    ``profile.half_width(P*)``. Any profile and any size of the loads; both bodies similar
    half-planes, no tension (a constant one has no part in the steady state), no rocking. Zero if
    every point slips during the cycle.

    Args:
        path: closed path with |Q| <= f P.
        friction: coefficient f, any shape.

    Raises:
        ValueError: if ``friction`` is not positive, if the bulk tension or the moment varies, or if
            |Q| exceeds f P somewhere: the contact would slide.
    """
    f = check_positive("friction", friction)
    _check_constant(path, "bulk tension", _functional(bulk_tension=1.0))
    _check_constant(path, "moment", _functional(moment=1.0))
    least, most = path.extremes(_functional(normal_force=f, shear_force=1.0))
    greatest = path.extremes(_functional(normal_force=-f, shear_force=1.0))[1]
    excess = np.maximum(-least, greatest)
    if np.any(excess > ROUND_OFF * np.abs(most)):
        raise ValueError(
            "path must have |shear force| <= friction * normal force, else the contact slides; "
            f"found an excess of {np.max(excess):g}"
        )
    return np.maximum(least - greatest, 0.0) / (2.0 * f)


def _check_constant(path: LoadPath, name: str, functional: Array) -> None:
    low, high = path.extremes(functional)
    if high - low > ROUND_OFF * np.maximum(np.abs(low), np.abs(high)):
        raise ValueError(
            f"path must have a constant {name}, else the permanent stick zone is not the contact "
            f"area at some normal load; found {low:g} to {high:g}"
        )


def _functional(
    *,
    normal_force: ArrayLike = 0.0,
    moment: ArrayLike = 0.0,
    shear_force: ArrayLike = 0.0,
    bulk_tension: ArrayLike = 0.0,
) -> Array:
    """Return weights (..., 4) of the load components."""
    columns = np.broadcast_arrays(normal_force, moment, shear_force, bulk_tension)
    return np.stack(columns, axis=-1).astype(np.float64)


def _tangential_weights(half_width: ArrayLike, side: Side) -> Array:
    return _functional(
        shear_force=tangential_factor(1.0, 0.0, half_width, side),
        bulk_tension=tangential_factor(0.0, 1.0, half_width, side),
    )


def _swing(amplitudes: NDArray[np.complex128]) -> Array:
    """Return least and greatest value (2,) of Re sum_k amplitudes[k - 1] exp(i k t)."""
    orders = np.arange(1, len(amplitudes) + 1)
    slopes = 1j * orders * amplitudes
    # A leading coefficient that is round-off would spoil the others as the polynomial is scaled.
    slopes[np.abs(slopes) <= 1e-15 * np.max(np.abs(slopes))] = 0.0
    roots = np.roots(np.concatenate([slopes[::-1], [0.0], slopes.conj()]))
    # Roots off the unit circle are no extremes, but their angle gives a value between them.
    angles = np.append(np.angle(roots), 0.0)
    values = np.real(np.exp(1j * np.outer(angles, orders)) @ amplitudes)
    return np.array([np.min(values), np.max(values)])


def _check_weights(weights: ArrayLike) -> Array:
    array = np.asarray(weights, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != COMPONENTS:
        raise ValueError(f"weights must have the shape (..., {COMPONENTS}), found {array.shape}")
    return array


def _check_states(name: str, states: NDArray[np.inexact]) -> None:
    if states.ndim != 2 or states.shape[1] != COMPONENTS or len(states) == 0:
        raise ValueError(
            f"{name} must have the shape (n, {COMPONENTS}), n >= 1, found {states.shape}"
        )
    _check_finite(name, states)


def _check_load_state(name: str, state: Array) -> None:
    if state.shape != (COMPONENTS,):
        raise ValueError(f"{name} must have the shape ({COMPONENTS},), found {state.shape}")
    _check_finite(name, state)


def _check_finite(name: str, values: NDArray[np.inexact]) -> None:
    if not np.all(np.isfinite(values)):
        raise ValueError(f"{name} must be finite, found {values[~np.isfinite(values)][0]}")


@dataclass(frozen=True)
class Rainflow:
    """Counted cycles of a history, n of them, in the order in which they were closed.

    Attributes:
        start, end: (n,) places of the two reversals in the history. In a repeated history `start`
            may stand behind `end`: the cycle then goes on in the next repetition.
        count: (n,) 1, or 0.5 for a range that no later one closes.
        range, mean: (n,) difference of the values at both reversals, positive, and their mean.
    """

    start: Indices
    end: Indices
    count: Array
    range: Array
    mean: Array


def rainflow(values: Array, repeated: bool = False) -> Rainflow:
    """Count the cycles of a history.

    Args:
        values: (T,) the history.
        repeated: it follows itself without end: it is counted from its largest value on, as
            section 5.4.5 has it, and all cycles are whole.

    Raises:
        ValueError: if a value is not finite.
    """
    values = np.asarray(values, dtype=np.float64)
    unknown = np.flatnonzero(~np.isfinite(values))
    if len(unknown):
        raise ValueError(f"expected finite values, found {values[unknown[0]]} at {unknown[0]}")
    order = np.arange(len(values))
    if repeated and len(values):
        largest = int(np.argmax(values))
        order = np.append(np.roll(order, -largest), largest)
    order = order[reversals(values[order])]
    pairs = np.array(list(_pairs(values[order].tolist(), repeated))).reshape(-1, 3)
    start, end = order[pairs[:, 0].astype(np.int64)], order[pairs[:, 1].astype(np.int64)]
    return Rainflow(
        start=start,
        end=end,
        count=pairs[:, 2],
        range=np.abs(values[end] - values[start]),
        mean=(values[end] + values[start]) / 2,
    )


def reversals(values: Array) -> Indices:
    """(n,) places of the first value, of all peaks and valleys, and of the last extreme.

    Of equal neighbours the first counts; a constant history has none.

    Args:
        values: (T,) finite.
    """
    places = np.append(0, 1 + np.flatnonzero(np.diff(values))) if len(values) else np.arange(0)
    if len(places) < 2:
        return places[:0]
    rises = np.diff(values[places]) > 0
    turns = 1 + np.flatnonzero(rises[1:] != rises[:-1])
    return np.asarray(places[[0, *turns, len(places) - 1]])


def _pairs(values: list[float], repeated: bool) -> Iterator[tuple[int, int, float]]:
    """Places of the two reversals of each cycle, and its count.

    Args:
        values: of the reversals; of a repeated history from its largest value to itself.
        repeated: whether it is one.
    """
    open_ones: list[int] = []
    for place, value in enumerate(values):
        open_ones.append(place)
        while len(open_ones) > 2:
            first, second = open_ones[-3:-1]
            if abs(value - values[second]) < abs(values[second] - values[first]):
                break
            if len(open_ones) > 3 or repeated:
                yield first, second, FULL
                del open_ones[-3:-1]
            else:
                # The range holds the starting point of the history: nothing has closed it.
                yield first, second, HALF
                del open_ones[0]
    for first, second in pairwise(open_ones):
        yield first, second, HALF
