# SPDX-License-Identifier: LGPL-3.0-or-later
"""Resultants of contacts between solids, and the two states between which a load cycle swings.

T is the number of states. Forces, moments and work are those of the whole contact; vectors are in
the axes of the case.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.evaluate.contacts import Front
from fretfe.evaluate.cycles import STEADY_CHANGE, cycle_changes, unsteady_text
from fretfe.evaluate.verdicts import withheld
from fretfe.history.solution import OPEN, STICK, ContactHistory, Solution
from fretfe.history.state_array import blocks
from fretfe.surface.reference import rim_nodes

# Shear factors that vary by less than this fraction of the normal ones are round-off.
SMALLEST_SHEAR = 1e-3
# Nodes in contact below which pressures and areas are coarse: about ten across.
FEWEST_NODES = 80
# Part of the area in contact that sticks, below which the contact nearly slides.
NEARLY_SLIDES = 0.1


def load_extremes(
    k_t: Sequence[Array], k_i: Sequence[Array], cycle: Sequence[int] | None
) -> list[int]:
    """States of the largest and the smallest load in the evaluated cycle.

    The load is K_T of the station where K_T varies most; where none feels shear, K_I likewise.

    Args:
        k_t: (T,) K_T of each station that is to be shown, stress·√length; NaN where there is none.
        k_i: (T,) K_I likewise.
        cycle: its first and last state; None for the whole history without the unloaded state.

    Returns:
        Two states in the order of time, or the last state alone if the load is constant: the last
        one in which it is known.
    """
    first, last = cycle or (1, len(k_t[0]) - 1)
    shear, normal = (np.array(each)[:, first : last + 1] for each in (k_t, k_i))
    ranges = [np.array([_range(each) for each in loads]) for loads in (shear, normal)]
    sheared = ranges[0].max() > SMALLEST_SHEAR * ranges[1].max()
    load = shear[ranges[0].argmax()] if sheared else normal[ranges[1].argmax()]
    known = first + np.flatnonzero(np.isfinite(load))
    if not len(known):
        return [last]
    load = load[known - first]
    states = {int(known[load.argmax()]), int(known[load.argmin()])}
    return sorted(states) if len(states) == 2 else [int(known[-1])]


def _range(load: Array) -> float:
    """Range where a load is known; below zero where it never is."""
    known = load[np.isfinite(load)]
    return float(np.ptp(known)) if len(known) else -1.0


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
    fronts: tuple[Front, ...]
    warnings: tuple[str, ...]


def evaluate_areas(
    solution: Solution, fronts: Mapping[str, tuple[Front, ...]]
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
    solution: Solution, contact: ContactHistory, fronts: tuple[Front, ...] | None
) -> AreaSummary:
    parts = [_in_block(contact, states) for states in blocks(*_size(contact))]
    histories = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    changes = cycle_changes(solution, contact.mean_traction, contact.friction)
    work = histories["work"]
    first, last = solution.cycle or (0, len(work) - 1)
    return AreaSummary(
        name=contact.name,
        pair=contact.pair,
        **histories,
        cycle_change=changes[0],
        steady=bool(changes[0] < STEADY_CHANGE),
        dissipation=float(work[first + 1 : last + 1].sum()),
        fronts=fronts or (),
        warnings=(
            *_warnings(contact, changes, fronts),
            *_withheld(solution, histories, fronts or ()),
        ),
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


def ever_closed(contact: ContactHistory) -> tuple[Bools, float]:
    """(N,) nodes that are in contact in some state, and the smallest gap of all."""
    closed, smallest = np.zeros(len(contact.weights), dtype=bool), np.inf
    for states in blocks(len(contact.status), len(contact.weights)):
        closed |= np.any(contact.status[states] != OPEN, axis=0)
        smallest = min(smallest, float(contact.gap[states].min()))
    return closed, smallest


def never_touch(smallest: float) -> str:
    """Warning about surfaces that are never in contact, by their smallest gap."""
    return f"the surfaces never touch; the smallest gap is {smallest:.4g}"


def _warnings(
    contact: ContactHistory, changes: Sequence[float], fronts: tuple[Front, ...] | None
) -> Iterator[str]:
    """Warnings about a contact, most serious first; fronts are None if nobody looked for them."""
    closed, smallest = ever_closed(contact)
    if not closed.any():
        yield never_touch(smallest)
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
    assert contact.facets is not None
    at_border = np.flatnonzero(closed & rim_nodes(contact.facets, len(closed)))
    if len(at_border):
        place = ", ".join(f"{value:.4g}" for value in contact.points[at_border[0]])
        yield (
            f"the contact reaches the border of its surface, first at ({place}): extend the "
            "physical group there, unless the body ends there too"
        )
    if unsteady := unsteady_text(changes):
        yield unsteady


def _withheld(
    solution: Solution, histories: Mapping[str, Array], fronts: tuple[Front, ...]
) -> Iterator[str]:
    """Fronts most of whose stations have no K_N or no range, and why."""
    if solution.cycle is None:
        return
    states = slice(solution.cycle[0], solution.cycle[1] + 1)
    touching, sticking = (histories[name][states] for name in ("contact_area", "stick_area"))
    share = np.where(touching > 0, sticking / np.maximum(touching, 1e-300), 1.0)
    least = int(np.argmin(share))
    for front in fronts:
        reasons = [text for station in front.judged if (text := withheld(station))]
        if 2 * len(reasons) <= len(front.judged):
            continue
        text = (
            f"{front.name}: K_N or the range of K_T and K_S is not told at {len(reasons)} of "
            f"{len(front.judged)} stations, as {reasons[len(reasons) // 2]}"
        )
        if share[least] < NEARLY_SLIDES:
            state = solution.step_of(solution.cycle[0] + least)
            text += (
                f". The contact nearly slides: of {touching[least]:.3g} in contact "
                f"{sticking[least]:.2g} sticks in state {state}, so that there is no border "
                "between slip and stick next to the front"
            )
        yield text
