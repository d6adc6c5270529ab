# SPDX-License-Identifier: LGPL-3.0-or-later
"""Hertz fretting cycle: the finite elements against Hertz, Cattaneo and Mindlin.

A cylinder of radius R is pressed on a block with a force P per thickness, then a shear force
Q sin(2π t) acts. For half-planes

    a² = 4 P R/(π E*)             half-width of the contact
    K_N = (2 P/(π a)) √(2/a)      p = K_N √s next to an edge
    ΔK_T = 2 Q/(π √(2 a))         stuck contact: q = K_T/√s
    c = a √(1 - Q/(f P))          half-width of the part that always sticks, d = a - c

Run it with: python demos/hertz.py
"""

from __future__ import annotations

import math
from pathlib import Path

from compare import Row, finish

import fretfe

RADIUS, NORMAL_FORCE, SHEAR_AMPLITUDE, FRICTION = 50.0, 600.0, 60.0, 0.4
E_STAR = 210e3 / (2 * (1 - 0.3**2))

# The case file says everything that the solver needs to know.
case = fretfe.load_case(Path(__file__).with_suffix(".toml"))
result = fretfe.run(case)

# What half-planes of the same material do.
half_width = math.sqrt(4 * NORMAL_FORCE * RADIUS / (math.pi * E_STAR))
k_n = 2 * NORMAL_FORCE / (math.pi * half_width) * math.sqrt(2 / half_width)
k_t_range = 2 * SHEAR_AMPLITUDE / (math.pi * math.sqrt(2 * half_width))
slip = half_width * (1 - math.sqrt(1 - SHEAR_AMPLITUDE / (FRICTION * NORMAL_FORCE)))

(contact,) = result.contacts
rows = [
    # The bodies are 28 half-widths wide, which changes all of these by about 0.1 %.
    Row("half-width a [mm]", contact.half_width[-1], half_width, 0.003),
]
for edge in contact.stations:
    backward, forward = edge.slip_zones[-2:]
    rows += [
        Row(f"K_N {edge.front} [MPa/√mm]", edge.k_n[-1], k_n, 0.005),
        Row(f"ΔK_T {edge.front} [MPa·√mm]", edge.k_t_range, k_t_range, 0.005),
        Row(f"slip zone d {edge.front}, half cycle 1 [mm]", backward.length, slip, 0.01),
        Row(f"slip zone d {edge.front}, half cycle 2 [mm]", forward.length, slip, 0.01),
        # The formula is the leading term in d/a = 0.13: about d/(2 a) too short.
        Row(f"d by ΔK_T/(f K_N) {edge.front} [mm]", forward.predicted, slip, 0.08),
    ]
finish(rows)
