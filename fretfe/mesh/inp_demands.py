# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ties, sectors and rigid surfaces that a case must have of a deck, whose model it else is not.

Of a model that a case cuts a part out of, only what is in that part.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping
from dataclasses import dataclass, field

from fretfe.errors import MeshError
from fretfe.mesh.inp import Deck
from fretfe.mesh.inp_references import references
from fretfe.mesh.inp_sectors import sectors


@dataclass(frozen=True)
class Uses:
    """Boundaries of a deck that a case ties, holds or moves, by their names there.

    Attributes:
        ties: pairs that it ties.
        sectors: pairs of sides of sectors, and the number of these in a full turn.
        led: boundaries that it holds, or moves as one rigid piece.
        keys: of the case, by the names of the boundaries there.
    """

    ties: Collection[tuple[str, str]] = ()
    sectors: Mapping[tuple[str, str], int] = field(default_factory=dict)
    led: Collection[str] = ()
    keys: Mapping[str, str] = field(default_factory=dict)


NOTHING = Uses()
# Something that two names of the same facets have alike.
Key = Callable[[str], Hashable]


def require(
    deck: Deck, dimension: int, uses: Uses, key: Key, counts: Callable[[str], bool]
) -> None:
    """Check that a case ties, turns and moves what a deck does.

    Args:
        deck: as it was read.
        dimension: of its bodies.
        uses: of the case.
        key: of a surface or set.
        counts: False for a surface or set that is not in the part that the case cuts out.

    Raises:
        MeshError: names the first that it does not.
    """
    known = {frozenset((key(one), key(other))) for one, other in uses.ties}
    for place, one, other in deck.ties:
        if frozenset((key(one), key(other))) not in known and (counts(one) or counts(other)):
            raise MeshError(
                f"{place}: *TIE of {one} and {other}, which the case does not tie: expected a table"
                f' [ties.NAME] with boundary1 = "{one}" and boundary2 = "{other}", and one body'
                f' with both, as by the label "{one}"'
            )
    turned = {
        frozenset((key(one), key(other))): count for (one, other), count in uses.sectors.items()
    }
    for each in sectors(deck, dimension):
        one, other = each.sides
        found = turned.get(frozenset((key(one), key(other))))
        if found != each.count and (counts(one) or counts(other)):
            raise MeshError(
                f"{each.place}: *TIE with CYCLIC SYMMETRY of {one} and {other}: expected a table "
                f'[symmetry.NAME] with boundary1 = "{one}", boundary2 = "{other}" and sectors = '
                f"{each.count}, found {'none' if found is None else f'sectors = {found}'}"
            )
    for led in references(deck):
        if led.rigid and led.label not in uses.led and counts(led.label):
            raise MeshError(
                f"{led.card.place}: *{led.card.keyword} moves {led.label} as one rigid piece, "
                "which the case does not: expected a load of type platen with boundary = "
                f'"{led.label}", or a support of it'
            )
