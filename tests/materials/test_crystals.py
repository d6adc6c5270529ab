# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes and crack tips of crystals: closed forms, and two formalisms against each other."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe._typing import Array
from fretfe.materials.crystals import (
    CrackTip,
    HalfPlane,
    around,
    bunge_rotation,
    couples_across,
    coupling,
    cubic,
    isotropic,
    orthotropic_compliance,
    plane_stress,
    slip_systems,
    smallest_eigenvalue,
    triclinic,
    turned,
    young_and_poisson,
)

# Rows normal (y), tangent (x), across (z).
FRAME = np.eye(3)[[1, 0, 2]]
# A nickel alloy, MPa.
NICKEL = cubic(252e3, 161e3, 131e3)
E, NU = 210e3, 0.3
ENGINEERING = ((120e3, 80e3, 60e3), (0.3, 0.25, 0.2), (40e3, 30e3, 20e3))


def rotations(count: int) -> Array:
    generator = np.random.default_rng(5)
    found = np.array([np.linalg.qr(generator.normal(size=(3, 3)))[0] for _ in range(count)])
    return found * np.sign(np.linalg.det(found))[:, None, None]


def displacement(tip: CrackTip, ahead: float, height: float, side: int) -> Array:
    """(d, d) displacement by each unit factor; the root is cut through the other body."""
    root = np.exp(0.25j * np.pi * side) * np.sqrt(-1j * side * (ahead + tip.roots * height))
    return np.sqrt(2 / np.pi) * (tip.shapes @ root).real


def test_isotropic_half_plane_has_the_constants_of_hertz() -> None:
    found = HalfPlane.of(isotropic(E, NU), rotations(1)[0])
    prime = E / (1 - NU**2)
    expected = np.diag([2 / prime, 2 / prime, 2 * (1 + NU) / E])
    np.testing.assert_allclose(found.compliance, expected, atol=1e-14 * expected.max())
    assert found.skew[0, 1] == pytest.approx((1 + NU) * (1 - 2 * NU) / E, rel=1e-13)
    short = HalfPlane.isotropic(E, NU, "strain")
    np.testing.assert_allclose(short.compliance, expected, rtol=1e-14)
    np.testing.assert_allclose(short.skew, found.skew, atol=1e-19)


def test_isotropic_plane_stress() -> None:
    found = HalfPlane.of(plane_stress(isotropic(E, NU)), FRAME)
    short = HalfPlane.isotropic(E, NU, "stress")
    np.testing.assert_allclose(found.compliance, short.compliance, atol=1e-19)
    np.testing.assert_allclose(found.skew, short.skew, atol=1e-19)
    assert short.compliance[0, 0] == pytest.approx(2 / E, rel=1e-14)


@pytest.mark.parametrize("angle", [0.0, 15.0, 30.0, 45.0])
def test_cubic_crystal_turned_about_its_axis_across_the_plane_is_the_same(angle: float) -> None:
    found = HalfPlane.of(turned(NICKEL, bunge_rotation((angle, 0.0, 0.0)).T), FRAME)
    numbers = np.diag([9.14631e-6, 9.14631e-6, 7.63359e-6])
    np.testing.assert_allclose(found.compliance, numbers, rtol=1e-6, atol=1e-18)
    assert found.skew[0, 1] == pytest.approx(2.42131e-6, rel=2e-6)
    start = HalfPlane.of(NICKEL, FRAME)
    np.testing.assert_allclose(found.compliance, start.compliance, atol=1e-19)
    np.testing.assert_allclose(found.skew, start.skew, atol=1e-19)


def test_orthotropic_half_plane_in_closed_form() -> None:
    compliance = orthotropic_compliance(*ENGINEERING)
    matrix = np.linalg.inv(compliance)
    found = HalfPlane.of(matrix, FRAME)
    reduced = compliance - np.outer(compliance[:, 2], compliance[2]) / compliance[2, 2]
    root = np.sqrt(reduced[0, 0] * reduced[1, 1])
    both = np.sqrt(2 * root + 2 * reduced[0, 1] + reduced[5, 5])
    across = 1 / np.sqrt(matrix[3, 3] * matrix[4, 4])
    expected = [np.sqrt(reduced[1, 1]) * both, np.sqrt(reduced[0, 0]) * both, across]
    np.testing.assert_allclose(found.compliance.diagonal(), expected, rtol=1e-12)
    assert found.skew[0, 1] == pytest.approx(root + reduced[0, 1], rel=1e-12)


@pytest.mark.parametrize("matrix", [NICKEL, np.linalg.inv(orthotropic_compliance(*ENGINEERING))])
def test_eigenvectors_and_integrals_agree(matrix: Array) -> None:
    """The faces of a crack open by L^-1 k, and what is ahead of it moves by S L^-1 k."""
    for frame in rotations(6):
        tip, plane = CrackTip.of(turned(matrix, frame), 3), HalfPlane.of(matrix, frame)
        opened = displacement(tip, -1.0, 0.0, 1).T * np.sqrt(np.pi / 2)
        ahead = displacement(tip, 1.0, 0.0, 1).T * np.sqrt(np.pi / 2)
        largest = np.abs(plane.compliance).max()
        np.testing.assert_allclose(opened, plane.compliance, atol=1e-12 * largest)
        np.testing.assert_allclose(ahead, plane.skew.T, atol=1e-12 * largest)
        np.testing.assert_allclose(displacement(tip, -1.0, 0.0, -1), -opened.T / np.sqrt(np.pi / 2))


@pytest.mark.parametrize("size", [2, 3])
def test_isotropic_crack_tip_is_that_of_williams(size: int) -> None:
    tip = CrackTip.of(isotropic(E, NU), size)
    kolosov, shear, radius = 3 - 4 * NU, E / (2 * (1 + NU)), 0.7
    for side in (1, -1):
        for angle in np.linspace(0.0, np.pi, 7) * side:
            s, c = np.sin(angle / 2), np.cos(angle / 2)
            shapes = np.array(
                [
                    [s * (kolosov + 1 - 2 * c**2), c * (kolosov - 1 + 2 * s**2), 0],
                    [c * (1 - kolosov + 2 * s**2), s * (kolosov + 1 + 2 * c**2), 0],
                    [0, 0, 4 * s],
                ]
            )[:size, :size]
            expected = shapes * np.sqrt(radius / (2 * np.pi)) / (2 * shear)
            found = displacement(tip, radius * np.cos(angle), radius * np.sin(angle), side)
            # Equal roots are moved apart: 5e-11.
            np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_generalised_beta_is_that_of_dundurs() -> None:
    (young1, nu1), (young2, nu2) = (210e3, 0.3), (70e3, 0.2)
    mu1, mu2 = young1 / (2 + 2 * nu1), young2 / (2 + 2 * nu2)
    kappa1, kappa2 = 3 - 4 * nu1, 3 - 4 * nu2
    beta = (mu1 * (kappa2 - 1) - mu2 * (kappa1 - 1)) / (mu1 * (kappa2 + 1) + mu2 * (kappa1 + 1))
    bodies = [HalfPlane.of(isotropic(*each), FRAME) for each in ((young1, nu1), (young2, nu2))]
    assert coupling(bodies[0], bodies[1]) == pytest.approx(abs(beta), rel=1e-12)
    assert coupling(bodies[0], bodies[0]) == 0


def test_directions_around_a_normal_are_frames() -> None:
    frames = around(np.array([0.6, 0.0, 0.8]))
    np.testing.assert_allclose(
        frames @ frames.swapaxes(1, 2), np.tile(np.eye(3), (24, 1, 1)), atol=1e-15
    )
    np.testing.assert_allclose(frames.sum(axis=0)[0] / 24, [0.6, 0.0, 0.8])


def test_young_modulus_along_the_diagonal_of_a_cube() -> None:
    """1/E111 = s11 - 2 (s11 - s12 - s44/2)/3 (Nye, Physical Properties of Crystals)."""
    s = np.linalg.inv(NICKEL)
    expected = s[0, 0] - 2 * (s[0, 0] - s[0, 1] - s[3, 3] / 2) / 3
    axis = np.ones(3) / np.sqrt(3)
    frame = around(axis)[0]
    assert np.linalg.inv(turned(NICKEL, frame))[0, 0] == pytest.approx(expected, rel=1e-12)


def test_euler_angles_turn_the_model_into_the_crystal() -> None:
    np.testing.assert_allclose(bunge_rotation((90, 0, 0))[0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(bunge_rotation((0, 90, 0))[2], [0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(bunge_rotation((0, 0, 90))[0], [0, 1, 0], atol=1e-15)
    # About z, then the new x: z goes along -(new y).
    np.testing.assert_allclose(bunge_rotation((90, 90, 0))[2], [1, 0, 0], atol=1e-15)


def test_constants_in_voigts_order() -> None:
    np.testing.assert_array_equal(triclinic(NICKEL[np.triu_indices(6)].tolist()), NICKEL)
    turn = rotations(1)[0]
    there_and_back = turned(turned(NICKEL, turn), turn.T)
    np.testing.assert_allclose(there_and_back, NICKEL, atol=1e-9)


def test_the_eigenvalue_does_not_depend_on_the_axes() -> None:
    """That of pure shear, c11 - c12, or 2 c44, or of pressure."""
    assert smallest_eigenvalue(NICKEL) == pytest.approx(252e3 - 161e3)
    assert smallest_eigenvalue(turned(NICKEL, rotations(1)[0])) == pytest.approx(91e3)
    assert smallest_eigenvalue(cubic(1.0, 2.0, 1.0)) == pytest.approx(-1.0)


def test_isotropic_constants_are_recognised() -> None:
    found = young_and_poisson(turned(isotropic(E, NU), rotations(1)[0]))
    assert found is not None and found == pytest.approx((E, NU), rel=1e-12)
    assert young_and_poisson(NICKEL) is None
    assert young_and_poisson(cubic(1.0, -2.0, 1.0)) is None


@pytest.mark.parametrize(
    ("along", "octahedral", "cube"),
    [
        ([0, 0, 1], 1 / np.sqrt(6), 0.0),
        ([1, 1, 1], np.sqrt(2 / 27), np.sqrt(2) / 3),
        ([0, 1, 1], 1 / np.sqrt(6), np.sqrt(2) / 4),
    ],
)
def test_schmid_factors_in_tension(along: list[int], octahedral: float, cube: float) -> None:
    """Those of textbooks for the corners of the standard triangle, in crystals turned any way."""
    for axes in rotations(3):
        pull = np.array(along) / np.linalg.norm(along) @ axes
        systems = slip_systems(axes)
        assert [len(each) for each in systems] == [12, 6]
        assert max(np.abs(np.trace(each, axis1=1, axis2=2)).max() for each in systems) < 1e-15
        found = [np.abs(np.einsum("sij,i,j->s", each, pull, pull)).max() for each in systems]
        assert found == pytest.approx([octahedral, cube], abs=1e-12)


def test_planes_of_symmetry() -> None:
    assert couples_across(turned(NICKEL, bunge_rotation((30, 0, 0)))) < 1e-15
    assert couples_across(turned(NICKEL, bunge_rotation((0, 20, 30)))) > 0.1
    # The diagonal of a face is normal to a plane of symmetry, too.
    assert couples_across(turned(NICKEL, bunge_rotation((0, 45, 0)).T)) < 1e-15
