# SPDX-License-Identifier: LGPL-3.0-or-later
"""An observer that remembers what it is told."""

from __future__ import annotations

import signal

from fretfe.backends import Observer


class Told(Observer):
    """Everything that happens, in order; ends a history after a number of steps."""

    def __init__(self, most_steps: int | None = None) -> None:
        self.steps: list[tuple[int, int, str]] = []
        self.phases: list[str] = []
        self.announced: list[str] = []
        self.done: list[str] = []
        self._most_steps = most_steps

    def step(self, number: int, count: int, text: str) -> None:
        self.steps.append((number, count, text))

    def phase(self, text: str) -> None:
        self.phases.append(text)

    def announce(self, text: str) -> None:
        self.announced.append(text)

    def doing(self, text: str) -> None:
        self.done.append(text)

    def stop(self) -> signal.Signals | None:
        return signal.SIGINT if len(self.steps) == self._most_steps else None
