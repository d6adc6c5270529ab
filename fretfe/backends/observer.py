# SPDX-License-Identifier: LGPL-3.0-or-later
"""Observers follow a run and may end it early."""

from __future__ import annotations

import signal


class Observer:
    """Follows a run without a word: override what is of interest.

    All methods are called on process 0, and only there; `stop` also on the others.
    """

    def step(self, number: int, count: int, text: str) -> None:
        """Note a finished step: its number from 1, the number of steps, and a text about it."""

    def phase(self, text: str) -> None:
        """Note that one of several runs begins, such as a companion run of `validate`."""

    def announce(self, text: str) -> None:
        """Note what begins or has ended besides steps: a mesh, a case of a sweep."""

    def stop(self) -> signal.Signals | None:
        """Return the signal by which a run is to end after the step that was just noted.

        Everything that was computed is kept, and the run ends with a `StoppedError`.
        """
        return None


class StopOnly(Observer):
    """Says nothing, but ends a run when another observer does; on processes other than 0.

    Args:
        observer: the other one.
    """

    def __init__(self, observer: Observer) -> None:
        self._observer = observer

    def stop(self) -> signal.Signals | None:
        """Return the signal that the other one was told of."""
        return self._observer.stop()


SILENT = Observer()
