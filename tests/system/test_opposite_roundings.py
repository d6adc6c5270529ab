# SPDX-License-Identifier: LGPL-3.0-or-later
"""Roots with one rounding of a flank on the blade and the other one on the disc, after sliding."""

from __future__ import annotations

import math
import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Any

import gmsh
import pytest

import fretfe
from fretfe.case import parse_case
from fretfe.reason import Kind
from fretfe.results.model import Result

DEMO = Path(__file__).parents[2] / "demos" / "dovetail.toml"
YOUNG, POISSON, RADIUS, FLAT = 115e3, 0.32, 4.0, 4.0


@pytest.fixture(scope="module")
def root() -> Result:
    data: dict[str, Any] = tomllib.loads(DEMO.read_text("utf-8"))
    data["geometry"]["parameters"] |= {"upper_on_disc": 1, "edge_size": 0.003}
    data["output"] = {"fields": "none"}
    wave = data["loads"]["pull"]["history"][-1]
    wave.update(cycles=1, steps_per_cycle=12)
    return fretfe.run(parse_case(data))


def slid(result: Result) -> float:
    """Largest sliding of the flanks, in mm."""
    found = [each.found for each in result.limits if each.kind is Kind.SHIFTED]
    return max(found) * RADIUS


def test_edges_follow_the_flat_that_sliding_shortens(root: Result) -> None:
    """Half-planes next to a flat: K_N = 2 E* √d/(πR) at the reach d past its end.

    Each end of the flat has come half of the sliding nearer. Without that, or with normals that
    turn on the roundings, K_N of one edge is 10 % or more away.
    """
    sliding = slid(root)
    assert 0.03 < sliding < 0.05
    modulus = YOUNG / (1 - POISSON**2) / 2
    for contact in root.contacts:
        for station in contact.stations:
            reach = abs(station.position[-1]) - FLAT / 2 + sliding / 2
            expected = 2 * modulus * math.sqrt(reach) / (math.pi * RADIUS)
            # To first order in the reach over the flat, and for half-planes.
            spread = station.k_n_spread[-1]
            assert abs(station.k_n[-1] - expected) < 0.025 * expected + spread


def test_mirror_edges_are_equal(root: Result) -> None:
    left, right = (each.stations for each in root.contacts)
    for one, other in zip(left, reversed(right), strict=True):
        # Round-off of slid profiles moves an edge by 1e-7, which fits with bars of .7 % enlarge.
        assert other.k_n[-1] == pytest.approx(one.k_n[-1], rel=3e-5)
        assert other.k_range == pytest.approx(one.k_range, rel=1e-6)


def test_such_a_root_is_within_the_model(root: Result) -> None:
    assert not {each.kind for each in root.warnings} & {Kind.TURNING_NORMAL, Kind.SHIFTED}
    turning = [each for each in root.limits if each.kind is Kind.TURNING_NORMAL]
    assert [each.found for each in turning] == [0.0, 0.0]
    assert root.solution.imbalance("force").max() < 1e-9


def write_blocks(path: Path, offset: float) -> None:
    """Two blocks, the upper one, moved by an offset, rounded at its left, the lower at its right.

    Their flats are 2 mm long where they face each other.
    """
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Verbosity", 1)
        geo, fine = gmsh.model.geo, []
        for name, sign, start in (("upper", 1, offset), ("lower", -1, 0.0)):
            turn = math.radians(12)

            def point(x: float, y: float, sign: int = sign, start: float = start) -> int:
                return int(geo.addPoint(sign * x + start, sign * y, 0))

            corner, centre = point(-1, 0), point(-1, RADIUS)
            end = -1 - RADIUS * math.sin(turn)
            tip = point(end, RADIUS - RADIUS * math.cos(turn))
            others = [point(1.6, 0), point(4, 0), point(4, 4), point(end, 4)]
            chain = [corner, *others, tip]
            lines = [geo.addCircleArc(tip, centre, corner)]
            lines += [geo.addLine(a, b) for a, b in pairwise(chain)]
            surface = geo.addPlaneSurface([geo.addCurveLoop(lines)])
            geo.synchronize()
            gmsh.model.addPhysicalGroup(2, [surface], name=name)
            gmsh.model.addPhysicalGroup(1, lines[:2], name=f"{name}_contact")
            gmsh.model.addPhysicalGroup(1, [lines[4]], name=f"{name}_back")
            fine.append(corner)
        field = gmsh.model.mesh.field
        near = field.add("Distance")
        field.setNumbers(near, "PointsList", fine)
        size = field.add("MathEval")
        field.setString(size, "F", f"Min(0.008 + 0.25*Max(F{near} - 0.15, 0), 0.5)")
        field.setAsBackgroundMesh(size)
        for key in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
            gmsh.option.setNumber(f"Mesh.MeshSize{key}", 0)
        gmsh.option.setNumber("Mesh.ElementOrder", 2)
        gmsh.model.mesh.generate(2)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()


def pressed(path: Path, offset: float, sliding: float) -> Result:
    """Blocks without friction, moved before they are meshed and by a load."""
    write_blocks(path, offset)
    platen = {"type": "platen", "boundary": "upper_back"}
    press = [{"ramp": -1500.0, "until": 1, "steps": 1}]
    slide = [{"hold": True, "until": 1}, {"ramp": sliding, "until": 2, "steps": 1}]
    body = {"young": YOUNG, "poisson": POISSON}
    case = {
        "geometry": {"file": str(path)},
        "bodies": {"upper": body, "lower": body},
        "contacts": {
            "main": {"surface1": "upper_contact", "surface2": "lower_contact", "friction": 0.0}
        },
        "supports": {"base": {"boundary": "lower_back", "fix": ["x", "y"]}},
        "loads": {
            "press": {**platen, "direction": "y", "control": "force", "history": press},
            "slide": {**platen, "direction": "x", "control": "displacement", "history": slide},
        },
        "output": {"fields": "none"},
    }
    return fretfe.run(parse_case(case))


@pytest.mark.parametrize("sliding", [0.02, 0.1])
def test_a_contact_that_slides_is_that_of_bodies_meshed_where_they_come_to(
    tmp_path: Path, sliding: float
) -> None:
    """Half-widths; the flat, 2 mm long, becomes shorter by the sliding."""
    moved = pressed(tmp_path / "moved.msh", 0.0, sliding)
    there = pressed(tmp_path / "there.msh", sliding, 0.0)
    (one,), (other,) = moved.contacts, there.contacts
    assert one.normal_force[-1] == pytest.approx(1500.0, rel=1e-9)
    before, after, expected = one.half_width[1], one.half_width[-1], other.half_width[-1]
    assert expected < before - 0.4 * sliding
    # A tenth of what sliding changes, or a quarter of an element of .008, as edges are known to.
    assert abs(after - expected) < max(0.1 * sliding / 2, 0.002)
