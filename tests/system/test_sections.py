# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies of STEP files that sweep a section: found in any place, or the face that prevents it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cases.swept_punch import ARC, Placed

from fretfe.errors import CaseError
from fretfe.mesh.elements import facet_measures
from fretfe.mesh.load import grouped_mesh, sweep_of
from fretfe.mesh.mesh import Mesh

# Flat of 2 and two arcs of pi/6.
AREA = 8 * (2 + 2 * np.pi / 6)
PLACES = {
    "any way": Placed((1.0, 2.0, 3.0), 0.7, (130.0, -70.0, 1017.0)),
    "mirrored": Placed((2.0, -1.0, 0.5), 1.9, mirrored=True),
    "leaning any way": Placed((1.0, 2.0, 3.0), 0.7, (13.0, -7.0, 101.0), lean=-0.3),
}


def area(mesh: Mesh, body: str, boundary: str) -> float:
    found = mesh.bodies[body]
    return float(facet_measures(found.points, found.boundaries[boundary]).sum())


@pytest.mark.parametrize("placed", PLACES.values(), ids=PLACES.keys())
def test_sections_are_swept_between_the_ends_of_the_bodies(placed: Placed, tmp_path: Path) -> None:
    case = placed.case(tmp_path)
    sweep = sweep_of(case)
    assert sweep is not None
    along = placed.matrix @ [placed.lean, 0.0, 1.0]
    # STEP files have seven digits behind the point or more
    np.testing.assert_allclose(np.cross(sweep.direction, along), 0.0, atol=1e-9)
    assert sweep.solid.span("lower") == pytest.approx((0.0, 10.0), abs=1e-6)
    # the normal may run either way
    assert np.ptp(sweep.solid.span("upper")) == pytest.approx(8.0, abs=1e-6)
    mesh = grouped_mesh(case)
    length = np.linalg.norm(along)
    # arcs of quadratic elements are short by less than 1e-5
    assert area(mesh, "lower", "lower_bottom") == pytest.approx(80 * 1.0, rel=1e-6)
    assert area(mesh, "upper", "upper_top") == pytest.approx(8 * (2 + 2 * ARC[0]), rel=1e-6)
    assert area(mesh, "upper", "upper_contact") < AREA * length
    for name, volume in (("lower", 160.0), ("upper", None)):
        shares = mesh.bodies[name].volumes()[1]
        assert shares.min() > 0
        assert volume is None or shares.sum() == pytest.approx(volume, rel=1e-6)
    shroud = mesh.bodies["upper"].points[np.unique(mesh.bodies["upper"].boundaries["upper_shroud"])]
    end = placed.of([0.0, 0.0, 9.0])
    across = placed.matrix @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose((shroud - end) @ across, 0.0, atol=1e-6)
    local = sweep.in_plane(mesh.bodies["lower"].points)
    np.testing.assert_allclose(local[:, 2], 0.0, atol=1e-9)


def test_the_accuracy_without_a_size_is_that_of_cad(tmp_path: Path) -> None:
    assert Placed().case(tmp_path).edges.tolerance == 0.1
    assert Placed(changes={"size": 0.3}).case(tmp_path).edges.tolerance is None


def test_a_body_that_is_no_sweep_names_its_face(tmp_path: Path) -> None:
    case = Placed(chamfer=(2.0, 1.5, 1.0)).case(tmp_path)
    assert sweep_of(case) is None
    with pytest.raises(CaseError) as error:
        grouped_mesh(case)
    assert "geometry.size" in str(error.value)
    assert "of body 'upper' is no plane end, and not parallel" in str(error.value)


@pytest.mark.parametrize("edge, end", [(2.0, 9.0), (0.0, 8.4)], ids=["free", "in contact"])
@pytest.mark.parametrize("placed", [Placed(), PLACES["any way"]], ids=["plain", "any way"])
def test_ends_that_are_cut_off_leave_the_length_of_the_contact(
    edge: float, end: float, placed: Placed, tmp_path: Path
) -> None:
    """Their edges are as if nothing were cut off where the contact does not reach, as is said."""
    case = replace(placed, chamfer=(edge, abs(edge - 0.5), 0.6)).case(tmp_path)
    sweep = sweep_of(case)
    assert sweep is not None
    assert np.ptp(sweep.solid.span("upper")) == pytest.approx(end - 1.0, abs=1e-6)
    assert np.ptp(sweep.solid.span("lower")) == pytest.approx(10.0, abs=1e-6)
    mesh = grouped_mesh(case)
    assert area(mesh, "upper", "upper_top") == pytest.approx((end - 1) * (2 + 2 * ARC[0]), rel=1e-6)
    assert "; ends of upper are taken as plane ones" in mesh.notes[-1]


def test_a_size_asks_for_tetrahedra_of_that_size(tmp_path: Path) -> None:
    assert sweep_of(Placed(changes={"size": 0.3}).case(tmp_path)) is None
