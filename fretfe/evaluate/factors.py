# SPDX-License-Identifier: LGPL-3.0-or-later
"""Singular factors of edges through a history: direction, range, unlike bodies at lengths."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.edges import at_length, oscillation, sliding_exponent
from fretfe.evaluate.contacts import RangeSpread
from fretfe.evaluate.edge_fit import EdgeFit
from fretfe.evaluate.load_path import STRAIGHT, LoadPath, excess
from fretfe.history.solution import Factor

# Nodes in contact that factors and useful error bars need: as many as fits to full stick.
WANTED_NODES = 16
# Between unlike bodies K_T and K_I are those at these parts of the reference length: with K_N at
# the length of the slip zone (11) then holds to first order in f beta. K_N(d) exceeds that of the
# mean of both ends of the cycle by (2 - 2 ln 2) f beta/pi, and that has f d K_N = dK_T + f dK_I(d)
# + (1 + 2 ln 2) f beta/pi dK_T: together K_I at exp(-3) d. At the border of stick the traction of
# full stick counts with 1/sqrt(s (d - s)), over which the mean of ln s is ln(d/4).
K_T_LENGTH = 0.25
K_I_LENGTH = math.exp(-3)
# A slip zone of which nothing is known is taken for so long, in half-widths.
UNKNOWN_ZONE = 0.1
# Slip zones that are less than this fraction of the half-width, and edges that move by less than
# that of the surface between two loads, do not tell anything.
SMALLEST_MOVE = 1e-6
# Iterations for the reference length, which hardly matters.
LENGTH_ITERATIONS = 5
# Components of a direction below this are round-off.
ROUND_OFF = 1e-9


def main_direction(history: Array, cycle: Indices) -> tuple[Array, float]:
    """(k,) unit vector along which factors of shear (T, k) vary most, and how much it turns.

    Its first component is positive: K along it has the sign of K_T, or of K_S without any K_T.
    """
    vectors = history[cycle] if len(cycle) else history
    vectors = vectors[np.isfinite(vectors).all(axis=1)]
    if len(vectors) < 2 or not np.ptp(vectors[:, 1:], axis=0).any():
        return np.eye(history.shape[1])[0], 0.0
    axes = np.linalg.svd(vectors - vectors.mean(axis=0), full_matrices=False)[2]
    along, across = (np.ptp(vectors @ axis) for axis in axes)
    leading = axes[0, 0] if abs(axes[0, 0]) > ROUND_OFF else axes[0, 1]
    return np.asarray(axes[0] * (1.0 if leading >= 0 else -1.0)), float(across / along)


def along_line(factors: Array, direction: Array) -> Array:
    """(..., T) factors (..., T, d) of shear along a direction (2,) of (K_T, K_S), or of K_T."""
    shear = factors[..., Factor.K_T :]
    return np.asarray(shear @ direction[: shear.shape[-1]])


@dataclass(frozen=True)
class FactorHistories:
    """Singular factors of all stations in every state.

    Attributes:
        ways: (R, stations, T, d) in R ways.
        fitted: (stations, T, d) by fits to tractions; None without them.
        exact: True for closed forms.
        one_sided: (stations, T) what steps up to each state may be wrong by in |K| together of
            which one end only is known.
        uneven: (stations, T) what they may be wrong by as edges move within them.
        known: (T,) states whose own area tells the factors, of one of the stations at least.
        units: (T, stations, d, J) for a unit of each driver, of unlike bodies at the length 1.
    """

    ways: Array
    fitted: Array | None
    exact: bool
    one_sided: Array
    uneven: Array
    known: Bools
    units: Array

    def directions(self, cycle: Indices) -> list[tuple[Array, float]]:
        """Direction of (K_T, K_S) and how much it turns at each station, by `main_direction`."""
        shear = self.ways.mean(axis=0)[..., Factor.K_T :]
        padded = np.pad(shear, ((0, 0), (0, 0), (0, 2 - shear.shape[2])))
        return [main_direction(each, cycle) for each in padded]

    def at(self, dundurs: float, lengths: Array) -> FactorHistories:
        """The same of unlike bodies at the reference lengths (stations,), from those at 1."""

        def turned(factors: Array) -> Array:
            own = [
                factors_at(factors[..., station, :, :], dundurs, length)
                for station, length in enumerate(lengths)
            ]
            return np.stack(own, axis=-3)

        fitted = None if self.fitted is None else turned(self.fitted)
        return replace(self, ways=turned(self.ways), fitted=fitted)

    def range_spread(
        self,
        number: int,
        direction: Array,
        unresolved: list[float],
        states: Indices,
        path: LoadPath | None,
    ) -> RangeSpread:
        """Error bar of the range of (K_T, K_S) over some states, of one station.

        Args:
            number: of the station.
            direction: (2,) of (K_T, K_S).
            unresolved: errors by the elements, of which the first two are of `misplaced_range`.
            states: of the evaluated cycle.
            path: loads of the cycle between its steps, unless they are straight lines.
        """
        ways = along_line(self.ways[:, number], direction)
        ranges, mean = [cycle_range(way, states) for way in ways], ways.mean(axis=0)
        # One way alone has no spread unless it is exact.
        alone = 0.0 if self.exact else math.nan
        moved = [range_error(mean, e[number], states) for e in (self.one_sided, self.uneven)]
        held, apart, *others = unresolved
        return RangeSpread(
            extraction=float(np.ptp(ranges)) / 2 if len(ranges) > 1 else alone,
            discretisation=math.hypot(held, *others),
            steps=excess(mean, path),
            moved=math.hypot(*moved, apart),
        )


def cycle_range(history: Array, cycle: Indices) -> float:
    """Largest less smallest of a history (T,) over the states of a cycle; NaN without one."""
    return float(np.ptp(history[cycle])) if len(cycle) else np.nan


def range_error(history: Array, error: Array, states: Indices) -> float:
    """Error bar of the range of a history (T,) over states: what lies between its ends counts.

    Args:
        history: the factor.
        error: (T,) what it may be wrong by since the beginning.
        states: of the range; none gives 0.
    """
    ranges = [cycle_range(history + sign * error, states) for sign in (-1.0, 0.0, 1.0)]
    return max(ranges) - ranges[1] if len(states) else 0.0


def misplaced_range(
    own: Array, growing: Array, shares: Array, cycle: Indices
) -> tuple[float, float]:
    """Errors of the range of a factor (T,) over a cycle where its edge is misplaced.

    Of the edge as it is where its place is known best, and what that adds up to beyond in steps in
    other places.

    Args:
        own: the factor.
        growing: that of which its increments may be wrong by shares.
        shares: (T,) of increments in each state; NaN where the place is not known.
        cycle: states.
    """
    best = np.full(len(shares), np.fmin.reduce(shares[cycle], initial=math.nan))
    held, whole = (range_error(own, misplaced_sums(growing, e), cycle) for e in (best, shares))
    return held, math.sqrt(max(whole**2 - held**2, 0.0))


def misplaced_sums(history: Array, shares: Array) -> Array:
    """(T,) what a factor may be wrong by since the beginning where its edge is misplaced.

    Args:
        history: (T,) the factor; steps to and from states in which it is not known do not count.
        shares: (T,) what increments may be wrong by in a state, over themselves; NaN if not known.
    """
    either = np.fmax(shares[1:], shares[:-1])
    return np.append(0.0, np.cumsum(np.nan_to_num(either * np.diff(history))))


def reference_length(
    dundurs: float,
    fit: EdgeFit,
    factors: Array,
    friction: Array,
    half_width: float,
    cycle: Indices,
    pressed: bool = False,
) -> float:
    """Length at which edge factors between unlike bodies are told: that of the predicted slip zone.

    Args:
        dundurs: beta.
        fit: K_N of a station, at the length 1.
        factors: (T, d) its singular factors, at the length 1.
        friction: (T,) coefficient there.
        half_width: of the contact.
        cycle: states of the evaluated cycle; without one the zone is that of first loading.
        pressed: whether P alone drives the edge; the zone is then not predicted.
    """
    length, share = UNKNOWN_ZONE * half_width, 1.0 if len(cycle) else 2.0
    states = cycle if len(cycle) else np.flatnonzero(np.isfinite(factors).all(axis=1))
    for _ in range(LENGTH_ITERATIONS):
        if pressed or not len(states):
            break
        shear = factors_at(factors, dundurs, length)[:, Factor.K_T :]
        reach = float(np.ptp(shear[states] @ main_direction(shear, cycle)[0]))
        found = share * reach / (friction.max() * fit.told(length)[states[-1]])
        if not SMALLEST_MOVE * half_width < found < half_width:
            break
        length = float(found)
    return length


def sliding_apart(dundurs: float, friction: float, direction: Array) -> float:
    """|lambda - 1/2| where an edge between unlike bodies slides.

    Args:
        dundurs: beta.
        friction: coefficient at the edge.
        direction: (2,) of the slip, as of `main_direction`: its inward part meets the pressure.
    """
    return float(abs(sliding_exponent(dundurs, friction * float(direction[0])) - 0.5))


def reversed_share(along: Array, cycle: Indices) -> Array:
    """(T,) part of the range of a factor of shear that has passed since its last extreme.

    To first order the slip zone of the state is so much of that of the whole reversal; 1 outside
    the cycle, where nothing changes, and without a cycle.

    Args:
        along: (T,) factor of shear, NaN where unknown.
        cycle: states of the evaluated cycle, of which the last one is like the first one.
    """
    shares = np.ones(len(along))
    values, steps = along[cycle], max(len(cycle) - 1, 1)
    if not len(cycle) or not np.ptp(values) > 0:
        return shares
    far = np.array([values.max(), values.min()])
    near = np.isclose(values, far[:, None], rtol=0.0, atol=STRAIGHT * np.ptp(values))
    # A cycle hardly ever closes to round-off: its last state ends what its first one ended.
    near[:, [0, -1]] = near[:, [0, -1]].any(axis=1, keepdims=True)
    at = np.argmax(near, axis=1)
    since = (np.arange(len(cycle)) - at[:, None]) % steps
    passed = np.abs(values - far[np.argmin(since, axis=0)]) / np.ptp(values)
    # An extreme ends a reversal, as long as it holds.
    shares[cycle] = np.where(near.any(axis=0), 1.0, passed)
    return shares


def rotated(units: Array, dundurs: float, ratio: Array) -> Array:
    """Unit factors (n, ..., d, J) of unlike bodies at lengths that are ratios (n,) of theirs."""
    if not dundurs:
        return units
    ratio = ratio.reshape(-1, *[1] * (units.ndim - 2))
    whole = units[..., Factor.K_I, :] + 1j * units[..., Factor.K_T, :]
    turned = at_length(whole, oscillation(dundurs), ratio)
    found = units.copy()
    found[..., Factor.K_I, :], found[..., Factor.K_T, :] = turned.real, turned.imag
    return found


def factors_at(factors: Array, dundurs: float, length: float) -> Array:
    """(..., d) singular factors at their parts of a reference length, from those at 1.

    K_S does not depend on it.
    """
    whole, epsilon = factors[..., Factor.K_I] + 1j * factors[..., Factor.K_T], oscillation(dundurs)
    found = factors.copy()
    found[..., Factor.K_I] = at_length(whole, epsilon, K_I_LENGTH * length).real
    found[..., Factor.K_T] = at_length(whole, epsilon, K_T_LENGTH * length).imag
    return found


def whole_factor(
    k_i: Array, k_t: Array, dundurs: float, length: float, wanted: float
) -> npt.NDArray[np.complex128]:
    """K_I + i K_T (complex, any shape) at a wanted length, from both at parts of another one.

    Args:
        k_i: at `K_I_LENGTH` times the length.
        k_t: at `K_T_LENGTH` times the length.
        dundurs: beta.
        length: the reference length.
        wanted: the other length.
    """
    epsilon = oscillation(dundurs)
    # K_I + i K_T where K_I is told, whose imaginary part follows from K_T farther out.
    turn = np.exp(1j * epsilon * np.log(K_T_LENGTH / K_I_LENGTH))
    whole = k_i + 1j * (k_t - k_i * turn.imag) / turn.real
    return at_length(whole, epsilon, wanted / (K_I_LENGTH * length))
