# SPDX-License-Identifier: LGPL-3.0-or-later
"""A case file from an Abaqus or CalculiX input file."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.mesh.inp import Deck, Material, read_deck
from fretfe.mesh.inp_groups import (
    FACET_ELEMENTS,
    SOLID,
    Groups,
    listed,
    supported_cells,
    unused,
)
from fretfe.mesh.inp_sectors import sectors
from fretfe.mesh.inp_steps import Proposal, propose
from fretfe.mesh.planes import PLANE_TOLERANCE

# Names that a case may have.
NAME = re.compile(r"[A-Za-z0-9_-]{1,100}\Z")
NEEDED = ("young", "poisson")
NUMBERS = (*NEEDED, "density", "expansion", "reference_temperature")


@dataclass(frozen=True)
class Outline:
    """A case that a deck amounts to.

    Attributes:
        lines: of the case file.
        lacks: how many things of the deck it has not, each a line among them.
    """

    lines: list[str]
    lacks: int


def outline(path: Path) -> Outline:
    """A case file with the bodies of a deck and their materials, contacts, supports and loads.

    The bodies are the instances of the file, or, where it has none, the element sets to which its
    sections give materials, or all element sets with elements of bodies; or the pieces with the
    surfaces of its contacts, where one of these has both surfaces of a contact, or a tie joins two.

    Args:
        path: input file.

    Raises:
        MeshError: as `read_deck`, or for elements that are not supported.
    """
    deck = read_deck(path)
    dimension = 3 if any(SOLID.match(kind) for kind, _ in deck.elements.values()) else 2
    cells = supported_cells(path, deck, dimension)
    labels = _bodies(deck, cells.keys())
    found = _proposal(path, deck, cells, dimension)
    labels = _in_pieces(deck, cells.keys(), labels, found.contacts.values())
    lines = _lines(path, deck, dimension, cells, labels, found)
    return Outline([*lines], len(found.lacks))


def _lines(
    path: Path,
    deck: Deck,
    dimension: int,
    cells: Mapping[int, object],
    labels: list[str],
    found: Proposal,
) -> Iterator[str]:
    """The case file."""
    of_facets = FACET_ELEMENTS[dimension].match
    facets = {number for number, (kind, _) in deck.elements.items() if of_facets(kind)}
    # those of the file in small letters, if a case may have them
    names = {label: label.lower() if NAME.match(label) else f"body{number}"
             for number, label in enumerate(labels, start=1)}  # fmt: skip
    if deck.title:
        yield from (f"title = {_quoted(deck.title)}", "")
    if dimension == 2:
        yield from _model(deck, cells.keys())
    yield "[geometry]"
    yield f"file = {_quoted(path.name)}"
    if other := {name: label for label, name in names.items() if name.upper() != label}:
        yield ""
        yield "[geometry.bodies]"
        for name, label in other.items():
            yield f"{name} = {{ label = {_quoted(label)} }}"
    yield ""
    yield "[bodies]"
    for label, name in names.items():
        yield from _body(deck, name, [each for each in deck.elements_of(label) if each in cells])
    ties = {f"tie{n}": {"boundary1": one, "boundary2": other}
            for n, (_, one, other) in enumerate(deck.ties, start=1)}  # fmt: skip
    yield from _tables({"ties": ties, "contacts": found.contacts,
                        "symmetry": _symmetry(deck, dimension), "supports": found.supports,
                        "loads": found.loads})  # fmt: skip
    if found.loads:
        yield from ("", "# to be added if the loads repeat: [cycle] with start and end")
    if found.lacks:
        yield ""
        yield "# not taken over:"
        for lack in found.lacks:
            yield f"# {lack.replace(f'{path}: ', '').removeprefix(f'{path.parent}/')}"
    yield ""
    yield "# names that a boundary may have, as such or as a label in [geometry.boundaries]"
    yield f"# surfaces: {listed(deck.surfaces)}"
    yield f"# node sets: {listed(deck.node_sets)}"
    sets = (name for name, members in deck.element_sets.items() if facets.issuperset(members))
    yield f"# element sets: {listed(sets)}"
    yield from (f"# {note}" for note in unused(path, deck, cells.keys() | facets, found.read))


def _proposal(
    path: Path, deck: Deck, cells: Mapping[int, tuple[int, ...]], dimension: int
) -> Proposal:
    """Contacts, supports and loads of a file."""
    if dimension == 2 and not _upright(deck, cells.values()):
        turned = "the bodies are not in a plane of constant z: their coordinates have other names"
        return Proposal(lacks=[f"{path.name}: contacts, supports and loads: {turned}"])
    groups = Groups(path, deck, dimension, [list(cells.items())])
    return propose(deck, dimension, lambda label: groups.boundary(label, label))


def _symmetry(deck: Deck, dimension: int) -> dict[str, dict[str, Any]]:
    """Tables of sectors."""
    return {
        f"sector{number}": {
            "type": "cyclic", "boundary1": each.sides[0], "boundary2": each.sides[1],
            "sectors": each.count, "centre": each.centre[:dimension].tolist(),
            **({"axis": each.axis.tolist()} if dimension == 3 else {}),
        }
        for number, each in enumerate(sectors(deck, dimension), start=1)
    }  # fmt: skip


def _in_pieces(
    deck: Deck, cells: Set[int], labels: list[str], contacts: Iterable[Mapping[str, Any]]
) -> list[str]:
    """Labels of the bodies; surfaces of contacts where a contact is within one of these."""
    surfaces = dict.fromkeys(
        contact[key] for contact in contacts for key in ("surface1", "surface2")
    )
    pieces: dict[str, set[int]] = {}
    for surface in surfaces:
        own = set(deck.elements_of(surface)) & cells
        if own and all(own.isdisjoint(other) for other in pieces.values()):
            pieces[surface] = own
    sets = [set(deck.element_sets[label]) for label in labels]
    within = any(len([own for own in pieces.values() if own <= each]) > 1 for each in sets)
    tied = [set(deck.elements_of(one)) & cells for _, one, _ in deck.ties]
    across = not all(own <= each for own in tied for each in sets if not own.isdisjoint(each))
    found = (within or across) and set().union(*pieces.values()) == cells
    return list(pieces) if found else labels


def _model(deck: Deck, cells: Set[int]) -> Iterator[str]:
    """The table of the plane state, where it is not what a case has without it."""
    stress = {deck.elements[number][0].startswith("CPS") for number in cells}
    lines = ['plane = "stress"'] if stress == {True} else []
    if len(stress) > 1:
        yield "# elements of plane stress and of plane strain: plane strain is taken for all"
    if len(deck.thicknesses) == 1 and deck.thicknesses != {1.0}:
        lines += [f"thickness = {thickness!r}" for thickness in deck.thicknesses]
    elif len(deck.thicknesses) > 1:
        yield f"# sections of different thickness, {deck.thicknesses}: 1 is taken for all"
    if lines:
        yield from ("[model]", *lines, "")


def _upright(deck: Deck, cells: Iterable[tuple[int, ...]]) -> bool:
    """True if x and y of the file are those of a plane case."""
    points = [deck.nodes[node] for nodes in cells for node in nodes]
    extent = np.ptp(points, axis=0) if points else np.zeros(3)
    return bool(extent[2] <= PLANE_TOLERANCE * extent.max())


def _tables(tables: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> Iterator[str]:
    """Tables of a case."""
    for kind, named in tables.items():
        for name, table in named.items():
            yield ""
            yield f"[{kind}.{name}]"
            yield from (f"{key} = {_toml(value)}" for key, value in table.items())


def _bodies(deck: Deck, cells: Set[int]) -> list[str]:
    """Labels of the sets that are probably the bodies, in the order of the file."""
    for labels in (deck.instances, dict(deck.sections), deck.element_sets):
        found = [
            label for label in labels if not cells.isdisjoint(deck.element_sets.get(label, ()))
        ]
        if found:
            return found
    return []


def _quoted(text: str) -> str:
    """A string of TOML, which are those of JSON."""
    return json.dumps(text, ensure_ascii=False)


def _body(deck: Deck, name: str, members: list[int]) -> Iterator[str]:
    kinds = Counter(deck.elements[number][0] for number in members)
    found = deck.materials_of(members)
    text = ", ".join(f"{count} {kind}" for kind, count in kinds.items())
    material = deck.materials.get(found[0], Material()) if len(found) == 1 else Material()
    yield f"# {text}; material: {', '.join(found) or 'none'}"
    yield from (f"# not taken over: {what}" for what in material.left_out)
    if missing := [key for key in NEEDED if key not in material.numbers]:
        yield f"# to be added: {', '.join(missing)}"
    given = {key: material.numbers[key] for key in NUMBERS if key in material.numbers}
    numbers = ", ".join(f"{key} = {_toml(value)}" for key, value in given.items())
    if tables := [key for key, value in given.items() if isinstance(value, dict)]:
        yield f"# to be added: temperature, at which {' and '.join(tables)} are taken"
    yield f"{name} = {{ {numbers} }}" if numbers else f"{name} = {{}}"


def _toml(value: Any) -> str:
    """A value as a case file has it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(rows)}" for key, rows in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return _quoted(value) if isinstance(value, str) else repr(value).lower()
