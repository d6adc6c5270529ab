# SPDX-License-Identifier: LGPL-3.0-or-later
"""Two load levels next to a solved state, between which the edges move as K_N has it."""

from __future__ import annotations

from dataclasses import replace

from fretfe.contact.march import March
from fretfe.contact.newton import NotConverged
from fretfe.contact.state import ContactState, StepLoads

# The loads are raised and lowered by this fraction: edges move by some elements (2.5 % of a Hertz
# contact, 5 % of a wedge either way), and stay well inside the circle of an interaction integral.
FRACTION = 0.05


def neighbour_states(
    march: March, state: ContactState, loads: StepLoads
) -> tuple[ContactState, ContactState] | None:
    """States after all loads are lowered, and raised, by a fraction; None without a solution."""
    try:
        low, high = (
            march.advance(state, loads, _scaled(loads, 1 + change)).state
            for change in (-FRACTION, FRACTION)
        )
    except NotConverged:
        return None
    return low, high


def _scaled(loads: StepLoads, factor: float) -> StepLoads:
    return replace(loads, amplitudes=factor * loads.amplitudes, values=factor * loads.values)
