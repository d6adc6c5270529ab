# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves on disk: `results.json` for numbers and histories, `results.h5` for arrays.

The schema is described in docs/results.md. Numbers that do not exist are null in JSON and NaN in
HDF5. Everything is gathered here, on one process.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from fretfe.edges.front import ContactSummary, Station
from fretfe.edges.refinement import Refinement
from fretfe.environment import versions
from fretfe.errors import OutputError
from fretfe.results.field_file import FIELDS
from fretfe.results.model import BodyArrays, Result
from fretfe.results.solution import ContactHistory, Solution

SCHEMA = {"name": "fretfe-results", "version": 2}
NUMBERS, ARRAYS, REPORT = "results.json", "results.h5", "report.html"
# Where pictures are in a results folder, and what lists them there.
PICTURES, PICTURE_LIST = "pictures", "pictures.json"


def prepare_directory(directory: Path) -> None:
    """Make the output folder and check that files can be written there.

    Raises:
        OutputError: if not.
    """
    probe = directory / ".fretfe-probe"
    try:
        directory.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(
            f"{directory}: expected a folder that files can be written to, found: {error.strerror}"
        ) from error


def remove_fields(directory: Path) -> None:
    """Remove the fields of an earlier run.

    Raises:
        OutputError: if that fails.
    """
    try:
        (directory / FIELDS).unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"{directory / FIELDS}: cannot remove old fields: {error}") from error


def remove_pictures(directory: Path) -> None:
    """Remove the pictures of an earlier run; other files stay."""
    folder = directory / PICTURES
    for path in [*folder.glob("*.png"), folder / PICTURE_LIST]:
        path.unlink(missing_ok=True)


def write_results(directory: Path, result: Result) -> None:
    """Write `results.json` and, if there are tractions, `results.h5`.

    Args:
        directory: existing folder.
        result: of a run, with the name of its backend.

    Raises:
        OutputError: if a file cannot be written.
    """
    try:
        text = json.dumps(as_numbers(result), indent=1, allow_nan=False)
        (directory / NUMBERS).write_text(text + "\n", encoding="utf-8")
        # Arrays of an earlier run would not belong to these numbers.
        (directory / ARRAYS).unlink(missing_ok=True)
        if result.solution is not None:
            _write_arrays(directory / ARRAYS, result, result.solution)
    except OSError as error:
        raise OutputError(f"{directory}: cannot write the results: {error}") from error


def _write_arrays(path: Path, result: Result, solution: Solution) -> None:
    with h5py.File(path, "w") as file:
        file.attrs.update({"schema": SCHEMA["name"], "version": SCHEMA["version"]})
        file["times"] = solution.times
        for contact in solution.contacts:
            _write_contact(file.create_group(f"contacts/{contact.name}"), contact)
        for name, body in result.bodies.items():
            _write_mesh(file.create_group(f"mesh/{name}"), body)


def as_numbers(result: Result) -> dict[str, Any]:
    """Everything that `results.json` holds, in plain Python types."""
    case, loads = result.case, result.loads
    return _plain(
        {
            "schema": SCHEMA,
            "title": case.title,
            "units": case.units.model_dump(),
            "backend": result.backend,
            "notes": result.notes,
            "complete": result.failure is None,
            "failure": str(result.failure or ""),
            "versions": {**versions(), **result.versions},
            "ranks": result.ranks,
            "seconds": result.seconds,
            "case": case.model_dump(mode="json", exclude_unset=True),
            "limits": [{**asdict(limit), "exceeded": limit.exceeded} for limit in result.limits],
            "refinement": _refinement_numbers(result.refinement),
            "times": loads.times,
            "cycle": loads.cycle,
            "loads": dict(zip(loads.channels, loads.values.T, strict=True)),
            "contacts": {contact.name: _contact_numbers(contact) for contact in result.contacts},
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
        }
    )


def _solution_numbers(solution: Solution | None) -> dict[str, Any]:
    """How the steps were solved and what moved the bodies; null without a solution."""
    if solution is None:
        return {"drivers": None, "coordinates": None, "steps": None}
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
        },
    }


def _refinement_numbers(refinement: Refinement | None) -> dict[str, Any] | None:
    """All meshes of a run that refined its mesh, and the limits of their values."""
    if refinement is None:
        return None
    numbers = asdict(refinement)
    for each in numbers["passes"]:
        each["edges"] = [
            {"side": station.pop("front"), **station} for station in each.pop("stations")
        ]
    numbers["limits"] = [
        {"contact": station.contact, "side": station.front, "values": limits}
        for station, limits in refinement.limits
    ]
    return numbers


def _contact_numbers(contact: ContactSummary) -> dict[str, Any]:
    """A contact's histories; its fronts in one list of stations."""
    numbers = {field.name: getattr(contact, field.name) for field in fields(contact)}
    del numbers["name"], numbers["fronts"]
    return {**numbers, "edges": [_station_numbers(station) for station in contact.stations]}


def _station_numbers(station: Station) -> dict[str, Any]:
    """A station; `side` is the name of its front, `station` its place along the front."""
    numbers = asdict(station)
    return {"station": numbers.pop("number"), "side": numbers.pop("front"), **numbers}


def _plain(value: Any) -> Any:
    """Arrays as lists, NaN and infinity as None, keys as strings."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _write_contact(group: h5py.Group, contact: ContactHistory) -> None:
    group.attrs.update({"pair": contact.pair, "body1": contact.body1, "body2": contact.body2})
    for field in fields(contact):
        value = getattr(contact, field.name)
        if isinstance(value, np.ndarray):
            group.create_dataset(field.name, data=value)
    group["bonded/fields"] = contact.full_stick.fields
    group["bonded/area"] = contact.full_stick.area


def _write_mesh(group: h5py.Group, body: BodyArrays) -> None:
    group.attrs.update({"cell": body.cell, "order": body.order})
    group["points"] = body.points
    group["cells"] = body.cells
    for name, facets in body.boundaries.items():
        group[f"boundaries/{name}"] = facets
