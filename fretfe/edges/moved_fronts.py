# SPDX-License-Identifier: LGPL-3.0-or-later
"""K_N at stations of solids by the movement of their front between two loads: 2 dK_I/da."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array
from fretfe.edges.front import NO_NUMBER
from fretfe.edges.range_spread import WITHIN_ELEMENT
from fretfe.edges.space_fronts import SpaceFront
from fretfe.edges.tracks_in_space import NEAR
from fretfe.results.solution import ContactHistory

NO_LOADS = "there are no two neighbouring loads, or K_I is not defined between these bodies"
NO_FRONT = "the front or K_I is not known at a neighbouring load"
AWAY = "the front of the neighbouring loads is too far from the station"
STANDS = "the front does not move outward with the loads"
POOR = "the front moves too little for elements of this size"


@dataclass(frozen=True)
class MovedStation:
    """K_N of a station by the movement of its front; NaN, with a reason, where it is not known.

    Attributes:
        k_n: 2 dK_I/da; needs no assumption about the shape of the pressure.
        spread: half the width of an interval that is meant to hold it with 95 %.
        reason: why it is not known, in words; empty where it is.
    """

    k_n: float
    spread: float
    reason: str


def moved_stations(
    contact: ContactHistory, front: SpaceFront, stations: slice
) -> tuple[MovedStation, ...]:
    """K_N of the n stations of a front by its movement about the last state.

    Args:
        contact: with its neighbouring loads.
        front: in the reference state.
        stations: which of all stations of the contact they are.
    """
    neighbours, count = contact.neighbours, len(front.sectors)
    if neighbours is None:
        return (MovedStation(np.nan, np.nan, NO_LOADS),) * count
    fit = front.fits.fit(neighbours.pressure)
    outward, spread = fit.place[0] - fit.place[1], np.linalg.norm(fit.place_spread, axis=0)
    near = np.abs(fit.place).max(axis=0) <= NEAR * front.sizes
    k_i = neighbours.k_i[:, stations]
    # The border of the nodes in contact is ragged at both loads; see `range_spread`.
    ragged = WITHIN_ELEMENT * front.sizes / front.depth
    return tuple(_moved(*each) for each in zip(near, outward, spread, k_i.T, ragged, strict=True))


def _moved(near: bool, outward: float, spread: float, k_i: Array, ragged: float) -> MovedStation:
    """One station.

    Args:
        near: whether its front is close to it at both loads.
        outward: how far it moves from the lower to the higher load.
        spread: error bar of that, as if those of both places had nothing to do with each other.
        k_i: (R,) of the difference of the loads, determined in R ways.
        ragged: error of K_I over it by the border of the nodes in contact.
    """

    def unknown(reason: str) -> MovedStation:
        return MovedStation(np.nan, np.nan, reason)

    if not np.isfinite([outward, *k_i]).all():
        return unknown(NO_FRONT)
    if not near:
        return unknown(AWAY)
    mean = float(k_i.mean())
    if not (outward > 0 and mean > 0):
        return unknown(STANDS)
    k_n = 2 * mean / outward
    relative = math.hypot(spread / outward, float(np.ptp(k_i)) / 2 / mean, ragged)
    return unknown(POOR) if relative > NO_NUMBER else MovedStation(k_n, relative * k_n, "")
