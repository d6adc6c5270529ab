# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a solved history: resultants, fronts, slip zones and warnings of every contact."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.cycles import STEADY_CHANGE, cycle_changes
from fretfe.evaluate.factors import integral_units
from fretfe.evaluate.plane.evaluate import FindUnits, evaluate_plane
from fretfe.evaluate.warnings import plane_warnings, solid_warnings
from fretfe.history.solution import ContactHistory, Solution

# Not loaded by whoever loads this module: SciPy's interpolation takes a second.
if TYPE_CHECKING:
    from fretfe.evaluate.space.fronts import FrontTrack

# The fronts of each contact between solids, followed through the history.
Tracks = Mapping[str, "tuple[FrontTrack, ...]"]


def evaluate(
    solution: Solution,
    find_units: FindUnits = integral_units,
    tracks: Tracks | None = None,
    reference_length: float | None = None,
) -> tuple[Contact, ...]:
    """Evaluate every contact of a solution.

    Args:
        solution: the solved history.
        find_units: gives the singular factors of plane contacts for a unit of each driver: by
            interaction integrals and fits, unless there is a closed form.
        tracks: the fronts between solids, by contact; None if nobody looked for them.
        reference_length: at which factors between unlike bodies are told; None for that of the slip
            zone that they predict.
    """
    return tuple(
        _evaluate_contact(solution, contact, find_units, tracks, reference_length)
        for contact in solution.contacts
    )


def _evaluate_contact(
    solution: Solution,
    contact: ContactHistory,
    find_units: FindUnits,
    tracks: Tracks | None,
    reference_length: float | None,
) -> Contact:
    solid = contact.facets is not None
    changes = cycle_changes(
        solution, contact.mean_traction if solid else contact.traction, contact.friction
    )
    if solid:
        from fretfe.evaluate.space.evaluate import evaluate_solids

        own = tracks[contact.name] if tracks is not None else None
        found = evaluate_solids(solution, contact, own, reference_length)
        warnings = solid_warnings(solution, contact, found, changes)
    else:
        found = evaluate_plane(solution, contact, find_units, reference_length)
        warnings = plane_warnings(solution, contact, found["fronts"], changes)
    return Contact(
        name=contact.name,
        pair=contact.pair,
        **found,
        cycle_change=changes[0],
        steady=bool(changes[0] < STEADY_CHANGE),
        dissipation_change=_dissipation_change(solution, contact, found["work"]),
        warnings=tuple(warnings),
    )


def _dissipation_change(solution: Solution, contact: ContactHistory, work: Array) -> float:
    """Friction work of the evaluated cycle over that of as many steps before it, less 1."""
    if solution.cycle is None:
        return np.nan
    ends, (first, last) = solution.ends, solution.cycle
    count = solution.step_of(last) - solution.step_of(first)
    if solution.step_of(first) < count:
        return np.nan
    begin = ends[solution.step_of(first) - count]
    before, earlier = work[begin + 1 : first + 1].sum(), contact.friction[begin + 1 : first + 1]
    if not (before > 0 and np.all(earlier > 0)):
        return np.nan
    return float(work[first + 1 : last + 1].sum() / before - 1)
