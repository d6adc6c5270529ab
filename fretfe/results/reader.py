# SPDX-License-Identifier: LGPL-3.0-or-later
"""The results of a run, read back from its folder as the `Result` that they were."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from enum import Enum
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import h5py
import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case, parse_case
from fretfe.case.messages import found as described
from fretfe.errors import CaseError, ConvergenceError, OutputError
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.limits import ModelLimit
from fretfe.evaluate.refinement import Refinement
from fretfe.faults import Fault
from fretfe.history.solution import ContactHistory, FullStickUnits, Repeat, Solution
from fretfe.history.state_array import StateArray
from fretfe.history.stream import select_rows
from fretfe.loads import CycleChoice, History
from fretfe.mesh.mesh import BodyMesh
from fretfe.results.hdf5_file import read_fault, require_own
from fretfe.results.model import Result
from fretfe.results.run_folder import are_unchanged, require_stored, unfinished
from fretfe.results.tables import NODAL
from fretfe.results.writer import ARRAYS, ELSEWHERE, NUMBERS, SCHEMA
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction

T = TypeVar("T")
WORDS = {bool: "true or false", int: "a whole number", str: "a text"}


def require_shapes(group: h5py.Group, states: int, kept: int) -> None:
    """Check that the arrays of a contact are over the same states and nodes.

    Args:
        group: of the contact.
        states: T.
        kept: number of states whose tractions are stored.

    Raises:
        ValueError: for the first array that does not fit.
        KeyError: for one that is not there.
    """
    nodes = group["weights"].shape
    expected = {
        "friction/number": ((states,), 1),
        "points": (nodes, 2),
        "frames": (nodes, 3),
        **{name: ((kept, *nodes), 3 if last else 2) for name, last in NODAL.items()},
    }
    for name, (shape, dimensions) in expected.items():
        found = group[name].shape
        if found[: len(shape)] != shape or len(found) != dimensions:
            raise ValueError(f"{group.name}/{name}: expected an array over {shape}, found {found}")


def load_result(directory: Path | str) -> Result:
    """Read `results.json` and, if the run has tractions, `results.h5`.

    Args:
        directory: folder that `fretfe run` or `fretfe.run` has written.

    Returns:
        The result as the run returned it, with this folder and all versions that took part.

    Raises:
        OutputError: if a file is missing, cannot be read, or is not of this schema, or the two are
            of different runs.
    """
    directory = Path(directory)
    _require_end(directory)
    return read_result(directory)


def read_result(directory: Path) -> Result:
    """As `load_result`, also while the run is at work."""
    path = directory / NUMBERS
    numbers = _with_lists(directory, _read_numbers(directory))
    try:
        return _result(directory, parse_case(numbers["case"], source="case"), numbers)
    except (AttributeError, CaseError, IndexError, KeyError, TypeError, ValueError) as error:
        found = f"no key {error}" if isinstance(error, KeyError) else str(error)
        raise OutputError(
            f"{path}: expected the results of a whole run, found: {found}; {_remedy(numbers)}"
        ) from error


def read_numbers(directory: Path) -> dict[str, Any]:
    """Read `results.json` as it stands.

    Raises:
        OutputError: if it is missing or not of this schema, or the run has not ended by itself.
    """
    _require_end(directory)
    return _read_numbers(directory)


def _require_end(directory: Path) -> None:
    """Refuse a folder in which a run was cut off or is at work: it has no results.

    Raises:
        OutputError: if there is one.
    """
    if found := unfinished(directory):
        raise OutputError(f"{directory}: expected the results of a run, found {found}")


def _read_numbers(directory: Path) -> dict[str, Any]:
    path = directory / NUMBERS
    require_stored(path)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise OutputError(
            f"{path.parent}: expected a folder with the results of a run, found no readable "
            f"{path.name}: {error.strerror}"
        ) from error
    except (ValueError, RecursionError) as error:
        raise OutputError(f"{path}: expected the results of a run, found: {error}") from error
    schema = data.get("schema") if isinstance(data, dict) else None
    if schema != SCHEMA:
        raise OutputError(f"{path}: expected schema {SCHEMA}, found {schema}: {_remedy(data)}")
    if not are_unchanged(data):
        raise OutputError(f"{path}: expected the numbers that a run wrote, found changed ones")
    return dict(data)


def _remedy(data: object) -> str:
    """Remedy for numbers that this version does not read, in words."""
    known = data.get("versions") if isinstance(data, dict) else None
    writer = known.get("fretfe") if isinstance(known, dict) else None
    read = f"read it with fretfe {writer}, which wrote it, or " if writer else ""
    return f"{read}run the case again with this version of fretfe"


def _with_lists(directory: Path, numbers: dict[str, Any]) -> dict[str, Any]:
    """The numbers with the lists that stand in `results.h5`.

    Raises:
        OutputError: if they are not there.
    """
    if ELSEWHERE not in json.dumps(numbers):
        return numbers
    with _opened(directory / ARRAYS, numbers) as file:

        def restored(value: Any) -> Any:
            if isinstance(value, dict):
                return {key: restored(item) for key, item in value.items()}
            if isinstance(value, list):
                return [restored(item) for item in value]
            if isinstance(value, str) and value.startswith(ELSEWHERE):
                return file[value.removeprefix(ELSEWHERE)][:]
            return value

        return {key: restored(value) for key, value in numbers.items()}


@contextmanager
def _opened(path: Path, numbers: Mapping[str, Any]) -> Iterator[h5py.File]:
    """The arrays that belong to some numbers.

    Raises:
        OutputError: if they cannot be read, or are of another schema.
    """
    require_stored(path)
    try:
        with h5py.File(path, "r") as file:
            require_own(path, file, SCHEMA)
            yield file
    except KeyError as error:  # h5py has a sentence there
        raise OutputError(
            f"{path}: expected arrays that this version of fretfe reads, found others: "
            f"{error.args[0]}; {_remedy(numbers)}"
        ) from error
    except (OSError, RuntimeError) as error:
        # h5py has both for files that are damaged.
        reason = read_fault(error) if path.exists() else "no such file"
        raise OutputError(
            f"{path}: expected the arrays that belong to {NUMBERS}, found: {reason}"
        ) from error


def _result(directory: Path, case: Case, numbers: Mapping[str, Any]) -> Result:
    times = _numbers(numbers["times"])
    loads = numbers["loads"]
    cycle = numbers["cycle"] and _as(tuple[int, ...], numbers["cycle"])
    choice = numbers.get("cycle_choice")  # earlier versions did not write it
    _require_names("loads", loads, case.loads)
    _require_names("mesh", numbers["mesh"], case.bodies)
    contacts = tuple(_contact(*each) for each in numbers["contacts"].items())
    _require_names("contacts", (each.pair for each in contacts), case.contacts)
    history = History(
        tuple(loads),
        times,
        _columns(loads.values(), times),
        cycle or None,
        choice=CycleChoice(choice) if choice else None,
    )
    solution, bodies = _read_arrays(directory / ARRAYS, case, history, numbers)
    refinement = numbers["refinement"]
    return Result(
        case=case,
        loads=history,
        backend=str(numbers["backend"]),
        contacts=contacts,
        notes=_as(tuple[str, ...], numbers["notes"]),
        failure=None if numbers["complete"] else ConvergenceError(numbers["failure"]),
        root_solution=solution,
        bodies=bodies,
        versions=numbers["versions"],
        seconds=numbers["seconds"],
        ranks=numbers["ranks"],
        limits=_as(tuple[ModelLimit, ...], numbers["limits"]),
        refinement=restored(Refinement, refinement) if refinement else None,
        directory=directory,
        faults=_as(tuple[Fault, ...], numbers["faults"]),
    )


def _require_names(what: str, found: Iterable[str], known: Iterable[str]) -> None:
    """Check that numbers are of what is in the case.

    Raises:
        ValueError: for the first name that is not.
    """
    names = list(known)
    if wrong := [name for name in found if name not in names]:
        raise ValueError(f"{what}: {wrong[0]!r}, which is none of the case ({', '.join(names)})")


def _contact(name: str, table: Mapping[str, Any]) -> Contact:
    contact = restored(Contact, {**table, "name": name, "fronts": ()})
    return replace(contact, fronts=tuple(_front(each) for each in _listed(table["fronts"])))


def _front(table: Mapping[str, Any]) -> Front:
    stations = tuple(
        restored(Station, {**each, "slip_zones": _rows(each["slip_zones"])})
        for each in _listed(table["stations"])
    )
    return replace(restored(Front, {**table, "stations": ()}), stations=stations)


def _rows(table: Any) -> Sequence[Mapping[str, Any]]:
    """A list of tables, of which a long one is a table of lists."""
    if not isinstance(table, dict):
        return _listed(table)
    lists = (values.tolist() for values in table.values())
    return [dict(zip(table, row, strict=True)) for row in zip(*lists, strict=True)]


def restored(cls: type[T], table: Mapping[str, Any]) -> T:
    """A dataclass from a table with a key for each of its fields; other keys are left out."""
    assert is_dataclass(cls)
    if not isinstance(table, Mapping):
        raise TypeError(f"{described(table)} in place of a table")
    hints = _hints(cls)
    values = {each.name: _as(hints[each.name], table[each.name]) for each in fields(cls)}
    return cls(**values)


@cache
def _hints(cls: type[Any]) -> dict[str, Any]:
    """Types of the fields of a class: finding them out takes longer than a table of numbers."""
    return get_type_hints(cls)


def _as(kind: Any, value: Any) -> Any:
    """A value of JSON as the type that a field is declared with."""
    if kind is float:
        return math.nan if value is None else float(value)
    if kind in (bool, int, str) and not isinstance(value, kind):
        raise TypeError(f"{described(value)} in place of {WORDS[kind]}")
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(value)
    if is_dataclass(kind):
        return restored(kind, value)  # type: ignore[arg-type]
    if get_origin(kind) is tuple:
        return tuple(_as(get_args(kind)[0], each) for each in _listed(value))
    if kind == Indices:
        return np.asarray(value, dtype=np.int64)
    # The only other lists are arrays.
    return _numbers(value) if isinstance(value, list | np.ndarray) else value


def _listed(value: Any) -> Sequence[Any]:
    """A list of JSON; of a text each letter would be one of its values."""
    if not isinstance(value, list | tuple | np.ndarray):
        raise TypeError(f"{described(value)} in place of a list")
    return [*value]


def _numbers(values: Any) -> Array:
    return np.asarray(values, dtype=float)


def _columns(values: Any, times: Array) -> Array:
    """(T, n) from n lists of T numbers."""
    return np.column_stack([np.empty((len(times), 0)), *map(_numbers, values)])


def _read_arrays(
    path: Path, case: Case, history: History, numbers: Mapping[str, Any]
) -> tuple[Solution, dict[str, BodyMesh]]:
    with _opened(path, numbers) as file:
        if not np.array_equal(file["times"][:], history.times):
            raise OutputError(
                f"{path}: expected the {len(history.times)} states of {NUMBERS}, found other "
                "times: the two files are of different runs"
            )
        states = file["states"][:]
        contacts = tuple(
            _read_contact(path, name, file[f"contacts/{name}"], states, len(history.times), case)
            for name in numbers["contacts"]
        )
        bodies = {name: _read_body(name, file[f"mesh/{name}"]) for name in numbers["mesh"]}
        free = file["free"][:] if "free" in file else None
    return replace(_solution(case, history, numbers, contacts, states), free=free), bodies


def _solution(
    case: Case,
    history: History,
    numbers: Mapping[str, Any],
    contacts: tuple[ContactHistory, ...],
    states: Indices,
) -> Solution:
    coordinates, drivers, steps = (numbers[key] for key in ("coordinates", "drivers", "steps"))
    times = history.times
    return Solution(
        degree=case.model.degree,
        times=times,
        channels=history.channels,
        values=history.values,
        cycle=history.cycle,
        coordinates=tuple(coordinates),
        amplitudes=_columns([each["amplitude"] for each in coordinates.values()], times),
        forces=_columns([each["force"] for each in coordinates.values()], times),
        drivers=tuple(drivers),
        driver_values=_columns(drivers.values(), times),
        contacts=contacts,
        iterations=np.array(steps["iterations"]),
        parts=np.array(steps["parts"]),
        fallbacks=np.array(steps["fallbacks"]),
        certificates={name: _numbers(values) for name, values in steps["certificate"].items()},
        repeats=tuple(Repeat(**each) for each in steps["repeats"]),
        kept=states if len(states) < len(times) else None,
        choice=history.choice,
    )


def _read_contact(
    path: Path, name: str, group: h5py.Group, states: Indices, count: int, case: Case
) -> ContactHistory:
    require_shapes(group, count, len(states))
    names = [each.name for each in fields(ContactSurface) if each.name in group]
    surface = ContactSurface(
        **{each: group[each][:] for each in names}, dundurs=float(group.attrs["dundurs"])
    )
    nodal: dict[str, Any] = {each: _stored(path, group[each], states, count) for each in NODAL}
    # There only of one of several patches.
    node_range = group["node_range"][:] if "node_range" in group else None
    units, areas = group["bonded/fields"], group["bonded/areas"][:]
    area = group["bonded/area"][:]
    full_stick = FullStickUnits(_stored(path, units, areas, int(area.max(initial=-1)) + 1), area)
    pair, body1, body2 = (str(group.attrs[key]) for key in ("pair", "body1", "body2"))
    _require_names(group.name, (pair,), case.contacts)
    _require_names(group.name, (body1, body2), case.bodies)
    return ContactHistory(
        name=name,
        pair=pair,
        body1=body1,
        body2=body2,
        surface=surface,
        friction=_friction(group["friction"], len(surface.weights)),
        **nodal,
        full_stick=full_stick,
        node_range=node_range,
    )


def _friction(group: h5py.Group, nodes: int) -> Friction:
    """Coefficients of a contact; those that are the same at all nodes are stored once."""
    fields = group["fields"][:]
    return Friction(np.broadcast_to(fields, (len(fields), nodes)), group["number"][:])


def _stored(path: Path, dataset: h5py.Dataset, numbers: Indices, count: int) -> StateArray:
    """An array over `count` states, or contact areas, of which some are in a file.

    It is read where it is needed; the file is opened each time, so that it can be replaced: then
    there is nothing more to be read.
    """
    name, identity = dataset.name, _identity(path)

    def read(wanted: Indices) -> Any:
        rows = np.searchsorted(numbers, wanted)
        missing = (rows == len(numbers)) | (numbers[np.minimum(rows, len(numbers) - 1)] != wanted)
        if missing.any():
            raise OutputError(
                f"{path}: expected {name} in state {int(wanted[np.argmax(missing)])}, found only "
                f'{len(numbers)} of {count}: run the case with [output] tractions = "all"'
            )
        if _identity(path) != identity:
            raise OutputError(f"{path}: expected the file that was read, found another one")
        try:
            with h5py.File(path, "r") as file:
                return select_rows(file[name], rows)
        except (OSError, RuntimeError) as error:
            raise OutputError(f"{path}: cannot read {name}: {read_fault(error)}") from error

    return StateArray((count, *dataset.shape[1:]), dataset.dtype, read)


def _identity(path: Path) -> tuple[int, int] | None:
    """Identity of a file among others of the same name; None if there is none."""
    if not path.exists():
        return None
    status = path.stat()
    return status.st_ino, status.st_mtime_ns


def _read_body(name: str, group: h5py.Group) -> BodyMesh:
    """The mesh of a body from its group in `results.h5`."""
    return BodyMesh(
        name=name,
        points=group["points"][:],
        cells=group["cells"][:],
        cell=str(group.attrs["cell"]),
        order=int(group.attrs["order"]),
        boundaries={name: facets[:] for name, facets in group.get("boundaries", {}).items()},
    )
