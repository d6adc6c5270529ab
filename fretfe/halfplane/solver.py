# SPDX-License-Identifier: LGPL-3.0-or-later
"""Half-planes in contact: an interface problem, marched through a load history.

The compliance is exact for the piecewise-linear tractions; friction, contact area and history are
those of `fretfe.contact`. Between unlike half-planes pressure and shear influence each other's
displacements; between similar ones the pressure bounds the shear, and that is all.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.analytic.edges import sliding_exponent
from fretfe.contact.full_stick import FRACTION, neighbour_states
from fretfe.contact.interface import Coordinate, DenseCompliance, Interface, Place, add_layers
from fretfe.contact.march import March, StepResult
from fretfe.contact.recorder import Recorder
from fretfe.contact.solve import Progress, solve_history
from fretfe.contact.state import ContactState, StepLoads, StepTable, certify, unloaded
from fretfe.errors import ConvergenceError
from fretfe.evaluate.increments import UnitFactors
from fretfe.evaluate.loaded import moving_state
from fretfe.evaluate.plane.full_stick_fit import GALERKIN_OVERHANG
from fretfe.evaluate.plane.unit_factors import full_stick_units, half_plane_units
from fretfe.evaluate.slip import cycle_states
from fretfe.history.solution import ContactHistory, Factor, NearbyLoads, Solution
from fretfe.history.stream import UNSEEN, Storage
from fretfe.idealise import HalfPlaneProblem
from fretfe.idealise.bodies import SIMILAR
from fretfe.idealise.problem import contact_edges, governing_length, layer_reach
from fretfe.local.hat_functions import EdgeRange, HatFunctions, graded_grid
from fretfe.surface.contact_surface import ContactSurface
from fretfe.surface.friction import Friction

ELEMENTS = 300
# Distance of the reference point of the displacements, in widths of the grid: only a rigid motion.
FAR = 100.0
# Springs, in units of E* and the width of the grid, hold the body along x while there is no
# friction, and upright on a single node; they take up to about this fraction of Q and M.
SPRING = 1e-9
# Forces on body 1 along these coordinates are Q, -P and -M.
MOMENT = "moment"
COORDINATES = ("shear", "normal", MOMENT)
TENSION = "tension"


class PartingMarch(March):
    """March of half-planes, which are in place again where nothing loads them.

    No load then finds a resistance, and wherever bodies part they are in equilibrium.
    """

    def advance(
        self, state: ContactState, start: StepLoads, end: StepLoads, *rest: Any, **named: Any
    ) -> StepResult:
        """Go from one load to the next, as of `March.advance`."""
        if end.values.any() or end.amplitudes.any():
            return super().advance(state, start, end, *rest, **named)
        parted, none = unloaded(self.interface), np.zeros(self.interface.size)
        certificate = certify(self.interface, end, parted, state.relative[:, 1:])
        return StepResult(parted, none, 1, 1, 0, certificate, end.friction)


@dataclass(frozen=True)
class HalfPlaneOutcome:
    """All accepted steps, and the reason why the history was not finished, or None."""

    problem: HalfPlaneProblem
    solution: Solution
    failure: ConvergenceError | None

    def unit_factors(
        self, solution: Solution, contact: ContactHistory, positions: Array
    ) -> UnitFactors:
        """Singular factors for a unit of each driver; see `evaluate`.

        In closed form, but for one of several patches, which feel each other.
        """
        if contact.node_range is not None:
            units = full_stick_units(solution, contact, positions, GALERKIN_OVERHANG)
            if contact.surface.dundurs:  # the fits know nothing of it
                units = np.full_like(units, np.nan)
            return UnitFactors([units])
        beta, guided = self.problem.dundurs, self.problem.guided
        units = half_plane_units(positions, beta, guided)[..., [2, 0, 1, 3]]
        units *= np.array([1.0, -1.0, -1.0, 1.0])
        if guided:  # no load drives the moment
            units = np.delete(units, COORDINATES.index(MOMENT), axis=-1)
        return UnitFactors([units], exact=True)


def build_interface(problem: HalfPlaneProblem, hats: HatFunctions) -> Interface:
    """The interface problem of two half-planes on given nodes; body 1 moves as a whole."""
    weights, x = hats.weights, hats.nodes
    roots, size, width = np.sqrt(weights), len(x), float(hats.grid[-1] - hats.grid[0])
    far, spring = FAR * width, SPRING * problem.profile.e_star
    scaled = hats.compliance(far) / np.outer(roots, roots) / problem.profile.e_star
    coupling = hats.coupling() / np.outer(roots, roots) * problem.dundurs / problem.profile.e_star
    compliance = np.zeros((size, 2, size, 2))
    compliance[:, 0, :, 0] = scaled
    compliance[:, 1, :, 1] = problem.tangential * scaled
    compliance[:, 0, :, 1], compliance[:, 1, :, 0] = coupling, coupling.T
    matrix, contacts = compliance.reshape(2 * size, -1), {problem.contact: slice(0, size)}
    add_layers(matrix, contacts, {problem.contact: np.tile(problem.layer, (size, 1))}, 2)
    gap, tension = np.zeros((size, 2)), np.zeros((size, 2))
    gap[:, 0] = hats.integrate(problem.profile.gap) / roots
    # A bulk tension sigma0 stretches surface 2 by sigma0/(2 E*) more than surface 1.
    stretch = problem.tangential / (2 * problem.profile.e_star)
    tension[:, 1] = hats.integrate(lambda at: stretch * at) / roots
    motion = np.zeros((size, 2, 3))
    motion[:, 1, 0] = -roots
    motion[:, 0, 1] = roots
    motion[:, 0, 2] = hats.integrate(lambda at: at) / roots
    return Interface(
        components=2,
        compliance=DenseCompliance(matrix),
        gap=gap.ravel(),
        motion=motion.reshape(2 * size, 3),
        stiffness=np.diag([spring / problem.tangential, 0.0, spring * width**2]),
        loads=tension.reshape(2 * size, 1),
        coordinate_loads=np.zeros((3, 1)),
        roots=roots,
        coordinates=tuple(_coordinate(label, problem) for label in COORDINATES),
        contacts=contacts,
    )


def _coordinate(label: str, problem: HalfPlaneProblem) -> Coordinate:
    if problem.guided and label == MOMENT:
        return Coordinate(label, problem.body1, "fixed")
    return Coordinate(label, problem.body1, "force", label)


def edge_shift(problem: HalfPlaneProblem) -> float:
    """Largest movement of an edge by the shear of unlike bodies, over the half-width.

    A parabola that slides without turning reaches from -(1 - lambda) L to lambda L, and L grows
    with 1/sqrt(lambda (1 - lambda)).
    """
    exponent = sliding_exponent(abs(problem.dundurs), float(problem.friction.max()))
    return float(np.sqrt((1 - exponent) / exponent) - 1)


def contact_grid(problem: HalfPlaneProblem, elements: int = ELEMENTS) -> Array:
    """(elements + 1,) nodes over all that ever is in contact, graded to the edges in the cycle.

    Without a cycle, to the edges in the last state in which there are some.
    """
    contact = contact_edges(problem)
    states = cycle_states(problem.history.cycle)
    states = states if len(states) else np.flatnonzero(np.isfinite(contact.left))[-1:]
    states = states[np.isfinite(contact.left[states])]  # the bodies may part in the cycle
    half_width = float(np.min(contact.right[states] - contact.left[states]) / 2)
    length = governing_length(problem, half_width)
    shift, wider_by = edge_shift(problem) * half_width, layer_reach(problem)
    outward = (contact.left, shift + wider_by, shift), (contact.right, shift, shift + wider_by)
    left, right = (
        EdgeRange(float(edge[states].min()) - below, float(edge[states].max()) + above, length)
        for edge, below, above in outward
    )
    kinks = np.array(problem.profile.kinks)
    # The neighbours of the last state are wider than anything in the history.
    wider = contact_edges(problem.scaled(1 + FRACTION))
    left_end, right_end = float(np.nanmin(wider.left)), float(np.nanmax(wider.right))
    shift = edge_shift(problem) * (right_end - left_end) / 2 + wider_by
    reach = left_end - shift, right_end + shift
    return graded_grid((left, right), reach, np.unique([-kinks, kinks]), elements)


def solve_half_planes(
    problem: HalfPlaneProblem,
    elements: int = ELEMENTS,
    progress: Progress = lambda *_: None,
    until_steady: bool = True,
    storage: Storage = UNSEEN,
) -> HalfPlaneOutcome:
    """Solve the load history of a half-plane problem.

    Args:
        problem: whose loads leave the contact closed and without gross sliding.
        elements: of the graded grid.
        progress: as of `solve_history`.
        until_steady: whether repeated blocks are solved until they are steady and then not again.
        storage: where the states go.
    """
    hats = HatFunctions(contact_grid(problem, elements))
    interface = build_interface(problem, hats)
    steps = _step_loads(problem, interface)
    march = PartingMarch(interface)
    surface = _surface(problem, hats)
    place = Place(problem.contact, problem.body1, problem.body2, surface, hats.averaging())
    recorder = Recorder(march, [place], steps, [TENSION], degree=1, storage=storage)
    failure = None
    try:
        solve_history(march, recorder, steps, until_steady, progress)
    except ConvergenceError as error:
        failure = error
    solution = recorder.solution(problem.history, _balance(problem, recorder, hats))
    neighbours = _neighbours(problem, march, recorder, hats, solution)
    contact = replace(solution.contacts[0], nearby_loads=neighbours)
    return HalfPlaneOutcome(problem, replace(solution, contacts=(contact,)), failure)


def _neighbours(
    problem: HalfPlaneProblem,
    march: March,
    recorder: Recorder,
    hats: HatFunctions,
    solution: Solution,
) -> NearbyLoads | None:
    """Two load levels next to a state, with K_I between them in closed form."""
    state = moving_state(solution)
    states = neighbour_states(march, recorder.state(state), recorder.loads[state])
    if states is None:
        return None
    contact, step = contact_edges(problem), solution.step_of(state)
    positions = np.array([[contact.left[step]], [contact.right[step]]])
    loads = np.array([problem.normal_force[step], problem.moment[step], 0.0, 0.0])
    k_i = half_plane_units(positions)[0, :, Factor.K_I] @ (2 * FRACTION * loads)
    if abs(problem.dundurs) > SIMILAR:  # K_I depends on the shear, and on a length
        k_i = np.full_like(k_i, np.nan)
    pressure = np.array([state.traction[:, 0] for state in states]) / np.sqrt(hats.weights)
    return NearbyLoads(pressure, k_i[None], state)


def _step_loads(problem: HalfPlaneProblem, interface: Interface) -> StepTable:
    return StepTable(
        amplitudes=problem.bulk_tension[:, None],
        values=np.column_stack([problem.shear_force, -problem.normal_force, -problem.moment]),
        friction=(Friction.uniform(problem.friction, interface.size),),
        within=lambda steps, shares: _step_loads(problem.divided(steps, shares), interface),
    )


def _surface(problem: HalfPlaneProblem, hats: HatFunctions) -> ContactSurface:
    x = hats.nodes
    return ContactSurface(
        arc=x,
        points=np.column_stack([x, np.zeros_like(x)]),
        frames=np.broadcast_to(np.array([[0.0, 1.0], [1.0, 0.0]]), (len(x), 2, 2)),
        weights=hats.weights,
        dundurs=problem.dundurs,
        layer=np.array(problem.layer) * problem.profile.e_star if any(problem.layer) else None,
    )


def _balance(problem: HalfPlaneProblem, recorder: Recorder, hats: HatFunctions) -> dict[str, Array]:
    """(T,) imbalance of the contact forces and the loads Q, -P and -M, and its scales.

    A moment that is a reaction balances whatever it is.
    """
    roots = np.sqrt(hats.weights)
    arms = hats.integrate(lambda at: at) / roots
    parts = []
    for block in recorder.blocks():
        traction = block.traction.reshape(len(block.traction), len(roots), 2)
        contact = np.array([roots @ each for each in traction])
        moments = np.array([arms @ each[:, 0] for each in traction])
        parts.append(np.column_stack([contact[:, ::-1] * [1.0, -1.0], moments]))
    found, loads = np.concatenate(parts), recorder.loads.values
    largest = np.abs(loads[:, :2]).max(axis=1)
    turning = 0.0 if problem.guided else np.abs(found[:, 2] + loads[:, 2])
    return {
        "force_imbalance": np.abs(found[:, :2] - loads[:, :2]).max(axis=1),
        "force_scale": largest,
        "moment_imbalance": turning + np.zeros(len(found)),
        "moment_scale": largest * np.ptp(hats.nodes),
    }
