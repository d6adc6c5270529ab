# SPDX-License-Identifier: LGPL-3.0-or-later
"""Margins of component edges, points in the plane of K_N and ΔK_T, against tested strength."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import beta

from fretfe._typing import Array, Bools
from fretfe.case import AnyBody, isotropic
from fretfe.errors import CaseError
from fretfe.evaluate.contacts import Contact, Station
from fretfe.evaluate.withheld import withheld
from fretfe.reason import Kind
from fretfe.report.texts import number, rounded
from fretfe.results.end_answers import beside_end
from fretfe.results.model import Result
from fretfe.strength.fit import COVERAGE, SAME, LifeFit, Survival, fit_life, is_one
from fretfe.strength.lives import StrengthTests, read_tests

# f ΔK_I over ΔK_T above which the normal load varies, and turning above which (K_T, K_S) does.
SMALL = 0.05
# Tests agree with a contact if friction and Young's modulus do to these fractions, and Poisson's
# ratio to this difference. Friction of a test is hardly known better, nor K_N of a component.
CLOSE = 0.1
YOUNG = 0.05
POISSON = 0.02


@dataclass(frozen=True)
class ComponentEdge:
    """An edge of a plane contact, or a station of a front of solids.

    Attributes:
        result: folder of the result.
        contact: its name.
        edge: left or right; of solids the front.
        station: number along the front; 0 in the plane.
        k_n, k_n_spread: K_N at the end of the evaluated cycle, and error bar; NaN where not known.
        k_t_range, k_t_range_spread: range of K_T over the evaluated cycle, of solids that of
            (K_T, K_S) along its main direction, and error bar; NaN where not known.
        friction: coefficient of the contact.
        bodies: of the contact.
        obstacles: reasons why its strength cannot be judged; none if it can.
        remarks: what tests at constant P and of equal cycles do not cover.
    """

    result: str
    contact: str
    edge: str
    station: int
    k_n: float
    k_n_spread: float
    k_t_range: float
    k_t_range_spread: float
    friction: float
    bodies: tuple[AnyBody, ...]
    obstacles: tuple[str, ...]
    remarks: tuple[str, ...]

    @property
    def name(self) -> str:
        """All of it, in words."""
        return " ".join((self.result, self.contact, self.edge))


def component_edges(results: Sequence[Result]) -> tuple[ComponentEdge, ...]:
    """All edges of results, those of solids without ends of fronts.

    Raises:
        CaseError: if the units of the results differ.
    """
    units = {result.case.units for result in results}
    if len(units) > 1:
        listed = "; ".join(", ".join(each.model_dump().values()) for each in units)
        raise CaseError(f"expected results in the same units, found {listed}")
    labels = result_labels(results)
    return tuple(
        edge
        for result, label in zip(results, labels, strict=True)
        for edge in _edges(result, label)
    )


def result_labels(results: Sequence[Result]) -> list[str]:
    """Names of folders, or paths where names are the same."""
    folders = [each.directory for each in results]
    names = [each.directory.name if each.directory else each.case.title for each in results]
    return [
        str(folder) if folder and names.count(name) > 1 else name
        for folder, name in zip(folders, names, strict=True)
    ]


def _edges(result: Result, label: str) -> Iterator[ComponentEdge]:
    for contact in result.contacts:
        for front in contact.fronts:
            for station in front.defined:
                remarks = list(_remarks(result, contact, station))
                yield _edge(result, label, contact, station, remarks)


def _remarks(result: Result, contact: Contact, station: Station) -> Iterator[str]:
    for kind in (Kind.LAYER, Kind.FRICTION_VARIES):
        if any(each.kind is kind for each in contact.warnings):
            yield f"{kind.heading}, which tests without that do not cover"
    if station.cycles.irregular:
        yield (
            "the loads are irregular: judged is the range over the whole cycle, other counted "
            "cycles do no damage here"
        )
    if beside := beside_end(result, station):
        yield f"{beside}, which the tests have not"
    if station.turning > SMALL:
        yield f"(K_T, K_S) turns: the range across its direction is {station.turning:.0%}"


def _edge(
    result: Result, label: str, contact: Contact, edge: Station, remarks: list[str]
) -> ComponentEdge:
    if not contact.steady:
        remarks.append("the cycle is not steady")
    friction = edge.friction
    k_n, k_t_range = edge.reported_k_n, edge.reported_range
    if edge.oscillation:
        remarks.append(
            "unlike bodies: K_N and ΔK_T are those at a length, "
            f"{edge.reference_length:.3g} and a quarter of it, which tests of similar ones have not"
        )
    elif k_t_range > 0 and friction * edge.k_i_range > SMALL * k_t_range:
        share = friction * edge.k_i_range / k_t_range
        remarks.append(f"P varies: f ΔK_I is {share:.0%} of ΔK_T, which the tests do not cover")
    return ComponentEdge(
        result=label, contact=contact.name, edge=edge.front, station=edge.number,
        k_n=k_n, k_n_spread=edge.decisive_k_n[1],
        k_t_range=k_t_range, k_t_range_spread=float(edge.told_range[1]),
        friction=friction, bodies=_bodies(result, contact.pair),
        obstacles=tuple(_obstacles(result, edge)), remarks=tuple(remarks),
    )  # fmt: skip


def _bodies(result: Result, pair: str) -> tuple[AnyBody, ...]:
    """The two bodies of a contact."""
    named = next(each for each in result.solution.contacts if each.pair == pair)
    return result.case.bodies[named.body1], result.case.bodies[named.body2]


def _obstacles(result: Result, edge: Station) -> Iterator[str]:
    """Reasons of the run, which another one may not have."""
    if result.failure is not None:
        yield Kind.INCOMPLETE.seen
    if reason := withheld(edge, ranged=result.loads.cycle is not None):
        yield reason.text
    if result.loads.cycle is None:
        yield Kind.NO_CYCLE.seen
    elif edge.reported_range == 0:
        yield "ΔK_T is zero"


@dataclass(frozen=True)
class Margin:
    """Margin of an edge by tests; NaN where they do not, and then `reason` says why.

    Attributes:
        edge: the edge.
        tests: number of tests that agree with it in friction and material.
        fit: of these tests; None without.
        strength, strength_spread: ΔK_T at its K_N at which half of all specimens reach the life,
            and error bar, by the error of the fit and the error bar of K_N.
        margin: that over its ΔK_T.
        low, high: ends of an interval that is meant to hold the margin of a single part with 95 %:
            scatter of single specimens, error of the fit, error bars of K_N and ΔK_T of the edge.
        fit_share, scatter_share, edge_share: half of the width of the interval of log10 of the
            margin that each of these three would have alone.
        survival: probability that it reaches the life, with the bars of the edge in its interval;
            None without a margin.
        reason: all that is in the way of a margin, what is hardest to mend first; empty if there is
            one.
    """

    edge: ComponentEdge
    tests: int
    fit: LifeFit | None
    reason: str
    strength: float = math.nan
    strength_spread: float = math.nan
    margin: float = math.nan
    low: float = math.nan
    high: float = math.nan
    fit_share: float = math.nan
    scatter_share: float = math.nan
    edge_share: float = math.nan
    survival: Survival | None = None


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
    agreeing = _agreeing(tests, edge)
    chosen = agreeing & tests.inside
    count = int(np.count_nonzero(chosen))
    reasons = [*_not_tested(tests, agreeing, edge, life)]
    fit: LifeFit | str | None = None
    if count:
        key = chosen.tobytes()
        if key not in fits:
            fits[key] = fit_life(
                tests.k_n[chosen], tests.k_t_range[chosen], tests.life[chosen], tests.runout[chosen]
            )
        fit = fits[key]
    reasons += [fit] if isinstance(fit, str) else []
    reasons += edge.obstacles
    if isinstance(fit, LifeFit) and not reasons:
        reasons += _beyond(tests, chosen, fit, edge.k_n, life)
    if reasons or not isinstance(fit, LifeFit):
        known = fit if isinstance(fit, LifeFit) else None
        least = None if edge.obstacles else _counted(tests, chosen, edge, life)
        return Margin(edge, count, known, "; ".join(reasons), survival=least)
    judged = _judged(edge, count, fit, life)
    bar = judged.edge_share * abs(fit.coefficients[1])
    return replace(judged, survival=_survival(tests, chosen, fit, edge, life, bar))


def _agreeing(tests: StrengthTests, edge: ComponentEdge) -> Bools:
    """(n,) tests with the friction and the material of an edge."""
    agree = (
        np.abs(tests.friction / edge.friction - 1) <= CLOSE if edge.friction else tests.friction < 0
    )
    for body in filter(None, map(isotropic, edge.bodies)):
        agree &= np.abs(tests.young / body.young - 1) <= YOUNG
        agree &= np.abs(tests.poisson - body.poisson) <= POISSON
    return np.asarray(agree)


def _disagreement(tests: StrengthTests, edge: ComponentEdge) -> str:
    bodies = list(filter(None, map(isotropic, edge.bodies)))
    young = " and ".join(dict.fromkeys(rounded(body.young, 4) for body in bodies))
    poisson = " and ".join(dict.fromkeys(rounded(body.poisson, 4) for body in bodies))
    return (
        f"no test has its friction and material, f = {edge.friction:g}, E = {young}, "
        f"ν = {poisson}: "
        f"the tests have f = {_span(tests.friction)}, E = {_span(tests.young)}, ν = "
        f"{_span(tests.poisson)}"
    )


def _not_tested(
    tests: StrengthTests, agreeing: Bools, edge: ComponentEdge, life: float
) -> Iterator[str]:
    """Reasons that no more tests of the same kind would mend."""
    if not all(isotropic(each) for each in edge.bodies):
        yield "a body is a crystal, and tests tell E and ν only"
    chosen = agreeing & tests.inside
    if not agreeing.any():
        yield _disagreement(tests, edge)
    elif not chosen.any():
        yield "all tests with its friction and material lie outside the edge formulas"
    else:
        tested = tests.k_n[chosen]
        same = SAME if is_one(tested) else 1.0
        if not (math.isnan(edge.k_n) or tested.min() / same <= edge.k_n <= tested.max() * same):
            yield f"K_N = {rounded(edge.k_n, 4)} is outside of the tested K_N, {_span(tested)}"
        # a life is tested from the first failure to the last end
        shortest = tests.life[chosen & ~tests.runout].min(initial=tests.life[chosen].max())
        if not shortest <= life <= tests.life[chosen].max():
            lives = f"{number(shortest)} to {number(tests.life[chosen].max())}"
            yield f"{number(life, 6)} cycles are outside of the tested lives, {lives}"


def _beyond(
    tests: StrengthTests, chosen: Bools, fit: LifeFit, k_n: float, life: float
) -> Iterator[str]:
    """Reason why a strength would be extrapolated; none if it is not."""
    strength, ranges = float(fit.strength(k_n, life)), tests.k_t_range[chosen]
    if not ranges.min() <= strength <= ranges.max():
        side = "above" if strength > ranges.max() else "below"
        yield f"the strength would be {side} all tested ΔK_T, {_span(ranges)}"
    elif fit.coefficients[2] and _is_outside(
        np.log10([ranges, tests.k_n[chosen]]), np.log10([strength, k_n])
    ):
        yield "K_N and the strength there lie outside of the cloud of tests"


def _is_outside(tests: Array, place: Array) -> bool:
    """True if a place (2,) is outside of the ellipsoid around all tests (2, n).

    By its leverage x (X'X)^-1 x', which is larger than that of any test: hidden extrapolation
    (Montgomery, Peck and Vining, Introduction to Linear Regression Analysis, section 3.8).
    """
    inverse = np.linalg.inv(np.cov(tests))
    deviations = np.column_stack([place, tests]) - tests.mean(axis=1)[:, None]
    distances = np.einsum("in,ij,jn->n", deviations, inverse, deviations)
    return bool(distances[0] > distances[1:].max())


def _survival(
    tests: StrengthTests, chosen: Bools, fit: LifeFit, edge: ComponentEdge, life: float, bar: float
) -> Survival:
    """Probability that an edge reaches a life; bar of log10 of its life."""
    ranges, place = tests.k_t_range[chosen], np.log10([edge.k_t_range, edge.k_n])
    beyond = not ranges.min() <= edge.k_t_range <= ranges.max()
    if fit.coefficients[2] and not beyond:
        beyond = _is_outside(np.log10([ranges, tests.k_n[chosen]]), place)
    if not beyond:
        return fit.survival(edge.k_n, edge.k_t_range, life, bar)
    outside = Survival(life, reason="its K_N and ΔK_T lie outside of the cloud of tests")
    return _counted(tests, chosen, edge, life) or outside


def _counted(tests: StrengthTests, own: Bools, edge: ComponentEdge, life: float) -> Survival | None:
    """The least share by tests at its K_N; None if none of them lasted so long and was no milder.

    Those that lasted count at its ΔK_T, with its bar, or a larger one, those that failed at any.
    With K_N the tension at the edge grows, but so does the pressure that closes cracks. What ended
    before the life without failure tells nothing of it. The share is the lower end of Clopper and
    Pearson (Biometrika 26, 1934), one-sided: .05^(1/n) where all n lasted, with 95 % at least.
    """
    own = own & (np.abs(tests.k_n / edge.k_n - 1) <= CLOSE)
    harder = tests.k_t_range >= edge.k_t_range + edge.k_t_range_spread
    failed = int(np.count_nonzero(own & (tests.life < life) & ~tests.runout))
    lasted = int(np.count_nonzero(own & (tests.life >= life) & harder))
    if not lasted:
        return None
    low = float(beta.ppf(1 - COVERAGE, lasted, failed + 1))
    return Survival(life, low=low, high=1.0, tests=lasted + failed, lasted=lasted)


def survival_text(found: Survival) -> str:
    """The probability in words; its tails are those of the normal distribution."""
    life = number(found.life, 6)
    if found.reason:
        return f"the probability to survive {life} cycles is unknown: {found.reason}"
    part, low, high = map(_share, (found.part, found.low, found.high))
    if found.tests:
        failed = found.tests - found.lasted
        tests = f"{found.lasted} tests at such K_N and ΔK_T, or a larger one, did, {failed} failed"
        return f"at least {low} of parts survive {life} cycles (95 % sure): {tests}"
    return f"{part} of parts survive {life} cycles (95 % sure: {low} to {high})"


def _share(value: float) -> str:
    if not 0.001 <= value <= 0.999:
        return "over 99.9 %" if value > 0.5 else "under 0.1 %"
    return f"{100 * value:.3g} %"


def _judged(edge: ComponentEdge, count: int, fit: LifeFit, life: float) -> Margin:
    strength = float(fit.strength(edge.k_n, life))
    of_fit, of_scatter = (fit.quantile * math.sqrt(v) for v in fit.variances(edge.k_n, life))
    slope = fit.coefficients[2] / fit.coefficients[1]
    # The strength goes with K_N to the power of the slope.
    of_k_n = slope * edge.k_n_spread / edge.k_n / math.log(10)
    of_edge = math.hypot(edge.k_t_range_spread / edge.k_t_range / math.log(10), of_k_n)
    half = math.hypot(of_fit, of_scatter, of_edge)
    margin = strength / edge.k_t_range
    return Margin(
        edge, count, fit, "",
        strength=strength, strength_spread=math.log(10) * math.hypot(of_fit, of_k_n) * strength,
        margin=margin, low=margin / 10**half, high=margin * 10**half,
        fit_share=of_fit, scatter_share=of_scatter, edge_share=of_edge,
    )  # fmt: skip


def _span(values: Array) -> str:
    low, high = values.min(), values.max()
    return rounded(low, 4) if low == high else f"{rounded(low, 4)} to {rounded(high, 4)}"
