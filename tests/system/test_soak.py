# SPDX-License-Identifier: LGPL-3.0-or-later
"""Many runs in one process leave nothing behind; `python -m harness.soak` makes two thousand."""

from __future__ import annotations

import pytest
from harness import soak
from harness.plots import whole_plots


@pytest.mark.slow
def test_runs_leave_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forty runs after twenty, four of them with files and one with a report more: +1.1 MB."""
    monkeypatch.setattr(soak, "WARM", 20)
    monkeypatch.setattr(soak, "REPORT", 50)
    with whole_plots():
        before, after = soak.soak(60)
    assert after.memory - before.memory < 5
    assert after.files <= before.files
    assert after.communicators >= before.communicators
    assert after.figures <= before.figures
