# SPDX-License-Identifier: LGPL-3.0-or-later
"""Writes the case of a part of a solved case, around one of its contacts, on a finer mesh.

The displacements of the run move the boundaries along which the part is cut out. Loads and supports
within the part are those of the run; those outside of it have done their work in that run.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from fretfe.case import Case, parse_case
from fretfe.case.base import CAD, file_kind, positive_number
from fretfe.errors import CaseError, OutputError
from fretfe.exchange.part_place import (
    driving_states,
    place_of,
    reach_of,
    require_fields,
    require_one_contact,
)
from fretfe.exchange.part_tables import HISTORY, POSITION, TIME, PartTables, fine_at, finer_tables
from fretfe.files import disk_reason, replace_text
from fretfe.mesh.load import made_mesh
from fretfe.mesh.mesh import Mesh, place_text
from fretfe.mesh.part import cut_name
from fretfe.results.front_ends import FrontEnd, find_end, zone_at
from fretfe.results.model import Result
from fretfe.results.writer import prepare_other

CASE = "submodel.toml"
# Around free ends: the same with elements twice as large.
COARSER = "coarser.toml"
# By it a file is known as one that may be replaced.
FIRST_LINE = "# A part of a solved case, written by fretfe submodel."
# Distance of the cut over that of the edges of the contact from the middle, if none is asked for.
FAR = 3.0
# Elements between middle and edge of a contact that show what is near it.
FEW = 10


@dataclass(frozen=True)
class Submodel:
    """A written case of a part.

    Attributes:
        cases: of the part; around a free end a second one with elements twice as large.
        centre: of the part, 2 coordinates of a circle or cylinder, 3 of a ball.
        radius: of the part.
        reach: distance from the centre of the farthest node of its contact that was ever pressed.
        size: key and value of its element size; empty and NaN where there is none.
        left_out: what of the case is not in the part, and why, in words.
        end: the free end that the part is around; None around anything else.
    """

    cases: tuple[Case, ...]
    centre: tuple[float, ...]
    radius: float
    reach: float
    size: tuple[str, float]
    left_out: tuple[str, ...]
    end: FrontEnd | None

    @property
    def case(self) -> Case:
        """The case with the smallest elements."""
        return self.cases[0]

    @property
    def path(self) -> Path:
        """Its file."""
        return self.case.source


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
        around: contact, edge or station, as for `Result.find`, or a free end, as for `find_end`.
        output: folder for the files.
        radius: of the part; None for three times the distance of the edges from the middle, around
            a free end for `radius_at`.
        size: of the elements at contact edges; None for a quarter of those of the run, around a
            free end for those over `finer_at`.
        trust_geo: whether a .geo file of the case may run.

    Raises:
        CaseError: if there is no such contact, or a part of the case cannot be cut.
        OutputError: if the results are not complete, or files cannot be read or written.
        MeshError: if there is no mesh of the part.
    """
    for option, value in (("--radius", radius), ("--size", size)):
        if value is not None:
            positive_number(option, value)
    folder, end = require_fields(result), find_end(result, around)
    if end is not None and size is None and result.case.edges.tolerance is not None:
        raise CaseError(
            "--size: expected that of the elements across the front, because those of the run were "
            "made for its edges.tolerance, found none"
        )
    name, centre = place_of(result, around, end)
    distance = reach_of(result, name, centre)
    wanted = radius
    if wanted is None:
        wanted = FAR * distance if end is None else radius_at(end)
    require_one_contact(result, name, centre, wanted)
    tables, known_size = finer_tables(result, size, 4.0 if end is None else finer_at(end))
    pair = result.contact_history(name).pair
    tables["geometry"]["part"] = {"centre": list(centre), "radius": float(wanted)}
    tables["contacts"] = {pair: tables["contacts"][pair]}
    tables = {key: value for key, value in tables.items() if key not in ("supports", "loads")}
    levels = {CASE: 1.0, COARSER: 2.0}
    bare = tables if end is None else fine_at(end, tables, known_size, levels[COARSER])
    part = _part(result, bare, distance, trust_geo=trust_geo)
    builder = PartTables(result.case, part, pair, tables)
    data = builder.tables(folder, output, result.loads.cycle, result.loads.times)
    cases = {CASE: data}
    if end is not None:
        cases = {name: fine_at(end, data, known_size, times) for name, times in levels.items()}
    made = tuple(
        parse_case(each, output / name, trust_geo=trust_geo) for name, each in cases.items()
    )
    _write(output, cases, _history(result, made[0]))
    return Submodel(made, centre, wanted, distance, known_size, tuple(builder.left_out), end)


def radius_at(end: FrontEnd) -> float:
    """Radius of the part around a free end, to the middle of a contact that is long beside d.

    Around contacts like those of cylinders, whose pressure falls over all of their width, it is two
    half-widths: there a cut changes ΔK_T by 0.9 %.
    """
    station = end.station
    return float(f"{max(station.depth, 2 * min(station.depth, station.length)):.3g}")


def finer_at(end: FrontEnd) -> float:
    """Elements of a run over those of the part around a free end.

    Those of the second level are twice as long: a contact of few elements would have no front. Slip
    at the edge, which grows to it within a zone, takes five elements of the first level there.
    """
    station, zone = end.station, zone_at(end)
    if station.depth <= 2 * FEW * station.size:
        return 2.0
    return min(max(1.4, 5 * station.size / zone), 3.0) if zone > 0 else 1.4


def _part(result: Result, tables: dict[str, Any], reach: float, *, trust_geo: bool) -> Mesh:
    """Mesh of a part, which shows the boundaries that are there.

    Args:
        result: of the whole.
        tables: of the case of the part, without supports and loads.
        reach: as of `Submodel`.
        trust_geo: as for `write_submodel`.

    Raises:
        CaseError: if nothing is cut off.
    """
    bare = {**tables, "symmetry": {}, "output": {}}
    if result.case.geometry.file is not None and file_kind(result.case.geometry.file) is CAD:
        # One that refines itself has no size; any shows which boundaries are there.
        bare["geometry"] = {"size": reach / FEW, **tables["geometry"]}
    part = made_mesh(parse_case(bare, result.case.source, trust_geo=trust_geo))
    if not any(cut_name(name) in body.boundaries for name, body in part.bodies.items()):
        radius = tables["geometry"]["part"]["radius"]
        raise CaseError(
            f"--radius: expected one that cuts a body, found {radius:.4g}, within which all of "
            f"{' and '.join(part.bodies)} is"
        )
    return part


def _write(folder: Path, cases: dict[str, dict[str, Any]], history: str) -> None:
    """Write cases, by the names of their files, and histories in place of another sub-model.

    Raises:
        OutputError: if there is another file with this name, or they cannot be written.
    """
    prepare_other(folder)
    path = folder / CASE
    try:
        for path in (folder / name for name in cases):
            if path.exists() and not path.read_text("utf-8").startswith(FIRST_LINE):
                raise OutputError(
                    f"{path}: expected no such file, or a sub-model, found another case"
                )
        replace_text(folder / HISTORY, history)
        for path, data in ((folder / name, data) for name, data in cases.items()):
            replace_text(path, f"{FIRST_LINE}\n{tomli_w.dumps(data)}")
    except (OSError, UnicodeDecodeError) as error:
        reason = disk_reason(error) if isinstance(error, OSError) else "there is another file"
        raise OutputError(f"{path}: cannot be written: {reason}") from error


def _history(result: Result, case: Case) -> str:
    """Times of the states of a run, the same as positions in it, and the values of its loads."""
    loads = result.loads
    kept = [n for n, name in enumerate(loads.channels)
            if name in case.loads and name not in case.cut_loads]  # fmt: skip
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([TIME, POSITION, *(loads.channels[n] for n in kept)])
    for state in driving_states(result):
        time, values = loads.times[state], loads.values[state, kept]
        writer.writerow([repr(float(each)) for each in (time, time, *values)])
    return text.getvalue()


def told(found: Submodel, length: str) -> Iterator[str]:
    """A sub-model in words, for its user."""
    what = "a circle" if len(found.centre) == 2 else "a ball"
    if found.case.geometry.solid is not None and len(found.centre) == 2:
        what = "a cylinder along the extrusion"
    place = f"Part within {what} of radius {found.radius:.4g} {length} around "
    where = place_text(np.array(found.centre))
    if found.end is None:
        yield f"{place}{where}; the contact reaches {found.reach:.4g} {length} from there"
    else:
        yield f"{place}the free end {found.end.name} at {where}"
    if found.size[0]:
        yield f"{found.size[0]} = {found.size[1]:g} {length}"
    elif found.case.edges.tolerance is None:
        yield "The elements are those of the run, whose mesh is a file: mesh the part yourself"
    if found.end is None and found.radius < found.reach:
        yield (
            "Warning: the cut runs through the contact. Its edges at the cut are none of the "
            "contact; the others count"
        )
    if found.left_out:
        yield f"Outside of the part: {'; '.join(found.left_out)}"
