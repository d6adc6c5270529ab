# SPDX-License-Identifier: LGPL-3.0-or-later
"""Groups of ranks, one for each body: bodies meet only at the contact nodes.

Two bodies on two ranks are factorised side by side, each by one process. Only where there are more
ranks than bodies does a group have several; where there are fewer, a group has several bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from fretfe.errors import FretfeError
from fretfe.fem._compat import MPI

T = TypeVar("T")

# Splitting a communicator costs one of a limited number of them: splits are kept.
_SPLITS: dict[tuple[int, tuple[int, ...]], MPI.Comm] = {}


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


def share_out(work: Sequence[float], ranks: int) -> list[tuple[tuple[int, ...], int]]:
    """Bodies and number of ranks of each group, so that the busiest rank has as little as possible.

    Args:
        work: of each body.
        ranks: number of all ranks.
    """
    if ranks >= len(work):
        shares = np.ones(len(work), dtype=np.int64)
        for _ in range(ranks - len(work)):
            shares[np.argmax(np.array(work) / shares)] += 1
        return [((body,), int(share)) for body, share in enumerate(shares)]
    groups: list[list[int]] = [[] for _ in range(ranks)]
    for body in np.argsort(work, kind="stable")[::-1]:
        least = min(groups, key=lambda group: sum(work[each] for each in group))
        least.append(int(body))
    return [(tuple(sorted(group)), 1) for group in groups]


def _split(comm: MPI.Comm, colours: tuple[int, ...]) -> MPI.Comm:
    if len(set(colours)) == 1:
        return comm
    key = comm.py2f(), colours
    if key not in _SPLITS:
        _SPLITS[key] = comm.Split(colours[comm.rank], comm.rank)
    return _SPLITS[key]


def together(comm: MPI.Comm, work: Callable[[], T]) -> T:
    """Do work in all groups; an error in one of them is raised on every rank. Collective."""
    result: T | None = None
    failure: FretfeError | None = None
    try:
        result = work()
    except FretfeError as error:
        failure = error
    failures = [each for each in comm.allgather(failure) if each is not None]
    if failures:
        raise failures[0]
    assert result is not None
    return result
