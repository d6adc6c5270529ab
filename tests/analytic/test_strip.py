# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts of half-planes with a table of gaps, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.analytic.profiles import FlatRounded, edge_factor_k_n
from fretfe.analytic.strip import strip_contact

X = np.linspace(-8.0, 8.0, 641)


def test_a_cylinder_beside_the_middle() -> None:
    # a² = 4 P R/(π E*), p0 = 2 P/(π a), K_N = p0 sqrt(2/a); a grows by da/dlnP = a/2.
    found = strip_contact(X, (X - 1) ** 2 / 100, np.pi / 200)
    assert found is not None
    # The table has 40 gaps over the half-width, and places of edges are interpolated.
    np.testing.assert_allclose(found.edges, [0.0, 2.0], atol=1e-3)
    np.testing.assert_allclose(found.growth, 0.5, rtol=5e-3)
    np.testing.assert_allclose(found.k_n, 0.01 * np.sqrt(2), rtol=5e-3)
    # The first increment, 1 % of P, is even.
    np.testing.assert_allclose(found.peaks, 0.01, rtol=0.02)


@pytest.mark.parametrize(("flat", "load"), [(0.2, 0.005), (1.0, 0.005), (1.0, 0.02)])
def test_a_flat_with_rounded_ends(flat: float, load: float) -> None:
    profile = FlatRounded(flat, 8.0, 1.0)
    a = float(profile.half_width(load))
    x = np.linspace(-flat - 0.6, flat + 0.6, 801)
    found = strip_contact(x, profile.gap(x), load)
    assert found is not None
    # 30 gaps or more over the rounding in contact.
    assert found.half_width == pytest.approx(a, rel=1e-3)
    np.testing.assert_allclose(found.k_n, edge_factor_k_n(profile, a), rtol=0.01)
    peak = profile.pressure(np.linspace(0.0, a, 4001)[:-1], a).max()
    np.testing.assert_allclose(found.peaks, peak, rtol=0.01)


def test_unlike_roundings_have_edges_of_their_own() -> None:
    """Next to a long flat K_N = 2 E* sqrt(d)/(π R), and P K_N is the same at both ends."""
    x = np.linspace(-2.4, 2.4, 4001)
    beyond = np.maximum(np.abs(x) - 2.0, 0.0)
    found = strip_contact(x, beyond**2 / np.where(x > 0, 4.0, 16.0), 1e-3)
    assert found is not None
    reach, radius = np.abs(found.edges) - 2.0, np.array([8.0, 2.0])
    # To first order in d over the flat, .03.
    np.testing.assert_allclose(found.k_n, 2 * np.sqrt(reach) / (np.pi * radius), rtol=0.03)
    assert reach[0] == pytest.approx(reach[1] * 4 ** (2 / 3), rel=0.03)


def test_nothing_is_said_of_several_parts_or_of_contacts_up_to_an_end() -> None:
    two = np.minimum((X - 3) ** 2, (X + 3) ** 2) / 100
    assert strip_contact(X, two, np.pi / 200) is None
    x = np.linspace(0.0, 3.0, 31)
    assert strip_contact(x, x**2 / 40, 1e-3) is None
    assert strip_contact(x, 0.1 * (3.0 - x), 1e-3) is None
    assert strip_contact(x[:2], x[:2] ** 2, 1e-3) is None  # one facet
    assert strip_contact(X, 0 * X, 1e-3) is None  # flat up to its corners
    assert strip_contact(X, X**2 / 100, 10.0) is None


def test_of_a_contact_far_smaller_than_its_table_nothing_is_told() -> None:
    assert strip_contact(X, X**2 / 100, 1e-18) is None
