# SPDX-License-Identifier: LGPL-3.0-or-later
"""Work that one rank does for all, with errors raised on all ranks alike."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from fretfe.errors import FretfeError
from fretfe.fem._compat import MPI

T = TypeVar("T")


def on_root(comm: MPI.Comm, work: Callable[[], T], *, share: bool = True) -> T | None:
    """Do `work` on rank 0 and give its result to all ranks. Collective.

    A `FretfeError` that `work` raises on rank 0 is raised on every rank; any other exception is
    raised on rank 0 only and has to end the whole run.

    Args:
        comm: communicator.
        work: takes no argument; called on rank 0 only.
        share: whether the other ranks get the result, or None.
    """
    result: T | None = None
    failure: FretfeError | None = None
    if comm.rank == 0:
        try:
            result = work()
        except FretfeError as error:
            failure = error
    failure = comm.bcast(failure)
    if failure is not None:
        raise failure
    return comm.bcast(result) if share else result
