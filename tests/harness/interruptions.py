# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of a small dovetail that are cut off at random moments, and what they leave.

`cd tests; python -m harness.interruptions 20` cuts off 20 runs in each way and prints where, and
the largest difference from the undisturbed run; `... 20 killed SIGINT` does so in these ways.
Three moments of five are in the steps, one is before them and one behind.
"""

from __future__ import annotations

import contextlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from harness.launch import python, started
from harness.restarts import largest_difference

from fretfe.errors import OutputError
from fretfe.results.reader import load_result

CASE = Path(__file__).parents[2] / "demos" / "dovetail.toml"
# Coarse, and with so many steps that most of the time goes there.
VALUES = {
    "geometry.parameters.edge_size": 0.1,
    "geometry.parameters.edge_zone": 0.2,
    "loads.pull.history.1.steps": 60,
    "loads.pull.history.2.steps": 30,
    "loads.pull.history.3.steps_per_cycle": 480,
}
# Kinds of interruptions, and the exit codes of those that fretfe tells.
KINDS = {"killed": -9, "SIGTERM": 143, "SIGINT": 130, "full disk": 6, "killed rank": 0}
SEED = 18
# Smallest room on a disk (kB).
SMALLEST = 50


@dataclass(frozen=True)
class Course:
    """A run that nothing disturbed.

    Attributes:
        folder: of its results.
        steps: numbers of the steps that it told.
        times: seconds from the start to each of them.
        end: seconds from the start to the end.
    """

    folder: Path
    steps: tuple[int, ...]
    times: tuple[float, ...]
    end: float

    @property
    def size(self) -> float:
        """Of what it left on the disk (kB)."""
        return sum(each.stat().st_size for each in self.folder.rglob("*") if each.is_file()) / 1024


@dataclass(frozen=True)
class Moment:
    """When a run is cut off: so many seconds after it told a step, or began (0); room on its disk.

    Attributes:
        step: number of the step.
        seconds: after it.
        room: on a disk (kB).
    """

    step: int
    seconds: float
    room: int

    @classmethod
    def at(cls, course: Course, number: int) -> Moment:
        """A random moment: before the steps, three times in them, behind them, by the number."""
        chance = random.Random(f"{SEED} {number}")
        part, last = chance.random(), len(course.steps) - 1
        room = round(SMALLEST + part * (0.9 * course.size - SMALLEST))
        if number % 5 == 3:
            return cls(0, chance.random() * course.times[0], room)
        if number % 5 == 4:
            return cls(course.steps[-1], chance.random() * (course.end - course.times[-1]), room)
        told = round(part * (last - 1))
        wait = course.times[told + 1] - course.times[told]
        return cls(course.steps[told], chance.random() * wait, room)


def arguments(folder: Path, *more: str) -> list[str]:
    """Those of the interpreter for a run."""
    values = [word for name, value in VALUES.items() for word in ("--set", f"{name}={value}")]
    return ["-m", "fretfe", "run", str(CASE), "-o", str(folder), "--no-report", *values, *more]


def steps_in(said: str) -> list[int]:
    """Numbers of the steps that a run told."""
    lines = (line for line in said.splitlines() if line.startswith("step "))
    return [int(line[5:].split("/")[0]) for line in lines]


def finish(folder: Path, *more: str, ranks: int = 1) -> list[int]:
    """Run to the end; return the steps that were solved."""
    done = python(*arguments(folder, *more), ranks=ranks, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return steps_in(done.stdout)


def undisturbed(folder: Path) -> Course:
    """Run to the end, and look at the clock."""
    begin, steps, times = time.monotonic(), [], []
    with started(*arguments(folder)) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if told := steps_in(line):
                steps += told
                times.append(time.monotonic() - begin)
    assert process.returncode == 0
    return Course(folder, tuple(steps), tuple(times), time.monotonic() - begin)


def read_to_step(process: subprocess.Popen[str], step: int) -> str:
    """What a run says until it tells a step; nothing for step 0."""
    said = ""
    assert process.stdout is not None
    while step and step not in steps_in(said):
        line = process.stdout.readline()
        if not line:
            break
        said += line
    return said


def interrupted(kind: str, folder: Path, moment: Moment) -> str:
    """Start a run and cut it off; return what it said, and its exit code."""
    ranks = 2 if kind == "killed rank" else 1
    with started(*arguments(folder), ranks=ranks) as process:
        said = ""
        if kind != "full disk":
            said = read_to_step(process, moment.step)
            time.sleep(moment.seconds)
        if kind == "killed":
            process.kill()
        elif kind in ("SIGTERM", "SIGINT"):
            process.send_signal(signal.Signals[kind])
        elif kind == "killed rank":
            kill_rank(process.pid)
        rest, _ = process.communicate(timeout=300)
    return f"{said}{rest}\nexit code {process.returncode}"


def kill_rank(launcher: int, number: signal.Signals = signal.SIGKILL) -> None:
    """Send a signal to the last rank of a launcher."""
    own = []
    for each in Path("/proc").iterdir():
        with contextlib.suppress(OSError, IndexError, ValueError):
            words = (each / "stat").read_text().rsplit(")", 1)[1].split()
            line = (each / "cmdline").read_bytes()
            if int(words[3]) != 0 and _below(int(each.name), launcher) and b"fretfe\0run" in line:
                own.append((line.startswith(sys.executable.encode()), int(each.name)))
    ranks = sorted(number for python, number in own if python)
    if ranks:
        with contextlib.suppress(ProcessLookupError):
            os.kill(ranks[-1], number)


def _below(process: int, ancestor: int) -> bool:
    while process > 1:
        if process == ancestor:
            return True
        stat = Path(f"/proc/{process}/stat").read_text()
        process = int(stat.rsplit(")", 1)[1].split()[1])
    return False


def require_consistent(folder: Path, said: str) -> None:
    """The folder has the complete results of this case, or says that it has none."""
    assert "Traceback" not in said, said
    mark = folder / "run.json"
    if not mark.exists():
        assert not (folder / "results.json").exists()
        return
    noted = json.loads(mark.read_text())
    try:
        result = load_result(folder)
    except OutputError as error:
        assert not noted["complete"], noted
        assert "expected the results of a run, found" in str(error), error
    else:
        assert noted["complete"] == (result.failure is None)


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[None]:
    """A disk of some kB at a folder; as root only."""
    folder.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "none", str(folder)], check=True)
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True)


def one(kind: str, course: Course, folder: Path, moment: Moment) -> tuple[str, float]:
    """Interrupt a run and continue it.

    Args:
        kind: of the interruption.
        course: the undisturbed run.
        folder: that does not exist yet.
        moment: when.

    Returns:
        Where it was cut off, and the largest difference from the undisturbed run.
    """
    if kind != "full disk":
        said = interrupted(kind, folder, moment)
        require_consistent(folder, said)
        solved = finish(folder, "--resume", ranks=2 if kind == "killed rank" else 1)
        return _place(said, solved, course), largest_difference(course.folder, folder)
    with small_disk(folder, moment.room):
        said = interrupted(kind, folder, moment)
        assert "exit code 6" in said and "the disk is full" in said, said
        require_consistent(folder, said)
        subprocess.run(["mount", "-o", "remount,size=64m", str(folder)], check=True)
        solved = finish(folder, "--resume")
        return _place(said, solved, course), largest_difference(course.folder, folder)


def _place(said: str, solved: list[int], course: Course) -> str:
    """Where a run was cut off, and where the next one went on."""
    told, code = steps_in(said), said.rsplit(" ", 1)[1]
    if not told:
        where = "before the steps"
    elif told[-1] == course.steps[-1]:
        where = "behind the steps"
    else:
        where = f"in the steps, after {told[-1]} of {course.steps[-1]}"
    again = f"went on with {solved[0]}" if solved else "solved none again"
    return f"{where} (exit code {code}; {again})"


def main(count: int, kinds: list[str]) -> None:
    """Interrupt runs and print what became of them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        finish(folder / "first")
        course = undisturbed(folder / "undisturbed")
        print(f"steps from {course.times[0]:.1f} s to {course.times[-1]:.1f} of {course.end:.1f} s")
        for number in range(count):
            for kind in kinds:
                place = folder / f"{kind}-{number}".replace(" ", "-")
                where, found = one(kind, course, place, Moment.at(course, number))
                print(f"{kind} {number + 1}: {where}: difference {found:.1e}", flush=True)
                shutil.rmtree(place, ignore_errors=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:] or list(KINDS))
