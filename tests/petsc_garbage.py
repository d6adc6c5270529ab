# SPDX-License-Identifier: LGPL-3.0-or-later
"""Destroy the PETSc objects of earlier tests, whose communicators would run out.

On several ranks PETSc keeps objects that Python has dropped, each with the communicator of its
mesh, until it is told to destroy those of that communicator. Without this MPICH, which has 2048
communicators, ends the run after about 80 models.
"""

from __future__ import annotations

import gc

import dolfinx.mesh

from fretfe.fem._compat import MPI, PETSc

_meshes: list[dolfinx.mesh.Mesh] = []


def replace_meshes(*meshes: dolfinx.mesh.Mesh) -> None:
    """Clean up after the meshes of the last call and keep these for the next one. Collective."""
    if MPI.COMM_WORLD.size == 1:  # destroyed at once
        return
    gc.collect()
    for mesh in _meshes:
        PETSc.garbage_cleanup(mesh.comm)
    _meshes[:] = meshes
