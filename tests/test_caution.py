# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cautions of one kind are one line with their places; kinds and subjects survive a file."""

from __future__ import annotations

from dataclasses import asdict, replace

from fretfe.caution import Caution, Subject, grouped
from fretfe.reason import Kind
from fretfe.results.reader import restored


def uncertain(contact: str, front: str, text: str) -> Caution:
    return Caution(Kind.K_N_UNCERTAIN, Subject(contact, front), text)


def test_twelve_edges_are_one_line() -> None:
    found = [
        uncertain(f"flank {number}", side, f"K_N is {number} ± .1 {side}")
        for number in range(6)
        for side in ("left", "right")
    ]
    (group,) = grouped(found)
    assert group.line == (
        "flank 0, left edge: K_N is 0 ± .1 left; flank 0, right edge: K_N is 0 ± .1 right; "
        "likewise at flank 1, left and right edges; flank 2, left and right edges; flank 3, left "
        "and right edges; flank 4, left and right edges; flank 5, left and right edges: "
        f"{Kind.K_N_UNCERTAIN.remedy}"
    )
    assert len(group.findings) == 12


def test_edges_without_a_number_are_not_likened_to_those_with_one() -> None:
    unknown = [uncertain(f"f{n}", "left", f"K_N is unknown by {n}") for n in range(3)]
    known = [replace(uncertain("g", "left", "K_N is known to 38 % only"), partly=True)]
    (group,) = grouped([*unknown, *known])
    assert group.line == (
        "f0, left edge: K_N is unknown by 0; f1, left edge: K_N is unknown by 1; likewise at f2, "
        f"left edge; g, left edge: K_N is known to 38 % only: {Kind.K_N_UNCERTAIN.remedy}"
    )


def test_mirrored_edges_with_the_same_finding_are_named_together() -> None:
    text = "the slip zone is not resolved by the mesh"
    both = [Caution(Kind.NOT_RESOLVED, Subject("main", side), text) for side in ("left", "right")]
    other = uncertain("main", "left", "K_N is 1 ± .1")
    first, second = grouped([both[0], other, both[1]])
    assert first.findings == (("main, left and right edges", text),)
    assert first.line == f"main, left and right edges: {text}: refine the mesh there"
    assert second.cautions == (other,)


def test_fronts_of_solids_and_the_run_are_named() -> None:
    fronts = [Caution(Kind.WITHHELD, Subject("main", f"front {n}"), "as K") for n in (1, 2)]
    run = Caution(Kind.NOT_CONVERGED, Subject(), "the mesh is not fine enough")
    assert [each.line for each in grouped([*fronts, run])] == [
        "main, front 1, front 2: as K",
        "the mesh is not fine enough",
    ]
    assert fronts[0].sentence == "front 1: as K"


def test_a_caution_is_restored() -> None:
    given = uncertain("main", "left", "K_N is 1 ± .1")
    table = asdict(given)
    assert table["kind"] == "K_N uncertain" and table["subject"]["front"] == "left"
    assert restored(Caution, table) == given


def test_each_kind_is_declared_whole() -> None:
    own_words = {Kind.NOTHING, Kind.NO_EDGE, Kind.LOST}
    assert {each for each in Kind if not each.heading} == own_words
    assert not any(each.remedy.endswith(".") for each in Kind)
