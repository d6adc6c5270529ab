# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `fretfe schema`."""

from __future__ import annotations

import json

from fretfe.cli.options import examples

EXAMPLES = examples("fretfe schema > case.schema.json")


def schema() -> None:
    """Print the JSON schema of case files."""
    from fretfe.case import case_schema

    print(json.dumps(case_schema(), indent=2))
