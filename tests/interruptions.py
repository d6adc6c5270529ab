# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of a small dovetail that are cut off at random moments, and what they leave.

`python tests/interruptions.py 20` cuts off 20 runs in each way and prints the largest difference
from the undisturbed run; `python tests/interruptions.py 20 killed stopped` does so in these ways.
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
from pathlib import Path

from launch import ENVIRONMENT
from restarts import largest_difference

from fretfe.errors import OutputError
from fretfe.results.reader import load_result

CASE = Path(__file__).parents[1] / "demos" / "dovetail.toml"
SIZE = "geometry.parameters.edge_size=0.1"
# Kinds of interruptions, and the exit codes of those that fretfe tells.
KINDS = {"killed": -9, "SIGTERM": 143, "SIGINT": 130, "full disk": 6, "killed rank": 0}
SEED = 18
# Room for the states of some of the steps (kB).
SMALLEST, LARGEST = 100, 1500


def command(folder: Path, *more: str, ranks: int = 1) -> list[str]:
    """The run, perhaps on several ranks."""
    run = [sys.executable, "-P", "-m", "fretfe", "run", str(CASE), "-o", str(folder)]
    run += ["--no-report", "--set", SIZE, *more]
    launcher = Path(sys.executable).with_name("mpirun")
    mpirun = str(launcher) if launcher.exists() else shutil.which("mpirun")
    return [str(mpirun), "-n", str(ranks), *run] if ranks > 1 else run


def finish(folder: Path, *more: str, ranks: int = 1) -> float:
    """Run to the end; return the seconds it took."""
    start = time.monotonic()
    done = subprocess.run(
        command(folder, *more, ranks=ranks),
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return time.monotonic() - start


def interrupted(kind: str, folder: Path, after: float) -> str:
    """Start a run and cut it off after some seconds; return what it said, and its exit code."""
    ranks = 2 if kind == "killed rank" else 1
    process = subprocess.Popen(
        command(folder, ranks=ranks),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=ENVIRONMENT,
        start_new_session=True,
    )
    with process:
        if kind != "full disk":
            time.sleep(after)
        if kind == "killed":
            process.kill()
        elif kind in ("SIGTERM", "SIGINT"):
            process.send_signal(signal.Signals[kind])
        elif kind == "killed rank":
            kill_rank(process.pid)
        said, _ = process.communicate(timeout=300)
    return f"{said}\nexit code {process.returncode}"


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


def one(kind: str, undisturbed: Path, folder: Path, part: float, seconds: float) -> float:
    """Interrupt a run and continue it; return the largest difference from the undisturbed one.

    Args:
        kind: of the interruption.
        undisturbed: folder of that run.
        folder: that does not exist yet.
        part: of the time of a run, or of the room on the disk, from 0 to 1.
        seconds: time of a run.
    """
    ranks = 2 if kind == "killed rank" else 1
    if kind != "full disk":
        require_consistent(folder, interrupted(kind, folder, part * seconds))
        finish(folder, "--resume", ranks=ranks)
        return largest_difference(undisturbed, folder)
    with small_disk(folder, round(SMALLEST + part * (LARGEST - SMALLEST))):
        said = interrupted(kind, folder, 0.0)
        assert "exit code 6" in said and "the disk is full" in said, said
        require_consistent(folder, said)
        subprocess.run(["mount", "-o", "remount,size=64m", str(folder)], check=True)
        finish(folder, "--resume")
        return largest_difference(undisturbed, folder)


def main(count: int, kinds: list[str]) -> None:
    """Interrupt runs and print what became of them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        finish(folder / "undisturbed")
        seconds = finish(folder / "again")
        for kind in kinds:
            random.seed(SEED)
            for number in range(count):
                part = random.random()
                place = folder / f"{kind}-{number}".replace(" ", "-")
                found = one(kind, folder / "undisturbed", place, part, seconds)
                print(f"{kind} {number + 1} at {part:.3f}: difference {found:.1e}", flush=True)
                shutil.rmtree(place, ignore_errors=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:] or list(KINDS))
