# SPDX-License-Identifier: LGPL-3.0-or-later
"""The Debian packages of docs/install.md are those that fretfe needs; a missing one is named."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

TOOL = Path(__file__).parents[1] / "tools" / "debian" / "check_packages.py"


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("check_packages", TOOL)
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
