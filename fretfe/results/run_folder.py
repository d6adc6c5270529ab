# SPDX-License-Identifier: LGPL-3.0-or-later
"""The state of a results folder: who is at work in it, and how far the run in it has come.

`run.json` says so. It is written before anything of an earlier run is touched, and says that the
run has finished only when all numbers are there. `run.lock` keeps a second process out.

Numbers have a digest, by which one sees that others were changed since. It tells damage and
mistakes, not malice: whoever changes numbers can change the digest.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import socket
from collections.abc import Callable, Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

from fretfe.errors import OutputError
from fretfe.files import disk_reason, file_fault, open_own, replace_text, writing

MARK = "run.json"
LOCK = "run.lock"
SCHEMA = {"name": "fretfe-run", "version": 1}
KEY = "digest"
FINISHED = "finished"
NEEDED = {"doing", "complete"}
ANEW = (
    "The file is damaged, so that the run cannot be continued: run the case without --resume, "
    "which starts it anew"
)
# Errors of file systems without locks.
NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS)


def with_digest(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers in plain types of JSON, and behind them the digest of all."""
    return {**numbers, KEY: _digest(numbers)}


def are_unchanged(numbers: Mapping[str, Any]) -> bool:
    """True if the digest among numbers is that of the others."""
    others = {name: value for name, value in numbers.items() if name != KEY}
    return bool(numbers.get(KEY) == _digest(others))


def _digest(numbers: Mapping[str, Any]) -> str:
    return sha256(json.dumps(numbers).encode()).hexdigest()


@contextlib.contextmanager
def locked(directory: Path, say: Callable[[str], None] = lambda _: None) -> Iterator[None]:
    """Keep other processes from writing to an existing folder.

    Args:
        directory: the folder.
        say: gets a line if the lock was left by a process that has ended.

    Raises:
        OutputError: if another process is at work there; it is named.
    """
    path = directory / LOCK
    try:
        descriptor, locks = _open(path)
    except OSError as error:
        raise OutputError(f"{path}: cannot be written: {disk_reason(error)}") from error
    try:
        before = _owner(path)
        if before is not None:
            _require_ended(directory, before, locks)
            say(f"process {before[0]}, which has ended, left {path}: taken over")
        me = {"process": os.getpid(), "host": socket.gethostname()}
        os.ftruncate(descriptor, 0)
        with contextlib.suppress(OSError):  # a full disk; the lock itself needs no room
            os.pwrite(descriptor, json.dumps(me).encode(), 0)
        yield
    finally:
        if _same(descriptor, path):
            path.unlink()
        os.close(descriptor)


def _open(path: Path) -> tuple[int, bool]:
    """Open and lock a file; say whether the file system has locks.

    Raises:
        OutputError: if another process has it.
    """
    while True:
        descriptor = open_own(path, os.O_RDWR)
        locks = True
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            locks = False
            if error.errno not in NO_LOCKS:
                os.close(descriptor)
                raise _in_use(path.parent, _owner(path)) from None
        # The process before removes the file when it ends: that may have been just now.
        if _same(descriptor, path):
            return descriptor, locks
        os.close(descriptor)


def _same(descriptor: int, path: Path) -> bool:
    """True if an open file is still the one of this name."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except OSError:
        return False


def _owner(path: Path) -> tuple[int, str] | None:
    """Process and host that a lock names; None if it names none."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return int(found["process"]), str(found["host"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _require_ended(directory: Path, owner: tuple[int, str], locks: bool) -> None:
    """Require that the owner has ended; one on this host has if this process got the lock.

    Raises:
        OutputError: if the owner may be at work.
    """
    process, host = owner
    if host != socket.gethostname():
        raise _in_use(directory, owner, f". If it has ended, remove {directory / LOCK}")
    if not locks and _exists(process):
        raise _in_use(directory, owner)


def _exists(process: int) -> bool:
    try:
        os.kill(process, 0)
    except PermissionError:
        return True  # that of somebody else
    except OSError:
        return False
    return True


def _at_work(path: Path) -> bool:
    """True if a lock is held, or the file system has no locks."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno in NO_LOCKS or isinstance(error, BlockingIOError)
    finally:
        os.close(descriptor)
    return False


def _in_use(directory: Path, owner: tuple[int, str] | None, remedy: str = "") -> OutputError:
    who = f"process {owner[0]} on host {owner[1]}" if owner else "another process"
    return OutputError(
        f"{directory}: expected a folder of its own, found {who} at work in it{remedy}"
    )


def write_mark(directory: Path, mark: Mapping[str, Any]) -> None:
    """Write down how far the run in a folder has come.

    Args:
        directory: folder.
        mark: `doing`, `complete` and what else there is to say, in plain types.

    Raises:
        OutputError: if that is not possible.
    """
    who = {"process": os.getpid(), "host": socket.gethostname()}
    said = with_digest({"schema": SCHEMA, **who, **mark})
    text = json.dumps(said, indent=1, allow_nan=False)
    with writing(directory / MARK, "the mark of a run"):
        replace_text(directory / MARK, text + "\n")


def read_mark(directory: Path) -> dict[str, Any] | None:
    """Progress of the run in a folder; None without a note of it.

    Raises:
        OutputError: if the note is not one of this version, or not as it was written.
    """
    path = directory / MARK
    require_stored(path)
    try:
        mark = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError, RecursionError) as error:
        found = "brackets in brackets" if isinstance(error, RecursionError) else str(error)
        raise OutputError(f"{path}: expected the state of a run, found: {found}. {ANEW}") from error
    if not isinstance(mark, dict) or mark.get("schema") != SCHEMA or not mark.keys() >= NEEDED:
        raise OutputError(f"{path}: expected schema {SCHEMA}, found something else. {ANEW}")
    # Those of earlier versions have no digest.
    if KEY in mark and not are_unchanged(mark):
        raise OutputError(f"{path}: expected the state of a run, found a changed one. {ANEW}")
    return mark


def require_stored(path: Path) -> None:
    """Check that a file that may be missing is nothing but a file: a pipe would never be read.

    Raises:
        OutputError: if it is something else.
    """
    # Of a name that cannot be opened `Path.exists` fails.
    if os.path.exists(path) and (fault := file_fault(path)):
        raise OutputError(f"{path}: expected a file of results, found {fault}")


def unfinished(directory: Path) -> str:
    """Say in what state the run in a folder is; empty if it has ended by itself.

    Raises:
        OutputError: as for `read_mark`.
    """
    mark = read_mark(directory)
    if mark is None or mark.get("doing") == FINISHED:
        return ""
    who = f"process {mark.get('process')} on host {mark.get('host')}"
    steps = f"step {mark.get('step', 0)} of {mark['steps']}" if mark.get("steps") else "no step yet"
    if _at_work(directory / LOCK):
        return f"a run that is still at work ({who}; {steps})"
    reason = mark.get("reason")
    if reason:
        return f"a run that failed: {reason}"
    return (
        f"a run that was ended from outside while {mark.get('doing')} ({who}; {steps}). The same "
        "command with --resume continues it"
    )
