# SPDX-License-Identifier: LGPL-3.0-or-later
"""A pad on a block as files that users have: CAD files, meshes of other programs, Gmsh scripts."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gmsh
from cases import pad_cases

# Radius and half width of the pad, half length of its contact surface, heights.
RADIUS, WIDTH, ZONE, HEIGHT = 50.0, 12.0, 1.5, 12.0
SIDES = ("lower_left", "lower_right", "lower_bottom")


def arc_y(x: float) -> float:
    """Height of the face of the pad."""
    return RADIUS - math.sqrt(RADIUS**2 - x**2)


def draw(scale: float = 1.0) -> dict[str, int]:
    """Draw both bodies with OpenCASCADE in the current model: tags of faces and curves by name."""
    occ = gmsh.model.occ

    def point(x: float, y: float) -> int:
        return int(occ.addPoint(scale * x, scale * y, 0))

    def chain(corners: list[int], names: list[str], centre: int | None = None) -> dict[str, int]:
        tags = {}
        for place, name in enumerate(names):
            start, end = corners[place], corners[(place + 1) % len(corners)]
            arc = centre is not None and place < 3
            tag = occ.addCircleArc(start, centre, end) if arc else occ.addLine(start, end)
            tags[name] = int(tag)
        return tags

    centre = point(0, RADIUS)
    arcs = [point(x, arc_y(x)) for x in (-WIDTH, -ZONE, ZONE, WIDTH)]
    names = ["upper_arc_left", "upper_contact", "upper_arc_right"]
    names += ["upper_right", "upper_top", "upper_left"]
    tags = chain([*arcs, point(WIDTH, HEIGHT), point(-WIDTH, HEIGHT)], names, centre)
    tags["upper"] = occ.addPlaneSurface([occ.addCurveLoop(list(tags.values()))])
    corners = [(-WIDTH, 0), (-WIDTH, -WIDTH), (WIDTH, -WIDTH), (WIDTH, 0), (ZONE, 0), (-ZONE, 0)]
    names = ["lower_left", "lower_bottom", "lower_right"]
    names += ["lower_top_right", "lower_contact", "lower_top_left"]
    block = chain([point(*each) for each in corners], names)
    tags |= {**block, "lower": occ.addPlaneSurface([occ.addCurveLoop(list(block.values()))])}
    occ.remove([(0, centre)])
    occ.synchronize()
    return tags


def write_cad(path: Path, scale: float = 1.0) -> Path:
    """Write a CAD file of the pad, without any names, in mm if it is a STEP file."""
    gmsh.initialize([], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("pad")
        draw(scale)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


def style(path: Path, labels: Sequence[str], colours: Mapping[int, str]) -> Path:
    """Give names to the parts of a STEP file and colours to its edges, both by their order.

    Gmsh does not write them; these are the entities that CAD programs write (ISO 10303-46).
    """
    text = path.read_text()
    parts = re.findall(r"PRODUCT\('([^']*)'", text)[-len(labels) :]
    for old, new in zip(parts, labels, strict=True):
        text = text.replace(f"'{old}'", f"'{new}'")
    number = max(map(int, re.findall(r"^#(\d+) = ", text, re.MULTILINE)))
    edges = re.findall(r"#(\d+) = EDGE_CURVE", text)
    context = re.findall(r"MANIFOLD_SURFACE_SHAPE_REPRESENTATION\('',\([^)]*\),#(\d+)\)", text)[0]
    lines, styled = [], []
    for edge, colour in colours.items():
        rgb = ",".join(f"{int(colour[i : i + 2], 16) / 255:.6f}" for i in (1, 3, 5))
        n = number + 1
        lines += [
            f"#{n} = STYLED_ITEM('color',(#{n + 1}),#{edges[edge]});",
            f"#{n + 1} = PRESENTATION_STYLE_ASSIGNMENT((#{n + 2}));",
            f"#{n + 2} = CURVE_STYLE('',#{n + 3},POSITIVE_LENGTH_MEASURE(0.1),#{n + 4});",
            f"#{n + 3} = DRAUGHTING_PRE_DEFINED_CURVE_FONT('continuous');",
            f"#{n + 4} = COLOUR_RGB('',{rgb});",
        ]
        styled.append(f"#{n}")
        number = n + 4
    lines.append(
        f"#{number + 1} = MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',"
        f"({','.join(styled)}),#{context});"
    )
    head, end = text[: text.rindex("ENDSEC;")], text[text.rindex("ENDSEC;") :]
    path.write_text(head + "\n".join(lines) + "\n" + end)
    return path


BODIES: dict[str, Any] = {"upper": {"point": [0, 5]}, "lower": {"point": [0, -5]}}
BOUNDARIES: dict[str, Any] = {
    "upper_contact": {"point": [1.0, arc_y(1.0)], "body": "upper"},
    "upper_top": {"points": [[0, HEIGHT], [1, HEIGHT]]},
    "lower_contact": {"point": [0, 0], "body": "lower"},
    "lower_left": {"point": [-WIDTH, -6]},
    "lower_right": {"point": [WIDTH, -6]},
    "lower_bottom": {"point": [0, -WIDTH]},
}


def cad_geometry(path: Path, size: float = 0.04, **tables: Any) -> dict[str, Any]:
    """The table [geometry] of a CAD file."""
    names = {"bodies": BODIES, "boundaries": BOUNDARIES}
    return {"file": str(path), "size": size, **names, **tables}


def case_of(geometry: Mapping[str, Any], **tables: Any) -> dict[str, Any]:
    """A case with a geometry of this pad."""
    return pad_cases.pad(geometry=dict(geometry), **tables)
