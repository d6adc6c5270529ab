# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes in place of bodies that are none say so, and by how much they are wrong."""

from __future__ import annotations

import pytest
from pad_cases import cylinder, pad

from fretfe.backends import find_backend
from fretfe.case import parse_case
from fretfe.quality.validation import summary, validate

HALF_WIDTH = 0.5749
QUANTITY = "error of K_N or ΔK_T because the bodies are not half-planes"
# K_N of finite elements with the lower body so many half-widths high, over that of one 42 high.
K_N_BY_HEIGHT = {3.0: 1.0256}


@pytest.mark.parametrize("backend", ["halfplane", "analytic"])
def test_a_low_body_is_no_half_plane(backend: str) -> None:
    case = parse_case(pad(geometry=cylinder(lower_height=3 * HALF_WIDTH)))
    validation = validate(case, find_backend(backend))
    (row,) = (each for each in validation.rows if each.quantity == QUANTITY)
    assert row.verdict == "unknown" and row.value == pytest.approx(0.03, rel=0.1)
    assert not validation.passed
    assert summary(validation).endswith("nothing can be said of this case before they are known.")
    (contact,) = validation.result.contacts
    assert any("use the backend 'fem'" in text for text in contact.warnings)
    for station in contact.stations:
        missing = (K_N_BY_HEIGHT[3.0] - 1) * station.k_n[-1]
        assert missing < station.k_n_spread[-1] < 2 * missing


@pytest.mark.parametrize("backend", ["halfplane", "analytic"])
def test_large_bodies_pass(backend: str) -> None:
    result = find_backend(backend).solve(parse_case(pad()))
    limit = result.limits[-1]
    assert limit.quantity == QUANTITY and limit.found < 0.004
    assert not any("outside the model" in text for text in result.contacts[0].warnings)
