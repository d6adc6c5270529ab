# SPDX-License-Identifier: LGPL-3.0-or-later
"""The README, the tutorials and the how-to pages say what works: every block of them is run.

Meshes and histories are coarser than on the page, and most pages do without pictures of bodies.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from harness.pages import ROOT, Reader

from fretfe.report.pictures import folder as pictures

DOCS = ROOT / "docs"
COARSER = {
    "size = 0.005 }": "size = 0.05 }",
    "size = 0.01 }": "size = 0.05 }",
    "size = 0.02 }": "size = 0.06 }",
    "size = 0.12 }": "size = 0.15, growth = 0.6 }",
    "edge_size = 0.002 }": "edge_size = 0.05, flank_size = 0.4 }",
    "edge_size = 0.004 }": "edge_size = 0.05, flank_size = 0.4 }",
    "edge_size = 0.004\n": "edge_size = 0.05\nflank_size = 0.4\n",
    "steps = 16 }": "steps = 4 }",
    "steps = 8 }": "steps = 2 }",
    "steps_per_cycle = 20": "steps_per_cycle = 8",
    "steps_per_cycle = 32": "steps_per_cycle = 8",
    "steps_per_cycle = 40": "steps_per_cycle = 8",
    "edge_size=0.0015": "edge_size=0.03",
    "cycles = 3": "cycles = 1",
    "tolerance = 0.01": "tolerance = 0.1",
    '"0.02 + 0.2*': '"0.05 + 0.4*',
    "stations = 40": "stations = 8",
}
QUICK = ("README.md", "docs/how-notebook.md")
# Pictures of bodies, by processes of their own, take half of the time of a run.
DRAWN = ("README.md", "docs/how-report.md")
PAGES = [*QUICK, "docs/sweep.md", "docs/new-geometry.md"]
PAGES += [f"docs/{path.name}" for kind in ("how", "tutorial") for path in DOCS.glob(f"{kind}-*")]
CHOSEN = [
    page if page in QUICK else pytest.param(page, marks=pytest.mark.slow)
    for page in sorted(set(PAGES))
]


@pytest.fixture
def reader(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Reader:
    """In a folder that has the case of the README."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    reader = Reader(tmp_path, COARSER)
    (case,) = re.findall(r"```toml\n(title = .*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    reader.save("pad.toml", case)
    return reader


def undrawn(directory: Path, files: Sequence[str]) -> dict[str, dict[str, str]]:
    return {file: {"reason": "it was not asked for"} for file in files}


@pytest.mark.parametrize("page", CHOSEN)
def test_page(page: str, reader: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    if page not in DRAWN:
        monkeypatch.setattr(pictures, "draw_in_child", undrawn)
    reader.follow(ROOT / page)
    assert reader.done
    plt.close("all")
