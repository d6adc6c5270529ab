# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case as a whole, checks of its tables against each other, and its JSON schema."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import chain, combinations, product
from pathlib import Path
from typing import Any, NamedTuple, Self

from pydantic import Field, PrivateAttr, model_validator

from fretfe.case.base import AXES, Name, Table, unit_vector
from fretfe.case.bodies import AnyBody, Given, OverTemperature
from fretfe.case.holders import ORTHOGONALITY, holders, platens, shown
from fretfe.case.loads import (
    AccelerationLoad,
    Along,
    AnyLoad,
    FieldLoad,
    Load,
    PlatenLoad,
    RotationLoad,
    TiltLoad,
)
from fretfe.case.tables import (
    Contact,
    Cycle,
    Edges,
    Geometry,
    Model,
    Output,
    Start,
    Support,
    Symmetry,
    TiedParts,
)
from fretfe.case.units import Units

Key = tuple[str | int, ...]

# Keys of tables whose constants may be tables over temperature.
OVER_TEMPERATURE = {
    "Body": ("young", "poisson", "density", "expansion"),
    "Crystal": ("density", "expansion"),
    "Elastic": ("cubic", "constants"),
}
# Distance of two axes over that of their points from the origin, up to which they are one.
SAME_AXIS = 1e-6


class Problem(NamedTuple):
    """One thing that is wrong with a case: the key in the file and a text for the user."""

    key: Key
    text: str


def cross_problems(
    bodies: Mapping[str, AnyBody],
    contacts: Mapping[str, Contact],
    supports: Mapping[str, Support],
    loads: Mapping[str, Load],
    symmetry: Mapping[str, Symmetry],
    ties: Mapping[str, TiedParts],
) -> list[Problem]:
    """Contradictions between the tables given, which may be only a part of a case."""
    return [
        *_surface_problems(contacts),
        *_held_surface_problems(contacts, supports, loads),
        *_platen_problems(contacts, supports, loads),
        *_platen_direction_problems(loads),
        *_displacement_problems(supports, loads),
        *_carried_problems(supports, loads),
        *_body_problems(bodies, loads),
        *_need_problems(bodies, loads),
        *_interference_problems(contacts, loads),
        *_pretension_problems(ties, loads),
        *_side_problems(contacts, supports, loads, symmetry, ties),
        *_axis_problems(symmetry),
        *_load_axis_problems(loads, symmetry),
    ]


def _surfaces(contacts: Mapping[str, Contact]) -> Iterator[tuple[tuple[str, str, str], str]]:
    """Surfaces of contacts, by their keys."""
    for name, contact in contacts.items():
        yield ("contacts", name, "surface1"), contact.surface1
        yield ("contacts", name, "surface2"), contact.surface2


def _surface_problems(contacts: Mapping[str, Contact]) -> Iterator[Problem]:
    used: dict[str, str] = {}
    for key, surface in _surfaces(contacts):
        if surface in used:
            text = f"expected a surface of its own, found {surface!r}, which is already "
            yield Problem(key, text + used[surface])
        used.setdefault(surface, ".".join(key))


def _held_surface_problems(
    contacts: Mapping[str, Contact], supports: Mapping[str, Support], loads: Mapping[str, Load]
) -> Iterator[Problem]:
    """Contact surfaces that are held or moved: only contact may hold them."""
    used = {surface: ".".join(key) for key, surface in _surfaces(contacts)}
    held = [("supports", name, each.boundary) for name, each in supports.items()]
    held += [("loads", name, load.on) for name, load in loads.items() if load.moves]
    for table, name, boundary in held:
        if boundary in used:
            yield Problem(
                (table, name, "boundary"),
                f"expected a boundary that is no contact surface, found {boundary!r}, which is "
                f"{used[boundary]}",
            )


def _platen_problems(
    contacts: Mapping[str, Contact], supports: Mapping[str, Support], loads: Mapping[str, Load]
) -> Iterator[Problem]:
    uses: list[tuple[Key, str]] = [*_surfaces(contacts)]
    uses += [(("supports", name, "boundary"), each.boundary) for name, each in supports.items()]
    uses += [(("loads", name, "boundary"), load.on) for name, load in loads.items() if load.moves]
    found = platens(loads)
    for key, boundary in uses:
        if boundary in found:
            yield Problem(
                key,
                f"expected a boundary that is not a platen, found {boundary!r}, the platen of "
                f"loads.{found[boundary]} (a platen is rigid and held in every direction "
                "without a load)",
            )


def _platen_direction_problems(loads: Mapping[str, Load]) -> Iterator[Problem]:
    """Directions, or axes, of loads on one platen that are not at right angles."""
    for kind, key in ((PlatenLoad, "direction"), (TiltLoad, "axis")):
        own = [(name, load) for name, load in loads.items() if isinstance(load, kind)]
        for (name1, load1), (name2, load2) in combinations(own, 2):
            if load1.on != load2.on:
                continue
            found1, found2 = getattr(load1, key), getattr(load2, key)
            vectors = (unit_vector(each, 3) for each in (found1, found2))
            cosine = sum(a * b for a, b in zip(*vectors, strict=True))
            if abs(cosine) > ORTHOGONALITY:
                yield Problem(
                    ("loads", name2, key),
                    f"expected {'an' if key == 'axis' else 'a'} {key} at right angles to that of "
                    f"loads.{name1} on the same platen {load1.on!r}, found {shown(found2)} "
                    f"and {shown(found1)}",
                )


def _displacement_problems(
    supports: Mapping[str, Support], loads: Mapping[str, Load]
) -> Iterator[Problem]:
    """Components of a boundary that are prescribed twice."""
    used = [*holders(supports, {})]
    for name, load in loads.items():
        if not (load.moves and load.on):
            continue
        axes = AXES if load.along is None else (load.along,)
        for axis, other in product(axes, [each for each in used if each.boundary == load.on]):
            if math.hypot(*other.carries(unit_vector(axis, 3))) > 1 - ORTHOGONALITY:
                yield Problem(
                    ("loads", name, "boundary" if load.along is None else "direction"),
                    f"expected a free component, found {axis!r} of {load.on!r}, which "
                    f"{other.key} prescribes already",
                )
        used += holders({}, {name: load})


def _carried_problems(
    supports: Mapping[str, Support], loads: Mapping[str, Load]
) -> Iterator[Problem]:
    """Loads that what holds their own boundary carries; of normal ones only the mesh tells."""
    for (name, load), holder in product(loads.items(), [*holders(supports, loads)]):
        along = None if load.rigid or holder.boundary != load.on else load.push
        if along is not None and along != "normal" and (text := holder.carried(along)):
            yield Problem(("loads", name), text)


def _body_problems(bodies: Mapping[str, AnyBody], loads: Mapping[str, Load]) -> Iterator[Problem]:
    """Loads in bodies that are not there."""
    for name, load in loads.items():
        for number, body in enumerate(load.within or ()):
            if body not in bodies:
                expected = ", ".join(map(repr, bodies)) or "none"
                yield Problem(
                    ("loads", name, "bodies", number),
                    f"expected one of the bodies {expected}, found {body!r}",
                )


def _need_problems(bodies: Mapping[str, AnyBody], loads: Mapping[str, Load]) -> Iterator[Problem]:
    """Constants of bodies that loads need and that are not known."""
    for name, load in loads.items():
        missing = [
            f"bodies.{body}.{key}"
            for body in bodies
            if load.within is None or body in load.within
            for key in load.needs
            if getattr(bodies[body], key) is None
        ]
        if missing:
            yield Problem(
                ("loads", name),
                f"{load.title} needs the {' and '.join(load.needs)} of every body that it acts on, "
                f"missing: {', '.join(missing)}",
            )


def _interference_problems(
    contacts: Mapping[str, Contact], loads: Mapping[str, Load]
) -> Iterator[Problem]:
    for name, load in loads.items():
        if load.closes and load.closes not in contacts:
            expected = ", ".join(map(repr, contacts)) or "none"
            text = f"expected one of the contacts {expected}, found {load.closes!r}"
            yield Problem(("loads", name, "contact"), text)


def _pretension_problems(
    ties: Mapping[str, TiedParts], loads: Mapping[str, Load]
) -> Iterator[Problem]:
    used: dict[str, str] = {}
    for name, load in loads.items():
        if (tie := load.tightens) and (tie not in ties or tie in used):
            others = ", ".join(map(repr, ties.keys() - used.keys())) or "none"
            taken = f", which loads.{used[tie]} has" if tie in used else ""
            text = f"expected one of the ties {others}, found {tie!r}{taken}"
            yield Problem(("loads", name, "tie"), text)
        used.setdefault(tie, name)


def _side_problems(
    contacts: Mapping[str, Contact],
    supports: Mapping[str, Support],
    loads: Mapping[str, Load],
    symmetry: Mapping[str, Symmetry],
    ties: Mapping[str, TiedParts],
) -> Iterator[Problem]:
    """Sides of a sector, or tied boundaries, that are something else: only the others may act."""
    used = {surface: ".".join(key) for key, surface in _surfaces(contacts)}
    used |= {each.boundary: f"supports.{name}.boundary" for name, each in supports.items()}
    for name, load in loads.items():
        used[load.on] = f"loads.{name}.boundary"
    tables: list[tuple[str, str, Mapping[str, Symmetry | TiedParts]]] = [
        ("symmetry", "the neighbour sector", {**symmetry}),
        ("ties", "the tied part", {**ties}),
    ]
    for table, other, name, pair in ((t, o, *item) for t, o, own in tables for item in own.items()):
        for key in ("boundary1", "boundary2"):
            side = getattr(pair, key)
            if side in used:
                yield Problem(
                    (table, name, key),
                    f"expected a boundary that only {other} acts on, found {side!r}, which is "
                    f"{used[side]}",
                )
            used[side] = f"{table}.{name}.{key}"


def _axis_problems(symmetry: Mapping[str, Symmetry]) -> Iterator[Problem]:
    """Tables that are not about the same sectors."""
    for (name1, one), (name2, other) in combinations(symmetry.items(), 2):
        if one.sectors != other.sectors:
            yield Problem(
                ("symmetry", name2, "sectors"),
                f"expected that of symmetry.{name1}, {one.sectors}, found {other.sectors}: all "
                "bodies are of one sector",
            )
        if not _same_axis(one, other):
            yield Problem(
                ("symmetry", name2), f"expected the axis of symmetry.{name1}, found another one"
            )


def _load_axis_problems(
    loads: Mapping[str, Load], symmetry: Mapping[str, Symmetry]
) -> Iterator[Problem]:
    """Body forces that are not the same in all sectors."""
    if not symmetry:
        return
    name, sector = next(iter(symmetry.items()))
    for key, load in loads.items():
        if isinstance(load, RotationLoad) and not _same_axis(load, sector):
            yield Problem(
                ("loads", key),
                f"expected a rotation about the axis of symmetry.{name}, found one about another "
                "axis, by which the sectors are not loaded alike",
            )
        if isinstance(load, AccelerationLoad) and not _parallel(load.direction, sector.axis):
            yield Problem(
                ("loads", key, "direction"),
                f"expected an acceleration along the axis of symmetry.{name}, found "
                f"{shown(load.direction)}, by which the sectors are not loaded alike",
            )


def _same_axis(one: RotationLoad | Symmetry, other: Symmetry) -> bool:
    """True if two axes are the same line."""
    if not _parallel(one.axis, other.axis):
        return False
    first, second = (unit_vector(each.centre, 3) for each in (one, other))
    between = tuple(b - a for a, b in zip(first, second, strict=True))
    distance = math.hypot(*_cross(between, unit_vector(other.axis, 3)))
    return distance <= SAME_AXIS * max(math.hypot(*first), math.hypot(*second))


def _parallel(one: Along, other: Along) -> bool:
    return math.hypot(*_cross(unit_vector(one, 3), unit_vector(other, 3))) < ORTHOGONALITY


def _cross(one: tuple[float, ...], other: tuple[float, ...]) -> tuple[float, float, float]:
    (a, b, c), (d, e, f) = one, other
    return (b * f - c * e, c * d - a * f, a * e - b * d)


class Contradiction(ValueError):
    """Tables that are valid one by one but not together."""

    def __init__(self, problems: list[Problem]) -> None:
        """Keep the problems, all of them."""
        super().__init__("; ".join(problem.text for problem in problems))
        self.problems = problems


class Case(Table):
    """Everything that a case file says."""

    title: str = Field(
        default="", strict=True, max_length=1000, description="Title, shown in the output."
    )
    units: Units = Field(default=Units(), description="Labels of the units used in the file.")
    model: Model = Field(default=Model(), description="Plane state, thickness, discretisation.")
    geometry: Geometry = Field(description="Where the mesh comes from.")
    bodies: dict[Name, AnyBody] = Field(
        min_length=2, description="Bodies; the key is the physical surface group of the mesh."
    )
    contacts: dict[Name, Contact] = Field(
        min_length=1, description="Contacts, by names that you choose."
    )
    supports: dict[Name, Support] = Field(
        default={}, description="Held boundaries, by names that you choose."
    )
    symmetry: dict[Name, Symmetry] = Field(
        default={},
        description="Sides of a sector of a disc, by names that you choose; one table for each "
        "body that the neighbour sectors continue.",
    )
    ties: dict[Name, TiedParts] = Field(
        default={},
        description="Boundaries of parts of one body that are bonded, by names that you choose.",
    )
    loads: dict[Name, AnyLoad] = Field(
        default={},
        description="Loads, by names that you choose; each is one channel with one history.",
    )
    start: Start | None = Field(
        default=None, description="State of another run, from which this one goes on."
    )
    cycle: Cycle = Field(
        default=Cycle(),
        description="The cycle to evaluate; without it the last period of the slowest wave.",
    )
    edges: Edges = Field(
        default=Edges(),
        description="Accuracy of the edge factors; without a tolerance the mesh is that of the "
        "geometry.",
    )
    output: Output = Field(
        default=Output(), description="What is written in addition to the results."
    )

    _source: Path = PrivateAttr(default=Path("case.toml"))
    _trust_geo: bool = PrivateAttr(default=False)
    _given: Given | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _no_contradictions(self) -> Self:
        problems = cross_problems(
            self.bodies, self.contacts, self.supports, self.loads, self.symmetry, self.ties
        )
        problems += [Problem(("edges", "ends"), text) for text in self._without_parts()]
        if self.start is not None and self.edges.tolerance is not None:
            text = "expected no edges.tolerance with it: the mesh is that of the other run"
            problems.append(Problem(("start",), text))
        if problems:
            raise Contradiction(problems)
        return self

    def _without_parts(self) -> Iterator[str]:
        """Reasons why no parts around ends of fronts can be made, though they are asked for."""
        if not self.edges.ends:
            return
        solid = self.geometry.solid
        if solid is None:
            yield (
                "expected geometry.solid with it, as parts around ends are made of layers: extrude "
                "plane bodies, or leave it out"
            )
        elif solid.skew and self.symmetry:
            yield (
                "expected no sector (symmetry) of bodies that lean (geometry.solid.skew), which "
                "are bent between contacts and sides, as a part is not: leave it out, or run a "
                "block that supports hold"
            )
        if self.edges.tolerance is not None:
            yield (
                "expected no edges.tolerance with it, as parts need elements of a given size: "
                "leave it out, and use fretfe submodel --run --size after the run"
            )

    @property
    def cut_loads(self) -> dict[str, FieldLoad]:
        """Loads that move the cut boundaries of a part as another run does, by name."""
        return {name: load for name, load in self.loads.items() if isinstance(load, FieldLoad)}

    @property
    def source(self) -> Path:
        """The case file; what it names is relative to its folder."""
        return self._source

    @property
    def trust_geo(self) -> bool:
        """True if a .geo file that the case names may run: the caller says so, never the file."""
        return self._trust_geo

    @property
    def given(self) -> Given | None:
        """Bodies as they were given, if materials or tables over temperature stood for numbers."""
        return self._given

    @property
    def material_notes(self) -> tuple[str, ...]:
        """Sources of constants that are no numbers in the case, in words."""
        return self._given.notes if self._given is not None else ()

    def components(self, dimension: int) -> int:
        """Number of displacement components, 2 or 3, on a mesh with so many coordinates.

        Bodies of a plane mesh have a third one, u_z(x, y), where something moves them along z.
        """
        return 3 if dimension == 3 or any(True for _ in self.moving_across()) else 2

    def moving_across(self) -> Iterator[Key]:
        """Keys of what moves plane bodies along z: loads, and crystals that couple it in.

        Supports alone do not: then a case of solids may lack its extrusion.
        """
        for name, load in self.loads.items():
            if load.along == "z" or (isinstance(load.along, tuple) and any(load.along[2:])):
                yield "loads", name, "direction"
        for name, body in self.bodies.items():
            if body.couples_across:
                yield "bodies", name, "orientation"

    @property
    def surface_names(self) -> frozenset[str]:
        """Names of the surfaces of all contacts."""
        pairs = ((each.surface1, each.surface2) for each in self.contacts.values())
        return frozenset(chain.from_iterable(pairs))

    def as_tables(self) -> dict[str, Any]:
        """The keys that are set, in plain types, as a case file has them."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True, exclude_none=True)

    def resolve(self, file: str) -> Path:
        """Path of a file that the case names."""
        return self._source.parent / file


def case_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a case file, with a description of every key."""
    schema = Case.model_json_schema()
    tables = schema["$defs"]
    tables["OverTemperature"] = OverTemperature.model_json_schema()
    for table, keys in OVER_TEMPERATURE.items():
        for key in keys:
            one = tables[table]["properties"][key]
            text = one.pop("description")
            either = [one, {"$ref": "#/$defs/OverTemperature"}]
            tables[table]["properties"][key] = {"anyOf": either, "description": text}
    del tables["Body"]["required"]  # a material may have them
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
