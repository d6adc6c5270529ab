# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which pictures a results folder should have, from its numbers alone."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import numpy as np

from fretfe.edges.extremes import load_extremes

T = TypeVar("T")

# Where pictures are in a results folder, and what lists them there.
FOLDER, LIST = "pictures", "pictures.json"
# Panels in one picture.
MOST_EDGES, MOST_CONTACTS = 4, 4

Kind = Literal["bodies", "edges", "status"]


@dataclass(frozen=True)
class EdgePlace:
    """An edge of a contact, at the last state.

    Attributes:
        contact: name.
        side: "left" or "right".
        position: along the arc.
        slip: length of the longer one of its last two slip zones; 0 if there is none.
        half_width: of the contact.
    """

    contact: str
    side: str
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


def plan_pictures(numbers: Mapping[str, Any]) -> list[Wanted]:
    """The pictures that a run should have.

    Args:
        numbers: contents of `results.json`.
    """
    states = shown_states(numbers)
    last = len(numbers["times"]) - 1
    bodies = Wanted("stress.png", "Stress in the bodies at the load extremes", "bodies", states)
    edges = [
        Wanted(f"edges{mark}.png", f"Stress at the contact edges{part}", "edges", (last,), chunk)
        for mark, part, chunk in _chunks(_edge_places(numbers), MOST_EDGES) or [("", "", ())]
    ]
    status = [
        Wanted(
            f"status{mark}.png", f"Stick and slip at the load extremes{part}", "status", states,
            contacts=chunk,
        )
        for mark, part, chunk in _chunks(list(numbers["contacts"]), MOST_CONTACTS)
    ]  # fmt: skip
    return [bodies, *edges, *status]


def shown_states(numbers: Mapping[str, Any]) -> tuple[int, ...]:
    """The load extremes of all contacts together."""
    edges = [edge for contact in numbers["contacts"].values() for edge in contact["edges"]]
    k_t, k_i = ([np.array(edge[key], dtype=np.float64) for edge in edges] for key in ("k_t", "k_i"))
    return tuple(load_extremes(k_t, k_i, numbers["cycle"]))


def _chunks(items: Sequence[T], most: int) -> list[tuple[str, str, tuple[T, ...]]]:
    """Parts of about equal size, with what to add to the name of a file and to a title."""
    count = -(-len(items) // most)
    limits = [round(number * len(items) / count) for number in range(count + 1)] if count else []
    parts = [tuple(items[low:high]) for low, high in itertools.pairwise(limits)]
    if count < 2:
        return [("", "", part) for part in parts]
    return [(f"_{number}", f" ({number} of {count})", part) for number, part in enumerate(parts, 1)]


def _edge_places(numbers: Mapping[str, Any]) -> list[EdgePlace]:
    """All edges that the last state has."""
    places = []
    for name, contact in numbers["contacts"].items():
        for edge in contact["edges"]:
            position, half_width = edge["position"][-1], contact["half_width"][-1]
            if position is None or half_width is None:
                continue
            lengths = [zone["length"] or 0.0 for zone in edge["slip_zones"][-2:]]
            slip = max(lengths, default=0.0)
            places.append(EdgePlace(name, edge["side"], position, slip, half_width))
    return places
