# SPDX-License-Identifier: LGPL-3.0-or-later
"""Work of one rank for all: results, errors, and what the others do in the meantime."""

from __future__ import annotations

import time
from contextlib import nullcontext
from functools import partial
from pathlib import Path

import pytest

from fretfe.errors import ModelError
from fretfe.faults import CollectiveError, collecting, guarded
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import Lead, on_root

COMM = MPI.COMM_WORLD


@pytest.mark.mpi
def test_all_ranks_get_what_rank_0_has_made() -> None:
    assert on_root(COMM, lambda: [COMM.rank, "made"]) == [0, "made"]
    made = on_root(COMM, lambda: COMM.rank, share=False)
    assert made == (0 if COMM.rank == 0 else None)


@pytest.mark.mpi
def test_an_error_of_rank_0_is_raised_on_all() -> None:
    def fail() -> None:
        raise ModelError(f"rank {COMM.rank} says so")

    with pytest.raises(ModelError, match="rank 0 says so"):
        on_root(COMM, fail)


@pytest.mark.mpi
def test_ranks_that_wait_leave_the_cores_to_the_work() -> None:
    wall, used = time.perf_counter(), time.process_time()
    on_root(COMM, lambda: time.sleep(0.5))
    wall, used = time.perf_counter() - wall, time.process_time() - used
    assert wall > 0.49
    assert used < 0.3 * wall  # a rank that spins uses all of it; 2 % measured


class Part:
    """Of each rank, one more than its number."""

    def sum(self, times: int, less: int = 0) -> int:
        """Sum over all ranks, multiplied; `less` is known to rank 0 alone."""
        return int(COMM.allreduce(COMM.rank + 1)) * times - less

    def fail(self) -> None:
        """Fail on all ranks, after all have come here."""
        COMM.barrier()
        raise ModelError("no rank can do this")

    def crash(self) -> None:
        """Fail in a way that nobody has foreseen."""
        raise ZeroDivisionError


@pytest.mark.mpi
def test_all_ranks_answer_what_rank_0_asks_meanwhile() -> None:
    lead = Lead(COMM, Part())

    def work() -> list[int]:
        return [lead.ask(partial(Part.sum, times=n), less=1) for n in (1, 2)]

    whole = COMM.size * (COMM.size + 1) // 2
    assert lead.run(work) == [whole - 1, 2 * whole - 1]


@pytest.mark.mpi
def test_guards_hold_errors_of_rank_0_but_not_of_what_all_do(tmp_path: Path) -> None:
    """Others may wait in the middle of a question that fails; outside they wait for the next."""
    lead = Lead(COMM, Part())

    def work() -> int | None:
        guarded("alone", Part().crash, lambda _: None)
        return lead.ask(partial(Part.sum, times=2))

    with collecting(tmp_path) as found:
        assert lead.run(work) == COMM.size * (COMM.size + 1)
        assert len(found.faults) == (COMM.rank == 0)

        def question() -> None:
            guarded("together", lambda: lead.ask(Part.crash), lambda _: None)

        error = ZeroDivisionError if COMM.rank else CollectiveError
        with pytest.raises(error) if COMM.size > 1 else nullcontext():
            lead.run(question)


@pytest.mark.mpi
def test_rank_0_may_go_on_after_a_question_without_an_answer() -> None:
    lead = Lead(COMM, Part())

    def work() -> int:
        with pytest.raises(ModelError, match="no rank can do this"):
            lead.ask(Part.fail)
        return lead.ask(partial(Part.sum, times=2))

    assert lead.run(work) == COMM.size * (COMM.size + 1)
    with pytest.raises(ModelError, match="no rank can do this"):
        lead.run(lambda: lead.ask(Part.fail))
