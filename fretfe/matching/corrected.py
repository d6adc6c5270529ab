# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads of a test corrected by the factors that finite elements have found in it.

Bodies of finite size deviate from half-planes by a factor that changes little with the loads: one
correction with the same pad leaves about the square of the deviation.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fretfe.errors import ModelError
from fretfe.geometry.templates import check_parameters, find_template
from fretfe.idealise.bodies import PROFILES, read_block
from fretfe.matching.pads import Factors, PadTest, closed_form, pad_test
from fretfe.matching.target import Target
from fretfe.results.model import Result


def corrected(factors: Factors, found: Target, result: Result) -> PadTest:
    """The same pad with the loads that give the factors.

    Args:
        factors: that are wanted.
        found: left edge of the test.
        result: of the test.

    Raises:
        ModelError: if the test is not one of the templates of pads.
    """
    test = _as_run(factors, found, result)
    had = closed_form(test)
    asked = replace(
        factors,
        k_n=had.k_n * factors.k_n / found.k_n,
        k_t_range=had.k_t_range * factors.k_t_range / found.k_t_range,
        k_i_range=had.k_i_range * factors.k_i_range / found.k_i_range if had.k_i_range else 0.0,
    )
    return pad_test(test.profile, asked)


def _as_run(factors: Factors, found: Target, result: Result) -> PadTest:
    """The test with the forces that its contact has carried in the cycle."""
    template = result.case.geometry.template
    if template not in PROFILES:
        raise ModelError(
            f"{result.directory or result.case.source}: expected a test with one of the templates "
            f"{', '.join(PROFILES)} to correct, found {template or 'a mesh'}"
        )
    values = check_parameters(find_template(template), result.case.geometry.parameters)
    profile = read_block(template, values, result.case).profile
    contact = result.contacts[0]
    begin, end = result.loads.cycle or (0, len(result.loads.times) - 1)
    force, shear = (each[begin : end + 1] for each in (contact.normal_force, contact.shear_force))
    varies = factors.k_i_range > 0
    middle = float(force.max() + force.min()) / 2
    return PadTest(
        profile=profile,
        factors=factors,
        half_width=float(profile.half_width(middle)),
        normal_force=middle,
        normal_amplitude=float(np.ptp(force)) / 2 if varies else 0.0,
        shear_amplitude=(found.in_step if varies else 1) * float(np.ptp(shear)) / 2,
    )
