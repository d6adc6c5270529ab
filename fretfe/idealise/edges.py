# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where the edges of the half-plane contact are, and K_N there, in every state."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from fretfe.analytic.profiles import edge_factor_k_n
from fretfe.analytic.rocking import TiltedContact, tilted_contact
from fretfe.idealise.problem import HalfPlaneProblem


def contact_edges(problem: HalfPlaneProblem) -> TiltedContact:
    """(T,) positions of both edges, tilt, and K_N at both edges; NaN in states without contact."""
    loaded = problem.normal_force > 0
    force, moment = problem.normal_force[loaded], problem.moment[loaded]
    if np.any(moment != 0):
        contact = tilted_contact(problem.profile, force, moment)
    else:
        a = problem.profile.half_width(force)
        k_n = edge_factor_k_n(problem.profile, a)
        contact = TiltedContact(-a, a, np.zeros_like(a), k_n, k_n)
    parts = np.full((len(fields(TiltedContact)), len(loaded)), np.nan)
    for part, field in zip(parts, fields(TiltedContact), strict=True):
        part[loaded] = getattr(contact, field.name)
    return TiltedContact(*parts)


def governing_length(problem: HalfPlaneProblem, half_width: float) -> float:
    """Length over which the edge description holds: a, or a - b of a flat-and-rounded profile."""
    inner = [kink for kink in problem.profile.kinks if kink < half_width]
    return half_width - max(inner, default=0.0)
