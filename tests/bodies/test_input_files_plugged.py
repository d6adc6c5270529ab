# SPDX-License-Identifier: LGPL-3.0-or-later
"""Materials and templates of other packages: found by name, checked, and part of what a run is."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from cases.pad_cases import pad, press
from harness.packages import EXAMPLE, write_package

from fretfe.bodies.input_files import input_digests
from fretfe.case import parse_case
from fretfe.case.materials import find_material, material_names
from fretfe.errors import CaseError, DependencyError
from fretfe.mesh.templates import find_template, template_directory, template_names

MATERIAL = 'source = "a book"\nyoung = 70e3\npoisson = 0.33\nunits.stress = "MPa"\n'
SOURCE = """
from pathlib import Path

def path():
    return Path(__file__).with_name("joint.geo")
"""


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "site"
    monkeypatch.syspath_prepend(folder)
    for name in ("other", "joints"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return folder


def test_a_material_of_another_package(site: Path) -> None:
    write_package(site, "other", EXAMPLE, "fretfe.materials", "Al-2024 = other:alloy")
    (site / "alloy.toml").write_text(MATERIAL)
    assert material_names()[-1] == "Al-2024"
    body = {"material": "Al-2024"}
    case = parse_case(pad(bodies={"upper": body, "lower": body}, loads={"press": press()}))
    assert case.bodies["upper"].young == 70e3  # type: ignore[union-attr]
    with pytest.raises(CaseError, match=r"'Al-2024'.* did you mean 'Al-2024'"):
        find_material("Al-2025", Path())
    (site / "alloy.toml").unlink()
    with pytest.raises(DependencyError, match=r"'Al-2024' of other 1\.0: expected the Path of a"):
        find_material("Al-2024", Path())


def test_a_template_of_another_package(site: Path) -> None:
    write_package(site, "joints", SOURCE, "fretfe.templates", "joint = joints:path")
    own = template_directory() / "cylinder.geo"
    (site / "joint.geo").write_text(own.read_text())
    assert template_names()[-1] == "joint"
    assert find_template("joint").parameters == find_template("cylinder").parameters
    tables = pad(loads={"press": press()})
    tables["geometry"]["template"] = "joint"
    before = input_digests(parse_case(tables))
    assert list(before) == [str(site / "joint.geo")]
    (site / "joint.geo").write_text("// other\n" + own.read_text())
    assert input_digests(parse_case(tables)) != before
    assert input_digests(parse_case(pad(loads={"press": press()}))) == {}


def test_names_of_fretfe_come_first(site: Path) -> None:
    entry = "cylinder = joints:path\nsphere = joints:path"
    write_package(site, "joints", "def path(): return None", "fretfe.templates", entry)
    assert find_template("cylinder").path.parent == template_directory()
    assert template_names().count("cylinder") == 1
