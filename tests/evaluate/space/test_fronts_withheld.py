# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fronts where nodal pressures flicker, and the reasons why a contact of solids has none."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from evaluate.space.test_evaluate import SIZE, STATIONS, Field, grid, hertz, solved

from fretfe._typing import Array
from fretfe.caution import Subject
from fretfe.evaluate.evaluate import evaluate
from fretfe.evaluate.space.contact_area import why_no_fronts
from fretfe.evaluate.space.fronts import follow_fronts, lost_fronts
from fretfe.reason import Kind


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


def strip(x: Array, z: Array) -> Array:
    """Falls like a root on both sides, on the right from a peak within an element."""
    steep = 1 + 8 * np.exp((x - 0.8) / (1.1 * SIZE))
    return np.asarray(np.sqrt(np.clip(0.64 - x**2, 0.0, None)) * steep + 0 * z)


def test_a_border_without_a_front_is_a_front_of_which_nothing_is_known() -> None:
    solution, contact = solved(*grid(), [strip])
    tracks = follow_fronts(solution, contact, STATIONS)
    (found,) = evaluate(replace(solution, cycle=(0, 1)), tracks={"main": tracks})
    known, lost = found.fronts
    assert (known.lost, lost.lost) == (False, True) and lost.name == "front 2"
    k_n, bars = np.array([each.decisive_k_n for each in known.stations]).T
    assert np.all(np.abs(k_n - np.sqrt(1.6)) < np.minimum(bars, 0.05))
    # Means around nodes reach an element farther.
    edge = [each.point[0] for each in lost.stations]
    np.testing.assert_allclose(edge, 0.8 + SIZE, atol=0.6 * SIZE)
    assert lost.length == pytest.approx(3.0, abs=2 * SIZE)
    assert not any(np.isfinite(each.reported_k_n) for each in lost.stations)
    kinds = Kind.NOTHING_KNOWN, Kind.WITHHELD  # of front 1 there are no integrals
    about = {each.subject: each for each in found.warnings if each.kind in kinds}
    caution = about[Subject("main", "front 2")]
    assert len(about) == 2 and caution.kind is Kind.NOTHING_KNOWN
    assert re.search("around .0.8.*within 2 elements of it, 4 are wanted", caution.text)


@pytest.mark.parametrize("field", [hertz(1.0, 1.0), hertz(1.0, 1e6)], ids=["closed", "open"])
def test_borders_with_fronts_are_not_lost(field: Field) -> None:
    solution, contact = solved(*grid(), [field])
    tracks = follow_fronts(solution, contact, STATIONS)
    assert tracks and not lost_fronts(solution, contact, tracks)


REASONS: dict[str, tuple[Field, Kind, str]] = {
    "narrow": (hertz(0.3, 0.3), Kind.NARROW, r"about \d+ elements over its width, 14 are wanted"),
    "filled": (hertz(9.0, 9.0), Kind.NO_BORDER, "let the surfaces reach farther"),
    "corner open": (corner, Kind.CUT, r"to a length of \d+ elements, less than its width"),
    "sharp": (punch(0.8), Kind.NO_CURVE, "At a sharp corner there is no K_N"),
}


@pytest.mark.parametrize(("field", "kind", "words"), REASONS.values(), ids=REASONS)
def test_a_contact_without_fronts_says_why(field: Field, kind: Kind, words: str) -> None:
    solution, contact = solved(*grid(), [field])
    assert kind is Kind.CUT or not follow_fronts(solution, contact, STATIONS)
    found = why_no_fronts(contact, 1)
    assert found.kind is kind
    assert re.search(words, found.text)
