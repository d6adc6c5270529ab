# SPDX-License-Identifier: LGPL-3.0-or-later
"""Packages of one module with an entry point, as an installer leaves them in a folder."""

from __future__ import annotations

import re
from pathlib import Path

_PAGE = Path(__file__).parents[2] / "docs" / "backends.md"
# The module `other` that the page prints, a function for each group but that of backends.
EXAMPLE: str = re.findall(r"```python\n(.*?)```", _PAGE.read_text("utf-8"), re.DOTALL)[-1]


def write_package(folder: Path, name: str, source: str | None, group: str, entry: str) -> None:
    """Write a package.

    Args:
        folder: on the path of Python.
        name: of the package and of its module.
        source: of the module; None for none.
        group: of its entry point.
        entry: the entry point, as ``name = module:object``.
    """
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[{group}]\n{entry}\n")
    if source is not None:
        (folder / f"{name}.py").write_text(source)
