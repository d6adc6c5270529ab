# SPDX-License-Identifier: LGPL-3.0-or-later
"""A fine flank that a coarse run of the whole dovetail drives.

The whole, with elements ten times as large as it needs, carries the right forces and has no edge
factors to speak of. Around its left flank a circle is cut out of both bodies and meshed finely; the
displacements of the coarse run move the cuts. What comes out is compared with the fine run in one
piece.

Run it with: python demos/submodel.py
"""

from __future__ import annotations

from pathlib import Path

from compare import Row, finish

import fretfe
from fretfe.backends import find_backend

CASE = Path(__file__).with_name("dovetail.toml")
FOLDER = Path("results") / "submodel"
# Half-widths of the contact from its middle to the cut: 2.16 mm.
RADIUS = 6.5

coarse = fretfe.load_case(CASE, {"geometry.parameters.edge_size": 0.02, "output.fields": "all"})
fretfe.run(coarse, output=FOLDER / "global")


def write() -> None:
    """Write the case of the flank; on the first process, if there are several."""
    result = fretfe.load_result(FOLDER / "global")
    fretfe.write_submodel(result, "left", FOLDER / "case", radius=RADIUS, size=0.002)


find_backend("fem").processes.on_root(write)
part = fretfe.run(fretfe.load_case(FOLDER / "case" / "submodel.toml"))
for note in part.notes:
    print(note)

whole = fretfe.run(fretfe.load_case(CASE))
(flank,), reference = part.contacts, whole.contacts[0]
rows = [
    Row("P [N/mm]", flank.normal_force[-1], reference.normal_force[-1], 1e-3),
    Row("Q [N/mm]", flank.shear_force[-1], reference.shear_force[-1], 1e-3),
]
for name, edge, expected in zip(
    ("upper", "lower"), flank.stations, reference.stations, strict=True
):
    rows += [
        Row(f"K_N {name}", edge.k_n[-1], expected.k_n[-1], 0.005),
        # The cut knows that the contact of the coarse run has slipped.
        Row(f"ΔK_T {name}", edge.k_t_range, expected.k_t_range, 0.01),
    ]
    for number in (-2, -1):
        found, wanted = (each.slip_zones[number] for each in (edge, expected))
        # Lengths of a few elements are known to their error bars: the same, within both.
        allowed = 0.01 + (found.spread + wanted.spread) / wanted.length
        title = f"d {name}, half cycle {number + 3}"
        rows.append(Row(title, found.length, wanted.length, allowed))
finish(rows)
