# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe verify`."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rich.console import Console
from rich.status import Status

from fretfe.api import verify
from fretfe.backends import Observer
from fretfe.environment import rank_from_environment
from fretfe.quality.verify.model import Benchmark, Row
from fretfe.quality.verify.report import as_numbers, print_rows, print_summary


class _Screen(Observer):
    """Tables on the standard output, and beside them what is at work; nothing if quiet."""

    def __init__(self, *, quiet: bool) -> None:
        self.console = Console(quiet=quiet)
        self._status = Status("", console=Console(stderr=True, quiet=quiet))

    def phase(self, text: str) -> None:
        """Name what is at work."""
        self._status.update(text)
        self._status.start()

    def show(self, benchmark: Benchmark, rows: Sequence[Row]) -> None:
        """Print the rows of a benchmark."""
        self._status.stop()
        print_rows(self.console, benchmark, rows)


def verify_backends(names: Sequence[str], *, as_json: bool) -> bool:
    """Run all benchmarks, print the comparisons, and return True if all is well.

    Collective if one of the backends is parallel.

    Args:
        names: of the backends; empty for all that are installed.
        as_json: print one JSON document at the end in place of tables.

    Raises:
        CaseError: if no backend of one of these names is installed.
    """
    first = rank_from_environment() == 0
    screen = _Screen(quiet=as_json or not first)
    found = verify(names, screen, screen.show)
    print_summary(screen.console, found.rows, found.seconds)
    if as_json and first:
        numbers = as_numbers(found.rows, found.seconds)
        print(json.dumps(numbers, indent=1, allow_nan=False), flush=True)
    return found.passed
