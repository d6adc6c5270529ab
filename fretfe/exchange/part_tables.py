# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of the case of a part: what of the case of a run belongs to it."""

from __future__ import annotations

import math
import os
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.case.base import CAD, file_kind
from fretfe.case.loads import Load
from fretfe.errors import CaseError
from fretfe.mesh.load import size_key
from fretfe.mesh.mesh import Mesh
from fretfe.mesh.part import cut_name
from fretfe.results.front_ends import FrontEnd
from fretfe.results.model import Result

# Times of the states of a run, the same as positions in it, and the values of its loads.
HISTORY = "history.csv"
TIME = "time"
POSITION = "position"


def finer_tables(
    result: Result, size: float | None, finer: float
) -> tuple[dict[str, Any], tuple[str, float]]:
    """Tables of the case of a run with smaller elements, and the key and size of these.

    A run of the whole may leave out the plane problems next to its stations (`edges.local`); those
    of the part are what it is for.

    Args:
        result: of the run.
        size: of the elements of the part; None for those of the run over `finer`.
        finer: elements of the run over those of the part.

    Raises:
        CaseError: if a mesh file is to have smaller elements.
    """
    case = result.case
    tables = case.as_tables()
    tables.get("edges", {}).pop("local", None)
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
    wanted = float(f"{now / finer:.3g}") if size is None else size
    _set(tables, key, wanted)
    return tables, (key, wanted)


def _set(tables: dict[str, Any], key: str, value: float) -> None:
    *path, last = key.split(".")
    for each in path:
        tables = tables.setdefault(each, {})
    tables[last] = value


def fine_at(
    end: FrontEnd, data: dict[str, Any], size: tuple[str, float], times: float
) -> dict[str, Any]:
    """The case of a part of extruded bodies with thin layers around a free end of a front.

    The first layer is as thick as an element of the run across the front is long, the thickest is
    a twelfth of the radius of the part.

    Args:
        end: the free end.
        data: tables of a case with elements of one size throughout.
        size: its key and value.
        times: larger elements, across the front and along it.
    """
    data = deepcopy(data)
    # Plane problems say little there, and factors of more stations cost more than the steps.
    edges = data.setdefault("edges", {})
    edges |= {"local": False, "stations": min(edges.get("stations", 16), 16)}
    edges.pop("ends", None)
    data.get("output", {}).pop("tractions", None)
    if times > 1:  # nobody looks at the fields and the stress of a second level
        data["output"] = {"fields": "none"}
    if size[0]:
        _set(data, size[0], size[1] * times)
    solid, radius = data["geometry"]["solid"], data["geometry"]["part"]["radius"]
    solid["layers"] = math.ceil(12 * solid["length"] / (radius * times))
    first = float(f"{end.station.size * times:.3g}")
    solid["end_size"] = min(first, solid["length"] / solid["layers"])
    return data


class PartTables:
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
        contact = data["contacts"][self._pair]
        tables = (contact["friction"], "csv"), (contact.get("layer"), "csv"), (contact, "gap")
        for table, key in tables:
            if isinstance(table, dict) and key in table:
                table[key] = _relative(case.resolve(table[key]), output)
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
        data.get("output", {}).pop("fields", None)
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
        if load.closes:
            return load.closes == self._pair
        if not load.on:  # in the volume
            bodies = load.within or tuple(self._case.bodies)
            surfaces = getattr(load, "surfaces", None)
            return any(body in self._part.bodies for body in bodies) and (
                surfaces is None or any(map(self._has, surfaces))
            )
        cuts = [cut_name(body) for body in self._part.bodies]
        if not self._has(load.on) or (name in self._case.cut_loads and load.on in cuts):
            return False
        if load.undivided and not self._whole(load.on):
            raise CaseError(
                f"--radius: expected all or nothing of the boundary {load.on!r} within the part, "
                f"because loads.{name} is {load.undivided} all of it, found a part of it: take "
                "another radius"
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
