# SPDX-License-Identifier: LGPL-3.0-or-later
"""Gaps between two curved surfaces follow the sliding of one along the other."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from cases import chains, sheets

from fretfe._typing import Array
from fretfe.surface.mortar import Coupling, couple

Profile = Callable[[Array], Array]
RADIUS, SLIDING = 1.2, 0.04
SIDES = pytest.mark.parametrize("side", ["surface1", "surface2"])


def rounded(begin: float, sign: int) -> Profile:
    """Flat up to x = begin, from there on (or, sign -1, up to there) an arc."""
    return lambda x: RADIUS - np.sqrt(RADIUS**2 - np.maximum(sign * (x - begin), 0.0) ** 2)


def circle(radius: float) -> Profile:
    return lambda x: radius - np.sqrt(radius**2 - x**2)


def coupled(upper: Profile, lower: Profile, side: str, count: int = 160) -> Coupling:
    """Curved facets, each second one three times as long; flats end between two of them."""
    x, other = np.linspace(-1.0, 1.0, 2 * count + 1), np.linspace(-1.0, 1.0, count + 1)
    for places in (x, other):
        places[2:-1:4] += 0.5 * (places[1] - places[0])  # ends of facets, every second one
        places[1::2] = (places[:-2:2] + places[2::2]) / 2
    first = chains.surface("upper", np.stack([x, upper(x)], axis=1), True)
    second = chains.surface("lower", np.stack([other, -lower(other)], axis=1)[::-1], True)
    return couple("main", first, second, side, 2)


def opened(coupling: Coupling, sliding: float) -> Array:
    """Mean gaps around the nodes that a sliding of body 1 opens."""
    assert coupling.slid is not None
    weights = coupling.surface.weights
    moved = np.full((len(weights), 1), -sliding)
    return coupling.slid.opened(moved, np.ones(len(weights))) / weights


def means(change: Profile, nodes: Array) -> Array:
    """Means of a change of gap with hats, of the nodes inside."""
    at, weights = np.polynomial.legendre.leggauss(5)
    share = (at + 1) / 2
    left, right = np.diff(nodes)[:-1, None], np.diff(nodes)[1:, None]
    middle = nodes[1:-1, None]
    rising = left * (weights * share * change(middle - left * (1 - share))).sum(1, keepdims=True)
    falling = right * (weights * (1 - share) * change(middle + right * share)).sum(1, keepdims=True)
    return ((rising + falling) / (left + right))[:, 0]


@SIDES
def test_roundings_on_opposite_bodies(side: str) -> None:
    """The flat becomes shorter, by half of the sliding at each end."""
    upper, lower, half = rounded(-0.5, -1), rounded(0.5, 1), SLIDING / 2
    coupling = coupled(upper, lower, side)
    nodes = coupling.surface.points[:, 0]
    found = opened(coupling, SLIDING)[1:-1]
    expected = means(lambda x: upper(x - half) - upper(x) + lower(x + half) - lower(x), nodes)
    assert expected.max() > 5e-4
    inside = np.abs(nodes[1:-1]) < 0.9
    # Hats of .025 of the other side where curvatures jump; means taken for values at the nodes of
    # such uneven elements are off by 5e-5 or more all along the roundings.
    np.testing.assert_allclose(found[inside], expected[inside], atol=4e-5)


@SIDES
def test_nothing_opens_in_place(side: str) -> None:
    coupling = coupled(rounded(-0.5, -1), rounded(0.5, 1), side)
    np.testing.assert_allclose(opened(coupling, 0.0), 0.0, atol=1e-16)


@SIDES
def test_beside_a_flat_and_between_arcs_nothing_is_followed(side: str) -> None:
    """A cylinder that slides by s over another comes down by s²/(2 (R1 + R2)), everywhere."""
    assert coupled(circle(8.0), circle(5.0), side).slid is None
    assert coupled(circle(8.0), np.zeros_like, side).slid is None
    assert coupled(np.zeros_like, rounded(0.5, 1), side).slid is None


@SIDES
def test_bodies_slide_by_the_mean_of_what_is_pressed_together(side: str) -> None:
    coupling = coupled(rounded(-0.5, -1), rounded(0.5, 1), side)
    assert coupling.slid is not None
    nodes = coupling.surface.points[:, 0]
    force = np.where(np.abs(nodes) < 0.3, 1.0, 0.0)
    moved = np.where(force > 0, -SLIDING, 5.0)[:, None]
    found = coupling.slid.opened(moved, force) / coupling.surface.weights
    np.testing.assert_allclose(found, opened(coupling, SLIDING), rtol=0, atol=1e-12)


@SIDES
@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_solids_slide_along_both_directions(side: str, cell: str) -> None:
    """Roundings along z: what the plane has, and nothing by sliding along them."""
    x, z = np.linspace(-1.0, 1.0, 41), np.linspace(-0.3, 0.3, 5)

    def lifted(profile: Profile) -> sheets.Lift:
        return lambda points: np.column_stack([points, profile(points[:, 0])])

    upper, lower = rounded(-0.5, -1), rounded(0.5, 1)
    first = sheets.sheet("upper", x, z, cell, 2, lifted(upper), down=True)
    second = sheets.sheet("lower", x, z, cell, 2, lifted(lambda x: -lower(x)))
    coupling = couple("main", first, second, side, 2)
    assert coupling.slid is not None
    frames, weights = coupling.surface.frames, coupling.surface.weights
    points = coupling.surface.points
    inside = (np.abs(points[:, 0]) < 0.9) & (np.abs(points[:, 1]) < 0.2)
    found = []
    for sliding in ([SLIDING, 0, 0], [0, 0.1, 0]):
        moved = -np.einsum("nad,d->na", frames[:, 1:], sliding)
        found.append(coupling.slid.opened(moved, np.ones(len(weights))) / weights)
    at, half = points[:, 0], SLIDING / 2
    expected = upper(at - half) - upper(at) + lower(at + half) - lower(at)
    # Means over hats of .05 on an arc of 1.2 mm.
    np.testing.assert_allclose(found[0][inside], expected[inside], atol=3e-4)
    assert found[0][inside].max() > 5e-4
    np.testing.assert_allclose(found[1][inside], 0.0, atol=2e-5)
