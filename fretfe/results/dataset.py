# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories and tractions of a run as an xarray dataset."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._typing import Indices
from fretfe.errors import DependencyError
from fretfe.evaluate.contacts import Contact, StationHistory, histories
from fretfe.history.solution import ContactHistory, Solution
from fretfe.loads import History

if TYPE_CHECKING:
    import xarray as xr

AXES = ("x", "y", "z")
# Fields along a contact, with what they have besides times and nodes.
NODAL = {
    "traction": "component",
    "mean_traction": "component",
    "slip": "tangent",
    "gap": "",
    "status": "",
    "dissipation": "",
}


def require(package: str) -> Any:
    """Import an optional package.

    Raises:
        DependencyError: if it is not installed.
    """
    try:
        return importlib.import_module(package)
    except ModuleNotFoundError as error:
        if error.name != package:
            raise
        raise DependencyError(
            f"the Python package {package} is not installed. Install it with "
            f"`pip install {package}` or from your distribution (Debian: python3-{package})"
        ) from None


def make_dataset(
    loads: History, contacts: Sequence[Contact], solution: Solution | None
) -> xr.Dataset:
    """Make a dataset with the dimensions time, load, contact and axis, and nodes by contact.

    Stations of plane contacts have the dimensions contact and edge, those of solids station.

    Raises:
        DependencyError: if xarray is not installed.
    """
    solid = any(contact.solid for contact in contacts)
    stations, places = _solid_stations(contacts) if solid else _plane_stations(contacts)
    variables = {"loads": (("time", "load"), loads.values), **_histories(contacts), **stations}
    contact_arrays = solution.contacts if solution is not None else ()
    kept = solution.kept if solution is not None else None
    for history in contact_arrays:
        variables |= _fields(history, kept)
    coordinates: dict[str, Any] = {
        "time": loads.times,
        "load": list(loads.channels),
        "contact": [each.name for each in contacts],
        **places,
    }
    if any("axis" in dimensions for dimensions, _ in variables.values()):
        coordinates["axis"] = list(AXES if solid else AXES[:2])
    if kept is not None:
        coordinates["kept"] = kept
    dataset: xr.Dataset = require("xarray").Dataset(variables, coordinates)
    return dataset


def _histories(contacts: Sequence[Contact]) -> dict[str, Any]:
    """Histories of the contacts, those that they have."""
    variables: dict[str, Any] = {}
    for name in histories(Contact):
        values = np.array([getattr(contact, name) for contact in contacts])
        if values.size:
            variables[name] = (("contact", "time", "axis")[: values.ndim], values)
    return variables


def _plane_stations(contacts: Sequence[Contact]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Histories of the edges of plane contacts, and the coordinate edge."""
    variables: dict[str, Any] = {}
    for name in histories(StationHistory):
        values = [[getattr(edge, name) for edge in contact.stations] for contact in contacts]
        variables[name] = (("contact", "edge", "time"), np.array(values))
    return variables, {"edge": [edge.front for edge in contacts[0].stations] if contacts else []}


def _solid_stations(contacts: Sequence[Contact]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Histories of the stations of solids, and where these are."""
    stations = [(contact.name, each) for contact in contacts for each in contact.stations]
    if not stations:
        return {}, {}
    variables = {
        name: (("station", "time"), np.array([getattr(each, name) for _, each in stations]))
        for name in histories(StationHistory)
    }
    points = np.array([each.point for _, each in stations])
    return variables, {
        "station_contact": ("station", [name for name, _ in stations]),
        "front": ("station", [each.front for _, each in stations]),
        "number": ("station", [each.number for _, each in stations]),
        "arc": ("station", [each.arc for _, each in stations]),
        **{f"station_{axis}": ("station", x) for axis, x in zip(AXES, points.T, strict=True)},
    }


def _fields(contact: ContactHistory, kept: Indices | None) -> dict[str, Any]:
    """Fields along a contact, of the states that are kept; components: normal, then tangents."""
    node = f"{contact.name}.node"
    arrays: dict[str, Any] = {}
    if contact.facets is None:
        arrays[f"{contact.name}.arc"] = (node, contact.arc)
    else:
        for axis, values in zip(AXES, contact.points.T, strict=True):
            arrays[f"{contact.name}.{axis}"] = (node, values)
        arrays[f"{contact.name}.weights"] = (node, contact.weights)
    for name, last in NODAL.items():
        states = "time" if kept is None else "kept"
        dimensions = (states, node, last) if last else (states, node)
        values = getattr(contact, name)[slice(None) if kept is None else kept]
        arrays[f"{contact.name}.{name}"] = (dimensions, values)
    return arrays
