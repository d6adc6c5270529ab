# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sections of other packages in the report."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from cases.stored_runs import solved
from harness.packages import write_package

from fretfe.report.page.html import draw_plots

SOURCE = """
from fretfe.report.page.html import Section
from fretfe.report.theme import make_plot

def section(run):
    plot = make_plot("mine", run.backend, "", 2.0, lambda figure: figure.subplots().plot([1, 2]))
    return Section("", "Mine", "Twice.", (plot,))

def wrong(run):
    return None

def failing(run):
    return 1 / 0
"""


def test_sections_of_other_packages_stand_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    entries = "a = mine:section\nb = mine:wrong\nc = mine:failing"
    write_package(tmp_path, "mine", SOURCE, "fretfe.sections", entries)
    *_, good, wrong, failing = draw_plots(solved("halfplane")).sections
    assert (good.anchor, good.title) == ("section-a", "Mine")
    assert good.plots[0].svg.startswith("<svg")
    assert wrong.intro == "'b' of mine 1.0: expected a Section, found None"
    assert failing.intro == "'c' of mine 1.0 failed: ZeroDivisionError: division by zero"
