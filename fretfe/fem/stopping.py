# SPDX-License-Identifier: LGPL-3.0-or-later
"""Signals that end a run, whichever of its ranks they come to. Collective."""

from __future__ import annotations

import signal

from fretfe.backends import Observer
from fretfe.fem._compat import MPI

# Of the messages that carry a signal to rank 0.
TAG = 143


class SharedStop(Observer):
    """Observer on rank 0 that is told of signals to other ranks too, while these wait for it.

    All ranks make one and close it.

    Args:
        comm: communicator.
        observer: that of this rank; says which signal came to it.
    """

    def __init__(self, comm: MPI.Comm, observer: Observer) -> None:
        self._comm = comm
        self._observer = observer
        self._sent: MPI.Request | None = None
        self._received: dict[int, signal.Signals] = {}

    def step(self, number: int, count: int, text: str) -> None:
        """Pass a step on."""
        self._observer.step(number, count, text)

    def announce(self, text: str) -> None:
        """Pass a text on."""
        self._observer.announce(text)

    def send(self) -> None:
        """Tell rank 0 of a signal to this rank, once."""
        number = self._observer.stop()
        if self._sent is None and number is not None:
            self._sent = self._comm.isend(int(number), 0, TAG)

    def stop(self) -> signal.Signals | None:
        """Return the signal that came to this rank, or to another one; on rank 0."""
        status = MPI.Status()
        while self._comm.iprobe(tag=TAG, status=status):
            self._receive(status.source)
        return self._observer.stop() or next(iter(self._received.values()), None)

    def close(self) -> None:
        """Take messages that are still on their way. Collective."""
        senders = self._comm.gather(self._sent is not None)
        for rank, sent in enumerate(senders or ()):
            if sent and rank not in self._received:
                self._receive(rank)
        if self._sent is not None:
            self._sent.wait()

    def _receive(self, rank: int) -> None:
        self._received[rank] = signal.Signals(self._comm.recv(source=rank, tag=TAG))


def agreed_stop(comm: MPI.Comm, observer: Observer) -> signal.Signals | None:
    """The signal that came to any rank so far, the same on all ranks. Collective."""
    return next((each for each in comm.allgather(observer.stop()) if each is not None), None)
