# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dovetail blade root under a pull that cycles: nothing is known in closed form.

What must hold all the same: both flanks mirror each other, together they carry the pull, and what
is found in two ways is found twice. K_N comes from the pressure next to the edge, and from the
movement of the edge with the load; ΔK_T from displacements around the edge, and from tractions;
the slip zones from the solution, and from the edge formulas for a normal load that varies.

Run it with: python demos/dovetail.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from compare import Row, finish

import fretfe

FLANK_ANGLE = math.radians(50.0)

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)
left, right = result.contacts

# Pressure and shear of both flanks, projected on the direction of the pull. The shear of the
# right flank is positive towards its upper end, that of the left one negative.
pressure = left.normal_force + right.normal_force
shear = right.shear_force - left.shear_force
carried = np.cos(FLANK_ANGLE) * pressure + np.sin(FLANK_ANGLE) * shear
pull = result.loads.values[:, 0]
largest = int(np.argmax(pull))
rows = [Row("pull carried by both flanks [N/mm]", carried[largest], pull[largest], 1e-8)]

for name, edge, mirrored in (
    ("lower", right.stations[0], left.stations[1]),
    ("upper", right.stations[1], left.stations[0]),
):
    # The upper edges hardly move: there the movement tells K_N with a bar of some tenths only.
    moved = max(0.025, edge.k_n_moved_spread / edge.k_n[-1])
    rows += [
        # The mesh mirrors itself to 1e-6.
        Row(f"K_N {name}, right and left flank", edge.k_n[-1], mirrored.k_n[-1], 1e-4),
        Row(f"K_N {name}, by pressure and by movement", edge.k_n[-1], edge.k_n_moved, moved),
        Row(f"ΔK_T {name}, right and left flank", edge.k_t_range, mirrored.k_t_range, 1e-4),
        Row(f"ΔK_T {name}, two extractions", edge.k_t_range, edge.k_t_range_fitted, 0.01),
    ]
    for number, zone in enumerate(edge.slip_zones[-2:], start=1):
        # The leading term in d over the rounding in contact.
        computed = f"d {name}, half cycle {number}, found and predicted"
        rows.append(Row(computed, zone.length, zone.predicted_loop, 0.12))
finish(rows)
