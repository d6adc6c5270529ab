# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mission of the demos by closed forms: its worst cycle, and all cycles on disk."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import fretfe
from fretfe.report.page.tables import cycle_table

DEMO = Path(__file__).parents[2] / "demos" / "mission.toml"


def test_worst_cycle_and_files(tmp_path: Path) -> None:
    fretfe.run(fretfe.load_case(DEMO), output=tmp_path, backend="halfplane")
    result = fretfe.load_result(tmp_path)
    load = 110 * np.loadtxt(DEMO.with_name("mission.csv"), delimiter=",", skiprows=1)[:, 1]
    a = float(result.contacts[0].half_width[-1])
    rows = list(csv.DictReader((tmp_path / "cycles.csv").read_text("utf-8").splitlines()))
    for edge in result.contacts[0].stations:
        cycles = edge.cycles
        worst = cycles.worst
        # All cycles of a mission that repeats itself: the way up and down is in one of them.
        factor = 1 / (np.pi * np.sqrt(2 * a))
        assert cycles.k_t_range[worst] == pytest.approx(np.ptp(load) * factor, rel=1e-9)
        way = np.abs(np.diff(load)).sum() * factor
        assert 2 * cycles.k_t_range.sum() == pytest.approx(way, rel=1e-9)
        assert cycles.start.dtype == np.int64
        extremes = result.loads.values[[cycles.start[worst], cycles.end[worst]], 1]
        assert sorted(extremes) == pytest.approx([load.min(), load.max()])
        exact = a * (1 - np.sqrt(1 - np.ptp(load) / (2 * 0.4 * 600)))
        assert len(edge.slip_zones) == 2
        assert all(abs(zone.length - exact) < zone.spread for zone in edge.slip_zones)
        own = [row for row in rows if row["front"] == edge.front]
        assert len(own) == len(cycles.count)
        (marked,) = [row for row in own if row["worst"] == "True"]
        assert float(marked["k_t_range"]) == pytest.approx(np.ptp(load) * factor)
    assert cycle_table(result) is not None


def test_regular_loads_have_no_file(tmp_path: Path) -> None:
    result = fretfe.run(
        fretfe.load_case(DEMO.with_name("hertz.toml")), output=tmp_path, backend="halfplane"
    )
    assert not (tmp_path / "cycles.csv").exists()
    assert cycle_table(result) is None
    assert all(edge.cycles.count.tolist() == [1.0] for edge in result.contacts[0].stations)
