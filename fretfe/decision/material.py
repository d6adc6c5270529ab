# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fatigue data of a material file in the units of results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.case import AnyBody, Units, isotropic
from fretfe.case.fatigue import Fatigue, GrowthTable, LifeTable, ThresholdTable
from fretfe.case.materials import read_material
from fretfe.case.messages import complaint
from fretfe.case.units import METRES, STRESSES
from fretfe.decision.damage import SmoothLife
from fretfe.decision.thresholds import FatigueLimit, GrowthLaw, Threshold
from fretfe.errors import CaseError
from fretfe.strength.margins import POISSON, YOUNG

# Of Young's modulus, and of that times √m: 10 MPa to 4 GPa, and 0.4 to 60 MPa√m of steel.
LIMITS = 5e-5, 0.02
THRESHOLDS = 2e-6, 3e-4


@dataclass(frozen=True)
class FatigueData:
    """Fatigue data of a material; None of what is not known.

    Attributes:
        path: of its file.
        source: of the numbers, in words.
        young, poisson: least and largest values that the file has.
        limit: of smooth specimens under push and pull.
        torsion: amplitude endured under reversed torsion.
        threshold: ΔK_th.
        growth: of long cracks.
        lengths: between which a life is asked for.
        life: of smooth specimens.
    """

    path: Path
    source: str
    young: tuple[float, float] | None
    poisson: tuple[float, float] | None
    limit: FatigueLimit | None
    torsion: float | None
    threshold: Threshold | None
    growth: GrowthLaw | None
    lengths: tuple[float, float] | None
    life: SmoothLife | None

    def disagreement(self, body: AnyBody) -> str:
        """Reason why a body is not of this material, or an empty text; alike as for tests."""
        own = isotropic(body)
        if own is None:
            return "the body is a crystal"
        if self.young is None or self.poisson is None:
            return ""
        low, high = self.young
        if not low * (1 - YOUNG) <= own.young <= high * (1 + YOUNG):
            return f"the body has E = {own.young:.4g}, the material {_ends(low, high)}"
        low, high = self.poisson
        if not low - POISSON <= own.poisson <= high + POISSON:
            return f"the body has ν = {own.poisson:.4g}, the material {_ends(low, high)}"
        return ""


def _ends(low: float, high: float) -> str:
    return f"{low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"


def fatigue_data(path: Path, units: Units) -> FatigueData:
    """Read the fatigue data of a material file.

    Args:
        path: of the file.
        units: of the results, whose labels must be known.

    Raises:
        CaseError: file and key of what is not as expected.
    """
    read = read_material(path)
    table = read.fatigue
    if table is None or table.units is None:
        raise CaseError(complaint(path, ("fatigue",), "expected a table of data, found none"))
    for key, known in (("stress", STRESSES), ("length", METRES)):
        if getattr(units, key) not in known:
            text = (
                f"expected results whose unit of {key} is known ({', '.join(known)}), to which the "
                f"data are converted, found {getattr(units, key)!r}"
            )
            raise CaseError(complaint(path, ("fatigue", "units", key), text))
    stress = STRESSES[table.units.stress] / STRESSES[units.stress]
    length = METRES[table.units.length] / METRES[units.length]
    intensity = stress * length**0.5
    elastic = STRESSES[read.units.stress] / STRESSES[units.stress]
    limit, growth = table.limit, table.growth
    young, threshold = _span(read.young, elastic), _threshold(table, intensity)
    if young is not None:
        metre = METRES[units.length] ** 0.5 / young[1]
        if limit is not None:
            _require_usual(path, "limit", limit.range * stress / young[1], LIMITS, "E")
        if threshold is not None:
            _require_usual(path, "threshold", threshold.ranges.max() * metre, THRESHOLDS, "E √m")
    return FatigueData(
        path=path,
        source=table.source,
        young=young,
        poisson=_span(read.poisson, 1.0),
        limit=None if limit is None else FatigueLimit(limit.range * stress, limit.ratio),
        torsion=None if table.torsion is None else table.torsion * stress,
        threshold=threshold,
        growth=None if growth is None else _growth(growth, intensity, length),
        lengths=None if growth is None else (growth.start * length, growth.end * length),
        life=None if table.life is None else _life(table.life, stress),
    )


def _require_usual(
    path: Path, key: str, share: float, usual: tuple[float, float], unit: str
) -> None:
    """Refuse data that no material of this Young's modulus has, as of a wrong unit.

    Raises:
        CaseError: file and key.
    """
    if not usual[0] <= share <= usual[1]:
        text = (
            f"expected {usual[0]:g} to {usual[1]:g} {unit}, as of metals, found {share:.3g} {unit}"
            ": are the units those of fatigue.units?"
        )
        raise CaseError(complaint(path, ("fatigue", key), text))


def _span(given: Any, scale: float) -> tuple[float, float] | None:
    """Least and largest value of a number, or of a table over temperature; None without."""
    values = given.get("values", ()) if isinstance(given, Mapping) else [given]
    numbers = [scale * each for each in values if isinstance(each, int | float)]
    return (min(numbers), max(numbers)) if numbers else None


def _threshold(table: Fatigue, scale: float) -> Threshold | None:
    match table.threshold:
        case ThresholdTable(range=float(one), ratio=float(ratio), walker=float(walker)):
            return Threshold(np.array([ratio]), np.array([one * scale]), walker)
        case ThresholdTable(ratios=tuple(ratios), ranges=tuple(ranges)):
            return Threshold(np.array(ratios), np.array(ranges) * scale)
    return None


def _growth(table: GrowthTable, intensity: float, length: float) -> GrowthLaw:
    ranges = np.array(table.ranges)
    if table.rates is not None:
        law = GrowthLaw(ranges, np.array(table.rates))
    else:
        assert table.factor is not None and table.exponent is not None
        law = GrowthLaw.paris(table.factor, table.exponent, (ranges[0], ranges[1]))
    return GrowthLaw(law.ranges * intensity, law.rates * length)


def _life(table: LifeTable, stress: float) -> SmoothLife:
    match table:
        case LifeTable(amplitudes=tuple(amplitudes), ratio=float(ratio)):
            return SmoothLife.of_amplitudes(
                np.array(table.cycles), np.array(amplitudes) * stress, ratio
            )
        case LifeTable(
            strength=float(strength), exponent=float(b),
            ductility=float(strain), ductility_exponent=float(c),
        ):  # fmt: skip
            span = table.cycles[0], table.cycles[-1]
            return SmoothLife.coffin_manson(span, (strength * stress, b), (strain, c))
    raise AssertionError("a table has amplitudes or the law")
