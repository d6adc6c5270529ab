# SPDX-License-Identifier: LGPL-3.0-or-later
"""First jobs: solve one, use its results as commands do, and list what is not as it must be."""

from __future__ import annotations

import io
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from campaign.first_jobs import (
    BODY,
    HALF_WIDTH,
    RADIUS,
    Job,
    Tables,
    cyclic_slip,
    exact_factors,
)
from hypothesis import event
from rich.console import Console

from fretfe.backends import Observer
from fretfe.case import parse_case
from fretfe.errors import ConvergenceError, FretfeError
from fretfe.evaluate.contacts import Station
from fretfe.quality.rows import own_rows
from fretfe.report.page.tables import contact_table, cycle_table, front_texts, station_table
from fretfe.results.model import Result
from fretfe.results.reader import load_result
from fretfe.runner import Runner, draw_report

# What bodies of 40 half-widths and straight steps may add to a factor; to K_T by pressing alone, of
# K_I (as in the other campaign); and to a slip zone, over the half-width of the contact.
FINITE = 0.006
PRESSED = 0.06 / BODY + 0.2 * HALF_WIDTH / RADIUS
BORDER = 0.004
# The slip zone of a sphere at nu = .3 is no circle (as in the campaign of solids).
COUPLED = 0.017


class Steps(Observer):
    """Counts the steps that were solved."""

    def __init__(self) -> None:
        self.count = 0

    def step(self, number: int, count: int, text: str) -> None:
        """Note a step."""
        self.count = number


def outcome(tables: Tables, backend: str, *, report: bool = False) -> Result | FretfeError:
    """Solve a case in a folder, read it again, and print all that the commands print.

    An error that is not one of fretfe's own passes: that is a traceback.
    """
    case = parse_case(tables)
    steps = Steps()
    with tempfile.TemporaryDirectory() as folder:
        try:
            result = Runner.find(backend).run(case, Path(folder), steps)
        except FretfeError as error:
            assert not steps.count, f"{steps.count} steps are lost: {error}"
            return error
        if result.failure is not None:
            return result.failure
        _use(result)
        _use(load_result(Path(folder)))
        if report:
            assert (problems := draw_report(Path(folder)).problems) == (), problems
    return result


def _use(result: Result) -> None:
    """Make the tables and rows of a result, as `run`, `report` and `validate` do."""
    console = Console(file=io.StringIO(), width=200)
    for table in (contact_table(result), station_table(result), cycle_table(result)):
        if table is not None:
            console.print(table)
    for text in front_texts(result) if result.solid else ():
        console.print(text)
    for row in own_rows(result):
        console.print(row.reason)


def faults(job: Job, backend: str, *, report: bool = False) -> Iterator[str]:
    """What is wrong with the results of a job, in words; an error of our own is raised."""
    found = outcome(job.tables, backend, report=report)
    event(type(found).__name__)
    if isinstance(found, ConvergenceError) and not job.unsolvable:
        yield f"no solution, though the contact neither opens nor slides: {found}"
    if isinstance(found, FretfeError):
        return
    yield from _faults_of_cycle(found, job)
    yield from _silent(found)
    yield from _faults_of_numbers(found, job)


def _faults_of_cycle(result: Result, job: Job) -> Iterator[str]:
    cycle = result.loads.cycle
    told = None if cycle is None else tuple(float(result.loads.times[each]) for each in cycle)
    if (told is None) != (job.cycle is None) or (
        told is not None and job.cycle is not None and not np.allclose(told, job.cycle, rtol=1e-9)
    ):
        yield f"the cycle {told} is evaluated in place of {job.cycle}"


def _silent(result: Result) -> Iterator[str]:
    """Numbers that are missing without a warning while the contact is closed."""
    for contact in result.contacts:
        for station in contact.stations:
            if contact.normal_force[station.last] > 0 and not contact.warnings:
                for name, value in _numbers(result, contact.name, station):
                    if math.isnan(value):
                        yield f"{contact.name} {station.front}: {name} is unknown without a word"


def _numbers(result: Result, contact: str, station: Station) -> Iterator[tuple[str, float]]:
    yield "K_N", station.reported_k_n
    if result.case.contacts[contact].friction and result.loads.cycle is not None:
        yield "ΔK_T", station.k_range


def _faults_of_numbers(result: Result, job: Job) -> Iterator[str]:
    factors, slip = exact_factors(job), cyclic_slip(job)
    if factors is None:
        return
    (contact,) = result.contacts
    sphere = job.template == "sphere"
    k_n, k_range = factors
    scale = job.peak / math.pi
    # K_N grows with the root of the half-width, that with P^(1/2), of spheres P^(1/3).
    force, power = contact.normal_force, 1 / 6 if sphere else 1 / 4
    at_end = float(force[-1 if result.loads.cycle is None else result.loads.cycle[1]])
    for each in contact.stations if at_end > 0 else ():
        value, bar = each.decisive_k_n
        truth = k_n * (float(force[each.decisive]) / at_end) ** power
        yield from _off(each.front, "K_N", value, bar, truth, FINITE * truth)
    # Edges have ranges of their own, stations of a sphere the same.
    largest = max(contact.stations, key=lambda each: each.k_range, default=None)
    pressed = job.tables["contacts"]["main"]["friction_from"] if _late(job) else math.inf
    if largest is not None and pressed <= (job.cycle or (0.0,))[0]:
        for each in contact.stations if sphere else (largest,):
            bar = each.k_range_spread
            allowed = FINITE * k_range + PRESSED * each.k_i_range + 1e-9 * scale
            yield from _off(each.front, "ΔK", each.k_range, bar, k_range, allowed)
    if slip is not None and contact.steady and result.loads.cycle is not None:
        allowed = BORDER + COUPLED if sphere else BORDER
        for each in contact.stations:
            for zone in each.slip_zones[-2:]:
                if zone.resolved:
                    yield from _off(each.front, "d", zone.length, zone.spread, slip, allowed)


def differences(job: Job) -> Iterator[str]:
    """Numbers of finite elements and of half-planes that differ by more than both their bars."""
    found = [outcome(job.tables, backend) for backend in ("fem", "halfplane")]
    event(" beside ".join(type(each).__name__ for each in found))
    elements, planes = found
    if isinstance(elements, FretfeError) or isinstance(planes, FretfeError):
        return
    if elements.loads.cycle != planes.loads.cycle:
        yield f"states {elements.loads.cycle} are evaluated, {planes.loads.cycle} by half-planes"
        return
    (contact,), (other,) = elements.contacts, planes.contacts
    for one, two in zip(contact.stations, other.stations, strict=True):
        (value, bar), (truth, width) = one.decisive_k_n, two.decisive_k_n
        yield from _off(one.front, "K_N", value, bar + width, truth, FINITE * truth)
        allowed = FINITE * two.k_range + PRESSED * two.k_i_range + 1e-9 * job.peak / math.pi
        bar = one.k_range_spread + two.k_range_spread
        yield from _off(one.front, "ΔK_T", one.k_range, bar, two.k_range, allowed)
        zones = zip(one.slip_zones[-2:], two.slip_zones[-2:], strict=False)
        for zone, same in zones if len(one.slip_zones) == len(two.slip_zones) else ():
            if zone.resolved and same.resolved:
                bar = zone.spread + same.spread
                yield from _off(one.front, "d", zone.length, bar, same.length, BORDER)


def _late(job: Job) -> bool:
    return "friction_from" in job.tables["contacts"]["main"]


def _off(
    front: str, name: str, value: float, bar: float, truth: float, allowed: float
) -> Iterator[str]:
    """A number beyond its bar; one that is unknown, or whose bar is, is not wrong."""
    if abs(value - truth) > bar + allowed:
        yield f"{front}: {name} = {value:.6g} ± {bar:.2g}, should be {truth:.6g}"
