# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Normal contact under a normal force and a moment: tilt, edges, K_N; profiles from tables.

The moment M is the integral of p x dx about the axis of symmetry of the profile: a positive one
loads the right edge. It tilts the body by theta, which makes the gap g(x) - theta x: the contact
left < x < right is unsymmetric. With its centre m, half of its width L, and xi = m + L cos(phi):

    theta = (1/pi) int_0^pi g'(xi) dphi
    P     = (E*/2) L int_0^pi cos(phi) g'(xi) dphi
    M     = P m + (E*/4) L^2 int_0^pi cos(2 phi) g'(xi) dphi
    K_N   = (E*/(2 pi)) sqrt(2L) int_0^pi [g'(xi) - g'(right)]/(xi - right) dphi

at the right edge, and with ``left`` in place of ``right`` at the left one. They follow from
(1/pi) int p(t)/(x - t) dt = (E*/2) [g'(x) - theta] (Johnson 1985, section 2.7) with the series
p = sum b_n sin(n phi), which gives g' - theta = (2/E*) sum b_n cos(n phi): P and M are b_1 and b_2,
theta the mean, K_N the slope of p at the edge. Half-planes, frictionless or elastically similar.
The contact is one interval if g' does not decrease along x (convex bodies).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fretfe._typing import Array, Bools
from fretfe.analytic._numerics import check_positive, check_range, graded_rule, solve_half_width
from fretfe.analytic.edges import edge_advance, normal_increment_factor
from fretfe.analytic.profiles import Profile

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_FEWEST_POINTS = 4
_MAX_ITERATIONS = 100
_MAX_CUTS = 20
# Steps of the moment where Newton's method fails from the symmetric contact: each 20 % more.
_FIRST_SHARE = 1e-3
_SHARES = 39
# Stands for 0 as a divisor of 0.
_SMALLEST_SINE = 1e-100
# Relative to P and to P times the half-width without moment.
_TOLERANCE = 1e-13
# Close to a flat, the loads themselves have no more digits.
_ACCEPTED = 1e-9


def tabulated_profile(x: ArrayLike, gap: ArrayLike, e_star: float) -> TabulatedProfile:
    """Return the profile through a table of the gap.

    Args:
        x: (n,) increasing positions, from 0 or over the full width of a symmetric table.
        gap: (n,) gap at these, 0 at x = 0 and nowhere falling away from it.
        e_star: composite modulus.

    Raises:
        ValueError: if the table has fewer than 4 points on a side, its positions do not increase,
            it has no point at x = 0 with gap 0, is not symmetric, or its gap falls with |x|.
    """
    position, height = np.asarray(x, dtype=np.float64), np.asarray(gap, dtype=np.float64)
    if position.ndim != 1 or position.shape != height.shape:
        raise ValueError(
            f"x and gap must be of the same length, found shapes {position.shape}, {height.shape}"
        )
    if not np.all(np.isfinite(position) & np.isfinite(height)):
        raise ValueError("x and gap must be finite, found nan or inf")
    if np.any(np.diff(position) <= 0.0):
        row = int(np.argmax(np.diff(position) <= 0.0))
        raise ValueError(f"x must increase, found {position[row]:g}, {position[row + 1]:g}")
    if position.size and position[0] < 0.0:
        position, height = _right_half(position, height)
    if position.size < _FEWEST_POINTS:
        raise ValueError(
            f"x must have at least {_FEWEST_POINTS} points from 0, found {position.size}"
        )
    if position[0] != 0.0 or height[0] != 0.0:
        raise ValueError(
            f"the table must have gap 0 at x = 0, found gap {height[0]:g} at {position[0]:g}"
        )
    if np.any(np.diff(height) < 0.0):
        row = int(np.argmax(np.diff(height) < 0.0))
        raise ValueError(
            f"gap must not fall with |x|, found {height[row]:g} at {position[row]:g} "
            f"and {height[row + 1]:g} at {position[row + 1]:g}"
        )
    # Brings SciPy's optimisers along, which nothing else here needs.
    from scipy.interpolate import CubicSpline

    return TabulatedProfile(CubicSpline(position, height, bc_type=((1, 0.0), "not-a-knot")), e_star)


def _right_half(position: Array, height: Array) -> tuple[Array, Array]:
    """Return the part x >= 0 of a table that is symmetric up to rounding in its text form."""
    mirrored = np.abs(position + position[::-1]) <= 1e-6 * position[-1]
    even = np.abs(height - height[::-1]) <= 1e-6 * np.max(np.abs(height))
    if not np.all(mirrored & even):
        row = int(np.argmin(mirrored & even))
        raise ValueError(
            f"a table from x < 0 must be symmetric, found gap {height[row]:g} at {position[row]:g} "
            f"and {height[-1 - row]:g} at {position[-1 - row]:g}"
        )
    middle = position.size // 2
    return position[middle:], height[middle:]


@dataclass(frozen=True)
class TabulatedProfile:
    """The cubic spline through the right half of a table, with slope 0 at x = 0.

    A spline rather than a monotone interpolation, because the pressure follows from g'': it is
    continuous and piecewise linear here, and jumps or vanishes at the points of a monotone one. The
    spline is exact for parabolas. Where the curvature of the gap jumps, as at the end of a flat,
    it overshoots by 5 % of the slope gained over one spacing h, over some spacings: the error is of
    the order h in the pressure there and h^3 in the load and in K_N. Noise must be smoothed
    beforehand; a corner at x = 0 is rounded over h.

    Between the points g'' = alpha + beta t; with A = sqrt(a^2 - t^2), B = sqrt(a^2 - x^2)

        P    = E* int_0^a A g'' dt           P' = E* a int_0^a g''/A dt
        p(x) = (E*/pi) int_0^a g'' ln[(A + B)/sqrt|t^2 - x^2|] dt

    (the formulas of ``fretfe.analytic.profiles`` by parts), integrated in closed form. All methods
    take arrays of any shape and raise a ValueError beyond the table, except ``gap`` and
    ``gap_slope``, which are NaN there.
    """

    spline: CubicSpline
    e_star: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_positive("e_star", self.e_star)

    @property
    def kinks(self) -> tuple[float, ...]:
        """None: g'' is continuous. The end of a flat is not told apart from other points."""
        return ()

    @property
    def inner_points(self) -> tuple[float, ...]:
        """The points between the ends of the table, where g''' jumps."""
        return tuple(float(point) for point in self.spline.x[1:-1])

    @property
    def largest_half_width(self) -> float:
        """End of the table."""
        return float(self.spline.x[-1])

    def gap(self, x: ArrayLike) -> Array:
        """Return g(x), NaN beyond the table."""
        return self.spline(np.abs(np.asarray(x, dtype=np.float64)), extrapolate=False)

    def gap_slope(self, x: ArrayLike) -> Array:
        """Return g'(x), odd in x, NaN beyond the table."""
        position = np.asarray(x, dtype=np.float64)
        return np.sign(position) * self.spline(np.abs(position), 1, extrapolate=False)

    def load(self, half_width: ArrayLike) -> Array:
        """Return P(a)."""
        a = self._check_half_width(half_width)[..., None]
        t = np.minimum(self.spline.x, a)
        height = np.sqrt((a - t) * (a + t))
        constant = (t * height + a**2 * self._angle(t, a)) / 2.0
        return self.e_star * self._sum(constant, -(height**3) / 3.0)

    def load_slope(self, half_width: ArrayLike) -> Array:
        """Return dP/da."""
        a = self._check_half_width(half_width)[..., None]
        t = np.minimum(self.spline.x, a)
        height = np.sqrt((a - t) * (a + t))
        return self.e_star * a[..., 0] * self._sum(self._angle(t, a), -height)

    def half_width(self, load: ArrayLike) -> Array:
        """Return a at a load P >= 0.

        Raises:
            ValueError: if the load is negative, or so large that a lies beyond the table.
        """
        points = self.spline.x
        loads = self.load(points)
        force = check_range("load", load, low=0.0)
        # Room for round-off in a load that was computed from the last point.
        if np.any(force > loads[-1] * (1.0 + 1e-12)):
            raise ValueError(
                f"load must not exceed {loads[-1]:g}, at which the contact reaches the end of the "
                f"table at {points[-1]:g}, found {np.max(force):g}"
            )
        force = np.minimum(force, loads[-1])
        # The last point whose load is not above: on a flat the spline has loads of both signs.
        least_beyond = np.minimum.accumulate(loads[::-1])[::-1]
        row = np.searchsorted(least_beyond, force, side="right") - 1
        high = points[np.minimum(row + 1, points.size - 1)]
        return solve_half_width(self.load, self.load_slope, force, points[row], high)

    def pressure(self, x: ArrayLike, half_width: ArrayLike) -> Array:
        """Return p(x), zero outside the contact."""
        a = self._check_half_width(half_width)
        distance, a = np.broadcast_arrays(np.abs(np.asarray(x, dtype=np.float64)), a)
        inside = distance < a
        found = np.zeros(a.shape)
        found[inside] = (
            self.e_star
            / np.pi
            * self._sum(
                *_kernels(
                    distance[inside][:, None],
                    np.minimum(self.spline.x, a[inside][:, None]),
                    a[inside][:, None],
                )
            )
        )
        return found

    def _check_half_width(self, half_width: ArrayLike) -> Array:
        return check_range("half_width", half_width, low=0.0, high=self.largest_half_width)

    def _angle(self, t: Array, a: Array) -> Array:
        return np.arcsin(np.divide(t, a, out=np.zeros_like(t), where=a > 0.0))

    def _sum(self, constant: Array, linear: Array) -> Array:
        """Return the integral of kernel times g'' from the primitives (..., n) at the points.

        Args:
            constant: primitive of the kernel.
            linear: primitive of t times the kernel.
        """
        slope, at_start = self.spline.derivative(2).c
        at_zero = at_start - slope * self.spline.x[:-1]
        return np.sum(at_zero * np.diff(constant) + slope * np.diff(linear), axis=-1)


def _kernels(x: Array, t: Array, a: Array) -> tuple[Array, Array]:
    """Return the primitives over t of the kernel of the pressure and of t times it, 0 <= x < a."""
    # Imported where it is needed: SciPy's special functions take a quarter of a second.
    from scipy.special import xlogy

    at_t, at_x = np.sqrt((a - t) * (a + t)), np.sqrt((a - x) * (a + x))
    distance = np.abs((t - x) * (t + x))
    constant = xlogy(t, at_t + at_x) - xlogy(x, (x * at_t + t * at_x) / a)
    constant += at_x * np.arcsin(t / a) - xlogy(t - x, distance) / 2.0
    squares = (t - x) * (t + x)
    linear = xlogy(squares, at_t + at_x) / 2.0 - xlogy(squares, distance) / 4.0 - at_t * at_x / 2.0
    return constant, linear


@dataclass(frozen=True)
class TiltedContact:
    """Contact under P and M; every array has the broadcast shape of the two, NaN where P = 0.

    Args:
        left: position of the left edge.
        right: position of the right edge.
        tilt: theta in radians, positive if the body turns towards the right edge.
        k_n_left: K_N of the left edge.
        k_n_right: K_N of the right edge.
    """

    left: Array
    right: Array
    tilt: Array
    k_n_left: Array
    k_n_right: Array

    def fields(self) -> tuple[Array, ...]:
        """Return all arrays, in the order in which they are declared."""
        return (self.left, self.right, self.tilt, self.k_n_left, self.k_n_right)


def tilted_contact(profile: Profile, normal_force: ArrayLike, moment: ArrayLike) -> TiltedContact:
    """Return the contact of a profile under a normal force and a moment.

    By Newton's method from the contact without moment. There is no largest moment as such: a body
    rolls on its profile until one edge leaves the part of it that is known. Solutions are found up
    to about M = 100 P a, with the half-width a without moment.

    Args:
        profile: symmetric profile with g' >= 0 for x > 0, and not decreasing.
        normal_force: P >= 0 per unit thickness, any shape.
        moment: M about the axis of symmetry of the profile, any shape that broadcasts with P.

    Raises:
        ValueError: if ``normal_force`` is negative or above what a table covers, or no contact is
            found for a ``moment``, as where one edge would lie beyond the end of a table.
    """
    force, couple = np.broadcast_arrays(
        check_range("normal_force", normal_force, low=0.0), check_range("moment", moment)
    )
    loaded = force > 0.0
    solved = _solve(profile, force[loaded], couple[loaded])
    fields = []
    for values in solved.fields():
        field = np.full(force.shape, np.nan)
        field[loaded] = values
        fields.append(field)
    return TiltedContact(*fields)


@dataclass(frozen=True)
class _Loads:
    """Contacts and the loads that they carry, all (n,)."""

    contact: TiltedContact
    force: Array
    moment: Array

    def at(self, row: Bools) -> _Loads:
        """Return a selection of the states."""
        contact = TiltedContact(*(values[row] for values in self.contact.fields()))
        return _Loads(contact, self.force[row], self.moment[row])

    def distance(self, force: Array, moment: Array, length: Array) -> Array:
        """Return the relative distance from other loads; infinite where this is no contact."""
        apart = np.hypot(self.force - force, (self.moment - moment) / length) / force
        pressed = (self.contact.k_n_left > 0.0) & (self.contact.k_n_right > 0.0)
        return np.where(pressed & np.isfinite(apart), apart, np.inf)


def _solve(profile: Profile, force: Array, moment: Array) -> TiltedContact:
    """Return the contacts under (n,) loads, all P > 0; the moment in steps where it must be."""
    scale = profile.half_width(force)
    start = _loads(profile, -scale, scale)
    state, failed = _newton(profile, start, force, moment, scale)
    if not np.any(failed):
        return state.contact
    row = failed
    part = start.at(row)
    for share in np.geomspace(_FIRST_SHARE, 1.0, _SHARES):
        part, failed = _newton(profile, part, force[row], share * moment[row], scale[row])
    if np.any(failed):
        raise ValueError(
            "moment must leave both edges on the profile, found no contact under the moment "
            f"{moment[row][failed][0]:g} and normal_force {force[row][failed][0]:g}"
        )
    for whole, values in zip(state.contact.fields(), part.contact.fields(), strict=True):
        whole[row] = values
    return state.contact


def _newton(
    profile: Profile, state: _Loads, force: Array, moment: Array, scale: Array
) -> tuple[_Loads, Bools]:
    """Return the contacts that Newton's method reaches, and which of them do not meet the loads.

    A step is cut to a share that brings the loads nearer; to none if there is none, as in round-off
    or at the end of a table.
    """
    residual = state.distance(force, moment, scale)
    active = residual > _TOLERANCE
    for _ in range(_MAX_ITERATIONS):
        left, right = _newton_step(state, force - state.force, moment - state.moment)
        share = active.astype(np.float64)
        for _ in range(_MAX_CUTS):
            trial = _moved(profile, state, share * left, share * right)
            worse = (share > 0.0) & ~(trial.distance(force, moment, scale) < residual)
            if not np.any(worse):
                break
            # Next to the solution a step that brings nothing is round-off.
            share = np.where(worse & (residual > _ACCEPTED), share / 4.0, share * ~worse)
        else:
            share *= ~worse
            trial = _moved(profile, state, share * left, share * right)
        state, residual = trial, trial.distance(force, moment, scale)
        active = (residual > _TOLERANCE) & (share > 0.0)
        if not np.any(active):
            break
    return state, residual > _ACCEPTED


def _moved(profile: Profile, state: _Loads, left: Array, right: Array) -> _Loads:
    return _loads(profile, state.contact.left + left, state.contact.right + right)


def _newton_step(state: _Loads, force: Array, moment: Array) -> tuple[Array, Array]:
    """Return how far increments of the loads move the left and the right edge along x."""
    contact = state.contact
    half = (contact.right - contact.left) / 2.0
    about_centre = moment - force * (contact.left + contact.right) / 2.0
    left = normal_increment_factor(force, about_centre, half, "left")
    right = normal_increment_factor(force, about_centre, half, "right")
    return -edge_advance(left, contact.k_n_left), edge_advance(right, contact.k_n_right)


def _loads(profile: Profile, left: Array, right: Array) -> _Loads:
    """Return the contacts with given edges (n,); NaN where these are out of order."""
    centre, half = (left + right) / 2.0, (right - left) / 2.0
    half = np.where(half > 0.0, half, np.nan)
    phi, weight = _rule(profile, centre, half)
    cosine = np.cos(phi)
    slope = profile.gap_slope(centre[:, None] + half[:, None] * cosine)
    at_left, at_right = profile.gap_slope(centre - half), profile.gap_slope(centre + half)
    mean = profile.e_star / 2.0 * half
    force = mean * np.sum(weight * cosine * slope, axis=-1)
    about_centre = mean / 2.0 * half * np.sum(weight * np.cos(2.0 * phi) * slope, axis=-1)
    # Half-angle forms of 1 - cos(phi) and 1 + cos(phi) keep their digits; pieces of no length end
    # up at the edges themselves.
    to_right = weight / np.maximum(np.sin(phi / 2.0), _SMALLEST_SINE) ** 2
    to_left = weight / np.maximum(np.cos(phi / 2.0), _SMALLEST_SINE) ** 2
    from_right = np.sum(to_right * (at_right[:, None] - slope), axis=-1)
    from_left = np.sum(to_left * (slope - at_left[:, None]), axis=-1)
    factor = profile.e_star / (2.0 * np.pi * np.sqrt(2.0 * half))
    tilt = np.sum(weight * slope, axis=-1) / np.pi
    contact = TiltedContact(left, right, tilt, factor * from_left, factor * from_right)
    return _Loads(contact, force, about_centre + centre * force)


def _rule(profile: Profile, centre: Array, half: Array) -> tuple[Array, Array]:
    """Return angles and weights (n, nodes) over 0 ... pi, split where the slope is not smooth."""
    one_side = profile.kinks
    if isinstance(profile, TabulatedProfile):
        one_side = profile.inner_points
    splits = np.array(sorted({0.0, *one_side, *(-place for place in one_side)}))[::-1]
    places = np.arccos(np.clip((splits - centre[:, None]) / half[:, None], -1.0, 1.0))
    ends = np.zeros((centre.size, 1))
    return graded_rule(np.concatenate([ends, places, ends + np.pi], axis=-1), (0.0, np.pi))
