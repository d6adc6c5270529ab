# SPDX-License-Identifier: LGPL-3.0-or-later
"""Work done by one rank for all, and collective release of PETSc objects."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from typing import Literal, TypeVar, overload

import dolfinx.mesh

from fretfe.errors import FretfeError
from fretfe.fem._compat import MPI, PETSc

T = TypeVar("T")

# How long waiting ranks sleep before they look again (s), and as a part of their waiting so far.
LONGEST_SLEEP, SLEEP_FRACTION = 0.005, 0.1


def _nothing() -> None:
    """Wait without doing anything."""


@overload
def on_root(comm: MPI.Comm, work: Callable[[], T]) -> T: ...


@overload
def on_root(
    comm: MPI.Comm,
    work: Callable[[], T],
    *,
    share: Literal[False],
    waiting: Callable[[], None] = _nothing,
) -> T | None: ...


def on_root(
    comm: MPI.Comm,
    work: Callable[[], T],
    *,
    share: bool = True,
    waiting: Callable[[], None] = _nothing,
) -> T | None:
    """Do `work` on rank 0 and give its result to all ranks. Collective.

    A `FretfeError` that `work` raises on rank 0 is raised on every rank; any other exception is
    raised on rank 0 only and has to end the whole run.

    Args:
        comm: communicator.
        work: takes no argument; called on rank 0 only.
        share: whether the other ranks get the result, or None.
        waiting: called by the other ranks again and again while they wait.
    """
    result: T | None = None
    failure: FretfeError | None = None
    if comm.rank == 0:
        try:
            result = work()
        except FretfeError as error:
            failure = error
    _wait_for_root(comm, waiting)
    failure = comm.bcast(failure)
    if failure is not None:
        raise failure
    return comm.bcast(result) if share else result


def _wait_for_root(comm: MPI.Comm, waiting: Callable[[], None]) -> None:
    """Until rank 0 comes here too. MPI's own waiting takes a core, which the work may need."""
    start = time.perf_counter()
    arrival = comm.Ibarrier()
    while not arrival.Test():
        waiting()
        time.sleep(min(LONGEST_SLEEP, SLEEP_FRACTION * (time.perf_counter() - start)))


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
