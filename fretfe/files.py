# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that a user names: looked at before they are opened."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from fretfe.errors import FretfeError

# Opening or reading these may wait for ever, never end, or do something.
NO_FILES = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


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
