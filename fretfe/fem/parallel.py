# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ranks: groups of them for bodies, work of one for all, an end that all know. Collective."""

from __future__ import annotations

import gc
import math
import os
import signal
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from types import TracebackType
from typing import Generic, Literal, TypeVar, overload

import dolfinx.mesh
import numpy as np

from fretfe.backends import Observer
from fretfe.contact import dense
from fretfe.environment import memory_shortage, threads_asked_for
from fretfe.errors import FretfeError, MemoryShortError
from fretfe.faults import CollectiveError, note_fault, said, trace_of
from fretfe.fem._compat import MPI, PETSc
from fretfe.mesh.shares import share_out

T = TypeVar("T")
Subject = TypeVar("Subject")

# How long waiting ranks sleep before they look again (s), and as a part of their waiting so far.
LONGEST_SLEEP = 0.005
SLEEP_FRACTION = 0.1
# How long a rank with an error waits for the others to come to the same place: so long (s), and
# so many times what its work took. Those that wait for this one never come.
LEAST_PATIENCE = 10.0
PATIENCE = 5.0
# Splitting a communicator costs one of a limited number of them: splits are kept.
_SPLITS: dict[tuple[int, tuple[int, ...]], MPI.Comm] = {}
# Copies of communicators on which ranks agree upon errors: what an error has left unfinished on the
# communicator itself is not taken for that.
_AGREEING: dict[int, MPI.Comm] = {}
# Of the messages that carry a signal to rank 0.
TAG = 143


def _nothing() -> None:
    """Wait without doing anything."""


@overload
def on_root(comm: MPI.Comm, work: Callable[[], T]) -> T: ...


@overload
def on_root(comm: MPI.Comm, work: Callable[[], T], *, share: Literal[False]) -> T | None: ...


def on_root(comm: MPI.Comm, work: Callable[[], T], *, share: bool = True) -> T | None:
    """Do `work` on rank 0 and give its result to all ranks. Collective.

    An error that `work` raises on rank 0 ends it on every rank, with the same message.

    Args:
        comm: communicator.
        work: takes no argument; called on rank 0 only.
        share: whether the other ranks get the result, or None.
    """
    return Lead(comm, None).run(work, share=share)


@dataclass(frozen=True)
class _End(Generic[T]):
    """The result of what rank 0 did alone, or the reason why there is none."""

    result: T | None = None
    failure: FretfeError | None = None


class RankError(Exception):
    """An error of fretfe on another rank; a note has its traceback."""


class Lead(Generic[Subject]):
    """Rank 0 works alone, the others wait; all do together what rank 0 asks them for meanwhile.

    So what only rank 0 has to do reads as if there were no other ranks.

    Args:
        comm: communicator; all ranks make one.
        subject: what this rank has that questions are about.
        waiting: called by the other ranks again and again while they wait.
    """

    def __init__(
        self, comm: MPI.Comm, subject: Subject, waiting: Callable[[], None] = _nothing
    ) -> None:
        self._comm, self._subject, self._waiting = comm, subject, waiting
        _agreeing(comm)

    @overload
    def run(self, work: Callable[[], T]) -> T: ...

    @overload
    def run(self, work: Callable[[], T], *, share: bool) -> T | None: ...

    def run(self, work: Callable[[], T], *, share: bool = True) -> T | None:
        """Do `work` on rank 0, which may ask for something; as `on_root`. Collective."""
        if self._comm.rank > 0:
            end: _End[T] = self._follow()
        else:
            try:
                end = _End(work())
            except FretfeError as error:
                end = _End(failure=error)
            except Exception as error:
                # Of a `CollectiveError` others do not know: they wait for something else.
                if self._comm.size == 1 or isinstance(error, CollectiveError):
                    raise
                end = _End(failure=_end_of_all(error))
            self._tell(end if share else replace(end, result=None))
        if end.failure is not None:
            raise end.failure
        return end.result

    def ask(self, question: Callable[..., T], **own: object) -> T:
        """Have all ranks put a question to their subjects; on rank 0, in the work of `run`.

        Args:
            question: called with the subject of each rank; collective there.
            own: further arguments, on rank 0 only.
        """
        self._tell(question)
        return agreed(self._comm, lambda: question(self._subject, **own))

    def _tell(self, message: object) -> None:
        _wait_for_all(self._comm, _nothing)
        self._comm.bcast(message)

    def _follow(self) -> _End[T]:
        """Answer what rank 0 asks for, until its work has come to its end."""
        while True:
            _wait_for_all(self._comm, self._waiting)
            message = self._comm.bcast(None)
            if isinstance(message, _End):
                return message
            # Raised on rank 0 as well, which decides what follows from it.
            with suppress(FretfeError, RankError):
                agreed(self._comm, partial(message, self._subject))


def use_waiting_cores(comm: MPI.Comm) -> None:
    """Have rank 0 work on large matrices with the cores of ranks that wait for it. Collective.

    A launcher may have given each rank a core of its own: rank 0 may use them all.
    """
    allowed = getattr(os, "sched_getaffinity", None)  # Linux
    own = MPI.Get_processor_name(), allowed(0) if allowed else set()
    ranks = comm.allgather(own)
    beside = [cores for name, cores in ranks if name == ranks[0][0]]
    if comm.rank == 0:
        cores = set().union(*beside)
        if cores:
            os.sched_setaffinity(0, cores)
        count = min(len(beside), len(cores) or len(beside))
        dense.use_threads(count // (threads_asked_for() or 1))  # of which each would have its own


def _agreeing(comm: MPI.Comm) -> MPI.Comm:
    """The copy of a communicator for errors. Collective when it is asked for first."""
    key = comm.py2f()
    if key not in _AGREEING:
        _AGREEING[key] = comm.Dup()
    return _AGREEING[key]


def together(comm: MPI.Comm, work: Callable[[], T]) -> T:
    """Do `work` on all ranks; an error of one ends it on all, with the same message. Collective."""
    try:
        return agreed(comm, work)
    except RankError as error:
        raise _end_of_all(error) from error


def agreed(comm: MPI.Comm, work: Callable[[], T]) -> T:
    """Do `work` on all ranks; an error of one is raised on all once all have ended it. Collective.

    Raises:
        FretfeError: the first one.
        RankError: if fretfe failed on a rank; on one rank alone its error itself.
        CollectiveError: if fretfe failed here, and others do not come: they wait in the middle.
    """
    if comm.size == 1:
        return work()
    agreeing = _agreeing(comm)
    begin, results, error = time.perf_counter(), list[T](), None
    try:
        results.append(work())
    except Exception as caught:
        error = caught
    patience = LEAST_PATIENCE + PATIENCE * (time.perf_counter() - begin)
    if not _wait_for_all(agreeing, _nothing, math.inf if error is None else patience):
        reason = "" if error is None else said(error)
        raise CollectiveError(f"rank {comm.rank}, which others wait for: {reason}") from error
    told = agreeing.allgather(None if error is None else _for_others(comm.rank, error))
    if failures := [each for each in told if each is not None]:
        raise failures[0] from error
    return results[0]


def _for_others(rank: int, error: Exception) -> FretfeError | RankError:
    """Return the error that other ranks raise for one of this rank."""
    if isinstance(error, FretfeError):
        return error
    if shortage := memory_shortage(error):
        return MemoryShortError(shortage)
    told = RankError(f"rank {rank}: {said(error)}")
    told.add_note(trace_of(error))
    return told


def _end_of_all(error: Exception) -> FretfeError:
    """Return the error that all ranks raise for one of fretfe on rank 0; its traceback is kept."""
    if shortage := memory_shortage(error):
        return MemoryShortError(shortage)
    fault = note_fault("run", said(error), trace_of(error))
    return FretfeError(
        f"{fault.reason}. The steps that were solved are kept: --resume goes on from them"
    )


def _wait_for_all(comm: MPI.Comm, waiting: Callable[[], None], limit: float = math.inf) -> bool:
    """Until all ranks come here too, or so many seconds; True if they have come.

    MPI's own waiting takes a core, which the work may need.
    """
    start = time.perf_counter()
    arrival = comm.Ibarrier()
    while not arrival.Test():
        if time.perf_counter() - start > limit:
            return False
        waiting()
        time.sleep(min(LONGEST_SLEEP, SLEEP_FRACTION * (time.perf_counter() - start)))
    return True


def release(meshes: list[dolfinx.mesh.Mesh]) -> None:
    """Destroy the PETSc objects of meshes whose models nobody refers to any more. Collective.

    On several ranks PETSc keeps what Python has dropped, each object with a communicator, until it
    is told to let go. MPI has a limited number of communicators: without this, a program that
    solves many cases one after the other ends after about eighty.
    """
    if MPI.COMM_WORLD.size == 1:  # destroyed at once
        return
    gc.collect()
    for mesh in meshes:
        PETSc.garbage_cleanup(mesh.comm)


@dataclass(frozen=True)
class Group:
    """The group that this rank belongs to.

    Attributes:
        comm: its ranks, in the order of the world.
        bodies: numbers of its bodies.
        roots: for each of all bodies: rank 0 of its group, as the world counts.
    """

    comm: MPI.Comm
    bodies: tuple[int, ...]
    roots: tuple[int, ...]


def find_group(comm: MPI.Comm, work: Sequence[float]) -> Group:
    """The group of this rank. Collective.

    Args:
        comm: all ranks.
        work: of each body, the same on all ranks.
    """
    groups = share_out(work, comm.size)
    colours = tuple(number for number, (_, ranks) in enumerate(groups) for _ in range(ranks))
    first = np.concatenate([[0], np.cumsum([ranks for _, ranks in groups])])
    roots = {body: int(first[n]) for n, (bodies, _) in enumerate(groups) for body in bodies}
    return Group(
        comm=_split(comm, colours),
        bodies=groups[colours[comm.rank]][0],
        roots=tuple(roots[body] for body in range(len(work))),
    )


def _split(comm: MPI.Comm, colours: tuple[int, ...]) -> MPI.Comm:
    if len(set(colours)) == 1:
        return comm
    key = comm.py2f(), colours
    if key not in _SPLITS:
        _SPLITS[key] = comm.Split(colours[comm.rank], comm.rank)
    return _SPLITS[key]


class SharedStop(Observer):
    """Observer on rank 0 that is told of signals to other ranks too, while these wait for it.

    A context that all ranks enter and leave, unless what ends it ends the whole run.

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

    def doing(self, text: str) -> None:
        """Pass on what takes long."""
        self._observer.doing(text)

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

    def __enter__(self) -> SharedStop:
        """Nothing but itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Take messages that are still on their way. Collective."""
        # Errors of other kinds are raised on one rank alone.
        if error is None or isinstance(error, FretfeError):
            self._close()

    def _close(self) -> None:
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
