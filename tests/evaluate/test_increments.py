# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories that add up increments: unknown adds up to unknown, and what is known later stays."""

from __future__ import annotations

import numpy as np
import pytest

from fretfe.evaluate.increments import (
    add_up,
    beside_known,
    one_sided_sums,
    uneven_sums,
    within_known,
)
from fretfe.evaluate.numerics import count_up
from fretfe.history.solution import Factor

NAN = np.nan


@pytest.mark.parametrize(
    ("increments", "cycle", "expected"),
    [
        ([1.0, 2.0, 3.0], None, [0.0, 1.0, 3.0, 6.0]),
        # an unknown first step leaves the rest known, counted from where it ends
        ([NAN, 2.0, 3.0], None, [NAN, 0.0, 2.0, 5.0]),
        ([NAN, 2.0, 3.0], (1, 3), [NAN, 0.0, 2.0, 5.0]),
        ([1.0, NAN, 3.0], (2, 3), [NAN, NAN, 0.0, 3.0]),
        # a step of the cycle that is unknown leaves nothing known behind it
        ([1.0, NAN, 3.0], (0, 3), [0.0, 1.0, NAN, NAN]),
        ([1.0, NAN, 3.0], (1, 3), [0.0, 1.0, NAN, NAN]),
        ([NAN, NAN, NAN], (0, 3), [0.0, NAN, NAN, NAN]),
        # without a cycle all steps count
        ([1.0, NAN, 3.0], None, [NAN, NAN, 0.0, 3.0]),
        # up to the state of the largest load, where that counts in place of a cycle
        ([1.0, 2.0, NAN], (2, 2), [0.0, 1.0, 3.0, NAN]),
    ],
)
def test_sums(
    increments: list[float], cycle: tuple[int, int] | None, expected: list[float]
) -> None:
    found = count_up(np.array(increments), cycle)
    np.testing.assert_array_equal(found, expected)


def test_each_column_is_counted_by_itself() -> None:
    found = count_up(np.array([[[NAN, 1.0]], [[2.0, 1.0]]]), None)
    np.testing.assert_array_equal(found[:, 0], [[NAN, 0.0], [0.0, 1.0], [2.0, 2.0]])


def units(states: int, unknown: tuple[int, ...] = ()) -> np.ndarray:
    """One driver, two stations, K_I = 1 and K_T = 2 for a unit of it."""
    values = np.zeros((states, 2, 2, 1))
    values[:, :, Factor.K_I], values[:, :, Factor.K_T] = 1.0, 2.0
    values[list(unknown)] = NAN
    return values


def test_a_history_without_steps_has_its_first_state() -> None:
    np.testing.assert_array_equal(count_up(np.zeros((0, 2, 3)), None), np.zeros((1, 2, 3)))


DRIVER = np.array([[0.0], [1.0], [3.0], [2.0]])
FRICTION = np.array([False, True, True, True])
TOUCHING = np.array([False, True, True, True])


def test_known_units_add_up() -> None:
    histories = add_up(units(4, (0,)), DRIVER, FRICTION, TOUCHING, (1, 3))
    np.testing.assert_allclose(histories[0, :, Factor.K_T], [0.0, 2.0, 6.0, 4.0])
    np.testing.assert_allclose(histories[1, :, Factor.K_I], [0.0, 1.0, 3.0, 2.0])


def test_a_step_between_unknown_states_is_unknown() -> None:
    histories = add_up(units(4, (0, 1, 2)), DRIVER, FRICTION, TOUCHING, (1, 3))
    # from state 1 to 2 neither state is known: so is the range over the cycle
    assert np.isnan(np.ptp(histories[:, 1:, Factor.K_T], axis=1)).all()


def test_shear_without_friction_is_known_to_be_none() -> None:
    friction = np.array([False, False, True, True])
    histories = add_up(units(4, (0, 1)), DRIVER, friction, TOUCHING, (1, 3))
    np.testing.assert_allclose(histories[0, :, Factor.K_T], [0.0, 0.0, 4.0, 2.0])
    assert np.isnan(histories[0, 0, Factor.K_I])
    np.testing.assert_allclose(histories[0, 1:, Factor.K_I], [0.0, 2.0, 1.0])


def test_without_contact_or_change_nothing_is_unknown() -> None:
    driver = np.array([[0.0], [1.0], [1.0], [1.0]])
    open_first = np.array([False, False, True, True])
    histories = add_up(units(4, (0, 1, 2, 3)), driver, FRICTION, open_first, None)
    np.testing.assert_array_equal(histories, np.zeros((2, 4, 2)))


def test_states_within_a_step_take_the_factors_of_its_known_end() -> None:
    """Step 1 touches: its first two parts are unknown. Step 2 opens: its last two are."""
    step = np.array([0, 1, 1, 1, 2, 2, 2, 3])
    each = units(8, (0, 1, 2, 5, 6))
    each[3] *= 2.0
    each[4] *= 3.0
    found = within_known(each, step)
    same = np.array([0, 3, 3, 3, 4, 4, 6, 7])
    np.testing.assert_array_equal(found, each[same])
    assert within_known(each, None) is each
    # Half of three parts that touch, two that open, and the step behind: K_T = 4, 6 and 2 each.
    sums = one_sided_sums(each, found, np.arange(8.0)[:, None])
    np.testing.assert_allclose(sums, [[0, 2, 4, 6, 6, 9, 12, 13]] * 2)


def test_small_states_take_the_factors_beside_them() -> None:
    """At both ends of a flight and between two; bodies part in state 4."""
    small = np.array([True, False, True, True, False, True, False, False, True])
    each = units(9, (0, 2, 3, 4, 5, 7, 8))
    each[1] *= 2.0
    each[6] *= 3.0
    # State 7 carries more than a little, and so leaves state 8 unknown as well.
    same = np.array([1, 1, 1, 1, 4, 6, 6, 7, 8])
    np.testing.assert_array_equal(beside_known(each, small), each[same])
    assert beside_known(each, np.zeros(9, dtype=bool)) is each


def test_bars_of_steps_hold_what_edges_that_move_change() -> None:
    """Q grows by 1 while P makes a cylinder's half-width a twice as large; K_T for Q = 1 is a^-.5.

    Two shapes that move both sides of a part alike change nothing.
    """
    found = np.zeros((2, 1, 3, 3))
    found[:, 0, Factor.K_T] = [[1.0, 1e3, -1e3], [2**-0.5, 2e3, -2e3]]
    drivers = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    acts = np.ones(2, dtype=bool)
    ((start, bar),) = uneven_sums(found, drivers, acts)
    assert start == 0.0
    exact = (4**0.75 - 1) / 0.75 / 3
    off = (1 + 2**-0.5) / 2 - exact
    assert 0.9 * off < bar < 4 * off
    np.testing.assert_allclose(uneven_sums(found[..., :1], drivers[:, :1], acts)[0, 1], bar)
