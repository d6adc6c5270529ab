# SPDX-License-Identifier: LGPL-3.0-or-later
"""Layers of contacts: either stiffnesses or a coating."""

from __future__ import annotations

from typing import Any

import pytest
from cases.pad_cases import PAD, pad

from fretfe.case import Case, parse_case
from fretfe.errors import CaseError


def layered(layer: Any) -> Case:
    return parse_case(pad(contacts={"main": {**PAD["contacts"]["main"], "layer": layer}}))


def compliances(layer: dict[str, float]) -> tuple[float, float]:
    found = layered(layer).contacts["main"].layer
    assert found is not None
    return found.compliances


def test_stiffnesses_are_those_of_the_layer() -> None:
    assert compliances({"normal": 4e6, "tangential": 2e6}) == (0.25e-6, 0.5e-6)


def test_a_coating_is_compressed_without_stretching_and_sheared() -> None:
    # Lamé's constants of E = 2.5, nu = 1/4: both 1.
    found = compliances({"thickness": 0.6, "young": 2.5, "poisson": 0.25})
    assert found == pytest.approx((0.2, 0.6), rel=1e-14)


@pytest.mark.parametrize(
    ("layer", "expected"),
    [
        ({"normal": 1e6}, "expected either normal and tangential, or thickness, young and poisson"),
        ({"csv": "a.csv", "normal": 1e6}, "or csv, found csv, normal"),
        ({"normal": 1e6, "tangential": 1e6, "young": 1.0}, "found normal, tangential, young"),
        ({}, "found none of them"),
        ({"normal": -1e6, "tangential": 1e6}, "contacts.main.layer.normal: expected a number > 0"),
        (
            {"thickness": 1.0, "young": 1.0, "poisson": 0.5},
            "layer.poisson: expected a number < 0.5",
        ),
        (
            {"normal": 1e6, "tangental": 1e6},
            "layer.tangental: unknown key; did you mean 'tangential'",
        ),
        (1e6, "contacts.main.layer: expected a table, found 1000000.0"),
        ({"normal": "stiff", "tangential": 1e6}, "layer.normal: expected a number, found text"),
        ({"normal": float("inf"), "tangential": 1e6}, "layer.normal: expected a finite number"),
    ],
)
def test_other_layers_are_refused(layer: Any, expected: str) -> None:
    with pytest.raises(CaseError) as error:
        layered(layer)
    assert expected in str(error.value)
