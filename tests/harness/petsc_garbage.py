# SPDX-License-Identifier: LGPL-3.0-or-later
"""Release the PETSc objects of earlier tests, whose communicators would run out."""

from __future__ import annotations

import dolfinx.mesh

from fretfe.fem.parallel import release

_meshes: list[dolfinx.mesh.Mesh] = []


def replace_meshes(*meshes: dolfinx.mesh.Mesh) -> None:
    """Clean up after the meshes of the last call and keep these for the next one. Collective."""
    release(_meshes)
    _meshes[:] = meshes
