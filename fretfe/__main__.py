# SPDX-License-Identifier: LGPL-3.0-or-later
"""`python -m fretfe`: the same as the command `fretfe`."""

from __future__ import annotations

import sys

from fretfe.environment import missing_package
from fretfe.errors import DependencyError


def main() -> None:
    """Entry point of the command: without Typer there is no command line to say so."""
    try:
        from fretfe.cli import main as command_line
    except ImportError as error:
        if not (reason := missing_package(error)):
            raise
        print(f"fretfe: error: {reason}", file=sys.stderr)
        sys.exit(DependencyError.exit_code)
    command_line()


if __name__ == "__main__":
    main()
