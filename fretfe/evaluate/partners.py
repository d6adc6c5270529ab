# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts and fronts of two results that lie in the same place.

Patches are numbered in the order in which they appear, fronts by their lengths: on another mesh, or
under other loads, the same one may have another number.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.evaluate.contacts import Contact, Front

Partner = TypeVar("Partner", Contact, Front)


class Places(NamedTuple):
    """Places of the line of a front, linear between its stations.

    Attributes:
        first, second: (n,) numbers of the two stations that each lies between.
        part: (n,) of the way from the first to the second one.
        gaps: (n,) distances from the points that they are nearest to.
    """

    first: Indices
    second: Indices
    part: Array
    gaps: Array


def nearest_places(front: Front, points: Array) -> Places:
    """Places of the line of a front that are nearest to points (n, 3)."""
    places = front.along("point")
    if len(places) == 1:
        alone = np.zeros(len(points), dtype=np.int64)
        gaps = np.linalg.norm(points - places[0], axis=1)
        return Places(alone, alone, np.zeros(len(points)), gaps)
    ends = np.roll(places, -1, axis=0) if front.closed else places[1:]
    starts = places[: len(ends)]
    lines = ends - starts
    share = np.einsum("nmd,md->nm", points[:, None] - starts, lines) / np.sum(lines**2, axis=1)
    share = np.clip(share, 0.0, 1.0)
    distances = np.linalg.norm(starts + share[..., None] * lines - points[:, None], axis=2)
    first, rows = distances.argmin(axis=1), np.arange(len(points))
    return Places(first, (first + 1) % len(places), share[rows, first], distances[rows, first])


def front_partners(fronts: Sequence[Front], others: Sequence[Front]) -> list[Front | None]:
    """For each front that of another result in the same place; None where there is none.

    Both are closed or both open, the contact is on the same side of both, and they are nearer to
    each other than half of the width of the contact, which is how far another one is at least.
    """
    return _matched(np.array([[_apart(one, two) for two in others] for one in fronts]), others)


def _apart(one: Front, two: Front) -> float:
    """Distance of two fronts over half of the width of the contact; infinite if they are not one.

    Mean over the stations of both, since one may be shorter than the other.
    """
    if one.closed != two.closed:
        return np.inf
    distances, along = [], []
    for front, other in ((one, two), (two, one)):
        near = nearest_places(other, front.along("point"))
        distances.append(near.gaps.mean())
        sides = [
            each.frame.inward @ other.stations[number].frame.inward
            for each, number in zip(front.stations, near.first, strict=True)
        ]
        along.append(np.mean(sides))
    depths = np.concatenate([front.along("depth") for front in (one, two)])
    known = depths[depths > 0]
    if min(along) <= 0 or not len(known):
        return np.inf
    return float(np.mean(distances) / np.median(known))


def contact_partners(
    contacts: Sequence[Contact], others: Sequence[Contact]
) -> list[Contact | None]:
    """For each contact that of another result in the same place; None where there is none.

    The contact of a pair with a single one in both is the same. Patches of plane contacts are where
    they touched last, and less than their half-width away from each other.
    """
    apart = np.full((len(contacts), len(others)), np.inf)
    for pair in {each.pair for each in contacts}:
        mine, theirs = (
            [number for number, each in enumerate(found) if each.pair == pair]
            for found in (contacts, others)
        )
        if len(mine) == len(theirs) == 1:
            apart[mine[0], theirs[0]] = 0.0
            continue
        for one in mine:
            for two in theirs:
                apart[one, two] = _patches_apart(contacts[one], others[two])
    return _matched(apart, others)


def _patches_apart(one: Contact, two: Contact) -> float:
    """Distance of two plane patches over the half-width of the wider one."""
    (centre, half_width), (other_centre, other_width) = map(_last_place, (one, two))
    widest = max(half_width, other_width)
    return abs(other_centre - centre) / widest if widest > 0 else np.inf


def _last_place(contact: Contact) -> tuple[float, float]:
    """Centre and half-width where a plane contact touches last, up to the end of the cycle."""
    last = contact.stations[0].last
    end = last + 1 if last >= 0 else len(contact.centre)
    touching = np.flatnonzero(np.isfinite(contact.half_width[:end]))
    if not len(touching):
        return np.nan, 0.0
    return float(contact.centre[touching[-1]]), float(contact.half_width[touching[-1]])


def _matched(apart: Array, others: Sequence[Partner]) -> list[Partner | None]:
    """One of the others (m,) for each row of distances (n, m) below 1, the nearest pair first."""
    found: list[Partner | None] = [None] * len(apart)
    left = np.nan_to_num(apart.reshape(len(apart), len(others)), nan=np.inf)
    while left.size and left.min() < 1:
        row, column = divmod(int(left.argmin()), len(others))
        found[row] = others[column]
        left[row], left[:, column] = np.inf, np.inf
    return found
