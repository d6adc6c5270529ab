# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that are whole or not there, and why the system does not take them, in words."""

from __future__ import annotations

import contextlib
import errno
from collections.abc import Iterator
from pathlib import Path

REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.ENOENT: "the folder is no longer there",
    errno.EROFS: "the disk cannot be written to",
}


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Path for a new file, which takes the place of `path` only when it has been written.

    Raises:
        OSError: if it cannot be written; what was there before stays.
    """
    new = path.with_name(f"{path.name}.new")
    try:
        yield new
        new.replace(path)
    except BaseException:
        with contextlib.suppress(OSError):
            new.unlink(missing_ok=True)
        raise


def replace_text(path: Path, text: str) -> None:
    """Write a text in place of a file, if there is one.

    Raises:
        OSError: as for `replacing`.
    """
    with replacing(path) as new:
        new.write_text(text, encoding="utf-8")


def disk_reason(error: OSError) -> str:
    """Say why a file cannot be written."""
    return REASONS.get(error.errno or 0, str(error))
