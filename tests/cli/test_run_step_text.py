# SPDX-License-Identifier: LGPL-3.0-or-later
"""The line about the solved steps at the end of a run."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from cases.halfplane_problems import LOAD, problem

from fretfe.cli.run import _step_text
from fretfe.halfplane import solve_half_planes


def test_a_run_without_solved_steps_has_no_mean_of_iterations() -> None:
    solution = solve_half_planes(problem(np.full(2, LOAD)), 20).solution
    assert "iterations a step" in _step_text(solution)
    unloaded = replace(solution, iterations=solution.iterations[:1])
    assert _step_text(unloaded) == ""
