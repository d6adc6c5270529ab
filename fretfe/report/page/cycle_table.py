# SPDX-License-Identifier: LGPL-3.0-or-later
"""Table of the worst counted cycle of each edge under irregular loads."""

from __future__ import annotations

from rich.table import Table

from fretfe.edges.front import Station
from fretfe.report.page.listings import plain_table
from fretfe.report.texts import MISSING, number
from fretfe.results.model import Result

HEADERS = (
    *("contact", "edge", "cycles", "from t", "to t"),
    *("ΔK_T", "mean K_T", "count", "d predicted"),
)


def cycle_table(run: Result) -> Table | None:
    """One row per edge with its worst cycle; None if the loads of all edges are regular.

    `cycles` are all that were counted. An edge whose loads are regular, or whose cycles could not
    be counted, has its number of cycles only.
    """
    edges = [(contact.name, edge) for contact in run.contacts for edge in contact.stations]
    if not any(edge.cycles.irregular for _, edge in edges):
        return None
    units = run.case.units
    title = (
        f"Worst counted cycles: t in {units.time}, K_T in {units.stress}·√{units.length}, d in "
        f"{units.length}"
    )
    table = plain_table(title, HEADERS, text=2)
    for contact, edge in edges:
        table.add_row(contact, edge.front, *_cells(run, edge))
    return table


def _cells(run: Result, edge: Station) -> list[str]:
    cycles, times = edge.cycles, run.loads.times
    if not len(cycles.count):
        return [cycles.reason, *[MISSING] * (len(HEADERS) - 3)]
    worst = cycles.worst
    return [
        number(float(cycles.count.sum())),
        *(number(float(times[states[worst]])) for states in (cycles.start, cycles.end)),
        *(number(float(each[worst])) for each in (cycles.k_t_range, cycles.k_t_mean, cycles.count)),
        number(float(cycles.slip[worst]), 3),
    ]
