# SPDX-License-Identifier: LGPL-3.0-or-later
"""The mesh of a case: read or made, and checked against the case."""

from __future__ import annotations

from fretfe.case import Case, check_dimension, complaint
from fretfe.errors import CaseError
from fretfe.fem.contact_checks import check_contacts
from fretfe.fem.mesh_groups import check_groups
from fretfe.fem.meshing import Mesh, SetSizes, mesh_template, read_mesh
from fretfe.templates import Template, find_template


def load_mesh(case: Case, size: SetSizes | None = None) -> Mesh:
    """Read or make the mesh of a case and check it against the case. Serial.

    Args:
        case: validated case.
        size: sets element sizes in place of those of the geometry.

    Raises:
        CaseError: if the template or its parameters are not valid, a direction does not fit, or the
            geometry has a mesh already and sizes are to be set.
        MeshError: if there is no valid mesh with all the groups that the case names, or its contact
            surfaces overlap or do not face each other.
    """
    geometry = case.geometry
    if geometry.template is not None:
        template = find_template(geometry.template)
        if size is not None:
            _refuse_sizes(case, template)
        mesh = mesh_template(template, geometry.parameters, geometry.order, size)
    else:
        assert geometry.file is not None
        if size is not None:
            raise CaseError(
                complaint(
                    case.source,
                    ("edges", "tolerance"),
                    f"expected a geometry that can be meshed again, found the mesh "
                    f"{geometry.file!r}",
                )
            )
        mesh = read_mesh(case.resolve(geometry.file))
    check_groups(mesh, case)
    check_dimension(case, mesh.dimension)
    if mesh.dimension == 2:
        check_contacts(mesh, case)
    return mesh


def _refuse_sizes(case: Case, template: Template) -> None:
    """A mesh that refines itself takes no element sizes."""
    given = [each.name for each in template.parameters if each.is_mesh_size]
    given = [name for name in given if name in case.geometry.parameters]
    if given:
        text = f"expected no element sizes together with edges.tolerance, found {', '.join(given)}"
        raise CaseError(complaint(case.source, ("geometry", "parameters"), text))
