# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pictures that a run should have."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from fretfe.report.source import edge_title, extremes
from fretfe.results.model import Result

T = TypeVar("T")

# Panels in one picture.
MOST_EDGES, MOST_CONTACTS = 4, 4
STRESS = "Stress in the bodies at the load extremes"

Kind = Literal["bodies", "edges", "status", "surface", "cycle", "scene"]


@dataclass(frozen=True)
class EdgePlace:
    """An edge of a contact, at the last state.

    Attributes:
        contact: name.
        title: of its panel.
        position: along the arc.
        slip: length of the longer one of its last two slip zones; 0 if there is none.
        half_width: of the contact.
    """

    contact: str
    title: str
    position: float
    slip: float
    half_width: float


@dataclass(frozen=True)
class Wanted:
    """A picture to make.

    Attributes:
        file: its name.
        title: what it shows.
        kind: of picture.
        states: that it shows.
        edges: that it shows, one panel each.
        contacts: that it shows, one row of panels each.
    """

    file: str
    title: str
    kind: Kind
    states: tuple[int, ...]
    edges: tuple[EdgePlace, ...] = ()
    contacts: tuple[str, ...] = ()


def plan_pictures(run: Result) -> list[Wanted]:
    """The pictures that a run should have."""
    return _plan_solids(run) if run.solid else _plan_plane(run)


def _plan_solids(run: Result) -> list[Wanted]:
    states = tuple(extremes(run))
    names = [contact.name for contact in run.contacts]
    surfaces = [
        Wanted(f"contact{mark}.png", f"Contact {name}", "surface", states, contacts=(name,))
        for mark, _, (name,) in _chunks(names, 1)
    ]
    moved = max(run.contacts, key=lambda each: float(np.ptp(each.shear_force, axis=0).max()))
    return [
        Wanted("stress.png", STRESS, "bodies", states),
        *surfaces,
        Wanted("cycle.gif", f"Cycle of the contact {moved.name}", "cycle", (), (), (moved.name,)),
        Wanted("bodies.gltf", "Bodies with their stress as a scene", "scene", states[-1:]),
    ]


def _plan_plane(run: Result) -> list[Wanted]:
    states = tuple(extremes(run))
    last = len(run.loads.times) - 1
    bodies = Wanted("stress.png", STRESS, "bodies", states)
    edges = [
        Wanted(f"edges{mark}.png", f"Stress at the contact edges{part}", "edges", (last,), chunk)
        for mark, part, chunk in _chunks(_edge_places(run), MOST_EDGES) or [("", "", ())]
    ]
    status = [
        Wanted(
            f"status{mark}.png", f"Stick and slip at the load extremes{part}", "status", states,
            contacts=chunk,
        )
        for mark, part, chunk in _chunks([each.name for each in run.contacts], MOST_CONTACTS)
    ]  # fmt: skip
    return [bodies, *edges, *status]


def _chunks(items: Sequence[T], most: int) -> list[tuple[str, str, tuple[T, ...]]]:
    """Parts of about equal size, with what to add to the name of a file and to a title."""
    count = -(-len(items) // most)
    limits = [round(number * len(items) / count) for number in range(count + 1)] if count else []
    parts = [tuple(items[low:high]) for low, high in itertools.pairwise(limits)]
    if count < 2:
        return [("", "", part) for part in parts]
    return [(f"_{number}", f" ({number} of {count})", part) for number, part in enumerate(parts, 1)]


def _edge_places(run: Result) -> list[EdgePlace]:
    """All edges that the last state has."""
    places = []
    for contact in run.contacts:
        for edge in contact.stations:
            position, half_width = float(edge.position[-1]), float(contact.half_width[-1])
            if np.isfinite([position, half_width]).all():
                lengths = [zone.length for zone in edge.slip_zones[-2:] if not zone.gross]
                slip = float(max(lengths, default=0.0))
                title = f"{contact.name}, {edge_title(edge)}"
                places.append(EdgePlace(contact.name, title, position, slip, half_width))
    return places
