# SPDX-License-Identifier: LGPL-3.0-or-later
"""What does an edge remember? The shear locked in next to it, at four moments of a mission.

A cylinder on a half-plane is pressed and pushed in proportion, pushed on, drawn back with less P,
and pushed again. Places are named by the load P at which the edge stood on them; D is the part of
f p with which each is locked in (docs/memory.md). The script draws D over these places, and ends
with the slip zones of both edges by the slip of the nodes beside those that the memory tells.

Run it with: python demos/memory.py [FIGURE.png]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from compare import Row, finish
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fretfe.analytic.profiles import Hertz
from fretfe.environment import rank_from_environment
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.edge_memory import EdgeMemory
from fretfe.evaluate.evaluate import evaluate
from fretfe.halfplane import solve_half_planes
from fretfe.idealise import HalfPlaneProblem
from fretfe.loads import History

Array = NDArray[np.float64]

# Steel on steel; contacts of half-width 1 mm at the largest P.
PROFILE, FRICTION = Hertz(50.0, 115e3), 0.5
# P over its largest, and Q over f times that, at the ends of the ramps of so many steps.
CORNERS, STEPS = np.array([(0, 0), (0.8, 0.24), (0.8, 0.56), (0.5, -0.1), (1.0, 0.45)]), 8
TITLES = (
    "pressed and pushed in proportion: nothing slips",
    "pushed on: slip from the edge inward",
    "drawn back: slip the other way",
    "pressed on, with more shear than P takes",
)


def loads() -> tuple[Array, Array]:
    """(n,) P and Q at all states."""
    at = np.linspace(0, len(CORNERS) - 1, STEPS * (len(CORNERS) - 1) + 1)
    p, q = (np.interp(at, np.arange(len(CORNERS)), each) for each in CORNERS.T)
    largest = float(PROFILE.load(1.0))
    return largest * p, FRICTION * largest * q


def solved() -> tuple[Contact, list[int]]:
    """The evaluated contact, and the states at the ends of the ramps."""
    p, q = loads()
    history = History(("step",), np.arange(float(len(p))), np.zeros((len(p), 1)), None)
    outcome = solve_half_planes(
        HalfPlaneProblem(
            "main", "pad", "block", PROFILE, history, np.full(len(p), FRICTION),
            normal_force=p, shear_force=q, moment=0 * p, bulk_tension=0 * p,
        )
    )  # fmt: skip
    (contact,) = evaluate(outcome.solution, outcome.unit_factors)
    return contact, outcome.solution.ends[STEPS::STEPS].tolist()


def draw(contact: Contact, moments: list[int], path: Path) -> None:
    """D over place at some moments, at the left edge."""
    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
    edge, friction = contact.stations[0], np.full(len(contact.normal_force), FRICTION)
    for axes, moment, title in zip(panels, moments, TITLES, strict=True):
        memory = EdgeMemory.of(edge, friction, moment)
        assert memory is not None
        low, share = memory.slip.locked.T
        hold = np.append(low, edge.hold[moment]) / edge.hold.max()
        axes.stairs(share, hold, fill=True, color="C0", alpha=0.35)
        axes.stairs(share, hold, color="C0", linewidth=1.4)
        axes.axvline(hold[-1], color="black", linewidth=1.0)
        axes.set_title(title, fontsize=10)
    panels[0].set(xlim=(0.0, 1.05), ylim=(-1.15, 1.15))
    for axes in panels[2:]:
        axes.set_xlabel("place: P of the edge there, over the largest")
    for axes in panels[::2]:
        axes.set_ylabel("D")
    figure.savefig(path, dpi=120)


def compared(contact: Contact) -> Iterator[Row]:
    """Slip zones by the nodes beside those that the memory tells."""
    for station in contact.stations:
        for zone in station.slip_zones:
            name = f"d from {station.front} edge, state {zone.end}"
            yield Row(name, zone.length, zone.predicted_loop, 0.03)


if __name__ == "__main__":
    found, ends = solved()
    if len(sys.argv) > 1 and rank_from_environment() == 0:
        draw(found, ends, Path(sys.argv[1]))
    finish(compared(found))
