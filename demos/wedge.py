# SPDX-License-Identifier: LGPL-3.0-or-later
"""A wedge on a block: the edges know nothing of the apex.

The faces of the wedge rise by a small angle α from the block. For half-planes P = E* tan(α) a, and
for any symmetric profile

    K_N = (1/π) √(2/a) dP/da
    ΔK_T = 2 Q/(π √(2 a))

although the pressure at the apex is infinite. The exact slip zones are those of Ciavarella and
Jäger: the shear is f times the difference of the pressures of two half-widths, a and c.

Run it with: python demos/wedge.py
"""

from __future__ import annotations

import math
from pathlib import Path

from compare import Row, finish

import fretfe
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import Wedge

NORMAL_FORCE, SHEAR_AMPLITUDE, FRICTION = 800.0, 60.0, 0.4

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)
(contact,) = result.contacts

profile = Wedge(slope=math.tan(math.radians(1.0)), e_star=210e3 / (2 * (1 - 0.3**2)))
exact = PartialSlip(profile, NORMAL_FORCE, FRICTION)
half_width = exact.half_width
k_n = float(profile.load_slope(half_width)) * math.sqrt(2 / half_width) / math.pi
k_t_range = 2 * SHEAR_AMPLITUDE / (math.pi * math.sqrt(2 * half_width))
slip = half_width - float(exact.stick_half_width(SHEAR_AMPLITUDE))

rows = []
for edge in contact.stations:
    zone = edge.slip_zones[-1]
    rows += [
        Row(f"edge position {edge.front} [mm]", abs(edge.position[-1]), half_width, 0.005),
        Row(f"K_N {edge.front} [MPa/√mm]", edge.k_n[-1], k_n, 0.01),
        Row(f"ΔK_T {edge.front} [MPa·√mm]", edge.k_t_range, k_t_range, 0.01),
        Row(f"slip zone d {edge.front} [mm]", zone.length, slip, 0.02),
        # The leading term in d/a = 0.19; for a wedge it happens to be exact.
        Row(f"d by ΔK_T/(f K_N) {edge.front} [mm]", zone.predicted, slip, 0.02),
    ]
finish(rows)
