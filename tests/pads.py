# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that half-planes can stand for."""

from __future__ import annotations

# Hertz, R = 50, P = 600, steady shear of 60 = f P/4 from the first reversal on: 20 steps.
HERTZ = """
title = "Cylindrical pad on a flat block"
[geometry]
template = "cylinder"
parameters = { upper_radius = 50, upper_width = 12, lower_radius = 0, lower_width = 12 }
[bodies]
upper = { young = 210e3, poisson = 0.3 }
lower = { young = 210e3, poisson = 0.3 }
[contacts.main]
surface1 = "upper_contact"
surface2 = "lower_contact"
friction = 0.4
friction_from = 1.0
[supports]
base = { boundary = "lower_bottom", fix = ["x", "y"] }
[loads.press]
type = "platen"
boundary = "upper_top"
direction = "y"
control = "force"
history = [{ ramp = -600, until = 1, steps = 4 }]
[loads.shear]
type = "platen"
boundary = "upper_top"
direction = "x"
control = "force"
history = [
  { hold = true, until = 1 },
  { wave = "sine", amplitude = 60, period = 1, cycles = 2, steps_per_cycle = 8 },
]
"""
