# SPDX-License-Identifier: LGPL-3.0-or-later
"""The page of an assessment and its sentences: first the answer, how sure, and what is missing."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from io import StringIO
from pathlib import Path

import pytest
from cases.solid_runs import stationed_sphere
from cases.stored_runs import CYCLE, solved, write_run
from decision.test_material import FATIGUE, write
from rich.console import Console
from rich.measure import Measurement

from fretfe.backends import RunOptions
from fretfe.backends.halfplane import BACKEND
from fretfe.case import parse_case
from fretfe.decision import field
from fretfe.decision.assess import assess
from fretfe.decision.assessment import Assessment, Criterion, Judgement
from fretfe.decision.page import write_assessment
from fretfe.decision.texts import answer, details, margin_tables
from fretfe.errors import CaseError, OutputError
from fretfe.loads import build_history
from fretfe.report.texts import rounded
from fretfe.results.model import Result


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Assessment:
    return assess(solved("halfplane"), write(tmp_path_factory.mktemp("data")))


def with_friction(friction: float) -> Result:
    """The same pad under the same loads."""
    main = {**CYCLE["contacts"]["main"], "friction": friction}
    case = parse_case({**CYCLE, "contacts": {"main": main}})
    found = BACKEND.solve(case, RunOptions(history=build_history(case)))
    return replace(found, backend="halfplane")


def test_range_over_results_of_other_friction(known: Assessment, tmp_path: Path) -> None:
    found = replace(known, others=(assess(with_friction(0.8), write(tmp_path)),))
    for edge, other in zip(found.edges, found.others[0].edges, strict=True):
        for criterion in list(Criterion)[2:]:
            margins = [each.of(criterion).margin for each in (edge, other)]
            assert found.range_of(edge, criterion) == (min(margins), max(margins))
            assert margins[0] != margins[1]
        # Unknown in one, unknown in all.
        assert math.isnan(found.range_of(edge, Criterion.TESTS)[0])
    first, sure, wanted = answer(found)
    assert first.startswith("Worst is body") and "over 2 results" in sure
    second = found.others[0]
    assert second.worst is not None and found.worst is not None
    edges = tuple(
        replace(each, judgements=(Judgement(Criterion.TESTS, 0.1), *each.judgements[1:]))
        for each in second.edges
    )
    worse = replace(found, others=(replace(second, edges=edges),))
    assert "the smallest margin of all results is 0.1, at main left" in list(answer(worse))[1]
    assert f"{found.frictions[0]:g} to 0.8" in sure and "likely friction" not in wanted
    smallest = min(each.worst[1].margin for each in (found, *found.others) if each.worst)
    assert found.keeps(0.99 * smallest) and not found.keeps(1.01 * smallest)


def test_results_of_something_else_are_refused(tmp_path: Path) -> None:
    given = solved("halfplane")
    other = replace(given, contacts=tuple(replace(each, name="b") for each in given.contacts))
    with pytest.raises(CaseError, match="expected contacts of"):
        assess(given, write(tmp_path), others=[other])
    with pytest.raises(CaseError, match="expected plane results or solids"):
        assess(given, write(tmp_path), others=[stationed_sphere()])
    once = replace(given, directory=tmp_path)
    with pytest.raises(CaseError, match="found this folder twice"):
        assess(once, write(tmp_path), others=[replace(once, directory=tmp_path / "." / "x" / "..")])


def test_a_margin_at_the_outermost_place_has_no_lower_end(known: Assessment) -> None:
    """And so is not known to be kept."""
    edge = known.edges[0]
    least = Judgement(Criterion.AREA, 1.2, 0.0, 1.3, place=-0.5, outermost=True)
    found = replace(known, edges=(replace(edge, judgements=(edge.judgements[0], least)),))
    first = next(answer(found))
    assert "0.5 mm outside of it: margin ≤ 1.2 (up to 1.3) by SWT, area" in first
    assert "may or may not endure" in first
    assert any("at most this one, and may be less" in each for each in details(found))
    assert not found.keeps(1.1)


def test_edges_that_are_not_judged_are_said_first(known: Assessment, tmp_path: Path) -> None:
    nothing = assess(solved("incomplete"), write(tmp_path))
    assert list(answer(nothing)) == [
        "No margin of any edge is known; the reasons stand below"
    ] and not nothing.keeps(0)
    mixed = replace(known, edges=(*known.edges, nothing.edges[0]))
    assert "1 of 5 bodies at edges are not judged and may be worse" in list(answer(mixed))
    assert not mixed.keeps(0) and not replace(nothing, edges=()).keeps(0)


def test_short_cracks_that_elements_do_not_resolve_are_said(
    known: Assessment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(field, "_finest", lambda station, size: size)
    short = write(tmp_path, threshold={**FATIGUE["threshold"], "range": 1.0})
    found = assess(solved("halfplane"), short)
    for edge in found.edges:
        assert edge.arrest is not None and math.isnan(edge.arrest.start)
        assert edge.arrest.deepest.lengths[0] > 0.1 * edge.arrest.a0
    assert any("from the length of an element on" in text for text in details(found))
    assert any("cracks shorter than an element are left out" in text for text in answer(found))
    assert not any("length of an element" in text for text in details(known))


def test_tables_fit_a_terminal_whatever_names_are(known: Assessment) -> None:
    """All criteria side by side; an infinite margin has the low end of its interval."""
    edges = tuple(
        replace(each, judgements=(Judgement(Criterion.TESTS, math.inf, 11.85, math.inf),
                                  *each.judgements[1:]))
        for each in known.edges
    )  # fmt: skip
    named = replace(known, edges=edges, result="a" * 100, material=Path("b" * 100))
    texts = []
    for table in margin_tables(named):
        text = StringIO()
        console = Console(file=text, width=80)
        wide = console.options.update(max_width=500)
        assert Measurement.get(console, wide, table).maximum <= 80
        console.print(table)
        texts.append(text.getvalue())
    assert texts[1].count("> 11.8") == len(edges)
    assert known.worst is not None
    low, high = (rounded(each) for each in (known.worst[1].low, known.worst[1].high))
    assert f"{low} to {high}" in texts[0] and known.worst[1].criterion.value in texts[0]


def test_the_cracks_of_arrest_and_margin_are_both_shown(known: Assessment, tmp_path: Path) -> None:
    assert known.worst is not None
    edge = known.worst[0]
    assert edge.arrest is not None
    critical = replace(edge.arrest.deepest, angle=-50.0)
    deepest = replace(edge.arrest.deepest, angle=10.0, stop=0.03)
    both = replace(edge, arrest=replace(edge.arrest, deepest=deepest, critical=critical))
    found = replace(known, edges=(both,))
    html = write_assessment(found, tmp_path / "out")[0].read_text("utf-8")
    assert "At 10°, where cracks stop last, and -50°" in html
    assert "the last one at 10° after 0.03 mm" in html
    numbers = json.loads((tmp_path / "out" / "assessment.json").read_text("utf-8"))
    arrest = numbers["edges"][0]["arrest"]
    assert (arrest["deepest"]["angle"], arrest["critical"]["angle"]) == (10, -50)


def test_the_page_and_the_numbers(known: Assessment, tmp_path: Path) -> None:
    found = replace(known, source="<b>7</b>")
    page, numbers = write_assessment(found, tmp_path / "out")
    html = page.read_text("utf-8")
    (first, *_) = answer(found)
    assert re.findall(r'<p class="answer">([^<]*)\.</p>', html)[0] == first
    assert html.count("<svg") == 2 and "<b>" not in html
    assert html.count("<tr>") == 2 * (1 + len(found.edges))
    assert json.loads(numbers.read_text("utf-8"))["units"] == {"length": "mm", "stress": "MPa"}
    again, _ = write_assessment(found, tmp_path / "out")
    assert again.read_text("utf-8") == html


def test_no_page_among_results(known: Assessment, tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="without results"):
        write_assessment(known, write_run(tmp_path / "run", "halfplane"))


def test_the_page_of_another_is_kept(known: Assessment, tmp_path: Path) -> None:
    page = tmp_path / "assessment.html"
    page.write_text("of another")
    with pytest.raises(OutputError, match="found another file"):
        write_assessment(known, tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == [page.name]
    assert page.read_text() == "of another"
