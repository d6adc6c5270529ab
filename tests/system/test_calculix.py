# SPDX-License-Identifier: LGPL-3.0-or-later
"""A flank that a run of CalculiX drives, against a run of the whole in one piece.

CalculiX has the contact by a penalty, on elements fifty times as large as those of the flank: of
its run only the displacements of the cuts are used.
"""

from __future__ import annotations

import runpy
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fretfe.case import parse_case
from fretfe.evaluate.contacts import Contact
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.loads import build_history

CCX = shutil.which("ccx")
TOOL = runpy.run_path(str(Path(__file__).parents[2] / "tools" / "calculix.py"))
DEMO = Path(__file__).parents[2] / "demos" / "dovetail.toml"
COARSE = {"edge_size": 0.1, "flank_size": 0.2, "growth": 0.5}
FINE = {"edge_size": 0.002}
CYCLE = {"start": 2.0, "end": 4.0}
# The middle of the left flank, and three half-widths of its contact.
CENTRE, RADIUS = (-10.663, -0.049), 6.5
HISTORY = [
    {"ramp": 3900.0, "until": 1.0, "steps": 2},
    {"ramp": 2400.0, "until": 2.0, "steps": 2},
    {"ramp": 3600.0, "until": 3.0, "steps": 2},
    {"ramp": 2400.0, "until": 4.0, "steps": 2},
]


def dovetail(sizes: dict[str, float]) -> dict[str, Any]:
    data: dict[str, Any] = tomllib.loads(DEMO.read_text())
    data["geometry"]["parameters"] |= sizes
    data["loads"]["pull"]["history"] = HISTORY
    data["cycle"] = dict(CYCLE)
    return data


def flank(file: Path) -> dict[str, Any]:
    """The case of the part."""
    data = dovetail(FINE)
    times = build_history(parse_case(data)).times[1:].tolist()
    data["geometry"]["part"] = {"centre": list(CENTRE), "radius": RADIUS}
    data["contacts"].pop("right")
    data.pop("supports")
    moved = {"type": "field", "file": str(file), "history": [{"times": times, "values": times}]}
    data["loads"] = {f"{name}_cut": {"boundary": f"{name}_cut", **moved} for name in data["bodies"]}
    return data


def left_flank(data: dict[str, Any]) -> Contact:
    outcome = solve(MPI.COMM_WORLD, parse_case(data))
    assert outcome.failure is None
    return outcome.contacts[0]


@pytest.mark.slow
@pytest.mark.skipif(CCX is None, reason="needs CalculiX: ccx, of Debian's calculix-ccx")
def test_a_run_of_calculix_drives_a_flank(tmp_path: Path) -> None:
    """The 2 % are between programs.

    P is 1.5 % larger than in one piece, in proportion to the deformation: of bodies ten times as
    stiff it is 0.2 %.
    """
    found = left_flank(flank(TOOL["run_calculix"](tmp_path, dovetail(COARSE))))
    expected = left_flank(dovetail(FINE))
    np.testing.assert_allclose(found.normal_force[1:], expected.normal_force[1:], rtol=0.02)
    for own, whole in zip(found.stations, expected.stations, strict=True):
        np.testing.assert_allclose(own.k_n[1:], whole.k_n[1:], rtol=0.02)
        assert own.k_t_range == pytest.approx(whole.k_t_range, rel=0.02)
        zones = [[zone.length for zone in each.slip_zones[-2:]] for each in (own, whole)]
        np.testing.assert_allclose(zones[0], zones[1], rtol=0.02)
