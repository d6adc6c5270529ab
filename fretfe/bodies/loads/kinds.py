# SPDX-License-Identifier: LGPL-3.0-or-later
"""The loads of a case that are spread, each by its kind, and whether a history is possible."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

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
from fretfe.errors import CaseError
from fretfe.loads import History
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


def require_one_rotation(case: Case, loads: Sequence[SpreadLoad], history: History) -> None:
    """Check that speeds are not to be added: the force goes with the square of their sum.

    Raises:
        CaseError: names the loads, and when they turn the bodies together.
    """
    names = [load.channel for load in loads if isinstance(load, Rotation)]
    speeds = history.values[:, [history.channels.index(name) for name in names]]
    both = np.flatnonzero((speeds != 0).sum(axis=1) > 1)
    if both.size:
        raise CaseError(
            f"{case.source}: loads: expected one load of the type rotation at a time, found "
            f"{' and '.join(names)} at time {history.times[both[0]]:g}: the force goes with the "
            "square of the whole speed, so give that by one of them"
        )
