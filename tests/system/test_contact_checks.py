# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact surfaces that overlap or look away are refused; those that can close are not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.blocks import Map, block
from cases.tiny_meshes import TWO_SQUARES

from fretfe._typing import Array
from fretfe.case import Case, load_case, parse_case
from fretfe.errors import MeshError
from fretfe.mesh.body_overlap import body_overlaps
from fretfe.mesh.mesh import BodyMesh, Mesh
from fretfe.surface.checks import check_contacts, load_mesh

STEEL = {"young": 2e5, "poisson": 0.3}
SQUARES_CASE = """
[geometry]
file = "m.msh"
[bodies]
upper = { young = 2e5, poisson = 0.3 }
lower = { young = 2e5, poisson = 0.3 }
[contacts]
main = { surface1 = "upper_face", surface2 = "lower_face", friction = 0.3 }
"""


def case(**contacts: tuple[str, str]) -> Case:
    tables = {
        name: {"surface1": first, "surface2": second, "friction": 0.3}
        for name, (first, second) in contacts.items()
    }
    bodies = {"upper": STEEL, "lower": STEEL, "third": STEEL}
    return parse_case({"geometry": {"file": "m.msh"}, "bodies": bodies, "contacts": tables})


MAIN = case(main=("upper_bottom", "lower_top"))


def mesh(*bodies: BodyMesh) -> Mesh:
    return Mesh({body.name: body for body in bodies})


def shifted(x: float, y: float) -> Map:
    return lambda points: points + np.array([x, y])


def blocks(x: float = 0.0, y: float = 0.0, **options: Any) -> Mesh:
    """The upper block, moved by (x, y), above the wider lower one; elements of a quarter."""
    return mesh(
        block("upper", np.linspace(0, 1, 5), np.linspace(0, 1, 5), mapping=shifted(x, y)),
        block("lower", np.linspace(-0.5, 1.5, 9), np.linspace(-1, 0, 5), **options),
    )


def ring(points: Array) -> Array:
    """Radius and degrees to a sector about the origin that opens upwards."""
    radius, angle = points[:, 0], np.radians(points[:, 1] - 90)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def pin_in_hole(order: int, clearance: float) -> Mesh:
    """A pin of radius 1 in the lower half of a hole; facets turn by 8.9 and 10 degrees."""
    pin, hole = np.linspace(-40, 40, 10), np.linspace(-60, 60, 13)
    return mesh(
        block("upper", [0.5, 1.0], pin, order=order, mapping=ring),
        block("lower", [1 + clearance, 1.5], hole, order=order, mapping=ring),
    )


# The outer face of the pin, the inner one of the hole.
PIN = case(main=("upper_right", "lower_left"))
# Sagitta of a facet that turns by 10 degrees on the radius 1.
SAGITTA = 1 - np.cos(np.radians(5))


@pytest.mark.parametrize(
    "valid",
    [
        pytest.param(blocks(), id="touching"),
        pytest.param(blocks(y=0.3), id="apart"),
        pytest.param(blocks(x=0.7), id="half over the end"),
        # 1 % of an element of 0.25
        pytest.param(blocks(y=-0.0024), id="overlap that the mesh does not resolve"),
        pytest.param(blocks(mapping=lambda p: p + 1e-13 * np.sin(50 * p)), id="round-off"),
    ],
)
@pytest.mark.parametrize("names", [("upper_bottom", "lower_top"), ("lower_top", "upper_bottom")])
def test_surfaces_that_can_close(valid: Mesh, names: tuple[str, str]) -> None:
    check_contacts(valid, case(main=names))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("clearance", [0.0, 0.01, 0.1])
def test_arcs_that_fit_into_each_other(order: int, clearance: float) -> None:
    check_contacts(pin_in_hole(order, clearance), PIN)


@pytest.mark.parametrize("order", [1, 2])
def test_arcs_that_overlap_by_more_than_their_facets(order: int) -> None:
    # Two sagittas of what facets may do, and some more.
    with pytest.raises(MeshError, match=r"contacts\.main.*overlap before any load acts"):
        check_contacts(pin_in_hole(order, -4 * SAGITTA), PIN)


@pytest.mark.parametrize("names", [("upper_bottom", "lower_top"), ("lower_top", "upper_bottom")])
def test_overlap_is_told_with_amount_and_place(names: tuple[str, str]) -> None:
    with pytest.raises(MeshError) as caught:
        check_contacts(blocks(y=-0.0125), case(main=names))
    message = str(caught.value)
    for part in ("contacts.main", *names, "'upper'", "'lower'", "0.0125 mm", "length of 1 mm"):
        assert part in message
    assert "press fit" in message
    # One problem, told once.
    assert message.count("\n  - ") == 1


def test_place_of_an_overlap() -> None:
    def dented(points: Array) -> Array:
        """The node in the middle of the lower face pulled down by 0.05."""
        dent = np.where(np.linalg.norm(points - [0.5, 0.0], axis=1) < 1e-9, 0.05, 0.0)
        return points - np.stack([np.zeros(len(points)), dent], axis=1)

    upper = block("upper", np.linspace(0, 1, 5), np.linspace(0, 1, 5), mapping=dented)
    with pytest.raises(MeshError, match=r"by up to 0\.0[45]\d* mm at \(0\.[45]\d*, 0\)"):
        check_contacts(mesh(upper, blocks().bodies["lower"]), MAIN)


@pytest.mark.parametrize(
    ("bodies", "names", "message"),
    [
        pytest.param(
            blocks(),
            ("upper_top", "lower_top"),
            r"face the wrong way: where they are nearest, 1 mm apart.*\(0, 1\) and \(0, 1\)",
            id="back",
        ),
        pytest.param(blocks(), ("upper_left", "lower_top"), "face the wrong way", id="side"),
        pytest.param(
            blocks(y=5.0),
            ("upper_bottom", "lower_top"),
            r"too far apart: nearest 5 mm apart .* expected less than 0\.5 mm",
            id="far",
        ),
        pytest.param(
            blocks(x=1.7), ("upper_bottom", "lower_top"), "pass by each other", id="beside"
        ),
    ],
)
@pytest.mark.parametrize("swapped", [False, True], ids=["", "swapped"])
def test_surfaces_that_never_close(
    bodies: Mesh, names: tuple[str, str], message: str, swapped: bool
) -> None:
    chosen = names[::-1] if swapped else names
    with pytest.raises(MeshError, match=message) as caught:
        check_contacts(bodies, case(main=chosen))
    assert f"contacts.main: '{chosen[0]}'" in str(caught.value)


THIRD = (np.linspace(0.1, 0.3, 3), np.linspace(-0.6, -0.4, 3))


@pytest.mark.parametrize(
    ("third", "words"),
    [
        pytest.param(block("third", *THIRD), ["'third' and 'lower'", "0.5 mm inside"], id="inside"),
        pytest.param(
            block("third", np.linspace(-0.5, 1.5, 9), np.linspace(-1, 0, 5)),
            ["'third' and 'lower'"],
            id="same place",
        ),
    ],
)
def test_bodies_in_the_same_place(third: BodyMesh, words: list[str]) -> None:
    bodies = mesh(*blocks().bodies.values(), third)
    with pytest.raises(MeshError) as caught:
        check_contacts(bodies, MAIN)
    assert all(word in str(caught.value).replace("'lower' and 'third'", words[0]) for word in words)


def test_bodies_that_overlap_by_most_of_their_size() -> None:
    # Surfaces deep inside the other body never face each other; the overlap is what is wrong.
    with pytest.raises(MeshError, match=r"bodies '\w+' and '\w+' overlap") as caught:
        check_contacts(blocks(y=-0.7), MAIN)
    assert "face" not in str(caught.value)


def test_everything_is_listed() -> None:
    both = case(main=("upper_bottom", "lower_top"), other=("third_top", "lower_left"))
    bodies = mesh(*blocks(y=-0.1).bodies.values(), block("third", [-5.0, -4.0], [-1.0, 0.0]))
    with pytest.raises(MeshError) as caught:
        check_contacts(bodies, both)
    assert "contacts.main" in str(caught.value) and "contacts.other" in str(caught.value)


def test_depth_of_an_overlap() -> None:
    """A square turned by 45 degrees: its corner is inside the lower block by what it is moved."""
    c = np.sqrt(0.5)
    turned = block(
        "upper",
        np.linspace(0, 1, 9),
        np.linspace(0, 1, 9),
        mapping=lambda p: p @ np.array([[c, c], [-c, c]]) + np.array([0.5, -0.3]),
    )
    (overlap,) = body_overlaps(mesh(turned, blocks().bodies["lower"]))
    assert overlap.body1 == "upper"
    assert overlap.depth == pytest.approx(0.3, abs=1e-12)  # round-off
    assert np.allclose(overlap.point, [0.5, -0.3])


def test_loading_a_mesh_checks_its_contacts(tmp_path: Path) -> None:
    tiny = TWO_SQUARES
    for node in (5, 6, 7, 8):
        x, y, _ = tiny.nodes[node - 1]
        tiny = tiny.move(node, x, y - 0.1)
    tiny.write(tmp_path / "m.msh")
    (tmp_path / "case.toml").write_text(SQUARES_CASE)
    with pytest.raises(MeshError, match=r"overlap before any load acts: by up to 0\.1 mm"):
        load_mesh(load_case(tmp_path / "case.toml"))
