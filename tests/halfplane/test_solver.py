# SPDX-License-Identifier: LGPL-3.0-or-later
"""Normal contact, moment, equilibrium and convergence of the half-plane solution."""

from __future__ import annotations

import numpy as np
import pytest
from cases.halfplane_problems import FRICTION, HERTZ, LIMIT, LOAD, loop, problem, solved

from fretfe._typing import Array
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import FlatRounded, Profile, Wedge, edge_factor_k_n
from fretfe.analytic.rocking import tilted_contact
from fretfe.halfplane import contact_grid, solve_half_planes
from fretfe.local.hat_functions import HatFunctions

PROFILES: dict[str, Profile] = {
    "Hertz": HERTZ,
    "wedge": Wedge(0.01, 100.0),
    "flat and rounded, b/a .5": FlatRounded(0.5, 20.0, 100.0),
    "flat and rounded, b/a .95": FlatRounded(0.95, 1.0, 100.0),
}


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_pressure_and_edges(profile: Profile) -> None:
    given = problem(float(profile.load(1.0)), profile=profile)
    solution = solve_half_planes(given).solution
    contact, summary = solution.contacts[0], solved(given)
    scale = 1.0 - max(profile.kinks, default=0.0)
    for edge, sign in zip(summary.stations, (-1, 1), strict=True):
        assert sign * edge.position[-1] == pytest.approx(1.0, abs=5e-4 * scale)
        # the fits of K_N are good to 0.5 % on any profile; Hertz is exact for them
        assert edge.k_n[-1] == pytest.approx(float(edge_factor_k_n(profile, 1.0)), rel=5e-3)
        # the second K_N: differences of positions, at loads 10 % apart
        assert edge.k_n_moved == pytest.approx(float(edge_factor_k_n(profile, 1.0)), rel=0.01)
    x = contact.surface.arc
    # without the edges, the apex of the wedge, and the kinks, where the pressure has a steep bend
    smooth = (np.abs(x) < 0.999) & (np.abs(x) > 0.02)
    for kink in profile.kinks:
        smooth &= np.abs(np.abs(x) - kink) > 0.01
    expected = profile.pressure(x, 1.0)
    error = np.abs(contact.mean_traction[-1, :, 0] - expected)[smooth].max()
    assert error < 0.01 * expected[smooth].max()


@pytest.mark.parametrize("moment", [0.3, -0.3])
@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_moment_moves_the_edges(profile: Profile, moment: float) -> None:
    load = float(profile.load(1.0))
    scale = 1.0 - max(profile.kinks, default=0.0)
    m = moment * load * scale
    summary = solved(problem(load, 0.0, m, profile=profile))
    expected = tilted_contact(profile, load, m)
    # the moment acts at the right edge if it is positive
    assert np.sign(summary.centre[-1]) == np.sign(moment)
    for edge, position, k_n in zip(
        summary.stations,
        (expected.left, expected.right),
        (expected.k_n_left, expected.k_n_right),
        strict=True,
    ):
        assert edge.position[-1] == pytest.approx(float(position), abs=5e-4 * scale)
        assert edge.k_n[-1] == pytest.approx(float(k_n), rel=0.01)
    # M about the centre of the contact
    assert summary.moment[-1] == pytest.approx(m - load * summary.centre[-1], abs=1e-4 * load)


def test_a_rocking_hertz_pad_slips_where_it_rolls() -> None:
    # A Hertz contact under a moment is the same contact shifted by M/P: with friction acting and
    # no shear force the edges move over stuck material.
    m = 0.1 * LOAD * np.sin(loop(40, 2))
    summary = solved(problem(LOAD, 0.0, m, cycle=40))
    assert summary.centre[-11] == pytest.approx(-0.1, abs=1e-3)
    assert summary.centre[-31] == pytest.approx(0.1, abs=1e-3)
    assert summary.half_width[6:] == pytest.approx(np.ones(81), abs=1e-3)
    assert np.abs(summary.shear_force).max() < 1e-12


def test_forces_balance() -> None:
    given = problem(LOAD, [0.3, -0.2], 0.1, [0.1, 0.3])
    solution = solve_half_planes(given).solution
    worst = solution.certificates["force_imbalance"].max()
    # the spring that holds the pad while there is no friction takes 1e-9 of its force
    assert worst < 1e-8 * LOAD
    assert solution.certificates["worst"].max() < 1e-10
    summary = solved(given)
    assert summary.normal_force == pytest.approx(given.normal_force, abs=1e-12)
    assert summary.shear_force == pytest.approx(given.shear_force, rel=1e-8)


def test_convergence_under_refinement() -> None:
    q1 = 0.5 * LIMIT
    given = problem(LOAD, q1 * np.linspace(0.2, 1.0, 5))
    reference = PartialSlip(HERTZ, LOAD, FRICTION)
    border = float(reference.stick_half_width(q1))
    pressures, shears = [], []
    for elements in (40, 80, 160, 320):
        contact = solve_half_planes(given, elements).solution.contacts[0]
        x, w = contact.surface.arc, contact.surface.weights
        p, q = contact.mean_traction[-1].T
        # The shear has a square root at the border of the stick zone, somewhere in an element.
        inside = np.abs(x) < 0.99
        away = inside & (np.abs(np.abs(x) - border) > 0.1)
        pressures.append(_mean_square(p - HERTZ.pressure(x, 1.0), w * inside))
        shears.append(_mean_square(q - reference.shear(x, q1), w * away) / FRICTION)
        assert contact_grid(given, elements).size == elements + 1
    # order 2 for the pressure
    assert np.all(np.log2(np.array(pressures[:-1]) / pressures[1:]) > 1.9)
    # the shear also feels where in its element the border lies
    assert shears[-1] < shears[0] / 10 and shears[-1] < 2e-4


def _mean_square(error: Array, weights: Array) -> float:
    return float(np.sqrt(np.sum(weights * error**2)))


def test_the_grid_is_graded_to_the_edges_of_the_cycle() -> None:
    p = LOAD * (1 + 0.5 * np.sin(loop(20, 2)))
    given = problem(p, 0.1 * np.sin(loop(20, 2)), cycle=20)
    grid = contact_grid(given, 200)
    low, high = (float(HERTZ.half_width(LOAD * factor)) for factor in (0.5, 1.5))
    sizes = np.diff(grid)
    middle = np.abs((grid[1:] + grid[:-1]) / 2)
    travelled = (middle > low) & (middle < high)
    assert sizes[travelled].max() < 0.3 * sizes[middle < 0.05].min()
    assert grid == pytest.approx(-grid[::-1], abs=1e-12)
    assert grid[-1] > high


def test_kinks_are_nodes() -> None:
    profile = FlatRounded(0.7, 20.0, 100.0)
    given = problem(float(profile.load(1.0)), profile=profile)
    grid = contact_grid(given, 120)
    assert np.abs(grid - 0.7).min() == np.abs(grid + 0.7).min() == 0.0


def test_compliance_is_symmetric_and_exact() -> None:
    grid = np.sort(np.concatenate([np.linspace(-1, 1, 9), [-0.999, 0.995, 0.05]]))
    hats = HatFunctions(grid)
    matrix = hats.compliance(1.0)
    assert matrix == pytest.approx(matrix.T, rel=1e-12)
    # a uniform traction on |x| < 1: w = -(2/pi) int ln|x - y| dy in closed form
    wide = HatFunctions(np.concatenate([[-1 - 1e-9], np.linspace(-1, 1, 41), [1 + 1e-9]]))
    x = np.linspace(-1, 1, 200_001)
    with np.errstate(divide="ignore", invalid="ignore"):
        primitive = np.nan_to_num((x + 1) * np.log(x + 1)) + np.nan_to_num((1 - x) * np.log(1 - x))
    displacement = -(2 / np.pi) * (primitive - 2)
    total = wide.compliance(1.0) @ np.ones(len(wide.nodes))
    for i in (0, 1, 20, 39, 40):
        hat = np.interp(x, wide.grid, np.eye(len(wide.grid))[i + 1])
        expected = np.trapezoid(hat * displacement, x)
        assert total[i] == pytest.approx(expected, abs=1e-7)
