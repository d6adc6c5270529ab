# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shear force and bulk tension out of phase: the load path is an ellipse.

At the two edges of a contact between half-planes

    K_T = ± Q/(π √(2 a)) + (σ0/4) √(a/2)        (+ at the left edge)

With Q and σ0 out of phase neither edge sees its largest K_T when Q is largest. Its range over the
ellipse, not the sum of the ranges, gives the length of the slip zone, d = ΔK_T/(f K_N).

Run it with: python demos/ellipse.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from compare import Row, finish

import fretfe
from fretfe.analytic.edges import factor_range_phase_shifted, slip_length_cyclic
from fretfe.analytic.profiles import Hertz

SHEAR_AMPLITUDE, PULL_AMPLITUDE, FRICTION, NORMAL_FORCE = 50.0, 40.0, 0.6, 600.0
# A block that is held at its left end carries the shear force there: under the pad the mean tension
# is Q/(2 H) besides the pull, with the height H of the block.
HEIGHT = 20.0

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)
(contact,) = result.contacts

profile = Hertz(radius=50.0, e_star=210e3 / (2 * (1 - 0.3**2)))
half_width = float(profile.half_width(NORMAL_FORCE))
k_n = float(profile.load_slope(half_width)) * math.sqrt(2 / half_width) / math.pi

# Q = Re[SHEAR_AMPLITUDE exp(i t)]; the tension is this complex amplitude, a quarter cycle ahead.
tension = SHEAR_AMPLITUDE / (2 * HEIGHT) + 1j * PULL_AMPLITUDE
rows = []
for edge in contact.stations:
    k_t_range = float(
        factor_range_phase_shifted(
            SHEAR_AMPLITUDE, abs(tension), -np.angle(tension), half_width, edge.front
        )
    )
    slip = float(slip_length_cyclic(k_t_range, k_n, FRICTION))
    rows += [
        Row(f"K_N {edge.front} [MPa/√mm]", edge.k_n[-1], k_n, 0.01),
        # Half-planes against a block 35 half-widths high.
        Row(f"ΔK_T {edge.front} [MPa·√mm]", edge.k_t_range, k_t_range, 0.01),
    ]
    for number, zone in enumerate(edge.slip_zones[-2:], start=1):
        # The formula is the leading term in d/a = 0.08: 4 % short, and 1 % for the mesh.
        rows.append(Row(f"d {edge.front}, half cycle {number} [mm]", zone.length, slip, 0.06))
finish(rows)
