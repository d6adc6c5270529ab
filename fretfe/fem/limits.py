# SPDX-License-Identifier: LGPL-3.0-or-later
"""Limits of the model, judged on a solved history with its displacements. Collective."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from fretfe._typing import Array, Bools, Indices
from fretfe.bodies.definition import BodyDefinition, Pair
from fretfe.bodies.loads.strain import heatings, surface_temperatures
from fretfe.case import Case, isotropic
from fretfe.case.bodies import OverTemperature
from fretfe.contact.interface import coordinate_range
from fretfe.contact.recorder import Recorder, StateBlock
from fretfe.errors import ConvergenceError
from fretfe.evaluate.contacts import Contact
from fretfe.evaluate.limits import (
    ContactExtent,
    ModelLimit,
    contact_extent,
    contact_limits,
    friction_limits,
)
from fretfe.evaluate.loaded import NO_LOAD
from fretfe.evaluate.resultants import SMALLEST_SHEAR, shear_direction
from fretfe.evaluate.slip import cycle_states
from fretfe.fem.model import Model, Reduction
from fretfe.fem.reduction import ReducedBody
from fretfe.history.solution import OPEN, ContactHistory, Solution
from fretfe.history.state_array import StateArray, blocks
from fretfe.idealise.bodies import SIMILAR, cross_compliance, dissimilarity
from fretfe.loads.friction import read_coefficients
from fretfe.loads.over_surface import read_gap
from fretfe.mesh.elements import reference_nodes, shape_values
from fretfe.reason import Kind
from fretfe.surface.checks import INTERPENETRATION_PER_FACET
from fretfe.surface.gap import LARGEST_MISS, gap_missed
from fretfe.surface.normals import mean_share
from fretfe.surface.surface import Surface, curvatures, deviations, normal_vectors

# Sum of the forces or moments on a body over that of their sizes from which a solution means
# nothing. Meshes up to 330 000 unknowns give 1e-12; what is lost grows with the
# ratio of the stiffnesses of bodies and supports.
LARGEST_IMBALANCE = 1e-4
# Forces keep their directions in a linear model: on a contact that turns by this angle, a force of
# two hundredths of P along it is missing or too much.
LARGEST_TURN = 0.02
# Gaps follow profiles that slide, the tractions of pairs do not: with roundings of 4 mm on both
# bodies the half-width is .1 % off after a fortieth of that.
LARGEST_SHIFT = 0.1
# The slope of the deformed surface, a/R for Hertz, from which half-spaces, small angles and
# tractions along the undeformed normal are doubted.
LARGEST_SLOPE = 0.1
# Error of K_T by pairing along normals that do not turn.
LARGEST_PAIRING_ERROR = 0.02
# Linear elasticity leaves out terms of the order of the strain.
LARGEST_STRETCH = 0.01
# One of two equal bodies has half of the compliance of a contact: one per cent of E*.
LARGEST_SOFTENING = 0.02
# An offset by this part of the radius changes the radius by it, and curvatures as much.
LARGEST_OFFSET = 0.01
# Depth over the width of the contact: about the pressure over the modulus that is left out.
LARGEST_PENETRATION = 1e-3


# From displacements (n, N, d) in n states to their derivatives (n, d - 1, N, d) along the tangents.
Derive = Callable[[Array], Array]


@dataclass(frozen=True)
class Motion:
    """Rotation and stretch of both surfaces of a contact, through all T states.

    Attributes:
        turn: (2, T, m) mean rotation of body 1 and body 2 over the contact: in the plane
            anticlockwise, of solids a vector.
        slope: largest rotation of a surface in the contact, about its tangents.
        stretch: largest root mean square of the strain of a surface over the contact.
        curvature: largest one of the surfaces where they ever touch, before deformation.
        turning: largest one of the line along which the bodies slide there: one over the sum of
            the radii of both surfaces.
        share: of the way from the normals of surface 1 to those of surface 2 on which contact
            normals are.
    """

    turn: Array
    slope: float
    stretch: float
    curvature: float
    turning: float
    share: float

    @property
    def normal_turn(self) -> Array:
        """(T, m) rotation of the contact normal, between those of both bodies."""
        return np.asarray((1 - self.share) * self.turn[0] + self.share * self.turn[1])


def opened(solution: Solution) -> str:
    """Say from which step on nothing is in contact, if that is so at the end; else empty."""
    pressures = [
        max(float(np.max(each.mean_traction[state][:, 0])) for each in solution.contacts)
        for state in range(len(solution.times))
    ]
    carrying = np.flatnonzero(np.array(pressures) > NO_LOAD * max(pressures))
    if not len(carrying) or carrying[-1] == len(pressures) - 1:
        return ""
    step = solution.step_of(int(carrying[-1]) + 1)
    return (
        f"The contact opens at step {step}: no contact is left, and what nothing else holds flies "
        "off. End the history before that, or hold the body by a support or a displacement."
    )


def imbalance(solution: Solution) -> ConvergenceError | None:
    """The reason why a solution means nothing, if forces or moments on a body do not balance."""
    for kind in ("force", "moment"):
        ratio = solution.imbalance(kind)
        worst = int(np.argmax(ratio))
        if ratio[worst] > LARGEST_IMBALANCE:
            if parted := opened(solution):
                return ConvergenceError(f"{kind}s on a body do not balance. {parted}")
            return ConvergenceError(
                f"step {solution.step_of(worst)}: expected {kind}s that balance on every body, "
                f"found that {ratio[worst]:.1e} of them is left over: round-off has destroyed the "
                "solution. Check the stiffnesses of the bodies, which may differ by a factor of "
                "about 1e8 at most, and the units; all steps are kept, but none can be trusted. A "
                "body that nothing holds but a contact, which opens in this step, may have moved "
                "away."
            )
    return None


def model_limits(
    model: Model,
    recorder: Recorder,
    solution: Solution,
    contacts: Sequence[Contact],
    depths: Mapping[str, float],
) -> tuple[ModelLimit, ...]:
    """All limits of a solved history, contact by contact; on rank 0.

    Args:
        model: of the bodies.
        recorder: holds the solved states.
        solution: the same states in physical units.
        contacts: their evaluation.
        depths: of unpaired penetration, by surface pair.
    """
    summaries = {each.name: each for each in contacts}
    limits = [_balance_limit(solution, kind) for kind in ("force", "moment")]
    pairs = {each.name: each for each in model.reduction.pairs}
    for history in solution.contacts:
        pair = pairs[history.pair]
        limits += contact_limits(model.case.bodies, model.case.model.plane, history)
        limits += friction_limits(summaries[history.name], history, solution.cycle)
        limits += _dissimilar(model.case, history)
        limits += _given_gap(model.case, history)
        limits += _at_other_temperatures(model, history, solution)
        extent = contact_extent(history)
        if extent.width > 0:
            motion = _motion(model, pair, history, recorder)
            limits += _motion_limits(history, extent, motion)
            limits += _offset(model.case, history, solution, motion)
            summary, cycle = summaries[history.name], cycle_states(solution.cycle)
            limits.append(_pairing(summary, history, motion, cycle))
            limits.append(_penetration(history, extent, depths[pair.name]))
    return tuple(limits)


def _given_gap(case: Case, history: ContactHistory) -> Iterator[ModelLimit]:
    """Part of a given gap that elements miss where there is contact."""
    if (given := read_gap(case, history.pair)) is not None:
        states = blocks(len(history.status), history.status[0].size)
        pressed = np.any([(history.status[each] != OPEN).any(axis=0) for each in states], axis=0)
        yield ModelLimit(
            history.name,
            Kind.GAP_MISSED,
            "distance of the elements from the gap given, over its range",
            gap_missed(given, history.surface, pressed),
            LARGEST_MISS,
        )


def _balance_limit(solution: Solution, kind: str) -> ModelLimit:
    return ModelLimit(
        "",
        Kind.BALANCE,
        f"sum of the {kind}s on a body over that of their sizes",
        float(solution.imbalance(kind).max()),
        LARGEST_IMBALANCE,
    )


def _at_other_temperatures(
    model: Model, history: ContactHistory, solution: Solution
) -> Iterator[ModelLimit]:
    """Change of Young's modulus along a contact and through its cycle, where it is told."""
    case = model.case
    states = cycle_states(solution.cycle) if solution.cycle is not None else [-1]
    for body in (history.body1, history.body2):
        curve = case.given.young.get(body) if case.given is not None else None
        loads = model.reduction.definition.loads
        used, start = case.bodies[body].temperature, case.bodies[body].reference_temperature
        if curve is None or not heatings(loads, body) or used is None or start is None:
            continue
        found = surface_temperatures(case, loads, (body,), history.surface.points, solution.loads)
        low, high = float(found[states].min()), float(found[states].max())
        yield ModelLimit(
            history.name,
            Kind.TEMPERATURE,
            f"change of Young's modulus of {body} by temperature, over the one used",
            _largest_change(curve, low, high, used),
            LARGEST_SOFTENING,
            f"the stiffness is that at {used:g} °C everywhere, next to {low:.4g} to "
            f"{high:.4g} °C at the surface",
        )
        first, last = curve.temperatures[0], curve.temperatures[-1]
        yield ModelLimit(
            history.name,
            Kind.TEMPERATURE_TABLE,
            f"temperature beyond the table of Young's modulus of {body}, over its extent",
            max(first - low, high - last, 0.0) / (last - first),
            0.0,
            f"the surface is at {low:.4g} to {high:.4g} °C, the table reaches from "
            f"{first:g} to {last:g} °C",
        )


def friction_notes(model: Model, solution: Solution) -> Iterator[str]:
    """Pressures and temperatures beyond the tables of friction, in words."""
    case, units = model.case, model.case.units
    for history in solution.contacts:
        given = read_coefficients(case, history.pair)
        bodies, points = (history.body1, history.body2), history.surface.points
        if given.pressure is not None:
            what, unit, table = "mean pressures", units.stress, given.pressure
            means = history.mean_traction
            parts = blocks(len(means), means[0].size)
            low, high = 0.0, max(float(means[part][..., 0].max()) for part in parts)
        elif given.temperature is not None:
            what, unit, table = "temperatures", "°C", given.temperature
            loads = model.reduction.definition.loads
            heat = surface_temperatures(case, loads, bodies, points, solution.loads)
            low, high = float(heat.min()), float(heat.max())
        else:
            continue
        if low < table[0] or high > table[-1]:
            yield (
                f"{given.key}: {what} of {low:.4g} to {high:.4g} {unit} are beyond the "
                f"table, from {table[0]:g} to {table[-1]:g}: there friction is that at its end"
            )


def _largest_change(curve: OverTemperature, low: float, high: float, used: float) -> float:
    """Largest change of a constant between two temperatures; NaN beyond its table."""
    if low < curve.temperatures[0] or high > curve.temperatures[-1]:
        return math.nan
    inside = [each for each in curve.temperatures if low < each < high]
    constants = [curve.at(each) for each in (low, *inside, high)]
    return max(abs(each / curve.at(used) - 1) for each in constants)


def oscillates(case: Case, history: ContactHistory) -> bool:
    """True if full stick oscillates next to the edges of a contact: K_I alone means nothing."""
    return history.friction.largest > 0 and _oscillation(case, history) > SIMILAR


def _oscillation(case: Case, history: ContactHistory) -> float:
    """Dundurs' beta, or what takes its place between crystals."""
    bodies = case.bodies[history.body1], case.bodies[history.body2]
    return abs(dissimilarity(*bodies, case.model.plane, history.surface.mean_normal))


def _dissimilar(case: Case, history: ContactHistory) -> Iterator[ModelLimit]:
    """Of crystals, that full stick oscillates at an edge, which only isotropic bodies know.

    And that pressure and shear depend on each other without oscillating.
    """
    if history.friction.largest == 0:
        return
    bodies = case.bodies[history.body1], case.bodies[history.body2]
    if not all(isotropic(each) for each in bodies):
        words, found = "Dundurs' beta of the bodies, with friction", _oscillation(case, history)
        yield ModelLimit(history.name, Kind.OSCILLATION, words, found, SIMILAR)
    cross = cross_compliance(*bodies, case.model.plane, history.surface.mean_normal)
    if cross > 0:
        yield ModelLimit(
            history.name,
            Kind.CROSS_COMPLIANCE,
            "cross compliance of the crystals, over those of pressure and shear, with friction",
            cross,
            SIMILAR,
        )


def _motion_limits(
    history: ContactHistory, extent: ContactExtent, motion: Motion
) -> Iterator[ModelLimit]:
    name = history.name
    yield ModelLimit(
        name,
        Kind.TURNING_NORMAL,
        "sliding over the sum of the radii of both surfaces",
        extent.sliding * motion.turning,
        LARGEST_TURN,
    )
    yield ModelLimit(
        name,
        Kind.SHIFTED,
        "sliding over the smaller radius of the surfaces",
        extent.sliding * motion.curvature,
        LARGEST_SHIFT,
    )
    yield ModelLimit(
        name,
        Kind.ROTATION,
        "rotation of a body at the contact",
        float(np.linalg.norm(motion.turn, axis=-1).max()),
        LARGEST_TURN,
    )
    yield ModelLimit(
        name,
        Kind.SLOPE,
        "largest slope that a surface takes in the contact",
        motion.slope,
        LARGEST_SLOPE,
    )
    yield ModelLimit(
        name,
        Kind.STRETCH,
        "stretch of a surface, root mean square over the contact",
        motion.stretch,
        LARGEST_STRETCH,
    )


def _offset(
    case: Case, history: ContactHistory, solution: Solution, motion: Motion
) -> Iterator[ModelLimit]:
    """An overlap moves surfaces along their normals and leaves them as curved as they are."""
    names = [name for name, load in case.loads.items() if load.closes == history.name]
    if names:
        loads = solution.loads
        overlap = sum(loads.values[:, loads.channels.index(name)] for name in names)
        yield ModelLimit(
            history.name,
            Kind.OVERLAP,
            "overlap of an interference over the smaller radius of the surfaces",
            float(np.abs(overlap).max()) * motion.curvature,
            LARGEST_OFFSET,
        )


def _pairing(
    summary: Contact, history: ContactHistory, motion: Motion, cycle: Indices
) -> ModelLimit:
    """Error of K_T because a gap along a turned normal counts as tangential displacement.

    In a gap g that closes, a common rotation ω moves partners apart by g ω. That adds ω p to the
    shear, as g causes p, less what brings Q back to its value: K_T is wrong by that of Q = ω P.
    A bound: part of ω is the slope that the shear itself gives to the surfaces.
    """
    turned = motion.normal_turn * summary.normal_force[:, None]
    if summary.solid:
        weights = history.surface.weights
        normal = weights @ history.surface.frames[:, 0] / weights.sum()
        wrong, largest = _swing(np.cross(turned, normal)[cycle]), _swing(summary.shear_force[cycle])
        known = largest > SMALLEST_SHEAR * np.abs(summary.normal_force).max()
    else:
        factors = turned[:, 0] / (np.pi * np.sqrt(2 * summary.half_width))
        wrong = float(np.ptp(factors[cycle])) if len(cycle) else np.nan
        largest = max(station.k_range for station in summary.stations)
        of_pressure = summary.normal_force / (np.pi * np.sqrt(2 * summary.half_width))
        known = largest > NO_LOAD * float(np.nanmax(of_pressure, initial=0.0))
    return ModelLimit(
        summary.name,
        Kind.PAIRING,
        "bound of the error of ΔK_T by gap times rotation",
        wrong / largest if known else np.nan,
        LARGEST_PAIRING_ERROR,
    )


def _swing(force: Array) -> float:
    """Range of forces (n, 3) along the direction in which they vary most; NaN if there are none."""
    return float(np.ptp(force @ shear_direction(force))) if len(force) else np.nan


def _penetration(history: ContactHistory, extent: ContactExtent, deepest: float) -> ModelLimit:
    return ModelLimit(
        history.name,
        Kind.PENETRATION,
        "penetration of the surfaces where nothing is paired, over the width of the contact",
        deepest / extent.width,
        LARGEST_PENETRATION,
    )


def _motion(model: Model, pair: Pair, history: ContactHistory, recorder: Recorder) -> Motion:
    contact = model.case.contacts[pair.name]
    touched = np.zeros(len(history.surface.weights), dtype=bool)
    rotations = 1 if history.surface.facets is None else 3
    turn, slope, stretch = np.zeros((2, len(history.status), rotations)), 0.0, 0.0
    derive = _along_arc(history) if history.surface.facets is None else _along_surface(history)
    for block in recorder.blocks():
        closed = history.status[block.states] != OPEN
        touched |= closed.any(axis=0)
        weights = closed * history.surface.weights
        total = np.maximum(weights.sum(axis=1), np.finfo(float).tiny)
        for number, body in enumerate((pair.body1, pair.body2)):
            moved = _displacement(model.reduction, pair, body, block)
            slopes = derive(moved if body == pair.body1 else -moved)
            rotation, tilt, strain = _deformation(slopes, history.surface.frames)
            turn[number, block.states] = np.einsum("tnm,tn->tm", rotation, weights) / total[:, None]
            slope = max(slope, float((tilt * closed).max()))
            mean_square = (strain**2 * weights).sum(axis=1) / total
            stretch = max(stretch, float(np.sqrt(mean_square).max()))
    surfaces = [model.surfaces[name] for name in (contact.surface1, contact.surface2)]
    points = history.surface.points
    curvature = np.array([_curvatures_near(surface, points)[touched] for surface in surfaces])
    normals = [surface.nearest(points)[1] for surface in surfaces]
    return Motion(
        turn=turn,
        slope=slope,
        stretch=stretch,
        curvature=float(curvature.max()),
        turning=float(_in_series(curvature).max()),
        share=mean_share(history.surface.frames[:, 0, : points.shape[1]], -normals[0], normals[1]),
    )


def _in_series(curvature: Array) -> Array:
    """(n,) curvature of the sum of both radii, of curvatures (2, n); 0 next to a flat."""
    low, high = curvature.min(axis=0), curvature.max(axis=0)
    ratio = np.divide(low, high, out=np.ones_like(low), where=high > 0)
    return np.asarray(low / (1 + ratio))


def _along_arc(history: ContactHistory) -> Derive:
    return lambda moved: np.gradient(moved, history.surface.arc, axis=1)[:, None]


def _along_surface(history: ContactHistory) -> Derive:
    """Mean derivatives of the facets around each node, along the tangents of the surface there."""
    facets, points = history.surface.facets, history.surface.points
    assert facets is not None
    corners, tangents = facets.shape[1], history.surface.frames[facets][:, :, 1:].mean(axis=1)
    places = points[facets] - points[facets].mean(axis=1, keepdims=True)
    # The plane through the corners, by least squares: exact for triangles.
    shares = np.linalg.pinv(np.einsum("fkd,fad->fka", places, tangents))
    around = np.bincount(facets.ravel(), minlength=len(points))
    rows = np.repeat(facets, corners, axis=1).ravel()
    columns = np.tile(facets, (1, corners)).ravel()
    size = (len(points),) * 2
    derivatives = []
    for share in shares.swapaxes(0, 1):
        values = np.tile(share, (1, corners)).ravel() / around[rows]
        derivatives.append(sparse.csr_array((values, (rows, columns)), shape=size))

    def derive(moved: Array) -> Array:
        flat = moved.swapaxes(0, 1).reshape(len(around), -1)
        found = [(each @ flat).reshape(len(around), -1, 3).swapaxes(0, 1) for each in derivatives]
        return np.stack(found, axis=1)

    return derive


def _deformation(slopes: Array, frames: Array) -> tuple[Array, Array, Array]:
    """Rotation and strain of a surface in n states, from the derivatives of its displacement.

    Args:
        slopes: (n, d - 1, N, c) along each tangent of the surface.
        frames: (N, c, c) of the nodes, of plane bodies with or without z.

    Returns:
        (n, N, m) rotation, (n, N) size of that about the tangents, and (n, N) size of the strain
        of the surface, the root of the sum of the squares of its components.
    """
    tilts = np.einsum("tand,nd->tna", slopes, frames[:, 0])
    strains = np.einsum("tand,nbd->tnab", slopes, frames[:, 1 : slopes.shape[1] + 1])
    even = (strains + strains.swapaxes(2, 3)) / 2
    tilt, strain = np.linalg.norm(tilts, axis=2), np.linalg.norm(even, axis=(2, 3))
    if slopes.shape[1] == 1:
        return tilts, tilt, strain
    # A rotation ω moves the surface by ω x r: its slope along t1 is -ω t2, that along t2 is ω t1.
    spin = (strains[..., 0, 1] - strains[..., 1, 0]) / 2
    parts = np.stack([spin, tilts[..., 1], -tilts[..., 0]], axis=2)
    return np.einsum("tna,nad->tnd", parts, frames), tilt, strain


def _displacement(reduction: Reduction, pair: Pair, body: str, block: StateBlock) -> Array:
    """(n, N, d) displacement of body 1, or that of body 2 times -1, at the nodes of a contact."""
    interface = reduction.interface
    nodes, own = interface.contacts[pair.name], coordinate_range(interface.coordinates, body)
    d = interface.components
    weighted = reduction.bodies[body].relative_displacement(
        block.traction,
        block.coordinates[:, own],
        block.amplitudes,
        slice(nodes.start * d, nodes.stop * d),
    )
    relative = weighted.reshape(len(weighted), -1, d)
    # Along the tangents w is that of body 2 relative to body 1.
    signs = np.where(np.arange(relative.shape[2]) > 0, -1.0, 1.0)
    parts = relative / interface.roots[nodes, None] * signs
    return np.einsum("tnc,ncd->tnd", parts, pair.coupling.surface.frames)


def _curvatures_near(surface: Surface, points: Array) -> Array:
    """(n,) curvature of the facets whose middles are nearest to points (n, d)."""
    facets = cKDTree(surface.nodes.mean(axis=1)).query(points)[1]
    return curvatures(surface)[facets]


def balance(reduction: Reduction, blocks: Iterable[StateBlock]) -> dict[str, Array]:
    """(T,) largest sums of all forces and moments on a body, and their scales, by name.

    The scale of the forces is the sum of their sizes, at each node of contacts and loads: what
    presses on a body from all sides has a resultant of zero. That of the moments is the same times
    the size of the body, and the moments of tilted platens.

    Args:
        reduction: the bodies.
        blocks: all solved states.
    """
    found: dict[str, list[Array]] = {}
    for block in blocks:
        bodies = [_body_balance(reduction, each, block) for each in reduction.definition.bodies]
        for name in bodies[0]:
            largest = np.array([body[name] for body in bodies]).max(axis=0)
            found.setdefault(name, []).append(largest)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _body_balance(
    reduction: Reduction, definition: BodyDefinition, block: StateBlock
) -> dict[str, Array]:
    body = reduction.bodies[definition.name]
    own = coordinate_range(reduction.interface.coordinates, definition.name)
    coordinates = block.coordinates[:, own]
    reactions, by_reactions, tilting = _reactions(reduction, definition, block.forces[:, own])
    excess = reactions + block.amplitudes @ body.body.load_resultants.T
    excess += body.contact_forces(block.traction)
    scale = by_reactions + np.abs(block.amplitudes) @ body.body.load_sizes
    scale += _contact_sizes(reduction, body, block.traction)
    moments = np.abs(body.moments(block.traction, coordinates, block.amplitudes)).max(axis=1)
    if (tie := definition.tie) is not None:
        # The neighbours of a sector balance what is across the axis. They cannot keep it from
        # turning about it: nor should the node that holds it have to.
        excess = excess - (excess @ tie.across.T) @ tie.across
        for constraint, force in zip(definition.constraints, block.forces[:, own].T, strict=False):
            if constraint.at:
                arm = np.linalg.norm(tie.from_axis(np.array([constraint.at])))
                moments = np.maximum(moments, np.abs(force) * arm)
    return {
        "force_imbalance": np.abs(excess).max(axis=1),
        "force_scale": scale,
        "moment_imbalance": moments,
        "moment_scale": scale * body.body.size + tilting,
    }


def _contact_sizes(reduction: Reduction, body: ReducedBody, traction: Array) -> Array:
    """(n,) sum of the sizes of the nodal contact forces on a body, for tractions (n, N*d)."""
    d = reduction.interface.components
    nodal = traction[:, body.rows].reshape(len(traction), -1, d)
    return np.linalg.norm(nodal, axis=2) @ reduction.interface.roots[body.rows[::d] // d]


def _reactions(
    reduction: Reduction, definition: BodyDefinition, forces: Array
) -> tuple[Array, Array, Array]:
    """(n, d) sum of the forces that constrained boundaries exert on a body, and (n,) sizes of them.

    Parts that overlap push each other: their sum is zero, their size is not.

    Args:
        reduction: the bodies.
        definition: of the body.
        forces: (n, m) of its coordinates.

    Returns:
        The sum, the sizes of the forces together, and those of the moments of tilts.
    """
    d, count = reduction.interface.components, len(definition.constraints)
    directions = np.array([c.direction for c in definition.constraints]).reshape(count, d)
    pushing = np.array([not c.overlap for c in definition.constraints], dtype=bool)
    turning = np.array([len(c.axis) > 0 for c in definition.constraints], dtype=bool)
    # About the axis of a sector they have no resultant that its neighbours do not balance.
    around = np.array([c.around is not None for c in definition.constraints], dtype=bool)
    # Rigid modes restrained by contact come last, and no force acts on them.
    own = forces[:, :count]
    sizes = np.abs(own)
    return (
        own @ (directions * pushing[:, None]),
        sizes @ (np.linalg.norm(directions, axis=1) + around),
        sizes @ turning,
    )


def farthest_states(model: Model, pair: Pair, recorder: Recorder) -> Indices:
    """States in which the surfaces of a contact are nearest to each other or have slid farthest.

    None of them if all nodes of both surfaces are paired.
    """
    coupling = pair.coupling
    components = coupling.surface.frames.shape[1]
    if not any(_unpaired(each, components).any() for each in (coupling.body1, coupling.body2)):
        return np.array([], dtype=np.int64)
    nodes = model.reduction.interface.contacts[pair.name]
    return _extremes(recorder.relative(nodes))


def unpaired_penetration(model: Model, pair: Pair, moved: Sequence[dict[str, Array]]) -> float:
    """Largest depth to which unpaired nodes of either surface are inside the other one.

    Args:
        model: the bodies; on rank 0.
        pair: the contact.
        moved: displacements of all contact surfaces, by name, in some states.
    """
    coupling, contact = pair.coupling, model.case.contacts[pair.name]
    degree = model.case.model.degree
    first, second = (model.surfaces[name] for name in (contact.surface1, contact.surface2))
    components, size = coupling.surface.frames.shape[1], first.dimension
    alone1, alone2 = (_unpaired(each, components) for each in (coupling.body1, coupling.body2))
    deepest = 0.0
    for state in moved:
        places1, places2 = (
            surface.displacement_points(degree) + state[surface.name][:, :size]
            for surface in (first, second)
        )
        deepest = max(
            deepest,
            depth(places1[alone1], places2[second.displacement_facets(degree)], second),
            depth(places2[alone2], places1[first.displacement_facets(degree)], first),
        )
    return deepest


def _unpaired(operator: sparse.csr_matrix, components: int) -> Bools:
    """(m,) nodes of a surface that no contact integral of an operator (N*d, m*d) refers to."""
    used = np.diff(operator.tocsc().indptr) > 0
    return np.asarray(~used.reshape(-1, components).any(axis=1))


def _extremes(relative: StateArray) -> Indices:
    """States in which mean gap and mean tangential displacement of (T, N, d) are extreme."""
    parts = blocks(len(relative), math.prod(relative.shape[1:]))
    means = np.concatenate([relative[part].mean(axis=1) for part in parts])
    return np.unique([means.argmin(axis=0), means.argmax(axis=0)])


def depth(points: Array, facets: Array, surface: Surface) -> float:
    """Largest depth of points inside a body, behind its deformed surface.

    Args:
        points: (n, d).
        facets: (f, k, d) corners, then middles, of the deformed facets.
        surface: before deformation, for what its mesh does not resolve.
    """
    if not len(points):
        return 0.0
    shape, degree = surface.shape, 1 if facets.shape[1] == surface.corners.shape[1] else 2
    centre = reference_nodes(shape, 1).mean(axis=0)[None]
    middles = np.einsum("k,fkd->fd", shape_values(shape, degree, centre)[0], facets)
    normals = normal_vectors(facets, shape, degree, centre)[:, 0]
    widths = np.linalg.norm(normals, axis=1)
    normals, sizes = normals / widths[:, None], widths ** (1 / (facets.shape[2] - 1))
    nearest = cKDTree(middles).query(points)[1]
    seen = points - middles[nearest]
    inside = -np.sum(seen * normals[nearest], axis=1)
    along = np.linalg.norm(seen + inside[:, None] * normals[nearest], axis=1)
    # Beyond an end of the surface there is another boundary, or nothing.
    beside = along <= sizes[nearest]
    allowed = deviations(surface) + INTERPENETRATION_PER_FACET * sizes
    excess = np.where(beside, inside - allowed[nearest], 0.0)
    return float(max(excess.max(), 0.0))
