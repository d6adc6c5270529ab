# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers about the mesh of a contact, the warnings they give, and bodies that are free to move."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases.blocks import Map, block
from cases.chains import surface

from fretfe._typing import Array
from fretfe.bodies.definition import define_model
from fretfe.bodies.rigid_modes import modes_restrained_by_contact
from fretfe.case import parse_case
from fretfe.mesh.mesh import BodyMesh, Mesh, mesh_summary
from fretfe.surface.checks import ContactQuality, contact_quality, initial_gaps, mesh_warnings
from fretfe.surface.surface import Chain

STEEL = {"young": 2e5, "poisson": 0.3}
CASE: dict[str, Any] = {
    "geometry": {"file": "m.msh"},
    "bodies": {"upper": STEEL, "lower": STEEL},
    "contacts": {
        "main": {"surface1": "upper_bottom", "surface2": "lower_top", "friction": 0.3}
    },
}  # fmt: skip


def on_arc(radius: float, gap: float = 0.0) -> Map:
    """Turn the lower side of a block into an arc about (0.5, gap + radius) through (0.5, gap)."""

    def moved(points: Array) -> Array:
        height = radius - np.sqrt(radius**2 - (points[:, 0] - 0.5) ** 2)
        return points + np.stack([np.zeros(len(points)), gap + height], axis=1)

    return moved


def bodies(upper: dict[str, Any], lower: int = 20, columns: int = 10) -> Mesh:
    """An upper block of `columns` on a lower one of `lower` columns and twice the width."""
    first = block("upper", np.linspace(0, 1, columns + 1), [0.0, 0.5, 1.0], **upper)
    second = block("lower", np.linspace(-0.5, 1.5, lower + 1), [-1.0, -0.5, 0.0])
    if first.order == 2:
        second = block("lower", np.linspace(-0.5, 1.5, lower + 1), [-1.0, -0.5, 0.0], order=2)
    return Mesh({"upper": first, "lower": second})


def quality(mesh: Mesh) -> ContactQuality:
    (found,) = contact_quality(initial_gaps(mesh, parse_case(CASE)))
    return found


def warnings(mesh: Mesh) -> tuple[str, ...]:
    return mesh_warnings(mesh_summary(mesh), [quality(mesh)], "mm")


@pytest.mark.parametrize("order", [1, 2])
def test_numbers_of_a_pad_above_a_wider_block(order: int) -> None:
    found = quality(bodies({"order": order, "mapping": on_arc(2.0, gap=0.03)}))
    pad, flat = found.surfaces
    # At the integration point next to the lowest node: h/21 away, on a facet of slope h/2R.
    assert found.gap == pytest.approx(0.03, abs=1.25e-4) and found.interpenetration == 0
    assert found.nearest == pytest.approx([0.5, 0.0], abs=0.05)  # half an element
    assert found.measure == pytest.approx(1.0, abs=1e-12)
    assert (pad.facets, pad.opposite, flat.facets, flat.opposite) == (10, 10, 20, 10)
    # An arc of half-angle asin(1/4); polygons of 10 sides are shorter by 0.01 %.
    assert pad.measure == pytest.approx(4 * np.arcsin(0.25), rel=2e-4)
    assert flat.measure == pytest.approx(2.0, rel=1e-12)
    # The chord of a facet at the end has the slope of the arc at x = 0.45: 1.3 %.
    assert (flat.smallest, flat.largest) == pytest.approx((0.1, 0.1))
    assert pad.smallest == pytest.approx(0.1, rel=1e-3)
    assert pad.largest == pytest.approx(0.1 / np.sqrt(1 - (0.45 / 2) ** 2), rel=1e-3)
    # Curvature from facets of 3 degrees.
    assert pad.radius == pytest.approx(2.0, rel=0.02)
    assert pad.per_radius == pytest.approx(2.0 / pad.largest, rel=0.02)
    assert flat.per_radius == np.inf and flat.deviation == 0
    # Facets on the arc are longer than those on the flat below them, by 1 % in the median.
    assert found.size_ratio == pytest.approx(1.0, abs=0.02)


def test_overlap_and_its_place() -> None:
    found = quality(bodies({"mapping": on_arc(2.0, gap=-1e-3)}))
    assert found.gap == 0
    assert found.interpenetration == pytest.approx(1e-3, abs=1.25e-4)  # as above
    assert found.nearest == pytest.approx([0.5, 0.0], abs=0.05)


def test_flats_that_touch_have_neither_gap_nor_overlap() -> None:
    found = quality(bodies({"mapping": lambda p: p + 1e-14 * np.sin(99 * p)}))
    assert (found.gap, found.interpenetration) == (0.0, 0.0)
    assert found.nearest == pytest.approx([0.5, 0.0], abs=0.05)


def arc_points(count: int, turn: float, radius: float) -> Array:
    """Points below the centre, from left to right: the body, on the left of them, is above."""
    angles = np.linspace(-turn / 2, turn / 2, count) - np.pi / 2
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


@pytest.mark.parametrize("curved", [False, True], ids=["straight", "curved"])
@pytest.mark.parametrize("degrees", [5.0, 15.0, 30.0])
def test_deviation_from_an_arc(curved: bool, degrees: float) -> None:
    """Against the distance of the facet's own points from the circle."""
    turn, radius, facets = np.radians(degrees), 3.0, 4
    points = arc_points((2 if curved else 1) * facets + 1, facets * turn, radius)
    chain = Chain(surface("face", points, curved))
    t = np.linspace(0, 1, 1001)[:, None]
    first, last, *middle = points[: (3 if curved else 2)][[0, -1, 1][: 3 if curved else 2]]
    places = first * (1 - t) + last * t
    if curved:
        places += 4 * t * (1 - t) * (middle[0] - (first + last) / 2)
    expected = np.abs(np.linalg.norm(places, axis=1) - radius).max()
    # First terms of series in the angle, and curvatures with an error of θ²/12, to the third power.
    assert chain.deviations == pytest.approx(np.full(facets, expected), rel=0.07)
    assert chain.curvatures == pytest.approx(np.full(facets, 1 / radius), rel=0.05)


GOOD = {"mapping": on_arc(2.0)}
SLANTED: dict[str, Any] = {"mapping": lambda p: p + np.outer(p[:, 1], [4.0, 0.0])}


def test_good_mesh_gives_no_warning() -> None:
    assert warnings(bodies({"order": 2, **GOOD}, columns=12)) == ()


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        pytest.param(
            bodies(SLANTED), ["upper: smallest angle 14.0°; expected at least 15°"], id="angle"
        ),
        pytest.param(
            bodies({"mapping": on_arc(2.0, gap=0.011)}),
            ["main: the surfaces stand apart everywhere, by 0.011", "1.1 % of the 1 mm"],
            id="gap",
        ),
        pytest.param(bodies(GOOD, lower=6), ["3.3 times as long"], id="sizes"),
        pytest.param(
            bodies({"order": 2, "mapping": on_arc(0.9)}),
            ["upper_bottom has an element of 0.1", "radius of curvature is 0.8", "per radius"],
            id="radius",
        ),
        pytest.param(
            bodies({"mapping": on_arc(2.0)}, columns=2, lower=4),
            ["straight elements of upper_bottom", "use elements of order 2"],
            id="straight",
        ),
    ],
)
def test_each_warning(mesh: Mesh, words: list[str]) -> None:
    found = [text for text in warnings(mesh) if all(word in text for word in words)]
    assert len(found) == 1, warnings(mesh)


def ramp(value: float) -> list[dict[str, Any]]:
    return [{"ramp": value, "until": 1.0, "steps": 1}]


def platen(direction: Any, control: str = "force") -> dict[str, Any]:
    return {
        "type": "platen",
        "boundary": "upper_top",
        "direction": direction,
        "control": control,
        "history": ramp(-1.0),
    }


def fix(**supports: tuple[str, list[str]]) -> dict[str, Any]:
    return {name: {"boundary": f"upper_{b}", "fix": axes} for name, (b, axes) in supports.items()}


EVERYWHERE = "to move in every direction and to turn"


@pytest.mark.parametrize(
    ("loads", "supports", "motion"),
    [
        pytest.param({}, {}, EVERYWHERE, id="nothing"),
        pytest.param({}, fix(a=("top", ["x", "y"])), None, id="held"),
        pytest.param({}, fix(a=("top", ["y"])), "to move along x", id="roller"),
        pytest.param({}, fix(a=("top", ["x"])), "to move along y and to turn", id="slot"),
        pytest.param(
            {}, fix(a=("top", ["x"]), b=("left", ["y"])), "to turn about (0, 1)", id="hinge"
        ),
        pytest.param({"p": platen("y")}, {}, "to move along y", id="force"),
        pytest.param({"p": platen([1, 1])}, {}, "to move along (1, 1)", id="inclined force"),
        pytest.param(
            {"p": platen("y"), "q": platen("x")}, {}, "to move in every direction", id="two forces"
        ),
        pytest.param({"p": platen("y", "displacement")}, {}, None, id="displacement"),
        pytest.param(
            {"p": platen("y")}, fix(a=("left", ["x"])), "to move along y", id="force and support"
        ),
        pytest.param({"p": platen("y")}, fix(a=("left", ["y"])), None, id="support against it"),
    ],
)
def test_rigid_modes_restrained_only_by_contact(
    loads: dict[str, Any], supports: dict[str, Any], motion: str | None
) -> None:
    case = parse_case({**CASE, "loads": loads, "supports": supports})
    mesh = Mesh({name: small(name) for name in ("upper", "lower")})
    expected = {"lower": EVERYWHERE} if motion is None else {"upper": motion, "lower": EVERYWHERE}
    assert modes_restrained_by_contact(define_model(case, mesh), mesh) == expected


def small(name: str) -> BodyMesh:
    start = 0.0 if name == "upper" else -1.0
    return block(name, [0.0, 0.5, 1.0], [start, start + 0.5, start + 1.0])
