# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tabulated profiles: exact for a parabola, convergence, quadrature of the same gap, errors."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.analytic.profiles import FlatRounded, GeneralProfile, Hertz, edge_factor_k_n
from fretfe.analytic.rocking import TabulatedProfile, tabulated_profile

E_STAR, RADIUS, FLAT, END = 110.0, 7.0, 0.6, 2.0
HERTZ, ROUNDED = Hertz(RADIUS, E_STAR), FlatRounded(FLAT, RADIUS, E_STAR)


def table(profile: Hertz | FlatRounded, points: int) -> TabulatedProfile:
    x = np.linspace(0.0, END, points)
    return tabulated_profile(x, profile.gap(x), E_STAR)


@pytest.mark.parametrize("x", [np.linspace(0, END, 9), np.array([0.0, 0.1, 0.7, 1.1, END])])
def test_parabola_is_hertz(x: np.ndarray) -> None:
    found, a = tabulated_profile(x, x**2 / (2 * RADIUS), E_STAR), np.linspace(0.0, END, 21)
    assert found.load(a) == pytest.approx(HERTZ.load(a), rel=1e-12)
    assert found.load_slope(a) == pytest.approx(HERTZ.load_slope(a), rel=1e-12)
    assert found.half_width(HERTZ.load(a)) == pytest.approx(a, rel=1e-12)
    places = np.linspace(-1.51, 1.53, 31)[:, None]
    peak = float(HERTZ.peak_pressure(END))
    exact = HERTZ.pressure(places, a)
    assert found.pressure(places, a) == pytest.approx(exact, abs=1e-12 * peak)
    assert found.gap(-x) == pytest.approx(HERTZ.gap(x), abs=1e-15)
    assert found.gap_slope(-x) == pytest.approx(-x / RADIUS, abs=1e-14)


def test_same_gap_by_quadrature() -> None:
    x = np.linspace(0.0, END, 6)
    found = tabulated_profile(x, np.cosh(x) - 1, E_STAR)
    same = GeneralProfile(found.gap_slope, E_STAR, found.inner_points)
    a, places = np.array([0.3, 1.0, 1.77]), np.array([0.0, 0.2, 0.4, 0.9, 1.5])[:, None]
    assert found.load(a) == pytest.approx(same.load(a), rel=1e-11)
    assert found.load_slope(a) == pytest.approx(same.load_slope(a), rel=1e-11)
    peak = float(same.pressure(0.0, 1.77))
    exact = same.pressure(places, a)
    assert found.pressure(places, a) == pytest.approx(exact, abs=1e-11 * peak)


@pytest.mark.parametrize("a", [0.9, 1.3])
def test_fine_table_of_flat_and_rounded_converges(a: float) -> None:
    errors, spacings = [], END / np.array([20, 40, 80, 160])
    for points in (21, 41, 81, 161):
        found = table(ROUNDED, points)
        k_n = edge_factor_k_n(found, a) / edge_factor_k_n(ROUNDED, a)
        errors.append([abs(found.load(a) / ROUNDED.load(a) - 1), abs(k_n - 1)])
    # Third order on average over changing places of the kink between the points.
    rate = np.polyfit(np.log(spacings), np.log(errors), 1)[0]
    assert (rate > 2.5).all()
    assert np.max(errors[-1]) < 1e-5


@pytest.mark.parametrize("points", [21, 81, 321])
def test_pressure_next_to_the_kink_is_of_first_order(points: int) -> None:
    x = np.linspace(0.0, 1.29, 400)
    error = np.abs(table(ROUNDED, points).pressure(x, 1.3) - ROUNDED.pressure(x, 1.3))
    # Change of the slope over one spacing, E* h/R, times a factor of order 1 (measured: 0.2).
    assert error.max() < 0.3 * E_STAR / RADIUS * END / (points - 1)


@pytest.mark.parametrize("points", [41, 161])
def test_no_load_leaves_the_flat(points: int) -> None:
    # Within one spacing.
    found = table(ROUNDED, points).half_width(0.0)
    assert found == pytest.approx(FLAT, abs=END / (points - 1))
    assert table(HERTZ, points).half_width(0.0) == 0.0


def test_largest_load_is_within_the_table() -> None:
    found = table(ROUNDED, 41)
    assert found.half_width(found.load(END)) == pytest.approx(END, rel=1e-14)
    assert found.largest_half_width == END


def test_symmetric_table_is_its_right_half() -> None:
    x = np.linspace(-END, END, 41)
    half = table(ROUNDED, 21)
    found = tabulated_profile(x, ROUNDED.gap(x), E_STAR)
    assert found.load([0.8, 1.5]) == pytest.approx(half.load([0.8, 1.5]), rel=1e-12)
    assert found.inner_points == pytest.approx(half.inner_points)
    assert found.kinks == half.kinks == ()


def test_gap_is_unknown_beyond_the_table() -> None:
    found = table(HERTZ, 9)
    assert np.isnan(found.gap([-2.1, 2.0, 2.1])).tolist() == [True, False, True]
    assert np.isnan(found.gap_slope([-2.1, 2.0, 2.1])).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("x", "gap", "message"),
    [
        ([0, 1, 2], [0, 1, 2], "x must have at least 4 points from 0, found 3"),
        ([-2, -1, 0, 1, 2], [4, 1, 0, 1, 4], "x must have at least 4 points from 0, found 3"),
        ([0, 1, 2, 3], [0, 1, 2], r"same length, found shapes \(4,\), \(3,\)"),
        ([0, 1, 1, 3], [0, 1, 2, 3], "x must increase, found 1, 1"),
        ([0, 1, 2, 3], [0, 2, 1, 3], "gap must not fall with |x|, found 2 at 1 and 1 at 2"),
        ([0, 1, 2, 3], [0, 2, np.nan, 3], "x and gap must be finite"),
        ([0, 1, 2, 3], [1, 2, 3, 4], "must have gap 0 at x = 0, found gap 1 at 0"),
        ([1, 2, 3, 4], [0, 2, 3, 4], "must have gap 0 at x = 0, found gap 0 at 1"),
        (
            [-3, -2, -1, 0, 1, 2, 3],
            [9, 4, 1, 0, 1, 5, 9],
            "must be symmetric, found gap 4 at -2 and 5 at 2",
        ),
        ([], [], "x must have at least 4 points from 0, found 0"),
    ],
)
def test_bad_table(x: list[float], gap: list[float], message: str) -> None:
    with pytest.raises(ValueError, match=message.replace("|x|", r"\|x\|")):
        tabulated_profile(x, gap, E_STAR)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: table(HERTZ, 9).half_width([1.0, 60.0]),
            "load must not exceed 49.3679, at which the contact reaches the end of the table at 2, "
            "found 60",
        ),
        (lambda: table(HERTZ, 9).load(2.1), r"half_width must lie in \[0, 2\], found 2.1"),
        (lambda: table(HERTZ, 9).half_width(-1.0), r"load must lie in \[0, inf\), found -1"),
        (lambda: tabulated_profile([0, 1, 2, 3], [0, 1, 2, 3], 0.0), r"e_star must lie in \(0"),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
