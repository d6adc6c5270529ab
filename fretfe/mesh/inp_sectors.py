# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sectors of a deck: *TIE with CYCLIC SYMMETRY and *CYCLIC SYMMETRY MODEL.

(Abaqus Analysis User's Guide, Analysis of models that exhibit cyclic symmetry; CalculiX has the
same, with a model for each tie that it names.)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.errors import MeshError
from fretfe.mesh.inp import Deck
from fretfe.mesh.inp_cards import Card, real, whole
from fretfe.mesh.planes import PLANE_TOLERANCE


@dataclass(frozen=True)
class Sector:
    """Two sides of bodies that are one of several equal sectors about an axis.

    Attributes:
        place: file and line of the tie.
        sides: names of the two surfaces.
        count: number of sectors in a full turn.
        centre: (3,) a point on the axis.
        axis: (3,) its direction.
    """

    place: str
    sides: tuple[str, str]
    count: int
    centre: Array
    axis: Array


def sectors(deck: Deck, dimension: int) -> list[Sector]:
    """All of a deck.

    Args:
        deck: as it was read.
        dimension: of its bodies.

    Raises:
        MeshError: one is not understood, or there is a tie without its model or the other way.
    """
    ties = [card for card in deck.cyclic if card.word == "TIE"]
    models = [card for card in deck.cyclic if card.word != "TIE"]
    found: list[Sector] = []
    for model in models:
        try:
            found += _of_model(model, ties, dimension)
        except (ValueError, IndexError) as error:
            raise MeshError(f"{model.place}: cannot read *{model.keyword}: {error}") from None
    known = [each.place for each in found]
    for tie in ties:
        if known.count(tie.place) != 1:
            raise MeshError(
                f"{tie.place}: expected one *CYCLIC SYMMETRY MODEL of this *TIE with CYCLIC "
                f"SYMMETRY, found {known.count(tie.place)}"
            )
    return found


def _of_model(model: Card, ties: list[Card], dimension: int) -> Iterator[Sector]:
    """The sectors of a model: of the tie that it names, or of all."""
    named = model.name("TIE")
    own = [tie for tie in ties if named in (None, tie.name("NAME"))]
    if not own:
        which = "" if named is None else f" called {named}"
        raise ValueError(f"expected a *TIE with CYCLIC SYMMETRY{which}, found none")
    count = whole(model.required("N"))
    numbers = np.array([real(value) for row in model.rows for value in row if value])
    if len(numbers) < 6 and dimension == 3:
        raise ValueError(f"expected two points on the axis, found {len(numbers)} numbers")
    centre = np.append(numbers[:3], np.zeros(3))[:3]
    axis = numbers[3:6] - centre if len(numbers) >= 6 else np.array([0.0, 0.0, 1.0])
    length = float(np.abs(axis).max())
    if length == 0.0:
        raise ValueError("expected two different points on the axis")
    if dimension == 2 and np.abs(axis[:2]).max() > PLANE_TOLERANCE * length:
        raise ValueError(f"expected an axis along z in a plane model, found {axis.tolist()}")
    for tie in own:
        yield Sector(tie.place, tie.pairs()[0], count, centre, axis)
