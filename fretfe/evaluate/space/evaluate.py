# SPDX-License-Identifier: LGPL-3.0-or-later
"""Evaluation of a contact of solids: its fronts, resultants, patches and friction work."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.evaluate.contacts import Frame, Front, unknown_station
from fretfe.evaluate.factors import FactorHistories, rotated
from fretfe.evaluate.friction_work import friction_work, work_before
from fretfe.evaluate.increments import ContactSteps, UnitFactors
from fretfe.evaluate.loaded import normal_force, pressed_state
from fretfe.evaluate.resultants import solid_resultants
from fretfe.evaluate.seen_slip import pressed_on
from fretfe.evaluate.slip import cycle_states
from fretfe.evaluate.space.contact_area import why_no_fronts
from fretfe.evaluate.space.edges import FrontEdges, moved_stations
from fretfe.evaluate.space.front_scatter import with_scatter
from fretfe.evaluate.space.fronts import FrontTrack, LostFront, lost_fronts
from fretfe.evaluate.space.half_spaces import half_space_ratios
from fretfe.evaluate.space.patches import follow_patches
from fretfe.evaluate.space.slip import SlipBetween
from fretfe.history.solution import ContactHistory, Solution
from fretfe.reason import TOLD

# P adds nothing to K_T between unlike bodies at the length of a strip's width, and at so much less
# within a circle (Mossakovskii 1954: at half of the radius).
WITHIN_CIRCLE = 4.0
# Power of the width with which factors for a unit of a load fall: around a circle, and by whether
# fronts are closed, where they are straight and long.
GROWTH = {True: 1.5, False: 0.5}


def evaluate_solids(
    solution: Solution,
    contact: ContactHistory,
    tracks: tuple[FrontTrack, ...] | None,
    told: float | None,
) -> dict[str, Any]:
    """Fronts, resultants and friction work of a contact of solids, by the names of `Contact`.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        tracks: its fronts, followed through the history; None if nobody looked for them.
        told: reference length of factors between unlike bodies; None for the predicted slip zones.
    """
    found = solid_resultants(contact)
    tracks, nobody = tracks or (), tracks is None
    lost = lost_fronts(solution, contact, tracks)
    fronts = evaluate_fronts(solution, contact, tracks, told)
    fronts += tuple(
        _unknown_front(each, f"front {number}", len(solution.times))
        for number, each in enumerate(lost, start=len(tracks) + 1)
    )
    patches, owner = follow_patches(solution, contact)
    if patches:
        nodes = [*(each.front.node for each in tracks), *(each.node for each in lost)]
        fronts = tuple(
            replace(front, patch=int(owner[node]) + 1)
            for front, node in zip(fronts, nodes, strict=True)
        )
    reference = pressed_state(solution, contact)
    missing = not nobody and not any(track.state == reference for track in tracks)
    work, spread = (float(each.sum()) for each in friction_work(solution, contact))
    change = abs(work - work_before(solution, contact))
    stations = [each for front in fronts for each in front.stations]
    hidden = [any(zone.hides for zone in each.evaluated_zones) for each in stations]
    still = not found["normal_force"].any() or (bool(stations) and all(s.still for s in stations))
    unseen = work == 0 and not still and contact.friction.acts.any()
    if unseen or 2 * sum(hidden) > len(hidden):
        spread = math.inf  # that of nodes that do not slip is no measure of it
    return {
        **found,
        "fronts": fronts,
        "lack": why_no_fronts(contact, reference) if missing else TOLD,
        "patches": patches,
        "dissipation": work,
        "dissipation_spread": spread + float(np.nan_to_num(change)),
    }


def evaluate_fronts(
    solution: Solution,
    contact: ContactHistory,
    tracks: tuple[FrontTrack, ...],
    told: float | None = None,
) -> tuple[Front, ...]:
    """Evaluate the fronts of a solid contact, followed through the history.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        tracks: its fronts.
        told: as of `evaluate_solids`.
    """
    fronts = []
    for track, edges in zip(tracks, front_edges(solution, contact, tracks), strict=True):
        frames = track.front.frames
        sums = half_space_ratios(solution, contact, track, alone=len(tracks) == 1)
        widths = [sector.half_width for sector in track.front.sectors]
        stations = with_scatter(edges.stations(told), frames.closed, widths, frames.length)
        fronts.append(Front(edges.name, stations, frames.closed, frames.length, sums))
    return tuple(fronts)


def _unknown_front(lost: LostFront, name: str, states: int) -> Front:
    """The front that a border of the contact should be, nothing of which is known over T states."""
    frames = lost.frames
    places = zip(frames.inward, frames.along, frames.across, strict=True)
    stations = tuple(
        replace(
            unknown_station(name, number, states, lost.lack),
            frame=Frame(*axes),
            point=frames.points[number],
            arc=float(frames.arc[number]),
            size=float(lost.sizes[number]),
        )
        for number, axes in enumerate(places)
    )
    return Front(name, stations, frames.closed, frames.length)


def front_edges(
    solution: Solution, contact: ContactHistory, tracks: tuple[FrontTrack, ...]
) -> Iterator[FrontEdges]:
    """The edges along each front of a contact, of unlike bodies at the reference length 1."""
    steps, force = ContactSteps.of(solution, contact, solution), normal_force(contact)
    slip, first = SlipBetween(contact, solution.least_slip, solution.cycle), 0
    for number, track in enumerate(tracks):
        own = slice(first, first + len(track.front.sectors))
        first = own.stop
        factors, frictions = _factors(steps, contact, track, own), _frictions(contact, track)
        yield FrontEdges(
            contact=contact,
            name=f"front {number + 1}",
            track=track,
            slip=slip,
            moves=moved_stations(contact, track.front, own),
            steps=steps,
            fits=[track.fit.of(station) for station in range(len(track.front.sectors))],
            factors=factors,
            frictions=frictions,
            half_widths=track.front.depth,
            pressed=_pressed(steps, track, factors, frictions),
            last=track.state,
            force=force,
        )


def _pressed(
    steps: ContactSteps, track: FrontTrack, factors: FactorHistories, frictions: list[Array]
) -> list[bool]:
    """True for each station of a front that P alone drives."""
    front, cycle = track.front, cycle_states(steps.solution.cycle)
    bent = np.clip(front.frames.curvature * front.depth, 0.0, 1.0)
    lengths = 2 * front.depth * WITHIN_CIRCLE**-bent
    stations = zip(factors.ways.mean(axis=0), lengths.tolist(), frictions, strict=True)
    return [
        pressed_on(own, steps.dundurs, length, friction, cycle)
        for own, length, friction in stations
    ]


def _frictions(contact: ContactHistory, track: FrontTrack) -> list[Array]:
    """(n, T) coefficient at each station of a front."""
    frames = track.front.frames
    places = frames.points + track.fit.place[..., None] * frames.inward
    return [contact.edge_friction(each) for each in places.swapaxes(0, 1)]


def _factors(
    steps: ContactSteps, contact: ContactHistory, track: FrontTrack, stations: slice
) -> FactorHistories:
    """Singular factors of the n stations of a front; NaN without integrals."""
    front, integrals = track.front, contact.integrals
    if integrals is None:
        nothing = np.full((1, *track.fit.place.T.shape, 3), np.nan)
        unknown = nothing[0, :, :, 0]
        states = np.zeros(len(track.fit.place), dtype=bool)
        units = np.full((*track.fit.place.shape, 3, 1), np.nan)
        return FactorHistories(nothing, None, False, unknown, unknown, states, units)
    known, power = integrals.positions[:, stations], GROWTH[front.frames.closed]
    ways = (
        _interpolate(track.fit.place, known, own, front.depth, steps.dundurs, power)
        for own in integrals.factors[:, :, stations].swapaxes(0, 1)
    )
    histories = steps.histories(UnitFactors(ways), alone=True)
    histories.ways[:, front.copied] = np.nan
    return histories


def _interpolate(
    places: Array, known: Array, values: Array, depth: Array, dundurs: float, power: float
) -> Array:
    """(T, n, ...) values (S, n, ...) known at places (S, n), at the places (T, n) of all states.

    Factors for a unit of a load fall with some power of the half of the width of the contact.
    Times that power they are taken linear between known places, and constant outside; NaN where the
    place is. Of unlike bodies that is so of K_I and K_T at a length in proportion to that width.

    Args:
        places: inward from the front of the reference state.
        known: likewise.
        values: factors for a unit of each driver.
        depth: (n,) half of the width in the reference state.
        dundurs: beta.
        power: by which they fall.
    """
    result = np.full((len(places), *values.shape[1:]), np.nan)
    for station, (at, x) in enumerate(zip(places.T, known.T, strict=True)):
        found, there = np.isfinite(at), np.isfinite(x)
        if not there.any():
            continue
        order = np.flatnonzero(there)[np.argsort(x[there])]
        # Half of the width where the front is some way inward; a tenth of it at least.
        half, least = depth[station], 0.1 * depth[station]
        width, widths = (np.maximum(half - each, least) for each in (at[found], x[order]))
        own = rotated(values[order, station], dundurs, widths)
        flat = widths[:, None] ** power * own.reshape(len(order), -1)
        columns = [np.interp(at[found], x[order], column) for column in flat.T]
        factors = np.array(columns).T / width[:, None] ** power
        factors = factors.reshape(-1, *values.shape[2:])
        result[found, station] = rotated(factors, dundurs, 1 / width)
    return result
