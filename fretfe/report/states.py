# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which states and nodes the plots of a contact show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from fretfe.backends import EdgeHistories
from fretfe.evaluate import ContactSummary, Edge, SlipZone
from fretfe.reading import Results
from fretfe.solution import ContactHistory

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Shown:
    """A contact to be drawn.

    Attributes:
        results: the run.
        summary: of the contact.
        history: its tractions.
        key: starts the ids of its plots.
    """

    results: Results
    summary: ContactSummary
    history: ContactHistory
    key: str

    @property
    def name(self) -> str:
        """The contact and its bodies."""
        return f"Contact {self.summary.name} ({self.history.body1} on {self.history.body2})"


def span(result: EdgeHistories) -> tuple[int, int]:
    """First and last state of the evaluated cycle, or of everything."""
    return result.history.cycle or (0, len(result.history.times) - 1)


def edge_extremes(result: EdgeHistories, edge: Edge) -> list[int]:
    """States in which K_T is smallest and largest in the cycle, in time order; the last if equal.

    Without a cycle the one in which it is largest in magnitude, and the last.
    """
    first, last = span(result)
    k_t = edge.k_t[first : last + 1]
    if not np.ptp(k_t) > 0:
        return [last]
    if result.history.cycle is None:
        return sorted({int(np.argmax(np.abs(k_t))), last})
    return sorted({first + int(np.argmax(k_t)), first + int(np.argmin(k_t))})


def around_contact(history: ContactHistory, state: int) -> npt.NDArray[np.bool_]:
    """Nodes of the contact at a state and a little beyond; all of them without contact."""
    closed = history.arc[history.traction[state, :, 0] > 0]
    if not len(closed):
        return np.ones(len(history.arc), dtype=bool)
    margin = 0.05 * np.ptp(closed)
    return (history.arc >= closed[0] - margin) & (history.arc <= closed[-1] + margin)


def time_text(results: Results, state: int) -> str:
    """The time of a state."""
    return f"t = {results.result.history.times[state]:g} {results.case.units.time}"


def prediction(zone: SlipZone) -> float:
    """What a slip zone is compared with: (11) of the theory guide in a cycle, else (8) or (9)."""
    return zone.predicted_loop if np.isfinite(zone.predicted_loop) else zone.predicted
