# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Debian packages of docs/install.md are those that fretfe needs; a missing one is named."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    path = ROOT / "tools" / "debian" / "check_packages.py"
    spec = importlib.util.spec_from_file_location("check_packages", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_names_what_is_needed_and_nothing_else(tool: ModuleType) -> None:
    assert tool.packages_named() == tool.packages_needed()


def test_packages_of_requirements(tool: ModuleType) -> None:
    assert tool.package_of("numpy>=1.26") == "python3-numpy"
    assert tool.package_of("fenics-dolfinx>=0.9") == "python3-dolfinx-real"
    assert {"python3-tomli-w", "python3-pyvista", "xvfb"} <= tool.packages_needed()


def test_a_package_off_the_list_is_named(
    tool: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One in the middle of a line, and the last one of a command."""
    text = tool.PAGE.read_text("utf-8").replace(" python3-h5py ", " ").replace(" xauth\n", "\n")
    (tmp_path / "install.md").write_text(text)
    monkeypatch.setattr(tool, "PAGE", tmp_path / "install.md")
    assert tool.packages_needed() - tool.packages_named() == {"python3-h5py", "xauth"}


def test_a_package_that_is_missing_or_too_old_is_named(
    tool: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tool, "requirements", lambda: ["numpy>=999", "not-there>=1", "scipy>=1"])
    monkeypatch.setattr(tool, "OTHERS", {"g++": tool.command("no-such-command")})
    found = [each for each in tool.problems() if "install.md" not in each]
    names = [each.partition(":")[0] for each in found]
    assert names == ["python3-numpy", "python3-not-there", "g++"]
    assert "expected numpy>=999, found" in found[0] and "no-such-command" in found[2]


def field(file: str, name: str) -> set[str]:
    """Packages in a field of a control file, without versions and substitutions."""
    text = (ROOT / "debian" / file).read_text("utf-8")
    (value,) = re.findall(rf"^{name}:((?:.*\n)(?: .*\n)*)", text, re.MULTILINE)
    return set(
        re.findall(r"(?<![\w{:])[a-z0-9][a-z0-9.+-]+(?![\w:}])", value.replace("(= 13)", ""))
    )


def installed(page: str, comment: str) -> set[str]:
    """What the command below a comment of docs/install.md installs."""
    (command,) = re.findall(rf"^# {comment}.*\n(apt install(?:.*\\\n)*.*)", page, re.MULTILINE)
    return {word for word in command.split()[2:] if word not in ("\\", "--no-install-recommends")}


def test_the_package_depends_on_what_the_page_installs(tool: ModuleType) -> None:
    """What the metadata of the wheel require is added to Depends when the package is built."""
    page = tool.PAGE.read_text("utf-8")
    project = tomllib.loads(tool.PYPROJECT.read_text("utf-8"))["project"]
    required = {tool.package_of(each) for each in project["dependencies"]}
    assert field("control", "Depends") | required == installed(page, "to run")
    assert field("control", "Recommends") == installed(page, "for pictures")
    assert field("tests/control", "Depends") == installed(page, "for the tests")
    # g++ is in build-essential, python3-venv for the way without the package
    build = installed(page, "to build") - {"g++", "python3-venv"}
    assert build <= field("control", "Build-Depends")
