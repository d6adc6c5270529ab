# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table `[fatigue]` of a material file: what tests of specimens and of cracks have told."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from fretfe.case.base import Positive, Table, Text, require_increasing
from fretfe.case.units import METRES, STRESSES


def _known(label: str, known: dict[str, float]) -> str:
    if label not in known:
        raise ValueError(f"expected one of {', '.join(known)}, found {label!r}")
    return label


Ratio = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-100, lt=1)]
Stress = Annotated[Text, AfterValidator(lambda label: _known(label, STRESSES))]
Length = Annotated[Text, AfterValidator(lambda label: _known(label, METRES))]
Values = Annotated[tuple[Positive, ...], Field(min_length=2, max_length=10_000)]


class FatigueUnits(Table):
    """Units of the table: ΔK is in stress times root of length, growth in length per cycle."""

    stress: Stress
    length: Length


class Limit(Table):
    """Range of the stress that smooth specimens endure under push and pull."""

    range: Positive
    ratio: Ratio


class ThresholdTable(Table):
    """ΔK_th of long cracks: at one R, with the exponent of Walker, or a table over R."""

    range: Positive | None = None
    ratio: Ratio | None = None
    walker: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=2)] | None = None
    ratios: Annotated[tuple[Ratio, ...], Field(min_length=2, max_length=10_000)] | None = None
    ranges: Values | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        single = [key for key in ("range", "ratio", "walker") if getattr(self, key) is not None]
        table = [key for key in ("ratios", "ranges") if getattr(self, key) is not None]
        if (len(single), len(table)) not in ((3, 0), (0, 2)):
            raise ValueError(
                "expected range, ratio and walker, or ratios and ranges, found "
                f"{', '.join((*single, *table)) or 'nothing'}"
            )
        if self.ratios is not None and self.ranges is not None:
            require_increasing("ratios", self.ratios, self.ranges)
            if any(b > a for a, b in pairwise(self.ranges)):
                raise ValueError(
                    "expected ranges that do not grow with R, as cracks are open for more of a "
                    "cycle, found some that do"
                )
        return self


class GrowthTable(Table):
    """Growth of long cracks, over ΔK: the law of Paris between two ΔK, or a table."""

    factor: Positive | None = None
    exponent: Positive | None = None
    ranges: Values
    rates: Values | None = None
    start: Positive
    end: Positive

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        law = [key for key in ("factor", "exponent") if getattr(self, key) is not None]
        if (self.rates is None) == (not law) or len(law) == 1:
            found = ", ".join([*law, *(["rates"] if self.rates is not None else [])]) or "nothing"
            raise ValueError(f"expected factor and exponent, or rates, found {found}")
        require_increasing("ranges", self.ranges, self.rates or self.ranges)
        if law and len(self.ranges) != 2:
            raise ValueError(
                f"expected two ranges, between which the law was tested, found {len(self.ranges)}"
            )
        if self.factor is not None and self.exponent is not None:
            # Numbers that are none: rates of a law would overflow.
            shift, slope = math.log10(self.factor), self.exponent
            if any(abs(shift + slope * math.log10(each)) > 100 for each in self.ranges):
                raise ValueError("expected rates between 1e-100 and 1e100 at the ranges")
        if any(b < a for a, b in pairwise(self.rates or ())):
            raise ValueError("expected rates that do not fall with the range, found some that do")
        if self.start >= self.end:
            raise ValueError(f"expected start < end, found {self.start:g} and {self.end:g}")
        return self


Power = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-5, lt=0)]


class LifeTable(Table):
    """Lives of smooth specimens: amplitudes at one R, or the law of Coffin and Manson.

    Of the law `cycles` are the two lives between which it was tested, and 2 N reversals count.
    """

    cycles: Values
    amplitudes: Values | None = None
    ratio: Ratio | None = None
    strength: Positive | None = None
    exponent: Power | None = None
    ductility: Positive | None = None
    ductility_exponent: Power | None = None

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        table = [key for key in ("amplitudes", "ratio") if getattr(self, key) is not None]
        law = [
            key for key in ("strength", "exponent", "ductility", "ductility_exponent")
            if getattr(self, key) is not None
        ]  # fmt: skip
        if (len(table), len(law)) not in ((2, 0), (0, 4)):
            raise ValueError(
                "expected amplitudes and ratio, or strength, exponent, ductility and "
                f"ductility_exponent, found {', '.join((*table, *law)) or 'nothing'}"
            )
        require_increasing("cycles", self.cycles, self.amplitudes or self.cycles)
        if law and len(self.cycles) != 2:
            raise ValueError(
                f"expected two lives, between which the law was tested, found {len(self.cycles)}"
            )
        if any(b >= a for a, b in pairwise(self.amplitudes or ())):
            raise ValueError("expected amplitudes that fall, found some that do not")
        if not 0.5 <= self.cycles[0] <= self.cycles[-1] <= 1e15:
            raise ValueError("expected lives from 0.5 to 1e15 cycles, found others")
        return self

    @property
    def tested_at(self) -> float:
        """Ratio R of the tests; laws are of reversed ones."""
        return -1.0 if self.ratio is None else self.ratio

    @property
    def lowest(self) -> float:
        """Amplitude of the stress at which specimens fail last; of a law its elastic part."""
        if self.amplitudes is not None:
            return self.amplitudes[-1]
        assert self.strength is not None and self.exponent is not None
        return float(self.strength * (2 * self.cycles[-1]) ** self.exponent)


class Fatigue(Table):
    """Fatigue data of a material; nothing has a default.

    Attributes:
        source: where the numbers are from.
        units: of them; None without any.
        limit: of smooth specimens under push and pull.
        torsion: amplitude that is endured under reversed torsion.
        threshold: of long cracks.
        growth: of long cracks, and the lengths between which a life is asked for.
        life: of smooth specimens, for damage.
    """

    source: Text
    units: FatigueUnits | None = None
    limit: Limit | None = None
    torsion: Positive | None = None
    threshold: ThresholdTable | None = None
    growth: GrowthTable | None = None
    life: LifeTable | None = None

    @model_validator(mode="after")
    def _with_units(self) -> Self:
        data = (self.limit, self.torsion, self.threshold, self.growth, self.life)
        if self.units is None and any(each is not None for each in data):
            raise ValueError("expected units beside data, found none")
        if self.growth is not None and self.units is not None:
            # No part is longer.
            if self.growth.end * METRES[self.units.length] > 10.0:
                found = f"{self.growth.end:g} {self.units.length}"
                raise ValueError(f"growth.end: expected cracks of at most 10 m, found {found}")
        return self

    @model_validator(mode="after")
    def _endured(self) -> Self:
        """Specimens that endure the limit do not fail below it, at the same R."""
        limit, life = self.limit, self.life
        if limit is None or life is None or limit.ratio != life.tested_at:
            return self
        lowest, endured = life.lowest, limit.range / 2
        # Both are read from scattered tests.
        if lowest < 0.9 * endured:
            raise ValueError(
                f"life: expected amplitudes of at least {endured:g}, which limit says is endured, "
                f"found {lowest:g} at {life.cycles[-1]:g} cycles"
            )
        return self

    @model_validator(mode="after")
    def _ductile(self) -> Self:
        """Criteria of endurance hold for metals whose limits are in the usual proportion."""
        if self.torsion is None:
            return self
        if self.limit is None or self.limit.ratio != -1:
            raise ValueError("expected a limit of the ratio -1 beside torsion, found none")
        share = self.torsion / (self.limit.range / 2)
        if not 1 / math.sqrt(3) <= share < 1:
            raise ValueError(
                "expected torsion between 0.577 and 1 times the amplitude of the limit, as of "
                f"ductile metals, found {share:.3g} times"
            )
        return self
