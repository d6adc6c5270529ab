# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact patches followed from state to state; each patch of a pair becomes a contact of its own.

A track is one patch through the history. It goes on as the patch that it overlaps along the arc. It
ends where it lifts off, merges with another one or parts; the patch that comes out of that is a
track of its own, so that no edge ever jumps. A patch at the place of an earlier track is that one
again, in another interval.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.evaluate.loaded import NO_LOAD
from fretfe.evaluate.plane.section import Patch, contact_patches
from fretfe.history.solution import ContactHistory, FullStickUnits, Solution
from fretfe.history.state_array import StateArray, blocks, mapped, part, picked

# Patches that carry less than this share of the normal force are traces of round-off.
SMALLEST_PATCH = 1e-3
# Fewer nodes than this have to carry a larger share: single nodes next to a patch may close.
FEWEST_NODES = 3
SHARE_OF_FEW = 0.05
# Places are told to about this many digits of the length of the surface.
PLACES = 3


@dataclass(frozen=True)
class Event:
    """Beginning or end of an interval in which a track exists.

    Attributes:
        step: the step in which it happens, by the state that ends it.
        begins: True for a beginning, False for an end.
        others: numbers of the tracks that it comes from, or goes over into; none where the surfaces
            touch or lift off.
        together: numbers of the tracks that do so with it.
        place: middle of the patch along the arc.
    """

    step: int
    begins: bool
    others: tuple[int, ...]
    together: tuple[int, ...]
    place: float


@dataclass
class Track:
    """One patch through the history.

    Attributes:
        patches: by state, where the track exists.
        events: in time order.
        first, last: outermost nodes that it ever had.
    """

    patches: dict[int, Patch] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)
    first: int = 0
    last: int = -1

    def add(self, state: int, patch: Patch) -> None:
        """Continue the track."""
        new = not self.patches
        self.first = patch.first if new else min(self.first, patch.first)
        self.last = patch.last if new else max(self.last, patch.last)
        self.patches[state] = patch


def stays_one_patch(pressure: StateArray | Array) -> bool:
    """True if a contact has one patch all the time once it has any, which goes on as it moves.

    False does not say that there are more: `follow` does.

    Args:
        pressure: (T, N).
    """
    before = np.zeros(0, dtype=bool)
    for states in blocks(len(pressure), pressure.shape[1]):
        closed = np.vstack([before.reshape(-1, pressure.shape[1]), pressure[states] > 0])
        runs = np.count_nonzero(np.diff(closed, axis=1, prepend=False, append=False), axis=1) // 2
        shared = np.any(closed[1:] & closed[:-1], axis=1)
        # Nothing may follow nothing.
        if runs.max() > 1 or np.any((runs[:-1] > 0) & ~shared):
            return False
        before = closed[-1]
    return True


def follow(arc: Array, pressure: StateArray | Array) -> list[Track]:
    """Return all tracks, in the order in which they appear, from left to right.

    Args:
        arc: (N,) nodes.
        pressure: (T, N).
    """
    tracker = _Tracker(arc)
    for state, patches in enumerate(_patches(arc, pressure)):
        tracker.advance(state, patches)
    return tracker.tracks


def _patches(arc: Array, pressure: StateArray | Array) -> list[list[Patch]]:
    """Patches of each state, without traces.

    Few nodes, or a small share of the force, are a patch where they are what a patch was in the
    state before, or becomes in the next one.
    """
    runs = [
        contact_patches(arc, state.clip(min=0.0))
        for states in blocks(len(pressure), len(arc))
        for state in pressure[states]
    ]
    forces = np.array([sum(patch.force for patch in patches) for patches in runs])
    # What is left where the bodies have parted is round-off.
    for state in np.flatnonzero(forces <= NO_LOAD * forces.max(initial=0.0)):
        runs[state] = []
    kept = [_clear(patches) for patches in runs]
    states = list(range(len(runs)))
    for before, now in [*pairwise(states), *pairwise(states[::-1])]:
        lost = [each for each in kept[before] if not _met(each, kept[now])]
        found = [each for each in runs[now] if each not in kept[now] and _met(each, lost)]
        kept[now] = sorted([*kept[now], *found], key=lambda patch: patch.first)
    return kept


def _clear(patches: Sequence[Patch]) -> list[Patch]:
    """The patches that are no traces; the largest one never is."""
    total = sum(patch.force for patch in patches)
    largest = max(patches, key=lambda patch: patch.force, default=None)
    shares = [SMALLEST_PATCH if _nodes(each) >= FEWEST_NODES else SHARE_OF_FEW for each in patches]
    return [
        patch
        for patch, share in zip(patches, shares, strict=True)
        if patch is largest or patch.force >= share * total
    ]


def overlap(one: Patch, other: Patch) -> int:
    """Return the number of nodes that two patches share; not positive if there are none."""
    return max(min(one.last, other.last) - max(one.first, other.first) + 1, 0)


def _met(patch: Patch, others: Sequence[Patch]) -> bool:
    return any(overlap(patch, each) for each in others)


def _nodes(patch: Patch) -> int:
    return patch.last - patch.first + 1


class _Tracker:
    """Follows patches through the states, one after the other."""

    def __init__(self, arc: Array) -> None:
        self._arc = arc
        self.tracks: list[Track] = []
        self._alive: dict[int, Patch] = {}

    def advance(self, state: int, patches: Sequence[Patch]) -> None:
        """Take the patches of the next state."""
        alive, self._alive = self._alive, {}
        for numbers, places in self._groups(alive, patches):
            before, now = [alive[n] for n in numbers], [patches[p] for p in places]
            if len(numbers) != len(places):
                self._change(state, numbers, before, now, taken={*alive, *self._alive})
                continue
            for number, patch in zip(numbers, now, strict=True):
                self._continue(state, number, patch)

    def _continue(self, state: int, number: int, patch: Patch) -> None:
        self.tracks[number].add(state, patch)
        self._alive[number] = patch

    def _change(
        self,
        state: int,
        numbers: list[int],
        before: Sequence[Patch],
        now: Sequence[Patch],
        taken: set[int],
    ) -> None:
        """Tracks end, and others that are not taken begin in their place: one may be none."""
        begun: list[int] = []
        for patch in now:
            number = self._find(patch, {*taken, *begun})
            self._continue(state, number, patch)
            begun.append(number)
        for ending, group, others in ((False, begun, numbers), (True, numbers, begun)):
            for number, patch in zip(group, before if ending else now, strict=True):
                together = tuple(each for each in group if each != number)
                place = float(self._arc[[patch.first, patch.last]].mean())
                event = Event(state, not ending, tuple(others), together, place)
                self.tracks[number].events.append(event)

    def _find(self, patch: Patch, taken: set[int]) -> int:
        """Number of the earlier track that a patch is most like, or of a new one."""
        best, number = 0.0, len(self.tracks)
        for each, track in enumerate(self.tracks):
            if each not in taken:
                shared = overlap(patch, Patch(track.first, track.last, 0.0))
                union = _nodes(patch) + track.last - track.first + 1 - shared
                if shared / union > best:
                    best, number = shared / union, each
        if number == len(self.tracks):
            self.tracks.append(Track())
        return number

    def _groups(
        self, alive: dict[int, Patch], patches: Sequence[Patch]
    ) -> Iterator[tuple[list[int], list[int]]]:
        """Tracks and patches that belong together, each in the order along the arc."""
        order = sorted(alive, key=lambda number: alive[number].first)
        links = {n: {p for p, each in enumerate(patches) if overlap(alive[n], each)} for n in order}
        free = [p for p in range(len(patches)) if not any(p in each for each in links.values())]
        for number in [n for n in order if not links[n]]:
            near = [p for p in free if self._near(alive[number], patches[p])]
            if near:
                links[number] = {near[0]}
                free.remove(near[0])
        groups: list[tuple[list[int], set[int]]] = []
        for number in order:
            mates = [group for group in groups if group[1] & links[number]]
            rest = [group for group in groups if not group[1] & links[number]]
            members = [each for group in mates for each in group[0]]
            groups = [
                *rest, ([*members, number], links[number].union(*(group[1] for group in mates)))
            ]  # fmt: skip
        yield from ((numbers, sorted(places)) for numbers, places in groups)
        yield from (([], [p]) for p in free)

    def _near(self, one: Patch, other: Patch) -> bool:
        """True if a patch may have moved to another one in a long step."""
        low, high = sorted((one, other), key=lambda patch: patch.first)
        arc = self._arc
        widths = arc[one.last] - arc[one.first] + arc[other.last] - arc[other.first]
        return bool(arc[high.first] - arc[low.last] < widths / 2)


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
    # Patches that part and merge again within one step are those of one contact.
    if stays_one_patch(picked(pressure, solution.ends)):
        return [pair]
    tracks = follow(pair.surface.arc, pressure)
    if len(tracks) < 2:
        return [pair]
    names = [f"{pair.name}[{number}]" for number in range(1, len(tracks) + 1)]
    begin = min(state for track in tracks for state in track.patches)
    contacts = []
    for name, track, node_range in zip(names, tracks, _territories(pair, tracks), strict=True):
        events = tuple(_fate(solution, pair, track, names, begin))
        contacts.append(replace(_restricted(pair, node_range), name=name, events=events))
    return contacts


def _territories(pair: ContactHistory, tracks: Sequence[Track]) -> list[Indices]:
    """(T, 2) of each track: to the surface's end, or half-way to the neighbouring patch.

    Patches of the first state in contact have always existed, like the contact itself.
    """
    states, nodes = pair.traction.shape[:2]
    begin = min(state for track in tracks for state in track.patches)
    territories = [np.full((states, 2), -1) for _ in tracks]
    for track, node_range in zip(tracks, territories, strict=True):
        if begin in track.patches:
            node_range[:begin] = 0, nodes - 1
    for state in range(begin, states):
        here = [number for number, track in enumerate(tracks) if state in track.patches]
        if not here:  # the bodies have parted: the surface belongs to nobody
            continue
        here.sort(key=lambda number: tracks[number].patches[state].first)
        patches = [tracks[number].patches[state] for number in here]
        middles = [(one.last + other.first) // 2 for one, other in pairwise(patches)]
        firsts, lasts = [0, *(middle + 1 for middle in middles)], [*middles, nodes - 1]
        for number, first, last in zip(here, firsts, lasts, strict=True):
            territories[number][state] = first, last
    return territories


def inside(node_range: Indices, nodes: int) -> Bools:
    """Return (T, nodes) nodes that belong to a patch; node_range (T, 2)."""
    numbers = np.arange(nodes)
    return np.asarray((numbers >= node_range[:, :1]) & (numbers <= node_range[:, 1:]))


def _restricted(pair: ContactHistory, node_range: Indices) -> ContactHistory:
    """A pair with tractions, contact and friction work of one patch only."""
    nodes = len(pair.surface.arc)

    def own(values: Array, states: Indices) -> Array:
        kept = inside(node_range[states], nodes)
        return np.where(kept.reshape(*kept.shape, *[1] * (values.ndim - 2)), values, 0)

    pressure = part(pair.traction, 0)
    return replace(
        pair,
        beside=mapped(pressure, lambda each, states: each - own(each, states)),
        traction=mapped(pair.traction, own),
        mean_traction=mapped(pair.mean_traction, own),
        # Nodes elsewhere are open.
        status=mapped(pair.status, lambda each, states: own(each, states).astype(np.int8)),
        dissipation=mapped(pair.dissipation, own),
        full_stick=_restricted_units(pair.full_stick, node_range, nodes),
        # Those of a pair are of edges that none of its patches need have.
        integrals=None,
        nearby_loads=None,
        node_range=node_range,
    )


def _restricted_units(units: FullStickUnits, node_range: Indices, nodes: int) -> FullStickUnits:
    """Increments of full stick on the nodes of a patch, the same in all states with one area."""
    area = np.where(node_range[:, 0] >= 0, units.area, -1)
    # By area: the part of the surface in the first state that has it; none without a state.
    parts = np.full((len(units.fields), 2), -1)
    numbers, firsts = np.unique(area, return_index=True)
    parts[numbers[numbers >= 0]] = node_range[firsts[numbers >= 0]]

    def own(fields: Array, areas: Indices) -> Array:
        kept = inside(parts[areas], nodes)
        return np.where(kept[..., None, None], fields, 0.0)

    return FullStickUnits(mapped(units.fields, own), area)


def _fate(
    solution: Solution, pair: ContactHistory, track: Track, names: Sequence[str], begin: int
) -> Iterator[str]:
    """Events of a track, those of a kind in one text with the first time and place."""
    digits = PLACES - math.floor(math.log10(np.ptp(pair.surface.arc)))
    kinds: dict[str, list[Event]] = {}
    for event in track.events:
        if event.step > begin:
            kinds.setdefault(_kind(event, names), []).append(event)
    for kind, events in kinds.items():
        first, more = events[0], len(events) - 1
        place = round(first.place, digits)
        again = f" and {more} time{'s' * (more > 1)} later" if more else ""
        when = f"time {solution.times[first.step]:.6g}, x = {place:g}"
        yield f"{kind} in step {solution.step_of(first.step)} ({when}){again}"


def _kind(event: Event, names: Sequence[str]) -> str:
    others = " and ".join(names[number] for number in event.others)
    together = " and ".join(names[number] for number in event.together)
    if not event.others:
        return "touches" if event.begins else "lifts off"
    if event.begins:
        return f"arises where {others} {'merge' if len(event.others) > 1 else 'parts'}"
    return f"merges with {together} into {others}" if together else f"parts into {others}"


def own_part(values: Array, node_range: Indices) -> Array:
    """Return values (..., N) of one state, zero outside the node_range (2,) of a patch."""
    return np.where(inside(node_range[None], values.shape[-1])[0], values, 0.0)
