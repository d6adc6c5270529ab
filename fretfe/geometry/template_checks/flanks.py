# SPDX-License-Identifier: LGPL-3.0-or-later
"""Checks of the templates whose contacts are flats with a rounding at both ends."""

from __future__ import annotations

import math
from collections.abc import Mapping

from fretfe.geometry.template_checks.bounds import at_most


def contact_ends_on_roundings(values: Mapping[str, float]) -> str | None:
    """The candidate contact must end on both roundings, with a margin."""
    limit = min(values["relief_angle"], 90 - values["flank_angle"]) - 5
    why = "5 degrees less than relief_angle and than 90 - flank_angle"
    return at_most("contact_angle", values, limit, why)


def fine_zone_fits(values: Mapping[str, float]) -> str | None:
    """The fine mesh must end inside the candidate contact and leave a middle of the flat."""
    radius = min(values["upper_radius"], values["lower_radius"])
    arc = 0.9 * radius * math.radians(values["contact_angle"])
    bound = min(arc, 0.45 * values["flank_length"])
    why = "90 % of the candidate contact on the smaller rounding, 45 % of the flat"
    return at_most("edge_zone", values, bound, why)


def flank_size_resolves_flat(values: Mapping[str, float]) -> str | None:
    """Four elements or more to the flat."""
    return at_most("flank_size", values, values["flank_length"] / 4, "a quarter of the flat")


def edge_size_is_smallest(values: Mapping[str, float]) -> str | None:
    """The mesh at the contact edges must be the finest, two elements or more."""
    bound = min(values["flank_size"], values["edge_zone"] / 2)
    return at_most("edge_size", values, bound, "flank_size, and half of edge_zone")
