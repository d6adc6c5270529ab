# SPDX-License-Identifier: LGPL-3.0-or-later
"""Malformed and hostile inputs: a part of the campaign that `python -m faults` runs as a whole."""

from __future__ import annotations

from pathlib import Path

import pytest
from campaign.extent import SEED, by_extent
from faults.every import all_faults
from faults.judge import BAD, judge_all
from faults.originals import write_originals

# One of so many, another one each week, and the whole files.
PART = by_extent(61, 11)


@pytest.mark.slow
def test_a_part_of_the_campaign(tmp_path: Path) -> None:
    faults = list(enumerate(all_faults()))
    assert len(faults) >= 600
    part = [
        (number, each)
        for number, each in faults
        if number % PART == SEED % PART or "whole" in each.name
    ]
    good, arena = tmp_path / "good", tmp_path / "arena"
    good.mkdir()
    arena.mkdir()
    write_originals(good)
    verdicts = judge_all(good, arena, part, lambda verdict: None, 1)
    assert len(verdicts) == len(part)
    wrong = [f"{each.kind}: {each.fault.name}: {each.text}" for each in verdicts]
    assert not [text for text, each in zip(wrong, verdicts, strict=True) if each.kind in BAD]
