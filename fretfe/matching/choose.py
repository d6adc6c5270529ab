# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests that a rig can do, along the families of pads that have the factors of an edge.

For a shape K_N and the ranges leave families of one parameter: the radius of a cylinder, the flat
of a pad with rounded ends for each of their radii, the angle of a wedge. Along each, every bound of
the rig leaves an interval; a family is as long as what all of them leave.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import brentq

from fretfe._typing import Array
from fretfe.analytic.profiles import FIRST_YIELD, FlatRounded, Hertz, Profile, Wedge
from fretfe.errors import ModelError
from fretfe.matching.pads import Factors, PadTest, pad_test
from fretfe.matching.rig import Rig, Shape
from fretfe.matching.spreads import number_spreads, relative_bars
from fretfe.matching.target import Target

# Radii of rounded ends, and members of a family, that are looked at, and choices that are listed.
RADII = 10
MEMBERS = 9
LISTED = 5
# Tests along a family that are tried first with a bulk stress.
SAMPLES = 40
# Difference of misfits that is none.
AS_GOOD = 0.01
# Half-width of a contact over that of a body up to which there is a body around it.
WIDEST = 0.5
# Margin that stands for values that are infinite or not known, over the limit.
FAR = 1e3
# Bounds that are equal are met to this, relative.
EQUAL = 1e-9


@dataclass(frozen=True)
class Bound:
    """A quantity of a test and what the rig allows.

    Attributes:
        name: in words.
        value: of a test.
        low, high: smallest and largest.
    """

    name: str
    value: Callable[[PadTest], float]
    low: float
    high: float

    def holds(self, test: PadTest) -> bool:
        """True if a test is inside, or at one of the ends."""
        value = self.value(test)
        tolerance = EQUAL * abs(value) if math.isfinite(value) else 0.0
        return self.low - tolerance <= value <= self.high + tolerance


@dataclass(frozen=True)
class Choice:
    """A test that the rig can do.

    Attributes:
        shape: of the pad.
        test: pad and loads.
        binding: names of the bounds that end its family here; empty inside.
        misfit: largest difference of the pressure from that of the component within the length that
            counts, over the latter; NaN if that is not known.
        slip_misfit: longer slip zone to expect over the one to expect of the component, less 1; NaN
            if the pad would slide or nothing is known of the component's.
        spreads: error bars of the numbers of the test that come from those of the factors, with
            the same pad.
    """

    shape: Shape
    test: PadTest
    binding: tuple[str, ...]
    misfit: float
    slip_misfit: float
    spreads: Mapping[str, float] = field(default_factory=dict)

    @property
    def score(self) -> float:
        """The larger one of both misfits; infinite if one is not known."""
        larger = max(self.misfit, abs(self.slip_misfit))
        return larger if math.isfinite(self.misfit + self.slip_misfit) else math.inf


@dataclass(frozen=True)
class Choices:
    """Tests that the rig can do with a shape.

    Attributes:
        shape: of the pad.
        choices: along the family, the smallest first; empty if there is none.
        best: number of the one whose pressure and slip zone are nearest to those of the component;
            the middle one where that is not known.
        infeasible: why there is none, one text for each bound that forbids it.
    """

    shape: Shape
    choices: tuple[Choice, ...]
    best: int
    infeasible: tuple[str, ...]


@dataclass(frozen=True)
class _Family:
    """Pads of one parameter, from `low` to `high`; its key in the rig."""

    key: str
    low: float
    high: float
    make: Callable[[float], Profile]


def choose(target: Target, rig: Rig, factors: Factors, shape: Shape) -> Choices:
    """The tests with a pad of some shape that have the factors and that the rig can do."""
    search = _Search(target, rig, factors, shape, _bounds(rig, shape))
    found, problems = search.along(_families(rig, shape))
    if not found:
        return Choices(shape, (), 0, min(problems, key=len))
    best = min(found, key=lambda each: each.score)
    if shape == "flat_rounded" and math.isfinite(best.score):
        found = [*found, *search.along(_nearby(rig, best.test))[0]]
    return _listed(search, found)


@dataclass(frozen=True)
class _Search:
    """A search of all families of a shape for tests."""

    target: Target
    rig: Rig
    factors: Factors
    shape: Shape
    bounds: tuple[Bound, ...]

    def along(self, families: Iterable[_Family]) -> tuple[list[Choice], list[tuple[str, ...]]]:
        """Tests that the rig can do, and for each family without any the reasons."""
        found: list[Choice] = []
        problems: list[tuple[str, ...]] = []
        for family in families:
            try:
                low, high, binding, reasons = _allowed(family, self.factors, self.bounds)
            except ModelError as error:
                problems.append((f"the factors need {error}",))
                continue
            if reasons:
                problems.append(reasons)
                continue
            profiles = self._profiles(family, low, high)
            tests = [pad_test(profile, self.factors) for profile in profiles]
            kept = [n for n, test in enumerate(tests) if not _broken(self.bounds, test)]
            if not kept:
                problems.append(_broken(self.bounds, tests[len(tests) // 2]))
            last = len(tests) - 1
            for n in kept:
                names = [binding[0]] * (n == 0) + [binding[1]] * (n == last)
                found.append(self._choice(tests[n], tuple(dict.fromkeys(names))))
        return found, problems

    def _profiles(self, family: _Family, low: float, high: float) -> list[Profile]:
        sizes = np.geomspace(low, high, MEMBERS if high > low else 1)
        return [family.make(float(size)) for size in sizes]

    def with_spreads(self, choice: Choice) -> Choice:
        """A choice with its error bars."""
        bars = relative_bars(self.target)
        return replace(choice, spreads=number_spreads(choice.test, bars, self.rig))

    def _choice(self, test: PadTest, binding: tuple[str, ...]) -> Choice:
        # Both lengths to second order, under a shear force.
        expected = 1 + self.target.stiffening * test.slip[0] / 2
        return Choice(
            shape=self.shape,
            test=test,
            binding=binding,
            misfit=_misfit(self.target, self.rig, test),
            slip_misfit=1 / (1 + test.asymptote_error) / expected - 1,
        )


def _listed(search: _Search, found: list[Choice]) -> Choices:
    """A few choices from the narrowest to the widest, the best one among them."""
    found = sorted(found, key=lambda each: each.test.half_width)
    lowest = min(each.score for each in found)
    best = len(found) // 2
    if math.isfinite(lowest):
        # The narrowest of those that are as good: it sees least of the size of the bodies.
        best = next(n for n, each in enumerate(found) if each.score <= lowest + AS_GOOD)
    spread = np.linspace(0, len(found) - 1, min(LISTED, len(found))).round().astype(int)
    places = sorted({*spread.tolist(), best})
    listed = tuple(search.with_spreads(found[n]) for n in places)
    return Choices(search.shape, listed, places.index(best), ())


def _families(rig: Rig, shape: Shape) -> Iterator[_Family]:
    pad, e_star = rig.pad, rig.e_star
    if shape == "cylinder" and pad.radius:
        yield _Family("pad.radius", *pad.radius, lambda size: Hertz(size, e_star))
    if shape == "wedge" and pad.angle:
        yield _Family(
            "pad.angle", *pad.angle, lambda size: Wedge(math.tan(math.radians(size)), e_star)
        )
    if shape == "flat_rounded" and pad.radius and pad.flat_half_width:
        low, high = pad.radius
        for radius in np.geomspace(low, high, RADII if high > low else 1).tolist():
            yield _Family("pad.flat_half_width", *pad.flat_half_width, _flat(radius, e_star))


def _nearby(rig: Rig, test: PadTest) -> Iterator[_Family]:
    """Families of rounded ends with radii next to that of a test."""
    low, high = rig.pad.radius or (1.0, 1.0)
    step = (high / low) ** (1 / (RADII - 1))
    radius = getattr(test.profile, "radius", low)
    ends = max(low, radius / step), min(high, radius * step)
    for near in np.geomspace(*ends, RADII if high > low else 0).tolist():
        flat = rig.pad.flat_half_width or (1.0, 1.0)
        yield _Family("pad.flat_half_width", *flat, _flat(near, rig.e_star))


def _flat(radius: float, e_star: float) -> Callable[[float], Profile]:
    return lambda size: FlatRounded(size, radius, e_star)


def _bounds(rig: Rig, shape: Shape) -> tuple[Bound, ...]:
    forces, strength = rig.forces, rig.specimen.yield_stress
    widest = WIDEST * min(rig.pad.half_width, rig.specimen.half_width)
    deepest = WIDEST * min(rig.pad.height, rig.specimen.thickness)
    bounds = [
        Bound("smallest normal force", lambda test: test.normal_force - test.normal_amplitude,
              forces.normal[0], math.inf),
        Bound("largest normal force", lambda test: test.normal_force + test.normal_amplitude,
              0.0, forces.normal[1]),
        Bound("amplitude of the shear force", lambda test: abs(test.shear_amplitude),
              *forces.shear),
        Bound("Q/(f P), which is sliding at 1", lambda test: test.shear_ratio, 0.0, 1.0),
        Bound("half-width of the contact, for the half-widths of the bodies",
              lambda test: test.widest, 0.0, widest),
        Bound("half-width of the contact, for the height of the pad and the thickness",
              lambda test: test.widest, 0.0, deepest),
    ]  # fmt: skip
    if forces.normal_amplitude is not None:
        low, high = forces.normal_amplitude
        name = "amplitude of the normal force"
        bounds.append(Bound(name, lambda test: test.normal_amplitude, low, high))
    # The pressure of a wedge is infinite at its tip: there is no limit that it could keep.
    if strength is not None and shape != "wedge":
        name = "largest pressure, by the yield stress"
        bounds.append(Bound(name, lambda test: test.peak_pressure, 0.0, FIRST_YIELD * strength))
    if shape == "flat_rounded":
        # The rounded ends must reach the sides of a pad wide enough for the contact.
        bounds.append(Bound("contact beyond the flat over the radius",
                            _shoulder, 0.0, 0.5))  # fmt: skip
    return tuple(bounds)


def _shoulder(test: PadTest) -> float:
    return test.governing_length / getattr(test.profile, "radius", math.inf)


def _allowed(
    family: _Family, factors: Factors, bounds: tuple[Bound, ...]
) -> tuple[float, float, tuple[str, str], tuple[str, ...]]:
    """The interval of a family that all bounds leave.

    With a bulk stress Q rises and falls along a family: then to both sides of a test inside.
    """
    if factors.bulk_range == 0:
        return _interval(family, factors, bounds)
    sizes = np.geomspace(family.low, family.high, SAMPLES).tolist()
    inside = [size for size in sizes if not _broken(bounds, pad_test(family.make(size), factors))]
    if not inside:
        return _interval(family, factors, bounds)
    middle = inside[len(inside) // 2]
    low, _, first, _ = _interval(replace(family, high=middle), factors, bounds)
    _, high, last, _ = _interval(replace(family, low=middle), factors, bounds)
    return low, high, (first[0], last[1]), ()


def _interval(
    family: _Family, factors: Factors, bounds: tuple[Bound, ...]
) -> tuple[float, float, tuple[str, str], tuple[str, ...]]:
    """The part of a family that all bounds leave: ends, bounds that bind there, or reasons."""
    ends = (pad_test(family.make(family.low), factors), pad_test(family.make(family.high), factors))
    low, high, binding = family.low, family.high, [family.key, family.key]
    reasons = []
    for bound in bounds:
        for limit, sign in ((bound.low, 1.0), (bound.high, -1.0)):
            margins = [_margin(bound, limit, sign, test) for test in ends]
            if max(margins) < 0:
                reasons.append(_outside(bound, limit, sign, ends))
            elif min(margins) < 0:
                end = _crossing(family, factors, bound, limit, sign)
                if margins[0] < 0 and end > low:
                    low, binding[0] = end, bound.name
                if margins[1] < 0 and end < high:
                    high, binding[1] = end, bound.name
    if not reasons and low > high * (1 + EQUAL):
        reasons.append(f"{binding[0]} and {binding[1]} exclude each other")
    return low, max(low, high), (binding[0], binding[1]), tuple(reasons)


def _margin(bound: Bound, limit: float, sign: float, test: PadTest) -> float:
    """Margin of a test inside a limit; an unknown value is outside of all."""
    value = bound.value(test)
    if math.isnan(value):
        return -math.inf
    distance = sign * (value - limit)
    return 0.0 if abs(distance) <= EQUAL * abs(limit) else distance


def _crossing(family: _Family, factors: Factors, bound: Bound, limit: float, sign: float) -> float:
    """The parameter at which a family reaches a limit that only one of its ends is inside of."""

    def inside(size: float) -> float:
        test = pad_test(family.make(math.exp(size)), factors)
        # Unknown or infinite values are far outside.
        return max(_margin(bound, limit, sign, test), -FAR * max(limit, 1.0))

    ends = math.log(family.low), math.log(family.high)
    margins = [inside(end) for end in ends]
    if min(margins) >= 0 or max(margins) <= 0:
        # One end meets the limit, but for the round-off of logarithms.
        return family.low if margins[0] > margins[1] else family.high
    return math.exp(brentq(inside, *ends, xtol=1e-13, rtol=1e-13))


def _outside(bound: Bound, limit: float, sign: float, ends: tuple[PadTest, PadTest]) -> str:
    values = sorted(bound.value(test) for test in ends)
    allowed = f"{'at least' if sign > 0 else 'at most'} {limit:.4g}"
    needed = " to ".join(dict.fromkeys(f"{value:.4g}" for value in values))
    if any(math.isnan(value) for value in values):
        return f"{bound.name}: no value gives the range of K_T with this bulk stress"
    return f"{bound.name}: the rig allows {allowed}, the factors need {needed}"


def _broken(bounds: tuple[Bound, ...], test: PadTest) -> tuple[str, ...]:
    return tuple(
        f"{bound.name}: the rig allows {bound.low:.4g} to {bound.high:.4g}, the factors need "
        f"{bound.value(test):.4g}"
        for bound in bounds
        if not bound.holds(test)
    )


def length_that_counts(target: Target, rig: Rig) -> float:
    """The process zone, and two slip zones at least."""
    return max(rig.process_zone or 0.0, 2 * target.longest_slip)


def pressure_of(test: PadTest, s: Array) -> Array:
    """(m,) pressure of a test over the distance from its left edge, at the mean load."""
    a = test.half_width
    return np.asarray(test.profile.pressure(a - np.asarray(s), a))


def _misfit(target: Target, rig: Rig, test: PadTest) -> float:
    if target.profile is None:
        return math.nan
    s, pressure = target.profile.s, target.profile.pressure
    inside = s <= length_that_counts(target, rig)
    if not inside.any():
        return math.nan
    difference = np.abs(pressure_of(test, s[inside]) - pressure[inside])
    return float((difference / pressure[inside]).max())
