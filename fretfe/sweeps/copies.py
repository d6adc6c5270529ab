# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that copies of this process solve beside one another, each with the model as it is.

A forked process has all that its parent has, and takes memory only for what it changes: a model of
condensed bodies serves as many histories at once as there are cores.
"""

from __future__ import annotations

import mmap
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from multiprocessing import connection, get_context
from multiprocessing.connection import Connection
from typing import TypeVar

from fretfe.backends import Observer
from fretfe.errors import StoppedError

T = TypeVar("T")
# Seconds after which is asked again whether the work is to end.
POLL = 0.1


class _FromParent(Observer):
    """Ends the work of a copy when the parent says so, or is no more.

    Args:
        parent: the process.
        order: number of the signal that it was told of, in memory of both; zero for none.
    """

    def __init__(self, parent: int, order: mmap.mmap) -> None:
        self._parent, self._order = parent, order

    def stop(self) -> signal.Signals | None:
        """Return the signal that the parent was told of."""
        if os.getppid() != self._parent:
            return signal.SIGTERM
        return signal.Signals(self._order[0]) if self._order[0] else None


def in_copies(
    shares: Sequence[Sequence[int]],
    solve: Callable[[int, Observer], T],
    stop: Callable[[], signal.Signals | None],
) -> Iterator[tuple[int, T]]:
    """Solve the cases of each share in a copy of this process; yield them as they are solved.

    Those of a copy that fails are left out.

    Args:
        shares: numbers of the cases of each copy.
        solve: solves one of them, heeding an observer.
        stop: tells which signal asks this process to end.

    Raises:
        StoppedError: if `stop` named a signal before all cases were solved.
    """
    context = get_context("fork")
    results: list[Connection] = []
    copies = []
    stopped: StoppedError | None = None
    order = mmap.mmap(-1, 1)
    try:
        for share in shares:
            result, far = context.Pipe(duplex=False)
            arguments = os.getpid(), order, far, share, solve
            copies.append(context.Process(target=_work, args=arguments, daemon=True))
            copies[-1].start()
            far.close()
            results.append(result)
        while results:
            for each in connection.wait(results, POLL):
                assert isinstance(each, Connection)
                try:
                    found = each.recv()
                except EOFError:
                    results.remove(each)
                    continue
                if isinstance(found, StoppedError):
                    stopped = found
                else:
                    yield found
            order[0] = order[0] or stop() or 0
    finally:
        for copy in copies:
            copy.kill()
            copy.join()
    if stopped is not None:
        raise stopped


def _work(
    parent: int,
    order: mmap.mmap,
    results: Connection,
    share: Sequence[int],
    solve: Callable[[int, Observer], object],
) -> None:
    """Solve the cases of a share in a process that `fork` has made."""
    # Signals to all processes of a terminal or a queue reach the parent too, which decides. PETSc
    # would make much of a parent that has gone.
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGPIPE):
        signal.signal(each, signal.SIG_IGN)
    observer = _FromParent(parent, order)
    try:
        for number in share:
            results.send((number, solve(number, observer)))
    except StoppedError as error:
        results.send(error)
    except Exception:
        return  # the parent does it again, and shows what is wrong
