# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact areas between solids: forces, moments, areas that stick and slip, friction work.

T is the number of states. Forces, moments and work are those of the whole contact; vectors are in
the axes of the case.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.edges.extremes import SMALLEST_SHEAR
from fretfe.edges.slip import cycle_change
from fretfe.edges.solid_fronts import SolidFront
from fretfe.edges.warnings import STEADY_CHANGE
from fretfe.results.solution import OPEN, STICK, ContactHistory, Solution
from fretfe.results.states import blocks

# Nodes in contact below which pressures and areas are coarse: about ten across.
FEWEST_NODES = 80


@dataclass(frozen=True)
class AreaSummary:
    """A contact between two solids, evaluated.

    Attributes:
        name: of the contact.
        pair: name of the surface pair, the contact in the case.
        normal_force: (T,) P, integral of the pressure.
        shear_force: (T, 3) Q, integral of the shear traction that body 1 exerts on body 2.
        force: (T, 3) all that body 1 exerts on body 2; on curved surfaces the pressure has a share
            in every component.
        centre: (T, 3) centre of pressure; NaN where nothing presses.
        moment: (T, 3) moment of the tractions on body 2 about `centre`; NaN where there is none.
        contact_area, stick_area: (T,) area that belongs to the nodes in contact, and to those of
            them that stick. A node counts as a whole: both grow in steps of an element.
        largest_pressure: (T,) of the means around the nodes.
        work: (T,) friction work in the step to each state.
        cycle_change: change of the shear over the evaluated cycle, of the means around the nodes,
            relative to f p_max.
        steady: whether that is below the limit; False without a cycle.
        dissipation: friction work in the evaluated cycle, or of all steps without one.
        fronts: the boundary curves of the contact area; empty where they cannot be told.
        warnings: what a reader must know, in words.
    """

    name: str
    pair: str
    normal_force: Array
    shear_force: Array
    force: Array
    centre: Array
    moment: Array
    contact_area: Array
    stick_area: Array
    largest_pressure: Array
    work: Array
    cycle_change: float
    steady: bool
    dissipation: float
    fronts: tuple[SolidFront, ...]
    warnings: tuple[str, ...]


def evaluate_areas(
    solution: Solution, fronts: Mapping[str, tuple[SolidFront, ...]]
) -> tuple[AreaSummary, ...]:
    """Evaluate every contact of a solution in space.

    Args:
        solution: the solved history.
        fronts: those of the contacts, by name; no entry if nobody looked for them.
    """
    return tuple(
        _evaluate_area(solution, contact, fronts.get(contact.name)) for contact in solution.contacts
    )


def shear_extremes(areas: Sequence[AreaSummary], cycle: tuple[int, int] | None) -> list[int]:
    """States of the largest and the smallest load in the evaluated cycle.

    The load is Q of the contact where it varies most, along the direction in which it does; where
    none feels shear, P likewise.

    Args:
        areas: the contacts.
        cycle: its first and last state; None for the whole history without the unloaded state.

    Returns:
        Two states in the order of time, or the last state alone if the load is constant or no step
        was solved.
    """
    first, last = cycle or (1, len(areas[0].normal_force) - 1)
    if last < first:
        return [last]
    states = slice(first, last + 1)
    shear = max((_principal(each.shear_force[states]) for each in areas), key=np.ptp)
    normal = max((each.normal_force[states] for each in areas), key=np.ptp)
    load = shear if np.ptp(shear) > SMALLEST_SHEAR * np.abs(normal).max() else normal
    found = sorted({first + int(load.argmax()), first + int(load.argmin())})
    return found if len(found) == 2 else [last]


def _principal(force: Array) -> Array:
    """(n,) components of forces (n, 3) along the direction in which they vary most."""
    return np.asarray(force @ shear_direction(force))


def shear_direction(force: Array) -> Array:
    """(3,) unit vector along which forces (n, 3) vary most, its largest component positive."""
    direction = np.linalg.svd(force - force.mean(axis=0), full_matrices=False)[2][0]
    return np.asarray(direction * np.sign(direction[np.abs(direction).argmax()]))


def _evaluate_area(
    solution: Solution, contact: ContactHistory, fronts: tuple[SolidFront, ...] | None
) -> AreaSummary:
    parts = [_in_block(contact, states) for states in blocks(*_size(contact))]
    histories = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    change = _cycle_change(solution, contact)
    work = histories["work"]
    first, last = solution.cycle or (0, len(work) - 1)
    return AreaSummary(
        name=contact.name,
        pair=contact.pair,
        **histories,
        cycle_change=change,
        steady=bool(change < STEADY_CHANGE),
        dissipation=float(work[first + 1 : last + 1].sum()),
        fronts=fronts or (),
        warnings=tuple(_warnings(contact, change, fronts)),
    )


def _size(contact: ContactHistory) -> tuple[int, int]:
    """Number of states, and of the values that each of them has."""
    return len(contact.traction), int(np.prod(contact.traction.shape[1:]))


def _in_block(contact: ContactHistory, states: slice) -> dict[str, Array]:
    """Histories of some states, by the names of `AreaSummary`."""
    # Means around the nodes have the moments of the field itself, nodal values do not.
    traction, status = contact.mean_traction[states], contact.status[states]
    pressure, weights = traction[..., 0], contact.weights
    # On body 2 the pressure acts against its outward normal.
    signed = traction * np.array([-1.0, 1.0, 1.0])
    vectors = np.einsum("tnc,ncd->tnd", signed, contact.frames)
    shear = np.einsum("n,tnc,ncd->td", weights, traction[..., 1:], contact.frames[:, 1:])
    force, normal_force = np.einsum("n,tnd->td", weights, vectors), pressure @ weights
    pressed = np.where(normal_force > 0, normal_force, np.nan)
    centre = (pressure * weights) @ contact.points / pressed[:, None]
    about_origin = np.einsum("n,tnd->td", weights, np.cross(contact.points, vectors))
    return {
        "normal_force": normal_force,
        "shear_force": shear,
        "force": force,
        "centre": centre,
        "moment": about_origin - np.cross(centre, force),
        "contact_area": (status != OPEN) @ weights,
        "stick_area": (status == STICK) @ weights,
        "largest_pressure": pressure.max(axis=1),
        "work": contact.dissipation[states].sum(axis=1),
    }


def _cycle_change(solution: Solution, contact: ContactHistory) -> float:
    """Largest change of the shear between the ends of the cycle, relative to f p_max."""
    if solution.cycle is None:
        return np.nan
    begin, end = (contact.mean_traction[state] for state in solution.cycle)
    friction, pressure = float(contact.friction[solution.cycle[1]]), float(end[:, 0].max())
    if friction == 0 or pressure <= 0:
        return np.nan
    return cycle_change(end[:, 1:], begin[:, 1:], friction, pressure)


def _warnings(
    contact: ContactHistory, change: float, fronts: tuple[SolidFront, ...] | None
) -> Iterator[str]:
    """Warnings about a contact, most serious first; fronts are None if nobody looked for them."""
    closed, smallest = np.zeros(len(contact.weights), dtype=bool), np.inf
    for states in blocks(len(contact.status), len(contact.weights)):
        closed |= np.any(contact.status[states] != OPEN, axis=0)
        smallest = min(smallest, float(contact.gap[states].min()))
    if not closed.any():
        yield f"the surfaces never touch; the smallest gap is {smallest:.4g}"
        return
    nodes = int(np.count_nonzero(contact.status[len(contact.status) - 1] != OPEN))
    if 0 < nodes < FEWEST_NODES:
        yield (
            f"{nodes} nodes are in contact in the last state, {FEWEST_NODES} are wanted at least "
            f"for pressures and areas: make the elements {np.sqrt(FEWEST_NODES / nodes):.1f} times "
            "smaller there"
        )
    if fronts is not None and not fronts:
        yield (
            "the boundary of the contact area cannot be found at the end of the cycle: K_N, K_T, "
            "K_S and slip zones are unknown; they need ten elements over the width of the contact"
        )
    at_border = np.flatnonzero(closed & _border(contact))
    if len(at_border):
        place = ", ".join(f"{value:.4g}" for value in contact.points[at_border[0]])
        yield (
            f"the contact reaches the border of its surface, first at ({place}): extend the "
            "physical group there, unless the body ends there too"
        )
    if change >= STEADY_CHANGE:
        yield (
            f"not in steady state: the shear changes by {change:.2g} f p_max over the evaluated "
            "cycle; add cycles"
        )


def _border(contact: ContactHistory) -> Bools:
    """(N,) nodes on the border of the surface: the ends of edges that one facet has."""
    assert contact.facets is not None
    facets = contact.facets
    edges = np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2)
    found, count = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    border = np.zeros(len(contact.weights), dtype=bool)
    border[found[count == 1]] = True
    return border
