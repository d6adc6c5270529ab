# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors of fretfe itself, which must not cost what they have nothing to do with.

`guarded` stands where one contact, station, table, figure or picture is made. What fails there is
unknown, the rest goes on, and the traceback is kept in the folder of the run.
"""

from __future__ import annotations

import re
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from fretfe.environment import memory_shortage, missing_package, rank_from_environment
from fretfe.errors import FaultError, FretfeError
from fretfe.files import open_own

T = TypeVar("T")
# Tracebacks of errors of fretfe, in a results folder.
FAULTS = "faults.log"


@dataclass(frozen=True)
class Fault:
    """An error of fretfe that left something unknown.

    Attributes:
        place: what is unknown: a contact, a station, a figure.
        error: type and text of the error.
    """

    place: str
    error: str

    @property
    def reason(self) -> str:
        """The reason why something is unknown, in words."""
        return f"fretfe itself failed ({self.error}): please report that"

    @property
    def text(self) -> str:
        """The place, and the reason why it is unknown."""
        return f"{self.place}: unknown, because {self.reason}"


class CollectiveError(Exception):
    """An error in what all ranks do together: others may wait for this one, so all have to end."""


@dataclass
class Collected:
    """The faults so far.

    Attributes:
        directory: where their tracebacks go; None for the terminal.
        faults: each once.
    """

    directory: Path | None
    faults: list[Fault] = field(default_factory=list)

    def add(self, fault: Fault, trace: str) -> None:
        """Keep a fault with its traceback, once."""
        if fault not in self.faults:
            self.faults.append(fault)
            write_traceback(self.directory, fault.place, trace)


_COLLECTED: ContextVar[Collected | None] = ContextVar("collected", default=None)


@contextmanager
def collecting(directory: Path | None = None) -> Iterator[Collected]:
    """Have `guarded` keep the errors of fretfe within a block, rather than raise them.

    Args:
        directory: results folder, in which `FAULTS` gets the tracebacks; None prints them.
    """
    found = Collected(directory)
    token = _COLLECTED.set(found)
    try:
        yield found
    finally:
        _COLLECTED.reset(token)


def faults_so_far() -> tuple[Fault, ...]:
    """The faults of the block around; none without one."""
    found = _COLLECTED.get()
    return tuple(found.faults) if found else ()


def guarded(place: str, work: Callable[[], T], otherwise: Callable[[Fault], T]) -> T:
    """Do some work, or what is left to do where fretfe fails in it.

    Errors that tell a user's mistake, missing memory or a missing package are raised as ever. So is
    everything where nobody is `collecting`.

    Args:
        place: what the work makes, in words.
        work: takes no argument.
        otherwise: gives the result of work that failed.
    """
    try:
        return work()
    except (FretfeError, CollectiveError):
        raise
    except Exception as error:
        found = _COLLECTED.get()
        if found is None or memory_shortage(error) or missing_package(error):
            raise
        return otherwise(note_fault(place, said(error), trace_of(error)))


def said(error: BaseException) -> str:
    """Type and text of an error, in one line."""
    text = re.sub(r"\s+", " ", str(error)).strip()
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def trace_of(error: BaseException) -> str:
    """Traceback of an error, in lines."""
    return "".join(traceback.format_exception(error))


def note_fault(place: str, error: str, trace: str) -> Fault:
    """Keep an error of fretfe that another process has told, if anybody is `collecting`."""
    fault, found = Fault(place, error), _COLLECTED.get()
    if found is not None:
        found.add(fault, trace)
    return fault


def write_traceback(directory: Path | None, place: str, trace: str) -> None:
    """Add a traceback to those in a folder, on process 0; print it without one, or if that fails.

    Args:
        directory: results folder, or None.
        place: what failed, in words.
        trace: the traceback.
    """
    if rank_from_environment() > 0:
        return
    if directory is not None:
        line = f"{time.strftime('%Y-%m-%d %H:%M:%S')} {place}\n"
        try:
            with open(directory / FAULTS, "a", encoding="utf-8", opener=open_own) as file:
                file.write(f"{line}{trace}\n")
            return
        except OSError:  # a full disk, or a folder that is gone
            pass
    print(trace, file=sys.stderr, flush=True, end="")


def require_none(faults: Sequence[Fault], directory: Path | None = None) -> None:
    """Raise an error that names what is unknown because fretfe failed, if anything is.

    Args:
        faults: of a run and of its report.
        directory: results folder.

    Raises:
        FaultError: if there are any.
    """
    if not faults:
        return
    places = "; ".join(dict.fromkeys(fault.place for fault in faults))
    beside = f" and {directory / FAULTS}" if directory is not None else ""
    raise FaultError(
        f"fretfe itself failed; unknown for that reason: {places}. All else is written. Please "
        f"report this with what `fretfe info` prints{beside}"
    )
