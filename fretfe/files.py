# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files: looked at before they are read, and whole or not there once they are written."""

from __future__ import annotations

import contextlib
import errno
import math
import os
import stat
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fretfe.errors import FretfeError, OutputError

# Opening or reading these may wait for ever, never end, or do something.
NO_FILES = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
# What is larger is refused (docs/security.md): rows of a table; nodes or elements that a file of
# another run states; bytes of its arrays, or of the files of a deck; these files, and how deep they
# include one another; members of a set of a deck, and of all of its instances.
MOST_ROWS = 1_000_000
MOST_STATED = 50_000_000
MOST_BYTES = 4 * 2**30
MOST_FILES = 1000
DEEPEST_INCLUDE = 10
MOST_MEMBERS = 100_000_000
MOST_PLACED = 200_000_000
REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.ENOENT: "the folder is no longer there",
    errno.EROFS: "the disk cannot be written to",
    errno.ELOOP: "a link to another place, through which nothing is written",
    errno.EMLINK: "a file that has a second name elsewhere, which would be changed with it",
    errno.ENXIO: "something that is no file",
}
# Errors of file systems, and of folders on them, that know no way to the disk.
NO_SYNC = (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS)


# Bytes that are written to learn why others were not.
PROBE = bytes(1 << 16)
# How the names of files begin that are not finished.
UNFINISHED = ".fretfe-new-"


def file_fault(path: Path) -> str:
    """The reason why a path is no file that can be opened, in words; empty if it is one."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError) as error:
        if isinstance(error, FileNotFoundError):
            return f"nothing at {path.absolute()}"
        reason = error.strerror if isinstance(error, OSError) else str(error)
        return f"a name that cannot be opened ({reason})"
    return next((text for is_kind, text in NO_FILES if is_kind(mode)), "")


def require_file(path: Path, what: str, error: type[FretfeError]) -> None:
    """Check that a path is a regular file, before it is opened.

    Args:
        path: of the file.
        what: it is expected to be, for the message.
        error: that is raised.

    Raises:
        FretfeError: of the type given, if it is none.
    """
    if fault := file_fault(path):
        raise error(f"{path}: expected {what}, found {fault}")


@contextlib.contextmanager
def replacing(path: Path, ending: str = "") -> Iterator[Path]:
    """Path for a new file, which takes the place of `path` only when it has been written.

    It is on the disk then: a machine that goes down leaves the file before, or this one. Nobody can
    guess the name of the new file, and put a link there that leads elsewhere.

    Args:
        path: of the file.
        ending: of the name of the new file, for what judges by it how to write.

    Raises:
        OSError: if it cannot be written; what was there before stays.
    """
    new = _new_file(path, ending)
    try:
        yield new
        sync_path(new)
        new.replace(path)
        sync_path(path.parent)
    except BaseException:
        with contextlib.suppress(OSError):
            new.unlink(missing_ok=True)
        raise


def _new_file(path: Path, ending: str = "") -> Path:
    """Make an empty file beside another one."""
    new = path.with_name(f"{UNFINISHED}{os.urandom(8).hex()}{ending}")
    os.close(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
    return new


def require_writable(directory: Path) -> None:
    """Check that files can be made in a folder, and removed.

    Raises:
        OSError: if they cannot.
    """
    _new_file(directory / UNFINISHED).unlink()


def remove_unfinished(directory: Path) -> None:
    """Remove new files of processes that were ended before they had written them.

    Args:
        directory: folder in which no other process is at work.

    Raises:
        OSError: if that fails.
    """
    for path in directory.glob(f"{UNFINISHED}*"):
        path.unlink(missing_ok=True)


def open_own(path: Path | str, flags: int) -> int:
    """Descriptor of a file that is changed where it is; made if it is missing.

    Args:
        path: of the file.
        flags: of `os.open`.

    Raises:
        OSError: if it cannot be opened; so also if it is a link, has a second name, or is no file:
            something elsewhere would be changed.
    """
    own = os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    descriptor = os.open(path, flags & ~os.O_TRUNC | own, 0o666)
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode) or status.st_nlink > 1:
        os.close(descriptor)
        number = errno.EMLINK if stat.S_ISREG(status.st_mode) else errno.ENXIO
        raise OSError(number, os.strerror(number), str(path))
    if flags & os.O_TRUNC:
        os.ftruncate(descriptor, 0)
    return descriptor


def stranger_in(folder: Path) -> Path | None:
    """The first in a folder, or it itself, that is neither a folder nor a file; None without any.

    Links and pipes are there if somebody has put them there: what is written would go elsewhere.

    Args:
        folder: that need not be there.
    """
    kinds = stat.S_ISDIR, stat.S_ISREG
    inside = ((Path(top), [*folders, *files]) for top, folders, files in os.walk(folder))
    paths = (top / name for top, names in inside for name in names)
    for path in (folder, *paths):
        with contextlib.suppress(FileNotFoundError):
            mode = path.lstat().st_mode
            if not any(is_kind(mode) for is_kind in kinds):
                return path
    return None


def replace_text(path: Path, text: str) -> None:
    """Write a text in place of a file, if there is one.

    Raises:
        OSError: as for `replacing`.
    """
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8")


def json_value(value: Any) -> Any:
    """A value in plain types of JSON: None for numbers that are not finite, lists for arrays."""
    if isinstance(value, Mapping):
        return {name: json_value(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(each) for each in value]
    if hasattr(value, "tolist"):  # of NumPy, which need not be there
        return json_value(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value


def cut_off(path: Path) -> OSError:
    """The reason why a library that does not tell has not written all of a file."""
    try:
        with path.open("ab") as file:
            file.write(PROBE)
            file.flush()
            sync(file.fileno())
    except OSError as error:
        return error
    return OSError("it was cut off")


def make_folder(path: Path) -> None:
    """Make a folder, and those that it is in, if they are missing.

    Raises:
        OSError: if that fails.
    """
    missing = [each for each in (path, *path.parents) if not each.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for each in missing:
        sync_path(each.parent)


def sync_path(path: Path) -> None:
    """Have a file, or the names in a folder, on the disk; errors as for `sync`."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        sync(descriptor)
    finally:
        os.close(descriptor)


def sync(descriptor: int) -> None:
    """Have what was written to an open file on the disk, not only in the memory of the system.

    Raises:
        OSError: if it cannot be written.
    """
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno not in NO_SYNC:
            raise


@contextlib.contextmanager
def writing(path: Path, what: str) -> Iterator[None]:
    """Say of what cannot be written where it is, what it is, and why.

    Raises:
        OutputError: if the system refuses it.
    """
    try:
        yield
    except OSError as error:
        raise OutputError(f"{path}: cannot write {what}: {disk_reason(error)}") from error


def disk_reason(error: OSError) -> str:
    """Say why a file cannot be written."""
    return REASONS.get(error.errno or 0, str(error))
