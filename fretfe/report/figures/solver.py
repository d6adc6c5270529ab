# SPDX-License-Identifier: LGPL-3.0-or-later
"""Solution of the steps: iterations and certificates; changes from mesh to mesh."""

from __future__ import annotations

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.refinement import KINDS, Refinement
from fretfe.history.solution import Solution
from fretfe.report.plotting import Axes, Figure, MaxNLocator
from fretfe.report.theme import (
    BLUE,
    GREEN,
    GREY,
    LOW,
    ORANGE,
    VERMILLION,
    Plot,
    envelope,
    legend_above,
    log_axis,
    make_plot,
)


def iteration_plot(solution: Solution) -> Plot:
    """Newton iterations, parts and fallbacks of each step."""
    cut = int(np.count_nonzero(solution.parts > 1))
    slow = int(solution.fallbacks.sum())
    text = "once" if slow == 1 else f"{slow} times" if slow else "nowhere"
    caption = (
        f"{int(solution.iterations.sum())} iterations in {len(solution.times) - 1} steps. "
        f"{cut or 'No'} step{'' if cut == 1 else 's'} had to be divided; the slow method "
        f"was needed {text}."
    )
    return make_plot(
        "iterations", "Iterations", caption, LOW, lambda figure: _iterations(figure, solution)
    )


def _iterations(figure: Figure, solution: Solution) -> None:
    axes = figure.subplots()
    steps = np.arange(1, len(solution.times))
    shown = envelope(solution.iterations[1:])
    iterations, label = solution.iterations[1:][shown], "Newton iterations"
    if len(shown) == len(steps):
        axes.stairs(iterations, np.arange(len(steps) + 1) + 0.5, fill=True, color=BLUE, label=label)
    else:
        axes.plot(steps[shown], iterations, lw=0.8, color=BLUE, label=label)
    for values, mark, colour, label in (
        (np.where(solution.parts > 1, solution.parts, 0), "s", ORANGE, "parts of a divided step"),
        (solution.fallbacks, "x", VERMILLION, "fallbacks"),
    ):
        there = np.flatnonzero(values[1:] > 0)
        if len(there):
            axes.plot(steps[there], values[1:][there], mark, color=colour, ms=5, label=label)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("load step")
    axes.set_ylabel("number")
    legend_above(axes, columns=3)


def certificate_plot(solution: Solution) -> Plot | None:
    """Violations of the contact conditions and of equilibrium; None if there is nothing but 0."""
    worst = solution.certificates["worst"][1:]
    imbalance = solution.imbalance("force")[1:]
    if not np.any(worst > 0) and not np.any(imbalance > 0):
        return None

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        steps = np.arange(1.0, len(solution.times))
        _dots(axes, steps, worst, ".", BLUE, "contact conditions")
        _dots(axes, steps, imbalance, "x", VERMILLION, "sum of forces on a body")
        log_axis(axes, "y")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("load step")
        axes.set_ylabel("relative violation [-]")
        legend_above(axes, columns=1)

    return make_plot(
        "certificate",
        "Certificate of each step",
        "The largest violation of a contact condition over its scale, and the largest sum of all "
        "forces on a body over the largest force. Zeros are not drawn. They show that the discrete "
        "equations are solved, not that the mesh is fine enough.",
        LOW,
        draw,
    )


def _dots(axes: Axes, x: Array, y: Array, mark: str, colour: str, label: str) -> None:
    seen = envelope(y)
    axes.plot(x[seen], np.where(y > 0, y, np.nan)[seen], mark, ms=4, color=colour, label=label)


def refinement_plot(refinement: Refinement) -> Plot | None:
    """Changes of the results from mesh to mesh; None with a single mesh."""
    passes = refinement.passes
    if len(passes) < 2:
        return None
    changes = np.array([[done.of_kind(kind) for kind in KINDS] for done in passes[1:]])
    unknowns = [done.unknowns for done in passes[1:]]
    if not np.any(np.isfinite(changes) & (changes > 0)):
        return None

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for values, mark, colour, label in zip(
            changes.T, ("o-", "s--", "^:"), (BLUE, VERMILLION, GREEN), KINDS, strict=True
        ):
            shown = np.where(np.isfinite(values) & (values > 0), values, np.nan)
            axes.plot(unknowns, shown, mark, ms=5, lw=1.0, color=colour, label=label)
        axes.axhline(refinement.tolerance, color=GREY, lw=0.8, ls="-.", label="tolerance")
        log_axis(axes, "y")
        axes.set_xlabel("unknowns [-]")
        axes.set_ylabel("relative change [-]")
        legend_above(axes, columns=2)

    return make_plot(
        "refinement",
        "Changes from mesh to mesh",
        "Largest change at any edge from the mesh before. Zeros are not drawn.",
        LOW,
        draw,
    )
