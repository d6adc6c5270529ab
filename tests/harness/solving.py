# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fixtures of tests with finite elements: what several ask about is solved once."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from harness.mesh_server import mesh_server

from fretfe.case import parse_case
from fretfe.fem.backend import BACKEND
from fretfe.mesh import contained
from fretfe.results.model import Result

# Here the processes that read meshes are what is tested.
REAL_PROCESSES = {"test_contained", "test_user_geometry_script"}
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


@pytest.fixture(scope="session")
def _processes() -> Iterator[object]:
    with mesh_server() as processes:
        yield processes


@pytest.fixture(scope="module", autouse=True)
def _fast_processes(request: pytest.FixtureRequest) -> Iterator[None]:
    """Meshes are read by processes that need not import anything."""
    if Path(request.module.__file__).stem in REAL_PROCESSES:
        yield
        return
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contained, "subprocess", request.getfixturevalue("_processes"))
        yield
