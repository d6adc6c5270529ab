# SPDX-License-Identifier: LGPL-3.0-or-later
"""Plane contacts of half-planes with any gap that bodies close without turning.

The edges c - a and c + a follow from g' alone: with x = c + a sin(angle), from -pi/2 to pi/2,

    0 = int g'(x) dangle        P/E* = (1/2) int g'(x) a sin(angle) dangle

so that the pressure vanishes at both. Each increment of P is that of a flat punch as wide as the
contact is by then, and an edge moves by de as its punch factor grows by dK_I = K_N/2 de (Johnson
1985, section 2.7, for the two integrals; `fretfe.analytic.profiles` for even gaps).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array

WIDTHS = 60
ANGLES = 160
HALVINGS = 25
# Parts of the load between which edges move.
NEARBY = (0.9, 1.1)


@dataclass(frozen=True)
class StripContact:
    """A plane contact under a load, per unit thickness; pressures and K_N over E*.

    Attributes:
        edges: (2,) places of the left and the right edge.
        growth: (2,) outward movement of the edges by the growth of ln P.
        peaks: (2,) largest pressure on either side.
        k_n: (2,) K_N at both edges.
    """

    edges: Array
    growth: Array
    peaks: Array
    k_n: Array

    @property
    def half_width(self) -> float:
        """Half of the distance between the edges."""
        return float(np.ptp(self.edges)) / 2


def strip_contact(along: Array, gap: Array, load: float) -> StripContact | None:
    """The contact under a load; None if it is wider than the surfaces, tiny, or in several parts.

    Args:
        along: (n,) places along the surface.
        gap: (n,) initial gap there, between sharp corners of which nothing follows.
        load: P/E*.
    """
    widest = float(np.ptp(along)) / 2
    if not widest > 0 or not np.ptp(gap) > 0:
        return None
    # Between places that are next to each other slopes are round-off.
    _, order = np.unique(np.round((along - along.min()) / widest, 5), return_index=True)
    x, slopes = _middles(along[order]), np.diff(gap[order]) / np.diff(along[order])
    widths = np.linspace(0.0, widest, WIDTHS + 1)[1:]
    loads = _grown(x, slopes, widest, widths)[1]
    if not load < loads.max() or (np.diff(loads) < -1e-6 * load).any():
        return None
    # The pressure is the sum of increments, the first of which are that of a flat punch.
    reached = [0.01 * load, min(NEARBY[1] * load, loads.max())]
    first, last = np.searchsorted(loads, reached)
    begin = float(widths[first - 1]) if first else 0.0
    fine = np.linspace(begin, widths[min(last, WIDTHS - 1)], 2 * WIDTHS + 1)[1:]
    edges, loads = _grown(x, slopes, widest, fine)
    found = _under(load, edges, loads) if loads[0] < load else None
    ends = np.array([along.min(), along.max()])
    # Behind an end nothing is known.
    return found if found and (np.abs(found.edges - ends) >= 1e-5 * widest).all() else None


def _middles(places: Array) -> Array:
    return np.asarray((places[1:] + places[:-1]) / 2)


def _grown(x: Array, slopes: Array, widest: float, widths: Array) -> tuple[Array, Array]:
    """(2, w) edges and (w,) loads P/E* of contacts of half-widths (w,); none of zero width.

    Slopes (n,) are those at x (n,). The middle is where the surfaces are level in the mean.
    """
    sines = np.sin(np.pi * ((np.arange(ANGLES) + 0.5) / ANGLES - 0.5))
    places, middle = widths[:, None] * sines, (x[0] + x[-1]) / 2
    level = 1e-9 * float(np.abs(slopes).max())  # slopes of flats are round-off
    bounds = []
    for sign in (1.0, -1.0):
        low, high = middle - (widest - widths), middle + (widest - widths)
        for _ in range(HALVINGS):
            centre = (low + high) / 2
            left = np.interp(centre[:, None] + places, x, slopes).mean(axis=1) < sign * -level
            low, high = np.where(left, centre, low), np.where(left, high, centre)
        bounds.append((low + high) / 2)
    centre = np.mean(bounds, axis=0)
    turned = np.interp(centre[:, None] + places, x, slopes)
    loads = np.pi / 2 * (turned * places).mean(axis=1)
    return np.stack([centre - widths, centre + widths]), loads


def _under(load: float, edges: Array, loads: Array) -> StripContact:
    """The contact under a load, from (2, w) edges under loads (w,)."""
    loads = np.maximum.accumulate(loads)
    near = np.minimum(np.multiply(NEARBY, load), loads[-1])
    low, here, high = (
        np.array([np.interp(each, loads, edge) for edge in edges])
        for each in (near[0], load, near[1])
    )
    outward = (high - low) * [-1, 1]
    punch = (near[1] - near[0]) / (math.pi * math.sqrt(float(np.ptp(here))))
    inside = loads < load
    grown = np.column_stack([edges[:, inside], here])
    increments = np.diff(np.append(loads[inside], load), prepend=0.0)
    peaks = [_peak(increments, *sides) for sides in (grown, -grown[::-1])]
    with np.errstate(divide="ignore"):
        k_n = 2 * punch / outward
    return StripContact(here, outward / math.log(near[1] / near[0]), np.array(peaks), k_n)


def _peak(increments: Array, left: Array, right: Array) -> float:
    """Largest pressure at places that were the left edge, over E*.

    Args:
        increments: (k,) of P/E*, the first one as wide as the first edges.
        left: (k,) left edges behind them.
        right: (k,) right ones.
    """
    x = left[:-1]
    before = np.concatenate([left[:1], left[:-1]])
    distance = x[:, None] - np.stack([left, before])[:, None, :]
    roots = np.sqrt(np.maximum(distance, 0.0)).sum(axis=0)
    # The first increment is that of a flat punch, of which its own edge has no pressure.
    roots[0, 0] = math.inf
    behind = np.arange(len(left)) >= np.arange(len(x))[:, None]
    behind &= roots > 0
    parts = np.zeros_like(roots)
    others = np.sqrt(right[None, :] - x[:, None])
    np.divide(2 * increments, np.pi * roots * others, out=parts, where=behind)
    return float(parts.sum(axis=1).max())
