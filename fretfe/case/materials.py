# SPDX-License-Identifier: LGPL-3.0-or-later
"""Constants of bodies from material files, decks and tables over temperature, as single numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Self

from pydantic import TypeAdapter, ValidationError, model_validator

from fretfe.case.base import ABAQUS, Table, Text
from fretfe.case.bodies import AnyBody, Given, OverTemperature
from fretfe.case.fatigue import Fatigue
from fretfe.case.messages import complaint, field_problems, found
from fretfe.case.model import Case, Key
from fretfe.case.toml_file import read_tables
from fretfe.case.units import (
    DENSITIES,
    FORCE,
    FORCES,
    LENGTH,
    METRES,
    STRESSES,
    TIMES,
    stress_label,
    unit_doubts,
)
from fretfe.errors import CaseError, MeshError
from fretfe.plugins import MATERIALS, plug_ins, plugged_file
from fretfe.report.texts import rounded
from fretfe.terminal import one_line

# Constants that are no stress.
PURE = ("poisson", "expansion")
CONSTANTS = ("young", "poisson", "elastic", "density", "expansion")
ELASTIC = ("young", "poisson", "elastic")
# Characters.
LONGEST_NAME = 1000
# Coefficients of friction up to about this one are measured.
LARGEST_FRICTION = 2.0


class MaterialUnits(Table):
    """Units of a material file; temperatures are degrees Celsius, expansion per degree."""

    stress: Text
    density: Text | None = None

    @model_validator(mode="after")
    def _known(self) -> Self:
        for label, known in ((self.stress, STRESSES), (self.density, DENSITIES)):
            if label is not None and label not in known:
                raise ValueError(f"expected one of {', '.join(known)}, found {label!r}")
        return self


class MaterialFile(Table):
    """A material file: constants as of a body, their source and their units, and fatigue data."""

    source: Text
    units: MaterialUnits
    young: Any = None
    poisson: Any = None
    elastic: Any = None
    density: Any = None
    expansion: Any = None
    fatigue: Fatigue | None = None

    @model_validator(mode="after")
    def _unit_of_density(self) -> Self:
        if self.density is not None and self.units.density is None:
            raise ValueError("expected units.density beside density, found none")
        return self

    @property
    def constants(self) -> dict[str, Any]:
        """Those that are given."""
        each = ((name, getattr(self, name)) for name in CONSTANTS)
        return {name: value for name, value in each if value is not None}


def material_directory() -> Path:
    """The folder of the materials that come with fretfe."""
    return Path(__file__).resolve().parents[1] / "materials"


def _own_names() -> list[str]:
    return sorted(path.stem for path in material_directory().glob("*.toml"))


def material_names() -> tuple[str, ...]:
    """Names of all materials that come with fretfe, sorted, then those of other packages."""
    return tuple(dict.fromkeys((*_own_names(), *(each.name for each in plug_ins(MATERIALS)))))


def find_material(material: Any, folder: Path) -> Path:
    """The file of a material: one that comes with fretfe or another package, or below a folder.

    Raises:
        CaseError: it is no name of one, nor that of a file.
        DependencyError: another package fails to give its file.
    """
    if isinstance(material, str) and len(material) < LONGEST_NAME:
        if material.endswith(".toml"):
            return folder / material
        if material in _own_names():
            return material_directory() / f"{material}.toml"
        if other := plugged_file(MATERIALS, material):
            return other
    names = material_names()
    near = get_close_matches(str(material)[:LONGEST_NAME], names, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise CaseError(
        f"expected one of {', '.join(map(repr, names))}, or a file whose name ends in '.toml', "
        f"found {found(material)}{hint}"
    )


def read_material(path: Path) -> MaterialFile:
    """A material file.

    Raises:
        CaseError: it is none; all problems are listed.
    """
    data = read_tables(path, "a material file (TOML)")
    try:
        return MaterialFile.model_validate(data)
    except ValidationError as error:
        problems = field_problems(error, MaterialFile)
        raise CaseError("\n".join(complaint(path, *each) for each in problems)) from None


def with_constants(data: Mapping[str, Any], source: Path) -> tuple[dict[str, Any], Given | None]:
    """Tables of a case with single numbers in place of materials and tables over temperature.

    Bodies without elastic constants have the material of an input file, if the mesh is one.

    Args:
        data: tables of a case file; not changed.
        source: the case file.

    Returns:
        The tables, and what they were; None if there was nothing to replace.

    Raises:
        CaseError: for the first body whose constants cannot be told.
    """
    bodies = data.get("bodies")
    if not isinstance(bodies, Mapping):
        return dict(data), None
    resolved: dict[str, Any] = {}
    notes: list[str] = []
    young: dict[str, OverTemperature] = {}
    decks = _of_deck(data, source, bodies)
    for name, body in bodies.items():
        resolved[name] = body
        if name in decks or (
            isinstance(body, Mapping) and ("material" in body or any(_tables(body)))
        ):
            deck = decks.get(name)
            resolved[name], note, curve = _resolved(data, source, str(name), body, deck)
            notes.append(note)
            if curve is not None:
                young[name] = curve
    if not notes:
        return dict(data), None
    return {**data, "bodies": resolved}, Given(bodies, tuple(notes), young)


def _of_deck(
    data: Mapping[str, Any], source: Path, bodies: Mapping[str, Any]
) -> dict[str, tuple[str, dict[str, Any]]]:
    """Name and numbers of the materials in an input file of bodies that lack elastic constants.

    Raises:
        CaseError: for the first body that has none there.
    """
    geometry = data.get("geometry")
    geometry = geometry if isinstance(geometry, Mapping) else {}
    file, labels = geometry.get("file"), geometry.get("bodies")
    bare = [
        name for name, body in bodies.items()
        if isinstance(body, Mapping) and not {"material", "elastic"}.intersection(body)
        and not {"young", "poisson"}.issubset(body)
    ]  # fmt: skip
    if not (bare and isinstance(file, str) and file.lower().endswith(ABAQUS.suffixes)):
        return {}
    # Imported where it is needed: most cases have no such file.
    from fretfe.mesh.inp import Material, read_deck

    try:
        deck = read_deck(source.parent / file)
    except MeshError as error:
        raise CaseError(complaint(source, ("geometry", "file"), str(error))) from None
    found = {}
    for name in bare:
        label = labels.get(name) if isinstance(labels, Mapping) else None
        label = label.get("label") if isinstance(label, Mapping) else None
        materials = deck.materials_of(deck.elements_of(str(label or name).upper()))
        one = deck.materials.get(materials[0]) if len(materials) == 1 else None
        material = one or Material()
        if missing := [key for key in ("young", "poisson")
                       if key not in bodies[name] and key not in material.numbers]:  # fmt: skip
            reason = ", ".join(material.left_out or materials) or "none"
            text = (
                f"expected {' and '.join(missing)}, or elastic, or a material, here or of "
                f"the body in {file}, found there: {reason}"
            )
            raise CaseError(complaint(source, ("bodies", name), text))
        found[name] = f"{materials[0]} of {file}", material.numbers
    return found


def _resolved(
    data: Mapping[str, Any],
    source: Path,
    name: str,
    body: Mapping[str, Any],
    deck: tuple[str, dict[str, Any]] | None,
) -> tuple[dict[str, Any], str, OverTemperature | None]:
    """A body with numbers, a note about it, and Young's modulus over temperature."""
    own = {key: value for key, value in body.items() if key != "material"}
    texts, place = [], source
    if deck is not None:
        texts.append(deck[0])
        own = {**deck[1], **own}
        if own.get("temperature") is None:
            texts += _at_first(own, deck[1])
    if "material" in body:
        place, read = _material(source, name, body["material"])
        own = {**_beside(own, _converted(data, source, name, read)), **own}
        texts.append(f"{body['material']} ({read.source})")
    temperature = own.get("temperature")
    curves = dict(_tables(own))
    for key in curves:
        where = (source, ("bodies", name, *key)) if key[0] in body else (place, key)
        value = _at(*where, source, name, temperature, curves[key])
        if len(key) > 1:
            own[key[0]] = {**own[key[0]], key[1]: value}
        else:
            own[key[0]] = value
    if "material" in body and not any(key in body for key in ELASTIC):
        _require_body(place, own)
    if curves:
        texts.append(f"constants at {temperature:g} °C")
    curve = curves.get(("young",))
    note = one_line(f"bodies.{name}: {', '.join(texts)}{_shown(own)}")
    return own, note, None if curve is None else OverTemperature(**curve)


def _at_first(own: dict[str, Any], deck: Mapping[str, Any]) -> list[str]:
    """Take what a deck has over temperature at the first temperature; what was done, in words.

    A model without temperatures is at 0, and beyond their ends tables stay constant (Abaqus
    Analysis User's Guide, Material data definition).
    """
    taken: dict[float, list[str]] = {}
    for key, table in deck.items():
        if own[key] is table and isinstance(table, Mapping):
            own[key] = table["values"][0]
            taken.setdefault(table["temperatures"][0], []).append(key)
    return [
        f"{' and '.join(keys)} at {first:g} °C, the first of a table, as the body has no "
        "temperature"
        for first, keys in taken.items()
    ]


def _material(source: Path, body: str, material: Any) -> tuple[Path, MaterialFile]:
    """The material of a body, and its file."""
    try:
        path = find_material(material, source.parent)
    except CaseError as error:
        raise CaseError(complaint(source, ("bodies", body, "material"), str(error))) from None
    return path, read_material(path)


def _beside(own: Mapping[str, Any], constants: Mapping[str, Any]) -> dict[str, Any]:
    """Constants of a material that go with those of the body's own.

    These may make a crystal isotropic, or the other way round.
    """
    other: tuple[str, ...] = ()
    if any(key in own for key in ELASTIC):
        other = ("young", "poisson") if "elastic" in own else ("elastic",)
    return {key: value for key, value in constants.items() if key not in other}


def _require_body(path: Path, constants: Mapping[str, Any]) -> None:
    """Check the constants of a material: what is wrong is in its file, or missing there."""
    kept = {key: value for key, value in constants.items() if key in CONSTANTS}
    try:
        TypeAdapter(AnyBody).validate_python(kept)
    except ValidationError as error:
        problems = field_problems(error, MaterialFile)
        raise CaseError("\n".join(complaint(path, *each) for each in problems)) from None


def _tables(body: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], dict[str, Any]]]:
    """Keys of a body that have values over temperature, and these."""
    for key in CONSTANTS:
        value = body.get(key)
        if not isinstance(value, Mapping):
            continue
        if "temperatures" in value or "values" in value:
            yield (key,), dict(value)
        for name, item in value.items():
            if isinstance(item, Mapping) and "temperatures" in item:
                yield (key, str(name)), dict(item)


def _at(
    path: Path, key: Key, source: Path, body: str, temperature: Any, table: Mapping[str, Any]
) -> Any:
    """A constant at the temperature of its body."""
    try:
        curve = OverTemperature.model_validate(table)
    except ValidationError as error:
        problems = field_problems(error, OverTemperature)
        lines = (complaint(path, (*key, *each.key), each.text) for each in problems)
        raise CaseError("\n".join(lines)) from None
    low, high = curve.temperatures[0], curve.temperatures[-1]
    number = isinstance(temperature, int | float) and not isinstance(temperature, bool)
    if not (number and low <= temperature <= high):
        shown = "none" if temperature is None else found(temperature)
        text = (
            f"expected a temperature from {low:g} to {high:g} °C, those of {key[-1]!r}, at which "
            f"the constants are taken, found {shown}"
        )
        raise CaseError(complaint(source, ("bodies", body, "temperature"), text))
    return curve.at(float(temperature))


def _converted(
    data: Mapping[str, Any], source: Path, body: str, material: MaterialFile
) -> dict[str, Any]:
    """Constants of a material in the units of a case."""
    units = data.get("units", {})
    units = dict(units) if isinstance(units, Mapping) else {}
    given = {"length": LENGTH, "force": FORCE, "stress": stress_label(units), "time": "s"} | units
    sizes = {}
    for key, known in zip(given, (METRES, FORCES, STRESSES, TIMES), strict=False):
        if not isinstance(given[key], str) or given[key] not in known:
            text = (
                f"expected one of {', '.join(known)}, to which the constants of the material of "
                f"bodies.{body} are converted, found {found(given[key])}"
            )
            raise CaseError(complaint(source, ("units", key), text))
        sizes[key] = known[given[key]]
    stress = STRESSES[material.units.stress] / sizes["stress"]
    mass = sizes["force"] * sizes["time"] ** 2 / sizes["length"]
    density = DENSITIES.get(material.units.density or "", 1.0) * sizes["length"] ** 3 / mass
    factors = dict.fromkeys(PURE, 1.0) | {"density": density}
    return {
        key: _scaled(value, factors.get(key, stress)) for key, value in material.constants.items()
    }


def _scaled(value: Any, factor: float) -> Any:
    """Numbers of a table times a factor, but not temperatures and Poisson's ratios."""
    if isinstance(value, Mapping):
        kept = ("temperatures", "poisson")
        return {k: v if k in kept else _scaled(v, factor) for k, v in value.items()}
    if isinstance(value, list):
        return [_scaled(each, factor) for each in value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * factor if number and factor != 1 else value


def _shown(body: Mapping[str, Any]) -> str:
    """Constants of a body, in words."""
    texts = [
        f"{key} = {rounded(body[key], 4)}"
        for key in CONSTANTS
        if isinstance(body.get(key), int | float) and not isinstance(body[key], bool)
    ]
    return f": {', '.join(texts)}" if texts else ""


def case_notes(case: Case) -> tuple[str, ...]:
    """Things in a case that a reader of its results should know, in words."""
    return (*unit_doubts(case), *_friction_doubts(case), *case.material_notes)


def _friction_doubts(case: Case) -> Iterator[str]:
    """Coefficients of friction that nobody measures, in words."""
    for name, contact in case.contacts.items():
        if contact.largest_friction > LARGEST_FRICTION:
            yield (
                f"contacts.{name}.friction: {contact.largest_friction:g} is more than is measured, "
                f"up to {LARGEST_FRICTION:g}"
            )
