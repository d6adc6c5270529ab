# SPDX-License-Identifier: LGPL-3.0-or-later
"""The idealisation step."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fretfe._typing import Array
from fretfe.case import Case
from fretfe.errors import ModelError
from fretfe.idealise.bodies import (
    LOWER,
    UPPER,
    Block,
    dissimilarity,
    geometry_obstacles,
    read_block,
)
from fretfe.idealise.loading import guided, loading_obstacles, one_sided, read_loading
from fretfe.idealise.problem import HalfPlaneProblem, contact_edges
from fretfe.loads import History, build_history
from fretfe.mesh.templates import check_parameters, find_template

# Bodies smaller than this many half-widths are no half-planes at all.
SMALLEST_BODY = 2.0


class NotIdealisable(ModelError):
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
    problem = HalfPlaneProblem(
        contact=name,
        body1=UPPER,
        body2=LOWER,
        profile=block.profile,
        history=history,
        friction=np.where(history.times > contact.friction_from, contact.friction, 0.0),
        normal_force=loading.normal_force,
        shear_force=loading.shear_force,
        moment=loading.moment,
        bulk_tension=loading.bulk_tension,
        between=_between(case, history, block),
        notes=(),
    )
    problem.require_partial_slip()
    edges = contact_edges(problem)
    reach = float(np.nanmax(np.abs([edges.left, edges.right])))
    if block.smallest < SMALLEST_BODY * reach:
        raise NotIdealisable(case, [_too_small(block, reach)])
    return problem.with_errors(*block.size_errors(reach)).with_notes(_notes(case, block, reach))


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
    except ModelError as error:
        return (str(error),)
    return ()


def _too_small(block: Block, reach: float) -> str:
    return (
        f"geometry.parameters: expected bodies larger than {SMALLEST_BODY:g} times what the "
        f"contact reaches ({reach:.4g}), found a width or height of {block.smallest:g}"
    )


def _notes(case: Case, block: Block, reach: float) -> Iterator[str]:
    yield f"half-planes in place of {case.geometry.template!r}, {_size(block, reach)}"
    if guided(case):
        yield "the platen does not turn: the pressure is symmetric, M = 0"
    if one_sided(case):
        yield "one side of the block carries all of Q: a tension of Q/2 over its height is added"
    beta = dissimilarity(case.bodies[UPPER], case.bodies[LOWER], case.model.plane)
    if abs(beta) > 1e-9:
        yield f"pressure and shear are taken as independent (Dundurs' beta = {beta:.3g})"
    if reach > block.zone:
        yield (
            f"the contact reaches beyond the candidate zone of the template ({reach:.4g} > "
            f"{block.zone:g})"
        )


def _size(block: Block, reach: float) -> str:
    k_n, k_t = block.size_errors(reach)
    return (
        f"whose bodies are {block.smallest / reach:.3g} half-widths wide or high: K_N is about "
        f"{k_n:.2%} off, ΔK_T {k_t:.2%}"
    )
