# SPDX-License-Identifier: LGPL-3.0-or-later
"""The monolithic solver side by side with the condensed path, on the same case."""

from __future__ import annotations

import numpy as np
from cases.contact_runs import Run
from reference.monolithic import MonolithicSolver, MonolithicStep

from fretfe._typing import Array
from fretfe.fem.model import Request

# Both paths end with round-off only. It grows with the condition of the bodies and of the contact;
# measured: 3e-11 with a body that rocks on the contact, 4e-12 otherwise.
SAME = 1e-9


def difference(found: list[Array], expected: list[Array]) -> float:
    """Largest difference in any step, over the largest value in all of them."""
    both = np.array(found), np.array(expected)
    return float(np.abs(both[0] - both[1]).max() / np.abs(both[1]).max())


def assert_same(condensed: Run, steps: list[MonolithicStep]) -> None:
    """Every step of both: tractions, gap and slip, whole displacement fields, forces."""
    interface = condensed.model.reduction.interface
    assert len(steps) == len(condensed.results)
    # A step cut into parts has another slip history: there would be nothing to compare.
    assert [result.parts for result in condensed.results] == [1] * len(steps)
    states = [result.state for result in condensed.results]
    roots = interface.roots[:, None]
    assert difference([s.traction for s in steps], [s.traction / roots for s in states]) < SAME
    assert difference([s.relative for s in steps], [s.relative / roots for s in states]) < SAME
    held = [j for j, c in enumerate(interface.coordinates) if c.control != "free"]
    assert difference([s.forces for s in steps], [s.forces[held] for s in states]) < SAME
    requests = [Request.of(*each) for each in zip(states, condensed.steps[1:], strict=True)]
    recovered = condensed.model.recover_fields([condensed.model.share(each) for each in requests])
    fields = [np.concatenate([u.x.array for u in field.values()]) for field in recovered]
    own = [np.concatenate(list(s.displacements.values())) for s in steps]
    assert difference(own, fields) < SAME


def monolithic(condensed: Run) -> list[MonolithicStep]:
    return list(MonolithicSolver(condensed.model).run(condensed.steps))


def statuses(condensed: Run) -> set[int]:
    """STICK and SLIP if there were such nodes after the press steps."""
    return {int(s) for result in condensed.results[2:] for s in np.unique(result.state.status)}
