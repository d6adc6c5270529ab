# SPDX-License-Identifier: LGPL-3.0-or-later
"""The loads of a case that are spread, each by its kind, and whether a history is possible."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from fretfe.bodies.loads.spread import (
    Acceleration,
    Force,
    Interference,
    Rotation,
    SpreadLoad,
    Traction,
)
from fretfe.bodies.loads.strain import (
    Temperature,
    TemperatureShape,
    eigenstrain,
)
from fretfe.case import Case
from fretfe.case.loads import (
    AccelerationLoad,
    EigenstrainLoad,
    ForceLoad,
    InterferenceLoad,
    Load,
    RotationLoad,
    TemperatureFieldLoad,
    TemperatureLoad,
    TractionLoad,
)
from fretfe.mesh.mesh import Mesh

# What loads of each kind are to bodies; those of other kinds move boundaries (`motion`).
SPREAD: Mapping[type[Load], Callable[[Case, str, Any, Mesh], Sequence[SpreadLoad]]] = {
    TractionLoad: Traction.of,
    ForceLoad: Force.of,
    RotationLoad: Rotation.of,
    AccelerationLoad: Acceleration.of,
    InterferenceLoad: Interference.of,
    TemperatureLoad: Temperature.of,
    TemperatureFieldLoad: TemperatureShape.of,
    EigenstrainLoad: eigenstrain,
}


def spread_loads(case: Case, mesh: Mesh) -> tuple[SpreadLoad, ...]:
    """All loads of a case that are spread over boundaries, bodies or contacts, in its order.

    Raises:
        CaseError: if a file with values at points is not as expected, or loads do not fit the mesh.
    """
    loads = tuple(
        each
        for name, load in case.loads.items()
        if type(load) in SPREAD
        for each in SPREAD[type(load)](case, name, load, mesh)
    )
    for load in loads:
        load.require_mesh(case, mesh)
    return loads
