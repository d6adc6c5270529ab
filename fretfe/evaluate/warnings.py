# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cautions of an evaluated contact: what is unknown, uncertain, not steady."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fretfe._typing import Array, Bools, Indices
from fretfe.analytic.paths import reversals
from fretfe.caution import Caution, about
from fretfe.evaluate.contacts import Front, Station
from fretfe.evaluate.cycles import unsteady_text
from fretfe.evaluate.loaded import NO_LOAD, SMALL_LOAD, evaluated_states, normal_force
from fretfe.evaluate.numerics import most_loaded
from fretfe.evaluate.plane.patches_in_time import SMALLEST_PATCH
from fretfe.evaluate.plane.section import PLANE_FRONTS, contact_patches
from fretfe.evaluate.plane.symmetry import reaches_image
from fretfe.evaluate.resolution import BLIND
from fretfe.evaluate.slip import cycle_states
from fretfe.evaluate.verdicts import FEWEST_ELEMENTS
from fretfe.evaluate.withheld import untouched_hint, withheld
from fretfe.history.solution import OPEN, ContactHistory, Solution
from fretfe.history.state_array import blocks
from fretfe.reason import Finding, Kind
from fretfe.surface.surface import edges_once, rim_nodes

# Part of the range of K_T that may lie between the steps without a warning.
LARGEST_STEPS = 0.02
# Loads with fewer reversals, their first and last value included, have no cycles to be counted.
FEWEST_TURNS = 5
# Nodes in contact between solids below which pressures and areas are coarse: about ten across.
FEWEST_NODES = 80
# A front whose elements are so many times as long as the finest ones next to it lies beside the
# fine mesh. Elements of that mesh are longer than the finest ones by up to the second factor.
BESIDE = 2.5
FINE = 1.5
# Error bar of K_N of solids over it from which on smaller elements are asked for, if at least so
# much of the bar is theirs: that falls with their square.
LARGEST_COARSE = 0.2
COARSE_SHARE = 0.3
# Part of the area in contact that sticks, below which the contact nearly slides.
NEARLY_SLIDES = 0.1
# Largest P within steps over that at their ends from which on it is told, and steps that show it.
BEYOND_ENDS = 1.05
SHOWING_STEPS = 20


def plane_warnings(
    solution: Solution,
    contact: ContactHistory,
    fronts: Sequence[Front],
    changes: Sequence[float],
    *,
    slides: bool,
) -> Iterator[Caution]:
    """Cautions about a plane contact, most serious first.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        fronts: left and right, of one station each.
        changes: of the shear over cycles, as of `cycle_changes`.
        slides: whether all of it slips at a time.
    """
    name = contact.name
    yield from _nothing_known(name, fronts)
    stations = tuple(station for front in fronts for station in front.stations)
    states = evaluated_states(solution, contact)
    if contact.nodes_pressed_in(states).any():
        for station in stations:
            yield from about(name, station.front, _unknown(solution, contact, station))
    else:
        yield from about(name, "", _parted(contact, states))
    for station in stations:
        yield from about(name, station.front, _uncounted(solution, station))
    yield from _surfaces(contact, fronts)
    yield from about(name, "", _patches(contact))
    if unsteady := unsteady_text(changes, solution.choice, solution.loads.open_channels):
        yield from about(name, "", [(Kind.UNSTEADY, unsteady)])
    yield from about(name, "", _within_step(solution, contact))
    if slides or any(station.slides for station in stations):
        yield from about(name, "", [_slides(solution)])
    # Bodies of linear elements are too stiff, however fine the mesh is at the edges.
    unknown = Kind.K_N_LINEAR if solution.degree == 1 else Kind.K_N_UNCERTAIN
    unknown = Kind.LAYER if contact.surface.layer is not None else unknown
    for station in stations:
        partly = math.isfinite(station.reported_k_n)
        for each in about(name, station.front, _uncertain(station, unknown)):
            yield replace(each, partly=partly and each.kind is unknown)
    for station in stations if solution.degree else ():  # half-planes have their own places
        beside = _beside_plane_mesh(solution, contact, station)
        if beside is not None:
            yield from about(name, station.front, [(Kind.BESIDE_FINE_MESH, beside)])


def solid_warnings(
    solution: Solution,
    contact: ContactHistory,
    found: Mapping[str, Any],
    changes: Sequence[float],
    *,
    slides: bool,
) -> Iterator[Caution]:
    """Cautions about a contact between solids, most serious first.

    Args:
        solution: the solved history.
        contact: one of its contacts.
        found: its histories and fronts, by the names of `Contact`.
        changes: of the shear over cycles, as of `cycle_changes`.
        slides: whether all of it slips at a time.
    """
    name = contact.name
    closed, smallest = _ever_closed(contact)
    if not closed.any():
        yield from about(name, "", [_never_touch(contact, smallest, 3)])
        return
    yield from about(name, "", _solid_contact(solution, contact, found, closed, changes))
    yield from about(name, "", _within_step(solution, contact))
    if slides:
        yield from about(name, "", [_slides(solution)])
    yield from _nothing_known(name, found["fronts"])
    yield from _withheld(solution, name, found)
    assert contact.surface.facets is not None
    edges = edges_once(contact.surface.facets)
    for front in found["fronts"]:
        told = [_beside_solid_mesh(solution, contact, edges, each) for each in front.judged]
        beside = [each for each in told if each is not None]
        if 2 * len(beside) > len(told):
            text = beside[len(beside) // 2]
            yield from about(name, front.name, [(Kind.BESIDE_FINE_MESH, text)])
        coarse = [text for each in front.judged if (text := _too_coarse(each))]
        if 2 * len(coarse) > len(told):
            text = coarse[len(coarse) // 2]
            yield from about(name, front.name, [(Kind.K_N_UNCERTAIN, text)])


def _within_step(solution: Solution, contact: ContactHistory) -> Iterator[Finding]:
    """P that is larger within a divided step than at the ends of steps, and steps that show it."""
    if solution.step is None:
        return
    states, force = evaluated_states(solution, contact), normal_force(contact)
    state = most_loaded(force, states)
    ends = states[np.isin(states, solution.ends)]
    most = float(force[ends].max(initial=0.0))
    if not force[state] > BEYOND_ENDS * most > 0:
        return
    step = solution.step_of(state)
    begin, end = solution.values[solution.ends[[step - 1, step]]]
    varied = [f"loads.{solution.channels[each]}" for each in np.flatnonzero(end != begin)]
    yield (
        Kind.WITHIN_STEP,
        f"P is {force[state]:.4g} at t = {solution.times[state]:.4g}, within step {step}, and "
        f"{most:.4g} at most at the ends of steps: take about {SHOWING_STEPS} steps there in the "
        f"history of {' and '.join(varied)}",
    )


def _too_coarse(station: Station) -> str:
    """Elements across a front of solids that would tell its K_N, in words; empty if these do."""
    k_n, spread = station.decisive_k_n
    bar = spread / k_n if k_n > 0 else math.nan
    # Imported where it is needed: SciPy's interpolation takes a second.
    from fretfe.evaluate.space.pressure_fit import COARSE

    by_elements = COARSE * (station.size / float(np.fmin(station.length, station.depth))) ** 2
    if not LARGEST_COARSE < bar < by_elements / COARSE_SHARE:
        return ""
    wanted = LARGEST_COARSE / 2
    return (
        f"K_N is known to {bar:.0%} only with elements of {station.size:.2g} across the front: "
        f"{station.size * math.sqrt(wanted / bar):.2g} would make that {wanted:.0%}"
    )


def _solid_contact(
    solution: Solution,
    contact: ContactHistory,
    found: Mapping[str, Any],
    closed: Bools,
    changes: Sequence[float],
) -> Iterator[Finding]:
    """Cautions about a contact between solids as a whole, which touches at nodes (N,)."""
    # What a contact has without a force, or behind the evaluated cycle, no number is told of.
    last = solution.cycle[1] if solution.cycle else len(contact.status) - 1
    forces = np.abs(found["normal_force"])
    nodes = int(np.count_nonzero(contact.status[last] != OPEN))
    if 0 < nodes < FEWEST_NODES and forces[last] > NO_LOAD * forces.max():
        finer = math.ceil(10 * math.sqrt(FEWEST_NODES / nodes)) / 10
        narrow = found["lack"].kind is Kind.NARROW
        yield (
            Kind.FEW_NODES,
            f"{nodes} node{' is' if nodes == 1 else 's are'} in contact in state "
            f"{solution.step_of(last)}, {FEWEST_NODES} are wanted at least for pressures and "
            # Fronts want smaller ones, which is told by itself.
            f"areas{'' if narrow else f': make the elements {finer:.1f} times smaller there'}",
        )
    if found["lack"]:
        earlier = {each.last for front in found["fronts"] for each in front.stations}
        known = "K_N, K_T, K_S and slip zones are unknown"
        if earlier:
            state = solution.step_of(max(earlier))
            known = f"K_N is that of state {state}, in which the contact is largest"
        yield Kind.NO_FRONTS.found(known=known, why=found["lack"].text)
    assert contact.surface.facets is not None and contact.surface.free is not None
    at_border = closed & rim_nodes(contact.surface.facets, len(closed)) & ~contact.surface.free
    if at_border.any():
        place = ", ".join(f"{value:.4g}" for value in contact.surface.points[np.argmax(at_border)])
        yield (
            Kind.SURFACE_BORDER,
            f"the contact reaches the border of its surface, first at ({place}), where not both "
            "bodies end",
        )
    for each in found["patches"]:
        if each.reason:
            yield Kind.PATCH_FORCES, f"patch {each.name}: {each.reason}"
    if unsteady := unsteady_text(changes, solution.choice, solution.loads.open_channels):
        yield Kind.UNSTEADY, unsteady


def _beside_plane_mesh(solution: Solution, contact: ContactHistory, station: Station) -> str | None:
    """As `_beside_fine_mesh`, of a plane edge and the elements nearer to it than to the other one.

    Those beyond are fine for the other edge. The place is that at which K_N is reported, where
    meshes that refine themselves are finest.
    """
    arc, place = contact.surface.arc, station.position[station.decisive]
    pressed = np.flatnonzero(contact.traction[station.decisive, :, 0] > 0)
    if not len(pressed) or not np.isfinite(place):
        return None
    centre = float(arc[pressed[[0, -1]]].mean())
    s = station.inward * (np.column_stack([arc[:-1], arc[1:]]) - place)
    own = s[s.min(axis=1) < station.inward * (centre - place)]
    here = own[(own.min(axis=1) <= 0) & (own.max(axis=1) >= 0)]
    size = float(np.ptp(here, axis=1).max(initial=0.0))
    return _beside_fine_mesh(solution, replace(station, size=size), own, np.ptp(own, axis=1))


def _beside_solid_mesh(
    solution: Solution, contact: ContactHistory, edges: Indices, station: Station
) -> str | None:
    """As `_beside_fine_mesh`, of a station of solids and the edges of elements (E, 2)."""
    frame, places = station.frame, contact.surface.points[edges] - station.point
    s, along = places @ frame.inward, places @ frame.along
    across = np.abs(np.diff(s, axis=1)) >= np.abs(np.diff(along, axis=1))
    near = np.abs(along).max(axis=1) < max(station.depth, station.size)
    near &= across[:, 0] & (np.abs(s).max(axis=1) < station.depth)
    if not near.any():
        return None
    s = s[near] - station.position[station.decisive]
    return _beside_fine_mesh(solution, station, s, np.ptp(s, axis=1))


def _beside_fine_mesh(solution: Solution, station: Station, s: Array, lengths: Array) -> str | None:
    """Place of the fine mesh that a station is beside of, in words; None if it is in it.

    Args:
        solution: with the cycle.
        station: one.
        s: (E, 2) places of the ends of elements, inward from the station in the state that decides.
        lengths: (E,) of these.
    """
    finest = float(np.quantile(lengths[lengths > 0], 0.05)) if (lengths > 0).any() else np.inf
    if not station.size > BESIDE * finest:
        return None
    fine = s[(lengths > 0) & (lengths < FINE * finest)]
    inside = (fine.min(axis=1) < 0) & (fine.max(axis=1) > 0)
    cycle = cycle_states(solution.cycle)
    places = station.position[cycle if len(cycle) else [station.last]]
    if inside.any() or not np.isfinite(places).all():
        return None
    nearest = float(fine.ravel()[np.argmin(np.abs(fine))])
    moved = station.inward * (places - station.position[station.decisive])
    farther = np.abs(moved - nearest).max() + 4 * finest
    side = "in" if nearest > 0 else "out"
    return (
        f"elements are {station.size:.2g} long there, and {finest:.2g} from {abs(nearest):.2g} "
        f"further {side}: the fine mesh ends {farther:.2g} too early for this front"
    )


def _withheld(solution: Solution, name: str, found: Mapping[str, Any]) -> Iterator[Caution]:
    """Fronts most of whose stations have no K_N or no range, and why."""
    if solution.cycle is None:
        return
    states = slice(solution.cycle[0], solution.cycle[1] + 1)
    touching, sticking = (found[name][states] for name in ("contact_area", "stick_area"))
    share = np.where(touching > 0, sticking / np.maximum(touching, 1e-300), 1.0)
    least = int(np.argmin(share))
    for front in found["fronts"]:
        reasons = [each.text for station in front.judged if (each := withheld(station))]
        if front.lost or 2 * len(reasons) <= len(front.judged):
            continue
        text = (
            f"K_N or the range of K_T and K_S is not told at {len(reasons)} of "
            f"{len(front.judged)} stations, as {reasons[len(reasons) // 2]}"
        )
        if share[least] < NEARLY_SLIDES:
            state = solution.step_of(solution.cycle[0] + least)
            text += (
                f". The contact nearly slides: of {touching[least]:.3g} in contact "
                f"{sticking[least]:.2g} sticks in state {state}, so that there is no border "
                "between slip and stick next to the front"
            )
        yield from about(name, front.name, [(Kind.WITHHELD, text)])


def _nothing_known(contact: str, fronts: Sequence[Front]) -> Iterator[Caution]:
    """Stations of fronts of which nothing is known, and why; in the plane a front has one."""
    for front in fronts:
        count = len(front.stations)
        whole = [each for each in front.stations if each.lack.whole and not each.no_edge]
        lacks = Counter(each.lack for each in whole)
        for lack, number in lacks.items():
            stations = f"{number} of {count} stations " if count > 1 else ""
            finding = Kind.NOTHING_KNOWN.found(stations=stations, why=lack.text)
            yield from about(contact, front.name, [finding])


def _unknown(solution: Solution, contact: ContactHistory, station: Station) -> Iterator[Finding]:
    """Factors of a plane edge that cannot be told, and why; a K_N with a bar is told by itself."""
    absent = contact.exists[station.decisive] and not math.isfinite(station.decisive_k_n[0])
    # Where all slides a range is no measure of anything.
    ranged = solution.cycle is not None and not station.slides
    reason = withheld(station, k_n=bool(absent), ranged=ranged)
    if reason and not reason.whole:
        yield Kind.FACTORS_UNKNOWN, reason.text


def _slides(solution: Solution) -> Finding:
    """Caution about a contact that slides as a whole, in the cycle if there is one."""
    return Kind.GROSS_SLIP.found(when="" if solution.cycle is None else " in the cycle")


def _parted(contact: ContactHistory, states: Indices) -> Iterator[Finding]:
    """A contact that has carried something, but nothing in the states that count."""
    if not contact.pressed_nodes.any():
        return  # it never touches, which is told by itself
    gap = min(float(contact.gap[state].min()) for state in states)
    which = "in the evaluated cycle" if len(states) > 1 else "at the end"
    yield (
        Kind.PARTED,
        f"the bodies do not touch {which}, though they did before: the contact carries no force "
        f"there, and has no edges; the smallest gap is {max(gap, 0.0):.3g}",
    )


def _uncounted(solution: Solution, station: Station) -> Iterator[Finding]:
    """Irregular loads without a cycle whose cycles cannot be counted, and why."""
    if solution.cycle is not None:
        return
    turns = max((len(reversals(each)) for each in solution.values.T), default=0)
    known = np.isfinite(station.k_t)
    if turns >= FEWEST_TURNS and not station.cycles.count.size and not known.all():
        yield Kind.UNCOUNTED.found(why=station.cycles.reason)


def _patches(contact: ContactHistory) -> Iterator[Finding]:
    """Events of a patch, and nodes that belong to it but lie apart."""
    if contact.events:
        yield (
            Kind.PATCH_EVENTS,
            f"not there all the time, as one of several patches of {contact.pair!r}: it "
            f"{'; it '.join(contact.events)}",
        )
    shares, force = [], normal_force(contact)
    for states in blocks(len(contact.traction), contact.traction[0].size):
        pressure = contact.traction[states, :, 0]
        borders = np.diff(pressure > 0, axis=1, prepend=False, append=False)
        apart = np.count_nonzero(borders, axis=1) > 2
        # What lies apart as the bodies are about to part matters nothing.
        apart &= force[states] > SMALL_LOAD * force.max()
        for state in np.maximum(pressure[apart], 0.0):
            forces = [patch.force for patch in contact_patches(contact.surface.arc, state)]
            shares.append(max(forces) / sum(forces) if forces else 1.0)
    several = [share for share in shares if share < 1 - SMALLEST_PATCH]
    if several:
        yield (
            Kind.NODES_APART,
            f"in {len(several)} of {len(contact.traction) - 1} states up to {1 - min(several):.1%} "
            "of P is on single nodes apart from the patch, too few for edges of their own",
        )


def _ever_closed(contact: ContactHistory) -> tuple[Bools, float]:
    """(N,) nodes that are in contact in some state, and the smallest gap of all."""
    closed, smallest = np.zeros(len(contact.surface.weights), dtype=bool), np.inf
    for states in blocks(len(contact.status), len(contact.surface.weights)):
        closed |= np.any(contact.status[states] != OPEN, axis=0)
        smallest = min(smallest, float(contact.gap[states].min()))
    return closed, smallest


def _never_touch(contact: ContactHistory, smallest: float, dimension: int) -> Finding:
    """Caution about surfaces that are never in contact, by their smallest gap of all states."""
    first = float(contact.gap[0].min())
    hint = untouched_hint(first, smallest, contact.surface.weights, dimension)
    return Kind.NEVER_TOUCH.found(gap=max(smallest, 0.0), hint=hint)


def _surfaces(contact: ContactHistory, fronts: Sequence[Front]) -> Iterator[Caution]:
    """Surfaces that never touch, or end where they are in contact and have an edge."""
    closed, smallest = _ever_closed(contact)
    if not closed.any():
        yield from about(contact.name, "", [_never_touch(contact, smallest, 2)])
    endless = {front.name for front in fronts if front.stations[0].no_edge}
    for front in PLANE_FRONTS:
        if not front.from_front(closed)[0] or front.name in endless:
            continue
        kind = Kind.CUT_END if reaches_image(contact, front) else Kind.SURFACE_END
        yield from about(contact.name, front.name, [kind.found()])


def _uncertain(station: Station, kind: Kind) -> Iterator[Finding]:
    """Numbers of a station that the mesh or the steps leave open, or a layer.

    Args:
        station: of a plane contact.
        kind: of the caution about K_N.
    """
    (k_n, spread), lost = station.decisive_k_n, withheld(station, ranged=False).text
    if station.slides:  # finer elements and steps do not change that
        if math.isfinite(k_n) and lost:
            yield Kind.FACTORS_UNKNOWN, lost
        return
    if station.uncertain:
        size = "" if kind is Kind.LAYER else _wanted(station, station.size / BLIND)
        yield kind, f"{lost or f'K_N is known to {spread / k_n:.0%} only'}{size}"
    parts = station.k_range_parts
    steps = parts.steps + (0.0 if station.moves else parts.moved)
    # What drives nothing has no share that steps could be wrong by.
    if not station.undriven and steps > LARGEST_STEPS * station.k_t_range > 0:
        yield (
            Kind.STEPS_TOO_LONG,
            f"the range of K_T may be {steps / station.k_t_range:.1%} off by what happens between "
            "the steps",
        )
    zones = station.evaluated_zones
    # An uncertain K_N has the same remedy, and so has one of too few nodes.
    if station.uncertain or station.lack.finer:
        return
    hidden = [zone for zone in zones if not (zone.resolved or zone.unknown)]
    if hidden:
        few = [zone.prediction / FEWEST_ELEMENTS for zone in hidden if zone.prediction > 0]
        few = [size for size in few if size < station.size] or [station.size / BLIND]
        text = "the slip zone is not resolved by the mesh"
        yield Kind.NOT_RESOLVED, text + _wanted(station, min(few))


def _wanted(station: Station, size: float) -> str:
    """Elements at an edge and those that it wants, in words; empty without elements."""
    if not station.size > 0:
        return ""
    return f", with elements of {station.size:.2g} ({size:.2g} or less are wanted)"
