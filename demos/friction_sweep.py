# SPDX-License-Identifier: LGPL-3.0-or-later
"""The dovetail with five friction coefficients: what friction changes, and what it does not.

Nobody knows the friction coefficient of a flank well. K_N hardly depends on it as long as the
flanks do not slide as a whole in the cycle; the slip zones become shorter with more friction, and
what the edges remember follows them. The bodies are condensed once for all cases: only the load
steps are solved five times. The same from the command line:

    fretfe sweep demos/dovetail.toml --vary "contacts.*.friction=0.4:0.8:5" -o results/friction

Run it with: python demos/friction_sweep.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from compare import Row, finish

import fretfe

FRICTION = [0.4, 0.5, 0.6, 0.7, 0.8]

# A little coarser than the demo itself, to be quick.
path = Path(__file__).with_name("dovetail.toml")
case = fretfe.load_case(path, {"geometry.parameters.edge_size": 0.003})
sweep = fretfe.sweep(case, {"contacts.*.friction": FRICTION})

# The lower edge of the right flank.
edges = [r for r in sweep.records() if (r["contact"], r["edge"]) == ("right", "left")]
k_n, found, predicted = (
    np.array([edge[name] for edge in edges]) for name in ("k_n", "slip_1", "predicted_1")
)
middle = FRICTION.index(0.6)
rows = []
for number, friction in enumerate(FRICTION):
    rows += [
        Row(f"f = {friction}: K_N, as with f = 0.6", k_n[number], k_n[middle], 0.06),
        Row(f"f = {friction}: d, found and predicted [mm]", found[number], predicted[number], 0.06),
    ]
finish(rows)
