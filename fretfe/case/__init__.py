# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case file: its model, reading it, its schema. Nothing else reads case files."""

from __future__ import annotations

from fretfe.case.base import BoundarySelector, Selector, unit_vector
from fretfe.case.bodies import (
    IS_CRYSTAL,
    AnyBody,
    Body,
    Crystal,
    isotropic,
)
from fretfe.case.loads import (
    FieldLoad,
    Load,
    PlatenLoad,
    RotationLoad,
    TemperatureFieldLoad,
    TemperatureLoad,
)
from fretfe.case.materials import case_notes
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
from fretfe.case.segments import CsvPoints, Hold, Points, Ramp, Segment, Wave
from fretfe.case.tables import (
    Geometry,
    Plane,
    Solid,
    Support,
    Symmetry,
)
from fretfe.case.units import Units, stiffness_doubts

__all__ = [
    "IS_CRYSTAL",
    "AnyBody",
    "Body",
    "BoundarySelector",
    "Case",
    "Crystal",
    "CsvPoints",
    "FieldLoad",
    "Geometry",
    "Hold",
    "Load",
    "Plane",
    "PlatenLoad",
    "Points",
    "Ramp",
    "RotationLoad",
    "Segment",
    "Selector",
    "Solid",
    "Support",
    "Symmetry",
    "TemperatureFieldLoad",
    "TemperatureLoad",
    "Units",
    "Wave",
    "as_written",
    "case_notes",
    "case_schema",
    "case_text",
    "changed",
    "check_dimension",
    "complaint",
    "isotropic",
    "load_case",
    "parse_assignments",
    "parse_case",
    "stiffness_doubts",
    "unit_vector",
]
