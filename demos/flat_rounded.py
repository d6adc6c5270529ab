# SPDX-License-Identifier: LGPL-3.0-or-later
"""A flat punch with rounded ends: the edges of an almost complete contact.

The flat makes 95 % of the contact, b = 0.95 a. The pressure rises from zero at the edge to its peak
within the outer 5 %, so that √s holds only very near to the edge. There, as for any profile,

    K_N = (1/π) √(2/a) dP/da
    ΔK_T = 2 Q/(π √(2 a))

and the mesh has to find that out: its elements at the edges are ten thousand times smaller than
the contact. Slip zones must be short in comparison with a - b for the formula d = ΔK_T/(f K_N).

Run it with: python demos/flat_rounded.py
"""

from __future__ import annotations

import math
from pathlib import Path

from compare import Row, finish

import fretfe
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import FlatRounded

NORMAL_FORCE, SHEAR_AMPLITUDE, FRICTION = 26.750084, 1.5, 0.4

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)
(contact,) = result.contacts

profile = FlatRounded(1.0, radius=50.0, e_star=210e3 / (2 * (1 - 0.3**2)))
exact = PartialSlip(profile, NORMAL_FORCE, FRICTION)
half_width = exact.half_width
k_n = float(profile.load_slope(half_width)) * math.sqrt(2 / half_width) / math.pi
k_t_range = 2 * SHEAR_AMPLITUDE / (math.pi * math.sqrt(2 * half_width))
slip = half_width - float(exact.stick_half_width(SHEAR_AMPLITUDE))

rows = []
for edge in contact.stations:
    zone = edge.slip_zones[-1]
    rows += [
        Row(f"edge position {edge.front} [mm]", abs(edge.position[-1]), half_width, 0.001),
        Row(f"K_N {edge.front} [MPa/√mm]", edge.k_n[-1], k_n, 0.01),
        Row(f"ΔK_T {edge.front} [MPa·√mm]", edge.k_t_range, k_t_range, 0.01),
        Row(f"slip zone d {edge.front} [mm]", zone.length, slip, 0.02),
        # The leading term in d/(a - b) = 0.1.
        Row(f"d by ΔK_T/(f K_N) {edge.front} [mm]", zone.predicted, slip, 0.05),
    ]
finish(rows)
