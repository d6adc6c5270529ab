# SPDX-License-Identifier: LGPL-3.0-or-later
"""Margins of component edges against the strength that tests have shown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.errors import CaseError
from fretfe.results.model import Result
from fretfe.strength.component import ComponentEdge, component_edges, result_labels
from fretfe.strength.fit import SAME, LifeFit, fit_life
from fretfe.strength.tests_file import StrengthTests, read_tests

# Tests agree with a contact if friction and Young's modulus do to these fractions, and Poisson's
# ratio to this difference. Friction of a test is hardly known better.
FRICTION, YOUNG, POISSON = 0.1, 0.05, 0.02


@dataclass(frozen=True)
class Margin:
    """What tests say of an edge; NaN where they do not, and then `reason` says why.

    Attributes:
        edge: the edge.
        tests: number of tests that agree with it in friction and material.
        fit: of these tests; None without.
        strength: ΔK_T at its K_N at which half of all specimens reach the life.
        margin: that over its ΔK_T.
        low, high: ends of an interval that is meant to hold the margin of a single part with 95 %:
            scatter of single specimens, error of the fit, error bars of K_N and ΔK_T of the edge.
        fit_share, scatter_share, edge_share: half of the width of the interval of log10 of the
            margin that each of these three would have alone.
        reason: why there is no margin; empty if there is one.
    """

    edge: ComponentEdge
    tests: int
    fit: LifeFit | None
    reason: str
    strength: float = math.nan
    margin: float = math.nan
    low: float = math.nan
    high: float = math.nan
    fit_share: float = math.nan
    scatter_share: float = math.nan
    edge_share: float = math.nan


@dataclass(frozen=True)
class StrengthMap:
    """Tests and component edges.

    Attributes:
        life: for which margins are given, in cycles.
        tests: all of them.
        margins: one for each edge, in the order of the results.
        without_edges: results that have none, such as solids whose fronts are not known.
    """

    life: float
    tests: StrengthTests
    margins: tuple[Margin, ...]
    without_edges: tuple[str, ...]

    @property
    def fits(self) -> tuple[LifeFit, ...]:
        """Each fit that a margin comes from, once."""
        found = {id(each.fit): each.fit for each in self.margins if each.fit is not None}
        return tuple(found.values())


def strength_map(tests: Path | str, results: Sequence[Result], life: float) -> StrengthMap:
    """Judge all edges of results by tests.

    Args:
        tests: CSV file.
        results: of components; their units are those of the tests.
        life: cycles that the component has to reach; > 0.

    Raises:
        CaseError: if the file is not as expected, units differ, or there are no edges.
    """
    if not (math.isfinite(life) and life > 0):
        raise CaseError(f"life: expected a finite number of cycles > 0, found {life:g}")
    edges = component_edges(results)
    if not edges:
        raise CaseError("expected results with contact edges, found none")
    read = read_tests(Path(tests), results[0].case.units)
    fits: dict[bytes, LifeFit | str] = {}
    found = {edge.result for edge in edges}
    return StrengthMap(
        life=life,
        tests=read,
        margins=tuple(_margin(read, edge, life, fits) for edge in edges),
        without_edges=tuple(label for label in result_labels(results) if label not in found),
    )


def _margin(
    tests: StrengthTests, edge: ComponentEdge, life: float, fits: dict[bytes, LifeFit | str]
) -> Margin:
    chosen = _agreeing(tests, edge)
    count = int(np.count_nonzero(chosen))
    if edge.obstacle:
        return Margin(edge, count, None, edge.obstacle)
    if not count:
        return Margin(edge, 0, None, _disagreement(tests, edge))
    key = chosen.tobytes()
    if key not in fits:
        fits[key] = fit_life(
            tests.k_n[chosen], tests.k_t_range[chosen], tests.life[chosen], tests.runout[chosen]
        )
    fit = fits[key]
    if isinstance(fit, str):
        return Margin(edge, count, None, fit)
    if reason := _beyond(tests, chosen, fit, edge.k_n, life):
        return Margin(edge, count, fit, reason)
    return _judged(edge, count, fit, life)


def _agreeing(tests: StrengthTests, edge: ComponentEdge) -> Bools:
    """(n,) tests with the friction and the material of an edge."""
    agree = (
        np.abs(tests.friction / edge.friction - 1) <= FRICTION
        if edge.friction
        else tests.friction < 0
    )
    for body in edge.bodies:
        agree &= np.abs(tests.young / body.young - 1) <= YOUNG
        agree &= np.abs(tests.poisson - body.poisson) <= POISSON
    return np.asarray(agree)


def _disagreement(tests: StrengthTests, edge: ComponentEdge) -> str:
    young = " and ".join(dict.fromkeys(f"{body.young:g}" for body in edge.bodies))
    poisson = " and ".join(dict.fromkeys(f"{body.poisson:g}" for body in edge.bodies))
    return (
        f"no test has its friction and material, f = {edge.friction:g}, E = {young}, "
        f"ν = {poisson}: "
        f"the tests have f = {_span(tests.friction)}, E = {_span(tests.young)}, ν = "
        f"{_span(tests.poisson)}"
    )


def _beyond(tests: StrengthTests, chosen: Bools, fit: LifeFit, k_n: float, life: float) -> str:
    """Why a margin would be extrapolated; empty if it is not."""
    tested = tests.k_n[chosen]
    varied = fit.coefficients[2] != 0
    same = 1.0 if varied else SAME
    if not fit.tested[0] / same <= k_n <= fit.tested[1] * same:
        return f"K_N = {k_n:.4g} is outside of the tested K_N, {_span(tested)}"
    shortest = tests.life[chosen & ~tests.runout].min()
    longest = tests.life[chosen].max()
    if not shortest <= life <= longest:
        return f"{life:g} cycles are outside of the tested lives, {shortest:g} to {longest:g}"
    strength, ranges = float(fit.strength(k_n, life)), tests.k_t_range[chosen]
    if not ranges.min() <= strength <= ranges.max():
        side = "above" if strength > ranges.max() else "below"
        return f"the strength would be {side} all tested ΔK_T, {_span(ranges)}"
    if varied and _is_outside(np.log10([ranges, tested]), np.log10([strength, k_n])):
        return "K_N and the strength there lie outside of the cloud of tests"
    return ""


def _is_outside(tests: Array, place: Array) -> bool:
    """True if a place (2,) is outside of the ellipsoid around all tests (2, n).

    By its leverage x (X'X)^-1 x', which is larger than that of any test: hidden extrapolation
    (Montgomery, Peck and Vining, Introduction to Linear Regression Analysis, section 3.8).
    """
    inverse = np.linalg.inv(np.cov(tests))
    deviations = np.column_stack([place, tests]) - tests.mean(axis=1)[:, None]
    distances = np.einsum("in,ij,jn->n", deviations, inverse, deviations)
    return bool(distances[0] > distances[1:].max())


def _judged(edge: ComponentEdge, count: int, fit: LifeFit, life: float) -> Margin:
    strength = float(fit.strength(edge.k_n, life))
    of_fit, of_scatter = (fit.quantile * math.sqrt(v) for v in fit.variances(edge.k_n, life))
    slope = fit.coefficients[2] / fit.coefficients[1]
    of_edge = math.hypot(
        edge.k_t_range_spread / edge.k_t_range, slope * edge.k_n_spread / edge.k_n
    ) / math.log(10)
    half = math.hypot(of_fit, of_scatter, of_edge)
    margin = strength / edge.k_t_range
    return Margin(
        edge, count, fit, "",
        strength=strength, margin=margin, low=margin / 10**half, high=margin * 10**half,
        fit_share=of_fit, scatter_share=of_scatter, edge_share=of_edge,
    )  # fmt: skip


def _span(values: Array) -> str:
    low, high = values.min(), values.max()
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
