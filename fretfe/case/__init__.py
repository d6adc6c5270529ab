# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case file: its model, reading it, its schema. Nothing else reads case files."""

from __future__ import annotations

from fretfe.case.base import BoundarySelector, Selector, file_kind, unit_vector
from fretfe.case.loads import (
    CsvPoints,
    DisplacementLoad,
    EigenstrainLoad,
    Hold,
    Load,
    PlatenLoad,
    Points,
    Ramp,
    RotationLoad,
    Segment,
    TemperatureLoad,
    TiltLoad,
    TractionLoad,
    Wave,
)
from fretfe.case.messages import complaint
from fretfe.case.model import Case, case_schema
from fretfe.case.overrides import parse_assignments
from fretfe.case.reading import (
    as_written,
    case_text,
    changed,
    check_dimension,
    load_case,
    parse_case,
)
from fretfe.case.tables import (
    Body,
    Contact,
    Cycle,
    Edges,
    Geometry,
    Model,
    Output,
    Plane,
    Solid,
    Support,
    Units,
    antiplane_ratio,
    contact_modulus,
    plane_modulus,
)

__all__ = [
    "Body",
    "BoundarySelector",
    "Case",
    "Contact",
    "CsvPoints",
    "Cycle",
    "DisplacementLoad",
    "Edges",
    "EigenstrainLoad",
    "Geometry",
    "Hold",
    "Load",
    "Model",
    "Output",
    "Plane",
    "PlatenLoad",
    "Points",
    "Ramp",
    "RotationLoad",
    "Segment",
    "Selector",
    "Solid",
    "Support",
    "TemperatureLoad",
    "TiltLoad",
    "TractionLoad",
    "Units",
    "Wave",
    "antiplane_ratio",
    "as_written",
    "case_schema",
    "case_text",
    "changed",
    "check_dimension",
    "complaint",
    "contact_modulus",
    "file_kind",
    "load_case",
    "parse_assignments",
    "parse_case",
    "plane_modulus",
    "unit_vector",
]
