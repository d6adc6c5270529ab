# SPDX-License-Identifier: LGPL-3.0-or-later
"""How far a cycle is from the steady one, and how many more cycles are asked for."""

from __future__ import annotations

import math
from functools import partial
from unittest.mock import patch

import pytest
from cases.pad_cases import pad, press, shear

from fretfe.case import parse_case
from fretfe.evaluate.cycles import (
    STEADY_CHANGE,
    cycle_changes,
    may_become_steady,
    unsteady_text,
)
from fretfe.halfplane import solve_half_planes
from fretfe.loads import CycleChoice
from fretfe.results.model import Result
from fretfe.runner import Runner


@pytest.mark.parametrize("factor", [1.3, 2.0, 8.0])
@pytest.mark.parametrize("done", [2, 3])
def test_the_cycles_that_are_asked_for_are_enough(factor: float, done: int) -> None:
    """Changes that fall by a factor from cycle to cycle."""
    changes = [0.3 / factor**cycle for cycle in range(200)]
    text = unsteady_text(changes[:done][::-1])
    count = int(text.split("add about ")[1].split(" cycle")[0])
    assert f"falls by a factor of {factor:.2g} from" in text
    assert changes[done - 1 + count] < STEADY_CHANGE <= changes[done - 2 + count]


def test_the_slower_fall_counts() -> None:
    text = unsteady_text([2e-2, 5e-2, 40e-2])
    assert "add about 4 cycles: the change falls by a factor of 2.5" in text


@pytest.mark.parametrize("before", [[0.012], [0.0], [0.0122, 0.3]])
def test_a_change_that_does_not_fall_is_told(before: list[float]) -> None:
    text = unsteady_text([0.012, *before])
    assert "the change does not fall, and more cycles would not make it steady" in text
    assert "add" not in text


def test_one_cycle_tells_nothing_and_a_steady_one_needs_none() -> None:
    assert unsteady_text([0.3]).endswith(
        "add a cycle: the changes over two say about how many it takes"
    )
    told = {choice: unsteady_text([0.3], choice) for choice in CycleChoice}
    assert "; add a cycle before the one in [cycle]: the" in told[CycleChoice.GIVEN]
    assert "; add a cycle to the case of the run that the cuts" in told[CycleChoice.OTHER_RUN]
    assert "; add a cycle by a larger `more` in [cycle]: the" in told[CycleChoice.ADDED]
    assert unsteady_text([0.9 * STEADY_CHANGE, 0.3]) == unsteady_text([math.nan]) == ""


def test_loads_that_do_not_return_are_no_cycle_to_add() -> None:
    text = unsteady_text([0.3], CycleChoice.GIVEN, ["pull", "shear"])
    assert text.endswith(
        "the evaluated cycle, in which pull, shear does not return: end it where loads do"
    )


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ([[0.3]], True),
        ([[0.9 * STEADY_CHANGE, 0.3]], False),
        ([[math.nan]], False),
        ([], False),
        ([[math.nan], [0.9 * STEADY_CHANGE], [0.02, 0.03]], True),
        # One rise may be chance, two are none.
        ([[0.03, 0.02]], True),
        ([[0.03, 0.02, 0.04]], True),
        ([[0.03, 0.03, 0.03]], False),
        ([[0.02, 0.03, 0.04], [0.03, 0.03, 0.03]], False),
    ],
)
def test_cycles_are_worth_adding_while_a_change_falls(
    changes: list[list[float]], expected: bool
) -> None:
    assert may_become_steady(changes) is expected


@pytest.mark.parametrize(("cycles", "known"), [(1, 1), (2, 2), (4, 3)])
def test_changes_are_those_of_the_same_cycles(cycles: int, known: int) -> None:
    loads = {"press": press(steps=4), "shear": shear(cycles=cycles, steps=8)}
    with patch(
        "fretfe.backends.halfplane.solve_half_planes", partial(solve_half_planes, elements=60)
    ):
        result: Result = Runner.find("halfplane").run(parse_case(pad(loads=loads)))
    (contact,) = result.solution.contacts
    changes = cycle_changes(result.solution, contact)
    assert len(changes) == known and changes[0] == result.contacts[0].cycle_change
    # Similar half-planes are steady once they were loaded; the first cycle begins without shear.
    first = [changes[-1]] if known == cycles else []
    assert all(each > 0.1 for each in first)
    assert all(each < 1e-9 for each in changes[: known - len(first)])
