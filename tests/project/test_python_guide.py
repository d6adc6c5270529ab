# SPDX-License-Identifier: LGPL-3.0-or-later
"""The examples of docs/python.md print what stands below them."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "python.md").read_text("utf-8")
EXAMPLES = re.findall(r"```python\n(.*?)```\s+```text\n(.*?)```", GUIDE, re.DOTALL)


def test_examples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One after the other, with the case of the README."""
    assert len(EXAMPLES) == GUIDE.count("```python") == 4
    readme = (ROOT / "README.md").read_text("utf-8")
    (case,) = re.findall(r"```toml\n(title = .*?)```", readme, re.DOTALL)
    (tmp_path / "pad.toml").write_text(case)
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    for code, output in EXAMPLES:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, "python.md", "exec"), names)
        assert printed.getvalue() == output
    assert (tmp_path / "factors.png").exists()
