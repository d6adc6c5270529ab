# SPDX-License-Identifier: LGPL-3.0-or-later
"""The life of laboratory tests over their edge factors, by maximum likelihood.

Run-outs are censored: the logarithm of the life of a test is taken as normal about a plane,

    log10 N = c0 + c1 log10 ΔK_T + c2 log10 K_N + s ε,

a Basquin line whose height depends on K_N by a power. A failure has the density of its life, a
run-out the probability of a longer one (censoring of type I: Meeker and Escobar, Statistical
Methods for Reliability Data, chapter 17). Where all tests have the same K_N, c2 is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize
from scipy.stats import chi2, norm
from scipy.stats import t as student

from fretfe._typing import Array, Bools

# Failures beyond the number of coefficients that a scatter is taken from.
SPARE = 4
# K_N (or ΔK_T) that vary by less than this factor are the same.
SAME = 1.02
# Condition number of the logarithms, scaled, from which on their effects cannot be told apart.
WORST = 1e3
# Coverage of intervals, two-sided.
COVERAGE = 0.95


@dataclass(frozen=True)
class Survival:
    """Probability that a part with some factors lives for longer than some cycles.

    Attributes:
        life: these cycles.
        part: of one part more, by scatter and error of the fit; NaN where unknown.
        low, high: ends of an interval that holds the share of all such parts with 95 %.
        reason: why it is unknown; empty if it is known.
        tests, lasted: of parts that no fit describes, how many tests count, and how many of them
            lasted so long: `low` is by these alone.
    """

    life: float
    part: float = np.nan
    low: float = np.nan
    high: float = np.nan
    reason: str = ""
    tests: int = 0
    lasted: int = 0


@dataclass(frozen=True)
class LifeFit:
    """A plane fitted to logarithms.

    Attributes:
        coefficients: (3,) c0, c1, c2; c2 is 0 if K_N does not vary.
        scatter: s, standard deviation of log10 N, with n - k in place of n for k coefficients.
        covariance: (3, 3) of the coefficients.
        failures, runouts: numbers of tests.
        freedom: failures less coefficients.
        tested: smallest and largest K_N of the tests.
    """

    coefficients: Array
    scatter: float
    covariance: Array
    failures: int
    runouts: int
    freedom: int
    tested: tuple[float, float]

    @property
    def quantile(self) -> float:
        """Half the width of a 95 % interval over the standard deviation, by Student."""
        return float(student.ppf((1 + COVERAGE) / 2, self.freedom))

    def strength(self, k_n: float | Array, life: float) -> float | Array:
        """The ΔK_T at which half of all specimens reach a life at some K_N."""
        c0, c1, c2 = self.coefficients
        log = (np.log10(life) - c0 - c2 * np.log10(k_n)) / c1
        return float(10**log) if np.ndim(k_n) == 0 else np.asarray(10**log)

    def variances(self, k_n: float, life: float) -> tuple[float, float]:
        """Variances of the log10 of the strength at a K_N: of the fit, and of a single specimen."""
        c0, c1, c2 = self.coefficients
        log = (np.log10(life) - c0 - c2 * np.log10(k_n)) / c1
        gradient = -np.array([1.0, log, np.log10(k_n)]) / c1
        return float(gradient @ self.covariance @ gradient), float((self.scatter / c1) ** 2)

    def survival(self, k_n: float, k_t_range: float, life: float, bar: float) -> Survival:
        """Probability of more cycles than a life at a K_N and ΔK_T, which the tests should cover.

        The distance of the mean from the life over the scatter is that of the fit times s'/s, whose
        square is χ² over its freedom, and a normal error of the mean: exact without run-outs (the
        interval is that of the noncentral t-distribution: Owen, J. Am. Stat. Assoc. 63, 1968).

        Args:
            k_n: factor of the part.
            k_t_range: its range.
            life: cycles.
            bar: error bar of log10 of the life by those of both factors, of 95 %.
        """
        at = np.array([1.0, np.log10(k_t_range), np.log10(k_n)])
        # Beyond 30 all of these are 0 or 1.
        distance = np.clip((at @ self.coefficients - np.log10(life)) / self.scatter, -30, 30)
        variance = at @ self.covariance @ at + (bar / norm.ppf((1 + COVERAGE) / 2)) ** 2
        error = np.sqrt(variance) / self.scatter
        scatters = np.sqrt(chi2.ppf((np.arange(2000) + 0.5) / 2000, self.freedom) / self.freedom)

        def below(place: float, share: float) -> float:
            return float(norm.cdf((place - distance * scatters) / error).mean()) - share

        far = 3 * abs(distance) + 10 * error
        low, high = (
            float(norm.cdf(brentq(below, -far, far, args=(share / 2,))))
            for share in (1 - COVERAGE, 1 + COVERAGE)
        )
        part = float(student.cdf(distance / np.hypot(1, error), self.freedom))
        return Survival(life, part, low, high)


def is_one(k_n: Array) -> bool:
    """True if values of K_N (n,) are one within `SAME`."""
    return bool(k_n.max() <= SAME * k_n.min())


def fit_life(k_n: Array, k_t_range: Array, life: Array, runout: Bools) -> LifeFit | str:
    """Fit the lives of tests (n,).

    Returns:
        The fit, or why there is none, in words.
    """
    failures = int(np.count_nonzero(~runout))
    count = 2 if is_one(k_n) else 3
    if failures < count + SPARE:
        return f"{count + SPARE} failures are needed for {count} coefficients, found {failures}"
    if k_t_range[~runout].max() < SAME * k_t_range[~runout].min():
        return "all failures have the same ΔK_T"
    logs = np.column_stack([np.ones(len(life)), np.log10(k_t_range), np.log10(k_n)])[:, :count]
    centre = logs.mean(axis=0) * (np.arange(count) > 0)
    design = logs - centre
    if np.linalg.cond(design[~runout] / np.linalg.norm(design[~runout], axis=0)) > WORST:
        return "K_N and ΔK_T of the failures vary together: their effects cannot be told apart"
    found = _most_likely(design, np.log10(life), runout)
    if isinstance(found, str):
        return found
    estimate, scatter, covariance = found
    widened = failures / (failures - count)
    # Back from centred logarithms: the plane goes through the same points.
    full = np.eye(3, count)
    full[0] -= centre
    coefficients = full @ estimate
    if coefficients[1] >= 0:
        return f"lives do not fall with ΔK_T: c1 = {coefficients[1]:.3g}"
    return LifeFit(
        coefficients=coefficients,
        scatter=scatter * np.sqrt(widened),
        covariance=full @ covariance @ full.T * widened,
        failures=failures,
        runouts=int(np.count_nonzero(runout)),
        freedom=failures - count,
        tested=(float(k_n.min()), float(k_n.max())),
    )


def _most_likely(design: Array, log: Array, runout: Bools) -> tuple[Array, float, Array] | str:
    """Coefficients (k,), scatter and covariance (k, k) of the largest likelihood, or why not."""
    start, *_ = np.linalg.lstsq(design, log, rcond=None)
    spread = float(np.std(log - design @ start)) or 1e-3
    # A step that goes too far overflows, and is taken back.
    with np.errstate(over="ignore", invalid="ignore"):
        found = minimize(
            _loss, np.append(start, np.log(spread)), (design, log, runout), jac=True, method="BFGS",
            options={"gtol": 1e-8},
        )  # fmt: skip
    size = np.abs(found.jac).max()
    if not np.isfinite(found.fun) or not size <= 1e-4:
        return f"the likelihood has no maximum that could be found: its slope is still {size:.2g}"
    estimate, scatter = found.x[:-1], float(np.exp(found.x[-1]))
    if scatter < 1e-6:
        return "the tests have no scatter"
    covariance = np.linalg.inv(_curvature(found.x, design, log, runout))[:-1, :-1]
    if not (np.diag(covariance) > 0).all():
        return "the likelihood has no maximum: too many run-outs"
    return estimate, scatter, covariance


def _loss(unknown: Array, design: Array, log: Array, runout: Bools) -> tuple[float, Array]:
    """Negative logarithm of the likelihood and its gradient by coefficients and log s."""
    scatter = np.exp(unknown[-1])
    z = (log - design @ unknown[:-1]) / scatter
    loss = np.where(runout, -norm.logsf(z), -norm.logpdf(z) + unknown[-1]).sum()
    # Of -log(1 - Φ) the slope is the hazard of the normal distribution.
    slope = np.where(runout, np.exp(norm.logpdf(z) - norm.logsf(z)), z)
    by_scatter = np.where(runout, -slope * z, 1 - z**2).sum()
    return float(loss), np.append(-(slope @ design) / scatter, by_scatter)


def _curvature(unknown: Array, design: Array, log: Array, runout: Bools) -> Array:
    """(k + 1, k + 1) second derivatives of the loss, by central differences of its gradient."""
    steps = 1e-5 * np.eye(len(unknown))
    rows = [
        (
            _loss(unknown + step, design, log, runout)[1]
            - _loss(unknown - step, design, log, runout)[1]
        )
        / 2e-5
        for step in steps
    ]
    matrix = np.array(rows)
    return np.asarray((matrix + matrix.T) / 2)
