# SPDX-License-Identifier: LGPL-3.0-or-later
"""Before a commit git checks what `make lint` checks."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_hooks_run_what_make_lint_runs() -> None:
    makefile = (ROOT / "Makefile").read_text("utf-8")
    recipe = re.search(r"^lint:.*\n((?:\t.*\n)+)", makefile, re.MULTILINE)
    assert recipe is not None
    commands = recipe[1].replace("\t$(BIN)", ".venv/bin").replace(" $(CPP)", "").splitlines()
    hooks = (ROOT / ".pre-commit-config.yaml").read_text("utf-8")
    assert re.findall(r"^ *entry: (.*)$", hooks, re.MULTILINE) == commands
