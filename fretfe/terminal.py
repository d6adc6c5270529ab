# SPDX-License-Identifier: LGPL-3.0-or-later
"""Standard streams that show the texts of others, and that need not have room for what is printed.

Names and texts in files of others may hold what a terminal takes for commands: to move the cursor,
to clear lines, to change its title. Whatever is printed goes through `shown`, by `print` and by
`fretfe.console.Console`.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import sys
from collections.abc import Callable, Iterator
from typing import Any, TextIO, cast

# Control characters but the end of a line and the tabulator, and those that turn the direction of
# a text or end a line elsewhere.
COMMANDS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")
# Pictures of the first control characters, in their order.
PICTURES = 0x2400


def shown(text: str) -> str:
    """A text without what a terminal would take for commands: a picture stands for each of them."""
    return COMMANDS.sub(lambda found: _picture(ord(found[0])), text)


def one_line(text: str) -> str:
    """A text in one line, as in a comment: all that separates words is a blank."""
    return shown(" ".join(text.split()))


def _picture(code: int) -> str:
    return chr(PICTURES + code) if code < 0x20 else "\N{REPLACEMENT CHARACTER}"


class Shown:
    """A standard stream to which anything may be printed, and that never fails.

    What it cannot encode is written as Python would. What it cannot take is lost: a run goes on
    when whoever reads its output has ended, or the disk of a log is full.

    Args:
        stream: to be written to.
        foreign: whether commands to a terminal are taken out; `Console` does that itself.

    Attributes:
        failure: the first error, or None.
    """

    def __init__(self, stream: TextIO, *, foreign: bool = True) -> None:
        self._stream, self._foreign = stream, foreign
        self.failure: OSError | None = None
        # This is what Console writes to: its colours are commands too.
        self.rich_proxied_file: Any = Shown(stream, foreign=False) if foreign else self

    def write(self, text: str) -> int:
        """Write a text."""
        self._attempt(lambda: self._stream.write(shown(text) if self._foreign else text))
        return len(text)

    def flush(self) -> None:
        """Write all of it."""
        self._attempt(self._stream.flush)

    def _attempt(self, work: Callable[[], object]) -> None:
        try:
            work()
        except OSError as error:
            self.failure = self.failure or error
            # What waits to be written would fail once more when Python ends.
            with contextlib.suppress(OSError, ValueError):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, self._stream.fileno())
                os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        """All else is that of the stream."""
        return getattr(self._stream, name)


@contextlib.contextmanager
def patient_streams() -> Iterator[Callable[[], OSError | None]]:
    """Have standard output and standard error take everything.

    Yields:
        A function that writes what waits, and returns why some of the standard output is lost; None
        if nothing is, or whoever read it has ended.
    """
    before = sys.stdout, sys.stderr
    for each in before:
        if hasattr(each, "reconfigure"):
            each.reconfigure(errors="backslashreplace")
    # They are None if they were closed before Python started.
    output, errors = (None if each is None else Shown(each) for each in before)
    sys.stdout, sys.stderr = cast("TextIO", output), cast("TextIO", errors)

    def lost() -> OSError | None:
        for each in (output, errors):
            if each is not None:
                each.flush()
        if output is None:
            return None
        found: OSError | None = output.failure or output.rich_proxied_file.failure
        return None if found is None or found.errno == errno.EPIPE else found

    try:
        yield lost
    finally:
        lost()
        sys.stdout, sys.stderr = before
