# SPDX-License-Identifier: LGPL-3.0-or-later
"""A firtree blade root with three pairs of lobes: six contacts, twelve edges.

How the lobes share the pull is known to nobody before it is computed. What must hold: all together
they carry it, left and right mirror each other, and every edge has its factors.

Run it with: python demos/firtree.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from compare import Row, finish

import fretfe

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)

flank_angle = math.radians(case.geometry.parameters.get("flank_angle", 45.0))
carried = 0.0
lobes = {}
for contact in result.contacts:
    # The shear of a right flank is positive towards its upper end, that of a left one negative.
    side = 1.0 if "right" in contact.name else -1.0
    share = math.cos(flank_angle) * contact.normal_force
    share = share + side * math.sin(flank_angle) * contact.shear_force
    carried = carried + share
    lobes[contact.name] = share
pull = result.loads.values[:, 0]
largest = int(np.argmax(pull))
for name, share in lobes.items():
    print(f"{name:12s} carries {share[largest] / pull[largest]:7.2%} of the pull")

rows = [Row("pull carried by all lobes [N/mm]", carried[largest], pull[largest], 1e-8)]
contacts = {contact.name: contact for contact in result.contacts}
for name, right in contacts.items():
    if "right" not in name:
        continue
    left = contacts[name.replace("right", "left")]
    for edge, mirrored in zip(right.stations, reversed(left.stations), strict=True):
        # The mesh mirrors itself to 1e-6.
        label = f"{name} {edge.front} edge, right and left"
        rows.append(Row(f"K_N {label}", edge.k_n[-1], mirrored.k_n[-1], 1e-4))
        rows.append(Row(f"ΔK_T {label}", edge.k_t_range, mirrored.k_t_range, 1e-4))
finish(rows)
