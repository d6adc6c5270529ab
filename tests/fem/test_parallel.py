# SPDX-License-Identifier: LGPL-3.0-or-later
"""Work of one rank for all: results, errors, and what the others do in the meantime."""

from __future__ import annotations

import os
import time
from functools import partial
from pathlib import Path

import pytest

from fretfe.contact import dense
from fretfe.environment import threads_asked_for
from fretfe.errors import FretfeError, ModelError
from fretfe.faults import FAULTS, CollectiveError, collecting, guarded
from fretfe.fem import parallel
from fretfe.fem._compat import MPI
from fretfe.fem.parallel import Lead, agreed, on_root, together, use_waiting_cores

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

    def crash_on(self, ranks: set[int]) -> None:
        """The same on some ranks alone."""
        if COMM.rank in ranks:
            self.crash()


@pytest.mark.mpi
def test_all_ranks_answer_what_rank_0_asks_meanwhile() -> None:
    lead = Lead(COMM, Part())

    def work() -> list[int]:
        return [lead.ask(partial(Part.sum, times=n), less=1) for n in (1, 2)]

    whole = COMM.size * (COMM.size + 1) // 2
    assert lead.run(work) == [whole - 1, 2 * whole - 1]


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [{0}, {1}, {0, 1}])
def test_guards_hold_errors_that_all_ranks_know_of(tmp_path: Path, ranks: set[int]) -> None:
    """In what rank 0 does alone, and in what all do, wherever it fails."""
    lead = Lead(COMM, Part())

    def work() -> int:
        guarded("alone", Part().crash, lambda _: None)
        guarded("together", lambda: lead.ask(partial(Part.crash_on, ranks=ranks)), lambda _: None)
        return lead.ask(partial(Part.sum, times=2))

    with collecting(tmp_path) as found:
        assert lead.run(work) == COMM.size * (COMM.size + 1)
    fails = min(ranks) < COMM.size
    places = ["alone", *["together"] * fails] if COMM.rank == 0 else []
    assert [fault.place for fault in found.faults] == places
    if COMM.rank == 0 and fails and COMM.size > 1:
        assert found.faults[1].error == f"RankError: rank {min(ranks)}: ZeroDivisionError"
        assert "in crash" in (tmp_path / FAULTS).read_text()


@pytest.mark.mpi
def test_errors_without_a_guard_end_all_ranks_with_one_message(tmp_path: Path) -> None:
    if COMM.size == 1:
        pytest.skip("one rank alone has its own traceback")
    with collecting(tmp_path), pytest.raises(FretfeError) as ended:
        Lead(COMM, Part()).run(Part().crash)
    assert COMM.allgather(str(ended.value)) == [str(ended.value)] * COMM.size
    assert "fretfe itself failed (ZeroDivisionError): please report" in str(ended.value)
    with pytest.raises(FretfeError, match=f"rank {COMM.size - 1}: ZeroDivisionError"):
        together(COMM, Part().crash if COMM.rank == COMM.size - 1 else lambda: None)


@pytest.mark.mpi
def test_a_rank_that_others_wait_for_does_not_wait_for_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Rank 0 is in the middle of the work, where it cannot be reached: the run has to end."""
    if COMM.size != 2:
        pytest.skip("made for two ranks")
    monkeypatch.setattr(parallel, "LEAST_PATIENCE", 0.1)
    twice = COMM.Dup()  # what is left waiting here is not waited for elsewhere
    Lead(twice, Part())
    if COMM.rank == 1:
        with pytest.raises(CollectiveError, match="others wait for: ZeroDivisionError"):
            agreed(twice, Part().crash)
    COMM.barrier()


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


@pytest.mark.mpi
def test_rank_0_works_with_the_cores_of_those_that_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    """One thread for each rank on its machine, as far as there are cores."""
    counts: list[int] = []
    monkeypatch.setattr(dense, "use_threads", counts.append)
    use_waiting_cores(COMM)
    cores = len(os.sched_getaffinity(0))
    threads = min(COMM.size, cores) // (threads_asked_for() or 1)
    assert counts == ([threads] if COMM.rank == 0 else [])
