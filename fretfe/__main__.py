# SPDX-License-Identifier: LGPL-3.0-or-later
"""`python -m fretfe`: the same as the command `fretfe`."""

from __future__ import annotations

import signal

TYPE_CHECKING = False  # that of typing takes long
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import NoReturn

    from fretfe.errors import FretfeError

# New objects after which Python looks for garbage among them.
COLLECTED = 5000
# Exit code of a process that Ctrl-C ends.
INTERRUPTED = 128 + signal.SIGINT


def main() -> None:
    """Entry point of the command: without Typer there is no command line to say so."""
    # While the libraries are loaded Ctrl-C ends the process without a word: nothing is lost.
    loading = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if loading:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    command_line = _load()
    if loading:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        command_line()
    except KeyboardInterrupt:
        # Before Typer listens or when it has ended.
        raise SystemExit(INTERRUPTED) from None


def _load() -> Callable[[], None]:
    """Load the command line, and set what has to be set before libraries are loaded."""
    import gc
    import os
    import sys
    import warnings

    from fretfe.environment import (
        LITTLE_ROOM,
        THREADS,
        memory_shortage,
        missing_package,
        threads_asked_for,
        too_little_room,
    )
    from fretfe.errors import DependencyError, MemoryShortError

    # As `few_threads`, before NumPy is imported: no BLAS begins any, nor other programs.
    if threads_asked_for() is None:
        os.environ[THREADS[-1]] = "1"
    # Loading the libraries makes hundreds of thousands of objects and no garbage, which a collector
    # that looks after every 700 of them looks for in a tenth of the time until a run begins.
    gc.set_threshold(COLLECTED)
    # What NumPy warns of is told by fretfe in its own words, or does not matter.
    if not sys.warnoptions:
        warnings.simplefilter("ignore", RuntimeWarning)
    if shortage := too_little_room(LITTLE_ROOM, "loading the libraries may take"):
        _end(MemoryShortError, shortage)
    try:
        from fretfe.cli.app import main as command_line
    except (ImportError, OSError, SystemError, MemoryError) as error:
        shortage = memory_shortage(error)
        if not (reason := shortage or missing_package(error)):
            raise
        _end(MemoryShortError if shortage else DependencyError, reason)
    return command_line


def _end(error: type[FretfeError], reason: str) -> NoReturn:
    import sys

    print(f"fretfe: error: {reason}", file=sys.stderr)
    sys.exit(error.exit_code)


if __name__ == "__main__":
    main()
