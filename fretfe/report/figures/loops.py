# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loops of force and displacement: what friction dissipates in the evaluated cycle."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from fretfe._typing import Array, Indices
from fretfe.edges.area import shear_direction
from fretfe.report.figures.plot import Plot, envelope, make_plot, plain_axis
from fretfe.report.source import (
    Shown,
    ShownArea,
    force_unit,
    work_unit,
    worst_run_states,
    worst_states,
)
from fretfe.report.texts import direction_text, number
from fretfe.report.theme import BLUE, SINGLE
from fretfe.results.model import Result
from fretfe.results.solution import OPEN, Solution
from fretfe.results.states import blocks

INTRO = (
    "Contacts: the shear force over the displacement of body 1 relative to body 2, as a mean over "
    "the nodes that stay in contact; the area is the friction work only if all nodes slip alike. "
    "Driven boundaries: the force per unit thickness over the displacement, and to the right the "
    "same without the part of the displacement that is proportional to the force. This does not "
    "change the area, which is the work done in the cycle."
)
SOLID_INTRO = INTRO.replace(" per unit thickness", "").replace("the shear force", "Q")
WORST = "Only the worst counted cycle is shown, without the smaller cycles within it."
# A boundary whose force times displacement is below this fraction of the largest does no work.
NO_WORK = 1e-6
ROUND_OFF = 1e-9


def slip_loop_plot(shown: Shown | ShownArea) -> Plot | None:
    """Q over the mean slip of a contact; None if no node stays in contact."""
    first, last = shown.run.loads.evaluated
    solution = shown.run.solution
    assert solution is not None
    path = worst_states(shown) if isinstance(shown, Shown) else np.zeros(0, dtype=np.int64)
    if len(path) and not solution.keeps(int(path[0]), int(path[-1])):
        # Its first half is in the repetition before the cycle.
        path = path[path >= first]
    if len(path):
        first, last = int(path[0]), int(path[-1])
    if last - first < 2 or not solution.keeps(first, last):
        return None
    states, tractions = slice(first, last + 1), shown.tractions
    count = len(tractions.weights)
    closed, means = np.ones(count, dtype=bool), []
    parts = [range(first, last + 1)[part] for part in blocks(last + 1 - first, count)]
    for part in parts:
        touching = tractions.status[part[0] : part[-1] + 1] != OPEN
        # Nothing is in contact before the first step.
        closed &= touching[1 if part[0] == 0 else 0 :].all(axis=0)
    if not closed.any():
        return None
    along, force, name = _shear(shown, states)
    for part in parts:
        moved = np.einsum("tnc,nc->tn", tractions.slip[part[0] : part[-1] + 1], along)
        means.append(moved @ (tractions.weights * closed))
    slip = np.concatenate(means)
    slip = (slip - slip[0]) / shown.tractions.weights[closed].sum()
    cycle = shown.run.loads.cycle is not None
    work = f"{number(shown.summary.dissipation)} {work_unit(shown.run)}"
    when = "evaluated cycle" if cycle else "whole history, which is shown: there is no cycle"
    caption = f"Friction work of this contact in the {when}: {work}."
    if len(path):
        slip, force = slip[path - first], force[path - first]
        caption += f" {WORST}"

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        seen = np.union1d(envelope(slip), envelope(force))
        axes.plot(slip[seen], force[seen], ".-", ms=4, lw=1.2, color=BLUE)
        plain_axis(axes, "x")
        length = shown.run.case.units.length
        axes.set_xlabel(f"mean slip since the first of these states [{length}]")
        axes.set_ylabel(f"{name} [{force_unit(shown.run)}]")

    return make_plot(f"{shown.key}-loop", f"Contact {shown.summary.name}", caption, SINGLE, draw)


def _shear(shown: Shown | ShownArea, states: slice) -> tuple[Array, Array, str]:
    """Direction of the shear at the nodes (N, d - 1), the force along it in some states, its name.

    Of solids it is the direction in which Q varies most.
    """
    contact, force = shown.tractions, shown.summary.shear_force[states]
    if isinstance(shown, Shown):
        return np.ones((len(contact.weights), 1)), force, "Q"
    direction = shear_direction(force)
    name = f"Q along {direction_text(direction)}"
    return contact.frames[:, 1:] @ direction, force @ direction, name


def work_loop_plots(run: Result) -> list[Plot]:
    """Force over displacement of each boundary that works during the cycle."""
    solution = run.solution
    if solution is None or solution.cycle is None:
        return []
    states = slice(solution.cycle[0], solution.cycle[1] + 1)
    forces, amplitudes = solution.forces[states], solution.amplitudes[states]
    scales = np.ptp(amplitudes, axis=0) * np.abs(forces).max(axis=0)
    working = np.flatnonzero(scales > NO_WORK * scales.max(initial=0.0))
    areas = [loop_area(forces[:, i], amplitudes[:, i]) for i in working]
    balance = _balance(run, solution, sum(areas))
    path = worst_run_states(run)
    return [
        _work_loop(run, solution.coordinates[i], int(i), area, balance, path)
        for i, area in zip(working, areas, strict=True)
    ]


def loop_area(force: Array, displacement: Array) -> float:
    """Work of a force over a closed path: the trapezoidal rule for ∮ F du."""
    return float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(displacement)))


def without_slope(force: Array, displacement: Array) -> Array:
    """The displacement less its best multiple of the force, which leaves the area of a loop."""
    centred = force - force.mean()
    size = float(centred @ centred)
    if size <= ROUND_OFF * float(force @ force):
        return displacement - displacement.mean()
    return displacement - displacement.mean() - centred * float(centred @ displacement) / size


def _balance(run: Result, solution: Solution, total: float) -> str:
    """Work of all boundaries next to the friction work of all contacts."""
    first, last = run.loads.evaluated
    friction = sum(contact.dissipation for contact in run.summaries)
    text = (
        f"All loops of boundaries together: {number(total)}; friction work of all contacts in the "
        f"cycle: {number(float(friction))}."
    )
    others = [
        name
        for name, values in zip(solution.drivers, solution.driver_values.T, strict=True)
        if name not in solution.coordinates and np.ptp(values[first : last + 1]) > 0
    ]
    if others:
        return f"{text} They differ by the work of {', '.join(others)}."
    return f"{text} In a steady cycle they are equal up to the size of the load steps."


def _work_loop(
    run: Result, label: str, index: int, area: float, balance: str, path: Indices
) -> Plot:
    solution, units = run.solution, run.case.units
    assert solution is not None and solution.cycle is not None
    states = path if len(path) else np.arange(solution.cycle[0], solution.cycle[1] + 1)
    force, displacement = solution.forces[states, index], solution.amplitudes[states, index]
    load = run.case.loads.get(label)
    turns = load is not None and load.type == "tilt"
    moved, force_label = ("rotation", "moment") if turns else ("displacement", "force")
    moved_unit, unit = ("rad", work_unit(run)) if turns else (units.length, force_unit(run))
    caption = f"Area: {number(area)} {work_unit(run)}. {balance}"
    if len(path):
        caption = f"{WORST} Work in the whole cycle: {number(area)} {work_unit(run)}. {balance}"

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, 2, sharey=True)
        reduced = without_slope(force, displacement)
        for axes, values in zip(panels, (displacement, reduced), strict=True):
            seen = np.union1d(envelope(values), envelope(force))
            axes.plot(values[seen], force[seen], ".-", ms=4, lw=1.2, color=BLUE)
            plain_axis(axes, "x")
            axes.set_xlabel(f"{moved} [{moved_unit}]")
            axes.tick_params(axis="x", labelrotation=30)
        panels[1].set_xlabel(f"the same less its slope [{moved_unit}]")
        panels[0].set_ylabel(f"{force_label} [{unit}]")

    return make_plot(
        f"work{index}", f"{force_label.capitalize()} and {moved}: {label}", caption, SINGLE, draw
    )
