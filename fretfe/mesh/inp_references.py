# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces of a deck that a reference node moves as one rigid piece, or spreads forces over.

*RIGID BODY, *COUPLING with *KINEMATIC and *KINEMATIC COUPLING are platens of a case, *COUPLING with
*DISTRIBUTING and *DISTRIBUTING COUPLING forces (Abaqus Analysis User's Guide, Coupling constraints,
Rigid body definition; CalculiX has the same, with a node of its own for rotations of *RIGID BODY).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fretfe.errors import MeshError
from fretfe.mesh.inp import Deck, Point
from fretfe.mesh.inp_cards import Card

# Keywords of a rigid body that name what is rigid.
RIGID = ("NSET", "ELSET", "TIENSET", "PINNSET")


@dataclass(frozen=True)
class Reference:
    """A surface and its reference node.

    Attributes:
        card: that says so.
        label: surface or set.
        node: number of the reference node.
        place: of the node.
        rigid: whether the surface moves as one piece; else forces are spread over it.
        turning: node whose displacements are rotations of the reference node; itself without one.
    """

    card: Card
    label: str
    node: int
    place: Point
    rigid: bool
    turning: int

    def advice(self, dimension: int) -> str:
        """Loads that a case has in place of the node, in words."""
        place = [float(value) for value in self.place[:dimension]]
        own = f'boundary = "{self.label}"'
        if self.rigid:
            return (
                f"this node moves {self.label} as one rigid piece: write loads of type platen with "
                f"{own}, and of type tilt with centre = {place}, or a support of {self.label}"
            )
        return (
            f"this node spreads forces over {self.label}: write loads of type force with {own} and "
            f"through = {place}"
        )


def references(deck: Deck) -> list[Reference]:
    """All of a deck.

    Raises:
        MeshError: one is not understood, belongs to a body, or moves several surfaces.
    """
    found: list[Reference] = []
    for card, kind in _pairs(deck.couplings):
        try:
            found.append(_reference(deck, card, kind))
        except (ValueError, IndexError, KeyError) as error:
            raise MeshError(f"{card.place}: cannot read *{card.keyword}: {error}") from None
    nodes = [each.node for each in found]
    # a mass at a reference node is no part of a body
    bodies = {node for _, own in deck.elements.values() if len(own) > 1 for node in own}
    for each in found:
        if each.node in bodies:
            raise MeshError(
                f"{each.card.place}: *{each.card.keyword}: the reference node "
                f"{deck.text(each.node)} is a node of a body, which would come apart from "
                f"{each.label} here: mesh these parts as one with common nodes"
            )
        if nodes.count(each.node) > 1:
            raise MeshError(
                f"{each.card.place}: *{each.card.keyword}: the reference node "
                f"{deck.text(each.node)} moves several surfaces together, which would come apart "
                "here: make them one surface of one body"
            )
    return found


def _pairs(cards: Sequence[Card]) -> Iterator[tuple[Card, Card]]:
    """Keywords with a reference node, each with the one that says what the node does."""
    for place, card in enumerate(cards):
        if card.word == "COUPLING":
            if place + 1 == len(cards) or cards[place + 1].word not in (
                "KINEMATIC",
                "DISTRIBUTING",
            ):
                raise MeshError(
                    f"{card.place}: expected *KINEMATIC or *DISTRIBUTING after *{card.keyword}"
                )
            yield card, cards[place + 1]
        elif card.word not in ("KINEMATIC", "DISTRIBUTING"):
            yield card, card


def _reference(deck: Deck, card: Card, kind: Card) -> Reference:
    """One of them."""
    card.refuse("INFLUENCERADIUS")
    if card.word == "RIGIDBODY":
        named = [name for key in RIGID if (name := card.name(key))]
        members = deck.element_sets.get(card.name("ELSET") or "", ())
        if any(deck.elements[number][0].startswith("C") for number in members):
            raise ValueError(
                "a rigid part of a body is not supported: leave its elements out, and make the "
                "surface around it a platen"
            )
        turning = card.name("ROTNODE")
    elif card.word == "COUPLING":
        named, turning = [card.required("SURFACE")], None
    else:
        named, turning = [row[0].strip('"').upper() for row in card.rows if row[0]], None
    if len(named) != 1:
        raise ValueError(f"expected one set or surface, found {', '.join(named) or 'none'}")
    if kind.word == "DISTRIBUTINGCOUPLING":
        elements = deck.members("ELSET", card.required("ELSET"))
        node = deck.elements[elements[0]][1][0]
    else:
        node = _node(deck, card.required("REFNODE"))
    return Reference(card, named[0], node, deck.nodes[node],
                     not kind.word.startswith("DISTRIBUTING"),
                     node if turning is None else _node(deck, turning))  # fmt: skip


def _node(deck: Deck, text: str) -> int:
    """The number of a node, by itself or by a set of it alone."""
    members = deck.node_sets.get(text) or [deck.number(text)]
    if len(set(members)) != 1 or members[0] not in deck.nodes:
        raise ValueError(f"expected one node that is defined, found {text}")
    return members[0]
