# SPDX-License-Identifier: LGPL-3.0-or-later
"""An assessment in the types of JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from fretfe.decision.assessment import Assessment
from fretfe.files import json_value

SCHEMA = {"name": "fretfe-assessment", "version": 1}
# Attributes of an edge and of a judgement, which are keys of the file.
OF_EDGE = (
    "contact",
    "edge",
    "body",
    "friction",
    "life",
    "bar",
    "spread",
    "lost",
    "depth",
    "straight",
)
OF_JUDGEMENT = ("margin", "low", "high", "place", "outermost", "reason", "station", "end", "to_end")


def assessment_numbers(found: Assessment) -> dict[str, Any]:
    """The margins in the types of JSON; null for what is unknown, or infinite without a reason."""
    worst = found.worst
    return {
        "schema": SCHEMA,
        "result": found.result,
        "others": [each.result for each in found.others],
        "units": {"length": found.units.length, "stress": found.units.stress},
        "material": str(found.material),
        "source": found.source,
        "critical_length": json_value(found.length),
        "worst": None
        if worst is None
        else {
            **{name: getattr(worst[0], name) for name in ("contact", "edge", "body")},
            "criterion": worst[1].criterion.value,
            "margin": json_value(worst[1].margin),
        },
        "edges": [
            {
                **{name: json_value(getattr(edge, name)) for name in OF_EDGE},
                "survival": json_value(edge.survival and asdict(edge.survival)),
                "damage": json_value(edge.damage and asdict(edge.damage)),
                "arrest": None if edge.arrest is None else json_value(asdict(edge.arrest)),
                "criteria": {
                    each.criterion.value: {
                        **{name: json_value(getattr(each, name)) for name in OF_JUDGEMENT},
                        "range": json_value(found.range_of(edge, each.criterion)),
                    }
                    for each in edge.judgements
                },
            }
            for edge in found.edges
        ],
        "remarks": list(found.remarks),
    }
