# SPDX-License-Identifier: LGPL-3.0-or-later
"""Load paths: extremes against dense sampling, the edge laws over a path against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.analytic._numerics import Side
from fretfe.analytic.edges import (
    factor_range_phase_shifted,
    normal_increment_factor,
    slip_length_cyclic,
    slip_length_loop,
    slip_lengths_in_phase,
    tangential_factor,
)
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.paths import (
    HarmonicPath,
    PolygonPath,
    factor_range,
    permanent_stick_load,
    slip_length_over_path,
)
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge, edge_factor_k_n

A = 1.7
both_sides = pytest.mark.parametrize("side", ["left", "right"])
ROUND_OFF = 1e-13
# Around P, M, Q, sigma0 = 9, .5, -1, 2: four states, none of them in line.
POLYGON = PolygonPath(
    np.array([[9.0, 0.5, -1.0, 2.0], [9.4, 0.2, 1.0, 2.5], [8.8, 0.9, 1.3, 0.5], [8.5, 0, -0.4, 1]])
)
PHASES = [*np.linspace(0.0, np.pi, 9), 4.0, -0.3]


def harmonic(harmonics: int, seed: int = 1) -> HarmonicPath:
    random = np.random.default_rng(seed)
    amplitudes = random.normal(size=(harmonics, 4)) + 1j * random.normal(size=(harmonics, 4))
    return HarmonicPath(np.array([20.0, 0.3, -2.0, 5.0]), 0.1 * amplitudes)


def samples(path: PolygonPath) -> np.ndarray:
    """Return states (n, 4) along the closed polygon, with its vertices."""
    ends = np.roll(path.vertices, -1, axis=0)
    share = np.linspace(0.0, 1.0, 201)[:, None, None]
    return ((1 - share) * path.vertices + share * ends).reshape(-1, 4)


# --- extremes


def test_polygon_extremes_against_samples() -> None:
    weights = np.random.default_rng(3).normal(size=(5, 2, 4))
    values = weights @ samples(POLYGON).T
    low, high = POLYGON.extremes(weights)
    assert low.shape == high.shape == (5, 2)
    assert low == pytest.approx(values.min(axis=-1), abs=ROUND_OFF)
    assert high == pytest.approx(values.max(axis=-1), abs=ROUND_OFF)


@pytest.mark.parametrize("harmonics", [1, 2, 3, 7])
def test_harmonic_extremes_against_samples(harmonics: int) -> None:
    path, weights = harmonic(harmonics), np.random.default_rng(4).normal(size=(3, 4))
    # The samples miss an extreme by (dt/2)^2/2 of the second derivative, at most 50 here.
    values = path.loads(np.linspace(0, 2 * np.pi, 1000001)) @ weights.T
    low, high = path.extremes(weights)
    assert low == pytest.approx(values.min(axis=0), abs=1e-9)
    assert high == pytest.approx(values.max(axis=0), abs=1e-9)
    # Never within the sampled range.
    assert (low <= values.min(axis=0) + ROUND_OFF).all()
    assert (high >= values.max(axis=0) - ROUND_OFF).all()


@pytest.mark.parametrize("second", [0.0, 1e-18, 1e-6, 0.1, 0.25, 1.0])
def test_two_harmonics_in_closed_form(second: float) -> None:
    # cos(t) + b cos(2t): for b > 1/4 the least value moves away from t = pi. There, at b = 1/4,
    # four roots coincide.
    path = HarmonicPath(np.zeros(4), np.array([[0, 0, 1.0, 0], [0, 0, second, 0]]))
    low, high = path.extremes([0, 0, 1, 0])
    least = second - 1 if second <= 0.25 else -second - 1 / (8 * second)
    assert (low, high) == pytest.approx((least, 1 + second), rel=ROUND_OFF)


def test_only_a_higher_harmonic() -> None:
    path = HarmonicPath(np.full(4, 3.0), np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0, 2j, 0, 0]]))
    assert path.extremes([0, 1, 0, 0]) == pytest.approx((1.0, 5.0), rel=ROUND_OFF)
    assert path.extremes([1, 0, 0, 0]) == (3.0, 3.0)


def test_loads_of_a_harmonic_path() -> None:
    path = HarmonicPath(np.array([9, 0, 7, 3]), np.array([[0, 0, 2, 1.5 * np.exp(-0.4j)]]))
    t = np.linspace(0, 6, 5)
    expected = [9 + 0 * t, 0 * t, 7 + 2 * np.cos(t), 3 + 1.5 * np.cos(t - 0.4)]
    assert path.loads(t) == pytest.approx(np.stack(expected, axis=-1), abs=ROUND_OFF)
    assert path.loads(0.3).shape == (4,)


# --- edge laws


@both_sides
@pytest.mark.parametrize("phase", PHASES)
def test_phase_ellipse(phase: float, side: Side) -> None:
    path = HarmonicPath(np.array([9, 0, 7, 3]), np.array([[0, 0, 2, 1.5 * np.exp(-1j * phase)]]))
    a = np.array([0.4, A, 30.0])
    exact = factor_range_phase_shifted(2.0, 1.5, phase, a, side)
    assert factor_range(path, a, side) == pytest.approx(exact, rel=1e-12)


@both_sides
def test_factor_range_of_a_polygon(side: Side) -> None:
    states = samples(POLYGON)
    k_t = tangential_factor(states[:, 2], states[:, 3], A, side)
    assert factor_range(POLYGON, A, side) == pytest.approx(np.ptp(k_t), rel=ROUND_OFF)


@both_sides
@pytest.mark.parametrize("state", [0, 300])
def test_loop_over_a_path_against_samples(state: int, side: Side) -> None:
    loads = samples(POLYGON)
    k_t = tangential_factor(loads[:, 2], loads[:, 3], A, side)
    k_i = normal_increment_factor(loads[:, 0], loads[:, 1], A, side)
    expected = slip_length_loop(k_t, k_i, 2.5, 0.4, reference=state)
    found = slip_length_over_path(POLYGON, 2.5, 0.4, A, side, loads[state])
    assert found == pytest.approx(expected, rel=1e-12)
    assert found > 0


@both_sides
def test_loop_over_a_harmonic_path_against_samples(side: Side) -> None:
    path = harmonic(2)
    loads = path.loads(np.linspace(0, 2 * np.pi, 400001))
    k_t = tangential_factor(loads[:, 2], loads[:, 3], A, side)
    k_i = normal_increment_factor(loads[:, 0], loads[:, 1], A, side)
    found = slip_length_over_path(path, 2.5, [0.4, 0.1], A, side, loads[0])
    expected = [slip_length_loop(k_t, k_i, 2.5, f) for f in (0.4, 0.1)]
    # The samples miss the extremes by (dt)^2/8 of the second derivative.
    assert found == pytest.approx(expected, abs=1e-9)


@both_sides
def test_constant_normal_load_is_the_cyclic_law(side: Side) -> None:
    path = HarmonicPath(np.array([9, 0.4, 7, 3]), np.array([[0, 0, 2, 1j], [0, 0, 0.5, 0.3]]))
    expected = slip_length_cyclic(factor_range(path, A, side), 2.5, 0.4)
    found = slip_length_over_path(path, 2.5, 0.4, A, side, [9, 0.4, 0, 0])
    assert found == pytest.approx(expected, rel=1e-12)


@both_sides
@pytest.mark.parametrize("turn", [1.0, -1.0])
@pytest.mark.parametrize("shear", [0.01, 3.0])
def test_loop_in_phase_gives_the_lengths_at_high_and_low_load(
    shear: float, turn: float, side: Side
) -> None:
    low, high = np.array([9.0, 0.2, 1.0, 2.0]), np.array([9.5, 0.2, 1.0 + turn * shear, 2.0])
    path = PolygonPath(np.stack([low, high]))
    k_t_range = factor_range(path, A, side)
    k_i_range = normal_increment_factor(0.5, 0.0, A, side)
    expected = slip_lengths_in_phase(k_t_range, k_i_range, 2.5, 0.4)
    found = [slip_length_over_path(path, 2.5, 0.4, A, side, state) for state in (high, low)]
    assert found == pytest.approx(expected, abs=ROUND_OFF)


@both_sides
def test_border_does_not_depend_on_the_reference(side: Side) -> None:
    states = np.array([[9.0, 0.5, 0, 0], [9.3, 0.1, 5, -3]])
    found = [slip_length_over_path(POLYGON, 2.5, 0.4, A, side, state) for state in states]
    k_i = normal_increment_factor(states[:, 0], states[:, 1], A, side)
    # The edge advances by 2 dK_I/K_N from one reference to the other.
    assert found[1] - found[0] == pytest.approx(2 * (k_i[1] - k_i[0]) / 2.5, abs=ROUND_OFF)


# --- permanent stick zone

PROFILES: list[Profile] = [Hertz(2.0, 60.0), Wedge(0.1, 60.0), FlatRounded(0.3, 2.0, 60.0)]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("mean", [-0.3, 0.0, 0.4])
def test_permanent_stick_zone_at_constant_load(profile: Profile, mean: float) -> None:
    path = HarmonicPath(np.array([5.0, 0, mean, 7.0]), np.array([[0, 0, 1.2, 0]]))
    contact = PartialSlip(profile, 5.0, 0.4)
    found = profile.half_width(permanent_stick_load(path, 0.4))
    # The mean does not enter.
    assert found == pytest.approx(contact.stick_half_width(1.2), rel=1e-12)


@both_sides
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("phase", [0.0, 1.0, np.pi / 2, 2.5])
def test_permanent_stick_zone_of_small_excursions(
    profile: Profile, phase: float, side: Side
) -> None:
    size = 1e-5
    amplitudes = size * np.array([[1.0, 0, 0.9 * np.exp(-1j * phase), 0], [0.2j, 0, 0.3, 0]])
    path, f = HarmonicPath(np.array([5.0, 0, 0.2, 0]), amplitudes), 0.4
    a = profile.half_width(5.0)
    k_n = edge_factor_k_n(profile, a)
    asymptotic = slip_length_over_path(path, k_n, f, a, side, path.mean)
    exact = a - profile.half_width(permanent_stick_load(path, f))
    # First order in the excursions, 1e-5 of the load and no more than 1e-4 of the shoulder.
    assert asymptotic == pytest.approx(exact, rel=1e-4)


def test_permanent_stick_load_of_a_rectangle() -> None:
    # P from 8 to 10, Q from -1 to 2, f = .5: [(-1 + 4) - (2 - 4)]/1 = 5.
    states = np.array([[8.0, 0, -1, 3], [10, 0, -1, 3], [10, 0, 2, 3], [8, 0, 2, 3]])
    assert permanent_stick_load(PolygonPath(states), 0.5) == pytest.approx(5.0, rel=ROUND_OFF)
    found = permanent_stick_load(PolygonPath(states), [0.5, 0.25])
    # At f = 1/4, Q = 2 = f P slides just: [(-1 + 2) - (2 - 2)]/.5.
    assert found == pytest.approx([5.0, 2.0], rel=ROUND_OFF)


def test_no_permanent_stick_zone() -> None:
    path = HarmonicPath(np.array([5.0, 0, 0, 0]), np.array([[0, 0, 2.0, 0]]))
    assert permanent_stick_load(path, 0.4) == pytest.approx(0.0, abs=ROUND_OFF)


VALID = np.zeros((2, 4))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: PolygonPath(np.zeros((3, 3))), r"vertices must have the shape \(n, 4\), n >= 1"),
        (lambda: PolygonPath(np.zeros((0, 4))), r"found \(0, 4\)"),
        (lambda: PolygonPath(np.full((1, 4), np.nan)), "vertices must be finite, found nan"),
        (lambda: HarmonicPath(np.zeros(3), VALID), r"mean must have the shape \(4,\), found \(3,"),
        (lambda: HarmonicPath(np.zeros(4), np.zeros(4)), r"harmonics must have the shape \(n, 4\)"),
        (lambda: POLYGON.extremes([1.0, 2.0]), r"weights must have the shape \(..., 4\), found"),
        (lambda: harmonic(1).extremes(1.0), r"weights must have the shape \(..., 4\), found \(\)"),
        (lambda: factor_range(POLYGON, -1, "left"), r"half_width must lie in \(0, inf\), found -1"),
        (
            lambda: slip_length_over_path(POLYGON, 1, 1, 1, "left", [0, 0]),
            r"reference must have the shape \(4,\), found \(2,\)",
        ),
        (
            lambda: slip_length_over_path(POLYGON, 0, 1, 1, "left", np.zeros(4)),
            r"k_n must lie in \(0, inf\), found 0",
        ),
        (lambda: permanent_stick_load(POLYGON, 0), r"friction must lie in \(0, inf\), found 0"),
        (
            lambda: permanent_stick_load(POLYGON, 1),
            "path must have a constant bulk tension, .* found 0.5 to 2.5",
        ),
        (
            lambda: permanent_stick_load(PolygonPath(np.array([[1.0, 0, 0, 0], [1, 2, 0, 0]])), 1),
            "path must have a constant moment, .* found 0 to 2",
        ),
        (
            lambda: permanent_stick_load(PolygonPath(np.array([[1.0, 0, 0.5, 0]])), 0.4),
            r"\|shear force\| <= friction \* normal force, .* found an excess of 0.1",
        ),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
