# SPDX-License-Identifier: LGPL-3.0-or-later
"""Over time: loads, load paths, edge factors and loops."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fretfe._typing import Array, Indices
from fretfe.case import Case
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.headline import shown_stations
from fretfe.evaluate.resultants import shear_direction, shear_line
from fretfe.evaluate.stress import worst_states
from fretfe.history.solution import OPEN, Solution
from fretfe.history.state_array import blocks
from fretfe.loads import History
from fretfe.report.plotting import Axes, Figure
from fretfe.report.source import Shown, edge_title
from fretfe.report.texts import direction_text, number, with_prefix
from fretfe.report.theme import (
    BLUE,
    CYCLE,
    DOUBLE,
    GREY,
    LOAD,
    ORANGE,
    PALE,
    SINGLE,
    SMALL_TEXT,
    Plot,
    envelope,
    legend_above,
    make_plot,
    plain_axis,
    say_if_unknown,
    sparse,
)
from fretfe.results.model import Result
from fretfe.results.quantities import axis_label

FACTORS_INTRO = (
    "K_T belongs to the shear and is positive if the shear on body 2 points inward; K_I belongs to "
    "the changes of the pressure. Both are summed from the first state, as if nothing slipped. "
    "While the contact grows much, the sums are not the factors of its edge. Shaded: the evaluated "
    "cycle."
)
LOADS_INTRO = (
    "Shaded: the evaluated cycle. Load paths are those of the resultants P and Q of each contact, "
    "thick in the evaluated cycle (or everywhere if there is none), with a dot at its first state. "
    "On the dotted lines |Q| = f P the whole contact slides. σ0 is shown if it varies: it is the "
    "tension that gives half-planes the same mean of K_T over the two edges, counted from the "
    "first state."
)
# A tension that varies by less than this fraction of what matters is constant.
CONSTANT = 1e-3
LOOPS_INTRO = (
    "Contacts: the shear force over the displacement of body 1 relative to body 2, as a mean over "
    "the nodes that stay in contact; the area is the friction work only if all nodes slip alike. "
    "Driven boundaries: the force per unit thickness over the displacement, and to the right the "
    "same without the part of the displacement that is proportional to the force. This does not "
    "change the area, which is the work done in the cycle."
)
SOLID_LOOPS_INTRO = LOOPS_INTRO.replace(" per unit thickness", "").replace("the shear force", "Q")
WORST = "Only the worst counted cycle is shown, without the smaller cycles within it."
# A boundary whose force times displacement is below this fraction of the largest does no work.
NO_WORK = 1e-6
ROUND_OFF = 1e-9
# Values that change by less than this part of themselves are shown without their middle.
SMALL_CHANGE = 1e-3


def load_plot(run: Result) -> Plot | None:
    """All loads over time, one panel each; None without loads."""
    if not run.loads.channels:
        return None
    caption = "As prescribed in the case; each dot is a load step."
    height = LOAD * (len(run.loads.channels) + 0.4)
    return make_plot(
        "loads", "Loads", caption, height,
        lambda figure: draw_loads(rows_of(figure, len(run.loads.channels)), run.case, run.loads),
    )  # fmt: skip


def draw_loads(panels: list[Axes], case: Case, history: History) -> None:
    """One panel for each load, in the units of its history; the evaluated cycle is shaded."""
    time_panels(panels, case, history)
    for panel, name, values in zip(panels, history.channels, history.values.T, strict=True):
        shown = envelope(values)
        mark = ".-" if len(shown) == len(values) else "-"
        panel.plot(history.times[shown], values[shown], mark, ms=4, color=BLUE)
        # Beside the axis, names longer than a panel is high would lie on one another.
        panel.set_title(name, loc="left", fontsize=SMALL_TEXT)
        panel.set_ylabel(f"[{case.loads[name].unit(case.units)}]")
        plain_axis(panel, "y")
        if not values.any():
            panel.set_yticks([0.0])


def factor_plot(run: Result, contact: Contact, key: str) -> Plot:
    """K_T and K_I of both edges over time."""

    def draw(figure: Figure) -> None:
        sheared = any(np.any(edge.k_s) for edge in contact.edges)
        names = ("k_t", "k_s", "k_i") if sheared else ("k_t", "k_i")
        draw_factors(rows_of(figure, len(names)), run.case, run.loads, (contact,), names)

    return make_plot(f"{key}-factors", f"Contact {contact.name}", "", DOUBLE, draw)


def draw_factors(
    panels: list[Axes],
    case: Case,
    history: History,
    contacts: tuple[Contact, ...],
    names: Sequence[str] = ("k_n", "k_t"),
) -> None:
    """One panel for each factor, by the name of its attribute, with a line for each edge.

    Of solids there is one for the station of the largest range of each front. The evaluated cycle
    is shaded.
    """
    time_panels(panels, case, history)
    edges = shown_stations(contacts)
    for panel, name in zip(panels, names, strict=True):
        for place, (contact, edge) in enumerate(edges):
            owner = "" if len(contacts) == 1 else f"{contact.name}, "
            values = getattr(edge, name)
            states = envelope(values)
            marks = ("x--", ".-") if len(states) == len(values) else ("--", "-")
            known = np.count_nonzero(np.isfinite(values)) > 1
            panel.plot(
                history.times[states],
                values[states],
                marks[0 if place % 2 else 1],
                ms=3,
                markevery=sparse(values[states]),
                lw=1.0,
                color=CYCLE[place % len(CYCLE)],
                label=f"{owner}{edge_title(edge)}{'' if known else ', unknown'}",
            )
        say_if_unknown(panel, least=2)
        panel.axhline(0, color=GREY, lw=0.6)
        panel.set_ylabel(axis_label(name, case.units, solid=False))
    legend_above(panels[0], columns=2)


def rows_of(figure: Figure, count: int) -> list[Axes]:
    """Panels of one figure below each other, with one axis across."""
    return list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])


def time_panels(panels: list[Axes], case: Case, history: History) -> None:
    """Have panels below each other be over time, with the evaluated cycle shaded."""
    for panel in panels:
        panel.set_xlim(0.0, history.times[-1] or 1.0)
        if history.cycle is not None:
            first, last = history.cycle
            panel.axvspan(history.times[first], history.times[last], color=PALE, alpha=0.6, lw=0)
    panels[-1].set_xlabel(f"time [{case.units.time}]")


def path_plot(run: Result, contact: Contact, key: str) -> Plot:
    """Path of P and Q, and of Q and the tension if that varies."""
    tension = _tension_varies(run, contact)
    return make_plot(
        f"{key}-path",
        f"Load path, contact {contact.name}",
        "",
        SINGLE,
        lambda figure: _draw_path(figure, run, contact, tension),
    )


def _tension_varies(run: Result, contact: Contact) -> bool:
    """True if the tension changes K_T, next to what the shear force does.

    By (7a) of the theory guide 4Q/(π a) is the tension that changes it as much as Q.
    """
    first, last = run.loads.evaluated
    tension = contact.effective_tension[first : last + 1]
    a = np.nanmax(contact.half_width, initial=0.0)
    scale = 4 * np.abs(contact.shear_force).max() / (np.pi * a) if a > 0 else 0.0
    return bool(np.ptp(tension) > CONSTANT * max(scale, np.abs(tension).max()))


def _draw_path(figure: Figure, run: Result, contact: Contact, tension: bool) -> None:
    panels = figure.subplots(1, 1 + tension, squeeze=False, sharey=True)[0]
    normal, shear = contact.normal_force, contact.shear_force
    _trace(panels[0], run, normal, shear)
    largest = max(float(np.max(normal)), 0.0)
    friction = max((each.friction for each in contact.edges), default=math.nan)
    for sign in (1, -1):
        bound = [0.0, sign * friction * largest]
        panels[0].plot([0.0, largest], bound, color=GREY, lw=0.8, ls=":")
    panels[0].set_xlabel(run.axis_label("normal_force"))
    panels[0].set_ylabel(run.axis_label("shear_force"))
    if tension:
        _trace(panels[1], run, contact.effective_tension, shear)
        panels[1].set_xlabel(run.axis_label("effective_tension"))


def _trace(axes: Axes, run: Result, x: Array, y: Array) -> None:
    first, last = run.loads.evaluated
    for states, colour, width, line in (
        (slice(0, len(x)), ORANGE, 0.8, "--"),
        (slice(first, last + 1), BLUE, 2.0, "-"),
    ):
        seen = np.union1d(envelope(x[states]), envelope(y[states]))
        axes.plot(x[states][seen], y[states][seen], color=colour, lw=width, ls=line)
    axes.plot(x[first], y[first], "o", color="black", ms=4)
    axes.axhline(0, color=GREY, lw=0.4)


def slip_loop_plot(shown: Shown) -> Plot | None:
    """Q over the mean slip of a contact; None if no node stays in contact."""
    first, last = shown.run.loads.evaluated
    solution = shown.run.solution
    path = worst_states(shown.run.solution, [shown.summary])
    if len(path) and not solution.keeps(int(path[0]), int(path[-1])):
        # Its first half is in the repetition before the cycle.
        path = path[path >= first]
    if len(path):
        first, last = int(path[0]), int(path[-1])
    if last - first < 2 or not solution.keeps(first, last):
        return None
    states, tractions = slice(first, last + 1), shown.tractions
    count = len(tractions.surface.weights)
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
        means.append(moved @ (tractions.surface.weights * closed))
    slip = np.concatenate(means)
    slip = (slip - slip[0]) / shown.tractions.surface.weights[closed].sum()
    cycle = shown.run.loads.cycle is not None
    work = f"{number(shown.summary.reported_dissipation)} {shown.run.unit('work')}"
    when = "evaluated cycle" if cycle else "whole history, which is shown: there is no cycle"
    caption = f"Friction work of this contact in the {when}: {work}."
    if len(path):
        slip, force = slip[path - first], force[path - first]
        caption += f" {WORST}"

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        seen = np.union1d(envelope(slip), envelope(force))
        scale, length = with_prefix(shown.run.case.units.length, float(np.abs(slip).max()))
        axes.plot(slip[seen] / scale, force[seen], ".-", ms=4, lw=1.2, color=BLUE)
        plain_axis(axes, "x")
        axes.set_xlabel(f"mean slip since the first of these states [{length}]")
        axes.set_ylabel(f"{name} [{shown.run.unit('force')}]")

    return make_plot(f"{shown.key}-loop", f"Contact {shown.summary.name}", caption, SINGLE, draw)


def _shear(shown: Shown, states: slice) -> tuple[Array, Array, str]:
    """Direction of the shear at the nodes (N, d - 1), the force along it in some states, its name.

    Of solids, and where plane bodies move along z, it is the direction in which Q varies most.
    """
    contact, force = shown.tractions, shown.summary.shear_force[states]
    if not shown.summary.solid:
        line, vectors = shear_line(shown.summary, states), shown.summary.shear_vectors[states]
        name = "Q" if len(line) == 1 else f"Q along {direction_text(np.insert(line, 1, 0.0))}"
        return np.tile(line, (len(contact.surface.weights), 1)), vectors @ line, name
    direction = shear_direction(force)
    name = f"Q along {direction_text(direction)}"
    return contact.surface.frames[:, 1:] @ direction, force @ direction, name


def work_loop_plots(run: Result) -> list[Plot]:
    """Force over displacement of each boundary that works during the cycle."""
    solution = run.solution
    if solution.cycle is None:
        return []
    states = slice(solution.cycle[0], solution.cycle[1] + 1)
    forces, amplitudes = solution.forces[states], solution.amplitudes[states]
    scales = np.ptp(amplitudes, axis=0) * np.abs(forces).max(axis=0)
    working = np.flatnonzero(scales > NO_WORK * scales.max(initial=0.0))
    areas = [loop_area(forces[:, i], amplitudes[:, i]) for i in working]
    balance = _balance(run, solution, sum(areas))
    path = worst_states(run.solution, run.contacts)
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
    friction = sum(contact.dissipation for contact in run.contacts)
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


def _middle(values: Array) -> float:
    """Middle of values that differ by a small part of themselves, to three digits; else 0.

    Ticks with six digits would be the same number.
    """
    if np.ptp(values) > SMALL_CHANGE * np.abs(values).max():
        return 0.0
    return float(f"{(values.min() + values.max()) / 2:.3g}")


def _work_loop(
    run: Result, label: str, index: int, area: float, balance: str, path: Indices
) -> Plot:
    solution, units = run.solution, run.case.units
    assert solution.cycle is not None
    states = path if len(path) else np.arange(solution.cycle[0], solution.cycle[1] + 1)
    force, displacement = solution.forces[states, index], solution.amplitudes[states, index]
    load = run.case.loads.get(label)
    moved, moved_unit, force_label, unit = {
        "tilt": ("rotation", "rad", "moment", run.unit("work")),
        "shape": ("factor of the shape", "1", "work per factor", run.unit("work")),
    }.get(
        load.type if load is not None else "",
        ("displacement", units.length, "force", run.unit("force")),
    )
    caption = f"Area: {number(area)} {run.unit('work')}. {balance}"
    if len(path):
        caption = f"{WORST} Work in the whole cycle: {number(area)} {run.unit('work')}. {balance}"

    def draw(figure: Figure) -> None:
        panels = figure.subplots(1, 2, sharey=True)
        middle = _middle(displacement)
        reduced = without_slope(force, displacement)
        for axes, values in zip(panels, (displacement - middle, reduced), strict=True):
            seen = np.union1d(envelope(values), envelope(force))
            scale, unit_shown = with_prefix(moved_unit, float(np.abs(values).max()))
            axes.plot(values[seen] / scale, force[seen], ".-", ms=4, lw=1.2, color=BLUE)
            plain_axis(axes, "x")
            name = f"{'less its slope' if values is reduced else moved} [{unit_shown}]"
            if middle and values is not reduced:
                name += f"\n{'less' if middle > 0 else 'plus'} {abs(middle):g} {moved_unit}"
            axes.set_xlabel(name)
            axes.tick_params(axis="x", labelrotation=30)
        if np.ptp(force) <= ROUND_OFF * np.abs(force).max():
            panels[0].set_yticks([force[0]], [number(float(force[0]))])
        panels[0].set_ylabel(f"{force_label} [{unit}]")

    return make_plot(
        f"work{index}", f"{force_label.capitalize()} and {moved}: {label}", caption, SINGLE, draw
    )
