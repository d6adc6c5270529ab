# SPDX-License-Identifier: LGPL-3.0-or-later
"""Margins of edges: what all criteria agree on, missing data, the command, its JSON."""

from __future__ import annotations

import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.solid_runs import stationed_sphere
from cases.stored_runs import solved, write_run
from decision.test_material import FATIGUE, write
from harness.packages import EXAMPLE, write_package
from typer.testing import CliRunner

import fretfe
from fretfe.cli.app import app
from fretfe.decision import assess as module
from fretfe.decision.assess import assess
from fretfe.decision.assessment import Assessment, Criterion, OtherCriterion
from fretfe.decision.field import EdgeField, edge_field
from fretfe.decision.near_field import NearField
from fretfe.decision.record import assessment_numbers
from fretfe.decision.texts import known_criteria
from fretfe.errors import CaseError

OF_STRESS = [each for each in Criterion if each is not Criterion.TESTS]
TESTS = """k_n [MPa/√mm],dk_t [MPa·√mm],life,runout,f,E [MPa],nu
900,20,1e6,0,0.4,210e3,0.3
1100,20,4e5,0,0.4,210e3,0.3
900,40,1e5,0,0.4,210e3,0.3
1100,40,5e4,0,0.4,210e3,0.3
1000,30,2e5,0,0.4,210e3,0.3
1400,30,1e5,0,0.4,210e3,0.3
1400,60,2e4,0,0.4,210e3,0.3
800,15,1e7,1,0.4,210e3,0.3
"""


def pulled(
    monkeypatch: pytest.MonkeyPatch, tension: list[float], spread: float = 0.0
) -> Assessment:
    """Edges under nothing but a uniaxial stress along the surface, and its error."""

    def uniform(*at: Any) -> EdgeField:
        field = edge_field(*at)
        assert isinstance(field, EdgeField)
        values = np.zeros((len(tension), 1, 4))
        values[:, 0, 0] = tension
        none = np.zeros((len(tension), 3))
        return replace(
            field,
            states=np.arange(len(tension)),
            near=NearField(np.array([-1.0, 0.0, 1.0]), none, none, 0.3),
            smooth=replace(field.smooth, values=values, spread=spread),
            other=np.arange(len(tension)),
        )

    monkeypatch.setattr(module, "edge_field", uniform)
    return assess(solved("halfplane"), Path("alloy.toml"))


def test_all_criteria_agree_on_the_fatigue_limit(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Half of the limit of reversed tension: the margin is two by each of them."""
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    found = pulled(monkeypatch, [124.0, -124.0])
    for edge in found.edges:
        for criterion in OF_STRESS[1:]:
            judgement = edge.of(criterion)
            assert judgement.margin == pytest.approx(2, rel=2e-3)
            assert judgement.low <= judgement.margin <= judgement.high
        assert edge.arrest is not None
        # Cracks of a tenth of a0, whose threshold is 5 % below the limit.
        assert edge.arrest.start == pytest.approx(2, rel=0.06)
        assert edge.arrest.deepest.stop == 0 and edge.life == math.inf
    assert found.length == pytest.approx((4.2 / 248) ** 2 / np.pi * 1000)


def test_a_small_tension_with_a_large_range_is_less_sure(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The interval of SWT by the error of the stress is that of both extremes, moved by it."""
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    edge = pulled(monkeypatch, [20.0, -200.0], 2.0).edges[0]
    judgement = edge.of(Criterion.POINT)
    used, of_factors = 1 / judgement.margin, edge.bar / judgement.margin
    assert used == pytest.approx(math.sqrt(20 * 110) / 248, rel=2e-3)
    half = used - 1 / judgement.high
    known = (math.sqrt(22 * 112) - math.sqrt(18 * 108)) / 2 / 248
    assert math.sqrt(half**2 - of_factors**2) == pytest.approx(known, rel=0.01)
    # The stress is the same everywhere, also at the first place: the margin has no lower end.
    assert judgement.place == pytest.approx(-5 * 0.0913, rel=1e-2)
    assert judgement.outermost and judgement.low == 0


def test_cracks_that_grow_have_a_life(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """dc/dN = C ΔK^3 with ΔK = 1.1215 σ √(π c), straight from the surface."""
    write(tmp_path)
    monkeypatch.chdir(tmp_path)
    found = pulled(monkeypatch, [280.0, -280.0])
    scale = 1.1215 * 280 * math.sqrt(math.pi)
    known = 2 * (1e-4**-0.5 - 2e-3**-0.5) / (1e-11 * scale**3)
    for edge in found.edges:
        assert edge.arrest is not None and edge.arrest.deepest.stop == math.inf
        assert edge.arrest.deepest.angle == 0
        assert edge.life == pytest.approx(known, rel=0.01)
    assert found.worst is not None and found.worst[1].margin < 1


def test_edges_of_a_run(tmp_path: Path) -> None:
    found = fretfe.assess(solved("halfplane"), write(tmp_path))
    assert [(each.edge, each.body) for each in found.edges] == [
        ("left", "upper"), ("left", "lower"), ("right", "upper"), ("right", "lower")
    ]  # fmt: skip
    worst = found.worst
    assert worst is not None
    for edge in found.edges:
        assert edge.of(Criterion.TESTS).reason == "no fretting tests are given"
        margins = [edge.of(each).margin for each in OF_STRESS]
        assert edge.governing is not None and edge.governing.margin == min(margins)
        # Both bodies and both edges are alike.
        assert margins == pytest.approx([worst[0].of(each).margin for each in OF_STRESS], rel=0.01)
        assert 0 < edge.bar < 0.05
    assert any("half-planes" in each for each in found.remarks)


def test_tests_beside_the_other_criteria(tmp_path: Path) -> None:
    table = tmp_path / "tests.csv"
    table.write_text(TESTS, "utf-8")
    path, result = write(tmp_path), solved("halfplane")
    found = assess(result, path, table, 2e5)
    margins = fretfe.strength_map(table, [result], 2e5).margins
    known = {each.edge.edge: (each.low, each.margin, each.high) for each in margins}
    for edge in found.edges:
        one = edge.of(Criterion.TESTS)
        assert not one.reason and (one.low, one.margin, one.high) == known[edge.edge]
    for given in ((table, None), (None, 1e6)):
        with pytest.raises(CaseError, match="tests together with a life"):
            assess(result, path, *given)


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        (EXAMPLE, ""),
        ("def margin(*_): return 1 / 0", "'mine' of other 1.0 failed: ZeroDivisionError: div"),
        ("def margin(*_): return float('nan')", "'mine' of other 1.0: expected a positive margin"),
        ("raise RuntimeError('no licence')", "'mine' of other 1.0 cannot be used: no licence"),
    ],
    ids=["right", "raises", "no number", "not loaded"],
)
def test_a_criterion_of_another_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str, reason: str
) -> None:
    """It is listed with the others, which it does not disturb."""
    result, path = solved("halfplane"), write(tmp_path)
    alone = fretfe.assess(result, path)
    write_package(tmp_path / "site", "other", source, "fretfe.criteria", "mine = other:margin")
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.delitem(sys.modules, "other", raising=False)
    found = fretfe.assess(result, path)
    for edge, before in zip(found.edges, alone.edges, strict=True):
        *others, mine = edge.judgements
        assert repr(others) == repr(list(before.judgements))
        assert mine.criterion == OtherCriterion("mine") and mine.reason.startswith(reason)
        if not reason:
            assert not mine.reason and 0 < mine.low < mine.margin < mine.high
    assert "mine" in assessment_numbers(found)["edges"][0]["criteria"]
    assert (found.edges[0].judgements[-1].criterion in known_criteria(found)) == (not reason)


def test_missing_data_are_named(tmp_path: Path) -> None:
    bare = {key: None for key in FATIGUE if key not in ("source", "units", "limit")}
    found = assess(solved("halfplane"), write(tmp_path, **bare))
    assert found.worst is None and math.isnan(found.length)
    for edge in found.edges:
        assert edge.governing is None and edge.arrest is None
        assert "fatigue.threshold" in edge.of(Criterion.ARREST).reason
        assert "fatigue.threshold" in edge.of(Criterion.AREA).reason
    plain = assess(solved("halfplane"), write(tmp_path, torsion=None, growth=None))
    assert "torsion" in plain.edges[0].of(Criterion.CROSSLAND).reason
    assert plain.edges[0].of(Criterion.POINT).margin > 0
    assert any("growth" in each for each in plain.remarks)
    coarse = assess(
        solved("halfplane"), write(tmp_path, threshold={**FATIGUE["threshold"], "range": 40.0})
    )
    assert "is needed down to" in coarse.edges[0].of(Criterion.POINT).reason
    assert not coarse.edges[0].of(Criterion.ARREST).reason
    late = assess(
        solved("halfplane"), write(tmp_path, threshold={"ratios": [0.7, 0.8], "ranges": [3.0, 2.0]})
    )
    assert "at the R of the limit, -1" in late.edges[0].of(Criterion.ARREST).reason
    # a0 is 2.3 m.
    tough = {"threshold": {**FATIGUE["threshold"], "range": 60.0}, "torsion": None}
    weak = {"limit": {"range": 40.0, "ratio": -1.0}}
    huge = assess(solved("halfplane"), write(tmp_path, **tough, **weak))
    assert "less than the shortest cracks" in huge.edges[0].of(Criterion.ARREST).reason


def test_edges_that_are_not_judged(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.write_text(path.read_text("utf-8").replace("young = 210.0", "young = 70.0"), "utf-8")
    found = assess(solved("halfplane"), path)
    assert found.worst is None
    assert all("E = 2.1e+05" in each.of(Criterion.ARREST).reason for each in found.edges)
    incomplete = assess(solved("incomplete"), write(tmp_path))
    assert {each.of(Criterion.POINT).reason for each in incomplete.edges} == {
        "the run is not complete"
    }
    result = solved("halfplane")
    bare = replace(result, contacts=(replace(result.contacts[0], fronts=()),))
    assert any("no edge" in each for each in assess(bare, path).remarks)
    round_one = assess(stationed_sphere(), write(tmp_path))
    assert [(each.edge, each.body) for each in round_one.edges] == [
        ("front 1", "upper"), ("front 1", "lower")
    ]  # fmt: skip
    assert round_one.worst is None
    for each in round_one.edges:
        (reason,) = each.lost
        assert "stress_depths" in reason and each.lost[reason] == tuple(range(12))


def test_the_numbers_are_json(tmp_path: Path) -> None:
    found = assess(solved("halfplane"), write(tmp_path))
    numbers = json.loads(json.dumps(assessment_numbers(found), allow_nan=False))
    assert numbers["schema"] == {"name": "fretfe-assessment", "version": 1}
    edge = numbers["edges"][1]
    assert list(edge["criteria"]) == [each.value for each in Criterion]
    known = found.edges[1].of(Criterion.POINT)
    assert edge["criteria"]["SWT, point"]["margin"] == known.margin
    # Infinite: null, and no reason.
    assert edge["criteria"]["arrest of cracks"] == {
        "margin": None, "low": None, "high": None, "place": None, "reason": "",
        "outermost": False, "station": -1, "end": "", "to_end": None, "range": [None, None],
    }  # fmt: skip
    assert numbers["worst"]["criterion"] in edge["criteria"]


def test_the_command(tmp_path: Path) -> None:
    run, path = write_run(tmp_path / "run", "halfplane"), write(tmp_path)
    words = ["assess", str(run), "--material", str(path)]
    out = tmp_path / "out"
    done = CliRunner().invoke(app, [*words, "--at-least", "0.01", "-o", str(out)])
    assert done.exit_code == 0 and "assessment.html and assessment.json" in done.output
    assert {each.name for each in out.iterdir()} == {"assessment.html", "assessment.json"}
    assert "edge of main" in done.output and "unknown (fretting tests)" in done.output
    assert "∞" in done.output and "smallest and largest likely friction" in done.output
    margin = assess(fretfe.load_result(run), path).worst
    assert margin is not None
    told = CliRunner().invoke(app, [*words, "--json", "--at-least", str(1.01 * margin[1].margin)])
    assert told.exit_code == 1
    assert json.loads(told.output)["worst"]["margin"] == pytest.approx(margin[1].margin)
