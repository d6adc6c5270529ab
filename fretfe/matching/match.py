# SPDX-License-Identifier: LGPL-3.0-or-later
"""From the edge of a component to tests with the same factors, and back to what they are worth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fretfe.case import Units
from fretfe.caution import grouped
from fretfe.errors import CaseError, ModelError
from fretfe.idealise.bodies import PROFILES, read_block
from fretfe.matching.agreement import Agreement, compare_edges
from fretfe.matching.choose import Choices, choose
from fretfe.matching.pads import Factors, PadTest, closed_form, pad_test
from fretfe.matching.rig import Rig
from fretfe.matching.target import NORMAL_COUNTS, Target, read_target
from fretfe.mesh.templates import check_parameters, find_template
from fretfe.results.model import Result

# Coefficients of friction, or moduli, that differ by less than this fraction are the same.
SAME = 0.01


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
    known = find_template(template, length=result.case.units.length)
    values = check_parameters(known, result.case.geometry.parameters)
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


@dataclass(frozen=True)
class Match:
    """Tests for an edge of a component.

    Attributes:
        target: the edge.
        rig: that they are for.
        factors: that the tests have.
        shapes: choices for each shape of pad.
        notes: what differs from the component all the same.
    """

    target: Target
    rig: Rig
    factors: Factors
    shapes: tuple[Choices, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Comparison:
    """Solved tests beside the component.

    Attributes:
        agreements: one for each test.
        corrected: the same pads with loads corrected by what was found.
    """

    agreements: tuple[Agreement, ...]
    corrected: tuple[PadTest, ...]


def match_test(result: Result, edge: str, rig: Rig) -> Match:
    """Find laboratory tests with the edge factors of a component.

    Args:
        result: of the component.
        edge: as of `read_target`.
        rig: bounds of the laboratory.

    Raises:
        FretfeError: if there is no such edge, its factors are not known, or units or friction of
            the rig are others. Bounds that no test can meet are no error: `shapes` names them.
    """
    target = read_target(result, edge)
    _require_same(result, target, rig)
    factors = _factors(target, rig)
    shapes = tuple(choose(target, rig, factors, shape) for shape in rig.pad.shapes)
    return Match(target, rig, factors, shapes, (*_notes(target, factors), *_unchecked(rig)))


def compare_tests(match: Match, tests: Sequence[tuple[str, Result]]) -> Comparison:
    """Lay the tractions of solved tests over those of the component.

    Args:
        match: of the component.
        tests: names and results; the left edge of each is compared.

    Raises:
        FretfeError: if a test has no tractions or factors to compare, or units or friction are
            others.
    """
    for name, result in tests:
        _require_same_units(match.rig.units, result.case.units, name)
    agreements = tuple(compare_edges(match.target, result, name) for name, result in tests)
    for each in agreements:
        _require_same_friction(match.target, each.test.friction, each.name)
    return Comparison(
        agreements,
        tuple(
            corrected(match.factors, each.test, result)
            for each, (_, result) in zip(agreements, tests, strict=True)
        ),
    )


def _factors(target: Target, rig: Rig) -> Factors:
    follows = rig.forces.normal_amplitude is not None and target.in_step != 0
    return Factors(
        k_n=target.k_n,
        k_t_range=target.k_t_range,
        k_i_range=target.k_i_range if follows else 0.0,
        in_step=target.in_step or 1,
        friction=target.friction,
        bulk_range=rig.forces.bulk_range,
        bulk_phase=math.radians(rig.forces.bulk_phase),
    )


def _require_same(result: Result, target: Target, rig: Rig) -> None:
    """Check that numbers of rig and component mean the same."""
    _require_same_units(result.case.units, rig.units, "rig")
    if not target.friction > 0:
        raise ModelError(f"edge {target.name}: expected friction, found none")
    if rig.friction is not None:
        _require_same_friction(target, rig.friction, "rig")


def _require_same_units(own: Units, other: Units, where: str) -> None:
    for key in ("length", "force", "stress"):
        if getattr(own, key) != getattr(other, key):
            raise CaseError(
                f"{where}: units.{key}: expected {getattr(own, key)!r} as in the component, found "
                f"{getattr(other, key)!r}"
            )


def _require_same_friction(target: Target, friction: float, where: str) -> None:
    if abs(friction / target.friction - 1) > SAME:
        raise ModelError(
            f"{where}: friction: expected {target.friction:g} as in the component, found "
            f"{friction:g}: with the same K_N and range of K_T the slip zones would differ"
        )


def _unchecked(rig: Rig) -> tuple[str, ...]:
    """Bounds of the rig that a shape of pad has nothing to compare with."""
    if rig.specimen.yield_stress is None or "wedge" not in rig.pad.shapes:
        return ()
    return (
        "the pressure of a wedge is infinite at its tip, whatever the load: specimen.yield_stress "
        "is no bound for wedges",
    )


def _notes(target: Target, factors: Factors) -> tuple[str, ...]:
    """Differences from the component although the factors are the same."""
    warnings = tuple(group.line for group in grouped(target.warnings))
    normal = target.friction * target.k_i_range
    if factors.k_i_range > 0 or normal <= NORMAL_COUNTS * target.k_t_range:
        return warnings
    scale = target.friction * target.k_n
    lengths = (target.k_t_range + normal) / scale, max(target.k_t_range - normal, 0.0) / scale
    return (
        *warnings,
        f"the normal force of the tests is constant, but f ΔK_I of the component is "
        f"{normal / target.k_t_range:.0%} of ΔK_T: slip zones become "
        f"{target.k_t_range / scale:.3g} in place of {lengths[0]:.3g} and {lengths[1]:.3g}; "
        "forces.normal_amplitude lets the tests match K_I too",
    )
