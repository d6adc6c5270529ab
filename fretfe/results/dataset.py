# SPDX-License-Identifier: LGPL-3.0-or-later
"""Histories and tractions of a run as an xarray dataset."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fretfe._typing import Indices
from fretfe.errors import DependencyError
from fretfe.evaluate.contacts import ContactSummary
from fretfe.evaluate.resultants import AreaSummary
from fretfe.history.solution import ContactHistory, Solution
from fretfe.loads import History

if TYPE_CHECKING:
    import xarray as xr

# Histories of a contact, of a contact of solids and of an edge, by their attributes.
CONTACT = (
    "normal_force", "shear_force", "moment", "centre", "half_width", "effective_tension"
)  # fmt: skip
AREA = (
    "normal_force", "shear_force", "force", "centre", "moment", "contact_area", "stick_area",
    "largest_pressure", "work",
)  # fmt: skip
AXES = ("x", "y", "z")
EDGE = ("position", "position_spread", "k_n", "k_n_spread", "k_t", "k_i")
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
    loads: History,
    contacts: Sequence[ContactSummary],
    areas: Sequence[AreaSummary],
    solution: Solution | None,
) -> xr.Dataset:
    """Make a dataset with the dimensions time, load and contact, and nodes by contact.

    Contacts of plane bodies have the dimension edge, those of solids axis.

    Raises:
        DependencyError: if xarray is not installed.
    """
    histories, last = _solid_histories(areas) if areas else _plane_histories(contacts)
    variables = {"loads": (("time", "load"), loads.values), **histories}
    contact_arrays = solution.contacts if solution is not None else ()
    kept = solution.kept if solution is not None else None
    for history in contact_arrays:
        variables |= _fields(history, kept)
    coordinates: dict[str, Any] = {
        "time": loads.times,
        "load": list(loads.channels),
        "contact": [each.name for each in areas or contacts],
        **last,
    }
    if kept is not None:
        coordinates["kept"] = kept
    dataset: xr.Dataset = require("xarray").Dataset(variables, coordinates)
    return dataset


def _plane_histories(
    contacts: Sequence[ContactSummary],
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Histories of contacts and edges of plane bodies, and the coordinate edge."""
    variables: dict[str, Any] = {}
    for name in CONTACT:
        histories = [getattr(contact, name) for contact in contacts]
        variables[name] = (("contact", "time"), np.array(histories))
    for name in EDGE:
        values = [[getattr(edge, name) for edge in contact.stations] for contact in contacts]
        variables[name] = (("contact", "edge", "time"), np.array(values))
    sides = [edge.front for edge in contacts[0].stations] if contacts else []
    return variables, {"edge": sides}


def _solid_histories(areas: Sequence[AreaSummary]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Histories of contacts of solids, and the coordinate axis of their vectors."""
    variables: dict[str, Any] = {}
    for name in AREA:
        values = np.array([getattr(area, name) for area in areas])
        variables[name] = (("contact", "time", "axis")[: values.ndim], values)
    return variables, {"axis": list(AXES)}


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
