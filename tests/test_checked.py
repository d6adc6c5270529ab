# SPDX-License-Identifier: LGPL-3.0-or-later
"""What `fretfe check` says of a case before it is solved."""

from __future__ import annotations

import pytest
from cases.pad_cases import pad

from fretfe.case import parse_case
from fretfe.checked import unloaded_steps
from fretfe.loads import build_history


@pytest.mark.parametrize(
    ("friction_from", "values", "steps"),
    [(0.0, [1, 0, 1, 0], 3), (2.0, [1, 0, 1, 0], 2), (0.0, [1, 0.1, 1, 0.1], 0), (0.0, [1, 2], 0)],
)
def test_steps_that_begin_or_end_without_load_are_counted(
    friction_from: float, values: list[float], steps: int
) -> None:
    history = [{"times": list(range(1, len(values) + 1)), "values": values}]
    given = pad()
    given["contacts"]["main"]["friction_from"] = friction_from
    for load in given["loads"].values():
        load["history"] = history
    case = parse_case(given)
    assert unloaded_steps(case, build_history(case)) == steps
