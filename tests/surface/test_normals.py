# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact normal lies between those of both surfaces and turns as little as it can."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from cases import chains, sheets

from fretfe._typing import Array
from fretfe.surface.normals import contact_normals, mean_share
from fretfe.surface.surface import Surface

Profile = Callable[[Array], Array]
# Radians. A first guess, which turns by up to .5, counts a thousandth; a facet turns by .01.
SMALL = 5e-5


def circle(radius: float, middle: float = 0.0) -> Profile:
    return lambda x: radius - np.sqrt(radius**2 - (x - middle) ** 2)


def rounded(begin: float, radius: float, sign: int = 1) -> Profile:
    """Flat up to x = begin, from there on (or, sign -1, up to there) an arc."""
    return lambda x: circle(radius)(np.maximum(sign * (x - begin), 0.0))


FLAT: Profile = np.zeros_like


def profiles(upper: Profile, lower: Profile, curved: bool = True) -> tuple[Surface, Surface]:
    """Surfaces of body 1 above, with nodes of its own, and body 2 below."""
    # Flats end between facets, not within them.
    x, other = np.linspace(-1.0, 1.0, 161), np.linspace(-1.0, 1.0, 121)
    points = np.stack([x, upper(x)], axis=1), np.stack([other, lower(other)], axis=1)
    return (
        chains.surface("upper", points[0], curved),
        chains.surface("lower", points[1][::-1], curved),
    )


def angles(normals: Array) -> Array:
    """From the y axis, clockwise."""
    return np.arctan2(normals[..., 0], normals[..., 1])


@pytest.mark.parametrize("curved", [False, True], ids=["straight", "curved"])
@pytest.mark.parametrize(
    ("upper", "lower"),
    [
        (FLAT, FLAT),
        (circle(3.0), FLAT),
        (FLAT, lambda x: -circle(3.0)(x)),
        (lambda x: rounded(0.5, 1.2)(x) + rounded(-0.5, 1.2, -1)(x), FLAT),
        (FLAT, lambda x: -rounded(0.5, 1.2)(x) - rounded(-0.5, 1.2, -1)(x)),
        (rounded(0.5, 1.2), lambda x: -rounded(-0.5, 1.2, -1)(x)),
        (rounded(-0.5, 1.2, -1), lambda x: -rounded(0.5, 2.0)(x)),
        (rounded(0.4, 1.2), lambda x: -rounded(0.6, 1.2)(x)),
    ],
    ids=["flat", "pad", "table", "upper", "lower", "opposite", "opposite-other-way", "same-end"],
)
def test_beside_a_flat_the_normal_is_that_of_the_flat(
    upper: Profile, lower: Profile, curved: bool
) -> None:
    normals = contact_normals(*profiles(upper, lower, curved))
    np.testing.assert_allclose(angles(normals), 0.0, atol=SMALL)


@pytest.mark.parametrize(("first", "second"), [(8.0, 8.0), (2.0, 30.0), (30.0, 2.0)])
def test_cylinders_meet_along_the_direction_between_their_axes(first: float, second: float) -> None:
    pair = profiles(circle(first, 0.2), lambda x: -circle(second, 0.2)(x))
    # The place at which they touch is known to a facet, over which the smaller one turns so much.
    np.testing.assert_allclose(angles(contact_normals(*pair)), 0.0, atol=1 / 60 / 2)
    assert np.ptp(angles(contact_normals(*pair))) < SMALL


def test_conforming_surfaces_have_their_common_normal() -> None:
    """A pin in its hole of radius 2; at the ends of a chain the normal is that of one facet."""
    pair = profiles(circle(2.0), circle(2.0))
    normals = contact_normals(*pair)
    np.testing.assert_allclose(np.sin(angles(normals)), -pair[1].nodes[..., 0] / 2.0, atol=5e-4)


def test_a_pin_in_a_wider_hole_has_the_normals_of_the_hole() -> None:
    """Those turn less than the normals of the pin, which is at the same side of its own."""
    pair = profiles(circle(2.0), circle(3.0))
    normals = contact_normals(*pair)
    np.testing.assert_allclose(np.sin(angles(normals)), -pair[1].nodes[..., 0] / 3.0, atol=5e-4)


def test_noise_of_coordinates_does_not_turn_the_normal() -> None:
    """A flat whose nodes are rounded to 1e-6, as in decks, turns by 1e-4 from facet to facet."""
    noise = np.random.default_rng(1).uniform(-1e-6, 1e-6, 121)
    pair = profiles(rounded(0.5, 1.2), lambda x: noise)
    own, found = (
        np.diff(angles(each), axis=1) for each in (pair[1].normals, contact_normals(*pair))
    )
    assert np.abs(own).max() > 5e-5
    assert np.linalg.norm(found) < np.linalg.norm(own) / 10


def test_bodies_may_change_places() -> None:
    """Turned by half a turn: the lower body is the upper one."""
    upper, lower = rounded(0.5, 1.2), lambda x: -0.2 * rounded(-0.3, 0.8, -1)(x) - 0.1 * x**2
    first, second = profiles(upper, lower)
    x, other = np.linspace(-1.0, 1.0, 161), np.linspace(-1.0, 1.0, 121)
    turned = (
        chains.surface("lower", np.stack([-other, -lower(other)], axis=1)[::-1], True),
        chains.surface("upper", np.stack([-x, -upper(x)], axis=1), True),
    )
    found, other_way = contact_normals(first, second), contact_normals(*turned)
    here = np.linspace(-0.7, 0.7, 15)

    def along(nodes: Array, normals: Array) -> Array:
        order = np.argsort(nodes.ravel(), kind="stable")
        return np.interp(here, nodes.ravel()[order], angles(normals).ravel()[order])

    at = along(second.nodes[..., 0], found), along(-turned[1].nodes[..., 0], other_way)
    # Each way the normals of the other body are looked up at nodes: a facet turns by .01.
    np.testing.assert_allclose(at[1], at[0], atol=2e-3)


@pytest.mark.parametrize("cell", ["triangle", "quadrilateral"])
def test_roundings_on_both_solids_leave_the_normal_of_the_flat(cell: str) -> None:
    x, z = np.linspace(-1.0, 1.0, 41), np.linspace(-0.3, 0.3, 7)

    def lifted(profile: Profile) -> sheets.Lift:
        return lambda points: np.column_stack([points, profile(points[:, 0])])

    upper = sheets.sheet("upper", x, z, cell, 2, lifted(rounded(0.5, 1.2)), down=True)
    lower = sheets.sheet(
        "lower", 0.97 * x, z, cell, 2, lifted(lambda x: -rounded(-0.5, 1.2, -1)(x))
    )
    normals = contact_normals(upper, lower)
    np.testing.assert_allclose(normals, np.broadcast_to([0, 0, 1.0], normals.shape), atol=SMALL)


def test_share_of_the_way_between_normals() -> None:
    first, last = np.array([[0.0, 1.0], [0.0, 1.0]]), np.array([[0.0, 1.0], [0.6, 0.8]])
    assert mean_share(0.75 * first + 0.25 * last, first, last) == pytest.approx(0.25)
    assert mean_share(first, first, first) == 1.0
