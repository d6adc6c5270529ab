# SPDX-License-Identifier: LGPL-3.0-or-later
"""A backend for `fretfe` that lives in a package of its own: a formula for the slip length.

The slip length d1 that `fretfe` predicts from the edge factors is the first term of an expansion in
d/a. Under a shear force alone the Hertz contact (Cattaneo, Mindlin) has d = a - sqrt(a^2 - 2 a d1),
hence with the next term

    d = d1 + d1^2/(2a)          d1 = change of K_T/(f K_N), twice that for first loading

with a relative error of about (d/a)^2/2 in place of d/(2a). (`halfplane` solves the whole problem.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fretfe.analytic.profiles import Hertz
from fretfe.backends.halfplane import BACKEND as HALF_PLANES
from fretfe.backends.protocol import DEFAULTS, Backend, RunOptions
from fretfe.case import Case
from fretfe.evaluate.contacts import Contact, Station, fronts_of
from fretfe.evaluate.slip import SlipBorder, cycle_states, slip_zones
from fretfe.idealise import HalfPlaneProblem, NotIdealisable, idealise, obstacles
from fretfe.results.model import Result


class TwoTerms(Backend):
    """Hertz contacts under a constant normal force and a shear force."""

    summary = "Hertz under a shear force: slip lengths from two terms of their expansion"

    def supports(self, case: Case) -> tuple[str, ...]:
        """Reasons why the formula does not hold for a case; empty if it does."""
        return obstacles(case) or tuple(_outside(idealise(case)))

    def solve(self, case: Case, options: RunOptions = DEFAULTS) -> Result:
        """Solve a case: slip lengths by the formula, half-planes for the rest."""
        if reasons := self.supports(case):
            raise NotIdealisable(case, list(reasons))
        result, problem = HALF_PLANES.solve(case, options), idealise(case, options.history)
        (contact,) = result.contacts
        stations = (_with_formula(each, contact, problem) for each in contact.stations)
        return replace(
            result,
            contacts=(replace(contact, fronts=fronts_of(stations)),),
            notes=(*result.notes, "slip lengths by: two terms of the expansion in d/a"),
        )


def _outside(problem: HalfPlaneProblem) -> Iterator[str]:
    """What the formula does not know of."""
    if not isinstance(problem.profile, Hertz):
        yield f"geometry: expected a Hertz contact, found {type(problem.profile).__name__}"
    if np.any(problem.bulk_tension) or np.any(problem.moment):
        yield "loads: expected no bulk tension and no moment"
    frictional = problem.normal_force[problem.friction > 0]
    if len(frictional) and np.ptp(frictional) > 1e-9 * frictional.max():
        yield "loads: expected a constant normal force as soon as there is friction"


def _with_formula(station: Station, contact: Contact, problem: HalfPlaneProblem) -> Station:
    """The station with slip zones by the formula; `slip_zones` finds the half cycles."""

    def find(start: int, end: int) -> SlipBorder:
        change = abs(station.k_t[end] - station.k_t[start])
        first_loading = problem.friction[start] == 0
        d1 = (2 if first_loading else 1) * change / (problem.friction[end] * station.k_n[end])
        length = d1 + d1**2 / (2 * contact.half_width[end])
        return SlipBorder(float(length), resolved=True, gross=False)

    zones = slip_zones(cycle_states(problem.history.cycle), problem.friction, station, find)
    return replace(station, slip_zones=zones)


BACKEND = TwoTerms()
