# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts where nodal pressures flicker, and the reasons why a contact of solids has none."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from evaluate.space.test_evaluate import STATIONS, Field, grid, hertz, solved

from fretfe._typing import Array
from fretfe.evaluate.space.contact_area import why_no_fronts
from fretfe.evaluate.space.fronts import follow_fronts
from fretfe.evaluate.withheld import Lack


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5])
def test_a_front_is_found_though_nodal_pressures_flicker(share: float) -> None:
    """The means around the nodes are those of Hertz, as where tractions have too many nodes."""
    solution, contact = solved(*grid(), [hertz(1.0, 1.0)])
    traction = np.array(contact.traction)
    off = np.random.default_rng(1).random(traction.shape[1]) < share
    traction[1, off, 0] = 0.0
    (track,) = follow_fronts(solution, replace(contact, traction=traction), STATIONS)
    radius = np.linalg.norm(track.front.frames.points[:, [0, 2]], axis=1)
    np.testing.assert_allclose(radius, 1.0, atol=0.01)
    np.testing.assert_allclose(track.fit.k_n[1], np.sqrt(2), rtol=0.015)


def punch(half: float) -> Field:
    """A square, pressed like a flat of this half-width: with a root in the denominator."""
    return lambda x, z: (
        (np.maximum(abs(x), abs(z)) < half)
        / np.sqrt(np.clip((half**2 - x**2) * (half**2 - z**2), 1e-6, None))
    )


def corner(x: Array, z: Array) -> Array:
    """A contact in a corner of the surface, which leaves a triangle open at the other one."""
    return np.asarray(np.sqrt(np.clip(1.8 - x - z, 0.0, None)))


REASONS: dict[str, tuple[Field, Lack, str]] = {
    "narrow": (hertz(0.3, 0.3), Lack.NARROW, r"about \d+ elements over its width, 14 are wanted"),
    "filled": (hertz(9.0, 9.0), Lack.NO_BORDER, "let the surfaces reach farther"),
    "corner open": (corner, Lack.CUT, r"to a length of \d+ elements, less than its width"),
    "sharp": (punch(0.8), Lack.NO_CURVE, "it ends at sharp corners"),
}


@pytest.mark.parametrize(("field", "kind", "words"), REASONS.values(), ids=REASONS)
def test_a_contact_without_fronts_says_why(field: Field, kind: Lack, words: str) -> None:
    solution, contact = solved(*grid(), [field])
    assert kind is Lack.CUT or not follow_fronts(solution, contact, STATIONS)
    found = why_no_fronts(contact, 1)
    assert found.kind is kind
    assert re.search(words, found.text)
