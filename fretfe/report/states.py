# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which states and nodes the plots of a contact show."""

from __future__ import annotations

from dataclasses import dataclass

from fretfe.backends import EdgeHistories
from fretfe.edges.front import ContactSummary
from fretfe.results.reader import Results
from fretfe.results.solution import ContactHistory


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


def time_text(results: Results, state: int) -> str:
    """The time of a state."""
    return f"t = {results.result.history.times[state]:g} {results.case.units.time}"
