# SPDX-License-Identifier: LGPL-3.0-or-later
"""The idealisation step, with P, Q, M and sigma0 of the loads and supports of a case."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fretfe._typing import Array
from fretfe.case import (
    Case,
    Load,
    Support,
    case_notes,
    isotropic,
    unit_vector,
)
from fretfe.case.holders import holders
from fretfe.errors import CaseError, ConvergenceError, ModelError
from fretfe.idealise.bodies import (
    LOWER,
    UPPER,
    Block,
    coupled_beta,
    geometry_obstacles,
    read_block,
    side_tension,
    tangential_ratio,
)
from fretfe.idealise.problem import HalfPlaneProblem, contact_edges, layer_reach
from fretfe.loads import History, build_history
from fretfe.loads.friction import read_coefficients
from fretfe.materials.moduli import plane_modulus
from fretfe.mesh.templates import check_parameters, find_template

TOP = "upper_top"
BOTTOM = "lower_bottom"
# Direction of the outward normal of the sides of the lower body, along x.
SIDES = {"lower_left": -1.0, "lower_right": 1.0}
OTHER_SIDE = {"lower_left": "lower_right", "lower_right": "lower_left"}
COMPONENTS = 2
STEEL = 0.3


@dataclass(frozen=True)
class Loading:
    """(T,) P, Q, M and sigma0 at every state, per unit thickness."""

    normal_force: Array
    shear_force: Array
    moment: Array
    bulk_tension: Array


def loading_obstacles(case: Case) -> Iterator[str]:
    """Reasons why the loads and supports of a case are not those of half-planes."""
    for name, load in case.loads.items():
        if obstacle := load.half_plane_obstacle(TOP, SIDES):
            yield f"loads.{name}: {obstacle}"
    for key in case.moving_across():
        if key[0] != "bodies":  # said of crystals in any case
            yield f"{'.'.join(map(str, key))}: expected nothing that moves the bodies along z"
    yield from _carried(case)
    if case.symmetry:
        yield "symmetry: expected no sector of a disc"
    if case.ties:
        yield "ties: expected bodies of one part"
    fixed = _fixed(case)
    unknown = sorted(set(fixed) - {BOTTOM, *SIDES})
    if unknown:
        yield f"supports: expected them on the lower body only, found {', '.join(unknown)}"
    for name, support in case.supports.items():
        if support.direction is not None and not _held(support):
            found = ", ".join(f"{part:.6g}" for part in support.direction)
            yield f"supports.{name}: expected a direction along x or y, found ({found})"
    if "y" not in fixed.get(BOTTOM, set()):
        yield f"supports: expected {BOTTOM!r} to be fixed in y, so that the block does not bend"
    if not any("x" in components for components in fixed.values()) and _is_sheared(case):
        yield f"supports: expected {BOTTOM!r} or a side of the block to be fixed in x, found none"
    sides = {load.on for load in _side_loads(case).values()}
    if sides and "x" in fixed.get(BOTTOM, set()):
        yield (
            f"supports: expected {BOTTOM!r} to be free in x under a bulk tension, found it fixed: "
            "the tension would not reach the contact"
        )
    held = _held_sides(case)
    if len(sides) > 1 or any(OTHER_SIDE[side] not in held for side in sides):
        yield "loads: expected bulk tension on one side of the block and the other side fixed in x"
    yield from _surface_obstacles(case)
    rough = any(contact.rough for contact in case.contacts.values())
    if (sides or (rough and _only_held_side(case))) and not _has_shear_load(case):
        found = "the bulk tension" if sides else "the support of one side"
        yield (
            f"loads: expected a force on {TOP!r} in x as well as {found} (0 will do): "
            "without one the shear force is an unknown reaction"
        )


def _carried(case: Case) -> Iterator[str]:
    """Tractions normal to a top that is held there; those along axes no case has."""
    for name, load in _top_loads(case).items():
        for holder in holders(case.supports, case.loads) if load.along == "normal" else ():
            if holder.boundary == TOP and (text := holder.carried("y")):
                yield f"loads.{name}: {text}"


def _surface_obstacles(case: Case) -> Iterator[str]:
    if case.start is not None:
        yield "start: expected a case that begins unloaded: states of other runs are of meshes"
    for name, contact in case.contacts.items():
        if contact.gap is not None:
            yield f"contacts.{name}.gap: expected the gap of the template alone"
        if contact.layer is not None and contact.layer.curve is not None:
            yield f"contacts.{name}.layer: expected a stiffness, not a curve of pressures"
        if contact.layer is not None and contact.layer.csv is not None:
            yield f"contacts.{name}.layer: expected the same layer all over the surface"
        if not read_coefficients(case, name).even:
            yield f"contacts.{name}.friction: expected the same coefficient all over the surface"


def _fixed(case: Case) -> dict[str, set[str]]:
    """Components held on each supported boundary."""
    fixed: dict[str, set[str]] = {}
    for support in case.supports.values():
        fixed.setdefault(support.boundary, set()).update(_held(support))
    return fixed


def _held(support: Support) -> tuple[str, ...]:
    """Components that a support holds; none if it does so along neither axis."""
    if support.direction is None:
        return support.fix
    across = np.abs(unit_vector(support.direction, COMPONENTS)) < 1e-9
    return tuple(axis for axis, free in zip("xy", across[::-1], strict=True) if free)


def _held_sides(case: Case) -> list[str]:
    """The sides of the block that are fixed in x."""
    fixed = _fixed(case)
    return [side for side in SIDES if "x" in fixed.get(side, set())]


def _only_held_side(case: Case) -> str | None:
    """The side of the block that is fixed in x if the other one is not."""
    held = _held_sides(case)
    return held[0] if len(held) == 1 else None


def _side_tension(case: Case, block: Block) -> tuple[float, float]:
    """Bulk tension by a unit of Q where only the left side is held, and its error bar."""
    sliding = "x" not in _fixed(case).get(BOTTOM, set())
    return side_tension(block.half_widths[1], block.heights[1], sliding=sliding)


def _kept(case: Case) -> float:
    """Compression along held sides of the block over that by P; 0 if one of them is free.

    Poisson's ratio of the plane; of crystals that of steel.
    """
    if len(_held_sides(case)) < len(SIDES):
        return 0.0
    known = isotropic(case.bodies[LOWER])
    nu = STEEL if known is None else known.poisson
    return nu / (1 - nu) if case.model.plane == "strain" else nu


def _side_loads(case: Case) -> dict[str, Load]:
    return {
        name: load
        for name, load in case.loads.items()
        if load.half_plane and not load.rigid and load.on in SIDES
    }


def _top_loads(case: Case) -> dict[str, Load]:
    return {name: load for name, load in case.loads.items() if load.half_plane and load.on == TOP}


def _has_shear_load(case: Case) -> bool:
    """True if the force along x is given: by a load, or because a traction lets the top move."""
    platens = [load for load in _top_loads(case).values() if load.rigid]
    along_x = any(abs(_direction(load)[0]) > 1e-9 for load in platens)
    return along_x or not platens


def _is_sheared(case: Case) -> bool:
    """True if a load on the top has a part along x."""
    return any(abs(_direction(load)[0]) > 1e-9 for load in _top_loads(case).values())


def guided(case: Case) -> bool:
    """True if the top of the upper body is a platen, which does not turn."""
    return any(load.rigid for load in _top_loads(case).values())


def read_loading(case: Case, history: History, block: Block) -> Loading:
    """P, Q, M and sigma0 of a case without obstacles.

    The resultant of the loads on the upper body passes through the contact; a platen takes up its
    moment, so that M = 0, and so is the tilt of the profile. Different bodies stretch differently:
    sigma0 = 2 E* x (strain of the lower body), with E* by the compliance to shear. Half-planes
    carry Q away half to either side; a block that is held on one side only carries more of it
    there, which is the same but for a uniform tension (`side_tension`).
    """
    values = dict(zip(history.channels, history.values.T, strict=True))
    force = np.zeros((COMPONENTS, len(history.times)))
    for name, load in _top_loads(case).items():
        # A traction acts on the whole top, a platen force is for the whole thickness.
        per_unit = 1 / case.model.thickness if load.rigid else block.top_width
        force += np.outer(_direction(load), values[name]) * per_unit
    tension = np.zeros(len(history.times))
    for name, load in _side_loads(case).items():
        along = 1.0 if load.along == "normal" else _direction(load)[0] * SIDES[load.on]
        tension += along * values[name]
    if (side := _only_held_side(case)) is not None:
        tension -= SIDES[side] * force[0] * _side_tension(case, block)[0]
    modulus = plane_modulus(case.bodies[LOWER], case.model.plane)
    return Loading(
        normal_force=0.0 - force[1],  # of 0 no -0
        shear_force=force[0],
        moment=np.zeros(len(history.times)) if guided(case) else block.heights[0] * force[0],
        bulk_tension=2 * block.profile.e_star / tangential_ratio(case) * tension / modulus,
    )


def _direction(load: Load) -> tuple[float, ...]:
    assert load.along is not None
    if load.along == "normal":  # outward at the top
        return (0.0, 1.0)
    return unit_vector(load.along, COMPONENTS)


# Bodies smaller than this many half-widths are no half-planes at all.
SMALLEST_BODY = 2.0


class NotIdealisable(CaseError):
    """There is no half-plane problem for a case; `reasons` says why, one by one."""

    def __init__(self, case: Case, reasons: list[str]) -> None:
        super().__init__(
            f"{case.source}: not a half-plane problem:\n"
            + "\n".join(f"  {reason}" for reason in reasons)
        )
        self.reasons = tuple(reasons)


def idealise(case: Case, loads: History | None = None) -> HalfPlaneProblem:
    """Map a case to half-planes: a cylinder, wedge or flat-and-rounded pad on a large block.

    Args:
        case: the case.
        loads: in place of those of the case.

    Raises:
        NotIdealisable: if that is not possible.
        CaseError: if the template, its parameters or the history are not valid.
        ModelError, ConvergenceError: as `HalfPlaneProblem.require_partial_slip`.
    """
    reasons = list(geometry_obstacles(case)) or list(loading_obstacles(case))
    if reasons:
        raise NotIdealisable(case, reasons)
    assert case.geometry.template is not None
    template = find_template(case.geometry.template, length=case.units.length)
    values = check_parameters(template, case.geometry.parameters)
    block = read_block(case.geometry.template, values, case)
    history = loads or build_history(case)
    loading = read_loading(case, history, block)
    name, contact = next(iter(case.contacts.items()))
    layer = contact.layer
    problem = HalfPlaneProblem(
        contact=name,
        body1=UPPER,
        body2=LOWER,
        profile=block.profile,
        history=history,
        friction=read_coefficients(case, name).over(history.times),
        normal_force=loading.normal_force,
        shear_force=loading.shear_force,
        moment=loading.moment,
        bulk_tension=loading.bulk_tension,
        tangential=tangential_ratio(case),
        dundurs=coupled_beta(case, name, UPPER, LOWER),
        layer=(0.0, 0.0) if layer is None else layer.compliances,
        guided=guided(case) and coupled_beta(case, name, UPPER, LOWER) != 0,
        between=_between(case, history, block),
        stretch=block.stretch(
            *(plane_modulus(case.bodies[each], case.model.plane) for each in (UPPER, LOWER)),
            kept=_kept(case),
        ),
        notes=(),
    )
    if problem.sheared.any() and not problem.friction.any():
        text = "expected friction, which alone carries the shear force, found 0"
        raise NotIdealisable(case, [f"contacts.{name}.friction: {text}"])
    problem.require_partial_slip()
    edges = contact_edges(problem)
    reach = float(np.nanmax(np.abs([edges.left, edges.right]))) + layer_reach(problem)
    if block.smallest < SMALLEST_BODY * reach:
        raise NotIdealisable(case, [_too_small(block, reach)])
    errors = (*_errors(case, block, reach), block.slip_error)
    return problem.with_errors(*errors).with_notes(_notes(case, block, reach))


def _errors(case: Case, block: Block, reach: float) -> tuple[float, float]:
    """Relative errors of K_N and K_T by the size and slope of the bodies and how they are held.

    A tension sigma0 is sigma0/4 √(a/2) in K_T, and Q is Q/(π √(2 a)).
    """
    k_n, k_t = block.size_errors(reach)
    if _only_held_side(case) is not None:
        k_t += np.pi * reach / 4 * _side_tension(case, block)[1]
    return k_n, k_t


def _between(case: Case, history: History, block: Block) -> Array | None:
    """(T-1, S, 4) P, Q, M and sigma0 within the steps; None if they are straight lines there."""
    if history.between is None:
        return None
    steps, places, channels = history.between.shape
    inner = replace(
        history,
        times=np.zeros(steps * places),
        values=history.between.reshape(-1, channels),
        cycle=None,
        between=None,
    )
    loading = read_loading(case, inner, block)
    loads = [loading.normal_force, loading.shear_force, loading.moment, loading.bulk_tension]
    return np.column_stack(loads).reshape(steps, places, len(loads))


def obstacles(case: Case) -> tuple[str, ...]:
    """Reasons why there is no half-plane problem for a case; empty if there is one.

    Raises:
        CaseError: if the template, its parameters or the history are not valid.
    """
    try:
        idealise(case)
    except NotIdealisable as error:
        return error.reasons
    except (ModelError, ConvergenceError) as error:
        return (str(error),)
    return ()


def _too_small(block: Block, reach: float) -> str:
    return (
        f"geometry.parameters: expected bodies larger than {SMALLEST_BODY:g} times what the "
        f"contact reaches ({reach:.4g}), found a width or height of {block.smallest:g}"
    )


def _notes(case: Case, block: Block, reach: float) -> Iterator[str]:
    yield from case_notes(case)
    yield f"half-planes in place of {case.geometry.template!r}, {_size(case, block, reach)}"
    if guided(case):
        yield (
            "the platen does not turn: M is a reaction"
            if coupled_beta(case, next(iter(case.contacts)), UPPER, LOWER)
            else "the platen does not turn: the pressure is symmetric, M = 0"
        )
    if (side := _only_held_side(case)) is not None:
        share, error = (2 * block.heights[1] * each for each in _side_tension(case, block))
        yield (
            f"{side} carries more of Q than the other side: a tension of {share:.2g} ± {error:.1g} "
            "times Q/2 over the height of the block is added"
        )
    if reach > block.zone:
        yield (
            f"the contact reaches beyond the candidate zone of the template ({reach:.4g} > "
            f"{block.zone:g})"
        )


def _size(case: Case, block: Block, reach: float) -> str:
    k_n, k_t = _errors(case, block, reach)
    return (
        f"whose bodies are {block.smallest / reach:.3g} half-widths wide or high: K_N is about "
        f"{k_n:.2%} off, ΔK_T {k_t:.2%}"
    )
