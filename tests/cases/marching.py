# SPDX-License-Identifier: LGPL-3.0-or-later
"""Load histories solved step by step, each step as a whole however far edges move in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fretfe.contact.march import March, StepResult, not_converged
from fretfe.contact.newton import NotConverged
from fretfe.contact.state import StepLoads, unloaded


def march_through(march: March, steps: Sequence[StepLoads]) -> Iterator[StepResult]:
    """Solve steps one after the other; the first entry is the unloaded state."""
    state = unloaded(march.interface)
    for number in range(1, len(steps)):
        try:
            result = march.advance(state, steps[number - 1], steps[number])
        except NotConverged as failure:
            raise not_converged(number, len(steps) - 1, failure) from None
        yield result
        state = result.state
