# SPDX-License-Identifier: LGPL-3.0-or-later
"""Progress of a history for those who wait for it, and its end when they do not want to."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fretfe.backends import Observer
from fretfe.cli.options import Verbosity
from fretfe.console import Console

if TYPE_CHECKING:
    from rich.progress import Progress, TaskID

    from fretfe.quality.comparison import Benchmark, Row

# What ends a process from outside: a user, a queue or `timeout`, a terminal that is closed.
DEFAULTS: dict[signal.Signals, Any] = {
    signal.SIGINT: signal.default_int_handler,
    signal.SIGTERM: signal.SIG_DFL,
    signal.SIGHUP: signal.SIG_DFL,
}


class StepReport(Observer):
    """Progress on rank 0: a bar on a terminal, elsewhere a line per step; nothing if quiet.

    Ctrl-C, SIGTERM and SIGHUP end the history after the step that is being solved, so that nothing
    is lost that was computed; before the first step and after the last one, whose states are kept,
    or once more, they end the process. One that the process ignores, as SIGHUP under `nohup`, does
    nothing.

    Args:
        rank: of this process.
        verbosity: lines on a terminal too if verbose.
        steps: whether there are lines for steps if it is not verbose.
    """

    def __init__(
        self, rank: int, verbosity: Verbosity = Verbosity.NORMAL, *, steps: bool = True
    ) -> None:
        self._quiet = verbosity is Verbosity.QUIET
        self._lines = verbosity is Verbosity.VERBOSE or (steps and not self._quiet)
        console = Console(stderr=True)
        self._rank = rank
        self._steps = 0
        self._signal: signal.Signals | None = None
        self._handlers: dict[signal.Signals, Any] = {}
        self._bar: Progress | None = None
        self._task: TaskID | None = None
        if console.is_terminal and rank == 0 and verbosity is Verbosity.NORMAL:
            self._bar = _bar(console)

    def __enter__(self) -> StepReport:
        """Show the bar and listen to signals."""
        self._handlers = {
            each: signal.signal(each, self._asked)
            for each in DEFAULTS
            if signal.getsignal(each) is not signal.SIG_IGN
        }
        if self._bar is not None:
            self._bar.start()
            self._task = self._bar.add_task("steps", total=None)
        return self

    def __exit__(self, *_: object) -> None:
        """Take the bar away and leave signals to their handlers."""
        for each in self._handlers:
            self._restore(each)
        if self._bar is not None:
            self._bar.stop()

    def step(self, number: int, count: int, text: str) -> None:
        """Report an accepted step."""
        self._steps += 1
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, completed=number, total=count, description="steps")
        elif self._lines:
            print(f"step {number}/{count}: {text}", flush=True)

    def doing(self, text: str) -> None:
        """Name what is being done: no step, for whose end a signal would have to wait."""
        self._steps = 0
        if self._bar is not None and self._task is not None:
            self._bar.update(self._task, description=text)
        elif self._lines:
            print(f"{text} ...", flush=True)

    def stop(self) -> signal.Signals | None:
        """Return the signal that asked the process to end, if there was one."""
        return self._signal

    def announce(self, text: str) -> None:
        """Say what begins or has ended."""
        if self._bar is not None:
            self._bar.console.print(text, highlight=False, markup=False)
        elif not self._quiet:
            print(text, flush=True)

    def _asked(self, number: int, _: object) -> None:
        """Handle a signal. Ranks without steps leave it to the one that has them."""
        if self._signal is not None or (self._rank == 0 and self._steps == 0):
            self._restore(signal.Signals(number))
            signal.raise_signal(number)
            return
        self._signal = signal.Signals(number)
        if self._rank == 0:
            print("Stopping after this step; once more stops at once.", file=sys.stderr, flush=True)

    def _restore(self, number: signal.Signals) -> None:
        # A handler that was not set from Python, such as that of PETSc, is not known.
        before = self._handlers[number]
        signal.signal(number, DEFAULTS[number] if before is None else before)


def _bar(console: Console) -> Progress:
    # Imported where it is needed: most runs write to a file.
    from rich import progress

    columns = (
        progress.TextColumn("{task.description}"),
        progress.BarColumn(),
        progress.MofNCompleteColumn(),
        progress.TimeRemainingColumn(),
    )
    return progress.Progress(*columns, console=console, transient=True)


class PhaseReport(StepReport):
    """Progress of several runs of a case: each is named where it begins."""

    def __init__(self, name: str, rank: int, verbosity: Verbosity) -> None:
        super().__init__(rank, verbosity, steps=False)
        self._name = name
        self._console = Console(stderr=True, quiet=rank > 0 or verbosity is Verbosity.QUIET)

    def phase(self, text: str) -> None:
        """Name the run that begins."""
        self._console.print(f"{self._name}: {text}", highlight=False)

    def announce(self, text: str) -> None:
        """Leave out the meshes."""


class BenchmarkReport(Observer):
    """Tables on the standard output, and beside them what is at work; nothing if quiet."""

    def __init__(self, *, quiet: bool) -> None:
        self.console = Console(quiet=quiet)
        from rich.status import Status

        self._status = Status("", console=Console(stderr=True, quiet=quiet))

    def phase(self, text: str) -> None:
        """Name what is at work."""
        self._status.update(text)
        self._status.start()

    def show(self, benchmark: Benchmark, rows: Sequence[Row]) -> None:
        """Print the rows of a benchmark."""
        from fretfe.quality.comparison import print_rows

        self._status.stop()
        print_rows(self.console, benchmark, rows)
