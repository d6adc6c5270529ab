# SPDX-License-Identifier: LGPL-3.0-or-later
"""A program that solves many cases one after the other on several ranks."""

from __future__ import annotations

from pathlib import Path

import pytest
from cases.b1_meshes import write_b1
from harness.launch import python

# Cases after which caches are full, and cases that must leave as many communicators as before.
WARM, COUNT = 2, 5

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[2])
from harness.soak import held
from fretfe.case import parse_case
from fretfe.fem._compat import MPI
from fretfe.fem.run import solve
from fretfe.loads import build_history

steel = {"young": 210e3, "poisson": 0.3}
press = {"type": "platen", "boundary": "pad_top", "direction": "y", "control": "displacement"}
case = parse_case({
    "model": {"degree": 1},
    "geometry": {"file": sys.argv[1]},
    "bodies": {"pad": steel, "substrate": steel},
    "contacts": {"main": {
        "surface1": "pad_contact", "surface2": "substrate_contact", "friction": 0.4}},
    "supports": {"base": {"boundary": "substrate_bottom", "fix": ["x", "y"]}},
    "loads": {"press": press | {"history": [{"ramp": -0.04, "until": 1.0, "steps": 1}]}},
})
warm, count = map(int, sys.argv[3:])
for number in range(warm + count):
    if number == warm:
        free = held().communicators
    solve(MPI.COMM_WORLD, case)
left = held().communicators
if MPI.COMM_WORLD.rank == 0:
    print("given back", left >= free)
"""


@pytest.mark.slow
def test_communicators_are_given_back(tmp_path: Path) -> None:
    write_b1(tmp_path / "pad.msh", order=1, h=0.2, growth=0.4)
    tests = Path(__file__).parents[1]
    counts = (str(each) for each in (WARM, COUNT))
    done = python("-c", SCRIPT, tmp_path / "pad.msh", tests, *counts, ranks=2, timeout=300)
    assert done.stdout.split() == ["given", "back", "True"], done.stderr
