# SPDX-License-Identifier: LGPL-3.0-or-later
"""Element sizes that follow fine places: how large, how many, on both sides of a mirror."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType

import gmsh
import numpy as np
import pytest
from numpy.typing import NDArray

from fretfe.mesh.elements import facet_measures
from fretfe.mesh.make import mesh_template
from fretfe.mesh.mesh import Mesh, count_unknowns, mesh_summary
from fretfe.mesh.sizing import (
    Sizes,
    Source,
    apply_sizes,
    corners_of,
    length_of,
    round_curves,
    tags_of_groups,
)
from fretfe.mesh.templates import find_template

EVEN, GROWTH = 0.1, 0.25


def graded(name: str, *sources: Source, **parameters: float) -> Mesh:
    contacts = {f"{body}_contact": EVEN for body in ("upper", "lower")}
    if name == "dovetail":
        contacts = dict.fromkeys(("blade_flank_right", "disc_flank_right"), EVEN)
    sizes = Sizes(contacts, GROWTH, sources)
    return mesh_template(
        find_template(name), parameters, 2, lambda model: apply_sizes(model, sizes)
    )


def sizes_along(mesh: Mesh, body: str, boundary: str) -> tuple[NDArray, NDArray]:
    """Middles (f, 2) and lengths (f,) of the facets of a boundary."""
    own = mesh.bodies[body]
    facets = own.boundaries[boundary]
    return own.points[facets[:, 2]], facet_measures(own.points, facets)


@pytest.mark.parametrize("side", [-1, 1])
def test_elements_grow_with_the_distance_from_a_source(side: int) -> None:
    place = np.array([[0.3 * side, 0.0]])
    mesh = graded("flat_rounded", Source(place, 0.001))
    for body in ("upper", "lower"):
        middles, lengths = sizes_along(mesh, body, f"{body}_contact")
        # The left half is a copy of the right one: both are fine at x = ±0.3.
        distance = np.abs(np.abs(middles[:, 0]) - 0.3)
        wanted = np.minimum(0.001 + GROWTH * distance, EVEN)
        assert 0.5 < (lengths / wanted).min() <= (lengths / wanted).max() < 1.3
        assert lengths.min() == pytest.approx(0.001, rel=0.2)


def test_the_mesh_is_well_shaped() -> None:
    mesh = graded("dovetail", Source(np.array([[10.0, 1.8]]), 1e-4))
    assert min(body.smallest_angle for body in mesh_summary(mesh)) > 25


def test_the_number_of_unknowns_grows_like_the_logarithm_of_the_size() -> None:
    place = np.array([[0.3, 0.0]])
    counts = [
        count_unknowns(graded("flat_rounded", Source(place, size)), 2)
        for size in (4e-3, 4e-4, 4e-5, 4e-6)
    ]
    steps = np.diff(counts)
    # each decade adds as many elements as the one before; whole elements round that
    np.testing.assert_allclose(steps, steps.mean(), rtol=0.1)
    assert counts[-1] < 3 * counts[0]


def test_corners_of_the_contact_surface_are_finer_than_their_distance_from_a_source() -> None:
    edge = np.array([[1.05, 0.0]])
    mesh = graded("flat_rounded", Source(edge, 1e-4))
    middles, lengths = sizes_along(mesh, "lower", "lower_contact")
    corner = np.abs(middles[:, 0] - 1.0).argmin()
    # an eighth of the distance 0.05; without the corner it would be 0.25 * 0.05
    assert lengths[corner] == pytest.approx(0.05 / 8, rel=0.3)


@pytest.fixture
def model() -> Iterator[ModuleType]:
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


@pytest.mark.parametrize(
    ("name", "boundary", "corners"),
    [
        ("cylinder", "upper_contact", []),  # two arcs that meet smoothly
        ("flat_rounded", "upper_contact", [(-1.0, 0.0), (1.0, 0.0)]),  # flat to arc
        ("wedge", "upper_contact", [(0.0, 0.0)]),  # the apex
        ("flat_rounded", "lower_contact", []),
    ],
)
def test_corners(
    model: ModuleType, name: str, boundary: str, corners: list[tuple[float, float]]
) -> None:
    model.merge(str(find_template(name).path))
    found = corners_of(model, tags_of_groups(model, 1)[boundary])
    np.testing.assert_allclose(sorted(map(tuple, found)), corners, atol=1e-9)


def test_s_shaped_arcs_have_a_corner(model: ModuleType) -> None:
    for x, y in ((0, 0), (1, 1), (2, 2), (0, 1), (2, 1)):
        model.model.geo.addPoint(x, y, 0)
    curves = [model.model.geo.addCircleArc(1, 4, 2), model.model.geo.addCircleArc(2, 5, 3)]
    model.model.geo.synchronize()
    # the tangent does not turn at (1, 1), and the radius is the same on both sides
    np.testing.assert_allclose(corners_of(model, curves), [[1, 1]], atol=1e-9)
    assert length_of(model, curves) == pytest.approx(np.pi, rel=1e-5)  # chords


def test_curvature_gives_sixteen_elements_around_a_circle(model: ModuleType) -> None:
    model.model.occ.addDisk(0, 0, 0, 3, 3)
    model.model.occ.addRectangle(5, 5, 0, 1, 1)
    model.model.occ.synchronize()
    ((size, curves),) = round_curves(model)
    assert len(curves) == 1
    assert size == pytest.approx(2 * np.pi * 3 / 16, rel=1e-2)
