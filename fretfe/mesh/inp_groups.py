# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies and boundaries of an Abaqus or CalculiX mesh: element sets, node sets and surfaces."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe.case import Selector
from fretfe.errors import MeshError
from fretfe.geometry.gmsh_model import ElementBlock, RawMesh
from fretfe.mesh.inp import Deck, read_deck
from fretfe.mesh.serendipity import complete

# Plane strain and plane stress; shells and membranes, which mesh generators write for plane cells.
PLANE = re.compile(r"(?:CPEG|CPE|CPS|M3D|STRI|S)([34689])\w*\Z")
LINE = re.compile(r"(?:T2D|T3D|B2|B3)\d\w*\Z")
UNSUPPORTED = {
    "volume elements": re.compile(r"C3D|SC\d|CSS\d"),
    "axisymmetric elements": re.compile(r"C?G?AX|SAX|MAX|SFMAX"),
}
# Gmsh types by the number of nodes.
CELLS = {3: 2, 4: 3, 6: 9, 8: 16, 9: 10}
LINES = {2: 1, 3: 8}


@dataclass(frozen=True)
class Facet:
    """A side of an element, by number; nodes: end, end[, middle]."""

    element: int
    side: int
    nodes: tuple[int, ...]


def read_inp(
    path: Path,
    bodies: Iterable[str],
    boundaries: Iterable[str],
    selectors: tuple[Mapping[str, Selector], Mapping[str, Selector]],
) -> RawMesh:
    """The bodies and boundaries of a case, by the names of sets and surfaces in the file.

    Args:
        path: input file.
        bodies: names of the bodies in the case: all plane elements belong to one of them.
        boundaries: names of the boundaries in the case.
        selectors: names in the file of bodies and of boundaries whose name is another one there.

    Raises:
        MeshError: the file cannot be read, or lacks a set.
    """
    deck = read_deck(path)
    numbers = sorted(deck.nodes)
    place = {number: index for index, number in enumerate(numbers)}
    points = np.array([deck.nodes[number] for number in numbers])
    plane = _plane_elements(path, deck)
    members = {
        name: _body_elements(path, deck, name, _label(name, selectors[0]), plane) for name in bodies
    }
    _require_all_elements(path, deck, plane, members)
    surfaces = {
        name: _blocks(([place[n] for n in plane[each]] for each in elements), CELLS)
        for name, elements in members.items()
    }
    groups = _Groups(path, deck, [[(each, plane[each]) for each in m] for m in members.values()])
    curves = {}
    for name in boundaries:
        facets = groups.boundary(name, _label(name, selectors[1]))
        curves[name] = _blocks(([place[n] for n in facet.nodes] for facet in facets), LINES)
    points, surfaces = complete(points, surfaces)
    return RawMesh(points, 2, surfaces, curves)


def _label(name: str, selectors: Mapping[str, Selector]) -> str:
    """The name in the file, in capitals."""
    selector = selectors.get(name)
    return ((selector.label if selector else None) or name).upper()


def _plane_elements(path: Path, deck: Deck) -> dict[int, tuple[int, ...]]:
    """Nodes of the plane elements.

    Raises:
        MeshError: elements of another dimension, or without all their nodes.
    """
    plane = {}
    for number, (kind, nodes) in deck.elements.items():
        for what, pattern in UNSUPPORTED.items():
            if pattern.match(kind):
                raise MeshError(
                    f"{path}: expected plane elements, found {what} ({kind}), which are not "
                    "supported"
                )
        match = PLANE.match(kind)
        if match and len(nodes) != int(match[1]):
            raise MeshError(
                f"{path}: element {number} of type {kind}: expected {match[1]} nodes, found "
                f"{len(nodes)}"
            )
        if missing := [node for node in nodes if match and node not in deck.nodes]:
            raise MeshError(f"{path}: element {number} has node {missing[0]}, which is not defined")
        if match:
            plane[number] = nodes
    return plane


def _body_elements(
    path: Path, deck: Deck, name: str, label: str, plane: Mapping[int, object]
) -> list[int]:
    members = dict.fromkeys(deck.element_sets.get(label, ()))
    if other := [number for number in members if number not in plane]:
        kind = deck.elements[other[0]][0] if other[0] in deck.elements else "not defined"
        raise MeshError(
            f"{path}: body '{name}': expected plane elements in the element set {label}, found "
            f"element {other[0]} ({kind})"
        )
    if not members:
        raise MeshError(
            f"{path}: no element set {label} for the body '{name}'; element sets: "
            f"{_listed(deck.element_sets)}"
        )
    return list(members)


def _require_all_elements(
    path: Path, deck: Deck, plane: Mapping[int, object], members: Mapping[str, list[int]]
) -> None:
    loose = plane.keys() - {number for numbers in members.values() for number in numbers}
    if loose:
        raise MeshError(
            f"{path}: expected all plane elements in one of the bodies {', '.join(members)}, but "
            f"{len(loose)} of {len(plane)} are in none, {min(loose)} for one; element sets: "
            f"{_listed(deck.element_sets)}"
        )


def _blocks(rows: Iterable[list[int]], types: Mapping[int, int]) -> list[ElementBlock]:
    by_count: dict[int, list[list[int]]] = {}
    for row in rows:
        by_count.setdefault(len(row), []).append(row)
    return [ElementBlock(types[count], np.array(found)) for count, found in by_count.items()]


class _Groups:
    """Facets of boundaries: surfaces, node sets, and element sets of lines, in this order."""

    def __init__(
        self, path: Path, deck: Deck, bodies: Iterable[list[tuple[int, tuple[int, ...]]]]
    ) -> None:
        self._path, self._deck = path, deck
        self._by_side: dict[tuple[int, int], Facet] = {}
        self._by_nodes: dict[frozenset[int], Facet] = {}
        self._exterior: list[Facet] = []
        for elements in bodies:
            facets = [facet for number, nodes in elements for facet in _sides(number, nodes)]
            self._by_side |= {(facet.element, facet.side): facet for facet in facets}
            self._by_nodes |= {frozenset(facet.nodes): facet for facet in facets}
            uses = Counter(frozenset(facet.nodes[:2]) for facet in facets)
            self._exterior += [each for each in facets if uses[frozenset(each.nodes[:2])] == 1]

    def boundary(self, name: str, label: str) -> list[Facet]:
        """The facets of a boundary, at least one."""
        deck = self._deck
        if label in deck.surfaces:
            found = self._of_surface(name, deck.surfaces[label])
        elif label in deck.node_sets:
            found = self._of_nodes(name, label, set(deck.node_sets[label]))
        elif label in deck.element_sets:
            found = self._of_lines(name, label, deck.element_sets[label])
        else:
            raise MeshError(
                f"{self._path}: no surface, node set or element set {label} for the boundary "
                f"'{name}'; surfaces: {_listed(deck.surfaces)}; node sets: "
                f"{_listed(deck.node_sets)}; element sets: {_listed(deck.element_sets)}"
            )
        if not found:
            raise MeshError(f"{self._path}: boundary '{name}': {label} has no facets")
        return found

    def _of_surface(self, name: str, entries: Iterable[tuple[int, int]]) -> list[Facet]:
        free: dict[int, list[Facet]] = {}
        for facet in self._exterior:
            free.setdefault(facet.element, []).append(facet)
        found = []
        for element, side in entries:
            if side and (element, side) not in self._by_side:
                raise MeshError(
                    f"{self._path}: boundary '{name}': element {element}, side S{side} is no side "
                    "of a plane element"
                )
            found += [self._by_side[element, side]] if side else free.get(element, [])
        return found

    def _of_nodes(self, name: str, label: str, nodes: set[int]) -> list[Facet]:
        """Exterior facets with all their nodes in a set, which has no others."""
        found = [facet for facet in self._exterior if nodes.issuperset(facet.nodes)]
        used = {node for facet in found for node in facet.nodes}
        if stray := sorted(nodes - used):
            x, y, _ = self._deck.nodes.get(stray[0], (np.nan, np.nan, np.nan))
            raise MeshError(
                f"{self._path}: boundary '{name}': expected nodes of whole facets on the outside of"
                f" a body in the node set {label}, but {len(stray)} of its {len(nodes)} nodes are "
                f"on none, the first is {stray[0]} at ({x:.6g}, {y:.6g}). A facet has both its end "
                "nodes and, in elements of order 2, its middle node in the set"
            )
        return found

    def _of_lines(self, name: str, label: str, members: Iterable[int]) -> list[Facet]:
        """Facets that line elements lie on, whatever the order of the nodes of these."""
        found = []
        for number in members:
            kind, nodes = self._deck.elements.get(number, ("not defined", ()))
            facet = self._by_nodes.get(frozenset(nodes))
            if not LINE.match(kind) or facet is None:
                raise MeshError(
                    f"{self._path}: boundary '{name}': expected line elements along the bodies in "
                    f"the element set {label}, found element {number} ({kind}); use a node set or "
                    "a surface"
                )
            found.append(facet)
        return found


def _sides(number: int, nodes: tuple[int, ...]) -> list[Facet]:
    """Sides S1, S2, ... of a plane element: from its first to its second corner, and so on."""
    corners = 3 if len(nodes) in (3, 6) else 4
    middles = nodes[corners : 2 * corners]
    return [
        Facet(number, i + 1, (nodes[i], nodes[(i + 1) % corners], *middles[i : i + 1]))
        for i in range(corners)
    ]


def _listed(names: Iterable[str]) -> str:
    return ", ".join(names) or "none"
