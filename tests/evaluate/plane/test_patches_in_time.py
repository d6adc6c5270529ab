# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patches are followed by overlap; traces of round-off are none."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.plane.patches_in_time import Track, follow

ARC = np.linspace(0.0, 1.0, 21)


def pressure(*states: str) -> Array:
    """Digits as pressures, a dot for zero, a comma for round-off."""
    values = {".": 0.0, ",": 1e-5, **{digit: float(digit) for digit in "123456789"}}
    return np.array([[values[each] for each in state.ljust(len(ARC), ".")] for state in states])


def tracks(*states: str) -> list[Track]:
    return follow(ARC, pressure("", *states))


def states_of(*states: str) -> list[list[int]]:
    return [list(track.patches) for track in tracks(*states)]


def test_one_patch_is_one_track() -> None:
    assert states_of("..121", ".12321", "...121", "", "..111") == [[1, 2, 3, 5]]


def test_a_patch_may_move_by_its_width() -> None:
    assert states_of("1221", ".....1221", "..........1221") == [[1, 2, 3]]


def test_patches_far_apart_are_two_even_one_after_the_other() -> None:
    assert states_of("121", "..............121", "121") == [[1, 3], [2]]


def test_the_larger_one_does_not_matter() -> None:
    assert states_of("121...343", "343...121", "121...343") == [[1, 2, 3]] * 2


def test_traces_are_no_patches() -> None:
    assert states_of("99999..,", "99999..,,,,", "99999..1", "99999.1.1") == [[1, 2, 3, 4]]


def test_few_nodes_that_carry_a_share_are_a_patch() -> None:
    assert states_of("9......9", "99....99") == [[1, 2], [1, 2]]


def test_a_patch_is_followed_to_its_beginning_and_end_as_a_trace() -> None:
    small = "99999.....1", "99999....111", "99999....,,,", "99999"
    first, second = tracks(*small)
    assert list(first.patches) == [1, 2, 3, 4]
    assert list(second.patches) == [1, 2, 3]
    (end,) = [event for event in second.events if not event.begins]
    assert (end.step, end.others, end.together) == (4, (), ())


def test_merging_and_parting() -> None:
    apart, merged = "1221..1221", ".12211221"
    found = tracks(apart, merged, merged, apart, merged)
    assert [list(track.patches) for track in found] == [[1, 4], [1, 4], [2, 3, 5]]
    events = [(each.step, each.begins, each.others, each.together) for each in found[0].events]
    assert events == [
        (1, True, (), ()),
        (2, False, (2,), (1,)),
        (4, True, (2,), (1,)),
        (5, False, (2,), (1,)),
    ]
    assert [each.others for each in found[2].events] == [(0, 1)] * 3
    assert found[0].events[1].place == ARC[:4].mean()


def test_two_that_move_past_each_others_places_stay_two() -> None:
    assert states_of("12221..12221", "....12221..12221") == [[1, 2]] * 2
