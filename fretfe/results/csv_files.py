# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stations and their counted cycles as CSV files."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Station
from fretfe.evaluate.verdicts import last_verdict, withheld
from fretfe.results.model import Result

CYCLES = "cycles.csv"
STATIONS = "stations.csv"
AXES = "xyz"


def write_cycles(path: Path, result: Result) -> None:
    """Write the cycles; if the loads are regular there is no file."""
    stations = (station for contact in result.contacts for station in contact.stations)
    irregular = any(station.cycles.irregular for station in stations)
    _write(path, cycle_records(result) if irregular else ())


def cycle_records(result: Result) -> Iterator[dict[str, Any]]:
    """Texts and numbers of every counted cycle, by name; numbers that do not exist are NaN."""
    for contact in result.contacts:
        for station in contact.stations:
            key = {"contact": contact.name, "front": station.front, "station": station.number}
            yield from ({**key, **cycle} for cycle in _cycles(station, result.loads.times))


def _cycles(station: Station, times: Array) -> Iterator[dict[str, Any]]:
    cycles, angle = station.cycles, math.radians(station.k_angle)
    along = station.k_t * math.cos(angle) + station.k_s * math.sin(angle)
    worst = cycles.worst if len(cycles.count) else None
    for number, (start, end) in enumerate(zip(cycles.start, cycles.end, strict=True)):
        yield {
            "start": int(start),
            "end": int(end),
            "start_time": float(times[start]),
            "end_time": float(times[end]),
            "count": float(cycles.count[number]),
            "k_t_start": float(along[start]),
            "k_t_end": float(along[end]),
            "k_t_range": float(cycles.k_t_range[number]),
            "k_t_mean": float(cycles.k_t_mean[number]),
            "effective_range": float(cycles.effective_range[number]),
            "slip": float(cycles.slip[number]),
            "worst": number == worst,
        }


def write_stations(path: Path, result: Result) -> None:
    """Write the stations; without any there is no file."""
    _write(path, station_records(result))


def station_records(result: Result) -> list[dict[str, Any]]:
    """Texts and numbers of every station, by name; numbers that do not exist are NaN.

    Ranges are those over the evaluated cycle, factors those at its end, or that of the history, the
    slip zone that of the last half cycle.
    """
    return [
        {"contact": contact.name, "front": station.front, **_record(station)}
        for contact in result.contacts
        for station in contact.stations
    ]


def _record(station: Station) -> dict[str, Any]:
    zone = station.slip_zones[-1] if station.slip_zones else None
    verdict = last_verdict(station)
    return {
        "station": station.number,
        "arc": station.arc,
        **{axis: float(value) for axis, value in zip(AXES, station.point, strict=True)},
        **{
            f"inward_{axis}": float(value)
            for axis, value in zip(AXES, station.frame.inward, strict=True)
        },
        "position": float(station.position[station.last]),
        "position_spread": float(station.position_spread[station.last]),
        "curvature": station.curvature,
        "to_end": station.to_end,
        "end": station.end,
        "element_size": station.size,
        "k_n": station.last_k_n[0],
        "k_n_spread": station.last_k_n[1],
        "k_n_moved": station.k_n_moved,
        "k_n_moved_spread": station.k_n_moved_spread,
        "k_n_moved_reason": station.k_n_moved_reason,
        "k_t": float(station.k_t[station.last]),
        "k_s": float(station.k_s[station.last]),
        "k_i": float(station.k_i[station.last]),
        "k_t_range": station.k_t_range,
        "k_s_range": station.k_s_range,
        "k_i_range": station.k_i_range,
        "k_range": station.k_range,
        "k_range_spread": station.k_range_spread,
        "k_angle": station.k_angle,
        "turning": station.turning,
        "slip": zone.reported_length if zone else np.nan,
        "slip_spread": zone.spread if zone else np.nan,
        "predicted": zone.prediction if zone else np.nan,
        "verdict": verdict.word,
        "reason": verdict.reason,
        "withheld": withheld(station),
    }


def _write(path: Path, records: Iterable[dict[str, Any]]) -> None:
    """A row for each record; without any there is no file."""
    rows = iter(records)
    first = next(rows, None)
    if first is None:
        path.unlink(missing_ok=True)
        return
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(first))
        writer.writeheader()
        for row in chain([first], rows):
            writer.writerow({name: _plain(value) for name, value in row.items()})


def _plain(value: Any) -> Any:
    return "" if isinstance(value, float) and not np.isfinite(value) else value
