# SPDX-License-Identifier: LGPL-3.0-or-later
"""All stations of the fronts of solids as a CSV file: a row for each."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.edges.area import AreaSummary
from fretfe.edges.solid_fronts import SolidStation
from fretfe.edges.solid_verdicts import judge
from fretfe.results.model import Result

STATIONS = "stations.csv"
AXES = "xyz"


def write_stations(path: Path, result: Result) -> None:
    """Write the stations; without any there is no file."""
    records = station_records(result.areas)
    if not records:
        path.unlink(missing_ok=True)
        return
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(records[0]))
        writer.writeheader()
        for record in records:
            writer.writerow({name: _plain(value) for name, value in record.items()})


def station_records(areas: tuple[AreaSummary, ...]) -> list[dict[str, Any]]:
    """Texts and numbers of every station, by name; numbers that do not exist are NaN.

    Factors are those of the last state, ranges those over the evaluated cycle, the slip zone that
    of the last half cycle.
    """
    return [
        {"contact": area.name, "front": front.name, **_record(station)}
        for area in areas
        for front in area.fronts
        for station in front.stations
    ]


def _record(station: SolidStation) -> dict[str, Any]:
    zone = station.slip_zones[-1] if station.slip_zones else None
    verdict = judge(station, zone) if zone else None
    return {
        "station": station.number,
        "arc": station.arc,
        **{axis: float(value) for axis, value in zip(AXES, station.point, strict=True)},
        **{
            f"inward_{axis}": float(value)
            for axis, value in zip(AXES, station.frame.inward, strict=True)
        },
        "curvature": station.curvature,
        "to_end": station.to_end,
        "end": station.end,
        "element_size": station.size,
        "k_n": float(station.k_n[-1]),
        "k_n_spread": float(station.k_n_spread[-1]),
        "k_n_moved": station.k_n_moved,
        "k_n_moved_spread": station.k_n_moved_spread,
        "k_n_moved_reason": station.k_n_moved_reason,
        "k_t": float(station.k_t[-1]),
        "k_s": float(station.k_s[-1]),
        "k_i": float(station.k_i[-1]),
        "k_t_range": station.k_t_range,
        "k_s_range": station.k_s_range,
        "k_i_range": station.k_i_range,
        "k_range": station.k_range,
        "k_range_spread": station.k_range_spread,
        "k_angle": station.k_angle,
        "turning": station.turning,
        "slip": zone.told_length if zone else np.nan,
        "slip_spread": zone.spread if zone else np.nan,
        "predicted": zone.prediction if zone else np.nan,
        "verdict": verdict.word if verdict else "",
        "reason": verdict.reason if verdict else "",
    }


def _plain(value: Any) -> Any:
    return "" if isinstance(value, float) and not np.isfinite(value) else value
