# SPDX-License-Identifier: LGPL-3.0-or-later
"""A punch with rounded ends, 8 long, on a block of 10, as STEP files in any place, and cases."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from cases.pad_cases import pad

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.mesh.gmsh import gmsh_model

# Flat from -1 to 1 with arcs of radius 1 up to an angle of 30 degrees.
ARC = np.sin(np.radians(30.0)), 1 - np.cos(np.radians(30.0))
BODIES = {"upper": [0.0, 1.0, 5.0], "lower": [0.0, -1.0, 5.0]}
BOUNDARIES = {
    "upper_contact": ([[0.0, 0.0, 5.0], [1.25, 0.0318, 5.0], [-1.25, 0.0318, 5.0]], "upper"),
    "lower_contact": ([[0.0, 0.0, 5.0]], "lower"),
    "upper_top": ([[0.0, 2.0, 5.0]], "upper"),
    "lower_bottom": ([[0.0, -2.0, 5.0]], "lower"),
    "upper_shroud": ([[0.0, 1.0, 9.0]], "upper"),
}


@dataclass(frozen=True)
class Placed:
    """A place of the bodies: turned about an axis, moved, scaled, and how the punch is changed."""

    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    angle: float = 0.0
    move: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirrored: bool = False
    lean: float = 0.0
    # Height of an edge at the end of the punch, up to where and how far along it is cut off.
    chamfer: tuple[float, float, float] | None = None
    changes: dict[str, Any] = field(default_factory=dict)

    @property
    def matrix(self) -> Array:
        """(3, 3) of the map of places of the drawing."""
        x, y, z = np.array(self.axis) / np.linalg.norm(self.axis)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + np.sin(self.angle) * cross + (1 - np.cos(self.angle)) * cross @ cross
        return turn @ np.diag([-1.0 if self.mirrored else 1.0, 1.0, 1.0])

    def of(self, point: Sequence[float]) -> list[float]:
        """A place in space of one of the drawing, which leans along x."""
        leaned = np.array(point) + self.lean * point[2] * np.array([1.0, 0.0, 0.0])
        return (self.matrix @ leaned + self.move).tolist()

    def case(self, folder: Path) -> Case:
        """A case with its file, of which no element size is given."""
        self._write(folder / "punch.step")
        boundaries = {
            name: {"points": [self.of(point) for point in points], "body": body}
            for name, (points, body) in BOUNDARIES.items()
        }
        geometry = {
            "file": str(folder / "punch.step"),
            "bodies": {name: {"point": self.of(point)} for name, point in BODIES.items()},
            "boundaries": boundaries,
            **self.changes,
        }
        held = {"base": {"boundary": "lower_bottom", "fix": ["x", "y", "z"]}}
        push = {"type": "traction", "boundary": "upper_top", "direction": "normal"}
        loads = {"press": {**push, "history": [{"ramp": -1.0, "until": 1.0, "steps": 1}]}}
        return parse_case(pad(geometry=geometry, supports=held, loads=loads))

    def _write(self, path: Path) -> None:
        with gmsh_model(path) as gmsh:
            occ = gmsh.model.occ
            y, out = ARC[1], 1 + ARC[0]
            corners = [(-out, y), (-1, 0), (1, 0), (out, y), (out, 2), (-out, 2)]
            points = [occ.addPoint(*self.of([*place, 1.0])) for place in corners]
            middles = [occ.addPoint(*self.of([side, 1.0, 1.0])) for side in (-1, 1)]
            curves = [
                occ.addCircleArc(points[0], middles[0], points[1]),
                occ.addLine(points[1], points[2]),
                occ.addCircleArc(points[2], middles[1], points[3]),
                *(occ.addLine(points[n], points[(n + 1) % 6]) for n in (3, 4, 5)),
            ]
            self._sweep(gmsh, curves, 8.0)
            base = [(-4, -2), (4, -2), (4, 0), (-4, 0)]
            points = [occ.addPoint(*self.of([*place, 0.0])) for place in base]
            self._sweep(gmsh, [occ.addLine(points[n], points[(n + 1) % 4]) for n in range(4)], 10.0)
            if self.chamfer is not None:
                edge, to, along = self.chamfer
                ends = [-3, to, 9], [-3, edge, 9 - along], [-3, edge, 9]
                wedge = [occ.addPoint(*self.of(place)) for place in ends]
                loop = [occ.addLine(wedge[n], wedge[(n + 1) % 3]) for n in range(3)]
                face = occ.addPlaneSurface([occ.addCurveLoop(loop)])
                cut = occ.extrude([(2, face)], *(self.matrix @ [6.0, 0.0, 0.0]))
                occ.cut([(3, 1)], [each for each in cut if each[0] == 3])
                occ.remove([(2, face)], recursive=True)
            occ.synchronize()
            gmsh.write(str(path))

    def _sweep(self, gmsh: Any, curves: list[int], length: float) -> None:
        occ = gmsh.model.occ
        face = occ.addPlaneSurface([occ.addCurveLoop(curves)])
        occ.extrude([(2, face)], *(self.matrix @ [self.lean * length, 0.0, length]))
