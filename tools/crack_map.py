# SPDX-License-Identifier: LGPL-3.0-or-later
"""Draw the drive of short cracks at an edge of half-planes in partial slip, for any K_N and ΔK_T.

    python tools/crack_map.py docs/images/crack_map.png

Next to an edge the pressure is K_N √s, constant, and the shear follows from the history of K_T, a
full reversal that slips over d = ΔK_T/(f K_N) (edge formulas, docs/theory.md). The stress of the
body, y < 0, is that of Westergaard's functions with the shear, or minus the pressure, as real part
at the surface: Z = √z - √(z - δ) for shear √s and √s - √(s - δ) inward of δ, and -√z for pressure.
Lengths are over d, stress over f K_N √d, which is half of the tension at the trailing edge.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from fretfe._typing import Array
from fretfe.analytic.cracks import EdgeCracks
from fretfe.decision.thresholds import opening_range
from fretfe.report.theme import STYLE, WIDTH, save_figure

FRICTION = 0.5
LENGTHS = np.geomspace(1e-2, 4, 70)
# Amplitudes of a bulk stress in phase with K_T; how far it lags, at the amplitude 1.
BULKS = 0.0, 0.5, 1.0, 2.0
LAGS = 0, 45, 90, 135, 180


def edge_stress(points: Array, times: Array, bulk: float, lag: float) -> Array:
    """(n, M, 3) xx, yy, xy at places (M, 2), x inward, by one steady cycle.

    Args:
        points: y <= 0.
        times: (n,) in radians; K_T goes as their sine.
        bulk: amplitude of a uniform stress along the surface.
        lag: of it behind K_T [radians].
    """
    z, y = points[:, 0] + 1j * points[:, 1], points[:, 1]

    def shear(length: Array) -> Array:
        """Stress where the shear has slipped over these lengths (n,)."""
        far = z - length[:, None]
        value, slope = np.sqrt(z) - np.sqrt(far), (1 / np.sqrt(z) - 1 / np.sqrt(far)) / 2
        parts = 2 * value.imag + y * slope.real, -y * slope.real, value.real - y * slope.imag
        return np.stack(parts, axis=-1)

    level, rises = np.sin(times)[:, None, None], (np.cos(times) > 0)[:, None, None]
    whole, sign = shear(np.ones(1)), np.where(rises, -1.0, 1.0)
    found = sign * (whole - 2 * shear((1 - sign * level)[:, 0, 0] / 2))
    value, slope = -np.sqrt(z), -1 / (2 * np.sqrt(z))
    pressed = value.real - y * slope.imag, value.real + y * slope.imag, -y * slope.real
    found = found + np.stack(pressed, axis=-1) / FRICTION
    found[..., 0] += bulk * np.sin(times - lag)[:, None]
    return np.asarray(found)


def drive(bulk: float, lag: float, lengths: Array = LENGTHS, states: int = 49) -> Array:
    """(C,) ΔK of cracks along the inward normal, over f K_N d √π, by states of the cycle."""
    cracks = EdgeCracks.of([0.0])
    points = cracks.points(lengths)
    times = np.linspace(-np.pi / 2, 1.5 * np.pi, states)
    stress = edge_stress(points.reshape(-1, 2), times, bulk, lag)
    k_1, k_2 = cracks.factors(lengths, stress.reshape(len(times), *points.shape[:-1], 3))
    return np.asarray(opening_range(k_1[:, 0], k_2[:, 0])[0] / np.sqrt(np.pi))


def _draw(axes: Axes, bulk: float, lag: int, color: float, label: str) -> None:
    found = drive(bulk, float(np.radians(lag)))
    axes.plot(LENGTHS, np.where(found > 0, found, np.nan), color=mpl.colormaps["viridis"](color),
              label=label)  # fmt: skip


def draw(path: Path) -> None:
    """Both panels: over the amplitude of the bulk stress, and over its lag."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2, sharey=True)
        for place, bulk in enumerate(BULKS):
            _draw(left, bulk, 0, place / len(BULKS), f"bulk stress {bulk:g}")
        for place, lag in enumerate(LAGS):
            _draw(right, 1.0, lag, place / len(LAGS), f"lag {lag}°")
        for axes in (left, right):
            axes.loglog()
            axes.set(xlabel="c/d", xlim=(LENGTHS[0], LENGTHS[-1]), ylim=(0.05, 9))
            for axis, ticks in ((axes.xaxis, (0.01, 0.1, 1)), (axes.yaxis, (0.1, 1))):
                axis.set_ticks(ticks, [f"{each:g}" for each in ticks])
                axis.set_minor_formatter(NullFormatter())
            axes.legend(loc="upper left")
        left.set_ylabel("ΔK / (f K_N d √π)")
        save_figure(figure, path)


if __name__ == "__main__":
    draw(Path(sys.argv[1]))
