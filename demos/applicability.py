# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where may the edge formulas be used? Their error over load level, phase and profile.

Pads on half-planes under cycles of shear force Q, bulk tension and normal force P are solved, and
the slip zones that are found are compared with those that the edge factors predict: by the range of
K_T at constant P, eqs. (9) and (10), and by K_T and K_I where P varies, eq. (11) of docs/theory.md.
The script draws maps of the largest error of both edges and both half cycles, and ends with the
error under a shear force alone against exact solutions (Ciavarella 1998, Jäger 1998).

Run it with: python demos/applicability.py [FIGURE.png]
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from compare import Row, finish
from matplotlib.axes import Axes
from matplotlib.contour import QuadContourSet
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fretfe.analytic.edges import asymptote_error, slip_length_loop, tension_for_zero_factor
from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge
from fretfe.environment import rank_from_environment
from fretfe.evaluate.contacts import SlipZone, Station
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
from fretfe.idealise import HalfPlaneProblem
from fretfe.loads import History

Array = NDArray[np.float64]

# Steel on steel; the flat of half-width b, all contacts of half-width 1 mm at the mean of P.
MODULUS, FRICTION, HALF_WIDTH = 115e3, 0.5, 1.0
PROFILES: dict[str, Profile] = {
    "cylinder": Hertz(50.0, MODULUS),
    "flat and rounded, b/a = 0.5": FlatRounded(0.5, 50.0, MODULUS),
    "flat and rounded, b/a = 0.9": FlatRounded(0.9, 50.0, MODULUS),
    "wedge": Wedge(0.02, MODULUS),
}
# Amplitude of Q over f P; how far tension lags behind Q in degrees, where 180 less that exchanges
# the edges; amplitude of P over its mean.
LEVELS = np.array([0.1, 0.25, 0.4, 0.55])
PHASES = np.array([0.0, 30.0, 60.0, 90.0])
VARIATIONS = np.array([0.05, 0.15, 0.25])
# Slip zones shorter than this part of P/P'(a), found and predicted, do not count: the formula has
# Q/(f P) times that.
SHORTEST = 0.04
# Factor of the tension over that of Q.
TENSION = 0.5
# Steps of the pressing, of the first quarter cycle, and of each of two cycles.
PRESS, QUARTER, CYCLE = 5, 8, 24
# Error at which the colours end, and the lines that are drawn, in per cent.
LARGEST, LINES = 30, [-20, -10, -5, 0, 5, 10, 20]


def waves(phase: float = 0.0) -> Array:
    """(n,) a sine that lags by some degrees, from its start through two cycles and a quarter."""
    first = np.linspace(0.0, 0.25, QUARTER + 1)[:-1]
    cycles = 0.25 + np.arange(2 * CYCLE + 1) / CYCLE
    lag = np.deg2rad(phase)
    started = np.append(first / 0.25, np.ones(len(cycles)))
    # From zero: a load that lags grows to its own value in the first quarter.
    return np.asarray(started * np.sin(2 * np.pi * np.append(first, cycles) - lag))


def slip_errors(profile: Profile, normal: Array, shear: Array, tension: Array) -> Array:
    """(k,) predicted/found - 1 of the slip zones in the last cycle; NaN where they are unknown.

    Normal force, shear force and tension (n,) act after the pad has been pressed on without
    friction.
    """
    press = np.linspace(0.0, normal[0], PRESS + 1)[:-1]
    loads = [
        np.concatenate([before, load])
        for before, load in ((press, normal), (0 * press, shear), (0 * press, tension))
    ]
    count = len(loads[0])
    friction = np.where(np.arange(count) > PRESS, FRICTION, 0.0)
    cycle = (count - 1 - CYCLE, count - 1)
    history = History(("step",), np.arange(float(count)), np.zeros((count, 1)), cycle)
    outcome = solve_half_planes(
        HalfPlaneProblem(
            "main", "pad", "block", profile, history, friction,
            normal_force=loads[0], shear_force=loads[1], moment=0 * loads[0], bulk_tension=loads[2],
        )
    )  # fmt: skip
    (contact,) = evaluate(outcome.solution, outcome.unit_factors)
    pairs = [(edge, zone) for edge in contact.stations for zone in edge.slip_zones[-2:]]
    found = np.array([zone.length for _, zone in pairs])
    predicted = np.array([by_formula(edge, zone, cycle) for edge, zone in pairs])
    known = np.array([zone.resolved and not zone.gross for _, zone in pairs])
    scale = float(profile.load(HALF_WIDTH) / profile.load_slope(HALF_WIDTH))
    counts = ~(np.fmax(found, predicted) < SHORTEST * scale)
    return np.where(known, predicted / np.where(found > 0, found, np.nan) - 1, np.nan)[counts]


def by_formula(edge: Station, zone: SlipZone, cycle: tuple[int, int]) -> float:
    """Length of a slip zone by the factors in a cycle: (11), at constant P (9) and (10)."""
    first, last = cycle
    k_t, k_i = edge.k_t[first : last + 1], edge.k_i[first : last + 1]
    return float(slip_length_loop(k_t, k_i, float(edge.k_n[zone.end]), FRICTION, zone.end - first))


def worst(errors: Array) -> float:
    """The error that is largest; NaN if one is unknown, or nothing slips."""
    return float(errors[np.argmax(np.abs(errors))]) if len(errors) else np.nan


def with_tension(profile: Profile, level: float, phase: float) -> float:
    """Worst error under shear and tension that lags behind, at constant P: eq. (10)."""
    normal = float(profile.load(HALF_WIDTH))
    shear = level * FRICTION * normal
    tension = TENSION * abs(float(tension_for_zero_factor(shear, HALF_WIDTH, "left")))
    sine = waves()
    return worst(slip_errors(profile, normal + 0 * sine, shear * sine, tension * waves(phase)))


def with_varying_load(profile: Profile, level: float, variation: float) -> float:
    """Worst error under shear and normal force that vary in step: eq. (11)."""
    normal = float(profile.load(HALF_WIDTH))
    sine = waves()
    shear = level * FRICTION * normal * sine
    return worst(slip_errors(profile, normal * (1 + variation * sine), shear, 0 * sine))


def draw_map(axes: Axes, down: Array, error: Callable[[float, float], float]) -> QuadContourSet:
    """Colours and lines of equal error over the level of Q and something else."""
    errors = 100 * np.array([[error(level, other) for level in LEVELS] for other in down])
    steps = np.linspace(-LARGEST, LARGEST, 25)
    colours = axes.contourf(LEVELS, down, errors, steps, cmap="RdBu_r", extend="both")
    axes.contour(LEVELS, down, errors, LINES, colors="black", linewidths=0.7)
    # Nothing is drawn where the contact slides, or a slip zone cannot be told.
    axes.set_facecolor("0.85")
    return colours


def draw(path: Path) -> None:
    """Draw all maps."""
    figure = Figure(figsize=(12.0, 6.4), layout="constrained")
    panels = figure.subplots(2, len(PROFILES), sharex=True, sharey="row")
    for (name, profile), (above, below) in zip(PROFILES.items(), panels.T, strict=True):
        draw_map(above, PHASES, partial(with_tension, profile))
        colours = draw_map(below, VARIATIONS, partial(with_varying_load, profile))
        above.set_title(name)
        below.set_xlabel("amplitude of Q over f P")
    panels[0, 0].set_ylabel("lag of the tension behind Q [degrees]")
    panels[1, 0].set_ylabel("amplitude of P over its mean")
    bar = figure.colorbar(colours, ax=panels, label="predicted over found slip zone, less 1 [%]")
    bar.set_ticks(LINES)
    figure.savefig(path, dpi=120)


def by_shear_alone() -> list[Row]:
    """Errors under a shear force alone against exact ones."""
    rows = []
    for name, profile in PROFILES.items():
        normal, sine = float(profile.load(HALF_WIDTH)), waves()
        for level in (0.2, 0.45):
            shear = level * FRICTION * normal
            errors = slip_errors(profile, normal + 0 * sine, shear * sine, 0 * sine)
            length = shear / (FRICTION * float(profile.load_slope(HALF_WIDTH)))
            exact = 1 + float(asymptote_error(profile, HALF_WIDTH, length))
            label = f"{name}, Q/(f P) = {level}"
            rows.append(Row(label, 1 + worst(errors), exact, 0.01))
    return rows


if __name__ == "__main__":
    if rank_from_environment() == 0:
        draw(Path(sys.argv[1] if len(sys.argv) > 1 else "applicability.png"))
        finish(by_shear_alone())
