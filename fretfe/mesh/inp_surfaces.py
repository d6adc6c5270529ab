# SPDX-License-Identifier: LGPL-3.0-or-later
"""A surface of an Abaqus or CalculiX input file by itself, as nodal forces need it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.mesh.inp import read_deck
from fretfe.mesh.inp_groups import SOLID, Groups, supported_cells
from fretfe.mesh.planes import upright


@dataclass(frozen=True)
class DeckSurface:
    """A surface of a model.

    Attributes:
        points: (n, d) its nodes.
        labels: of the nodes, as they are written in the file.
        facets: blocks (f, k) of facets with as many nodes each, corners first.
        inside: (f, d) a place in the element behind each facet, by block.
    """

    points: Array
    labels: tuple[str, ...]
    facets: tuple[Indices, ...]
    inside: tuple[Array, ...]


def read_surface(path: Path, name: str) -> DeckSurface:
    """A surface, node set or element set of facets on the outside of all elements of a file.

    Args:
        path: input file.
        name: of the surface or set.

    Raises:
        MeshError: the file cannot be read, or has no facets of that name.
    """
    deck = read_deck(path)
    dimension = 3 if any(SOLID.match(kind) for kind, _ in deck.elements.values()) else 2
    cells = supported_cells(path, deck, dimension)
    facets = Groups(path, deck, dimension, [list(cells.items())]).boundary(name, name.upper())
    numbers = sorted({node for facet in facets for node in facet.nodes})
    place = {number: index for index, number in enumerate(numbers)}
    centres = np.array(
        [np.mean([deck.nodes[node] for node in cells[facet.element]], axis=0) for facet in facets]
    )
    sizes = np.array([len(facet.nodes) for facet in facets])
    rows = {size: np.flatnonzero(sizes == size) for size in np.unique(sizes)}
    points = np.array([deck.nodes[number] for number in numbers])
    if dimension == 2:
        together, _ = upright(np.vstack([points, centres]), np.arange(len(points) + len(centres)))
        points, centres = np.split(together, [len(points)])
    return DeckSurface(
        points[:, :dimension],
        tuple(deck.text(number) for number in numbers),
        tuple(
            np.array([[place[node] for node in facets[row].nodes] for row in own])
            for own in rows.values()
        ),
        tuple(centres[own, :dimension] for own in rows.values()),
    )
