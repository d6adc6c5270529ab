# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that commands make of results: what is wrong with those of a command that succeeded."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from fretfe.matching.rig import Rig, load_rig

# Root finding of `fretfe match`, relative.
EXACT = 1e-6


def wrong_numbers(here: Path, printed: str) -> str:
    """What is wrong with the tests of a match, or with the margins of a strength map."""
    path = here / "out" / "match.json"
    if path.exists():
        found = json.loads(path.read_text("utf-8"), parse_constant=_refuse)
        rig = load_rig(here / "rig.toml")
        return next((text for each in _choices(found) if (text := _wrong(each, found, rig))), "")
    if not printed.startswith("{"):
        return ""
    edges = json.loads(printed, parse_constant=_refuse).get("edges", [])
    return next((text for each in edges if "margin" in each and (text := _wrong_margin(each))), "")


def _refuse(text: str) -> float:
    raise ValueError(text)


def _choices(found: dict[str, Any]) -> list[dict[str, Any]]:
    return [choice for shape in found["shapes"] for choice in shape["choices"]]


def _wrong(choice: dict[str, Any], found: dict[str, Any], rig: Rig) -> str:
    """A choice beyond the bounds of the rig, or with another K_N than the component."""
    middle, part = choice["normal_force"], choice["normal_amplitude"]
    bounds = {
        "P": (middle - part, *rig.forces.normal),
        "largest P": (middle + part, *rig.forces.normal),
        "Q": (abs(choice["shear_amplitude"]), *rig.forces.shear),
        "Q/(f P)": (choice["shear_ratio"], 0.0, 1.0),
        "radius": (choice.get("radius"), *(rig.pad.radius or (0.0, math.inf))),
    }
    for name, (value, low, high) in bounds.items():
        if value is not None and not low * (1 - EXACT) <= value <= high * (1 + EXACT):
            return f"{name} = {value:g} is not from {low:g} to {high:g}"
    # Eq. (5) of a cylinder, with a flat if there is one.
    if "radius" in choice:
        a, flat = choice["half_width"], choice.get("flat_half_width", 0.0)
        k_n = rig.e_star / (2 * choice["radius"]) * math.sqrt(2 * a)
        k_n *= 2 / math.pi * math.acos(flat / a)
        if not math.isclose(k_n, found["component"]["k_n"], rel_tol=EXACT):
            return f"K_N = {k_n:g} in place of {found['component']['k_n']:g}"
    return ""


def _wrong_margin(edge: dict[str, Any]) -> str:
    known = edge["margin"] is not None
    if known == bool(edge["reason"]):
        return f"margin {edge['margin']} with the reason {edge['reason']!r}"
    if known and not 0 < edge["low"] <= edge["margin"] <= edge["high"]:
        return f"margin {edge['margin']} of {edge['low']} to {edge['high']}"
    return ""
