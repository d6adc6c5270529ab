# SPDX-License-Identifier: LGPL-3.0-or-later
"""Feeds inputs to their commands and says what became of them.

Each input is read by a process that reads many, one after the other: quick, and one that crashes or
hangs is replaced.
"""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, Queue

from faults.fault import Fault

# A command that has not ended by then hangs.
LIMIT = 60.0
# What is right, and what is wrong.
GOOD = ("refused", "accepted")
BAD = ("traceback", "crash", "hang", "warning", "nonsense", "escaped")


@dataclass(frozen=True)
class Verdict:
    """What became of an input.

    Attributes:
        fault: the input.
        kind: one of `GOOD` or `BAD`.
        text: message of the command, or what is wrong.
        seconds: it took.
    """

    fault: Fault
    kind: str
    text: str
    seconds: float


class Reader:
    """A process that reads inputs by their number in the list of all."""

    def __init__(self, good: Path, arena: Path) -> None:
        self._good, self._arena = good, arena
        self._start()

    def _start(self) -> None:
        answers, answer_end = os.pipe()
        command = [sys.executable, "-m", "faults.worker", str(self._good), str(answer_end)]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            text=True,
            pass_fds=[answer_end],
            cwd=Path(__file__).parents[1],
            start_new_session=True,
        )
        os.close(answer_end)
        self._answers = os.fdopen(answers)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._answers, selectors.EVENT_READ)

    def judge(self, number: int, fault: Fault) -> Verdict:
        """Let the process read an input."""
        folder = self._arena / str(number)
        folder.mkdir()
        begin = time.monotonic()
        assert self._process.stdin is not None
        self._process.stdin.write(f"{number} {folder}\n")
        self._process.stdin.flush()
        # The first answer comes when the files are written and fretfe is imported.
        line = self._line(4 * LIMIT) and self._line(LIMIT)
        seconds = time.monotonic() - begin
        if line:
            kind, text = json.loads(line)
            return Verdict(fault, kind, text, seconds)
        ended = self._process.poll()
        self.close()
        self._start()
        if ended is None and seconds >= LIMIT:
            return Verdict(fault, "hang", f"no end after {seconds:.0f} s", seconds)
        return Verdict(fault, "crash", f"the process ended with {self._process_end}", seconds)

    def _line(self, limit: float) -> str:
        return self._answers.readline() if self._selector.select(limit) else ""

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process_end = self._process.wait()
        self._selector.close()
        self._answers.close()
        if self._process.stdin is not None:
            self._process.stdin.close()


def judge_all(
    good: Path,
    arena: Path,
    faults: Sequence[tuple[int, Fault]],
    tell: Callable[[Verdict], object],
    processes: int,
) -> list[Verdict]:
    """What became of inputs, several at a time.

    Args:
        good: folder with the good files.
        arena: empty folder, in which every input gets one of its own.
        faults: number in the list of all, and input.
        tell: called with each verdict.
        processes: that read.
    """
    waiting: Queue[tuple[int, Fault]] = Queue()
    for each in faults:
        waiting.put(each)

    def work(_: int) -> list[Verdict]:
        reader, verdicts = Reader(good, arena), []
        try:
            for number, fault in _taken(waiting):
                verdicts.append(reader.judge(number, fault))
                tell(verdicts[-1])
        finally:
            reader.close()
        return verdicts

    with ThreadPoolExecutor(processes) as pool:
        return [each for found in pool.map(work, range(processes)) for each in found]


def _taken(waiting: Queue[tuple[int, Fault]]) -> Iterator[tuple[int, Fault]]:
    while True:
        try:
            yield waiting.get_nowait()
        except Empty:
            return
