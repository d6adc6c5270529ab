# SPDX-License-Identifier: LGPL-3.0-or-later
"""The version stands in pyproject.toml, and the files that must repeat it agree."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]


@pytest.mark.parametrize(
    ("file", "pattern"),
    [("CITATION.cff", r"^version: (\S+)$"), ("debian/changelog", r"\Afretfe \((\S+)\) unstable;")],
)
def test_the_version_is_the_same(file: str, pattern: str) -> None:
    assert re.findall(pattern, (ROOT / file).read_text("utf-8"), re.MULTILINE) == [VERSION]


def test_the_changelog_begins_with_this_version_or_with_what_is_not_released() -> None:
    newest, *older = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert newest == "Unreleased" or re.fullmatch(rf"{VERSION} \(\d{{4}}-\d\d-\d\d\)", newest)
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ \(\d{4}-\d\d-\d\d\)", each) for each in older)


def test_no_module_has_a_version_of_its_own() -> None:
    sources = [*ROOT.glob("fretfe/**/*.py"), ROOT / "CMakeLists.txt", ROOT / "debian/rules"]
    assert [path for path in sources if f'"{VERSION}"' in path.read_text("utf-8")] == []
