# SPDX-License-Identifier: LGPL-3.0-or-later
"""The case file: its model, reading it, its schema. Nothing else reads case files."""

from __future__ import annotations

from fretfe.case.base import BoundarySelector, Selector, file_kind, unit_vector
from fretfe.case.bodies import (
    IS_CRYSTAL,
    AnyBody,
    Body,
    Crystal,
    isotropic,
)
from fretfe.case.loads import (
    AccelerationLoad,
    DisplacementLoad,
    EigenstrainLoad,
    FieldLoad,
    ForceLoad,
    InterferenceLoad,
    Load,
    PlatenLoad,
    RotationLoad,
    ShapeLoad,
    TemperatureFieldLoad,
    TemperatureLoad,
    TiltLoad,
    TractionLoad,
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
    Contact,
    Cycle,
    Edges,
    Geometry,
    Model,
    Output,
    Plane,
    Solid,
    Support,
    Symmetry,
    TiedParts,
)
from fretfe.case.units import Units, stiffness_doubts

__all__ = [
    "IS_CRYSTAL",
    "AccelerationLoad",
    "AnyBody",
    "Body",
    "BoundarySelector",
    "Case",
    "Contact",
    "Crystal",
    "CsvPoints",
    "Cycle",
    "DisplacementLoad",
    "Edges",
    "EigenstrainLoad",
    "FieldLoad",
    "ForceLoad",
    "Geometry",
    "Hold",
    "InterferenceLoad",
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
    "ShapeLoad",
    "Solid",
    "Support",
    "Symmetry",
    "TemperatureFieldLoad",
    "TemperatureLoad",
    "TiedParts",
    "TiltLoad",
    "TractionLoad",
    "Units",
    "Wave",
    "as_written",
    "case_notes",
    "case_schema",
    "case_text",
    "changed",
    "check_dimension",
    "complaint",
    "file_kind",
    "isotropic",
    "load_case",
    "parse_assignments",
    "parse_case",
    "stiffness_doubts",
    "unit_vector",
]
