# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge cracks against integral equations that others have solved, and the free surface."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array, Complexes
from fretfe.analytic.cracks import EdgeCracks, dislocation_traction


def uniform(angle: float, count: int = 60) -> Array:
    """(2,) K over √(π c) under a unit tension along the surface; angle in degrees."""
    cracks = EdgeCracks.of([np.radians(angle)], count)
    stress = np.zeros((*cracks.points([1.0]).shape[:-1], 3))
    stress[..., 0] = 1.0
    return cracks.factors([1.0], stress)[:, 0, 0] / np.sqrt(np.pi)


@pytest.mark.parametrize(
    ("power", "known"), [(0, 1.12152), (1, 0.68286), (2, 0.52549), (3, 0.44098)]
)
def test_a_normal_crack_under_powers_of_the_depth(power: int, known: float) -> None:
    cracks = EdgeCracks.of([0.0])
    lengths = np.array([0.5, 2.0])
    points = cracks.points(lengths)
    stress = np.zeros((*points.shape[:-1], 3))
    stress[..., 0] = (-points[..., 1] / lengths[:, None]) ** power
    k_1, k_2 = cracks.factors(lengths, stress)
    assert k_1[0] / np.sqrt(np.pi * lengths) == pytest.approx([known, known], abs=3e-5)
    assert k_2 == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("angle", "known"),
    [(15, (1.0685, 0.1738)), (30, (0.920, 0.3058)), (45, (0.705, 0.3645)), (60, (0.4625, 0.336))],
)
def test_an_inclined_crack_under_tension(angle: float, known: tuple[float, float]) -> None:
    """Handbooks give three digits."""
    assert uniform(angle) == pytest.approx(known, abs=5e-4)
    assert uniform(angle) == pytest.approx(uniform(angle, 240), abs=1e-4)


def test_a_crack_to_the_other_side_is_the_mirrored_one() -> None:
    k_1, k_2 = uniform(30)
    assert uniform(-30) == pytest.approx([k_1, -k_2], abs=1e-12)


def test_the_surface_is_free_of_a_dislocation() -> None:
    surface = np.linspace(-3, 4, 29).astype(np.complex128)
    for strength in (1.0, 1j, 0.3 - 0.8j):
        there = dislocation_traction(surface, np.array(0.4 - 0.7j), strength, 1)
        alone = 2 * strength / (surface - (0.4 - 0.7j))
        assert np.abs(there).max() < 1e-14 < 0.1 < np.abs(alone).max()


def test_a_dislocation_needs_no_force_to_hold_it() -> None:
    """Tractions on circles around it, and around another place, have no resultant."""
    turns: Complexes = np.exp(2j * np.pi * np.arange(400) / 400)
    for middle in (0.4 - 0.7j, 1.0 - 1.5j):
        stress = dislocation_traction(
            np.asarray(middle + 0.3 * turns), np.array(0.4 - 0.7j), 0.3 + 1j, np.asarray(1j * turns)
        )
        forces = -turns * np.conj(stress)
        assert abs(forces.mean()) < 1e-12 < 0.1 < np.abs(forces).mean()


def test_far_from_the_surface_a_dislocation_is_that_of_a_plane() -> None:
    along, strength = np.exp(0.4j), 0.3 + 1j
    found = dislocation_traction(np.array(0.01 * along - 100j), np.array(-100j), strength, along)
    assert found == pytest.approx(200 * np.conj(strength / along), rel=1e-3)


def test_pressed_faces_have_a_negative_factor() -> None:
    cracks = EdgeCracks.of(np.radians([-45.0, 0.0, 45.0]))
    stress = np.zeros((4, *cracks.points([0.1, 1.0]).shape[:-1], 3))
    stress[..., :2] = -np.arange(4.0)[:, None, None, None, None]
    k_1, k_2 = cracks.factors([0.1, 1.0], stress)
    assert k_1.shape == (4, 3, 2)
    assert (k_1[1:] < 0).all() and k_1[2] == pytest.approx(2 * k_1[1])
    assert k_2[:, 1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("angle", [np.radians(81), -1.5, np.nan])
def test_cracks_along_the_surface_are_refused(angle: float) -> None:
    with pytest.raises(ValueError, match="angles must lie in"):
        EdgeCracks.of([0.0, angle])
