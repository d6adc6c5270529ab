# SPDX-License-Identifier: LGPL-3.0-or-later
"""One file with the tractions on all contact surfaces of solids, in the format VTKHDF."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.results.solution import ContactHistory, Solution
from fretfe.results.vtkhdf import Column, GridWriter, Part

# The ending by which PyVista knows the format.
SURFACES = "contacts.hdf"
# VTK's number of a facet, by number of nodes.
FACET_TYPES = {3: 5, 4: 9}
COLUMNS = {
    "pressure": Column(),
    "shear": Column(3),
    "slip": Column(3),
    "gap": Column(),
    "status": Column(kind=np.uint8),
    "dissipation": Column(),
}


def write_surfaces(path: Path, solution: Solution, states: Indices) -> None:
    """Write the contacts of solids before deformation, with their values in some states.

    Args:
        path: file to write.
        solution: of solids.
        states: (K,) states, increasing.

    Raises:
        OSError: if the file cannot be written.
    """
    parts = {contact.name: _part(contact) for contact in solution.contacts}
    with closing(GridWriter(path, parts, "contact", COLUMNS)) as writer:
        for state in states:
            values = [_values(contact, int(state)) for contact in solution.contacts]
            columns = {name: [each[name] for each in values] for name in COLUMNS}
            writer.add(float(solution.times[state]), columns)


def _part(contact: ContactHistory) -> Part:
    assert contact.facets is not None
    return Part(contact.points, contact.facets, FACET_TYPES[contact.facets.shape[1]])


def _values(contact: ContactHistory, state: int) -> dict[str, Array]:
    """(N, c) values of each column; vectors in the axes of the case, work per area."""
    traction = contact.mean_traction[state]
    scalars = {
        "pressure": traction[:, 0],
        "gap": contact.gap[state],
        "status": contact.status[state],
        "dissipation": contact.dissipation[state] / contact.weights,
    }
    return {
        **{name: np.asarray(values)[:, None] for name, values in scalars.items()},
        "shear": in_space(contact, traction[:, 1:]),
        "slip": in_space(contact, contact.slip[state]),
    }


def in_space(contact: ContactHistory, components: Array) -> Array:
    """(N, 3) vectors in the axes of the case, from components (N, 2) along the tangents."""
    return np.asarray(np.einsum("nt,ntd->nd", components, contact.frames[:, 1:]))
