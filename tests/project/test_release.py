# SPDX-License-Identifier: LGPL-3.0-or-later
"""The version stands in pyproject.toml, and the files that must repeat it agree."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
VERSION = PROJECT["version"]


@pytest.mark.parametrize(
    ("file", "pattern"),
    [
        ("CITATION.cff", r"^version: (\S+)$"),
        ("codemeta.json", r'^  "version": "(\S+)",$'),
        ("debian/changelog", r"\Afretfe \((\S+)\) unstable;"),
        ("tools/conda/recipe.yaml", r'^  version: "(\S+)"$'),
        ("tools/spack/package.py", r'^    version\("(\S+)"\)$'),
    ],
)
def test_the_version_is_the_same(file: str, pattern: str) -> None:
    assert re.findall(pattern, (ROOT / file).read_text("utf-8"), re.MULTILINE) == [VERSION]


@pytest.mark.parametrize(
    ("file", "pattern", "renamed"),
    [
        ("tools/conda/recipe.yaml", "- {name} >={least}\n", {"matplotlib": "matplotlib-base"}),
        ("tools/spack/package.py", '"py-{name}@{least}:"', {}),
    ],
)
def test_other_packages_ask_for_the_same_versions(
    file: str, pattern: str, renamed: dict[str, str]
) -> None:
    text = (ROOT / file).read_text("utf-8")
    wanted = [each.split(">=") for each in PROJECT["dependencies"]]
    for name, least in wanted:
        assert pattern.format(name=renamed.get(name, name), least=least) in text


def test_the_changelog_begins_with_this_version_or_with_what_is_not_released() -> None:
    newest, *older = re.findall(r"^## (.*)$", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert newest == "Unreleased" or re.fullmatch(rf"{VERSION} \(\d{{4}}-\d\d-\d\d\)", newest)
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ \(\d{4}-\d\d-\d\d\)", each) for each in older)


def test_no_module_has_a_version_of_its_own() -> None:
    sources = [*ROOT.glob("fretfe/**/*.py"), ROOT / "CMakeLists.txt", ROOT / "debian/rules"]
    assert [path for path in sources if f'"{VERSION}"' in path.read_text("utf-8")] == []
