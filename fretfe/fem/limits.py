# SPDX-License-Identifier: LGPL-3.0-or-later
"""Limits of the model, judged on a solved history with its displacements: see `edges.limits`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from fretfe._typing import Array, Indices
from fretfe.bodies.pairs import Pair
from fretfe.case import Case
from fretfe.contact.interface import coordinate_range
from fretfe.contact.recorder import Recorder, StateBlock
from fretfe.edges.front import ContactSummary, fronts_of
from fretfe.edges.limits import ContactExtent, ModelLimit, contact_extent, contact_limits
from fretfe.edges.slip_zones import cycle_states
from fretfe.errors import ConvergenceError
from fretfe.fem.model import Model, Reduction
from fretfe.idealise.bodies import SIMILAR, dissimilarity
from fretfe.results.solution import OPEN, ContactHistory, Solution
from fretfe.surface.chain import Chain
from fretfe.surface.surface import Surface

# Forces or moments on a body that do not add up to zero, over the largest of them, from which a
# solution means nothing. Meshes up to 330 000 unknowns give 1e-12; what is lost grows with the
# ratio of the stiffnesses of bodies and supports.
LARGEST_IMBALANCE = 1e-4
# Forces keep their directions in a linear model: on a contact that turns by this angle, a force of
# two hundredths of P along it is missing or too much.
LARGEST_TURN = 0.02
# The slope of the deformed surface, a/R for Hertz, from which half-spaces, small angles and
# tractions along the undeformed normal are doubted.
LARGEST_SLOPE = 0.1
# Error of K_T by pairing along normals that do not turn.
LARGEST_PAIRING_ERROR = 0.02
# Linear elasticity leaves out terms of the order of the strain.
LARGEST_STRETCH = 0.01
# Depth over the width of the contact: about the pressure over the modulus that is left out.
LARGEST_PENETRATION = 1e-3


@dataclass(frozen=True)
class Motion:
    """Rotation and stretch of both surfaces of a contact, through all T states.

    Attributes:
        turn: (2, T) mean rotation of body 1 and body 2 over the contact, anticlockwise.
        slope: largest rotation of a surface in the contact.
        stretch: largest root mean square of the strain of a surface over the contact.
        curvature: largest one of the surfaces where they ever touch, before deformation.
        mean_curvature: (2,) of the whole surfaces, by which contact normals are weighted.
    """

    turn: Array
    slope: float
    stretch: float
    curvature: float
    mean_curvature: Array

    @property
    def normal_turn(self) -> Array:
        """(T,) rotation of the contact normal: of each body by the curvature of the other."""
        first, second = self.mean_curvature
        if second == 0:
            return np.asarray(self.turn[1])
        return np.asarray((second * self.turn[0] + first * self.turn[1]) / (first + second))


def imbalance(solution: Solution) -> ConvergenceError | None:
    """The reason why a solution means nothing, if forces or moments on a body do not balance."""
    for kind in ("force", "moment"):
        ratio = _imbalance(solution, kind)
        worst = int(np.argmax(ratio))
        if ratio[worst] > LARGEST_IMBALANCE:
            return ConvergenceError(
                f"step {worst}: expected {kind}s that balance on every body, found a sum of "
                f"{ratio[worst]:.1e} of the largest of them: round-off has destroyed the solution. "
                "Check the stiffnesses of the bodies, which may differ by a factor of about 1e8 at "
                "most, and the units; all steps are kept, but none can be trusted."
            )
    return None


def _imbalance(solution: Solution, kind: str) -> Array:
    """(T,) sum of the forces or moments on a body over the largest of them."""
    parts = solution.certificates
    scale = np.maximum(parts[f"{kind}_scale"], np.finfo(float).tiny)
    return np.asarray(parts[f"{kind}_imbalance"] / scale)


def model_limits(
    model: Model,
    recorder: Recorder,
    solution: Solution,
    contacts: tuple[ContactSummary, ...],
    depths: dict[str, float],
) -> tuple[ModelLimit, ...]:
    """All limits of a solved history, contact by contact; on rank 0.

    Args:
        model: of the bodies.
        recorder: holds the solved states.
        solution: the same states in physical units.
        contacts: their evaluation.
        depths: of unpaired penetration, by surface pair.
    """
    assert model.reduction is not None
    summaries = {each.name: each for each in contacts}
    limits = [_balance_limit(solution, kind) for kind in ("force", "moment")]
    pairs = {each.name: each for each in model.reduction.pairs}
    for history in solution.contacts:
        pair = pairs[history.pair]
        limits += contact_limits(model.case, history)
        limits += _dissimilar(model.case, history)
        extent = contact_extent(history)
        if extent.width > 0:
            motion = _motion(model, pair, history, recorder)
            limits += _motion_limits(history, extent, motion)
            cycle = cycle_states(solution.cycle)
            limits.append(_pairing(summaries[history.name], motion, cycle))
            limits.append(_penetration(history, extent, depths[pair.name]))
    return tuple(limits)


def solid_limits(case: Case, solution: Solution) -> tuple[ModelLimit, ...]:
    """Limits of a solved history of solids that the history tells by itself."""
    limits = [_balance_limit(solution, kind) for kind in ("force", "moment")]
    for history in solution.contacts:
        limits += contact_limits(case, history)
        limits += _dissimilar(case, history)
    return tuple(limits)


def _balance_limit(solution: Solution, kind: str) -> ModelLimit:
    return ModelLimit(
        "",
        f"sum of the {kind}s on a body over the largest of them",
        float(_imbalance(solution, kind).max()),
        LARGEST_IMBALANCE,
        "round-off has destroyed the solution",
    )


def without_moved(
    case: Case, solution: Solution, contacts: tuple[ContactSummary, ...]
) -> tuple[ContactSummary, ...]:
    """The contacts without K_N by the moving edge where it needs a K_I that is not defined.

    Between dissimilar bodies with friction the integral, which assumes beta = 0, makes it 50 %
    wrong.
    """
    wrong = {history.name for history in solution.contacts if oscillates(case, history)}
    return tuple(_without_moved(each) if each.name in wrong else each for each in contacts)


def _without_moved(contact: ContactSummary) -> ContactSummary:
    stations = (
        replace(each, k_n_moved=np.nan, k_n_moved_spread=np.nan) for each in contact.stations
    )
    return replace(contact, fronts=fronts_of(stations))


def oscillates(case: Case, history: ContactHistory) -> bool:
    """Whether full stick oscillates next to the edges of a contact: K_I is not defined there."""
    return any(limit.exceeded for limit in _dissimilar(case, history))


def _dissimilar(case: Case, history: ContactHistory) -> Iterator[ModelLimit]:
    """Between dissimilar bodies full stick oscillates at an edge: K_T and K_I are not defined."""
    if not np.any(history.friction > 0):
        return
    bodies = case.bodies[history.body1], case.bodies[history.body2]
    yield ModelLimit(
        history.name,
        "Dundurs' beta of the bodies, with friction",
        abs(dissimilarity(*bodies, case.model.plane)),
        SIMILAR,
        "the tractions of full stick oscillate next to an edge, which K_T, K_I and what follows "
        "from them neglect; rely on tractions and slip zones",
    )


def _motion_limits(
    history: ContactHistory, extent: ContactExtent, motion: Motion
) -> Iterator[ModelLimit]:
    name = history.name
    yield ModelLimit(
        name,
        "sliding over the smaller radius of the surfaces",
        extent.sliding * motion.curvature,
        LARGEST_TURN,
        "the contact normal turns by this angle, and with it the normal force; use smaller loads",
    )
    yield ModelLimit(
        name,
        "rotation of a body at the contact",
        float(np.abs(motion.turn).max()),
        LARGEST_TURN,
        "forces keep their directions in this model and turn against the contact; hold the body, "
        "or use a code for large rotations",
    )
    yield ModelLimit(
        name,
        "largest slope that a surface takes in the contact",
        motion.slope,
        LARGEST_SLOPE,
        "angles of this size are not small; check units and loads",
    )
    yield ModelLimit(
        name,
        "stretch of a surface, root mean square over the contact",
        motion.stretch,
        LARGEST_STRETCH,
        "strains of this size are not small; check units and loads",
    )


def _pairing(summary: ContactSummary, motion: Motion, cycle: Indices) -> ModelLimit:
    """Error of K_T because a gap along a turned normal counts as tangential displacement.

    In a gap g that closes, a common rotation ω moves partners apart by g ω. That adds ω p to the
    shear, as g causes p, less what brings Q back to its value: K_T is wrong by that of Q = ω P.
    A bound: part of ω is the slope that the shear itself gives to the surfaces.
    """
    wrong = motion.normal_turn * summary.normal_force / (np.pi * np.sqrt(2 * summary.half_width))
    largest = max(station.k_t_range for station in summary.stations)
    found = float(np.ptp(wrong[cycle])) / largest if len(cycle) and largest > 0 else np.nan
    return ModelLimit(
        summary.name,
        "bound of the error of ΔK_T by gap times rotation",
        found,
        LARGEST_PAIRING_ERROR,
        "the bodies turn under the loads of the cycle; apply the shear nearer to the contact, or "
        "use lower or wider bodies",
    )


def _penetration(history: ContactHistory, extent: ContactExtent, deepest: float) -> ModelLimit:
    return ModelLimit(
        history.name,
        "penetration of the surfaces where nothing is paired, over the width of the contact",
        deepest / extent.width,
        LARGEST_PENETRATION,
        "contact is looked for only between points that face each other before deformation, up to "
        "half the length of the shorter surface apart: put the bodies where they touch, or make a "
        "contact of these parts",
    )


def _motion(model: Model, pair: Pair, history: ContactHistory, recorder: Recorder) -> Motion:
    assert model.reduction is not None
    contact = model.case.contacts[pair.name]
    touched = np.zeros(len(history.arc), dtype=bool)
    turn, slope, stretch = np.zeros((2, len(history.status))), 0.0, 0.0
    for block in recorder.blocks():
        closed = history.status[block.states] != OPEN
        touched |= closed.any(axis=0)
        weights = closed * history.weights
        total = np.maximum(weights.sum(axis=1), np.finfo(float).tiny)
        for number, body in enumerate((pair.body1, pair.body2)):
            rotation, strain = _deformation(model.reduction, pair, body, history, block)
            turn[number, block.states] = (rotation * weights).sum(axis=1) / total
            slope = max(slope, float(np.abs(rotation * closed).max()))
            mean_square = (strain**2 * weights).sum(axis=1) / total
            stretch = max(stretch, float(np.sqrt(mean_square).max()))
    surfaces = [model.surfaces[name] for name in (contact.surface1, contact.surface2)]
    curvature = np.array([_curvatures(surface, history.points) for surface in surfaces])
    return Motion(
        turn=turn,
        slope=slope,
        stretch=stretch,
        curvature=float(curvature[:, touched].max()),
        mean_curvature=np.array([Chain(surface).mean_curvature for surface in surfaces]),
    )


def _deformation(
    reduction: Reduction, pair: Pair, body: str, history: ContactHistory, block: StateBlock
) -> tuple[Array, Array]:
    """(n, N) rotation, anticlockwise, and strain of the surface of a body in n states."""
    moved = _displacement(reduction, pair, body, block)
    slope = np.gradient(moved if body == pair.body1 else -moved, history.arc, axis=1)
    tangents, normals = history.frames[:, 1], history.frames[:, 0]
    return np.einsum("tnd,nd->tn", slope, normals), np.einsum("tnd,nd->tn", slope, tangents)


def _displacement(reduction: Reduction, pair: Pair, body: str, block: StateBlock) -> Array:
    """(n, N, d) displacement of body 1, or that of body 2 times -1, at the nodes of a contact."""
    interface = reduction.interface
    nodes, own = interface.contacts[pair.name], coordinate_range(interface.coordinates, body)
    weighted = reduction.bodies[body].relative_displacement(
        block.traction, block.coordinates[:, own], block.amplitudes
    )
    relative = weighted.reshape(len(weighted), interface.size, -1)[:, nodes]
    # Along the tangents w is that of body 2 relative to body 1.
    parts = relative / interface.roots[nodes, None] * np.array([1.0, -1.0])
    return np.einsum("tnc,ncd->tnd", parts, pair.coupling.frames)


def _curvatures(surface: Surface, points: Array) -> Array:
    """(n,) curvature of the facets whose middles are nearest to points (n, 2)."""
    facets = cKDTree(surface.nodes.mean(axis=1)).query(points)[1]
    return Chain(surface).curvatures[facets]
