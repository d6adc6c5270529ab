# SPDX-License-Identifier: LGPL-3.0-or-later
"""The exceptions that fretfe raises for a user's mistake or a run that cannot be finished.

Each class carries the exit code that the command line returns for it. Every message says what was
expected, what was found, and where (file and key, or step and iteration).
"""

from __future__ import annotations

import signal


class FretfeError(Exception):
    """Base class of all errors that are reported without a traceback."""

    exit_code = 1


class CaseError(FretfeError):
    """The case file, or a table it names, is not valid."""

    exit_code = 2


class MeshError(FretfeError):
    """The geometry cannot be meshed, or the mesh does not hold what the case names."""

    exit_code = 3


class ModelError(FretfeError):
    """The model is not well posed: a body that nothing holds, surfaces that never meet."""

    exit_code = 4


class ConvergenceError(FretfeError):
    """A load step has no solution, or none was found; earlier steps are kept."""

    exit_code = 5


class StoppedError(ConvergenceError):
    """The process was asked to end by a signal; the steps before are kept.

    Args:
        number: the signal.
        where: the history was stopped, in words.
    """

    def __init__(self, number: signal.Signals, where: str) -> None:
        super().__init__(f"stopped by {number.name} {where}")
        self.signal = number
        self.exit_code = 128 + number  # as shells have it
        self._arguments = (number, where)

    def __reduce__(self) -> tuple[type[StoppedError], tuple[signal.Signals, str]]:
        """Say how a copy on another rank is made."""
        return StoppedError, self._arguments


class OutputError(FretfeError):
    """Results cannot be written or read."""

    exit_code = 6


class MemoryShortError(FretfeError):
    """There is not enough memory."""

    exit_code = 8


class FaultError(FretfeError):
    """Something is unknown because of an error of fretfe itself; all else is there."""

    exit_code = 9


class DependencyError(FretfeError):
    """A library that the chosen operation needs is not installed or does not load."""

    exit_code = 7
