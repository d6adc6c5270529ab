# SPDX-License-Identifier: LGPL-3.0-or-later
"""The states of a history whose tractions are kept in the results."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Indices
from fretfe.evaluate.contacts import ContactSummary
from fretfe.evaluate.resultants import load_extremes, shear_extremes
from fretfe.evaluate.slip import cycle_states
from fretfe.history.solution import Solution
from fretfe.results.model import Result

# Histories of more states are long: their tractions are not all kept unless the case asks for that,
# and lists of more numbers do not stand in the text of the results.
LONG = 1000
# Half cycles whose ends are kept: those whose slip zones are printed.
HALF_CYCLES = 2


def kept_states(result: Result, solution: Solution) -> Indices:
    """(K,) states whose tractions the case wants to keep, increasing.

    Args:
        result: the run, evaluated.
        solution: its solution.
    """
    if solution.kept is not None:
        return solution.kept
    count = len(solution.times)
    wanted = result.case.output.tractions or ("all" if count <= LONG else "cycle")
    if wanted == "all":
        return np.arange(count)
    starts = {max(int(np.argmax(each.friction > 0)) - 1, 0) for each in solution.contacts}
    states = _extremes(result.contacts, solution.cycle) | starts | {0, count - 1}
    if result.areas and count > 1:
        states |= set(shear_extremes(result.areas, solution.cycle))
    if wanted == "cycle":
        states |= set(cycle_states(solution.cycle).tolist())
    # What moved in the step to a state tells what slipped there.
    before = {max(state - 1, 0) for state in states}
    return np.array(sorted(states | before))


def _extremes(contacts: tuple[ContactSummary, ...], cycle: tuple[int, int] | None) -> set[int]:
    """Load extremes of all edges together, of each contact and of each edge; ends of slip zones."""
    edges = [[edge] for contact in contacts for edge in contact.stations]
    together = [list(contact.stations) for contact in contacts]
    groups = [*edges, *together, [edge for (edge,) in edges]]
    states = {
        state
        for group in groups
        if group
        for state in load_extremes([e.k_t for e in group], [e.k_i for e in group], cycle)
    }
    zones = [zone for (edge,) in edges for zone in edge.slip_zones[-HALF_CYCLES:]]
    return states | {state for zone in zones for state in (zone.start, zone.end)}
