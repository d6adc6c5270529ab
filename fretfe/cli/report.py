# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe report`."""

from __future__ import annotations

from pathlib import Path

from fretfe.environment import rank_from_environment
from fretfe.report.page import write_report


def make_report(directory: Path) -> None:
    """Make report.html again from the results in a folder; on the first process.

    Raises:
        OutputError: if the folder has no complete set of results, or the file cannot be written.
    """
    if rank_from_environment() == 0:
        print(f"Report in {write_report(directory)}")
