# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe report`; the first process writes."""

from __future__ import annotations

from fretfe.cli.options import Results, examples
from fretfe.environment import rank_from_environment

EXAMPLES = examples("fretfe report pad")


def report(directory: Results) -> None:
    """Make report.html again from the results in a folder."""
    from fretfe.report.page.html import write_report
    from fretfe.results.reader import read_numbers
    from fretfe.results.run_folder import locked

    if rank_from_environment() > 0:
        return
    read_numbers(directory)
    with locked(directory):
        path = write_report(directory)
    print(f"Report in {path}")
