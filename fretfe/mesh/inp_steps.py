# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, supports and loads of an Abaqus or CalculiX input file, as a case has them.

Static steps one after the other: a load goes linearly from where it stands to its value at the end
of the step, or as its amplitude says, a jump within the first increment; what a later step does not
name stays (OP=MOD) or goes to zero (OP=NEW). Amplitudes are factors over the time of the step.
(Abaqus Analysis User's Guide, Prescribed conditions; CalculiX has the same rules.)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial

from fretfe.errors import MeshError
from fretfe.mesh.inp import Deck
from fretfe.mesh.inp_cards import Card, real, whole
from fretfe.mesh.inp_channels import Amplitude, Channel, Step, TomlTable, read_amplitude
from fretfe.mesh.inp_groups import listed
from fretfe.mesh.inp_language import ACTING
from fretfe.mesh.inp_references import references
from fretfe.mesh.inp_shapes import Facet
from fretfe.mesh.templates import did_you_mean

AXES = ("x", "y", "z")
# Displacements, 1 to 3, and rotations, 4 to 6.
HELD = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6), "PINNED": (1, 2, 3), "XSYMM": (1, 5, 6), "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5),
}  # fmt: skip
# Load steps for a step of the deck that leaves its increments to the program.
INCREMENTS = 10
# Keywords that begin what a step does, other than statics.
STATICS = ("STATIC", "VISCO")
LOAD_CARDS = ("BOUNDARY", "CLOAD", "DLOAD", "DSLOAD")

# Facets of a boundary; raises MeshError with a reason if it has none.
Find = Callable[[str], list[Facet]]


@dataclass
class Proposal:
    """Tables of a case, by name, and what of the deck is in none of them.

    Attributes:
        contacts: from pairs of surfaces.
        supports: boundaries held from the beginning to the end.
        loads: with their histories.
        lacks: what was not understood, in words.
        read: keywords that were.
    """

    contacts: dict[str, TomlTable] = field(default_factory=dict)
    supports: dict[str, TomlTable] = field(default_factory=dict)
    loads: dict[str, TomlTable] = field(default_factory=dict)
    lacks: list[str] = field(default_factory=list)
    read: set[str] = field(default_factory=set)


def propose(deck: Deck, dimension: int, find: Find) -> Proposal:
    """The contacts, supports and loads of a deck.

    Args:
        deck: as it was read.
        dimension: of its bodies.
        find: looks for a boundary.
    """
    reader = _Steps(deck, dimension, find)
    model: list[Card] = []
    steps: list[list[Card]] = []
    within = False
    for card in deck.analysis:
        if card.word == "STEP":
            within = True
            steps.append([])
        (steps[-1] if within else model).append(card)
        within = within and card.word != "ENDSTEP"
    reader.model(model)
    for cards in steps:
        reader.step(cards)
    return reader.finish()


class _Steps:
    def __init__(self, deck: Deck, dimension: int, find: Find) -> None:
        self._deck, self._find, self._axes = deck, find, AXES[:dimension]
        self._found = Proposal()
        self._friction: dict[str, float | None] = {}
        self._amplitudes: dict[str, Amplitude] = {}
        self._channels: dict[tuple[str, ...], Channel] = {}
        self._end, self._count = 0.0, 0
        self._led = {node: each for each in references(deck) for node in (each.node, each.turning)}
        for card in deck.analysis:
            if card.word == "AMPLITUDE":
                self._try(card, lambda each: self._amplitudes.update(read_amplitude(each)))
            elif card.word in ACTING:
                self._found.read.add(card.keyword)
                self._lack(card, "not supported: without it the model is another one")

    def model(self, cards: Sequence[Card]) -> None:
        """Read what stands outside the steps."""
        interaction = ""
        for card in cards:
            if card.word == "SURFACEINTERACTION":
                interaction = card.name("NAME") or ""
                self._friction[interaction] = 0.0
                self._found.read.add(card.keyword)
            elif card.word == "FRICTION":
                self._friction[interaction] = None
                self._try(card, partial(self._coefficient, interaction))
            elif card.word in LOAD_CARDS:
                self._try(card, partial(self._load, Step(0, 0.0, 0.0, 1.0, jumps=False)))
        for card in cards:
            if card.word == "CONTACTPAIR":
                self._try(card, self._contact)

    def step(self, cards: Sequence[Card]) -> None:
        """Read a step."""
        self._count += 1
        first = cards[0]
        static = next((card for card in cards if card.word in STATICS), None)
        if static is None or "PERTURBATION" in first.parameters:
            self._lack(first, f"step {self._count} is not static: its loads are not taken over")
            return
        if "NLGEOM" in first.parameters and first.choice("NLGEOM", "YES", "NO") == "YES":
            self._lack(first, "NLGEOM: displacements and turns are small here")
        try:
            row = [real(value) if value else 0.0 for value in (static.rows or [[""]])[0][:2]]
        except ValueError as error:
            self._lack(static, str(error))
            return
        increment, period = ((value or 1.0) for value in (*row, 0.0, 0.0)[:2])
        if "DIRECT" not in static.parameters:
            increment = max(increment, period / INCREMENTS)
        jumps = first.choice("AMPLITUDE", "RAMP", "STEP") == "STEP"
        step = Step(self._count, self._end, self._end + period, increment, jumps)
        self._end = step.end
        self._found.read |= {first.keyword, static.keyword, cards[-1].keyword}
        before = set(self._channels)
        named: set[tuple[str, ...]] = set()
        renewed: set[str] = set()
        for card in cards:
            if card.word in LOAD_CARDS:
                if card.choice("OP", "MOD", "NEW") == "NEW":
                    renewed.add(card.word)
                self._try(card, lambda each: named.update(self._load(step, each)))
        for key in sorted(before - named):
            channel = self._channels[key]
            if channel.word in renewed and channel.word == "BOUNDARY":
                self._lack(first, f"step {self._count} frees {' '.join(key[1:])} (OP=NEW)")
            elif channel.word in renewed:
                channel.go(step, 0.0, None)

    def finish(self) -> Proposal:
        """Make the tables."""
        found = self._found
        for channel in self._channels.values():
            table, still = channel.table, not any(value for _, value, _ in channel.points)
            if channel.word == "BOUNDARY" and channel.since > 0.0:
                found.lacks.append(
                    f"{channel.place}: {table['boundary']} is held or moved along "
                    f"{table['direction']} from t = {channel.since:g} on only"
                )
            elif channel.word == "BOUNDARY" and still:
                self._hold(table["boundary"], table["direction"])
            elif not still:
                self._add(table, channel.history())
        return found

    def _hold(self, boundary: str, axis: str) -> None:
        support = self._found.supports.setdefault(
            _name(boundary), {"boundary": boundary, "fix": []}
        )
        support["fix"].append(axis)

    def _add(self, table: TomlTable, history: list[TomlTable]) -> None:
        """Take over a load."""
        name = _name(str(table.get("boundary", table["type"])))
        along = table.get("direction")
        name = f"{name}_{along}" if isinstance(along, str) else name
        while name in self._found.loads:
            name += "_"
        self._found.loads[name] = {**table, "history": history}

    def _try(self, card: Card, read: Callable[[Card], object]) -> None:
        """Read a card, or say why it is not understood."""
        try:
            card.require_text()
            read(card)
            self._found.read.add(card.keyword)
        except (ValueError, IndexError, MeshError) as error:
            self._lack(card, str(error))

    def _lack(self, card: Card, reason: str) -> None:
        self._found.lacks.append(f"{card.place}: *{card.keyword}: {reason}")

    def _coefficient(self, interaction: str, card: Card) -> None:
        if "ROUGH" in card.parameters or len(card.rows) != 1:
            raise ValueError("expected one coefficient of friction")
        self._friction[interaction] = real(card.rows[0][0])

    def _contact(self, card: Card) -> None:
        interaction = card.name("INTERACTION") or ""
        friction = self._friction.get(interaction)
        for one, other in card.pairs():
            for surface in (one, other):
                self._find(surface)
            table: TomlTable = {"surface1": one, "surface2": other}
            if friction is None:
                near = did_you_mean(interaction, self._friction)
                self._lack(
                    card, f"no friction is known of the interaction {interaction or '-'}{near}"
                )
            else:
                table["friction"] = friction
            name = _name(one)
            while name in self._found.contacts:
                name += "_"
            self._found.contacts[name] = table

    def _load(self, step: Step, card: Card) -> list[tuple[str, ...]]:
        """Take the values of a card for a step; keys of their channels."""
        amplitude = None
        if name := card.name("AMPLITUDE"):
            if name not in self._amplitudes:
                near = did_you_mean(name, self._amplitudes)
                raise ValueError(f"the amplitude {name} is not known{near}")
            amplitude = self._amplitudes[name]
        read = {"BOUNDARY": self._held, "CLOAD": self._force, "DLOAD": self._distributed,
                "DSLOAD": self._pressure}[card.word]  # fmt: skip
        keys = []
        refused: dict[str, list[str]] = {}
        for row in card.rows:
            try:
                for table, value in read(card, row):
                    key = (card.word, *(str(table[k]) for k in table if k != "type"))
                    new = Channel(card.word, card.place, table, step.begin)
                    channel = self._channels.setdefault(key, new)
                    if step.number or value:
                        channel.go(step, value, amplitude)
                    keys.append(key)
            except (ValueError, IndexError, MeshError) as error:
                refused.setdefault(str(error), []).append(", ".join(row))
        for reason, (first, *others) in refused.items():
            self._lack(card, f"{first}{f' and {len(others)} more' if others else ''}: {reason}")
        return keys

    def _held(self, card: Card, row: list[str]) -> Iterator[tuple[TomlTable, float]]:
        """Held and prescribed displacements; those that no body has are left out."""
        if "FIXED" in card.parameters or card.choice("TYPE", "DISPLACEMENT") != "DISPLACEMENT":
            raise ValueError("expected displacements")
        word = row[1].upper()
        if word in HELD:
            places: Sequence[int] = HELD[word]
        else:
            first = whole(word)
            places = range(first, (whole(row[2]) if len(row) > 2 and row[2] else first) + 1)
        value = real(row[3]) if len(row) > 3 and row[3] else 0.0
        boundary = self._nodes(row[0])
        for axis in (AXES[place - 1] for place in places if place <= len(self._axes)):
            yield {"type": "displacement", "boundary": boundary, "direction": axis}, value

    def _force(self, card: Card, row: list[str]) -> Iterator[tuple[TomlTable, float]]:
        """Equal forces on the nodes of a boundary, as one force that is spread over it."""
        if "FOLLOWER" in card.parameters:
            raise ValueError("expected forces that keep their direction")
        boundary = self._nodes(row[0])
        unnamed = self._deck.unnamed
        count = unnamed.get(boundary) or len(set(self._deck.node_sets[boundary]))
        table = {"type": "force", "boundary": boundary, "direction": self._axes[whole(row[1]) - 1]}
        yield table, count * real(row[2])

    def _pressure(self, card: Card, row: list[str]) -> Iterator[tuple[TomlTable, float]]:
        """A pressure on a surface, or a traction along a vector."""
        label = row[0].strip('"').upper()
        self._find(label)
        kind = row[1].upper()
        if kind == "P":
            yield self._traction(label, "normal"), -real(row[2])
        elif kind == "TRVEC":
            along = [real(value) for value in row[3 : 3 + len(self._axes)]]
            yield self._traction(label, along), real(row[2])
        else:
            raise ValueError(f"expected P or TRVEC, found {kind}")

    def _distributed(self, card: Card, row: list[str]) -> Iterator[tuple[TomlTable, float]]:
        """Pressure on a surface of sides of elements, gravity, rotation."""
        label, kind = row[0].strip('"').upper(), row[1].upper()
        if kind in ("GRAV", "CENTRIF"):
            yield self._body_force(label, kind, [real(value) for value in row[2:] if value])
            return
        if kind != "P":
            raise ValueError(
                "expected sides on the outside of a body (P1, P2, ...), GRAV or CENTRIF, found "
                f"{kind}"
            )
        self._find(label)
        yield self._traction(label, "normal"), -real(row[2])

    def _body_force(self, label: str, kind: str, numbers: list[float]) -> tuple[TomlTable, float]:
        members = set(self._deck.element_sets.get(label, ()))
        if others := self._deck.elements.keys() - members:
            raise ValueError(f"expected all elements, found {len(others)} that are not in {label}")
        size = len(self._axes)
        if kind == "GRAV":
            return {"type": "acceleration", "direction": numbers[1 : 1 + size]}, numbers[0]
        if size == 2 and numbers[4:6] != [0.0, 0.0]:
            raise ValueError(f"expected a rotation about z, found the axis {numbers[4:]}")
        axis: TomlTable = {"axis": numbers[4:7]} if size == 3 else {}
        table = {"type": "rotation", "centre": numbers[1 : 1 + size], **axis}
        return table, math.sqrt(numbers[0])

    def _traction(self, label: str, along: str | list[float]) -> TomlTable:
        return {"type": "traction", "boundary": label, "direction": along}

    def _nodes(self, text: str) -> str:
        """A set of nodes that is a boundary."""
        label = text.strip('"').upper()
        for node in self._deck.labelled(text):
            if node in self._led:
                raise ValueError(self._led[node].advice(len(self._axes)))
        if label in self._deck.unnamed:
            return label
        if label not in self._deck.node_sets:
            raise ValueError(self._no_set(text))
        if label in self._deck.surfaces:
            raise ValueError(f"expected a name of its own, found {label}, a surface too")
        self._find(label)
        return label

    def _no_set(self, text: str) -> str:
        """A label that is no set of nodes, in words."""
        sets = self._deck.node_sets
        if not (nodes := self._deck.labelled(text)):
            return (
                f"no node set {text}{did_you_mean(text.upper(), sets)}; node sets: {listed(sets)}"
            )
        if nodes[0] not in self._deck.nodes:
            return f"there is no node {text}"
        return (
            "single nodes are neither held nor loaded here: name the nodes of whole facets "
            "(*NSET), or a surface (*SURFACE) around them"
        )


def _name(label: str) -> str:
    """A name in a case."""
    text = "".join(each if each.isascii() and each.isalnum() else "_" for each in label.lower())
    return text[:80] or "load"
