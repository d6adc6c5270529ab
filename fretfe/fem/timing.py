# SPDX-License-Identifier: LGPL-3.0-or-later
"""Wall time of the phases of a run, and which of them are told."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

# Phases that may take long, in the words of those who wait for them.
TOLD = {
    "mesh": "mesh",
    "condensation": "condensation of the bodies",
    "edge integrals": "edge factors",
    "evaluation": "evaluation of edges and slip zones",
    "local problems": "plane problems next to the fronts",
    "stress near the contacts": "stress near the contacts",
    "fields": "fields",
}


def _nothing(_: str) -> None:
    """Tell nobody."""


class Clock:
    """Accumulates wall time by phase.

    Args:
        say: told of phases that may take long when they begin.

    Attributes:
        seconds: wall time of each phase so far, in the order of their first start.
    """

    def __init__(self, say: Callable[[str], None] = _nothing) -> None:
        self.seconds: dict[str, float] = {}
        self._say = say

    @contextmanager
    def __call__(self, phase: str, of: str = "") -> Iterator[None]:
        """Count the time spent inside the context for `phase`, which may be one of several."""
        if phase in TOLD:
            self._say(f"{TOLD[phase]}{of and ': '}{of}")
        start = time.perf_counter()
        self.seconds.setdefault(phase, 0.0)
        try:
            yield
        finally:
            self.seconds[phase] += time.perf_counter() - start
