# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sections of other packages in the report."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from cases.stored_runs import solved
from harness.packages import EXAMPLE, write_package

from fretfe.report.page.html import draw_plots

WRONG = """
def wrong(run):
    return None

def failing(run):
    return 1 / 0
"""


def test_sections_of_other_packages_stand_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "other", raising=False)
    entries = "a = other:section\nb = other:wrong\nc = other:failing"
    write_package(tmp_path, "other", EXAMPLE + WRONG, "fretfe.sections", entries)
    *_, good, wrong, failing = draw_plots(solved("halfplane"))
    assert (good.anchor, good.title) == ("section-a", "My loads")
    assert good.plots[0].svg.startswith("<svg")
    assert wrong.intro == "'b' of other 1.0: expected a Section, found None"
    assert failing.intro == "'c' of other 1.0 failed: ZeroDivisionError: division by zero"
