# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tractions of a component and of a test over each other, from the edge inward."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fretfe._typing import Array, Bools
from fretfe.errors import CaseError, ModelError
from fretfe.matching.target import Profile, Target, read_target
from fretfe.results.model import Result

TOLERANCES = (0.05, 0.10)
# Elements of the coarser mesh over which differences do not count: means around the nodes blunt the
# kink of the shear at the border of slip and stick.
NARROW = 2.0
# Distance of the largest pressure of a test over that of the component from which they differ.
FARTHER = 1.1


@dataclass(frozen=True)
class Reach:
    """Distance over which two tractions agree.

    Attributes:
        tolerance: largest relative difference.
        length: distance from the edge up to which no difference is larger.
        whole: whether that is all that was compared.
    """

    tolerance: float
    length: float
    whole: bool


@dataclass(frozen=True)
class Agreement:
    """A test beside the component.

    Attributes:
        name: of the test.
        target, test: factors and tractions of both.
        s: (m,) distances from the edge inward at which both are known.
        pressure, test_pressure: (m,) in the last states of the cycles.
        shear, test_shear: (m,) changes of q between the states of largest and smallest K_T.
        pressure_reach, shear_reach: for each tolerance how far they agree.
        remark: on where the pressures part; empty if they agree over the slip zone or farther.
    """

    name: str
    target: Target
    test: Target
    s: Array
    pressure: Array
    test_pressure: Array
    shear: Array
    test_shear: Array
    pressure_reach: tuple[Reach, ...]
    shear_reach: tuple[Reach, ...]
    remark: str


def compare_edges(target: Target, result: Result, name: str) -> Agreement:
    """Compare the tractions of a component's edge with those of the left edge of a test.

    Pressures are compared with the component's own, changes of q with f (p + p') of the component,
    by which q can change at most. The mean of q is left over from the first loading; a test that
    matches ranges does not match it.

    Args:
        target: edge or station of the component.
        result: of the test, with one contact.
        name: of the test.

    Raises:
        CaseError: if the test is of solids, or has several contacts.
        ModelError: if one of the two has no tractions, or the factors of the test are not known.
        OutputError: if the test is not complete.
    """
    if result.solid:
        raise CaseError(f"{name}: expected a test of plane bodies, found solids")
    if len(result.contacts) > 1:
        known = ", ".join(contact.name for contact in result.contacts)
        raise CaseError(f"{name}: expected a test with one contact, found {known}")
    contact = result.contacts[0].name if result.contacts else ""
    test = read_target(result, f"{contact}.left")
    own, other = _profile(target, "the component"), _profile(test, name)
    s = np.union1d(own.s, other.s)
    s = s[(s >= max(own.s[0], other.s[0])) & (s <= min(own.s[-1], other.s[-1]))]
    if not len(s):
        raise ModelError(f"{name}: expected edges that can be compared, found no common distances")
    pressure, test_pressure = (np.interp(s, one.s, one.pressure) for one in (own, other))
    shear, test_shear = (np.interp(s, one.s, one.shear_change) for one in (own, other))
    p_error = np.abs(test_pressure - pressure) / pressure
    q_error = np.abs(test_shear - shear) / np.interp(s, own.s, own.limit)
    size = np.maximum(*(np.interp(s, one.s, np.gradient(one.s)) for one in (own, other)))
    pressure_reach = tuple(_reach(s, p_error, size, each) for each in TOLERANCES)
    return Agreement(
        name=name,
        target=target,
        test=test,
        s=s,
        pressure=pressure,
        test_pressure=test_pressure,
        shear=shear,
        test_shear=test_shear,
        pressure_reach=pressure_reach,
        shear_reach=tuple(_reach(s, q_error, size, each) for each in TOLERANCES),
        remark=_remark(own, other, pressure_reach),
    )


def better(agreements: list[Agreement]) -> Agreement:
    """The test whose pressure agrees to 5 % the farthest, and of equal ones its shear."""
    return max(
        agreements, key=lambda each: (each.pressure_reach[0].length, each.shear_reach[0].length)
    )


def _profile(target: Target, name: str) -> Profile:
    if target.profile is None:
        raise ModelError(
            f"{name}, edge {target.name}: expected tractions through the cycle to compare, found "
            "none: the backend has none, they were not kept ([output] tractions), or there are too "
            "few nodes next to the edge"
        )
    return target.profile


def _reach(s: Array, error: Array, size: Array, tolerance: float) -> Reach:
    """Distance over which two fields agree, but for what is too narrow for both meshes."""
    beyond: Bools = ~(error <= tolerance)
    starts, ends = np.flatnonzero(np.diff(beyond, prepend=False, append=False)).reshape(-1, 2).T
    for start, end in zip(starts, ends, strict=True):
        last = min(end, len(s) - 1)
        if end == len(s) or s[last] - s[start] > NARROW * size[start]:
            # Between two nodes in proportion.
            before = max(start - 1, 0)
            part = (tolerance - error[before]) / (error[start] - error[before] or math.nan)
            length = s[before] + max(np.nan_to_num(part), 0.0) * (s[start] - s[before])
            return Reach(tolerance, float(length) if start else 0.0, False)
    return Reach(tolerance, float(s[-1]), True)


def _remark(own: Profile, other: Profile, reach: tuple[Reach, ...]) -> str:
    if reach[0].whole:
        return ""
    if other.peak > FARTHER * own.peak:
        return (
            f"its pressure keeps rising to {other.peak:.4g} from the edge, where the component's "
            f"falls from {own.peak:.4g} on"
        )
    if own.peak > FARTHER * other.peak:
        return (
            f"its pressure falls from {other.peak:.4g} from the edge on, where the component's "
            f"keeps rising to {own.peak:.4g}"
        )
    return ""
