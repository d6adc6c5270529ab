# SPDX-License-Identifier: LGPL-3.0-or-later
"""Parameters of geometry templates, with the checks that the templates make themselves."""

from __future__ import annotations

from collections.abc import Mapping

from fretfe.mesh.gmsh import script_model
from fretfe.mesh.templates import Template, check_parameters


def checked(template: Template, values: Mapping[str, float]) -> dict[str, float]:
    """All parameters of a template.

    Raises:
        CaseError: a value is out of its range, or the script finds that they do not fit together.
    """
    with script_model(template, values):
        return check_parameters(template, values)


def defaults(template: Template) -> dict[str, float]:
    """The parameters of a template as it has them."""
    return {each.name: each.default for each in template.parameters}
