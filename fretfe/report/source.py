# SPDX-License-Identifier: LGPL-3.0-or-later
"""A run as its figures, pictures and page see it: all that they take from a results folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import fill

import numpy as np

from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.resultants import load_extremes
from fretfe.history.solution import ContactHistory
from fretfe.results.model import Result

# More loads than this are not named in a title.
MOST_LOADS = 3
# Characters in a line of a title.
TITLE = 38
# Names of the fronts of plane contacts.
SIDES = ("left", "right")
# Waves pass through zero up to this fraction of their amplitude.
ROUND_OFF = 1e-12


def folder_of(run: Result) -> Path:
    """The folder that a run was read from."""
    assert run.directory is not None
    return run.directory


def extremes(run: Result) -> list[int]:
    """The load extremes of all contacts together."""
    return load_extremes(run.contacts, run.loads.cycle)


def when(run: Result, state: int) -> str:
    """The time of a state, with its unit."""
    return f"t = {run.loads.times[state]:.6g} {run.case.units.time}"


def loading(run: Result, state: int) -> str:
    """The values of the loads at a state, in lines of a title, if they are not too many for one."""
    if len(run.loads.channels) > MOST_LOADS:
        return ""
    largest = np.abs(run.loads.values).max(axis=0)
    values = run.loads.values[state]
    shown = np.where(np.abs(values) > ROUND_OFF * largest, values, 0.0)
    pairs = zip(run.loads.channels, shown, strict=True)
    values = ", ".join(f"{name} = {value:.5g}" for name, value in pairs)
    return fill(values, TITLE, break_long_words=False, break_on_hyphens=False)


def state_title(run: Result, state: int) -> str:
    """The time of a state, and below it the values of the loads if they are not too many."""
    return "\n".join(filter(None, [when(run, state), loading(run, state)]))


def times_text(run: Result, states: Sequence[int]) -> str:
    """The times of some states in a sentence."""
    return " and ".join(when(run, state) for state in states)


@dataclass(frozen=True)
class Shown:
    """A contact to be drawn.

    Attributes:
        run: the run.
        summary: of the contact.
        tractions: its tractions, slips and statuses.
        key: starts the ids of its plots.
    """

    run: Result
    summary: Contact
    tractions: ContactHistory
    key: str

    @property
    def title(self) -> str:
        """The contact and its bodies."""
        return f"Contact {self.summary.name} ({self.tractions.body1} on {self.tractions.body2})"


def shown_contacts(run: Result) -> list[Shown]:
    """The contacts with their tractions."""
    pairs = zip(run.contacts, run.solution.contacts, strict=True)
    return [Shown(run, *pair, f"contact{number}") for number, pair in enumerate(pairs)]


def edge_title(edge: Station) -> str:
    """An edge, or a station of a front of solids, in titles and labels."""
    return f"{edge.front} edge" if edge.front in SIDES else f"{edge.front}, station {edge.number}"
