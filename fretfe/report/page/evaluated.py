# SPDX-License-Identifier: LGPL-3.0-or-later
"""The evaluated cycle in words: from when to when, and why this one."""

from __future__ import annotations

from fretfe.loads import cycle_words
from fretfe.report.source import shown_stations
from fretfe.report.texts import number
from fretfe.results.model import Result


def cycle_sentences(run: Result) -> str:
    """The cycle that a run was evaluated for, and the worst counted one of irregular loads."""
    loads, steps = run.loads, len(run.loads.times) - 1
    worst = _worst_text(run)
    if loads.cycle is not None:
        first, last = loads.cycle
        behind = f"; the {steps - last} behind it do not count" if last < steps else ""
        text = f"Evaluated cycle: {cycle_words(loads, run.case.units.time)}"
        return f"{text} (steps {first + 1} to {last} of {steps}{behind}).{worst}"
    if run.failure is not None:
        return f"There is no evaluated cycle, as not all steps are solved.{worst}"
    told = "" if run.solid or worst else " Ranges over it are missing."
    reason = "no load is a wave or a repeated table, and [cycle] gives none"
    return f"There is no evaluated cycle: {reason}.{worst or told}"


def _worst_text(run: Result) -> str:
    """The worst counted cycle of all edges or stations; empty if the loads are regular."""
    found = [
        (float(cycles.effective_range[cycles.worst]), contact, edge)
        for contact, edge in shown_stations(run.contacts)
        if (cycles := edge.cycles).irregular
    ]
    if not found:
        return ""
    _, contact, edge = max(found, key=lambda each: each[0])
    worst, times = edge.cycles.worst, run.loads.times
    ends = sorted(float(times[each[worst]]) for each in (edge.cycles.start, edge.cycles.end))
    start, end = (number(each, 6) for each in ends)
    return (
        " Loads are irregular: slip zones are those of the worst counted cycle of each edge, "
        f"at {contact.name_of(edge)} that between t = {start} and {end} "
        f"{run.case.units.time}."
    )
