# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of solids around the stations of their fronts, without cracks.

Across a front the fields are those of a plane contact with three components. The stress is that of
half-planes under the tractions of the plane problem of the station, whatever elements resolve, and
of what is missing to the stress of the elements at depths of two elements and more: what the bodies
and the bend of the front add, a polynomial of the place whose residual is the error bar.

Axes are those of `fretfe.decision.field`, with z along the front.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from fretfe._typing import Array
from fretfe.case import isotropic
from fretfe.decision.field import EdgeField, SmoothStress, pulled_most
from fretfe.decision.near_field import NearField, beside_edges, edge_places, every_other
from fretfe.evaluate.contacts import Contact, Front, Station
from fretfe.evaluate.edge_tractions import edge_nodes
from fretfe.evaluate.loaded import normal_force
from fretfe.evaluate.space.local import PlaneTractions, plane_tractions
from fretfe.evaluate.withheld import withheld
from fretfe.history.solution import ContactHistory
from fretfe.reason import Kind, Reason
from fretfe.results.model import Result
from fretfe.results.station_stress import StationStress

BothFields = tuple[EdgeField | str, EdgeField | str]


def station_fields(
    result: Result, contact: Contact, only: Collection[tuple[str, int]] | None = None
) -> Iterator[tuple[Station, BothFields]]:
    """Stations of a contact, with the stress in both bodies or why it is not known.

    Args:
        result: of solids.
        contact: of it.
        only: fronts and numbers of the stations that are wanted, beside those for which there is a
            reason before anything is computed; None for all.
    """
    pair = next(each for each in result.solution.contacts if each.pair == contact.pair)
    if not contact.stations:
        return
    if reason := _obstacle(result, pair):
        yield from ((each, (reason, reason)) for each in contact.stations)
        return
    stress = result.station_stress(contact.pair)
    reasons = {_key(each): _lack(each, stress) for each in contact.stations}
    posed = [
        (front, each)
        for front in contact.fronts
        for each in front.stations
        if not reasons[_key(each)] and (only is None or _key(each) in only)
    ]
    edges = {_key(each): _edge_places(contact, each, stress) for _, each in posed}
    found = plane_tractions(result.solution, pair, posed, result.case.bodies, stress.states)
    tractions = {
        _key(each): _unsolved(contact, own)
        if isinstance(own, str)
        else _joined(pair, front, each, own, stress, edges[_key(each)])
        for (front, each), own in zip(posed, found, strict=True)
    }
    for station in contact.stations:
        own = reasons[_key(station)] or tractions.get(_key(station))
        if own is None:
            continue
        if isinstance(own, str):
            yield station, (own, own)
        else:
            at = edges[_key(station)]
            first, second = (
                _field(result, pair, station, own, stress, at, body) for body in (0, 1)
            )
            yield station, (first, second)


def _key(station: Station) -> tuple[str, int]:
    return station.front, station.number


def _obstacle(result: Result, pair: ContactHistory) -> str:
    """Reason why no stress is known, or an empty text."""
    bodies = (result.case.bodies[each] for each in (pair.body1, pair.body2))
    checks = {
        Kind.INCOMPLETE: result.failure is not None,
        Kind.CRYSTAL: not all(map(isotropic, bodies)),
        Kind.UNLIKE: bool(pair.surface.dundurs),
        Kind.NO_CYCLE: result.solution.cycle is None,
        Kind.NOT_KEPT: not result.solution.keeps(*result.loads.evaluated),
        Kind.NO_STRESS: not result.has_station_stress,
    }
    return Reason.first(checks).text


def _lack(station: Station, stress: StationStress) -> str:
    """Reason why the stress at a station is not known, or an empty text."""
    lost = stress.row(*_key(station)) is None
    found = Reason.first({Kind.NEAR_END: station.end}) or withheld(station, ranged=False)
    return (found or Reason.first({Kind.NO_PLACE: lost})).text


def _edge_places(contact: Contact, station: Station, stress: StationStress) -> Array:
    """(n,) places of the front from the mouth inward, in the states of the stress."""
    row = stress.row(*_key(station))
    assert row is not None
    return edge_places(contact, station, stress.states) - stress.mouths[row]


def _unsolved(contact: Contact, reason: str) -> str:
    """Reason why the plane problem of a station has no tractions."""
    if contact.sliding_share > 0:
        return (
            "all of the contact slides in the cycle, and plane problems are those of partial slip"
        )
    return reason


def _joined(
    pair: ContactHistory,
    front: Front,
    station: Station,
    plane: PlaneTractions,
    stress: StationStress,
    edges: Array,
) -> PlaneTractions:
    """Tractions of the plane problem next to the edge, from some elements on those of the nodes.

    The nodes are those around the station, in rows; beyond the middle of the contact, which is too
    far for it to matter how, as before it. Both pressures have a root at the edge, so one over the
    other is smooth there: 1 + slope * distance, by the nodes.
    """
    row = stress.row(*_key(station))
    assert row is not None
    middle = station.depth
    nodes = edge_nodes(pair, front, station, station.last, (0.0, middle))
    ahead = float(station.position[station.last] - stress.mouths[row])
    places = nodes.by_rows(nodes.s) + ahead
    frame = np.stack([station.frame.inward, station.frame.along], axis=1)
    turned = pair.surface.frames[nodes.nodes, 1:] @ frame
    half = np.concatenate([[0.0], plane.x, places, beside_edges(edges, plane.x)])
    half = half[(half >= 0) & (half < middle)]
    x = np.unique(np.concatenate([half, 2 * middle - half]))
    nearer = np.minimum(x, 2 * middle - x)
    values = np.zeros((len(stress.states), len(x), 3))
    through = zip(stress.states, edges, plane.pressure, plane.shear, strict=True)
    for own, (state, edge, p, q) in zip(values, through, strict=True):
        if not p.any():  # no contact
            continue
        local = _with_root(nearer, plane.x, np.column_stack([p, q]), float(edge))
        mean = pair.mean_traction[int(state)][nodes.nodes]
        both = np.column_stack([mean[:, 0], np.einsum("nt,ntk->nk", mean[:, 1:], turned)])
        far = np.stack([np.interp(nearer, places, nodes.by_rows(each)) for each in both.T], axis=1)
        inside = nearer - plane.x[np.argmax(p > 0)]
        # Those of nodes begin to count two elements from the edge, and are all from four on.
        share = np.clip(inside / station.size / 2 - 1, 0.0, 1.0)[:, None]
        both = (share[:, 0] > 0) & (share[:, 0] < 1) & (local[:, 0] > 0)
        slope = 0.0
        if both.any():
            missed = far[both, 0] / local[both, 0] - 1
            slope = float(inside[both] @ missed / (inside[both] @ inside[both]))
        own[:] = (1 - share) * (1 + slope * inside[:, None]) * local + share * far
    return PlaneTractions(x, values[..., 0], values[..., 1:])


def _with_root(x: Array, nodes: Array, tractions: Array, edge: float) -> Array:
    """(M, 3) tractions (K, 3) at places x: p² is straight from the edge on, and q over p."""
    inside = (tractions[:, 0] > 0) & (nodes > edge)
    at, (p, *shears) = nodes[inside], tractions[inside].T
    pressure = np.sqrt(np.interp(x, np.r_[edge, at], np.r_[0.0, p**2], left=0.0))
    return np.stack([pressure, *(pressure * np.interp(x, at, q / p) for q in shears)], axis=1)


def _field(
    result: Result,
    pair: ContactHistory,
    station: Station,
    tractions: PlaneTractions,
    stress: StationStress,
    edges: Array,
    number: int,
) -> EdgeField | str:
    name = (pair.body1, pair.body2)[number]
    body, row = isotropic(result.case.bodies[name]), stress.row(*_key(station))
    assert body is not None and row is not None
    # On body 1 the shear is the opposite one, and y its own outward normal.
    way = 1.0 if number else -1.0
    inward, along = np.moveaxis(way * tractions.shear, 2, 0)
    near = NearField(tractions.x, tractions.pressure, inward, body.poisson, along)
    depths = stress.depths[row]
    places = np.stack(np.broadcast_arrays(stress.places[row], -depths[:, None]), axis=-1)
    elements = stress.stress[number, row]
    used = np.isfinite(elements).all(axis=(0, 3))
    # Elements of solids scatter; next to the edge a third power does more so: on pads twice.
    smooth = SmoothStress.of(
        places[used], elements[:, used] - near.at(places[used]), len(depths), 2
    )
    if isinstance(smooth, str):
        return smooth
    edge = f"{station.front}.{station.number}"
    force = normal_force(pair)[stress.states]
    other = every_other(result.solution.values[stress.states], force)
    found = EdgeField(
        pair.pair, edge, name, stress.states, 0.0, near, smooth, station.size, other=other
    )
    surface = found.stress(np.stack([edges, np.zeros_like(edges)], axis=1))
    return pulled_most(found, edges, surface[..., 0].diagonal())
