# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ranks shared out among bodies."""

from __future__ import annotations

import pytest

from fretfe.errors import ModelError
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import find_group, together
from fretfe.mesh.shares import share_out


@pytest.mark.parametrize(
    ("work", "ranks", "groups"),
    [
        ((3.0, 2.0), 1, [((0, 1), 1)]),
        ((3.0, 2.0), 2, [((0,), 1), ((1,), 1)]),
        ((3.0, 2.0), 3, [((0,), 2), ((1,), 1)]),
        ((1.0, 8.0), 4, [((0,), 1), ((1,), 3)]),
        # The largest body alone, the others together.
        ((2.0, 5.0, 2.0), 2, [((1,), 1), ((0, 2), 1)]),
        ((1.0, 1.0, 1.0), 5, [((0,), 2), ((1,), 2), ((2,), 1)]),
    ],
)
def test_bodies_and_ranks_of_groups(
    work: tuple[float, ...], ranks: int, groups: list[tuple[tuple[int, ...], int]]
) -> None:
    assert share_out(work, ranks) == groups


@pytest.mark.mpi
def test_every_body_has_one_group_and_every_rank_is_in_one() -> None:
    comm = MPI.COMM_WORLD
    group = find_group(comm, (1.0, 2.0, 3.0))
    firsts = comm.allgather(group.bodies if group.comm.rank == 0 else ())
    assert sorted(body for bodies in firsts for body in bodies) == [0, 1, 2]
    for body, root in enumerate(group.roots):
        assert body in firsts[root]
    # The same split again takes no other communicator.
    assert find_group(comm, (1.0, 2.0, 3.0)).comm is group.comm


@pytest.mark.mpi
def test_an_error_in_one_group_is_raised_on_all_ranks() -> None:
    comm = MPI.COMM_WORLD

    def work() -> int:
        if comm.rank == comm.size - 1:
            raise ModelError("this body is too large")
        return comm.rank

    with pytest.raises(ModelError, match="this body is too large"):
        together(comm, work)
    assert together(comm, lambda: comm.rank) == comm.rank
