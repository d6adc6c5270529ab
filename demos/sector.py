# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dovetail in one sector of a disc that spins: no support and no load but the speed.

What the flanks must carry is known: the mass of the blade times the square of the speed times the
radius of its centre of mass. The rest is found in two ways, as in the demo dovetail.py.

Run it with: python demos/sector.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from compare import Row, finish

import fretfe
from fretfe.mesh.elements import quadrature, shape_slopes, shape_values

FLANK_ANGLE = math.radians(50.0)

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
mesh = fretfe.make_mesh(case)
result = fretfe.run(case)
left, right = result.contacts

# Area times radius of the blade, over its curved triangles.
blade = mesh.bodies["blade"]
nodes = blade.points[blade.cells]
at, weights = quadrature("triangle", 4)
area = weights * np.linalg.det(np.einsum("qak,mkd->mqad", shape_slopes("triangle", 2, at), nodes))
height = np.einsum("qk,mk->mq", shape_values("triangle", 2, at), nodes[..., 1])
moment = np.sum(area * (height - case.symmetry["disc"].centre[1]))
speed = result.loads.values[:, 0]
pull = case.bodies["blade"].density * moment * speed**2

# The shear of the right flank is positive towards its upper end, that of the left one negative.
pressure = left.normal_force + right.normal_force
shear = right.shear_force - left.shear_force
carried = np.cos(FLANK_ANGLE) * pressure + np.sin(FLANK_ANGLE) * shear
largest = int(np.argmax(pull))
rows = [Row("pull carried by both flanks [N/mm]", carried[largest], pull[largest], 1e-8)]
for name, edge, mirrored in (
    ("lower", right.stations[0], left.stations[1]),
    ("upper", right.stations[1], left.stations[0]),
):
    rows += [
        Row(f"K_N {name}, right and left flank", edge.k_n[-1], mirrored.k_n[-1], 1e-3),
        Row(f"ΔK_T {name}, right and left flank", edge.k_t_range, mirrored.k_t_range, 1e-3),
        Row(f"ΔK_T {name}, two extractions", edge.k_t_range, edge.k_t_range_fitted, 0.01),
    ]
finish(rows)
