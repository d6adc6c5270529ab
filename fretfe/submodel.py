# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case of a part of a solved case, around one of its contacts, on a finer mesh.

The displacements of the run move the boundaries along which the part is cut out. Loads and supports
within the part are those of the run; those outside of it have done their work in that run.
"""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from fretfe._typing import Array
from fretfe.case import Case, parse_case
from fretfe.case.base import CAD, file_kind
from fretfe.case.loads import (
    DisplacementLoad,
    FieldLoad,
    ForceLoad,
    InterferenceLoad,
    Load,
    ShapeLoad,
    TractionLoad,
)
from fretfe.errors import CaseError, OutputError
from fretfe.files import disk_reason, replace_text
from fretfe.mesh.load import made_mesh, size_key
from fretfe.mesh.mesh import Mesh, place_text
from fretfe.mesh.part import cut_name, seen
from fretfe.quality.global_run import pressed_nodes
from fretfe.results.field_files import FIELDS, FieldReader
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

CASE, HISTORY = "submodel.toml", "history.csv"
# By it a file is known as one that may be replaced.
FIRST_LINE = "# A part of a solved case, written by fretfe submodel."
TIME, POSITION = "time", "position"
# Distance of the cut over that of the edges of the contact from the middle, where none is asked
# for; elements of the run over those of the part.
FAR, FINER = 3.0, 4.0
# Elements between middle and edge of a contact that show what is near it.
FEW = 10
# Times closer than this, relative to the last one, are the same.
SAME_TIME = 1e-9


@dataclass(frozen=True)
class Submodel:
    """A written case of a part.

    Attributes:
        path: of the case file.
        case: in it.
        centre: of the part, 2 coordinates of a circle or cylinder, 3 of a ball.
        radius: of the part.
        reach: distance from the centre of the farthest node of its contact that was ever pressed.
        size: key and value of its element size; empty and NaN where there is none.
        left_out: what of the case is not in the part, and why, in words.
    """

    path: Path
    case: Case
    centre: tuple[float, ...]
    radius: float
    reach: float
    size: tuple[str, float]
    left_out: tuple[str, ...]


def write_submodel(
    result: Result,
    around: str,
    output: Path,
    radius: float | None = None,
    size: float | None = None,
    *,
    trust_geo: bool = False,
) -> Submodel:
    """Write the case of the part of a solved case around one of its contacts.

    Args:
        result: with all of its steps, and a folder that has the displacements of all of them.
        around: contact, edge or station, as for `Result.find`.
        output: folder for the files.
        radius: of the part; None for three times the distance of the edges from the middle.
        size: of the elements at contact edges; None for a quarter of those of the run.
        trust_geo: whether a .geo file of the case may run.

    Raises:
        CaseError: if there is no such contact, or a part of the case cannot be cut.
        OutputError: if the results are not complete, or files cannot be read or written.
        MeshError: if there is no mesh of the part.
    """
    folder = _require_fields(result)
    name, centre = _place(result, around)
    distance = _reach(result, name, centre)
    wanted = FAR * distance if radius is None else radius
    _require_one_contact(result, name, centre, wanted)
    tables, known_size = _finer(result, size)
    pair = result.contact_history(name).pair
    tables["geometry"]["part"] = {"centre": list(centre), "radius": float(wanted)}
    tables["contacts"] = {pair: tables["contacts"][pair]}
    tables = {key: value for key, value in tables.items() if key not in ("supports", "loads")}
    bare = {**tables, "symmetry": {}, "output": {}}
    if result.case.geometry.file is not None and file_kind(result.case.geometry.file) is CAD:
        # One that refines itself has no size; any shows which boundaries are there.
        bare["geometry"] = {"size": distance / FEW, **tables["geometry"]}
    part = made_mesh(parse_case(bare, result.case.source, trust_geo=trust_geo))
    if not any(cut_name(name) in body.boundaries for name, body in part.bodies.items()):
        raise CaseError(
            f"--radius: expected one that cuts a body, found {wanted:.4g}, within which all of "
            f"{' and '.join(part.bodies)} is"
        )
    builder = _Builder(result.case, part, pair, tables)
    data = builder.tables(folder, output, result.loads.cycle, result.loads.times)
    path = output / CASE
    case = parse_case(data, path, trust_geo=trust_geo)
    _write(path, data, _history(result, case))
    return Submodel(path, case, centre, wanted, distance, known_size, tuple(builder.left_out))


def _require_fields(result: Result) -> Path:
    """The folder of a result, which has displacements of all states.

    Raises:
        OutputError: says what is missing.
    """
    where = result.directory
    if result.failure is not None or where is None:
        found = result.failure or "none that were written"
        raise OutputError(
            f"{where or result.case.source}: expected complete results, found {found}"
        )
    remedy = 'run the case with [output] fields = "all"'
    if not (where / FIELDS).is_file():
        raise OutputError(
            f"{where}: expected the displacements of the run ({FIELDS}), found none: {remedy}"
        )
    times, wanted = FieldReader(where / FIELDS).times, result.loads.times[1:]
    near = SAME_TIME * float(wanted[-1])
    missing = [time for time in wanted if not (np.abs(times - time) <= near).any()]
    if missing:
        raise OutputError(
            f"{where / FIELDS}: expected the displacements of all {len(wanted)} states, found none "
            f"of {len(missing)} of them, the first at {missing[0]:g}: {remedy}"
        )
    return where


def _pressed(result: Result, name: str) -> Array:
    """(n, d) nodes of a contact that are under pressure in some state."""
    history = result.contact_history(name)
    return history.points[pressed_nodes([history])]


def _place(result: Result, around: str) -> tuple[str, tuple[float, ...]]:
    """Name of a contact, and the middle of what of it was ever pressed, or one of its stations."""
    case = result.case
    solid = case.geometry.solid is not None
    if around in [each.name for each in result.contacts]:
        points = _pressed(result, around)
        if not len(points):
            raise CaseError(f"{result.directory}: expected a contact that carries a force, found "
                            f"that {around!r} never does")  # fmt: skip
        points = seen(case, points, 2 if solid else points.shape[1])
        centre = (points.min(axis=0) + points.max(axis=0)) / 2
        return around, _rounded(centre, float(np.ptp(points, axis=0).max()))
    contact, _, station = result.find(around)
    count = 3 if contact.solid else 2
    size = float(np.ptp(_pressed(result, contact.name), axis=0).max())
    return contact.name, _rounded(station.point[:count], size)


def _rounded(place: Array, size: float) -> tuple[float, ...]:
    """Coordinates of a place with as many digits as a length needs that is known to a millionth."""
    digits = 6 - math.floor(math.log10(size))
    return tuple(round(float(each), digits) + 0.0 for each in place)


def _reach(result: Result, name: str, centre: tuple[float, ...]) -> float:
    points = seen(result.case, _pressed(result, name), len(centre))
    return float(np.linalg.norm(points - np.array(centre), axis=1).max())


def _require_one_contact(
    result: Result, name: str, centre: tuple[float, ...], radius: float
) -> None:
    """Check that no other contact presses within the part: there the cut would open it.

    Raises:
        CaseError: with the largest radius that there may be.
    """
    assert result.solution is not None
    for other in result.solution.contacts:
        if other.pair == result.contact_history(name).pair:
            continue
        points = _pressed(result, other.name)
        if not len(points):
            continue
        away = np.linalg.norm(seen(result.case, points, len(centre)) - np.array(centre), axis=1)
        if away.min() <= radius:
            raise CaseError(
                f"--radius: expected less than {away.min():.4g}, where contact {other.name!r} "
                f"presses (a part has one contact), found {radius:.4g}"
            )


def _finer(result: Result, size: float | None) -> tuple[dict[str, Any], tuple[str, float]]:
    """Tables of the case of a run with smaller elements, and the key and size of these.

    Raises:
        CaseError: if a mesh file is to have smaller elements.
    """
    case = result.case
    tables = case.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    key, now = size_key(case)
    if case.geometry.file is not None and file_kind(case.geometry.file) is CAD:
        key = "geometry.size"
    if not key and size is not None:
        raise CaseError(
            f"--size: expected none, because {case.geometry.file} is a mesh, whose elements stay "
            f"as they are, found {size:g}: mesh the part yourself"
        )
    refines = case.edges.tolerance is not None
    if not key or (refines and size is None):
        return tables, ("", math.nan)
    if refines:
        tables["edges"].pop("tolerance")
    finer = float(f"{now / FINER:.3g}") if size is None else size
    *path, last = key.split(".")
    place = tables
    for each in path:
        place = place.setdefault(each, {})
    place[last] = finer
    return tables, (key, finer)


def _write(path: Path, data: dict[str, Any], history: str) -> None:
    """Write case and histories in place of those of another sub-model.

    Raises:
        OutputError: if there is another file with this name, or they cannot be written.
    """
    prepare_other(path.parent)
    try:
        if path.exists() and not path.read_text("utf-8").startswith(FIRST_LINE):
            raise OutputError(f"{path}: expected no such file, or a sub-model, found another case")
        replace_text(path.parent / HISTORY, history)
        replace_text(path, f"{FIRST_LINE}\n{tomli_w.dumps(data)}")
    except (OSError, UnicodeDecodeError) as error:
        reason = disk_reason(error) if isinstance(error, OSError) else "there is another file"
        raise OutputError(f"{path}: cannot be written: {reason}") from error


def _history(result: Result, case: Case) -> str:
    """Times of the states of a run, the same as positions in it, and the values of its loads."""
    loads = result.loads
    kept = [n for n, name in enumerate(loads.channels)
            if name in case.loads and not isinstance(case.loads[name], FieldLoad)]  # fmt: skip
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([TIME, POSITION, *(loads.channels[n] for n in kept)])
    for time, values in zip(loads.times[1:], loads.values[1:], strict=True):
        writer.writerow([repr(float(each)) for each in (time, time, *values[kept])])
    return text.getvalue()


class _Builder:
    """Tables of the case of a part; what does not belong to it is told.

    Args:
        case: of the run.
        part: mesh of the part.
        pair: name of its contact.
        tables: of the case, without supports and loads.
    """

    def __init__(self, case: Case, part: Mesh, pair: str, tables: dict[str, Any]) -> None:
        self._case, self._part, self._pair, self._tables = case, part, pair, tables
        self.left_out: list[str] = []

    def tables(
        self, folder: Path, output: Path, cycle: tuple[int, int] | None, times: Array
    ) -> dict[str, Any]:
        """The whole case.

        Args:
            folder: of the run.
            output: of the case.
            cycle: first and last state of the evaluated cycle.
            times: (T,) of the states.
        """
        case, data = self._case, dict(self._tables)
        data["title"] = f"Part of: {case.title}" if case.title else "Part of a solved case"
        data["bodies"] = {name: data["bodies"][name] for name in self._part.bodies}
        self._say("body", case.bodies, data["bodies"])
        self._say("contact", case.contacts, data["contacts"])
        self._require_no_sides()
        data.pop("symmetry", None)
        geometry = data["geometry"]
        for key in ("file", "facets"):
            if key in geometry:
                geometry[key] = _relative(case.resolve(geometry[key]), output)
        data["supports"] = {
            name: support.model_dump(mode="json", exclude_unset=True, exclude_none=True)
            for name, support in case.supports.items()
            if self._has(support.boundary)
        }
        self._say("support", case.supports, data["supports"])
        loads = {name: self._load(name, load, output) for name, load in case.loads.items()
                 if self._acts(name, load)}  # fmt: skip
        self._say("load", case.loads, loads)
        for body in self._cut_bodies():
            loads[cut_name(body)] = {
                "type": "field", "boundary": cut_name(body), "file": _relative(folder, output),
                "history": [_segment(POSITION)],
            }  # fmt: skip
        data["loads"] = loads
        data.pop("cycle", None)
        if cycle is not None:
            first, last = (float(times[state]) for state in cycle)
            data["cycle"] = {"start": first, "end": last}
        if not data.get("output", {}).pop("fields", None) or not data["output"]:
            data.pop("output", None)
        return data

    def _say(self, what: str, before: Any, after: Any) -> None:
        gone = [name for name in before if name not in after]
        if gone:
            plural = {"body": "bodies"}.get(what, f"{what}s") if len(gone) > 1 else what
            self.left_out.append(f"{plural} {', '.join(gone)}")

    def _cut_bodies(self) -> list[str]:
        return [name for name, body in self._part.bodies.items()
                if cut_name(name) in body.boundaries]  # fmt: skip

    def _has(self, boundary: str) -> bool:
        return any(boundary in body.boundaries for body in self._part.bodies.values())

    def _leans(self) -> bool:
        solid = self._case.geometry.solid
        return solid is not None and solid.skew != 0

    def _whole(self, boundary: str) -> bool:
        """True if a boundary in the part does not meet a cut, so that all of it is there."""
        for name, body in self._part.bodies.items():
            if boundary in body.boundaries and cut_name(name) in body.boundaries:
                meet = np.intersect1d(body.boundaries[boundary], body.boundaries[cut_name(name)])
                if len(meet):
                    return False
        return True

    def _require_no_sides(self) -> None:
        """Check that the part stays away from the sides of a sector.

        Raises:
            CaseError: if it has some of them, or if the sector leans and therefore bends.
        """
        for name, symmetry in self._case.symmetry.items():
            if self._leans():
                raise CaseError(
                    f"{self._case.source}: symmetry.{name}: expected no sector of extruded bodies "
                    "that lean (geometry.solid.skew): they are bent between contacts and sides, "
                    "which a part without its sides would not be"
                )
            if any(self._has(side) for side in (symmetry.boundary1, symmetry.boundary2)):
                raise CaseError(
                    f"--radius: expected a part without the sides of the sector, found some of "
                    f"those of symmetry.{name} within it: take a smaller one"
                )

    def _acts(self, name: str, load: Load) -> bool:
        """True if a load belongs to the part.

        Raises:
            CaseError: if it does, but cannot act on a part of its boundary.
        """
        if isinstance(load, InterferenceLoad):
            return load.contact == self._pair
        boundary = getattr(load, "boundary", None)
        if boundary is None:  # in the volume
            bodies = getattr(load, "bodies", None) or tuple(self._case.bodies)
            surfaces = getattr(load, "surfaces", None)
            return any(body in self._part.bodies for body in bodies) and (
                surfaces is None or any(map(self._has, surfaces))
            )
        cuts = [cut_name(body) for body in self._part.bodies]
        if not self._has(boundary) or (isinstance(load, FieldLoad) and boundary in cuts):
            return False
        anywhere = TractionLoad | DisplacementLoad | ShapeLoad | FieldLoad
        if not isinstance(load, anywhere) and not self._whole(boundary):
            kind = "a force spread over" if isinstance(load, ForceLoad) else "one rigid piece,"
            raise CaseError(
                f"--radius: expected all or nothing of the boundary {boundary!r} within the part, "
                f"because loads.{name} is {kind} all of it, found a part of it: take another radius"
            )
        return True

    def _load(self, name: str, load: Load, output: Path) -> dict[str, Any]:
        """Table of a load that belongs to the part; its history is that of the run."""
        table = load.model_dump(mode="json", exclude_unset=True, exclude_none=True)
        if "file" in table:
            table["file"] = _relative(self._case.resolve(table["file"]), output)
        if "bodies" in table:
            table["bodies"] = [each for each in table["bodies"] if each in self._part.bodies]
        if "surfaces" in table:
            table["surfaces"] = [each for each in table["surfaces"] if self._has(each)]
        return {**table, "history": [_segment(name)]}


def _segment(column: str) -> dict[str, Any]:
    return {"csv": HISTORY, "time": TIME, "value": column}


def _relative(path: Path, output: Path) -> str:
    return os.path.relpath(path.resolve(), output.resolve())


def told(found: Submodel, length: str) -> Iterator[str]:
    """A sub-model in words, for its user."""
    what = "a circle" if len(found.centre) == 2 else "a ball"
    if found.case.geometry.solid is not None and len(found.centre) == 2:
        what = "a cylinder along the extrusion"
    yield (
        f"Part within {what} of radius {found.radius:.4g} {length} around "
        f"{place_text(np.array(found.centre))}; the contact reaches {found.reach:.4g} {length} "
        "from there"
    )
    if found.size[0]:
        yield f"{found.size[0]} = {found.size[1]:g} {length}"
    elif found.case.edges.tolerance is None:
        yield "The elements are those of the run, whose mesh is a file: mesh the part yourself"
    if found.radius < found.reach:
        yield (
            "Warning: the cut runs through the contact. Its edges at the cut are none of the "
            "contact; the others count"
        )
    if found.left_out:
        yield f"Outside of the part: {'; '.join(found.left_out)}"
