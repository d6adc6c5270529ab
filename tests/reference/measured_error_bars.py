# SPDX-License-Identifier: LGPL-3.0-or-later
"""Print the tables of noise in docs/edges.md: errors of K_N, edge and slip zones, and their bars.

Run it with: .venv/bin/PYTHONPATH=tests python -m reference.measured_error_bars
"""

from __future__ import annotations

import numpy as np
from cases.edge_contacts import HERTZ
from evaluate import test_sampled_tractions as tractions
from evaluate.plane import test_pressure_fit as pressures
from reference.halfplane_galerkin import graded_nodes, uniform_nodes

from fretfe._typing import Array
from fretfe.analytic.profiles import FlatRounded

NOISES = (0.001, 0.005, 0.01)
FLAT_5, FLAT_8 = (FlatRounded(flat, 1.0, 1.0) for flat in (0.5, 0.8))
PRESSURES = {
    name.replace(".", "0."): sampled
    for name, sampled in pressures.SAMPLED.items()
    if name != "Hertz .015"
} | {
    "flat 0.5, 50, uniform": pressures.Sampled(uniform_nodes(0.01, 0.3), FLAT_5),
    "flat 0.8, 20, uniform": pressures.Sampled(uniform_nodes(0.01, 0.3), FLAT_8),
}
TRACTIONS = {
    "Hertz 0.02": tractions.Sampled(uniform_nodes(0.02, 0.3), 0.3, HERTZ),
    "Hertz 0.01": tractions.Sampled(uniform_nodes(0.01, 0.3), 0.3, HERTZ),
    "Hertz 0.01, short": tractions.Sampled(uniform_nodes(0.01, 0.3), 0.15, HERTZ),
    "Hertz 0.01, long": tractions.Sampled(uniform_nodes(0.01, 0.3), 0.6, HERTZ),
    "flat 0.5, 100": tractions.Sampled(graded_nodes(0.005, 0.05, 0.3), 0.3, FLAT_5),
    "flat 0.8, 100": tractions.Sampled(graded_nodes(0.002, 0.05, 0.3), 0.3, FLAT_8),
}


def cells(errors: Array, bars: Array) -> str:
    """Median error, what 95 % stay below, both in %, percentage covered, and ratio."""
    median, most = np.percentile(errors, [50, 95]) * 100
    ratio = np.median(bars) / np.median(errors)
    return f"{median:.2g} | {most:.2g} | {np.mean(errors < bars) * 100:.0f} | {ratio:.1f}"


def print_tables() -> None:
    """K_N and edge from pressures, then slip zones; rows as in the document."""
    for name, pressure in PRESSURES.items():
        for noise in NOISES:
            k_n, bar, shift, bar_of_shift = pressure.draws(noise, 200)
            print(
                f"| {name} | {100 * noise:g} % | {cells(k_n, bar)} | {cells(shift, bar_of_shift)} |"
            )
    for name, traction in TRACTIONS.items():
        title = f"{name.rsplit(', ')[0]}, d = {traction.slip_length:.2f}"
        if name.startswith("flat"):
            title = f"{name}, d = {traction.slip_length:.2f}"
        for noise in NOISES:
            errors, bars = traction.draws(noise, 60)
            slip = cells(errors[:, 2], bars[:, 2])
            print(f"| {title} | {100 * noise:g} % | {slip} | {cells(errors[:, 3], bars[:, 3])} |")


if __name__ == "__main__":
    print_tables()
