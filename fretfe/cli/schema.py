# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe schema`."""

from __future__ import annotations

import json

from fretfe.case import case_schema


def show_schema() -> None:
    """Print the JSON schema of case files."""
    print(json.dumps(case_schema(), indent=2))
