# SPDX-License-Identifier: LGPL-3.0-or-later
"""Benchmark B1: a cylindrical pad on a rectangular substrate, meshed as a user would with Gmsh.

Lengths in mm. The two meshes do not match at the interface. Bodies `pad` and `substrate`;
boundaries `pad_contact`, `pad_top`, `substrate_contact`, `substrate_bottom`, `substrate_left`,
`substrate_right`.
"""

from __future__ import annotations

import math
import os
from itertools import pairwise

import gmsh

RADIUS = 50.0
PAD_HALF_WIDTH = 10.0
SUBSTRATE_HALF_WIDTH = 20.0
HEIGHT = 20.0
ZONE = 1.5  # half-width of the candidate contact zone
MISMATCH = 1.07  # facet length on the substrate over facet length on the pad


def write_b1(
    path: str | os.PathLike[str], order: int = 2, h: float = 0.02, growth: float = 0.15
) -> None:
    """Write the mesh to `path` (.msh 4.1).

    Args:
        path: File to write.
        order: Polynomial order of the elements, 1 or 2.
        h: Element size in the contact zone.
        growth: Increase of the element size per distance from the contact zone.
    """
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("b1")
        substrate = _add_substrate()
        pad = _add_pad()
        gmsh.model.geo.synchronize()
        _name_groups(pad, substrate)
        _grade([pad[1], substrate[3]], h, growth)
        _divide(pad[1], h)
        _divide(substrate[3], MISMATCH * h)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        gmsh.write(os.fspath(path))
    finally:
        gmsh.finalize()


def _add_substrate() -> list[int]:
    """Curves counter-clockwise from the bottom; [3] is the contact zone."""
    x, y = SUBSTRATE_HALF_WIDTH, -HEIGHT
    corners = [(-x, y), (x, y), (x, 0.0), (ZONE, 0.0), (-ZONE, 0.0), (-x, 0.0)]
    points = [gmsh.model.geo.addPoint(*corner, 0.0) for corner in corners]
    curves = [gmsh.model.geo.addLine(*ends) for ends in pairwise([*points, points[0]])]
    _add_surface(curves)
    return curves


def _add_pad() -> list[int]:
    """Curves counter-clockwise from the left arc; [1] is the contact zone, [4] the top."""
    centre = gmsh.model.geo.addPoint(0.0, RADIUS, 0.0)
    stations = (-PAD_HALF_WIDTH, -ZONE, ZONE, PAD_HALF_WIDTH)
    corners = [(x, RADIUS - math.sqrt(RADIUS**2 - x**2)) for x in stations]
    corners += [(PAD_HALF_WIDTH, HEIGHT), (-PAD_HALF_WIDTH, HEIGHT)]
    points = [gmsh.model.geo.addPoint(*corner, 0.0) for corner in corners]
    curves = [gmsh.model.geo.addCircleArc(a, centre, b) for a, b in pairwise(points[:4])]
    curves += [gmsh.model.geo.addLine(a, b) for a, b in pairwise([*points[3:], points[0]])]
    _add_surface(curves)
    return curves


def _add_surface(curves: list[int]) -> None:
    gmsh.model.geo.addPlaneSurface([gmsh.model.geo.addCurveLoop(curves)])


def _name_groups(pad: list[int], substrate: list[int]) -> None:
    for (_, surface), name in zip(gmsh.model.getEntities(2), ("substrate", "pad"), strict=True):
        gmsh.model.addPhysicalGroup(2, [surface], name=name)
    curves = {
        "pad_contact": pad[1],
        "pad_top": pad[4],
        "substrate_contact": substrate[3],
        "substrate_bottom": substrate[0],
        "substrate_left": substrate[5],
        "substrate_right": substrate[1],
    }
    for name, curve in curves.items():
        gmsh.model.addPhysicalGroup(1, [curve], name=name)


def _grade(contact: list[int], h: float, growth: float) -> None:
    """Element size h + growth * distance from the contact zone, and nothing else."""
    field = gmsh.model.mesh.field
    distance = field.add("Distance")
    field.setNumbers(distance, "CurvesList", contact)
    field.setNumber(distance, "Sampling", 400)
    size = field.add("MathEval")
    field.setString(size, "F", f"{h} + {growth}*F{distance}")
    field.setAsBackgroundMesh(size)
    for source in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 6)


def _divide(curve: int, size: float) -> None:
    gmsh.model.mesh.setTransfiniteCurve(curve, round(2 * ZONE / size) + 1)
