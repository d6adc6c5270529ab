# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cases that several tests ask about, and their bodies, are solved and condensed once."""

from __future__ import annotations

import pytest
from harness.solving import _fast_processes, _processes, solved

from fretfe.runner import Runner

__all__ = ["_fast_processes", "_processes", "solved"]


@pytest.fixture(scope="session")
def runner() -> Runner:
    """Runs cases with finite elements into folders."""
    return Runner.find("fem")
