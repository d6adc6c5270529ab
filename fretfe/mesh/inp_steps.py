# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contacts, supports and loads of an Abaqus or CalculiX input file, as a case has them.

Static steps one after the other: a load goes linearly from where it stands to its value at the end
of the step, or as its amplitude says, a jump within the first increment; what a later step does not
name stays (OP=MOD) or goes to zero (OP=NEW). Amplitudes are factors over the time of the step, or
over that of all steps.
(Abaqus Analysis User's Guide, Prescribed conditions; CalculiX has the same rules.)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

from fretfe.errors import MeshError
from fretfe.mesh.inp import Deck
from fretfe.mesh.inp_cards import Card, real, whole
from fretfe.mesh.inp_channels import Amplitude, Channel, Step, TomlTable, read_amplitude, repeated
from fretfe.mesh.inp_groups import listed
from fretfe.mesh.inp_language import ACTING
from fretfe.mesh.inp_references import Reference, references
from fretfe.mesh.inp_shapes import Facet
from fretfe.mesh.templates import did_you_mean

AXES = ("x", "y", "z")
# Displacements, 1 to 3, and rotations, 4 to 6.
HELD = {
    "ENCASTRE": (1, 2, 3, 4, 5, 6), "PINNED": (1, 2, 3), "XSYMM": (1, 5, 6), "YSYMM": (2, 4, 6),
    "ZSYMM": (3, 4, 5),
}  # fmt: skip
# What the histories of a platen and its tilts are.
MOTIONS = ("displacement", "rotation")
FORCES = ("force", "moment")
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
        cycle: begin and end of what the loads repeat.
        lacks: what was not understood, in words.
        read: keywords that were.
    """

    contacts: dict[str, TomlTable] = field(default_factory=dict)
    supports: dict[str, TomlTable] = field(default_factory=dict)
    loads: dict[str, TomlTable] = field(default_factory=dict)
    cycle: tuple[float, float] | None = None
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
        # surfaces that slide, and axes, 1 to 3, about which they do not turn
        self._upright: set[tuple[str, int]] = set()
        self._references = references(deck)
        self._led = {each.turning: (each, 3) for each in self._references}
        self._led |= {each.node: (each, 0) for each in self._references}
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
            else:
                channel.go_on(step)

    def finish(self) -> Proposal:
        """Make the tables."""
        found = self._found
        for channel in self._channels.values():
            table, still = channel.table, not any(value for _, value, _ in channel.points)
            along = table.get("direction", table.get("axis"))
            if channel.word == "BOUNDARY" and channel.since > 0.0:
                found.lacks.append(
                    f"{channel.place}: {table['boundary']} is held or moved along {along} from "
                    f"t = {channel.since:g} on only"
                )
            elif channel.word == "BOUNDARY" and still:
                # a platen is held without a load
                if table["type"] == "displacement":
                    self._hold(table["boundary"], table["direction"])
            elif not still:
                self._add(table, channel.history())
        for each in self._references:
            if each.rigid:
                self._finish_platen(each)
        found.cycle = repeated([*self._channels.values()])
        return found

    def _hold(self, boundary: str, axis: str) -> None:
        support = self._found.supports.setdefault(
            _name(boundary), {"boundary": boundary, "fix": []}
        )
        support["fix"].append(axis)

    def _add(self, table: TomlTable, history: list[TomlTable]) -> None:
        """Take over a load."""
        name = _name(str(table.get("boundary", table["type"])))
        along = table.get("direction", table.get("axis") if table["type"] == "tilt" else None)
        name += "_about" if table["type"] == "tilt" else ""
        name = f"{name}_{along}" if isinstance(along, str) else name
        while name in self._found.loads:
            name += "_"
        self._found.loads[name] = {**table, "history": history}

    def _finish_platen(self, led: Reference) -> None:
        """Free what nothing holds or loads of a rigid surface; a support where nothing is free."""
        places: Iterable[int] = range(1, 7)
        if self._slides(led):
            places = sorted(led.axes)
            turns = {about for about in (1, 2, 3) if led.axes - {about}}
            turns &= {3} if len(self._axes) == 2 else {1, 2, 3}
            if not {(led.label, about) for about in turns} <= self._upright:
                turning = "which a platen that slides does not: hold the turns of its node"
                self._lack(led.card, f"{led.label} is tied along some axes and may turn, {turning}")
        try:
            tables = [each for n in places for each, _ in self._moved(led, n, FORCES)]
        except (ValueError, MeshError) as error:
            self._lack(led.card, str(error))
            return
        held = {
            (channel.table["type"], channel.table.get("direction", channel.table.get("axis")))
            for channel in self._channels.values()
            if channel.word == "BOUNDARY" and channel.table.get("boundary") == led.label
        }
        loaded = {
            (load["type"], load.get("direction", load.get("axis")))
            for load in self._found.loads.values() if load.get("boundary") == led.label
        }  # fmt: skip
        for table in tables:
            if (table["type"], table.get("direction", table.get("axis"))) not in held | loaded:
                self._add(table, [{"hold": True, "until": self._end or 1.0, "steps": 1}])
        if all(load.get("boundary") != led.label for load in self._found.loads.values()):
            for place in sorted(led.axes):
                if place <= len(self._axes):
                    self._hold(led.label, AXES[place - 1])

    def _slides(self, led: Reference) -> bool:
        """True for a surface that is free to move along some axes."""
        return not led.axes.issuperset(range(1, len(self._axes) + 1))

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
        if led := self._led_by(row[0]):
            for each, place in ((each, place + more) for each, more in led for place in places):
                if not each.rigid:
                    raise ValueError(f"expected forces at the reference node of {each.label} alone")
                if self._slides(each) and place > len(AXES) and not value:
                    self._upright.add((each.label, place - len(AXES)))
                    continue
                for table, _ in self._moved(each, place, MOTIONS):
                    yield table, value
            return
        boundary = self._nodes(row[0])
        for axis in (AXES[place - 1] for place in places if place <= len(self._axes)):
            yield {"type": "displacement", "boundary": boundary, "direction": axis}, value

    def _force(self, card: Card, row: list[str]) -> Iterator[tuple[TomlTable, float]]:
        """Equal forces on the nodes of a boundary, as one force that is spread over it."""
        if "FOLLOWER" in card.parameters:
            raise ValueError("expected forces that keep their direction")
        if led := self._led_by(row[0]):
            for each, more in led:
                for table, factor in self._moved(each, whole(row[1]) + more, FORCES):
                    yield table, factor * real(row[2])
            return
        place = whole(row[1]) - 1
        # of many nodes each would be a load of its own
        if (node := self._lone(row[0])) and len(card.rows) <= 10:
            boundary = self._around(node, row[0])
            self._lack(card, f"the force on node {row[0]} as such: it is spread over {boundary}")
            through = [float(value) for value in self._deck.nodes[node][: len(self._axes)]]
            yield {"type": "force", "boundary": boundary, "direction": self._axes[place],
                   "through": through}, real(row[2])  # fmt: skip
            return
        boundary = self._nodes(row[0])
        unnamed = self._deck.unnamed
        count = unnamed.get(boundary) or len(set(self._deck.node_sets[boundary]))
        table = {"type": "force", "boundary": boundary, "direction": self._axes[place]}
        yield table, count * real(row[2])

    def _led_by(self, text: str) -> list[tuple[Reference, int]]:
        """References of a node or set, if these are theirs, and what leads to their rotations."""
        members = self._deck.labelled(text)
        return [self._led[node] for node in dict.fromkeys(members) if node in self._led]

    def _moved(
        self, led: Reference, place: int, controls: tuple[str, str]
    ) -> Iterator[tuple[TomlTable, float]]:
        """Loads of a surface with a reference node along or about an axis, and their factors."""
        self._find(led.label)
        size, own = len(self._axes), {"boundary": led.label}
        centre = [float(value) for value in led.place[:size]]
        if self._slides(led) and place not in led.axes:
            # the surface stays where it is, whatever the node does
            if led.rigid and place <= size and controls is MOTIONS:
                return
            raise ValueError(f"{led.label} is tied along some axes only, and does not follow")
        if place <= size:
            along = {**own, "direction": AXES[place - 1]}
            if led.rigid:
                yield {"type": "platen", **along, "control": controls[0]}, 1.0
            else:
                yield {"type": "force", **along, "through": centre}, 1.0
        elif place == 6 or (place > 3 and size == 3):
            about = place - 4
            if led.rigid:
                yield {"type": "tilt", **own, "axis": AXES[about], "centre": centre,
                       "control": controls[1]}, 1.0  # fmt: skip
                return
            # a couple of forces with a lever of one
            arm, along = (about + 1) % 3, {**own, "direction": AXES[(about + 2) % 3]}
            for end in (0.5, -0.5):
                through = [value + end * (axis == arm) for axis, value in enumerate(centre)]
                yield {"type": "force", **along, "through": through}, 2 * end

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
        if label in self._deck.unnamed:
            return label
        if label not in self._deck.node_sets:
            raise ValueError(self._no_set(text))
        if label in self._deck.surfaces:
            raise ValueError(f"expected a name of its own, found {label}, a surface too")
        self._find(label)
        return label

    def _lone(self, text: str) -> int | None:
        """The number of a node that is alone in a row; None for a set of several."""
        members = self._deck.labelled(text)
        return members[0] if len(members) == 1 and members[0] in self._deck.nodes else None

    def _around(self, node: int, text: str) -> str:
        """The smallest named boundary with a node on its facets that is no surface of a contact."""
        contacts = [table[f"surface{n}"] for table in self._found.contacts.values() for n in (1, 2)]
        sizes = {}
        for label in (*self._deck.surfaces, *self._deck.node_sets):
            if label not in contacts:
                with suppress(MeshError):
                    facets = self._find(label)
                    if any(node in facet.nodes for facet in facets):
                        sizes[label] = len(facets)
        if not sizes:
            raise ValueError(
                f"under a force on one node it moves the farther the smaller the elements are: name"
                f" a surface (*SURFACE) around node {text}, over which it is spread"
            )
        return min(sizes, key=lambda label: sizes[label])

    def _no_set(self, text: str) -> str:
        """A label that is no set of nodes, in words."""
        sets = self._deck.node_sets
        if not (nodes := self._deck.labelled(text)):
            return (
                f"no node set {text}{did_you_mean(text.upper(), sets)}; node sets: {listed(sets)}"
            )
        if nodes[0] not in self._deck.nodes:
            return f"there is no node {text}"
        return "single nodes are not held here: hold the nodes of whole facets (*NSET) or a surface"


def _name(label: str) -> str:
    """A name in a case."""
    text = "".join(each if each.isascii() and each.isalnum() else "_" for each in label.lower())
    return text[:80] or "load"
