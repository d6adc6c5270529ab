# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that several tests ask about, and their bodies, are solved and condensed once."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import pytest

from fretfe.case import parse_case
from fretfe.fem.backend import BACKEND
from fretfe.results.model import Result

Solve = Callable[[dict[str, Any]], Result]


@pytest.fixture(scope="session")
def solved() -> Iterator[Solve]:
    """Solve a case given as tables, unless a test before did; the result is not to be changed."""
    session = BACKEND.session()

    @cache
    def once(text: str) -> Result:
        return session.solve(parse_case(json.loads(text)))

    yield lambda tables: once(json.dumps(tables))
    session.close()
