# SPDX-License-Identifier: LGPL-3.0-or-later
"""Reading a case file, with every problem at once, writing it, and checks against its mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, cast

import tomli_w
from pydantic import TypeAdapter, ValidationError

from fretfe.case.base import AXES, CAD, FILE_KINDS, Name, Table
from fretfe.case.bodies import AnyBody, isotropic
from fretfe.case.loads import Along, AnyLoad, Load
from fretfe.case.materials import with_constants
from fretfe.case.messages import complaint, field_problems
from fretfe.case.model import Case, Key, Problem, cross_problems
from fretfe.case.overrides import with_overrides
from fretfe.case.tables import Contact, Support, Symmetry, TiedParts
from fretfe.case.toml_file import read_tables
from fretfe.errors import CaseError
from fretfe.terminal import one_line

# Accuracy of edge factors of CAD files for which no element size is given.
OF_CAD = 0.1


def load_case(
    path: Path | str | Mapping[str, Any],
    overrides: Mapping[str, Any] | None = None,
    *,
    trust_geo: bool = False,
) -> Case:
    """Read and validate a case file.

    Args:
        path: the TOML file, or its tables as a mapping; files that these name are relative to the
            working folder.
        overrides: values in place of those of the file, by paths like ``contacts.main.friction``.
        trust_geo: whether a .geo file that the case names may run. Such a script can do whatever
            the user can.

    Raises:
        CaseError: the file cannot be read, is not TOML, or is not a valid case. The message has one
            line per problem: file, key, what was expected and what was found.
    """
    if isinstance(path, Mapping):
        source = Path("case.toml")
        tables = with_overrides({**path}, overrides or {}, source)
        return parse_case(tables, source, trust_geo=trust_geo)
    source = Path(path)
    for kind in FILE_KINDS:
        if source.suffix.lower() in kind.suffixes:
            ways = (
                f", with bodies and boundaries of it chosen by {' or '.join(kind.ways)} in "
                "[geometry.bodies] and [geometry.boundaries]"
                if kind.named
                else ""
            )
            raise CaseError(
                f"{source}: expected a case file (TOML), found a {kind.text}: write one beside it "
                f'with [geometry] file = "{source.name}"{ways}, and with materials, contacts, '
                "supports and loads"
            )
    data = read_tables(source, "a case file (TOML)")
    return parse_case(with_overrides(data, overrides or {}, source), source, trust_geo=trust_geo)


def changed(case: Case, overrides: Mapping[str, Any]) -> Case:
    """A case with other values.

    Args:
        case: the case; not changed.
        overrides: as in ``load_case``.

    Raises:
        CaseError: as ``load_case``.
    """
    data = case.as_tables()
    if case.given is not None:
        data["bodies"] = case.given.bodies
    return parse_case(
        with_overrides(data, overrides, case.source), case.source, trust_geo=case.trust_geo
    )


def parse_case(
    data: Mapping[str, Any], source: Path | str = "case.toml", *, trust_geo: bool = False
) -> Case:
    """Validate the contents of a case file.

    Args:
        data: tables and values as TOML has them.
        source: name of the case file for messages; files that the case names are relative to its
            folder.
        trust_geo: as in ``load_case``.

    Raises:
        CaseError: as ``load_case``.
    """
    data, given = with_constants(_with_accuracy(data), Path(source))
    try:
        case = Case.model_validate(data)
    except ValidationError as error:
        problems = field_problems(error)
        # Contradictions among the tables that are valid are shown even if other tables are not;
        # when the validation came as far as that, they are among the problems already.
        problems += [each for each in _partial_cross_problems(data) if each not in problems]
        lines = [complaint(Path(source), *problem) for problem in problems]
        raise CaseError("\n".join(lines)) from None
    case._source = Path(source)
    case._trust_geo = trust_geo
    case._given = given
    return case


def _partial_cross_problems(data: Mapping[str, Any]) -> list[Problem]:
    return cross_problems(
        cast("dict[str, AnyBody]", _valid_entries(AnyBody, data.get("bodies"))),
        cast("dict[str, Contact]", _valid_entries(Contact, data.get("contacts"))),
        cast("dict[str, Support]", _valid_entries(Support, data.get("supports"))),
        cast("dict[str, Load]", _valid_entries(AnyLoad, data.get("loads"))),
        cast("dict[str, Symmetry]", _valid_entries(Symmetry, data.get("symmetry"))),
        cast("dict[str, TiedParts]", _valid_entries(TiedParts, data.get("ties"))),
    )


def _valid_entries(kind: Any, section: Any) -> dict[str, Table]:
    adapter: TypeAdapter[dict[str, Table]] = TypeAdapter(dict[Name, kind])
    entries: dict[str, Table] = {}
    for name, entry in section.items() if isinstance(section, Mapping) else ():
        try:
            entries |= adapter.validate_python({name: entry})
        except ValidationError:
            continue
    return entries


def _with_accuracy(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Tables of a case with the accuracy that CAD files without an element size are meshed for."""
    geometry, edges = data.get("geometry"), data.get("edges", {})
    if not isinstance(geometry, Mapping) or not isinstance(edges, Mapping) or "start" in data:
        return data
    file = geometry.get("file")
    is_cad = isinstance(file, str) and Path(file).suffix.lower() in CAD.suffixes
    if not is_cad or {"size", "part"} & geometry.keys():
        return data
    return {**data, "edges": {"tolerance": OF_CAD, **edges}}


def case_text(case: Case) -> str:
    """The case as run, as TOML.

    The text of the case file itself if it says the same and names no files relative to its folder.
    Else the case without comments, the files that it names with their full paths, and numbers in
    place of materials and tables over temperature.
    """
    data = with_full_paths(case)
    if case.given is None and as_written(case) and data == case.as_tables():
        return case.source.read_text("utf-8-sig")
    head = ("The case as run, written by fretfe.", *case.material_notes)
    return "".join(f"# {one_line(line)}\n" for line in head) + tomli_w.dumps(data)


def as_written(case: Case) -> bool:
    """True if the case is what its file says; false if it was not read from a file."""
    try:
        return load_case(case.source).as_tables() == case.as_tables()
    except CaseError:
        return False


def with_full_paths(case: Case) -> dict[str, Any]:
    """The keys that are set, in plain types, and files with their full paths."""
    data = case.as_tables()
    for key, path in named_files(case).items():
        table: Any = data
        for part in key[:-1]:
            table = table[part]
        table[key[-1]] = str(path)
    return data


def named_files(case: Case) -> dict[Key, Path]:
    """Full paths of the files and folders that a case names, by key; not those of materials."""
    data = case.as_tables()
    tables: list[tuple[Key, Any]] = [(("geometry",), data["geometry"])]
    for name, load in data.get("loads", {}).items():
        tables.append((("loads", name), load))
        segments = enumerate(load["history"])
        tables += [(("loads", name, "history", number), each) for number, each in segments]
    for name, contact in data["contacts"].items():
        if isinstance(contact["friction"], dict):
            tables.append((("contacts", name, "friction"), contact["friction"]))
        tables.append((("contacts", name), contact))
        tables.append((("contacts", name, "layer"), contact.get("layer") or {}))
    tables.append((("start",), data.get("start", {})))
    return {
        (*key, name): case.resolve(table[name]).absolute()
        for key, table in tables
        for name in ("file", "facets", "csv", "gap", "from")
        if name in table
    }


# Added to a complaint about a direction or a place.
PLANE = "; the mesh is plane, and [geometry.solid] would extrude it"
SOLID = "; the bodies are solid"


def check_dimension(case: Case, dimension: int) -> None:
    """Check that every direction of the case exists in the space of the mesh.

    Args:
        case: the case.
        dimension: number of coordinates of the mesh, 2 or 3.

    Raises:
        CaseError: an axis or a vector does not fit; all of them are listed.
    """
    lines = [complaint(case.source, *problem) for problem in _misfits(case, dimension)]
    if lines:
        raise CaseError("\n".join(lines))


def _misfits(case: Case, dimension: int) -> Iterator[Problem]:
    if dimension == 3:
        yield from _plane_only(case)
    elif case.cycle.more:
        text = f"expected none in the plane, where no cycles are added, found {case.cycle.more}"
        yield Problem(("cycle", "more"), text)
    components = case.components(dimension)
    # What holds crystals along z may stay where an orientation, as of a sweep, does not move them.
    crystals = any(isotropic(body) is None for body in case.bodies.values())
    for key, direction in _directions(case):
        if isinstance(direction, str):
            if direction in AXES[components:] and not (key[0] == "supports" and crystals):
                text = f"expected 'x' or 'y' on this mesh, found {direction!r}"
                yield Problem(key, text + PLANE)
        elif not dimension <= len(direction) <= components:
            yield Problem(key, _miscounted(dimension, direction))
    for key, place in _places(case):
        if len(place) != dimension:
            yield Problem(key, _miscounted(dimension, place))
    if dimension < components:
        yield from _in_plane_only(case)
    turning: list[tuple[Key, Along]] = [
        (("loads", name, "axis"), load.about)
        for name, load in case.loads.items()
        if load.about is not None
    ]
    turning += [(("symmetry", name, "axis"), each.axis) for name, each in case.symmetry.items()]
    for key, axis in turning:
        if not _is_axis(axis, dimension):
            expected = "[0, 0, 1] or [0, 0, -1]" if dimension == 2 else "3 components"
            found = repr(axis) if isinstance(axis, str) else str(list(axis))
            yield Problem(key, f"expected {expected}, found {found}")


def _miscounted(dimension: int, found: tuple[float, ...]) -> str:
    text = f"expected {dimension} components on this mesh, found {len(found)}"
    return text + (PLANE if dimension == 2 else SOLID)


def _in_plane_only(case: Case) -> Iterator[Problem]:
    """Tables that do not fit displacements along z in the plane."""
    keys = list(case.moving_across())
    if case.model.plane == "stress":
        text = (
            "expected nothing that moves plane bodies along z, which they do in plane strain only"
        )
        yield from (Problem(key, text + PLANE) for key in keys)
    because = f"displacements along z, which {'.'.join(map(str, keys[0]))} brings in"
    for name, load in case.loads.items():
        if load.by_shape:
            text = f"expected a load with {because}, found {load.title}, which has none of them"
            yield Problem(("loads", name, "type"), text)


def _plane_only(case: Case) -> Iterator[Problem]:
    """Keys that mean nothing, or nothing yet, on a mesh of solids."""
    if case.model.plane != "strain":
        yield Problem(("model", "plane"), "expected no plane state on a mesh of solids")
    if case.model.thickness != 1:
        found = f"{case.model.thickness:g}"
        yield Problem(("model", "thickness"), f"expected 1 on a mesh of solids, found {found}")


def _is_axis(axis: Along, dimension: int) -> bool:
    """True if bodies can turn about an axis: in the plane about z only."""
    if isinstance(axis, str):
        return dimension == 3 or axis == "z"
    return len(axis) == 3 and (dimension == 3 or axis[:2] == (0, 0))


def _directions(case: Case) -> Iterator[tuple[Key, Along]]:
    for name, support in case.supports.items():
        axes = ((i, axis) for i, axis in enumerate(support.fix) if axis in AXES)
        yield from ((("supports", name, "fix", i), axis) for i, axis in axes)
        if support.direction is not None:
            yield ("supports", name, "direction"), support.direction
    for name, load in case.loads.items():
        if load.along is not None:
            yield ("loads", name, "direction"), load.along


def _places(case: Case) -> Iterator[tuple[Key, tuple[float, ...]]]:
    for name, sector in case.symmetry.items():
        yield ("symmetry", name, "centre"), sector.centre
    for name, load in case.loads.items():
        yield from ((("loads", name, *key), place) for key, place in load.places.items())
