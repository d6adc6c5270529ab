# SPDX-License-Identifier: LGPL-3.0-or-later
"""Libraries that crash, end or hang while they read a file take no more with them than the file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import pad
from cases.tiny_meshes import TWO_SQUARES
from harness import failing_works

from fretfe.case import parse_case
from fretfe.errors import CaseError, MeshError
from fretfe.mesh.contained import raw_mesh_of, read_raw, write_raw
from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.surface.checks import load_mesh

HANGING = (failing_works.hang, failing_works.hang_later)


def children() -> list[str]:
    return Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()


@pytest.mark.parametrize(
    ("work", "expected"),
    [
        (failing_works.abort, r"crashed \(SIGABRT\)"),
        (failing_works.segmentation, r"crashed \(SIGSEGV\)"),
        (failing_works.leave, r"ended \(exit code 0\)"),
        (failing_works.hang, r"reading it, .* was ended after 3 s"),
        (failing_works.hang_later, r"reading it, .* was ended after 4 s"),
        (failing_works.eat, "more memory than the machine has"),
    ],
)
def test_a_library_that_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, work: Any, expected: str
) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(failing_works.__file__).parents[1]))
    path, before = TWO_SQUARES.write(tmp_path / "m.msh"), children()
    with pytest.raises(MeshError, match=rf"m\.msh: .*{expected}"):
        # Time enough for a process to start on a busy machine, except where it is to run out.
        raw_mesh_of(work, path, reading=3.0 if work in HANGING else 100.0)
    assert children() == before


def test_a_script_that_ends_gmsh(tmp_path: Path) -> None:
    (tmp_path / "pad.geo").write_text("Point(1) = {0, 0, 0};\nExit;\n")
    case = parse_case(pad(geometry={"file": "pad.geo"}), tmp_path / "case.toml", trust_geo=True)
    with pytest.raises(MeshError, match=r"pad\.geo: .*Exit in a Gmsh script"):
        load_mesh(case)


@pytest.mark.parametrize("name", ["pad.msh", "pad.inp", "pad.geo"])
def test_pipes_and_devices_are_not_opened(tmp_path: Path, name: str) -> None:
    """Reading a pipe would wait for ever, a device might never end."""
    case = parse_case(pad(geometry={"file": name}), tmp_path / "case.toml", trust_geo=True)
    os.mkfifo(tmp_path / name)
    with pytest.raises((CaseError, MeshError), match="expected a file, found a pipe"):
        load_mesh(case)
    (tmp_path / name).unlink()
    (tmp_path / name).symlink_to("/dev/zero")
    with pytest.raises((CaseError, MeshError), match="expected a file, found a device"):
        load_mesh(case)


def test_meshes_are_handed_over_as_they_are(tmp_path: Path) -> None:
    names = ("a/b", "µ", "head", "x" * 300)
    block = ElementBlock(2, np.array([[0, 1, 2]]))
    raw = RawMesh(
        np.array([[0.1, 1e300, -1 / 3]]),
        3,
        {name: [block, ElementBlock(9, np.empty((0, 6), dtype=np.int64))] for name in names},
        {"points": [block]},
    )
    write_raw(tmp_path / "raw.npz", raw)
    found = read_raw(tmp_path / "raw.npz")
    assert found.dimension == 3
    np.testing.assert_array_equal(found.points, raw.points)
    assert [*found.bodies, *found.boundaries] == [*names, "points"]
    assert [each.gmsh_type for each in found.bodies["a/b"]] == [2, 9]
    np.testing.assert_array_equal(found.bodies["µ"][0].nodes, block.nodes)
    assert found.bodies["head"][1].nodes.shape == (0, 6)
