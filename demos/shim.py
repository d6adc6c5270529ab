# SPDX-License-Identifier: LGPL-3.0-or-later
"""A blade, shims under the shoulders of its root and a sector of the disc: four bodies in a row.

Blade and shims are held by contacts only, so each shim passes on what it gets, and both sides of
the blade, which are meshed alike, carry half of the pull.

Run it with: python demos/shim.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from compare import Row, finish

import fretfe

NECK_WIDTH = 2 * (8 - 4.2 * 0.5 - 1.2)  # shim.geo: inner, round, fillet

case = fretfe.load_case(Path(__file__).with_suffix(".toml"), trust_geo=True)
result = fretfe.run(case)
contacts = {each.name: each for each in result.contacts}
pull = NECK_WIDTH * result.loads.values[:, 0]
largest = int(np.argmax(pull))

rows = [
    Row(f"P {name} [N/mm]", each.normal_force[largest], pull[largest] / 2, 1e-6)
    for name, each in contacts.items()
]
for side in ("left", "right"):
    root, seat = (contacts[f"{name}_{side}"] for name in ("root", "seat"))
    shears = root.shear_force[largest], seat.shear_force[largest]
    rows.append(Row(f"Q of the shim, {side}, both contacts [N/mm]", *shears, 1e-6))
for name in ("root", "seat"):
    edges = contacts[f"{name}_right"].stations[1], contacts[f"{name}_left"].stations[0]
    outer = (abs(each.position[largest]) for each in edges)
    rows.append(Row(f"outer edge of the {name}, right and left [mm]", *outer, 1e-3))
shear = [-contacts["root_right"].shear_force[largest], contacts["root_left"].shear_force[largest]]
rows.append(Row("Q of the root, right and left [N/mm]", *shear, 1e-6))
finish(rows)
