# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a solved history: resultants, fronts, slip zones and warnings of every contact."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._typing import Array
from fretfe.caution import Caution, Subject
from fretfe.evaluate.contacts import (
    Contact,
    Front,
    SlipZone,
    Station,
    fronts_of,
    histories,
    unknown_station,
)
from fretfe.evaluate.cycles import STEADY_CHANGE, cycle_changes
from fretfe.evaluate.friction_work import work_before
from fretfe.evaluate.loaded import whole_sliding, with_own_cycle
from fretfe.evaluate.plane.evaluate import FindUnits, evaluate_endless, evaluate_plane
from fretfe.evaluate.plane.patches_in_time import separate_patches
from fretfe.evaluate.plane.section import PLANE_FRONTS, PlaneFront
from fretfe.evaluate.plane.symmetry import NO_EDGE, whole_contact
from fretfe.evaluate.plane.unit_factors import integral_units
from fretfe.evaluate.resultants import force_ranges, plane_resultants, solid_resultants
from fretfe.evaluate.warnings import plane_warnings, solid_warnings
from fretfe.faults import Fault, guarded
from fretfe.history.solution import ContactHistory, Solution
from fretfe.reason import Kind, Reason

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

    def evaluated(contact: ContactHistory) -> Contact:
        return guarded(
            f"contact {contact.name}",
            lambda: _evaluate_contact(solution, contact, find_units, tracks, reference_length),
            partial(_unknown_contact, contact),
        )

    return tuple(evaluated(contact) for contact in solution.contacts)


def with_patches(solution: Solution) -> tuple[Solution, Fault | None]:
    """The solution with a contact for each patch; as it was, and why, where fretfe fails in that.

    The contacts of the latter cannot be evaluated: their edges are those of several patches.
    """

    def separated() -> tuple[Solution, Fault | None]:
        return separate_patches(solution), None

    return guarded("patches of the contacts", separated, lambda fault: (solution, fault))


def unknown_contacts(solution: Solution, fault: Fault) -> tuple[Contact, ...]:
    """All contacts of a solution, where fretfe failed in what their numbers rest on."""
    return tuple(_unknown_contact(contact, fault) for contact in solution.contacts)


def _unknown_contact(contact: ContactHistory, fault: Fault) -> Contact:
    """A contact whose evaluation failed, with its resultants if these can be told."""
    solid, lost = contact.surface.facets is not None, np.full(len(contact.traction), np.nan)

    def resultants() -> dict[str, Array]:
        return solid_resultants(contact) if solid else plane_resultants(contact, lost)

    def none(_: Fault) -> dict[str, Array]:
        force = np.full((len(lost), contact.surface.points.shape[1]), np.nan)
        vectors = ("shear_force", "centre", "moment")
        return {
            **dict.fromkeys(histories(Contact), lost),
            **dict.fromkeys(vectors, force if solid else lost),
            "force": force,
        }

    found = guarded(f"forces of contact {contact.name}", resultants, none)
    of_plane = {} if solid else {"half_width": lost, "effective_tension": lost}
    known: dict[str, Any] = {**found, **of_plane}
    sides = () if solid else PLANE_FRONTS
    return Contact(
        name=contact.name,
        pair=contact.pair,
        fronts=fronts_of(
            unknown_station(each.name, 0, len(lost), Reason(Kind.FAULT, words=fault.reason))
            for each in sides
        ),
        **known,
        cycle_change=np.nan,
        steady=False,
        dissipation=np.nan,
        dissipation_change=np.nan,
        warnings=(Caution(Kind.FAULT, Subject(contact.name), fault.text),),
    )


def _evaluate_contact(
    solution: Solution,
    contact: ContactHistory,
    find_units: FindUnits,
    tracks: Tracks | None,
    reference_length: float | None,
) -> Contact:
    solid = contact.surface.facets is not None
    warnings: Iterable[Caution]
    share, reach = whole_sliding(solution, contact)
    changes = cycle_changes(solution, contact)
    if solid:
        from fretfe.evaluate.space.evaluate import evaluate_solids

        # One of those that fretfe has failed to follow is not among them.
        own = tracks.get(contact.name) if tracks is not None else None
        found = evaluate_solids(solution, contact, own, reference_length)
        found = _sliding(solution, found, share)
        warnings = solid_warnings(solution, contact, found, changes, slides=share > 0)
    else:
        whole = whole_contact(contact)
        if whole.endless:
            found = evaluate_endless(solution, contact)
        else:
            found = evaluate_plane(solution, whole.contact, find_units, reference_length)
            for image in whole.images:
                found = _of_half(solution, contact, image, found)
        found = _sliding(solution, found, share)
        loaded = with_own_cycle(solution, whole.contact)
        fronts = found["fronts"]
        warnings = plane_warnings(loaded, whole.contact, fronts, changes, slides=share > 0)
    return Contact(
        name=contact.name,
        pair=contact.pair,
        **found,
        **force_ranges(found["normal_force"], found["shear_force"], solution.cycle),
        sliding_share=share,
        sliding_range=reach,
        cycle_change=changes[0],
        steady=bool(changes[0] < STEADY_CHANGE),
        dissipation_change=found["dissipation"] / work_before(solution, contact) - 1,
        warnings=tuple(warnings),
    )


def _sliding(solution: Solution, found: dict[str, Any], share: float) -> dict[str, Any]:
    """Results of a contact that slides, if at all: gross slip where factors tell no slip zone."""
    if share == 0:
        return found
    start, end = solution.cycle or (0, len(solution.times) - 1)
    nan = np.nan
    whole = SlipZone(start, end, nan, nan, np.inf, True, True, predicted=nan, predicted_loop=nan)

    def sliding(station: Station) -> Station:
        told = station.slip_zones or station.no_edge
        return station if told else replace(station, slip_zones=(whole,))

    fronts = (
        replace(front, stations=tuple(map(sliding, front.stations))) for front in found["fronts"]
    )
    return {**found, "fronts": tuple(fronts)}


def _of_half(
    solution: Solution, contact: ContactHistory, image: PlaneFront, found: dict[str, Any]
) -> dict[str, Any]:
    """Results of a whole contact for the half that the model has: without its image."""
    states = len(solution.times)
    fronts = [
        Front(front.name, (unknown_station(front.name, 0, states, NO_EDGE),))
        if front.name == image.name
        else front
        for front in found["fronts"]
    ]
    resultants = plane_resultants(contact, found["centre"])
    own = {name: found[name] / 2 for name in ("dissipation", "dissipation_spread")}
    return {**found, **resultants, "fronts": tuple(fronts), **own}
