# SPDX-License-Identifier: LGPL-3.0-or-later
"""The beginning of a case file from an Abaqus or CalculiX input file."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Set
from pathlib import Path

from fretfe.mesh.inp import Constant, Deck, Material, read_deck
from fretfe.mesh.inp_groups import (
    FACET_ELEMENTS,
    SOLID,
    listed,
    supported_cells,
    unused,
)

# Names that a case may have.
NAME = re.compile(r"[A-Za-z0-9_-]{1,100}\Z")
NEEDED = ("young", "poisson")
NUMBERS = (*NEEDED, "density", "expansion", "reference_temperature")


def outline(path: Path) -> Iterator[str]:
    """Lines for a case file: bodies with their materials, and what boundaries could be.

    The bodies are the instances of the file, or, where it has none, the element sets to which its
    sections give materials, or all element sets with elements of bodies.

    Args:
        path: input file.

    Raises:
        MeshError: as `read_deck`, or for elements that are not supported.
    """
    deck = read_deck(path)
    dimension = 3 if any(SOLID.match(kind) for kind, _ in deck.elements.values()) else 2
    cells = supported_cells(path, deck, dimension).keys()
    facets = _of_kind(deck, FACET_ELEMENTS[dimension])
    labels = _bodies(deck, cells)
    names = {label: _name(label, number) for number, label in enumerate(labels, start=1)}
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
        members = [number for number in deck.element_sets[label] if number in cells]
        yield from _body(deck, name, members)
    yield ""
    yield "# names that a boundary may have, as such or as a label in [geometry.boundaries]"
    yield f"# surfaces: {listed(deck.surfaces)}"
    yield f"# node sets: {listed(deck.node_sets)}"
    sets = (name for name, members in deck.element_sets.items() if facets.issuperset(members))
    yield f"# element sets: {listed(sets)}"
    yield from (f"# {note}" for note in unused(path, deck, cells | facets))


def _of_kind(deck: Deck, kinds: re.Pattern[str]) -> set[int]:
    """Numbers of the elements of some kinds."""
    return {number for number, (kind, _) in deck.elements.items() if kinds.match(kind)}


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


def _name(label: str, number: int) -> str:
    """A name in a case: that of the file in small letters, if a case may have it."""
    return label.lower() if NAME.match(label) else f"body{number}"


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


def _toml(value: Constant) -> str:
    """A constant as a case file has it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {rows!r}" for key, rows in value.items()) + " }"
    return repr(value)
