# SPDX-License-Identifier: LGPL-3.0-or-later
"""Results of finite elements compared with half-planes, and exported."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
from cases.pad_cases import cylinder, pad, press, shear

import fretfe
from fretfe.case import parse_case


@pytest.mark.slow
def test_finite_elements_beside_half_planes(tmp_path: Path) -> None:
    """The bodies are 20 half-widths wide: K_N is that of half-planes to .1 %."""
    loads = {"press": press(steps=2), "shear": shear(steps=8, cycles=1)}
    case = parse_case(pad(loads=loads, geometry=cylinder(size=0.02)))
    solid, plane = (fretfe.run(case, backend) for backend in ("fem", "halfplane"))
    comparison = fretfe.compare(plane, solid)
    found = {(each.edge, each.quantity): each for each in comparison.quantities}
    for edge in ("left", "right"):
        assert found[edge, "K_N"].verdict == "agrees" and found[edge, "ΔK_T"].verdict == "agrees"
        assert abs(found[edge, "K_N"].difference) < 0.02
    # Elements of .035 half-widths; p has roots at the edges and q peaks at both ends of stick.
    for pair in comparison.tractions:
        assert pair.pressure_difference < 0.02 and pair.shear_difference < 0.05
    assert "solved by halfplane and by fem" in comparison.notes
    (path,) = (path for path in fretfe.export(solid, tmp_path) if path.name == "edges.csv")
    with path.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["k_n [MPa/mm^0.5]"]) for row in rows] == pytest.approx(
        [edge["k_n"] for edge in solid.edges()]
    )
