# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lists of what is installed: a plug-in that is broken is named beside the others."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from harness.packages import write_package

import fretfe
from fretfe.cli.lists import info, materials, templates


@pytest.mark.parametrize(
    ("listed", "group", "own"),
    [(materials, "fretfe.materials", "steel"), (templates, "fretfe.templates", "cylinder")],
)
def test_a_broken_plug_in_hides_no_other(
    listed: Callable[[None], None], group: str, own: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setenv("COLUMNS", "300")
    monkeypatch.syspath_prepend(tmp_path)
    write_package(tmp_path, "broken_list", "1 / 0", group, "lost = broken_list:path")
    listed(None)
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert any(line.startswith(f"{own} ") for line in lines)
    assert any(
        line.startswith("lost not usable: 'lost' of broken_list 1.0 cannot be used: division by")
        for line in lines
    ), lines


def test_info_tells_versions_where_dolfinx_and_gmsh_cannot_be_used(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # Python takes None for a module that is not there.
    for name in ("fretfe.fem._compat", "fretfe.mesh.gmsh"):
        monkeypatch.setitem(sys.modules, name, None)
        package, _, module = name.rpartition(".")
        if package in sys.modules:  # which knows what another test has imported
            monkeypatch.delattr(sys.modules[package], module, raising=False)
    info()
    told = capsys.readouterr().out
    assert f"fretfe       {fretfe.__version__}" in told
    assert "\ndolfinx      cannot be used: " in told and "\ngmsh         cannot be used: " in told
