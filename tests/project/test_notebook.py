# SPDX-License-Identifier: LGPL-3.0-or-later
"""The notebook of the demos runs from its first to its last cell and shows what it says."""

from __future__ import annotations

import contextlib
import io
import json
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import pytest

DEMOS = Path(__file__).parents[2] / "demos"


@pytest.mark.slow
@pytest.mark.pictures
def test_notebook(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    notebook = json.loads((DEMOS / "compare_results.ipynb").read_text("utf-8"))
    assert notebook["nbformat"] == 4
    cells = [each for each in notebook["cells"] if each["cell_type"] == "code"]
    # Outputs are made where it is run.
    assert not any(cell["outputs"] for cell in cells)
    monkeypatch.chdir(DEMOS)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    names: dict[str, Any] = {}
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        for cell in cells:
            exec(compile("".join(cell["source"]), "cell", "exec"), names)
    plt.close("all")
    left = {each.quantity: each for each in names["comparison"].quantities if each.edge == "left"}
    friction = [names[name].case.contacts["pad"].friction for name in ("pad", "rougher")]
    assert left["K_N"].verdict == left["ΔK_T"].verdict == "agrees"
    # (9) to its own error, half of d/a.
    assert left["d_2"].difference == pytest.approx(friction[0] / friction[1] - 1, abs=0.05)
    assert "edges.csv\n" in printed.getvalue()
