# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files that a run leaves: `results.json` for numbers and histories, `results.h5` for arrays.

Contact surfaces of solids are in `contacts.hdf` too, for ParaView, the stations of all fronts in
`stations.csv`. Counted cycles of irregular loads are in `cycles.csv`.

Lists of more than `LONG` numbers, the histories of a long run, go to `results.h5` too.

The schema is described in docs/results.md. Numbers that do not exist are null in JSON and NaN in
HDF5. Everything is gathered here, on one process.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from fretfe._typing import Array, Indices
from fretfe.case.reading import with_full_paths
from fretfe.environment import versions
from fretfe.errors import CaseError, OutputError
from fretfe.evaluate.contacts import Contact, SlipZone, quantities
from fretfe.evaluate.refinement import Refinement
from fretfe.evaluate.resultants import load_extremes, station_extremes
from fretfe.evaluate.slip import cycle_states
from fretfe.faults import FAULTS, guarded
from fretfe.files import make_folder, replace_text, replacing, require_writable, writing
from fretfe.history.solution import ContactHistory, Solution
from fretfe.history.state_array import StateArray, states_in_block
from fretfe.mesh.mesh import BodyMesh
from fretfe.results.field_files import DISPLACEMENTS, FIELDS, SURFACES, write_surfaces
from fretfe.results.hdf5_file import STRESSES, new_hdf5, room, store
from fretfe.results.model import Result
from fretfe.results.run_folder import MARK, with_digest
from fretfe.results.station_stress import STATION_STRESSES
from fretfe.results.tables import CYCLES_FILE, NODAL, STATIONS_FILE, write_cycles, write_stations

SCHEMA = {"name": "fretfe-results", "version": 10}
NUMBERS = "results.json"
ARRAYS = "results.h5"
REPORT = "report.html"
# Of a sweep: table, picture, and the variants as they are solved.
TABLE = "sweep.csv"
FIGURE = "sweep.png"
VARIANTS = "variants.jsonl"
SWEEP_FILES = (TABLE, FIGURE, VARIANTS)
# Where pictures are in a results folder, and what lists them there.
PICTURES = "pictures"
PICTURE_LIST = "pictures.json"
# Folder with one for each free end around which parts were solved, and the file in it.
ENDS = "ends"
ANSWER = "end.json"
# Files of a run beside its pictures, the numbers first.
RESULT_FILES = (
    NUMBERS,
    ARRAYS,
    SURFACES,
    STATIONS_FILE,
    CYCLES_FILE,
    FIELDS,
    DISPLACEMENTS,
    STRESSES,
    STATION_STRESSES,
    REPORT,
    FAULTS,
)
REFINING = "the mesh was still refining itself"
# Parts of a block of states, each with a checksum of its own.
PARTS = 8
# Histories of more states are long: their tractions are not all kept unless the case asks for that,
# and lists of more numbers do not stand in the text of the results.
LONG = 1000
# Half cycles whose ends are kept: those whose slip zones are printed.
HALF_CYCLES = 2
# In place of a list that is in `ARRAYS`: this, and the name of its data set there.
ELSEWHERE = f"{ARRAYS}:"
# A contact without its name, which is its key; of solids with the work along its fronts.
CONTACT_KEYS = [each.name for each in fields(Contact) if each.name != "name"]
CONTACT_KEYS += [name for name in quantities(Contact) if name not in CONTACT_KEYS]
ENCODER = json.JSONEncoder(allow_nan=False)


def prepare_directory(directory: Path) -> None:
    """Make the output folder and check that files can be written there.

    Raises:
        OutputError: if not.
    """
    try:
        make_folder(directory)
        require_writable(directory)
    except OSError as error:
        raise OutputError(
            f"{directory}: expected a folder that files can be written to, found: {error.strerror}"
        ) from error


def prepare_other(directory: Path) -> None:
    """Make a folder for files about results, which must not lie among those of a run.

    Raises:
        CaseError: if the folder holds results of a run.
        OutputError: as for `prepare_directory`.
    """
    prepare_directory(directory)
    found = next((name for name in (NUMBERS, MARK) if (directory / name).exists()), None)
    if found:
        raise CaseError(f"{directory}: expected a folder without results of a run, found {found}")


def remove_results(directory: Path, kept: str = "") -> None:
    """Remove numbers, arrays and fields of an earlier run, the numbers first.

    Args:
        directory: of the run.
        kept: name of a file that stays.

    Raises:
        OSError: if that fails.
    """
    for name in RESULT_FILES:
        if name != kept:
            (directory / name).unlink(missing_ok=True)
    for path in (directory / ENDS).glob(f"*/{ANSWER}"):
        path.unlink()


def remove_old_report(directory: Path) -> None:
    """Remove a report that is older than the numbers: it is one of an earlier run.

    Raises:
        OSError: if that fails.
    """
    report, numbers = directory / REPORT, directory / NUMBERS
    if report.exists() and numbers.exists():
        if report.stat().st_mtime_ns < numbers.stat().st_mtime_ns:
            report.unlink()


def remove_pictures(directory: Path) -> None:
    """Remove the pictures of an earlier run; other files stay."""
    folder = directory / PICTURES
    for path in [*folder.glob("*.png"), folder / PICTURE_LIST]:
        path.unlink(missing_ok=True)


def write_results(directory: Path, result: Result) -> None:
    """Write `results.json`; `results.h5`, of solids more.

    Args:
        directory: existing folder.
        result: of a run, with the name of its backend.

    Raises:
        OutputError: if a file cannot be written.
    """
    with writing(directory, "the results"):
        lists: dict[str, Array] = {}
        numbers = with_digest(as_numbers(result, lists))
        text = json_text(numbers)
        # The result may have been read from the file that is replaced: surfaces come before it.
        # What keeps them from being written must not keep the numbers from it.
        surfaces = partial(_write_surfaces, result=result)
        late = _failure(partial(_attempt, directory / SURFACES, surfaces))
        with replacing(directory / ARRAYS) as new:
            _write_arrays(new, result, lists)
        replace_text(directory / NUMBERS, text + "\n")
        _attempt(directory / STATIONS_FILE, lambda path: write_stations(path, result.contacts))
        times = result.loads.times
        _attempt(directory / CYCLES_FILE, lambda path: write_cycles(path, result.contacts, times))
        if late is not None:
            raise late


def json_text(value: Any, line: str = "\n") -> str:
    """Plain types as JSON, with lines for what has dictionaries in it; numbers stand on one line.

    Args:
        value: of plain types.
        line: a new one at the place of the value.
    """
    inner = f"{line} "
    if isinstance(value, dict) and any(isinstance(each, dict | list) for each in value.values()):
        items = (f"{json.dumps(name)}: {json_text(each, inner)}" for name, each in value.items())
        return f"{{{inner}{f',{inner}'.join(items)}{line}}}"
    if isinstance(value, list) and any(isinstance(each, dict) for each in value):
        return f"[{inner}{f',{inner}'.join(json_text(each, inner) for each in value)}{line}]"
    return ENCODER.encode(value)


def _attempt(path: Path, write: Callable[[Path], None]) -> None:
    """Write a file that others do without: an error of fretfe in it costs none of them."""

    def make() -> OSError | None:
        return _failure(partial(write, path))

    if (failed := guarded(path.name, make, lambda _: path.unlink(missing_ok=True))) is not None:
        raise failed


def _failure(write: Callable[[], None]) -> OSError | None:
    try:
        write()
    except OSError as error:
        return error
    return None


def _write_surfaces(path: Path, result: Result) -> None:
    """Write the contact surfaces of solids; of plane bodies there are none, nor any file."""
    solution = result.solution
    if solution.dimension == 3:
        with replacing(path) as new:
            write_surfaces(new, solution, kept_states(result, solution))
    else:
        path.unlink(missing_ok=True)


def _write_arrays(path: Path, result: Result, lists: Mapping[str, Array]) -> None:
    solution = result.solution
    with new_hdf5(path, SCHEMA) as file:
        store(file, "times", result.loads.times)
        for name, values in lists.items():
            store(file, name, values)
        states = kept_states(result, solution)
        store(file, "states", states)
        if solution.free is not None:
            store(file, "free", solution.free)
        for contact in solution.contacts:
            _write_contact(file.create_group(f"contacts/{contact.name}"), contact, states)
        for name, body in result.bodies.items():
            _write_mesh(file.create_group(f"mesh/{name}"), body)


def as_numbers(result: Result, lists: dict[str, Array]) -> dict[str, Any]:
    """Everything that `results.json` holds, in plain Python types.

    Args:
        result: of a run.
        lists: gets those of more than `LONG` numbers, by the names of their data sets.
    """
    case, loads = result.case, result.loads
    refined = result.refinement is None or bool(result.refinement.reason)
    return _Plain(lists)(
        {
            "schema": SCHEMA,
            "title": case.title,
            "units": case.units.model_dump(),
            "backend": result.backend,
            "headline": guarded("first lines", lambda: result.headline, lambda _: None),
            "notes": result.notes,
            "complete": result.failure is None and refined,
            "failure": str(result.failure or ("" if refined else REFINING)),
            "faults": result.faults,
            "versions": {**versions(), **result.versions},
            "ranks": result.ranks,
            "seconds": result.seconds,
            "case": with_full_paths(case),
            "limits": [
                {**asdict(limit), "consequence": limit.consequence, "exceeded": limit.exceeded}
                for limit in result.limits
            ],
            "refinement": result.refinement and _refinement_numbers(result.refinement),
            "times": loads.times,
            "cycle": loads.cycle,
            "cycle_choice": loads.choice,
            "loads": dict(zip(loads.channels, loads.values.T, strict=True)),
            "contacts": {
                contact.name: {key: getattr(contact, key) for key in CONTACT_KEYS}
                for contact in result.contacts
            },
            **_solution_numbers(result.solution),
            "mesh": {
                name: {
                    "cell": body.cell,
                    "order": body.order,
                    "nodes": len(body.points),
                    "cells": len(body.cells),
                }
                for name, body in result.bodies.items()
            },
        },
        "lists",
    )


def plain(value: Any, place: str) -> Any:
    """A value without long arrays in plain types of JSON."""
    return _Plain({})(value, place)


def _solution_numbers(solution: Solution) -> dict[str, Any]:
    """Steps as they were solved, and coordinates of the bodies."""
    return {
        "drivers": dict(zip(solution.drivers, solution.driver_values.T, strict=True)),
        "coordinates": {
            label: {"amplitude": amplitude, "force": force}
            for label, amplitude, force in zip(
                solution.coordinates, solution.amplitudes.T, solution.forces.T, strict=True
            )
        },
        "steps": {
            "iterations": solution.iterations,
            "parts": solution.parts,
            "fallbacks": solution.fallbacks,
            "certificate": solution.certificates,
            "repeats": solution.repeats,
        },
    }


def _refinement_numbers(refinement: Refinement) -> dict[str, Any]:
    """All meshes of a run that refined its mesh, and the limits of their values."""
    numbers = asdict(refinement)
    numbers["limits"] = [
        {
            "contact": station.contact,
            "front": station.front,
            "values": [limit.value for limit in limits],
            "spreads": [limit.spread for limit in limits],
        }
        for station, limits in refinement.limits
    ]
    return numbers


@dataclass(frozen=True)
class _Plain:
    """Makes plain Python types: arrays are lists, NaN and infinity None, keys strings.

    Many slip zones are one table of lists.

    Attributes:
        lists: gets arrays of more than `LONG` rows; a text says where they are.
    """

    lists: dict[str, Array]

    def __call__(self, value: Any, place: str) -> Any:
        """Return the value in plain types; `place` is its name, with those around it."""
        if is_dataclass(value):
            value = {field.name: getattr(value, field.name) for field in fields(value)}
        elif isinstance(value, tuple) and len(value) > LONG and isinstance(value[0], SlipZone):
            names = [field.name for field in fields(SlipZone)]
            value = {name: np.array([getattr(zone, name) for zone in value]) for name in names}
        if isinstance(value, Mapping):
            return {str(key): self(item, f"{place}/{key}") for key, item in value.items()}
        if isinstance(value, np.ndarray) and len(value) > LONG:
            return self._elsewhere(value, place)
        if isinstance(value, np.ndarray):
            if value.dtype.kind == "f" and not (known := np.isfinite(value)).all():
                value = np.where(known, value, np.array(None))
            return value.tolist()
        if isinstance(value, list | tuple):
            return [self(item, f"{place}/{number}") for number, item in enumerate(value)]
        if isinstance(value, np.generic):
            return self(value.item(), place)
        if isinstance(value, float) and not math.isfinite(value):
            return None
        return value

    def _elsewhere(self, values: NDArray[Any], place: str) -> str:
        finite = values.dtype.kind != "f" or np.isfinite(values).all()
        self.lists[place] = values if finite else np.where(np.isfinite(values), values, np.nan)
        return ELSEWHERE + place


def kept_states(result: Result, solution: Solution) -> Indices:
    """(K,) states whose tractions the case wants to keep, increasing.

    Args:
        result: the run, evaluated.
        solution: its solution.
    """
    if solution.kept is not None:
        return solution.kept
    count = len(solution.times)
    wanted = result.case.output.tractions or ("all" if count <= LONG else "cycle")
    if wanted == "all":
        return np.arange(count)
    starts = {max(int(np.argmax(each.friction.acts)) - 1, 0) for each in solution.contacts}
    states = _extremes(result.contacts, solution.cycle) | starts | {0, count - 1}
    if wanted == "cycle":
        states |= set(cycle_states(solution.cycle).tolist())
    # What moved in the step to a state tells what slipped there.
    before = {max(state - 1, 0) for state in states}
    return np.array(sorted(states | before))


def _extremes(contacts: tuple[Contact, ...], cycle: tuple[int, int] | None) -> set[int]:
    """Load extremes of all contacts; of plane ones those of each and of each edge too.

    Besides these the ends of the slip zones of edges that are printed or drawn.
    """
    states = set(load_extremes(contacts, cycle))
    if contacts[0].solid:
        return states
    stations = [station for contact in contacts for station in contact.stations]
    for group in (*([station] for station in stations), *(each.stations for each in contacts)):
        states |= set(station_extremes(group, cycle))
    zones = [zone for station in stations for zone in station.slip_zones[-HALF_CYCLES:]]
    zones += [zone for station in stations if (zone := station.longest_zone) is not None]
    return states | {state for zone in zones for state in (zone.start, zone.end)}


def _write_contact(group: h5py.Group, contact: ContactHistory, states: Indices) -> None:
    """Write a contact: what it has for each state in some of the states."""
    names = {"pair": contact.pair, "body1": contact.body1, "body2": contact.body2}
    group.attrs.update({**names, "dundurs": contact.surface.dundurs})
    for name in NODAL:
        _write_rows(group, name, getattr(contact, name), states)
    friction = contact.friction.fields
    same = bool((friction == friction[:, :1]).all())
    store(group, "friction/fields", friction[:, :1] if same else friction)
    store(group, "friction/number", contact.friction.number)
    for owner in (contact, contact.surface):
        for field in fields(owner):
            value = getattr(owner, field.name)
            if field.name not in NODAL and isinstance(value, np.ndarray):
                store(group, field.name, value)
    units = contact.full_stick
    numbers = np.unique(units.area[states])
    areas = numbers[numbers >= 0] if len(states) < len(units.area) else np.arange(len(units.fields))
    _write_rows(group, "bonded/fields", units.fields, areas)
    store(group, "bonded/areas", areas)
    store(group, "bonded/area", units.area)


def _write_rows(
    group: h5py.Group, name: str, values: StateArray | NDArray[Any], rows: Indices
) -> None:
    """Write some rows of an array, block by block."""
    shape = (len(rows), *values.shape[1:])
    part = states_in_block(PARTS * math.prod(shape[1:]) * values.dtype.itemsize)
    dataset = room(group, name, shape, values.dtype, part)
    for start in range(0, len(rows), PARTS * part):
        block = slice(start, start + PARTS * part)
        dataset[block] = values[rows[block]]


def _write_mesh(group: h5py.Group, body: BodyMesh) -> None:
    group.attrs.update({"cell": body.cell, "order": body.order})
    store(group, "points", body.points)
    store(group, "cells", body.cells)
    for name, facets in body.boundaries.items():
        store(group, f"boundaries/{name}", facets)
