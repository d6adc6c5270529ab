# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies and boundaries of an Abaqus or CalculiX mesh: kinds of elements, sets, sides."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Hashable, Iterable, Iterator, Mapping, Set
from contextlib import suppress
from pathlib import Path

import numpy as np

from fretfe._typing import Array
from fretfe.case import AnyBody, Selector
from fretfe.case.tables import Part
from fretfe.errors import MeshError
from fretfe.mesh.elements import SOLID_TYPES, TYPES, complete, in_gmsh_order
from fretfe.mesh.gmsh import ElementBlock, RawMesh
from fretfe.mesh.inp import FACES, Constant, Deck, Material, Side, read_deck
from fretfe.mesh.inp_demands import NOTHING, Uses, require
from fretfe.mesh.inp_language import ANALYSIS
from fretfe.mesh.inp_shapes import Facet, sides, without_double_nodes
from fretfe.mesh.inp_unnamed import name_surfaces
from fretfe.mesh.part import distances
from fretfe.mesh.planes import upright
from fretfe.mesh.templates import did_you_mean

# Plane strain and plane stress; shells and membranes, which mesh generators write for plane cells.
PLANE = re.compile(r"(?:CPEG|CPE|CPS|M3D|STRI|S)([34689])\w*\Z")
SOLID = re.compile(r"C3D(4|5|6|8|10|15|20)(?!\d)\w*\Z")
SOLIDS = "tetrahedra (C3D4, C3D10), hexahedra (C3D8, C3D20) or wedges (C3D6, C3D15)"
LINE = re.compile(r"(?:T2D|T3D|B2|B3)\d\w*\Z")
UNSUPPORTED = {
    "axisymmetric elements": re.compile(r"C?G?AX|SAX|MAX|SFMAX"),
    "volume elements": re.compile(r"C3D(?!(?:4|5|6|8|10|15|20)(?!\d))|SC\d|CSS\d"),
}
# Points with a mass or of a coupling, surfaces without stiffness: without them a model has the same
# statics.
HARMLESS = re.compile(r"(?:MASS|ROTARYI|HEATCAP|SFM|DCOUP)\w*\Z")
# Elements of bodies, and those that may stand for their facets, by dimension.
BODY_ELEMENTS = {2: PLANE, 3: SOLID}
FACET_ELEMENTS = {2: LINE, 3: PLANE}
# Numbers of a deck that differ by less, relatively, are the same.
SAME = 1e-6


def read_inp(
    path: Path,
    bodies: Mapping[str, AnyBody | None],
    boundaries: Iterable[str],
    selectors: tuple[Mapping[str, Selector], Mapping[str, Selector]],
    uses: Uses = NOTHING,
    part: Part | None = None,
) -> RawMesh:
    """The bodies and boundaries of a case, by the names of sets and surfaces in the file.

    Args:
        path: input file.
        bodies: those of the case, None for one that only a selector names: all solid elements
            belong to one of them, or all plane ones where there are no solid ones.
        boundaries: names of the boundaries in the case.
        selectors: names in the file of bodies and of boundaries whose name is another one there.
        uses: what the case does with boundaries, by their names in the file.
        part: that is cut out of the mesh: of what has no node there nothing is asked.

    Raises:
        MeshError: the file cannot be read, or lacks a set.
    """
    deck = read_deck(path)
    numbers = sorted(deck.nodes)
    place = {number: index for index, number in enumerate(numbers)}
    points = np.array([deck.nodes[number] for number in numbers])
    dimension = 3 if any(SOLID.match(kind) for kind, _ in deck.elements.values()) else 2
    inside = _inside(deck, points, place, dimension, part)
    cells = supported_cells(path, deck, dimension, inside)
    members = {
        name: _body_elements(path, deck, name, label_of(name, selectors[0]), cells)
        for name in bodies
    }
    _require_all_elements(path, deck, cells, members, inside)
    named = {
        name: _blocks(
            ([place[n] for n in _whole(path, deck, each, dimension)] for each in elements),
            dimension,
        )
        for name, elements in members.items()
    }
    own = [[(each, cells[each]) for each in elements] for elements in members.values()]
    groups = Groups(path, deck, dimension, own)
    outside = {}
    for name in boundaries:
        try:
            facets = groups.boundary(name, label_of(name, selectors[1]))
        except MeshError as error:
            key = uses.keys.get(name)
            raise MeshError(f"{key}: {error}" if key else str(error)) from None
        rows = ([place[n] for n in facet.nodes] for facet in facets)
        outside[name] = _blocks(rows, dimension - 1)
    require(deck, dimension, uses, groups.key, lambda label: groups.reaches(label, inside))
    # a case has what these say in its tables
    in_case = {card.keyword for card in deck.analysis if card.word in ANALYSIS}
    notes = (
        *unused(path, deck, cells.keys() | groups.used, in_case),
        *_material_notes(path, deck, bodies, members),
    )
    return complete(RawMesh(points, dimension, named, outside, notes))


def _inside(
    deck: Deck, points: Array, place: Mapping[int, int], dimension: int, part: Part | None
) -> set[int]:
    """Nodes near the centre of a part; all without one."""
    if part is None:
        return set(deck.nodes)
    if dimension == 2:
        kinds = (nodes for kind, nodes in deck.elements.values() if PLANE.match(kind))
        own = [place[node] for nodes in kinds for node in nodes if node in place]
        points, _ = upright(points, np.array(own))
    near = distances(part, points) <= part.radius
    return {number for number, index in place.items() if near[index]}


def unused(path: Path, deck: Deck, used: Set[int], read: Set[str] = frozenset()) -> Iterator[str]:
    """Parts of the file that are not used, in words.

    Args:
        path: of the file.
        deck: what was read.
        used: numbers of elements that are.
        read: keywords that are.
    """
    if deck.broken:
        name, reason = next(iter(deck.broken.items()))
        yield (
            f"{path.name}: sets and surfaces that cannot be read, and are not used: "
            f"{listed(deck.broken)}; {name}: {reason.removeprefix(str(path.parent) + '/')}"
        )
    if left := sorted((word, count) for word, count in deck.unused.items() if word not in read):
        words = ", ".join(f"{count} *{word}" for word, count in left)
        yield f"{path.name}: keywords that are not used: {words}"
    kinds = Counter(kind for number, (kind, _) in deck.elements.items() if number not in used)
    if kinds:
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
        yield f"{path.name}: elements that are not used: {counts}"


def _material_notes(
    path: Path, deck: Deck, bodies: Mapping[str, AnyBody | None], members: Mapping[str, list[int]]
) -> Iterator[str]:
    """Numbers of materials that the case has not, or other ones, in words: the case counts."""
    for body, elements in members.items():
        found = deck.materials_of(elements)
        case = bodies[body]
        if len(found) > 1:
            yield (
                f"{path.name}: body '{body}' has {len(found)} materials, {', '.join(found)}, in "
                "place of which it has that of the case"
            )
        elif found and case is not None:
            there = deck.materials.get(found[0], Material()).numbers
            # a crystal has other constants
            here = {key: getattr(case, key, None) for key in there}
            other = [key for key in there if _differ(here[key], there[key])]
            if other:
                theirs = ", ".join(f"{key} = {_constant_text(there[key])}" for key in other)
                ours = ", ".join("none" if here[k] is None else f"{here[k]:.9g}" for k in other)
                yield (
                    f"{path.name}: material {found[0]} of body '{body}' has {theirs}; the case "
                    f"has {ours}, which counts"
                )


def _differ(here: float | None, there: Constant) -> bool:
    """True if a constant is another one; one over temperature has all values in between."""
    if here is None:
        return True
    if not isinstance(there, dict):
        return not math.isclose(here, there, rel_tol=SAME)
    low, high = min(there["values"]), max(there["values"])
    return not low * (1 - SAME) <= here <= high * (1 + SAME)


def _constant_text(constant: Constant) -> str:
    """A constant in a note."""
    if isinstance(constant, dict):
        values, places = constant["values"], constant["temperatures"]
        return f"{values[0]:.9g} to {values[-1]:.9g} at {places[0]:g} to {places[-1]:g}"
    return f"{constant:.9g}"


def label_of(name: str, selectors: Mapping[str, Selector]) -> str:
    """The name in the file, in capitals."""
    selector = selectors.get(name)
    return ((selector.label if selector else None) or name).upper()


def supported_cells(
    path: Path, deck: Deck, dimension: int, inside: Set[int] | None = None
) -> dict[int, tuple[int, ...]]:
    """Nodes of the elements that bodies are made of.

    Args:
        path: of the file.
        deck: what was read.
        dimension: of the bodies.
        inside: nodes; elements without any of them are not refused. All without it.

    Raises:
        MeshError: elements that are not supported, or without all their nodes.
    """
    cells = {}
    for number, (kind, nodes) in deck.elements.items():
        for what, pattern in UNSUPPORTED.items():
            if pattern.match(kind):
                raise MeshError(
                    f"{path}: expected plane elements, {SOLIDS}, found {what} ({kind}), which are "
                    "not supported"
                )
        match = BODY_ELEMENTS[dimension].match(kind)
        if not match and inside is not None and inside.isdisjoint(nodes):
            continue
        known = match or FACET_ELEMENTS[dimension].match(kind) or LINE.match(kind)
        if not known and not HARMLESS.match(kind):
            raise MeshError(
                f"{path}: element {deck.text(number)} is of type {kind}, which is not supported: "
                f"a model without it would be another one. Expected plane elements, {SOLIDS}, and "
                "lines, shells or membranes along them for boundaries"
            )
        if match and len(nodes) != int(match[1]):
            raise MeshError(
                f"{path}: element {deck.text(number)} of type {kind}: expected {match[1]} nodes, "
                f"found {len(nodes)}"
            )
        if missing := [node for node in nodes if match and node not in deck.nodes]:
            raise MeshError(
                f"{path}: element {deck.text(number)} has node {deck.text(missing[0])}, which is "
                "not defined"
            )
        if match:
            cells[number] = nodes
    return cells


def _body_elements(
    path: Path, deck: Deck, name: str, label: str, cells: Mapping[int, object]
) -> list[int]:
    if label in deck.broken:
        raise MeshError(f"{deck.broken[label]}; the body '{name}' needs it")
    members = dict.fromkeys(deck.elements_of(label))
    if label not in deck.element_sets:  # with shells and lines on it
        members = {number: None for number in members if number in cells}
    if other := [number for number in members if number not in cells]:
        kind = deck.elements[other[0]][0] if other[0] in deck.elements else "not defined"
        raise MeshError(
            f"{path}: body '{name}': expected elements of one kind of body, all plane or all "
            f"solid, in the element set {label}, found element {deck.text(other[0])} ({kind})"
        )
    if not members:
        raise MeshError(
            f"{path}: no element set {label} for the body '{name}', and no surface of it; element "
            f"sets: {listed(deck.element_sets)}"
        )
    return list(members)


def _require_all_elements(
    path: Path,
    deck: Deck,
    cells: Mapping[int, tuple[int, ...]],
    members: Mapping[str, list[int]],
    inside: Set[int],
) -> None:
    loose = cells.keys() - {number for numbers in members.values() for number in numbers}
    loose = {number for number in loose if not inside.isdisjoint(cells[number])}
    if loose:
        raise MeshError(
            f"{path}: expected all elements in one of the bodies {', '.join(members)}, but "
            f"{len(loose)} of {len(cells)} are in none, {deck.text(min(loose))} for one; "
            f"element sets: {listed(deck.element_sets)}"
        )


def _whole(path: Path, deck: Deck, number: int, dimension: int) -> tuple[int, ...]:
    """Nodes of an element, each once."""
    try:
        return without_double_nodes(deck.elements[number][1], dimension)
    except ValueError as error:
        raise MeshError(f"{path}: element {deck.text(number)} {error}") from None


def _blocks(rows: Iterable[list[int]], dimension: int) -> list[ElementBlock]:
    by_count: dict[int, list[list[int]]] = {}
    for row in rows:
        by_count.setdefault(len(row), []).append(row)
    return [
        ElementBlock(kind, in_gmsh_order(kind, np.array(found)))
        for count, found in by_count.items()
        for kind in [SOLID_TYPES[count] if dimension == 3 else TYPES[dimension, count]]
    ]


class Groups:
    """Facets of boundaries: surfaces, node sets, element sets of lines or shells, in this order."""

    def __init__(
        self,
        path: Path,
        deck: Deck,
        dimension: int,
        bodies: Iterable[list[tuple[int, tuple[int, ...]]]],
    ) -> None:
        self._path, self._deck, self._dimension = path, deck, dimension
        self._by_side: dict[tuple[int, int], Facet] = {}
        self._by_nodes: dict[frozenset[int], Facet] = {}
        self._exterior: list[Facet] = []
        # elements that stand for facets
        self.used: set[int] = set()
        for elements in bodies:
            facets = [
                facet for number, nodes in elements for facet in sides(number, nodes, dimension)
            ]
            self._by_side |= {(facet.element, facet.side): facet for facet in facets}
            self._by_nodes |= {frozenset(facet.nodes): facet for facet in facets}
            uses = Counter(facet.corners for facet in facets)
            self._exterior += _outside([each for each in facets if uses[each.corners] == 1])
        name_surfaces(deck, self._exterior)

    def key(self, label: str) -> Hashable:
        """The same for different names of the same facets; a name itself that has none."""
        return frozenset((each.element, each.side) for each in self._found(label)) or label

    def reaches(self, label: str, nodes: Set[int]) -> bool:
        """True if a surface or set has one of some nodes; of an unknown one it may have."""
        found = {node for facet in self._found(label) for node in facet.nodes}
        own = found or self._deck.nodes_at(label)
        return not own or not nodes.isdisjoint(own)

    def _found(self, label: str) -> list[Facet]:
        """The facets of a boundary; none where it is no boundary."""
        with suppress(MeshError):
            return self.boundary(label, label)
        return []

    def boundary(self, name: str, label: str) -> list[Facet]:
        """The facets of a boundary, at least one."""
        deck = self._deck
        if label in deck.surfaces:
            found = self._of_surface(name, deck.surfaces[label])
        elif label in deck.node_sets:
            found = self._of_nodes(name, label, set(deck.node_sets[label]))
        elif label in deck.element_sets:
            found = self._of_elements(name, f"the element set {label}", deck.element_sets[label])
        elif label in deck.broken:
            raise MeshError(f"{deck.broken[label]}; the boundary '{name}' needs it")
        else:
            near = did_you_mean(label, (*deck.surfaces, *deck.node_sets, *deck.element_sets))
            raise MeshError(
                f"{self._path}: no surface, node set or element set {label} for the boundary "
                f"'{name}'{near}; surfaces: {listed(deck.surfaces)}; node sets: "
                f"{listed(deck.node_sets)}; element sets: {listed(deck.element_sets)}"
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
            kind, _ = self._deck.elements[element]
            covers = self._dimension == 3 and PLANE.match(kind) is not None
            if side == Side.FACE and not covers:
                raise MeshError(
                    f"{self._path}: boundary '{name}': expected an edge, E1 to E4 (Abaqus) or S3 "
                    f"to S6 (CalculiX), of the shell {self._deck.text(element)} ({kind}), found "
                    f"one of its faces ({', '.join(FACES)})"
                )
            if covers and side <= 0:
                found += self._of_elements(name, "the surface", [element])
            elif side and (element, side) not in self._by_side:
                raise MeshError(
                    f"{self._path}: boundary '{name}': element {self._deck.text(element)}, "
                    f"side S{side} is no side of an element of a body"
                )
            else:
                found += [self._by_side[element, side]] if side else free.get(element, [])
        return found

    def _of_nodes(self, name: str, label: str, nodes: set[int]) -> list[Facet]:
        """Exterior facets with all their nodes in a set, which has no others."""
        found = [facet for facet in self._exterior if nodes.issuperset(facet.nodes)]
        used = {node for facet in found for node in facet.nodes}
        if stray := sorted(nodes - used):
            place = self._deck.nodes.get(stray[0], (np.nan,) * 3)[: self._dimension]
            place_text = ", ".join(f"{value:.6g}" for value in place)
            raise MeshError(
                f"{self._path}: boundary '{name}': expected nodes of whole facets on the outside of"
                f" a body in the node set {label}, but {len(stray)} of its {len(nodes)} nodes are "
                f"on none, the first is {self._deck.text(stray[0])} at ({place_text}). "
                "A facet has all its corners and, in elements of order 2, its mid-side nodes in "
                "the set"
            )
        return found

    def _of_elements(self, name: str, label: str, members: Iterable[int]) -> list[Facet]:
        """Facets that lines or shells lie on, whatever the order of the nodes of these."""
        what = {2: "line elements along", 3: "shells or membranes on"}[self._dimension]
        found = []
        for number in members:
            kind, nodes = self._deck.elements.get(number, ("not defined", ()))
            facet = self._by_nodes.get(frozenset(nodes))
            if not FACET_ELEMENTS[self._dimension].match(kind) or facet is None:
                raise MeshError(
                    f"{self._path}: boundary '{name}': expected {what} the bodies in "
                    f"{label}, found element {self._deck.text(number)} "
                    f"({kind}); use a node set or a surface"
                )
            found.append(facet)
            self.used.add(number)
        return found


def _outside(facets: list[Facet]) -> list[Facet]:
    """Facets of one element only, without quadrilaterals on which two triangles lie, and these."""
    triangles = {facet.corners for facet in facets if len(facet.corners) == 3}
    if not triangles or len({len(facet.corners) for facet in facets}) == 1:
        return facets
    inside: set[frozenset[int]] = set()
    for facet in facets:
        if len(facet.corners) == 4:
            a, b, c, d = facet.nodes[:4]
            for halves in (((a, b, c), (a, c, d)), ((a, b, d), (b, c, d))):
                if triangles.issuperset(map(frozenset, halves)):
                    inside.update((facet.corners, *map(frozenset, halves)))
    return [facet for facet in facets if facet.corners not in inside]


def listed(names: Iterable[str]) -> str:
    """Names but those of sets that Abaqus/CAE makes for itself, which begin with a line."""
    return (
        ", ".join(name for name in names if not name.rpartition(".")[2].startswith("_")) or "none"
    )
