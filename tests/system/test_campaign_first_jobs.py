# SPDX-License-Identifier: LGPL-3.0-or-later
"""First jobs by finite elements: pads under any loads, and flanks under what drives them.

FRETFE_CAMPAIGN=long draws more, for an hour (-o faulthandler_timeout=0 lets it); another seed than
that of the week is FRETFE_CAMPAIGN_SEED.
"""

from __future__ import annotations

import pytest

hypothesis = pytest.importorskip("hypothesis")

from campaign.extent import LONG, SEED  # noqa: E402
from campaign.first_jobs import Job, blades, pads, spheres  # noqa: E402
from campaign.judge_first_jobs import differences, faults  # noqa: E402
from hypothesis import HealthCheck, Phase, given, note, seed, settings  # noqa: E402

PROFILES = ("cylinder", "wedge", "flat_rounded")
# A case takes a second or two: the short form tells which it is, the long form makes it small.
DRAWN = settings(
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
    phases=(Phase.generate, Phase.shrink) if LONG else (Phase.generate,),
)


@pytest.mark.timeout(7200 if LONG else 300)
@seed(SEED)
@settings(DRAWN, max_examples=60 if LONG else 6)
@given(pads(8, PROFILES))
def test_pad(job: Job) -> None:
    note(f"FRETFE_CAMPAIGN_SEED={SEED}")
    assert list(faults(job, "fem", report=LONG)) == []


@pytest.mark.timeout(7200 if LONG else 300)
@seed(SEED)
@settings(DRAWN, max_examples=60 if LONG else 6)
@given(pads(8, PROFILES))
def test_pad_beside_half_planes(job: Job) -> None:
    note(f"FRETFE_CAMPAIGN_SEED={SEED}")
    assert list(differences(job)) == []


@pytest.mark.timeout(7200 if LONG else 300)
@seed(SEED)
@settings(DRAWN, max_examples=40 if LONG else 2)
@given(blades())
def test_blade(job: Job) -> None:
    note(f"FRETFE_CAMPAIGN_SEED={SEED}")
    assert list(faults(job, "fem", report=LONG)) == []


@pytest.mark.skipif(not LONG, reason="a sphere takes half a minute: FRETFE_CAMPAIGN=long")
@pytest.mark.timeout(7200)
@seed(SEED)
@settings(DRAWN, max_examples=8)
@given(spheres())
def test_sphere(job: Job) -> None:
    note(f"FRETFE_CAMPAIGN_SEED={SEED}")
    assert list(faults(job, "fem", report=True)) == []


@pytest.mark.timeout(7200 if LONG else 600)
@pytest.mark.slow
@seed(SEED)
@settings(DRAWN, max_examples=12 if LONG else 2)
@given(spheres(known=True))
def test_sphere_beside_hertz_and_mindlin(job: Job) -> None:
    note(f"FRETFE_CAMPAIGN_SEED={SEED}")
    assert list(faults(job, "fem")) == []
