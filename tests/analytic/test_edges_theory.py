# SPDX-License-Identifier: LGPL-3.0-or-later
"""The worked examples of docs/theory.md print what stands below them."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

THEORY = Path(__file__).parents[2] / "docs" / "theory.md"
EXAMPLES: list[tuple[str, str]] = re.findall(
    r"```python\n(.*?)```\s+```text\n(.*?)```", THEORY.read_text(encoding="utf-8"), re.DOTALL
)


def test_every_example_has_its_output() -> None:
    assert len(EXAMPLES) == THEORY.read_text(encoding="utf-8").count("```python") >= 2


@pytest.mark.parametrize(("code", "output"), EXAMPLES)
def test_example(code: str, output: str) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, str(THEORY), "exec"), {})
    assert printed.getvalue() == output
