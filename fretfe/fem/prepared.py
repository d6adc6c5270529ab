# SPDX-License-Identifier: LGPL-3.0-or-later
"""What several load histories can be solved with: a mesh, its model, and a march."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fretfe.case import Case
from fretfe.contact.march import March
from fretfe.fem._compat import MPI
from fretfe.fem.model import Model
from fretfe.fem.parallel import on_root
from fretfe.fem.timing import Clock
from fretfe.mesh.mesh import Mesh
from fretfe.surface.load import load_mesh

LoadMesh = Callable[[], Mesh]


@dataclass(frozen=True)
class Prepared:
    """A mesh, its model, and what marches through load histories on it.

    Attributes:
        mesh: on rank 0, None elsewhere.
        model: the condensed bodies.
        march: on rank 0, None elsewhere.
    """

    mesh: Mesh | None
    model: Model
    march: March | None

    @property
    def digest(self) -> str:
        """Text that is equal for the same mesh; on rank 0."""
        assert self.mesh is not None
        found = hashlib.sha256()
        for name, body in self.mesh.bodies.items():
            found.update(repr((name, body.cell, body.order, body.cells.shape)).encode())
            for values in (body.points, body.cells, *body.boundaries.values()):
                found.update(np.ascontiguousarray(values).tobytes())
        return found.hexdigest()

    @property
    def meshes(self) -> list[Any]:
        """DOLFINx's meshes of the bodies."""
        return [body.elastic.mesh for body in self.model.bodies.values()]


def build_model(comm: MPI.Comm, case: Case, clock: Clock, load: LoadMesh | None = None) -> Prepared:
    """Mesh and model of a case. Collective.

    Args:
        comm: communicator.
        case: validated case, the same on all ranks.
        clock: for timings.
        load: gives the mesh, called on rank 0; None for `load_mesh`.

    Raises:
        FretfeError: if there is no mesh or no model for the case.
    """
    with clock("mesh"):
        mesh = on_root(comm, load or partial(load_mesh, case), share=False)
    model = Model(comm, case, mesh, clock)
    reduction = model.reduction
    march = March(reduction.interface) if reduction is not None else None
    return Prepared(mesh, model, march)
