# SPDX-License-Identifier: LGPL-3.0-or-later
"""Limits of the model, judged on a solved history: equilibrium, dissimilar bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretfe.case import Case
from fretfe.edges.front import ContactSummary
from fretfe.errors import ConvergenceError
from fretfe.idealise.bodies import SIMILAR, dissimilarity
from fretfe.results.solution import ContactHistory, Solution

# Forces on a body that do not add up to zero, over the largest of them, from which a solution means
# nothing. Meshes up to 330 000 unknowns give 1e-12; what is lost grows with the ratio of the
# stiffnesses of bodies and supports.
LARGEST_IMBALANCE = 1e-4


def imbalance(solution: Solution) -> ConvergenceError | None:
    """The reason why a solution means nothing, if the forces on a body do not balance."""
    certificates = solution.certificates
    scale = np.maximum(certificates["force_scale"], np.finfo(float).tiny)
    ratio = certificates["force_imbalance"] / scale
    worst = int(np.argmax(ratio))
    if ratio[worst] <= LARGEST_IMBALANCE:
        return None
    return ConvergenceError(
        f"step {worst}: expected forces that balance on every body, found a sum of "
        f"{ratio[worst]:.1e} of the largest of them: round-off has eaten the solution. Check the "
        "stiffnesses of the bodies, which may differ by 1e8 or so at most, and the units; all "
        "steps are kept, none can be trusted."
    )


def with_model_warnings(
    case: Case, solution: Solution, contacts: tuple[ContactSummary, ...]
) -> tuple[ContactSummary, ...]:
    """The contacts with warnings where the description of their edges does not hold."""
    return tuple(
        replace(each, warnings=(*each.warnings, *_dissimilar(case, history)))
        for each, history in zip(contacts, solution.contacts, strict=True)
    )


def _dissimilar(case: Case, history: ContactHistory) -> tuple[str, ...]:
    """Between dissimilar bodies full stick oscillates at an edge: K_T and K_I are not defined."""
    bodies = case.bodies[history.body1], case.bodies[history.body2]
    beta = dissimilarity(*bodies, case.model.plane)
    if not np.any(history.friction > 0) or abs(beta) <= SIMILAR:
        return ()
    return (
        f"the bodies are dissimilar (Dundurs' beta = {beta:.3g}): with friction the tractions of "
        "full stick oscillate next to an edge, and K_T, K_I and what follows from them neglect "
        "that; rely on tractions and slip zones, not on K_N by the moving edge",
    )
