# SPDX-License-Identifier: LGPL-3.0-or-later
"""The processes that a backend runs on."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from fretfe.backends.protocol import Backend, ParallelBackend, Processes
from fretfe.environment import rank_from_environment

T = TypeVar("T")


class OneProcess:
    """A backend that runs on one process; others that a launcher started have nothing to do."""

    @property
    def rank(self) -> int:
        """Number of this process, as the launcher announces it."""
        return rank_from_environment()

    def on_root(self, work: Callable[[], T]) -> T:
        """Do `work`."""
        return work()


def processes_of(backend: Backend | None) -> Processes:
    """Return the processes that a backend runs on; one if it cannot be used."""
    return backend.processes if isinstance(backend, ParallelBackend) else OneProcess()
