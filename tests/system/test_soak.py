# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many runs in one process leave nothing behind; `python -m harness.soak` makes two thousand."""

from __future__ import annotations

import pytest
from harness import soak
from harness.plots import whole_plots


@pytest.mark.slow
def test_runs_leave_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fifty runs after a hundred, five of them with files and one with a report more."""
    monkeypatch.setattr(soak, "WARM", 100)
    monkeypatch.setattr(soak, "REPORT", 50)
    with whole_plots():
        before, after = soak.soak(150)
    assert after.memory - before.memory < 5
    assert after.files <= before.files
    assert after.communicators >= before.communicators
    assert after.figures <= before.figures
