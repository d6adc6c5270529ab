# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact under force and moment: closed forms, equilibrium of the pressure, edge increments."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from fretfe.analytic.edges import edge_advance, normal_increment_factor
from fretfe.analytic.profiles import (
    FlatRounded,
    GeneralProfile,
    Hertz,
    Profile,
    Wedge,
    edge_factor_k_n,
)
from fretfe.analytic.rocking import tabulated_profile, tilted_contact

E_STAR, RADIUS, SLOPE = 110.0, 7.0, 0.03
HERTZ, WEDGE = Hertz(RADIUS, E_STAR), Wedge(SLOPE, E_STAR)
GRID = np.linspace(0.0, 4.0, 30)
PROFILES: dict[str, Profile] = {
    "hertz": HERTZ,
    "wedge": WEDGE,
    "rounded": FlatRounded(0.6, RADIUS, E_STAR),
    "power": GeneralProfile(lambda t: 0.06 * t**0.5, E_STAR, (0.0,)),
    "table": tabulated_profile(GRID, 0.05 * np.cosh(GRID) - 0.05, E_STAR),
}
every_profile = pytest.mark.parametrize("name", list(PROFILES))
FORCE, MOMENT = np.array([[0.7], [3.0], [6.0]]), np.array([-0.8, -0.1, 0.3, 0.9])


@every_profile
def test_no_moment_is_the_symmetric_contact(name: str) -> None:
    profile = PROFILES[name]
    found = tilted_contact(profile, FORCE, 0.0)
    a = profile.half_width(FORCE)
    assert found.right == pytest.approx(a, rel=1e-11)
    assert found.left == pytest.approx(-a, rel=1e-11)
    assert found.tilt == pytest.approx(0.0, abs=1e-15)
    k_n = edge_factor_k_n(profile, a)
    assert found.k_n_left == pytest.approx(k_n, rel=1e-11)
    assert found.k_n_right == pytest.approx(k_n, rel=1e-11)


@every_profile
def test_the_other_moment_is_the_mirror_image(name: str) -> None:
    found = tilted_contact(PROFILES[name], FORCE, MOMENT)
    left, right, tilt, k_n_left, k_n_right = tilted_contact(PROFILES[name], FORCE, -MOMENT).fields()
    mirrored = [-right, -left, -tilt, k_n_right, k_n_left]
    # The tolerance of the solution, times the largest ratio of an edge movement to the half-width.
    for one, other in zip(found.fields(), mirrored, strict=True):
        assert one == pytest.approx(other, rel=1e-9, abs=1e-12)


def test_hertz_rolls_without_change() -> None:
    found = tilted_contact(HERTZ, FORCE, [-50.0, -0.1, 0.3, 200.0])
    centre, a = np.array([-50.0, -0.1, 0.3, 200.0]) / FORCE, HERTZ.half_width(FORCE)
    assert (found.left + found.right) / 2 == pytest.approx(centre, rel=1e-11)
    # Rounding of edges that are a hundred half-widths from the axis.
    assert (found.right - found.left) / 2 == pytest.approx(a + 0 * centre, rel=1e-11)
    assert found.tilt == pytest.approx(centre / RADIUS, rel=1e-11)
    k_n = E_STAR / (2 * RADIUS) * np.sqrt(2 * a) + 0 * centre
    assert found.k_n_left == pytest.approx(k_n, rel=1e-9)
    assert found.k_n_right == pytest.approx(k_n, rel=1e-9)


def test_wedge_in_closed_form() -> None:
    """The integrals of a step: centre m = 2M/P, half of the width L = sqrt(a^2 + m^2)."""
    moment = np.array([-10.0, -0.1, 0.3, 3.0])
    found = tilted_contact(WEDGE, FORCE, moment)
    m = 2 * moment / FORCE
    half = np.hypot(WEDGE.half_width(FORCE), m)
    # Angle of the apex; L sin = a.
    apex = np.arctan2(WEDGE.half_width(FORCE), -m)
    assert (found.left + found.right) / 2 == pytest.approx(m, rel=1e-9)
    assert (found.right - found.left) / 2 == pytest.approx(half, rel=1e-9)
    assert found.tilt == pytest.approx(SLOPE * (2 * apex / np.pi - 1), rel=1e-9)
    scale = E_STAR * SLOPE / np.pi * np.sqrt(2 / half)
    # The apex is close to an edge under the largest moments.
    assert found.k_n_right == pytest.approx(scale / np.tan(apex / 2), rel=1e-8)
    assert found.k_n_left == pytest.approx(scale * np.tan(apex / 2), rel=1e-8)


def test_flat_and_rounded_on_one_shoulder_is_hertz_there() -> None:
    profile, force = FlatRounded(0.6, RADIUS, E_STAR), np.array([0.1, 1.0])
    found = tilted_contact(profile, force, 3.0 * force)
    # The gap differs from (x - b)^2/(2R) only where there is no contact.
    a = HERTZ.half_width(force)
    assert found.left == pytest.approx(3.0 - a, rel=1e-11)
    assert found.right == pytest.approx(3.0 + a, rel=1e-11)
    assert found.tilt == pytest.approx(2.4 / RADIUS, rel=1e-11)
    assert found.k_n_left == pytest.approx(edge_factor_k_n(HERTZ, a), rel=1e-9)


def series_pressure(profile: Profile, left: float, right: float) -> np.ndarray:
    """Return b_1 ... b_N of p = sum b_n sin(n phi), by the cosine series of the slope."""
    count = 20000
    phi = (np.arange(count) + 0.5) / count * np.pi
    slope = profile.gap_slope((left + right) / 2 + (right - left) / 2 * np.cos(phi))
    return np.array([E_STAR / count * np.sum(slope * np.cos(n * phi)) for n in range(1, 400)])


@pytest.mark.parametrize(("force", "moment"), [(2.0, 0.5), (2.0, -1.0), (0.5, 0.28)])
def test_pressure_carries_force_and_moment(force: float, moment: float) -> None:
    profile = FlatRounded(0.6, RADIUS, E_STAR)
    contact = tilted_contact(profile, force, moment)
    left, right = float(contact.left), float(contact.right)
    factors, n = series_pressure(profile, left, right), np.arange(1, 400)
    phi = (np.arange(20000) + 0.5) / 20000 * np.pi
    p = np.sin(np.outer(phi, n)) @ factors
    x = (left + right) / 2 + (right - left) / 2 * np.cos(phi)
    width = (right - left) / 2 * np.sin(phi) * np.pi / 20000
    assert p.min() > 0.0
    # Midpoint rules across the kink: of the order of 1/20000^2.
    assert np.sum(width * p) == pytest.approx(force, rel=1e-7)
    assert np.sum(width * p * x) == pytest.approx(moment, rel=1e-6)


@pytest.mark.parametrize("point", [-0.3, 0.2, 0.75])
def test_pressure_bends_the_surfaces_to_the_tilted_profile(point: float) -> None:
    profile = FlatRounded(0.6, RADIUS, E_STAR)
    contact = tilted_contact(profile, 2.0, 0.5)
    left, right = float(contact.left), float(contact.right)
    factors, n = series_pressure(profile, left, right), np.arange(1, 400)

    def pressure(x: float) -> float:
        angle = np.arccos(np.clip((2 * x - left - right) / (right - left), -1, 1))
        return float(np.sin(n * angle) @ factors)

    # (1/pi) int p(t)/(x - t) dt = (E*/2) (g'(x) - theta) by an adaptive principal value.
    principal = quad(
        pressure, left, right, weight="cauchy", wvar=point, epsabs=1e-6, epsrel=1e-6, limit=400
    )[0]
    expected = E_STAR / 2 * (profile.gap_slope(point) - contact.tilt)
    # The series ends at 400 terms that fall like 1/n^2.
    assert -principal / np.pi == pytest.approx(expected, abs=1e-3)


@every_profile
@pytest.mark.parametrize(("d_force", "d_moment"), [(1.0, 0.0), (0.0, 1.0), (-0.4, 0.7)])
def test_load_increments_move_the_edges(name: str, d_force: float, d_moment: float) -> None:
    profile, step = PROFILES[name], 1e-5
    at = tilted_contact(profile, FORCE, MOMENT)
    up = tilted_contact(profile, FORCE + step * d_force, MOMENT + step * d_moment)
    down = tilted_contact(profile, FORCE - step * d_force, MOMENT - step * d_moment)
    half, centre = (at.right - at.left) / 2, (at.right + at.left) / 2
    about_centre = d_moment - d_force * centre
    advance_left = edge_advance(
        normal_increment_factor(d_force, about_centre, half, "left"), at.k_n_left
    )
    advance_right = edge_advance(
        normal_increment_factor(d_force, about_centre, half, "right"), at.k_n_right
    )
    # Round-off of the edges over the step, and the second order of the step.
    assert (down.left - up.left) / (2 * step) == pytest.approx(advance_left, rel=1e-5, abs=1e-6)
    assert (up.right - down.right) / (2 * step) == pytest.approx(advance_right, rel=1e-5, abs=1e-6)


def test_a_flat_punch_rolls_over_its_corner() -> None:
    # A flat of half-width b stays down up to M = P b/2; beyond P b it stands on one shoulder.
    profile, force = FlatRounded(1.0, RADIUS, E_STAR), 1e-3
    found = tilted_contact(profile, force, force * np.array([0.3, 0.9, 1.5, 5.0]))
    assert found.left[0] < -1.0 < 0.5 < found.left[1] < 1.0
    centre, a = np.array([1.5, 5.0]), HERTZ.half_width(force)
    assert found.left[2:] == pytest.approx(centre - a, rel=1e-9)
    assert found.right[2:] == pytest.approx(centre + a, rel=1e-9)


def test_no_force_no_contact() -> None:
    found = tilted_contact(WEDGE, [0.0, 1.0], [[0.0], [1.0]])
    for field in found.fields():
        assert np.isnan(field).tolist() == [[True, False], [True, False]]


def test_many_states_at_a_time() -> None:
    t = np.linspace(0.0, 2 * np.pi, 400)
    force, moment = 3.0 + np.cos(t), 2.0 * np.sin(t)
    found = tilted_contact(PROFILES["rounded"], force, moment)
    alone = tilted_contact(PROFILES["rounded"], force[150], moment[150])
    assert found.right[150] == pytest.approx(float(alone.right), rel=1e-12)
    assert found.left.shape == (400,)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tilted_contact(HERTZ, -1.0, 0.0), r"normal_force must lie in \[0, inf\), found"),
        (lambda: tilted_contact(HERTZ, 1.0, np.nan), "moment must lie in"),
        (
            lambda: tilted_contact(PROFILES["table"], 1.0, [0.1, 100.0]),
            "moment must leave both edges on the profile, found no contact under the moment 100",
        ),
        (lambda: tilted_contact(PROFILES["table"], 1e5, 0.0), "load must not exceed"),
    ],
)
def test_out_of_range(call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(ValueError, match=message):
        call()
