# SPDX-License-Identifier: LGPL-3.0-or-later
"""A geometry from a CAD program: a STEP file, names by points, a mesh that finds the contact.

The contact is 1.2 mm wide on a face of 24 mm. Nothing in the case says where it is or how fine the
mesh must be; only the accuracy is given. The pad is that of hertz.py, so that the answer is known.

Run it with: python demos/own_geometry.py
"""

from __future__ import annotations

import math
from pathlib import Path

from compare import Row, finish

import fretfe
from fretfe.analytic.partial_slip import PartialSlip
from fretfe.analytic.profiles import Hertz

NORMAL_FORCE, SHEAR_AMPLITUDE, FRICTION = 600.0, 60.0, 0.4

case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)
(contact,) = result.contacts

profile = Hertz(radius=50.0, e_star=210e3 / (2 * (1 - 0.3**2)))
exact = PartialSlip(profile, NORMAL_FORCE, FRICTION)
half_width = exact.half_width
k_n = float(profile.load_slope(half_width)) * math.sqrt(2 / half_width) / math.pi
slip = half_width - float(exact.stick_half_width(SHEAR_AMPLITUDE))

rows = []
for edge in contact.stations:
    rows += [
        Row(f"edge position {edge.front} [mm]", abs(edge.position[-1]), half_width, 0.005),
        Row(f"K_N {edge.front} [MPa/√mm]", edge.k_n[-1], k_n, 0.01),
        Row(f"slip zone d {edge.front} [mm]", edge.slip_zones[-1].length, slip, 0.02),
    ]
finish(rows)
