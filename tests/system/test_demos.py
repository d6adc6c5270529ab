# SPDX-License-Identifier: LGPL-3.0-or-later
"""The demos end with computed against expected values: none of them may be off.

Sweeps have fewer values: those that something is known of.
"""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path

import pytest
from campaign.extent import every_so_many_weeks
from harness.launch import python

DEMOS = Path(__file__).parents[2] / "demos"
SCRIPTS = sorted(path for path in DEMOS.glob("*.py") if path.stem != "compare")
# `make docs` runs these, and ends if a value is off.
GALLERY = runpy.run_path(str(DEMOS.parent / "tools" / "site" / "gallery.py"))["SHOWN"]
MAPS = "applicability"
OTHERS = [path for path in SCRIPTS if path.stem not in (*GALLERY, MAPS)]
# Those that take longest take turns; pages and tests of crystals and parts do the like each time.
TURNS = {"crystal": 0, "submodel": 1}
# Its maps have 112 cells of a second each: the corners of each panel draw the same figure.
CORNERS = """
import sys; sys.path.insert(0, sys.argv[1])
from pathlib import Path
import applicability as demo
demo.PROFILES = dict(list(demo.PROFILES.items())[::3])
demo.LEVELS, demo.PHASES, demo.VARIATIONS = (each[[0, -1]] for each in
    (demo.LEVELS, demo.PHASES, demo.VARIATIONS))
demo.draw(Path("maps.png"))
demo.finish(demo.by_shear_alone())
"""

# Fewer values, steps and elements where what is known holds with any of them: mirror images and
# balance to round-off (crystal, firtree), numbers of two ways on meshes of the same sizes.
COARSER = {"geometry.parameters.edge_size": 0.006}
FEWER = {
    "crystal.py": [("[15.0, 30.0, 45.0, 60.0]", "[30.0, 60.0]")],
    "crystal.toml": [
        ("edge_size = 0.0025", "edge_size = 0.008"),
        ("growth = 0.3", "growth = 0.5"),
        ("cycles = 2", "cycles = 1"),
    ],
    "firtree.toml": [
        ("edge_size = 0.003", "edge_size = 0.012"),
        ("_cycle = 16", "_cycle = 8"),
    ],
    "flat_rounded.toml": [("steps_per_cycle = 40", "steps_per_cycle = 16")],
    "friction_sweep.py": [("[0.4, 0.5, 0.6, 0.7, 0.8]", "[0.4, 0.6, 0.8]")],
    "own_geometry.toml": [
        ("steps_per_cycle = 40", "steps_per_cycle = 16"),
        ("tolerance = 0.01", "tolerance = 0.02"),
    ],
    "dovetail.toml": [
        ("steps = 16", "steps = 6"),
        ("steps = 8", "steps = 3"),
        ("cycles = 3, steps_per_cycle = 32", "cycles = 2, steps_per_cycle = 16"),
    ],
    "submodel.py": [
        ("size=0.002", "size=0.006"),
        ("load_case(CASE)", f"load_case(CASE, {COARSER})"),
    ],
}


@pytest.fixture(scope="module")
def demos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the demos."""
    folder = Path(shutil.copytree(DEMOS, tmp_path_factory.mktemp("demos") / "demos"))
    for name, changes in FEWER.items():
        text = (folder / name).read_text("utf-8")
        for all_of_them, some in changes:
            assert all_of_them in text
            text = text.replace(all_of_them, some)
        (folder / name).write_text(text, "utf-8")
    return folder


def test_there_are_demos() -> None:
    assert len(SCRIPTS) >= 8


def test_a_value_that_is_off_makes_a_demo_fail() -> None:
    text = "from compare import Row, finish; finish([Row('a', 1.02, 1.0, 0.01)])"
    done = python("-c", f"import sys; sys.path.insert(0, {str(DEMOS)!r}); {text}")
    assert done.returncode == 1
    assert "<-- off" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    "script",
    [
        pytest.param(
            path,
            id=path.stem,
            marks=[every_so_many_weeks(2, TURNS[path.stem])] if path.stem in TURNS else [],
        )
        for path in OTHERS
    ],
)
def test_demo(script: Path, demos: Path, tmp_path: Path) -> None:
    done = python(demos / script.name, timeout=600, folder=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "computed" in done.stdout


@pytest.mark.slow
def test_maps_of_the_edge_formulas(tmp_path: Path) -> None:
    done = python("-c", CORNERS, DEMOS, timeout=600, folder=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "computed" in done.stdout
    assert (tmp_path / "maps.png").stat().st_size > 10_000
