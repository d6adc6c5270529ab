# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surface pairs in contact at several places: each patch becomes a contact of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.edges.tracks import Event, Track, follow, stays_one_patch
from fretfe.results.solution import ContactHistory, FullStickUnits, Solution
from fretfe.results.states import mapped, part

# Places are told to about this many digits of the length of the surface.
PLACES = 3


def separate_patches(solution: Solution) -> Solution:
    """Return the solution with a contact for each patch of each surface pair.

    A pair that never has more than one patch stays as it is. The patches of another one are called
    after it, with a number in brackets: in the order in which they appear, from left to right. A
    merged patch is one of them.
    """
    contacts = [each for pair in solution.contacts for each in _patches_of(solution, pair)]
    return replace(solution, contacts=tuple(contacts))


def _patches_of(solution: Solution, pair: ContactHistory) -> list[ContactHistory]:
    pressure = part(pair.traction, 0)
    if stays_one_patch(pressure):
        return [pair]
    tracks = follow(pair.arc, pressure)
    if len(tracks) < 2:
        return [pair]
    names = [f"{pair.name}[{number}]" for number in range(1, len(tracks) + 1)]
    begin = min(state for track in tracks for state in track.patches)
    contacts = []
    for name, track, territory in zip(names, tracks, _territories(pair, tracks), strict=True):
        fate = tuple(_fate(solution, pair, track, names, begin))
        contacts.append(replace(_restricted(pair, territory), name=name, fate=fate))
    return contacts


def _territories(pair: ContactHistory, tracks: Sequence[Track]) -> list[Indices]:
    """(T, 2) of each track: to the surface's end, or half-way to the neighbouring patch.

    Patches of the first state in contact have always existed, like the contact itself.
    """
    states, nodes = pair.traction.shape[:2]
    begin = min(state for track in tracks for state in track.patches)
    territories = [np.full((states, 2), -1) for _ in tracks]
    for track, territory in zip(tracks, territories, strict=True):
        if begin in track.patches:
            territory[:begin] = 0, nodes - 1
    for state in range(begin, states):
        here = [number for number, track in enumerate(tracks) if state in track.patches]
        here.sort(key=lambda number: tracks[number].patches[state].first)
        patches = [tracks[number].patches[state] for number in here]
        middles = [(one.last + other.first) // 2 for one, other in pairwise(patches)]
        firsts, lasts = [0, *(middle + 1 for middle in middles)], [*middles, nodes - 1]
        for number, first, last in zip(here, firsts, lasts, strict=True):
            territories[number][state] = first, last
    return territories


def inside(territory: Indices, nodes: int) -> Bools:
    """Return (T, nodes) nodes that belong to a patch; territory (T, 2)."""
    numbers = np.arange(nodes)
    return np.asarray((numbers >= territory[:, :1]) & (numbers <= territory[:, 1:]))


def _restricted(pair: ContactHistory, territory: Indices) -> ContactHistory:
    """A pair with tractions, contact and friction work of one patch only."""
    nodes = len(pair.arc)

    def own(values: Array, states: Indices) -> Array:
        kept = inside(territory[states], nodes)
        return np.where(kept.reshape(*kept.shape, *[1] * (values.ndim - 2)), values, 0)

    return replace(
        pair,
        traction=mapped(pair.traction, own),
        mean_traction=mapped(pair.mean_traction, own),
        # Nodes elsewhere are open.
        status=mapped(pair.status, lambda each, states: own(each, states).astype(np.int8)),
        dissipation=mapped(pair.dissipation, own),
        full_stick=_restricted_units(pair.full_stick, territory, nodes),
        # Those of a pair are of edges that none of its patches need have.
        integrals=None,
        neighbours=None,
        territory=territory,
    )


def _restricted_units(units: FullStickUnits, territory: Indices, nodes: int) -> FullStickUnits:
    """Increments of full stick on the nodes of a patch, the same in all states with one area."""
    area = np.where(territory[:, 0] >= 0, units.area, -1)
    # By area: the part of the surface in the first state that has it; none without a state.
    parts = np.full((len(units.fields), 2), -1)
    numbers, firsts = np.unique(area, return_index=True)
    parts[numbers[numbers >= 0]] = territory[firsts[numbers >= 0]]

    def own(fields: Array, areas: Indices) -> Array:
        kept = inside(parts[areas], nodes)
        return np.where(kept[..., None, None], fields, 0.0)

    return FullStickUnits(mapped(units.fields, own), area)


def _fate(
    solution: Solution, pair: ContactHistory, track: Track, names: Sequence[str], begin: int
) -> Iterator[str]:
    """Events of a track, those of a kind in one text with the first time and place."""
    digits = PLACES - math.floor(math.log10(np.ptp(pair.arc)))
    kinds: dict[str, list[Event]] = {}
    for event in track.events:
        if event.step > begin:
            kinds.setdefault(_kind(event, names), []).append(event)
    for kind, events in kinds.items():
        first, more = events[0], len(events) - 1
        place = round(first.place, digits)
        again = f" and {more} time{'s' * (more > 1)} later" if more else ""
        when = f"time {solution.times[first.step]:.6g}, x = {place:g}"
        yield f"{kind} in step {first.step} ({when}){again}"


def _kind(event: Event, names: Sequence[str]) -> str:
    others = " and ".join(names[number] for number in event.others)
    together = " and ".join(names[number] for number in event.together)
    if not event.others:
        return "touches" if event.begins else "lifts off"
    if event.begins:
        return f"arises where {others} {'merge' if len(event.others) > 1 else 'parts'}"
    return f"merges with {together} into {others}" if together else f"parts into {others}"


def own_part(values: Array, territory: Indices) -> Array:
    """Return values (..., N) of one state, zero outside the territory (2,) of a patch."""
    return np.where(inside(territory[None], values.shape[-1])[0], values, 0.0)
