# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dovetail root that runs in: its friction rises from .2 to .6 in 20 blocks of a cycle.

New flanks slip far: a cycle does four times the friction work of the last one. What they slid in
with little friction stays: the root sits deeper, its flanks carry more normal force, and K_N is
larger than that of a root that always had its friction. The range ΔK_T remembers hardly anything.

Run it with: python demos/running_in.py
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from compare import Row, finish

import fretfe

BLOCKS = np.linspace(0.2, 0.6, 20)
LOADED = 1.5
path = Path(__file__).with_name("dovetail.toml")

# One cycle in each block; friction changes within the first thousandth of it.
begins = LOADED + np.arange(len(BLOCKS))
times = np.column_stack([begins + 0.001, begins + 1.0]).ravel()
friction = {"times": [0.0, *times], "values": [0.2, *np.repeat(BLOCKS, 2)]}
coarse: dict[str, Any] = {
    "geometry.parameters.edge_size": 0.005,
    "loads.pull.history.3.steps_per_cycle": 12,
    "output.fields": "none",
}
cycles = {"loads.pull.history.3.cycles": len(BLOCKS)}
run_in = fretfe.run(fretfe.load_case(path, {**coarse, **cycles, "contacts.*.friction": friction}))
old = fretfe.run(fretfe.load_case(path, {**coarse, "loads.pull.history.3.cycles": 2}))

flank, same = (
    next(contact for contact in result.contacts if contact.name == "right")
    for result in (run_in, old)
)
clock = run_in.loads.times
print("friction work of the right flank, in N/mm a cycle")
for begin, coefficient in zip(begins, BLOCKS, strict=True):
    cycle = (clock > begin + 1e-9) & (clock < begin + 1.0 + 1e-9)
    print(f"f = {coefficient:.3f}: {flank.work[cycle].sum():.4f}")

for edge, other in zip(flank.stations, same.stations, strict=True):
    more = edge.k_n[-1] / other.k_n[-1] - 1
    print(f"{edge.front} edge: K_N is {more:.0%} above that of a root that always had f = 0.6")

angle = np.radians(50.0)
carried = sum(
    np.cos(angle) * each.normal_force + np.sin(angle) * np.abs(each.shear_force)
    for each in run_in.contacts
)
pull = run_in.loads.values[:, 0]
rows = [Row("pull carried by both flanks [N/mm]", carried[-1], pull[-1], 1e-6)]
for edge, other in zip(flank.stations, same.stations, strict=True):
    label = f"{edge.front} edge: ΔK_T, run in and always with f = 0.6 [MPa·√mm]"
    rows.append(Row(label, edge.k_t_range, other.k_t_range, 0.03))
# The zone of the other edge is two elements long.
zone = flank.stations[1].slip_zones[-1]
rows.append(Row("right edge: d, found and predicted [mm]", zone.length, zone.prediction, 0.1))
finish(rows)
