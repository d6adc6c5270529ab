# SPDX-License-Identifier: LGPL-3.0-or-later
"""Abaqus and CalculiX input files: nodes, elements, sets and surfaces as they are written.

Own reading rather than meshio's, which (5.3.5) knows half of the plane elements, keeps only the
last of several *NODE blocks, and passes over node sets made of sets, surfaces and parts in silence.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from fretfe.errors import MeshError
from fretfe.files import require_file

# Keywords, without blanks, that change nodes, elements or what numbers mean, or that join parts:
# without them the model would be another one. And what to do instead.
_WITHOUT_PARTS = (
    "write the file without parts (Abaqus/CAE: model attribute 'Do not use parts and assemblies in "
    "input files')"
)
_WRITTEN_OUT = "write out all nodes and elements"
_JOINED = (
    "it joins nodes or parts, which would come apart here: mesh them as one part with common "
    "nodes, or make them bodies of their own in contact"
)
REFUSED = {
    **dict.fromkeys(("PART", "INSTANCE", "ASSEMBLY"), _WITHOUT_PARTS),
    **dict.fromkeys(
        (
            *("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "IMPERFECTION"),
            *("SYMMETRICMODELGENERATION", "IMPORT", "MAP", "PARAMETER", "MODELCHANGE"),
        ),
        _WRITTEN_OUT,
    ),
    **dict.fromkeys(
        (
            *("TIE", "MPC", "EQUATION", "NETWORKMPC", "EMBEDDEDELEMENT", "RIGIDBODY", "COUPLING"),
            *("KINEMATIC", "DISTRIBUTING", "KINEMATICCOUPLING", "DISTRIBUTINGCOUPLING"),
            *("SHELLTOSOLIDCOUPLING", "CYCLICSYMMETRYMODEL", "FASTENER", "PRE-TENSIONSECTION"),
            *("SUBSTRUCTUREGENERATE", "SUBSTRUCTUREPROPERTY", "MATRIXASSEMBLE", "USERELEMENT"),
            *("BONDEDREGION", "COHESIVEBEHAVIOR", "RELEASE", "JOINT", "CONNECTORSECTION"),
            *("RIGIDSURFACE", "IMPLICITRIGIDBODY", "SPRING", "DASHPOT", "DISPLAYBODY"),
        ),
        _JOINED,
    ),
}
# Say nothing of the model.
TITLES = ("HEADING", "INCLUDE")
# Parameters, or their values, that make a keyword join parts.
JOINING = {
    "CONTACTPAIR": ("TIED",),
    "SURFACEBEHAVIOR": ("TIED",),
    "CONTACTINITIALIZATIONDATA": ("TIED",),
}
DEEPEST = 10
# Stands for bytes that are not UTF-8; in comments they do not matter.
UNKNOWN = "\N{REPLACEMENT CHARACTER}"
MOST_MEMBERS = 100_000_000


@dataclass(frozen=True)
class Card:
    """A keyword with its parameters (names in capitals) and its rows of data."""

    keyword: str
    parameters: dict[str, str]
    rows: list[list[str]]
    place: str


@dataclass
class Deck:
    """The mesh in an input file; names are in capitals, as case does not count.

    Attributes:
        nodes: coordinates by number.
        elements: type and nodes by number.
        node_sets: numbers of nodes, in order.
        element_sets: numbers of elements.
        surfaces: element numbers and sides (S1 is 1; 0 is whatever side is free).
        unused: how often there was each keyword that was not used.
    """

    nodes: dict[int, tuple[float, float, float]] = field(default_factory=dict)
    elements: dict[int, tuple[str, tuple[int, ...]]] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)
    surfaces: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    unused: Counter[str] = field(default_factory=Counter)


def read_deck(path: Path) -> Deck:
    """Read an input file and the files that it includes.

    Raises:
        MeshError: a file cannot be read, or says something that is not understood.
    """
    deck = Deck()
    readers = {
        "NODE": _nodes,
        "ELEMENT": _elements,
        "NSET": _node_set,
        "ELSET": _element_set,
        "SURFACE": _surface,
    }
    for card in _cards(path, DEEPEST):
        _refuse_keyword(card)
        # blanks in keywords do not count
        read = readers.get(card.keyword.replace(" ", ""))
        if read is None:
            deck.unused.update([card.keyword] if card.keyword not in TITLES else ())
            continue
        try:
            _require_text(card)
            read(deck, card)
        except (ValueError, IndexError, KeyError, OverflowError) as error:
            raise MeshError(f"{card.place}: cannot read *{card.keyword}: {error}") from error
    if not deck.nodes or not deck.elements:
        raise MeshError(
            f"{path}: expected an Abaqus or CalculiX input file with nodes and elements, found "
            f"{len(deck.nodes)} nodes and {len(deck.elements)} elements"
        )
    return deck


def _refuse_keyword(card: Card) -> None:
    """Raise for a keyword without which the model would be another one."""
    keyword = card.keyword.replace(" ", "")
    words = {*card.parameters, *(value.upper() for value in card.parameters.values())}
    joining = sorted(words.intersection(JOINING.get(keyword, ())))
    if keyword in REFUSED or joining:
        with_word = f" with {joining[0]}" if joining else ""
        raise MeshError(
            f"{card.place}: *{card.keyword}{with_word} is not supported; "
            f"{REFUSED.get(keyword, _JOINED)}"
        )


def _require_text(card: Card) -> None:
    """Bytes that are not UTF-8 would make different names the same one."""
    texts = [*card.parameters.values(), *(value for row in card.rows for value in row)]
    if any(UNKNOWN in text for text in texts):
        raise ValueError("expected UTF-8 text, found other bytes in a name or a number")


def _cards(path: Path, depth: int) -> Iterator[Card]:
    """The keywords of a file in their order, those of included files in place of *INCLUDE."""
    card: Card | None = None
    for number, line in _lines(path):
        if line.startswith("*"):
            if card is not None:
                yield from _included(path, card, depth)
            keyword, *parameters = (part.strip() for part in line[1:].split(","))
            pairs = (part.partition("=") for part in parameters if part)
            values = {name.strip().upper(): value.strip() for name, _, value in pairs}
            card = Card(" ".join(keyword.upper().split()), values, [], f"{path}, line {number}")
        elif card is not None:
            card.rows.append([part.strip() for part in line.split(",")])
    if card is not None:
        yield from _included(path, card, depth)


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    """Lines with their number; no comments, no empty lines, keywords that go on in one line."""
    require_file(path, "a mesh file", MeshError)
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise MeshError(f"{path}: cannot read the mesh file: {error.strerror}") from error
    keyword = ""
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("**"):
            continue
        line = keyword + line
        keyword = line if line.startswith("*") and line.endswith(",") else ""
        if not keyword:
            yield number, line


def _included(path: Path, card: Card, depth: int) -> Iterator[Card]:
    if card.keyword != "INCLUDE":
        yield card
        return
    if depth == 0:
        raise MeshError(f"{card.place}: files include each other more than {DEEPEST} deep")
    name = card.parameters.get("INPUT", "").strip("\"'")
    yield from _cards(path.parent / name, depth - 1)


def _name(card: Card, parameter: str) -> str | None:
    value = card.parameters.get(parameter)
    return value.strip('"').upper() if value else None


def _refuse_parameters(card: Card, *names: str) -> None:
    for name in names:
        if name in card.parameters:
            raise ValueError(f"the parameter {name} is not supported")


def _nodes(deck: Deck, card: Card) -> None:
    _refuse_parameters(card, "SYSTEM", "INPUT")
    numbers = []
    for row in card.rows:
        number = int(row[0])
        # Fortran writes 1.0D+00; coordinates at the end of a row may be left out
        values = [float(value.upper().replace("D", "E") or 0) for value in row[1:4]]
        x, y, z = values + [0.0] * (3 - len(values))
        if deck.nodes.setdefault(number, (x, y, z)) != (x, y, z):
            raise ValueError(f"node {number} is defined twice, at different places")
        numbers.append(number)
    if name := _name(card, "NSET"):
        deck.node_sets.setdefault(name, []).extend(numbers)


def _elements(deck: Deck, card: Card) -> None:
    _refuse_parameters(card, "INPUT")
    kind = card.parameters["TYPE"].upper()
    numbers: list[int] = []
    unfinished: list[int] = []
    for row in card.rows:
        unfinished += [int(value) for value in row if value]
        # a comma at the end: the nodes go on in the next row
        if row[-1]:
            number, *nodes = unfinished
            if number in deck.elements:
                raise ValueError(f"element {number} is defined twice")
            deck.elements[number] = (kind, tuple(nodes))
            numbers.append(number)
            unfinished = []
    if unfinished:
        raise ValueError(f"the nodes of element {unfinished[0]} are not complete")
    if name := _name(card, "ELSET"):
        deck.element_sets.setdefault(name, []).extend(numbers)


def _members(card: Card, sets: dict[str, list[int]]) -> list[int]:
    """The numbers in a set: listed, from sets known already, or first, last and step."""
    if "GENERATE" in card.parameters:
        found: list[int] = []
        for row in card.rows:
            first, last, *step = (int(value) for value in row if value)
            members = range(first, last + 1, *step)
            if len(members) > MOST_MEMBERS:
                raise ValueError(f"a set of {len(members)} is larger than any mesh")
            found += members
        return found
    numbers: list[int] = []
    for value in (value for row in card.rows for value in row if value):
        if value.lstrip("+-").isdigit():
            numbers.append(int(value))
        else:
            name = value.strip('"').upper()
            if name not in sets:
                raise ValueError(f"there is no set {value!r}")
            numbers += sets[name]
    return numbers


def _node_set(deck: Deck, card: Card) -> None:
    _refuse_parameters(card, "INSTANCE")
    if source := _name(card, "ELSET"):
        members = [n for each in deck.element_sets[source] for n in deck.elements[each][1]]
    else:
        members = _members(card, deck.node_sets)
    deck.node_sets.setdefault(_required_name(card, "NSET"), []).extend(dict.fromkeys(members))


def _element_set(deck: Deck, card: Card) -> None:
    _refuse_parameters(card, "INSTANCE")
    members = _members(card, deck.element_sets)
    deck.element_sets.setdefault(_required_name(card, "ELSET"), []).extend(members)


def _required_name(card: Card, parameter: str) -> str:
    name = _name(card, parameter)
    if name is None:
        raise ValueError(f"the parameter {parameter} is missing")
    return name


def _surface(deck: Deck, card: Card) -> None:
    """A surface of nodes is a node set; one of elements is a list of their sides."""
    _refuse_parameters(card, "INSTANCE", "COMBINE")
    name = _required_name(card, "NAME")
    kind = card.parameters.get("TYPE", "ELEMENT").upper()
    if kind == "NODE":
        rows = [[row[0]] for row in card.rows]
        plain = Card(card.keyword, {}, rows, card.place)
        deck.node_sets.setdefault(name, []).extend(_members(plain, deck.node_sets))
        return
    if kind != "ELEMENT":
        raise ValueError(f"surfaces of type {kind} are not supported; use NODE or ELEMENT")
    sides = deck.surfaces.setdefault(name, [])
    for row in card.rows:
        side = row[1].upper() if len(row) > 1 else ""
        if side not in ("", "S1", "S2", "S3", "S4", "S5", "S6"):
            raise ValueError(f"expected a side S1, S2, ... or S6, found {row[1]!r}")
        plain = Card(card.keyword, {}, [[row[0]]], card.place)
        members = _members(plain, deck.element_sets)
        sides += [(element, int(side[1:] or 0)) for element in members]
