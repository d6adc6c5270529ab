# SPDX-License-Identifier: LGPL-3.0-or-later
"""One flat record per contact edge: the numbers that tables are made of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from fretfe.evaluate.contacts import Contact, Station

# Slip zones of a record: those of the last two half cycles.
ZONES = 2


def edge_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts, numbers and truth values of every edge, by name; numbers that do not exist are NaN.

    ``slip_1`` and ``slip_2`` are the lengths of the slip zones of the last two half cycles, in the
    order of time, ``slip_1_spread`` and ``slip_2_spread`` their error bars, ``predicted_1`` and
    ``predicted_2`` what the edge factors predict for them. With one half cycle only it is the
    second. All spreads are half the width of an interval meant to hold the truth with 95 %; where
    that is more than half of the number, or unknown, there is none.
    """
    return [_record(contact, station) for contact in contacts for station in contact.stations]


def solid_records(contacts: Sequence[Contact]) -> list[dict[str, Any]]:
    """Texts, numbers and truth values of every contact of solids in its last state, by name."""
    return [
        {
            "contact": each.name,
            "normal_force": float(each.normal_force[-1]),
            **{
                f"shear_force_{axis}": float(q)
                for axis, q in zip("xyz", each.shear_force[-1], strict=True)
            },
            "contact_area": float(each.contact_area[-1]),
            "stick_area": float(each.stick_area[-1]),
            "largest_pressure": float(each.largest_pressure[-1]),
            "dissipation": each.dissipation,
            "steady": each.steady,
            "warnings": "; ".join(each.warnings),
        }
        for each in contacts
    ]


def _record(contact: Contact, station: Station) -> dict[str, Any]:
    zones = station.slip_zones[-ZONES:]
    first = ZONES - len(zones) + 1
    lengths = {f"slip_{n}": zone.reported_length for n, zone in enumerate(zones, start=first)}
    spreads = {f"slip_{n}_spread": zone.spread for n, zone in enumerate(zones, start=first)}
    predictions = {f"predicted_{n}": zone.prediction for n, zone in enumerate(zones, start=first)}
    kinds = ("slip_{}", "slip_{}_spread", "predicted_{}")
    numbers = [kind.format(n) for kind in kinds for n in range(1, ZONES + 1)]
    return {
        "contact": contact.name,
        "edge": station.front,
        "position": float(station.position[station.last]),
        "half_width": float(contact.half_width[station.last]),
        "k_n": station.reported_k_n,
        "k_n_spread": station.last_k_n[1],
        "k_t_range": station.reported_range,
        "k_t_range_spread": float(station.k_range_spread),
        "k_i_range": float(station.k_i_range),
        **{name: float((lengths | spreads | predictions).get(name, math.nan)) for name in numbers},
        "gross": any(zone.gross for zone in zones),
        "resolved": all(zone.resolved for zone in zones),
        "dissipation": float(station.dissipation),
        "steady": bool(contact.steady),
        "warnings": "; ".join(contact.warnings),
    }
