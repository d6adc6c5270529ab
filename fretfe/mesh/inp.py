# SPDX-License-Identifier: LGPL-3.0-or-later
"""Abaqus and CalculiX input files: nodes, elements, sets, surfaces, materials as they are written.

Own reading rather than meshio's, which (5.3.5) knows half of the plane elements, keeps only the
last of several *NODE blocks, and passes over node sets made of sets, surfaces and parts in silence.
Parts that are placed as instances become one flat mesh.
"""

from __future__ import annotations

import functools
import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from itertools import pairwise
from pathlib import Path

import numpy as np

from fretfe._typing import Array
from fretfe.errors import MeshError
from fretfe.files import MOST_MEMBERS, MOST_PLACED
from fretfe.mesh.inp_cards import WHOLE, Card, cards, real
from fretfe.mesh.inp_language import ACTING, ANALYSIS, JOINED, REFERENCES, REFUSED

# Parameters of a rigid body that is an analytical surface and nothing of the mesh.
ANALYTICAL = {"ANALYTICALSURFACE", "REFNODE", "POSITION", "ISOTHERMAL"}
# Laws of *SURFACE BEHAVIOR, the first of which is that of a case.
OVERCLOSURES = ("HARD", "EXPONENTIAL", "LINEAR", "TABULAR", "SCALEFACTOR", "TIED")
# A type of *MODEL CHANGE that says nothing of the mesh.
CONTACT = "CONTACTPAIR"
# Shells and membranes, whose sides are called otherwise.
SHELL = re.compile(r"(?:M3D|STRI|S)\d")
SIDE = re.compile(r"([SE])([1-6])\Z")
# Faces of a shell in Abaqus and in CalculiX.
FACES = ("SPOS", "SNEG", "S1", "S2")
# Types of one node, whose digits are dimensions; triangular shells, whose second digit is that of
# degrees of freedom; lines and shells of revolution, whose last digit is their order.
ONE_NODE = re.compile(r"MASS|ROTARYI|HEATCAP|DCOUP")
TRIANGULAR_SHELL = re.compile(r"STRI(\d)")
OF_ORDER = re.compile(r"(?:B[23]|PIPE[23]|ELBOW3|SAX|MAX|SFMAX)([123])")
# All others: a family, perhaps with its dimension, and the number of nodes (Abaqus Elements Guide,
# Element index; CalculiX has the same names). Types of users are called U and a number.
NUMBERED = re.compile(r"(?!U\d)[A-Z]+(?:[123]D)?(\d+)")
# Numbers of nodes and elements are smaller; those of instance i are i times this one larger.
STRIDE = 10**9

Point = tuple[float, float, float]
# A number, or `temperatures` and `values` as a body of a case may have them.
Constant = float | dict[str, list[float]]


class Side(IntEnum):
    """Sides of elements without a number of their own: S1 is 1."""

    FREE = 0
    FACE = -1


class _UnknownError(ValueError):
    """A name or number that the file has not, or not yet."""


@dataclass
class Material:
    """Elastic material.

    Attributes:
        numbers: by the keys that a body of a case has.
        left_out: what else is said of it that no body has, in words.
    """

    numbers: dict[str, Constant] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)


@dataclass
class Level:
    """Contents of a part, an instance, or the model outside them; names are in capitals.

    Attributes:
        nodes: coordinates by number.
        elements: type and nodes by number.
        node_sets: numbers of nodes, in order.
        element_sets: numbers of elements.
        surfaces: element numbers and sides: S1 is 1, or a `Side`.
        sections: element sets and their materials.
        thicknesses: of plane elements, as sections have them.
        broken: why a set or surface cannot be read, by name; it is in none of the others.
        waiting: sets that name others which have not come yet.
        surface_cards: surfaces, which are read when all sets are known.
    """

    nodes: dict[int, Point] = field(default_factory=dict)
    elements: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    sections: list[tuple[str, str]] = field(default_factory=list)
    thicknesses: set[float] = field(default_factory=set)
    broken: dict[str, str] = field(default_factory=dict)
    waiting: list[Card] = field(default_factory=list)
    surface_cards: list[Card] = field(default_factory=list)

    def settle(self) -> None:
        """Read surfaces, and sets that waited for what comes after them in the file."""
        reasons: dict[str, str] = {}
        while sets := [*self.waiting]:
            for card in sets:
                self.waiting.remove(card)
                try:
                    _READERS[card.word](self, card)
                except _UnknownError as error:
                    reasons[card.place] = str(error)
                    self.waiting.append(card)
                except ValueError as error:
                    self._break(card, card.required(card.word), str(error))
            if len(self.waiting) == len(sets):
                break
        for card in self.waiting:
            self._break(card, card.required(card.word), reasons[card.place])
        # those that are made of others come last
        for card in sorted(self.surface_cards, key=lambda each: "COMBINE" in each.parameters):
            try:
                _surface(self, card)
            except ValueError as error:
                self._break(card, card.required("NAME"), str(error))
        self.waiting, self.surface_cards = [], []

    def _break(self, card: Card, name: str, reason: str) -> None:
        """Take a set or surface away that is not whole."""
        self.broken[name] = f"{card.place}: cannot read *{card.keyword}: {reason}"
        for table in (self.node_sets, self.element_sets, self.surfaces):
            table.pop(name, None)

    def members(self, word: str, name: str) -> list[int]:
        """Numbers in a set of nodes (NSET) or elements (ELSET).

        Raises:
            _UnknownError: there is none, or not all of it has been read yet.
        """
        table = self.node_sets if word == "NSET" else self.element_sets
        waits = any(card.word == word and card.name(word) == name for card in self.waiting)
        if name not in table or waits:
            raise _UnknownError(f"there is no set {name!r}")
        return table[name]

    def number(self, text: str, instance: str | None = None) -> int:
        """The number of a node or element, perhaps one of an instance as `NAME.7`."""
        own = text
        # a name begins with a letter, or in quotes
        if "." in text and instance is None and (text[0].isalpha() or text[0] in '_"'):
            instance, _, own = text.rpartition(".")
        if not WHOLE.fullmatch(own) or not 0 < (value := int(own)) < STRIDE:
            raise ValueError(f"expected a number from 1 to {STRIDE - 1}, found {own}")
        return value if instance is None else value + self.first(instance)

    def first(self, instance: str) -> int:
        """The number added to those of an instance."""
        raise _UnknownError(f"there is no instance {instance!r} here")


@dataclass
class Deck(Level):
    """The mesh in an input file: all instances in one, with numbers that are larger by theirs.

    Sets and surfaces of an instance have its name in front, `NAME.SET`, and their own names, too,
    where nothing else has these. All elements of an instance are in a set with its name.

    Attributes:
        instances: by name, in order, the number added to those of their nodes and elements.
        materials: by name.
        unused: how often there was each keyword that says nothing of the mesh.
        analysis: keywords of contacts and steps, which are among these.
        title: of the model; empty without one.
        ties: file and line, and the two surfaces, of parts that are bonded.
        cyclic: ties of the sides of sectors, and what says how many these are.
        couplings: keywords with reference nodes.
        unnamed: surfaces that have their names here, with the number of their nodes.
    """

    instances: dict[str, int] = field(default_factory=dict)
    materials: dict[str, Material] = field(default_factory=dict)
    unused: Counter[str] = field(default_factory=Counter)
    analysis: list[Card] = field(default_factory=list)
    title: str = ""
    ties: list[tuple[str, str, str]] = field(default_factory=list)
    cyclic: list[Card] = field(default_factory=list)
    couplings: list[Card] = field(default_factory=list)
    unnamed: dict[str, int] = field(default_factory=dict)

    def first(self, instance: str) -> int:
        """The number added to those of an instance."""
        name = instance.strip('"').upper()
        if name not in self.instances:
            raise _UnknownError(
                f"there is no instance {instance!r}; instances: {', '.join(self.instances) or '-'}"
            )
        return self.instances[name]

    def text(self, number: int) -> str:
        """The number as it is written in the file, with the name of its instance."""
        instance, own = divmod(number, STRIDE)
        return f"{list(self.instances)[instance - 1]}.{own}" if instance else str(own)

    def materials_of(self, elements: Iterable[int]) -> list[str]:
        """Names of the materials that sections give to elements, sorted."""
        names = {
            number: material
            for label, material in self.sections
            for number in self.element_sets.get(label, ())
        }
        return sorted({names[number] for number in elements if number in names})

    def elements_of(self, label: str) -> list[int]:
        """Elements of an element set, or that hang together with the surface or node set."""
        if label in self.element_sets:
            return self.element_sets[label]
        wanted = {self.pieces.get(node) for node in self.nodes_at(label)}
        return [number for number, (_, own) in self.elements.items()
                if wanted and self.pieces[own[0]] in wanted]  # fmt: skip

    @functools.cached_property
    def pieces(self) -> dict[int, int]:
        """Nodes of elements, and the number of the piece of the mesh that each is in.

        Pieces that are tied are one.
        """
        # Imported where it is needed: a mesh is begun without SciPy.
        from scipy import sparse
        from scipy.sparse.csgraph import connected_components

        joined_nodes = [nodes for _, nodes in self.elements.values()]
        joined_nodes += [
            (*self.nodes_at(one), *self.nodes_at(other)) for _, one, other in self.ties
        ]
        rows = np.repeat(np.arange(len(joined_nodes)), [*map(len, joined_nodes)])
        numbers, columns = np.unique(
            [node for nodes in joined_nodes for node in nodes], return_inverse=True
        )
        joined = sparse.coo_matrix((np.ones(len(rows)), (rows, len(joined_nodes) + columns)),
                                   shape=(len(joined_nodes) + len(numbers),) * 2)  # fmt: skip
        pieces = connected_components(joined, directed=False)[1][len(joined_nodes) :]
        return dict(zip(numbers.tolist(), pieces.tolist(), strict=True))

    def nodes_at(self, label: str) -> tuple[int, ...]:
        """Nodes of a node set, of an element set, or of the elements with sides in a surface."""
        elements = [number for number, _ in self.surfaces.get(label, ())]
        elements += self.element_sets.get(label, ())
        nodes = (node for number in elements for node in self.elements[number][1])
        return (*nodes, *self.node_sets.get(label, ()))

    def labelled(self, text: str) -> list[int]:
        """Numbers of the nodes in a set, or the one that stands there; none of a wrong label."""
        try:
            return self.node_sets.get(text.strip('"').upper()) or [self.number(text)]
        except ValueError:
            return []

    def named(self, name: str) -> bool:
        """True if a set or surface has this name."""
        tables = (self.node_sets, self.element_sets, self.surfaces, self.broken)
        return any(name in each for each in tables)

    def add(self, name: str, level: Level) -> None:
        """Add an instance."""
        first = self.instances[name] = STRIDE * (len(self.instances) + 1)
        self.nodes |= {number + first: point for number, point in level.nodes.items()}
        self.elements |= {
            number + first: (kind, tuple(node + first for node in nodes))
            for number, (kind, nodes) in level.elements.items()
        }
        for own, of_all in (
            (level.node_sets, self.node_sets), (level.element_sets, self.element_sets)
        ):  # fmt: skip
            for each, members in own.items():
                of_all[f"{name}.{each}"] = [number + first for number in members]
        for each, entries in level.surfaces.items():
            self.surfaces[f"{name}.{each}"] = [(number + first, side) for number, side in entries]
        self.sections += [(f"{name}.{each}", material) for each, material in level.sections]
        self.thicknesses |= level.thicknesses
        self.broken |= {f"{name}.{each}": reason for each, reason in level.broken.items()}


def read_deck(path: Path) -> Deck:
    """Read an input file and the files that it includes.

    Raises:
        MeshError: a file cannot be read, or says something that is not understood.
    """
    reader = _Reader()
    for card in cards(path):
        _refuse_keyword(card)
        try:
            reader.read(card)
        except (ValueError, IndexError, KeyError, OverflowError) as error:
            raise MeshError(f"{card.place}: cannot read *{card.keyword}: {error}") from error
    if reader.open:
        card = reader.open[-1]
        raise MeshError(f"{card.place}: expected *END {card.keyword} after it, found none")
    reader.place_alone()
    deck = reader.deck
    if not deck.nodes or not deck.elements:
        unplaced = ", ".join(reader.parts.keys() - reader.placed)
        raise MeshError(
            f"{path}: expected an Abaqus or CalculiX input file with nodes and elements, found "
            f"{len(deck.nodes)} nodes and {len(deck.elements)} elements"
            + (f"; no instance places the parts {unplaced}" if unplaced else "")
        )
    reader.finish()
    return deck


def _refuse_keyword(card: Card) -> None:
    """Raise for a keyword without which the model would be another one."""
    overclosure = card.parameters.get("PRESSURE-OVERCLOSURE", "").upper()
    tied = "TIED" in card.parameters or overclosure in ("TI", "TIE", "TIED")
    # which contacts there are, the case says
    of_contact = card.word == "MODELCHANGE" and card.choice("TYPE", "ELEMENT", CONTACT) == CONTACT
    if (card.word in REFUSED or tied) and not of_contact:
        with_word = " with TIED" if tied else ""
        raise MeshError(
            f"{card.place}: *{card.keyword}{with_word} is not supported; "
            f"{REFUSED.get(card.word, JOINED)}"
        )


class _Reader:
    """Reads keyword after keyword into the level that is open."""

    def __init__(self) -> None:
        self.deck = Deck()
        self.parts: dict[str, Level] = {}
        self.placed: set[str] = set()
        # *PART, *ASSEMBLY and *INSTANCE that have not ended, and where their data goes.
        self.open: list[Card] = []
        self._level: Level = self.deck
        # Sets and surfaces by their own names, with the instances that have one.
        self._own: dict[str, set[str]] = {}
        self._elements: dict[str, list[int]] = {}
        self._moved, self._size, self._assembled = False, 0, False
        self._material: Material | None = None
        self._blocks: dict[str, Callable[[Card], None]] = {
            "PART": self._part, "ASSEMBLY": self._assembly, "INSTANCE": self._instance,
            "ENDPART": self._end_part, "ENDASSEMBLY": self._close,
            "ENDINSTANCE": self._end_instance, "MATERIAL": self._begin_material,
        }  # fmt: skip

    def read(self, card: Card) -> None:
        """Read one; those that say nothing of the mesh are counted."""
        if card.word == "HEADING":
            self.deck.title = self.deck.title or ", ".join((card.rows or [[""]])[0])
            return
        if card.word == "SURFACEBEHAVIOR":
            hard, *_ = OVERCLOSURES
            if card.choice("PRESSURE-OVERCLOSURE", *OVERCLOSURES) == hard:
                return
        if card.word == "CYCLICSYMMETRYMODEL" or "CYCLICSYMMETRY" in card.parameters:
            card.require_text()
            self.deck.cyclic.append(card)
            return
        if card.word == "TIE":
            card.require_text()
            self.deck.ties += [(card.place, *pair) for pair in card.pairs()]
            return
        analytical = "ANALYTICALSURFACE" in card.parameters
        if card.word in REFERENCES and not (analytical and card.parameters.keys() <= ANALYTICAL):
            card.require_text()
            self.deck.couplings.append(card)
            return
        read, block = _READERS.get(card.word), self._blocks.get(card.word)
        of_material = _OF_MATERIALS.get(card.word) if self._material is not None else None
        if block is None and read is None and of_material is None and card.word != "SURFACE":
            self.deck.unused.update([card.keyword])
            self.deck.analysis += [card] if card.word in (*ANALYSIS, *ACTING) else []
            return
        card.require_text()
        if block is not None:
            block(card)
        elif card.word == "SURFACE":
            card.required("NAME")
            self._level.surface_cards.append(card)
        elif read is not None:
            try:
                read(self._level, card)
            except _UnknownError:
                if card.word not in ("NSET", "ELSET"):
                    raise
                self._level.waiting.append(card)
        elif of_material is not None and self._material is not None:
            of_material(self._material, card)

    def place_alone(self) -> None:
        """Place the parts of a file that has nothing else: no assembly, no other nodes."""
        if not self._assembled and not self.deck.nodes:
            for name, part in self.parts.items():
                self.placed.add(name)
                self._place(name, part)

    def finish(self) -> None:
        """Give instances and what they alone have names without a prefix."""
        deck = self.deck
        deck.settle()
        deck.element_sets |= {
            name: members for name, members in self._elements.items() if not deck.named(name)
        }
        for name, instances in self._own.items():
            if len(instances) > 1 or deck.named(name):
                continue
            (qualified,) = (f"{instance}.{name}" for instance in instances)
            tables: tuple[dict[str, list[int]], ...] = (deck.node_sets, deck.element_sets)
            for table in tables:
                if qualified in table:
                    table[name] = table[qualified]
            if qualified in deck.surfaces:
                deck.surfaces[name] = deck.surfaces[qualified]
            if qualified in deck.broken:
                deck.broken[name] = deck.broken[qualified]

    def _begin(self, card: Card, *within: str) -> None:
        if tuple(each.word for each in self.open) != within:
            expected = f"within *{within[-1]}" if within else "outside parts and the assembly"
            raise ValueError(f"expected it {expected}")
        self.open.append(card)

    def _close(self, card: Card) -> None:
        word = card.word.removeprefix("END")
        if not self.open or self.open[-1].word != word:
            raise ValueError(f"expected *{word} before it")
        self.open.pop()

    def _part(self, card: Card) -> None:
        name = card.required("NAME")
        if name in self.parts:
            raise ValueError(f"there is a part {name!r} already")
        self._begin(card)
        self._level = self.parts[name] = Level()

    def _end_part(self, card: Card) -> None:
        self._close(card)
        self._level.settle()
        self._level = self.deck

    def _assembly(self, card: Card) -> None:
        self._begin(card)
        self._assembled = True

    def _instance(self, card: Card) -> None:
        card.refuse("LIBRARY", "INSTANCE")
        name, part = card.required("NAME"), card.required("PART")
        if part not in self.parts:
            parts = ", ".join(self.parts) or "none"
            raise ValueError(f"there is no part {part!r}; parts: {parts}")
        if name in self.deck.instances:
            raise ValueError(f"there is an instance {name!r} already")
        self._begin(card, "ASSEMBLY")
        self.placed.add(part)
        self._level, self._moved = _placed(self.parts[part], card.rows)

    def _end_instance(self, card: Card) -> None:
        begin, level = self.open[-1] if self.open else card, self._level
        self._close(card)
        level.settle()
        name = begin.required("NAME")
        if self._moved and len(level.nodes) > len(self.parts[begin.required("PART")].nodes):
            raise ValueError(
                f"expected nodes in the part, found some in the instance {name!r}, which is moved: "
                "define them in its part (Abaqus/CAE: make the instance dependent)"
            )
        self._place(name, level)

    def _place(self, name: str, level: Level) -> None:
        """Add a part or an instance to the mesh."""
        self._size += len(level.nodes) + len(level.elements)
        self._size += sum(map(len, (*level.node_sets.values(), *level.element_sets.values())))
        if self._size > MOST_PLACED:
            raise ValueError(f"instances of {self._size} members are larger than any mesh")
        self.deck.add(name, level)
        first = self.deck.first(name)
        self._elements[name] = [number + first for number in level.elements]
        for each in (*level.node_sets, *level.element_sets, *level.surfaces, *level.broken):
            self._own.setdefault(each, set()).add(name)
        self._level = self.deck

    def _begin_material(self, card: Card) -> None:
        name = card.required("NAME")
        if name in self.deck.materials:
            raise ValueError(f"there is a material {name!r} already")
        self._material = self.deck.materials[name] = Material()


def _placed(part: Level, rows: list[list[str]]) -> tuple[Level, bool]:
    """A part moved and then turned about an axis, and whether it was, by the rows of *INSTANCE."""
    points = np.array(list(part.nodes.values())).reshape(-1, 3)
    values = [[real(value) for value in row if value] for row in rows]
    if len(values) > 2 or [len(row) for row in values][1:] not in ([], [7]):
        raise ValueError(
            "expected a translation and a row with two points of an axis and an angle, found "
            f"{len(values)} rows of {', '.join(str(len(row)) for row in values)} numbers"
        )
    if values and len(values[0]) > 3:
        raise ValueError(f"expected a translation of 3 numbers, found {len(values[0])}")
    shift = [real(value) if value else 0.0 for value in rows[0]] if rows else []
    moved = any(shift)
    if moved:
        points = points + (shift + [0.0] * 3)[:3]
    if len(values) == 2 and values[1][6]:
        points, moved = _turned(points, np.array(values[1])), True
    nodes = dict(zip(part.nodes, map(tuple, points.tolist()), strict=True)) if moved else part.nodes
    return Level(
        {**nodes}, {**part.elements},
        {name: [*members] for name, members in part.node_sets.items()},
        {name: [*members] for name, members in part.element_sets.items()},
        {name: [*entries] for name, entries in part.surfaces.items()},
        [*part.sections], {*part.thicknesses}, {**part.broken},
    ), moved  # fmt: skip


def _turned(points: Array, row: Array) -> Array:
    """Points (n, 3) turned about the axis from a to b by an angle (Rodrigues); exact quarters.

    Args:
        points: (n, 3).
        row: (7,) a, b, and the angle in degrees.
    """
    origin, axis = row[:3], row[3:6] - row[:3]
    length = float(np.linalg.norm(axis))
    if not 0.0 < length < math.inf:
        raise ValueError("expected two different points on the axis of the rotation")
    axis, angle = axis / length, float(row[6]) % 360.0
    quarters = {90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
    turn = math.radians(angle)
    cosine, sine = quarters.get(angle, (math.cos(turn), math.sin(turn)))
    arms = points - origin
    along = np.outer(arms @ axis, axis)
    return origin + along + cosine * (arms - along) + sine * np.cross(axis, arms)


def _nodes(level: Level, card: Card) -> None:
    card.refuse("INPUT")
    system = card.choice("SYSTEM", "RECTANGULAR", "CYLINDRICAL", "SPHERICAL")
    if system != "RECTANGULAR":
        raise ValueError(f"expected x, y and z, found SYSTEM={system}: {REFUSED['SYSTEM']}")
    numbers: list[int] = []
    lifted: set[bool | None] = set()  # of solids z in some rows alone is a mistake
    with card.each_row() as rows:
        for row in rows:
            number, cells = level.number(row[0]), row[1:4]
            if cells[-1:] == [""]:
                cells = cells[:-1]
            values = [real(cell) for cell in cells]
            lifted.add(values[2] != 0 if len(values) > 2 else None)
            if len(values) < 2 or lifted >= {True, None}:
                raise ValueError(
                    f"expected x, y and (in all rows or none) z, found {', '.join(cells)}"
                )
            x, y, z = (*values, 0.0)[:3]
            if level.nodes.setdefault(number, (x, y, z)) != (x, y, z):
                raise ValueError(f"node {number} is defined twice, at different places")
            numbers.append(number)
    if name := card.name("NSET"):
        level.node_sets.setdefault(name, []).extend(numbers)


def _elements(level: Level, card: Card) -> None:
    card.refuse("INPUT", "FILE", "OFFSET")
    kind = card.required("TYPE")
    numbers: list[int] = []
    with card.each_row() as rows:
        for number, *nodes in _records(rows, level.number, node_count(kind)):
            if number in level.elements:
                raise ValueError(f"element {number} is defined twice")
            level.elements[number] = (kind, tuple(nodes))
            numbers.append(number)
    if name := card.name("ELSET"):
        level.element_sets.setdefault(name, []).extend(numbers)


def node_count(kind: str) -> int | None:
    """Number of nodes of a type of element, by its name in capitals; None for one without it."""
    if ONE_NODE.match(kind):
        return 1
    if order := OF_ORDER.match(kind):
        return 3 if order[1] == "2" else 2
    found = TRIANGULAR_SHELL.match(kind) or NUMBERED.match(kind)
    return int(found[1]) if found else None


def _records(
    rows: Iterable[list[str]], number: Callable[[str], int], count: int | None
) -> Iterator[list[int]]:
    """Number and nodes of each element, which may go on in the next row.

    It does so while its type has as many nodes more: some programs end each row with a comma,
    others none that goes on. Of a type whose nodes are not known a comma at the end goes on.
    """
    found: list[int] = []
    for row in rows:
        values = [number(value) for value in row if value]
        if found and count is not None and len(found) + len(values) > count + 1:
            yield found
            found = []
        found += values
        if row[-1] if count is None else len(found) > count:
            yield found
            found = []
    if found:
        yield found


def _members(level: Level, card: Card, word: str) -> list[int]:
    """The numbers in a set: listed, from other sets, or first, last and step."""
    instance = card.name("INSTANCE")
    if "GENERATE" in card.parameters:
        return _generated(level, card, instance)
    sets = level.node_sets if word == "NSET" else level.element_sets
    numbers: list[int] = []
    for value in (value for row in card.rows for value in row if value):
        name = value.strip('"').upper()
        name = name if instance is None else f"{instance}.{name}"
        if value.lstrip("+-").isdigit():
            numbers.append(level.number(value, instance))
        elif name not in sets and value.rpartition(".")[2].isdigit():
            numbers.append(level.number(value))
        else:
            numbers += level.members(word, name)
    return numbers


def _generated(level: Level, card: Card, instance: str | None) -> list[int]:
    """Numbers from the first to the last ones in each row."""
    found: list[int] = []
    for row in card.rows:
        values = [value for value in row if value]
        if len(values) not in (2, 3):
            raise ValueError(f"expected first, last and perhaps step, found {', '.join(row)}")
        first, last, step = (*values, "1")[:3]
        if not step.isdecimal() or not int(step):
            raise ValueError(f"expected a step of 1 or more, found {step}")
        members = range(level.number(first, instance), level.number(last, instance) + 1, int(step))
        if len(members) > MOST_MEMBERS:
            raise ValueError(f"a set of {len(members)} is larger than any mesh")
        found += members
    return found


def _node_set(level: Level, card: Card) -> None:
    name = card.required("NSET")
    if source := card.name("ELSET"):
        instance = card.name("INSTANCE")
        of_elements = level.members("ELSET", source if instance is None else f"{instance}.{source}")
        if missing := [each for each in of_elements if each not in level.elements]:
            raise _UnknownError(f"there is no element {missing[0]}, which is in {source}")
        members = [node for each in of_elements for node in level.elements[each][1]]
    else:
        members = _members(level, card, "NSET")
    level.node_sets.setdefault(name, []).extend(dict.fromkeys(members))


def _element_set(level: Level, card: Card) -> None:
    name = card.required("ELSET")
    level.element_sets.setdefault(name, []).extend(_members(level, card, "ELSET"))


def _surface(level: Level, card: Card) -> None:
    """A surface of nodes is a node set; one of elements is a list of their sides."""
    card.refuse("CROP")
    name = card.required("NAME")
    kind = card.choice("TYPE", "ELEMENT", "NODE", "SEGMENTS", "CYLINDER", "REVOLUTION", "USER")
    if kind not in ("ELEMENT", "NODE"):
        raise ValueError(f"surfaces of type {kind} are not supported; use NODE or ELEMENT")
    if "COMBINE" in card.parameters:
        level.surfaces[name] = _combined(level, card)
        return
    sides: list[tuple[int, int]] = []
    for row in card.rows:
        plain = Card(card.keyword, card.word, {}, [[row[0]]], card.place)
        if kind == "NODE":
            level.node_sets.setdefault(name, []).extend(_members(level, plain, "NSET"))
            continue
        side = row[1] if len(row) > 1 else ""
        for element in _members(level, plain, "ELSET"):
            if element not in level.elements:
                raise ValueError(f"there is no element {element}")
            sides.append((element, _side(level.elements[element][0], side)))
    if kind == "ELEMENT":
        level.surfaces.setdefault(name, []).extend(sides)


def _combined(level: Level, card: Card) -> list[tuple[int, int]]:
    """Sides in any of some surfaces, in both of two, or in the first of two only."""
    how = card.choice("COMBINE", "UNION", "INTERSECTION", "DIFFERENCE")
    names = [value.strip('"').upper() for row in card.rows for value in row if value]
    if missing := [name for name in names if name not in level.surfaces]:
        raise ValueError(f"there is no surface {missing[0]!r} of elements")
    found = [dict.fromkeys(level.surfaces[name]) for name in names]
    if how == "UNION":
        return [*dict.fromkeys(side for sides in found for side in sides)]
    if how not in ("INTERSECTION", "DIFFERENCE") or len(found) != 2:
        raise ValueError(
            "expected UNION of surfaces, or INTERSECTION or DIFFERENCE of two, found "
            f"{how} of {len(found)}"
        )
    if any(side == Side.FREE for sides in found for _, side in sides):
        raise ValueError(f"expected surfaces with sides (S1, ...) for {how}, found one without")
    one, other = found
    return [side for side in one if (side in other) == (how == "INTERSECTION")]


def _side(kind: str, text: str) -> int:
    """The number of a side of an element.

    Plane elements have sides S1 to S4. Edges of shells are E1 to E4 in Abaqus; in CalculiX S1 and
    S2 of a shell are its two faces and S3 to S6 its edges.
    """
    if not text:
        return Side.FREE
    found = SIDE.match(text.upper())
    letter, number = (found[1], int(found[2])) if found else ("", 0)
    if SHELL.match(kind):
        if text.upper() in FACES:
            return Side.FACE
        number -= 2 if letter == "S" else 0
        if not 0 < number < 5:
            raise ValueError(
                f"expected an edge of a shell ({kind}), E1 to E4 (Abaqus) or S3 to S6 (CalculiX), "
                f"or a face, {', '.join(FACES)}, found {text!r}"
            )
    elif not number:
        raise ValueError(f"expected a side S1, S2, ... or S6, found {text!r}")
    return number


def _section(level: Level, card: Card) -> None:
    if material := card.name("MATERIAL"):
        level.sections.append((card.required("ELSET"), material))
        level.thicknesses |= {real(value) for row in card.rows[:1] for value in row[:1] if value}


def _constants(card: Card, keys: tuple[str, ...]) -> dict[str, Constant]:
    """Numbers of the rows by their keys; none where they are not those of an isotropic material.

    Several rows are over temperature, which follows the numbers of each row.
    """
    values = [[real(value) for value in row if value] for row in card.rows]
    isotropic = card.choice("TYPE", "ISOTROPIC", "ORTHOTROPIC") == "ISOTROPIC"
    count = len(keys)
    if not isotropic or not values or len(values[0]) < count or "DEPENDENCIES" in card.parameters:
        return {}
    if len(values) == 1:
        return dict(zip(keys, values[0], strict=False))
    if any(len(row) < count for row in values):
        return {}
    # CalculiX and Abaqus take a temperature that is left out for 0
    places = [row[count] if len(row) > count else 0.0 for row in values]
    if any(after <= before for before, after in pairwise(places)):
        raise ValueError(f"expected increasing temperatures, found {places}")
    return {
        key: {"temperatures": places, "values": [row[number] for row in values]}
        for number, key in enumerate(keys)
    }


def _elastic(material: Material, card: Card) -> None:
    _take(material, card, _constants(card, ("young", "poisson")))


def _density(material: Material, card: Card) -> None:
    _take(material, card, _constants(card, ("density",)))


def _expansion(material: Material, card: Card) -> None:
    found = _constants(card, ("expansion",))
    if found and (zero := card.name("ZERO")):
        found["reference_temperature"] = real(zero)
    _take(material, card, found)


def _take(material: Material, card: Card, found: Mapping[str, Constant]) -> None:
    material.numbers |= found
    if not found:
        material.left_out.append(
            f"*{card.keyword} that is not isotropic or depends on more than temperature"
        )


_READERS: dict[str, Callable[[Level, Card], None]] = {
    "NODE": _nodes,
    "ELEMENT": _elements,
    "NSET": _node_set,
    "ELSET": _element_set,
    **dict.fromkeys(("SOLIDSECTION", "SHELLSECTION", "MEMBRANESECTION"), _section),
}
_OF_MATERIALS: dict[str, Callable[[Material, Card], None]] = {
    "ELASTIC": _elastic,
    "DENSITY": _density,
    "EXPANSION": _expansion,
}
