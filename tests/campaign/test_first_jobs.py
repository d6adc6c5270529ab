# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pads under any loads that the case file allows, as half-planes: no traceback, nothing silent.

FRETFE_CAMPAIGN=long draws hundreds; FRETFE_CAMPAIGN_SEED another seed than that of the week.
"""

from __future__ import annotations

import pytest

hypothesis = pytest.importorskip("hypothesis")

from campaign.extent import LONG, SEED  # noqa: E402
from campaign.first_jobs import Job, pads  # noqa: E402
from campaign.judge_first_jobs import faults  # noqa: E402
from hypothesis import Phase, given, note, seed, settings  # noqa: E402

PHASES = (Phase.generate, Phase.shrink)
EXAMPLES = 400 if LONG else 10


@pytest.mark.timeout(3600 if LONG else 300)
@seed(SEED)
@settings(max_examples=EXAMPLES, deadline=None, database=None, phases=PHASES)
@given(pads(12))
def test_cylinder(job: Job) -> None:
    note(f"FRETFE_CAMPAIGN_SEED={SEED}")
    assert list(faults(job, "halfplane")) == []
