# SPDX-License-Identifier: LGPL-3.0-or-later
"""A run in its folder: what it begins with, keeps, and leaves when it ends; on the first process.

The folder never holds a mixture of two runs, and says how far the one in it has come.
"""

from __future__ import annotations

import shutil
import signal
import time
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, NoReturn

from fretfe.backends import Observer
from fretfe.bodies.input_files import input_digests, input_files
from fretfe.case import Case, as_written, case_text
from fretfe.case.overrides import by_key
from fretfe.environment import versions
from fretfe.errors import FaultError, OutputError, StoppedError
from fretfe.faults import Fault, guarded
from fretfe.files import (
    remove_unfinished,
    replace_text,
    stranger_in,
    sync_path,
    writing,
)
from fretfe.history.stream import STATES
from fretfe.results.model import Result
from fretfe.results.reader import read_result
from fretfe.results.run_folder import FINISHED, KEY, LOCK, MARK, read_mark, write_mark
from fretfe.results.writer import (
    NUMBERS,
    PICTURES,
    REPORT,
    RESULT_FILES,
    SWEEP_FILES,
    remove_pictures,
    remove_results,
    write_results,
)

CASE_COPY = "case.toml"
ROWS = "validation.json"
# The command of a run that makes a report at its end.
RUN = "run"
# Keys of a case that a run may be continued without: they change no state.
FREE_KEYS = ("title", "output")
# Packages whose versions must not change within a run; those of a backend stand with its states.
VERSIONS = ("fretfe",)
MOST_CHANGES = 5
# Names in a results folder under which a run removes or replaces what it finds.
TAKEN = {*RESULT_FILES, *SWEEP_FILES, CASE_COPY, LOCK, MARK, PICTURES, ROWS, STATES}
# Seconds between two notes of the last step: at least so many times what the last one took.
NOTE_SECONDS = 1.0
SPARING = 50.0


class Work:
    """A run in its folder, which `run_folder.locked` keeps others from.

    Args:
        directory: existing folder.
        command: "run", "sweep" or "validate".
        backend: its name.
        case: to be solved.
        varied: what a sweep varies.
        cases: that it solves; the one without these.

    Attributes:
        directory: of the run.
        known: the numbers that were found in it, on the process that has read them.
    """

    def __init__(
        self,
        directory: Path,
        command: str,
        backend: str,
        case: Case,
        varied: Mapping[str, Any] | None = None,
        cases: Sequence[Case] = (),
    ) -> None:
        self.directory = directory
        self.known: Result | None = None
        self._case = case
        self._cases = cases or (case,)
        # What tells the result that was written last from another one of this run.
        self._written: object = None
        self._begun = False
        self._mark: dict[str, Any] = {
            "doing": "starting",
            "complete": False,
            "step": 0,
            "steps": 0,
            "reason": "",
            "command": command,
            "backend": backend,
            "versions": {name: versions()[name] for name in VERSIONS},
            "varied": {key: list(map(str, values)) for key, values in (varied or {}).items()},
            "case": _plain(case),
        }

    def require_apart(self) -> None:
        """Check that nothing that the case reads would be removed, or written through.

        Raises:
            OutputError: if it would.
        """
        own = self.directory.resolve()
        inputs = {path: key for case in self._cases for path, key in input_files(case).items()}
        for path, key in inputs.items():
            if path.is_relative_to(own) and path.relative_to(own).parts[0] in TAKEN:
                raise OutputError(
                    f"{self.directory}: expected another folder than that with files of the case, "
                    f"found {path} ({key}), which the run would remove"
                )
        for name in (STATES, PICTURES):
            if (found := stranger_in(self.directory / name)) is not None:
                raise OutputError(
                    f"{found}: expected a file or a folder of a run, found a link or a pipe, "
                    "through which the run would write to another place"
                )

    def _require_own(self, *, with_case: bool) -> None:
        """Check that a folder without a run has no files that one would remove or replace.

        Args:
            with_case: whether the case file is there, which stays as it is.

        Raises:
            OutputError: if it has; they are somebody's.
        """
        if (self.directory / MARK).exists():
            return
        kept = {LOCK, CASE_COPY} if with_case else {LOCK}
        if found := sorted(
            each.name for each in self.directory.iterdir() if each.name in TAKEN - kept
        ):
            raise OutputError(
                f"{self.directory}: expected a new folder, or that of an earlier run, found "
                f"{' and '.join(found)} without the {MARK} of a run, which would be replaced"
            )

    def begin(self, *, resume: bool) -> bool:
        """Take the folder for this run; with `resume` go on with the one in it, if there is one.

        Returns:
            True if the run in it is complete.

        Raises:
            OutputError: if another case would be written over the case file, the run in the
                folder is another one, or files there are of no run.
        """
        target = self.directory / CASE_COPY
        copied = target.resolve() == self._case.source.resolve()
        if copied and not as_written(self._case):
            raise OutputError(
                f"{self.directory}: expected another folder than that of the case file, found "
                f"{target}, which the case with other values would replace"
            )
        self.require_apart()
        self._require_own(with_case=copied)
        digests = (input_digests(each).items() for each in self._cases)
        self._mark["inputs"] = dict(chain.from_iterable(digests))
        before = read_mark(self.directory) if resume else None
        if before is not None:
            self._require_same(before)
            if before["complete"] and before["doing"] == FINISHED:
                return True
            self._mark |= {"step": before.get("step", 0), "steps": before.get("steps", 0)}
        else:
            self._note("starting")
        with writing(self.directory, "the case"):
            remove_unfinished(self.directory)
            if before is None:
                self._clear()
            if not copied:
                replace_text(target, case_text(self._case))
        self._note("solving")
        return False

    def _clear(self) -> None:
        """Remove what an earlier run has left, but a report until there is another one."""
        remove_results(self.directory, kept=REPORT if self._mark["command"] == RUN else "")
        remove_pictures(self.directory)
        for name in (ROWS, *SWEEP_FILES):
            (self.directory / name).unlink(missing_ok=True)
        self._remove_states()

    def _remove_states(self) -> None:
        states = self.directory / STATES
        if states.is_dir():
            shutil.rmtree(states)

    def _require_same(self, before: Mapping[str, Any]) -> None:
        try:
            changes = list(_changes(before, self._mark))
        except RecursionError:
            changes = [f"{MARK} has brackets in brackets"]
        if changes:
            more = f" and {len(changes) - MOST_CHANGES} more" if len(changes) > MOST_CHANGES else ""
            raise OutputError(
                f"{self.directory}: the run there cannot be continued, as it is another one: "
                f"{'; '.join(changes[:MOST_CHANGES])}{more}. Run the case without --resume"
            )

    def _note(self, doing: str, **more: Any) -> None:
        self._begun = True
        self._mark |= {"doing": doing, **more}
        write_mark(self.directory, self._mark)

    def step(self, number: int, count: int) -> None:
        """Note the last accepted step; the next one tells if that fails."""
        self._note_if_possible({"doing": "solving", "step": number, "steps": count})

    def _note_if_possible(self, more: Mapping[str, Any]) -> None:
        self._mark |= more
        try:
            write_mark(self.directory, self._mark)
        except OutputError:
            return

    def evaluating(self) -> None:
        """Note that all steps are solved."""
        self._note_if_possible({"doing": "evaluating"})

    def numbers(self, result: Result) -> None:
        """Write the numbers of a result in place of those before, if they are not there."""
        this = result.notes, result.failure, result.refinement, result.faults
        if self._written == this:
            return
        self._note("writing results", step=len(result.loads.times) - 1)
        guarded(NUMBERS, partial(write_results, self.directory, result), self._unwritten)
        self._written = this
        self._note("solving")

    def _unwritten(self, fault: Fault) -> NoReturn:
        raise FaultError(
            f"{self.directory / NUMBERS}: not written: {fault.reason}. The steps that were solved "
            "are kept: the same command with --resume goes on from them"
        )

    def close(self, result: Result) -> None:
        """Write the numbers of the last result and say that it is all.

        States stay if a signal ended the run.
        """
        self.numbers(result)
        complete = result.failure is None
        self.finish(complete=complete, resumable=isinstance(result.failure, StoppedError))

    def read_known(self) -> Result | None:
        """Read what the run has written so far into `known`; for other processes, without arrays.

        None if it has not written all of its numbers.
        """
        try:
            self.known = read_result(self.directory)
        except OutputError:
            return None
        return replace(self.known, root_solution=None, bodies={})

    def finish(self, *, complete: bool, resumable: bool = False) -> None:
        """Say that all is written, once it is on the disk.

        States that a later run could go on from stay if it could.

        Args:
            complete: whether everything was solved.
            resumable: whether it would be worth while to go on.
        """
        with writing(self.directory, "the results"):
            for path in self.directory.iterdir():
                if path.is_file():
                    sync_path(path)
            self._note(FINISHED, complete=complete)
            if not resumable:
                self._remove_states()

    def fail(self, reason: str) -> None:
        """Say why there are no results; on a full disk nothing can be said."""
        if not self._begun:
            return
        try:
            self._note("solving", reason=reason)
        except OutputError:
            return

    def fail_elsewhere(self, reason: str) -> None:
        """As `fail`, on a process of which the first one does not know that it has failed."""
        with suppress(OutputError):
            if (mark := read_mark(self.directory)) is not None:
                del mark[KEY]
                write_mark(self.directory, {**mark, "reason": reason})


class StepNotes(Observer):
    """Passes everything on, and notes the last accepted step in the folder from time to time.

    Args:
        observer: to pass it on to.
        work: the run.
    """

    def __init__(self, observer: Observer, work: Work) -> None:
        self._observer = observer
        self._work = work
        self._next = 0.0
        self._solved = False

    def step(self, number: int, count: int, text: str) -> None:
        """Note a step."""
        self._solved = True
        begin = time.monotonic()
        if begin >= self._next:
            self._work.step(number, count)
            end = time.monotonic()
            self._next = end + max(NOTE_SECONDS, SPARING * (end - begin))
        self._observer.step(number, count, text)

    def phase(self, text: str) -> None:
        """Pass it on."""
        self._observer.phase(text)

    def announce(self, text: str) -> None:
        """Pass it on."""
        self._observer.announce(text)

    def doing(self, text: str) -> None:
        """Pass it on; after steps it is their evaluation."""
        if self._solved:
            self._work.evaluating()
        self._observer.doing(text)

    def stop(self) -> signal.Signals | None:
        """Ask the other one."""
        return self._observer.stop()


def _plain(case: Case) -> dict[str, Any]:
    """The case in plain types, the same from its own file and from the copy in the folder."""
    return tomllib.loads(case_text(case))


def _changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    """Differences of two runs that matter, in words."""
    for key in ("command", "backend", "versions", "varied", "case"):
        start = "" if key == "case" else key
        one, other = (by_key(each.get(key), start) for each in (before, now))
        for name in {**one, **other}:
            if name.split(".")[0] in FREE_KEYS or one.get(name) == other.get(name):
                continue
            yield f"{name} was {one.get(name, 'not given')}, is {other.get(name, 'not given')}"
    one, other = (dict(each.get("inputs", {})) for each in (before, now))
    for path in {**one, **other}:
        if one.get(path) != other.get(path):
            yield f"{path} has changed since it was read" if path in one else f"{path} is read too"
