# SPDX-License-Identifier: LGPL-3.0-or-later
"""Free ends of fronts, by name and by place."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases.solid_runs import LENGTH, stationed_sphere, straight

from fretfe.errors import CaseError
from fretfe.results.front_ends import end_beside, end_near, find_end, free_ends, known_numbers


def test_both_ends_have_names_and_places() -> None:
    result = straight(mirrored=False)
    start, end = free_ends(result)
    assert (start.name, end.name) == ("main.1.start", "main.1.end")
    np.testing.assert_allclose(start.point, 0.0, atol=1e-12)
    np.testing.assert_allclose(end.point, [LENGTH, 0.0, 0.0])
    np.testing.assert_array_equal(end.into, [-1.0, 0.0, 0.0])
    assert end.station.number == 11
    near = end_near(result, np.array([2.9, 0.3, 0.0]))
    assert near is not None and near.name == end.name


def test_ranges_are_those_of_stations_with_a_meaning() -> None:
    end = find_end(straight(mirrored=False), "main.1.end")
    assert end is not None
    distance, k_range, spread, *k_n = known_numbers(end)
    # Two stations at each end are too near to it.
    np.testing.assert_allclose(distance, (np.arange(2, 10) + 0.5) / 4)
    np.testing.assert_allclose(k_range, 10.0 - (LENGTH - distance))
    np.testing.assert_array_equal(spread, 0.1)
    inner = [end.front.stations[number].decisive_k_n for number in range(9, 1, -1)]
    np.testing.assert_array_equal(np.transpose(k_n), inner)


def test_what_is_no_free_end() -> None:
    result = straight(mirrored=True)
    assert [each.name for each in free_ends(result)] == ["main.1.start"]
    with pytest.raises(
        CaseError, match=r"one of the free ends main\.1\.start, found 'main\.1\.end'"
    ):
        find_end(result, "main.1.end")
    assert find_end(result, "main.1.3") is None
    closed = stationed_sphere()
    assert math.isinf(closed.contacts[0].fronts[0].stations[0].to_end)
    assert end_near(closed, np.zeros(3)) is None
    with pytest.raises(CaseError, match=r"free ends \(none\)"):
        find_end(closed, "main.1.start")


def test_stations_beside_an_end_are_no_farther_than_their_contact_is_deep() -> None:
    result = straight(mirrored=False)
    (front,) = result.contacts[0].fronts
    depth = front.stations[0].depth
    found = [end_beside(result, each) for each in front.stations]
    near = [each.to_end <= depth for each in front.stations]
    assert [each is not None for each in found] == near and any(near)
    assert found[0] is not None and found[0].name == "main.1.start"
    assert found[-1] is not None and found[-1].name == "main.1.end"
