# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces that a deck holds or loads node by node, or element by element, and does not name.

Rows of *BOUNDARY, *CLOAD and *DLOAD that are the same for all nodes, or sides, of whole facets on
the outside of a body become one row for a surface that is called BOUNDARY_1, CLOAD_1, DLOAD_1 and
so on, in the order of the file. Other rows stay as they are.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from fretfe._typing import Array
from fretfe.mesh.inp import Deck
from fretfe.mesh.inp_cards import Card, real
from fretfe.mesh.inp_shapes import Facet
from fretfe.mesh.pieces import connected_groups

# The middle of forces at nodes and that of their facets are one up to this part of the extent.
SAME_MIDDLE = 1e-3
# Cosine between the normals of a facet and an axis that it is across.
ACROSS = 0.999


def name_surfaces(deck: Deck, exterior: Iterable[Facet]) -> None:
    """Name the surfaces of rows that have none, in the deck and its cards.

    Args:
        deck: gets the surfaces.
        exterior: facets on the outside of its bodies.
    """
    names = _Names(deck, exterior)
    gather = {"BOUNDARY": names.held, "CLOAD": names.forced, "DLOAD": names.pressed}
    for card in deck.analysis:
        if card.word in gather:
            # what is not whole is reported where loads are read
            whole = [row for row in card.rows if _is_whole(card, row)]
            rest = [row for row in card.rows if not _is_whole(card, row)]
            card.rows[:] = whole
            card.rows[:] = [*gather[card.word](card), *rest]


def _is_whole(card: Card, row: Sequence[str]) -> bool:
    """True if a row has what its keyword needs."""
    try:
        return len(row) > 1 and (card.word == "BOUNDARY" or math.isfinite(real(row[2])))
    except (ValueError, IndexError):
        return False


class _Names:
    def __init__(self, deck: Deck, exterior: Iterable[Facet]) -> None:
        self._deck = deck
        self._exterior = {(facet.element, facet.side): facet for facet in exterior}
        self._at: dict[int, list[Facet]] = {}
        for facet in self._exterior.values():
            for node in facet.nodes:
                self._at.setdefault(node, []).append(facet)
        self._names = {frozenset(sides): name for name, sides in deck.surfaces.items()}
        self._count: Counter[str] = Counter()

    def held(self, card: Card) -> Iterator[list[str]]:
        """Rows of *BOUNDARY: one for the nodes of each piece that are held alike."""
        alike: dict[tuple[str, ...], dict[int, list[str]]] = {}
        for row in card.rows:
            if not (nodes := self._loose(row[0])):
                yield row
            first, last, value = (*row[1:4], "", "", "")[:3]
            for node in nodes:
                alike.setdefault((first, last or first, value), {})[node] = row
        for what, rows in alike.items():
            facets = self._facets(rows, what[0] if what[0] == what[1] else "")
            for own in self._of_pieces(facets):
                yield [self._name(card, own), *what]
            yield from _left(rows, facets)

    def forced(self, card: Card) -> Iterator[list[str]]:
        """Rows of *CLOAD: one for each face whose forces at nodes act in its middle."""
        forces: dict[str, dict[int, float]] = {}
        origin: dict[str, dict[int, list[str]]] = {}
        loose = {row[1] for row in card.rows if self._loose(row[0])}
        for row in card.rows:
            # a set of whole facets, too, beside others of the same face
            nodes = self._members(row[0]) if row[1] in loose else []
            if not nodes:
                yield row
            for node in nodes:
                own = forces.setdefault(row[1], {})
                own[node] = own.get(node, 0.0) + real(row[2])
                origin.setdefault(row[1], {})[node] = row
        for axis, values in forces.items():
            taken: list[Facet] = []
            for face in _faces(self._facets(values)):
                nodes = [*_nodes(face)]
                force = np.array([values.get(node, 0.0) for node in nodes])
                if self._in_the_middle(face, nodes, force):
                    taken += face
                    yield [self._name(card, face), axis, repr(float(force.mean()))]
            yield from _left(origin[axis], taken)

    def pressed(self, card: Card) -> Iterator[list[str]]:
        """Rows of *DLOAD: one for the sides of each piece that have the same pressure."""
        alike: dict[str, list[Facet]] = {}
        for row in card.rows:
            sides = self._sides(row)
            if sides and all(side in self._exterior for side in sides):
                alike.setdefault(row[2], []).extend(self._exterior[side] for side in sides)
            else:
                yield row
        for value, facets in alike.items():
            for own in self._of_pieces(facets):
                yield [self._name(card, own), "P", value]

    def _loose(self, label: str) -> list[int]:
        """Nodes of bodies in a row that names no boundary: a number, or a set of some nodes."""
        nodes = self._members(label)
        whole = _nodes(self._facets(nodes)).issuperset(nodes)
        return [] if whole else [node for node in nodes if node in self._deck.pieces]

    def _members(self, label: str) -> list[int]:
        """Nodes in a row, if it has some on bodies."""
        name = label.strip('"').upper()
        nodes = self._deck.labelled(label)
        return [] if name in self._deck.surfaces or self._at.keys().isdisjoint(nodes) else nodes

    def _sides(self, row: Sequence[str]) -> list[tuple[int, int]]:
        """Elements of a row of *DLOAD and their side, if it is a pressure."""
        label, kind = row[0].strip('"').upper(), row[1].upper()
        if not (kind.startswith("P") and kind[1:].isdecimal()):
            return []
        members = self._deck.element_sets.get(label)
        if members is None:
            try:
                members = [self._deck.number(row[0])]
            except ValueError:
                return []
        return [(number, int(kind[1:])) for number in dict.fromkeys(members)]

    def _facets(self, nodes: Iterable[int], axis: str = "") -> list[Facet]:
        """Facets with all their nodes among some.

        Those across an axis alone, if these have all the nodes: of a sheet of elements that is held
        along its normal the two faces, not the rim.
        """
        wanted = set(nodes)
        found = {
            (facet.element, facet.side): facet
            for node in wanted
            for facet in self._at.get(node, ())
            # an even traction has no forces at the corners of triangles with six nodes
            if wanted.issuperset(facet.nodes[3:] if len(facet.nodes) == 6 else facet.nodes)
        }
        if axis in ("1", "2", "3"):
            areas = {side: self._area(facet) for side, facet in found.items()}
            across = [found[side] for side, area in areas.items()
                      if abs(area[int(axis) - 1]) > ACROSS * np.linalg.norm(area)]  # fmt: skip
            if _nodes(across).issuperset(wanted):
                return across
        return [*found.values()]

    def _area(self, facet: Facet) -> Array:
        """(3,) area times the normal of a facet, of an edge in the plane xy its length."""
        corners = self._points(facet.nodes[: len(facet.corners)])
        if len(corners) == 2:
            return np.cross(corners[1] - corners[0], [0.0, 0.0, 1.0])
        arms = corners - corners[0]
        return np.asarray(sum(np.cross(a, b) for a, b in pairwise(arms[1:])) / 2)

    def _points(self, nodes: Iterable[int]) -> Array:
        return np.array([self._deck.nodes[node] for node in nodes])

    def _in_the_middle(self, face: Sequence[Facet], nodes: Sequence[int], forces: Array) -> bool:
        """True if forces (n,) at nodes have the line of action of an even traction."""
        points = self._points(nodes)
        areas = np.array([np.linalg.norm(self._area(facet)) for facet in face])
        middles = np.array(
            [self._points(each.nodes[: len(each.corners)]).mean(axis=0) for each in face]
        )
        away = forces @ points / (forces.sum() or np.nan) - areas @ middles / areas.sum()
        return bool(np.abs(away).max() < SAME_MIDDLE * np.ptp(points, axis=0).max())

    def _of_pieces(self, facets: Iterable[Facet]) -> Iterator[list[Facet]]:
        """Facets of each piece of the mesh: a boundary is on one body."""
        pieces: dict[int, list[Facet]] = {}
        for facet in facets:
            pieces.setdefault(self._deck.pieces[facet.nodes[0]], []).append(facet)
        yield from pieces.values()

    def _name(self, card: Card, facets: Sequence[Facet]) -> str:
        """The name of a surface, perhaps a new one."""
        sides = [(facet.element, facet.side) for facet in facets]
        known = self._names.get(frozenset(sides))
        # held and loaded nodes of the file are sets of nodes
        if known is not None and (card.word == "DLOAD" or known in self._deck.unnamed):
            return known
        while True:
            self._count[card.word] += 1
            name = f"{card.word}_{self._count[card.word]}"
            if not self._deck.named(name):
                break
        self._names[frozenset(sides)] = name
        self._deck.surfaces[name] = sides
        self._deck.unnamed[name] = len(_nodes(facets))
        return name


def _nodes(facets: Iterable[Facet]) -> set[int]:
    return {node for facet in facets for node in facet.nodes}


def _left(rows: Mapping[int, list[str]], facets: Iterable[Facet]) -> Iterator[list[str]]:
    """Rows, each once, of nodes that are on none of some facets."""
    on = _nodes(facets)
    left = {id(row): row for node, row in rows.items() if node not in on}
    yield from left.values()


def _faces(facets: Sequence[Facet]) -> Iterator[list[Facet]]:
    """Facets that hang together by their nodes."""
    last: dict[int, int] = {}
    pairs = []
    for number, facet in enumerate(facets):
        pairs += [(last[node], number) for node in facet.nodes if node in last]
        last |= dict.fromkeys(facet.nodes, number)
    first, second = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    groups = connected_groups(len(facets), first, second)
    for group in dict.fromkeys(groups.tolist()):
        yield [facet for facet, own in zip(facets, groups, strict=True) if own == group]
