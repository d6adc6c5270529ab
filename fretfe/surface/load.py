# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a case, checked down to its contact surfaces."""

from __future__ import annotations

from fretfe.case import Case
from fretfe.mesh.load import grouped_mesh, naming_case
from fretfe.mesh.make import SetSizes
from fretfe.mesh.mesh import Mesh
from fretfe.surface.checks import check_contacts


def load_mesh(case: Case, size: SetSizes | None = None) -> Mesh:
    """Read or make the mesh of a case and check it against the case. Serial.

    Args:
        case: validated case.
        size: sets element sizes in place of those of the geometry.

    Raises:
        CaseError: as for `grouped_mesh`.
        MeshError: as for `grouped_mesh`, and if contact surfaces overlap or do not face each other.
    """
    mesh = grouped_mesh(case, size)
    with naming_case(case):
        check_contacts(mesh, case)
    return mesh
