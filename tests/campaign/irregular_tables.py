# SPDX-License-Identifier: LGPL-3.0-or-later
"""Coverage of the error bars of irregular histories, by class."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from campaign.extent import SEED
from campaign.irregular_draw import VARYING, IrregularDraw
from campaign.judge import QUANTITIES, Judged

IRREGULAR_QUANTITIES = (*QUANTITIES, "edge")
# Elements over the half-width, or over the rounded part in contact, that meshes are told apart by.
COARSE, FINE = 10, 25


def _varies(name: str) -> Callable[[IrregularDraw], bool]:
    return lambda one: one.varying == name


CLASSES: dict[str, Callable[[IrregularDraw], bool]] = {
    "all": lambda one: True,
    **{f"varies: {name}": _varies(name) for name in VARYING},
    "cycle repeated": lambda one: one.repeats,
    "passed once": lambda one: not one.repeats,
    "degree 1": lambda one: one.degree == 1,
    "degree 2": lambda one: one.degree == 2,
    "meshes that refine themselves": lambda one: one.tolerance is not None,
    f"under {COARSE} elements": lambda one: not one.tolerance and one.per_half_width < COARSE,
    f"{COARSE} to {FINE} elements": lambda one: (
        not one.tolerance and COARSE <= one.per_half_width < FINE
    ),
    f"over {FINE} elements": lambda one: not one.tolerance and one.per_half_width >= FINE,
}


def of_class(judged: Iterable[Judged], quantity: str, name: str = "all") -> list[Judged]:
    """The numbers of a class."""
    own = [each for each in judged if each.quantity == quantity]
    chosen = CLASSES[name]
    return [e for e in own if isinstance(e.draw, IrregularDraw) and chosen(e.draw)]


def given(judged: Iterable[Judged], quantity: str, name: str = "all") -> list[Judged]:
    """The numbers of a class that have a value."""
    return [each for each in of_class(judged, quantity, name) if np.isfinite(each.value)]


def held(numbers: list[Judged]) -> float:
    """Share of numbers that are within their bars."""
    return float(np.mean([each.error <= each.bar for each in numbers]))


def sharpness(numbers: list[Judged]) -> float:
    """Median of bar over error."""
    errors = [max(abs(each.value - each.truth), 1e-9 * each.size) for each in numbers]
    return float(np.median([each.bar for each in numbers] / np.array(errors)))


def coverage(judged: list[Judged]) -> str:
    """A row for each class and number, in Markdown."""
    rows = ["| class | number | given | bars hold | median bar/error |", "|---|---|---|---|---|"]
    for name in CLASSES:
        for quantity in IRREGULAR_QUANTITIES:
            drawn = of_class(judged, quantity, name)
            numbers = given(judged, quantity, name)
            if numbers:
                rows.append(
                    f"| {name} | {quantity} | {len(numbers)} of {len(drawn)} | "
                    f"{100 * held(numbers):.1f}% | {sharpness(numbers):.1f} |"
                )
    return "\n".join(rows)


def require_held(judge: Callable[[int, int], list[Judged]], count: int) -> None:
    """Judge so many histories of the week: bars of 95 % of each number hold."""
    judged = [each for one in range(count) for each in judge(one, SEED)]
    print(f"FRETFE_CAMPAIGN_SEED={SEED}\n{coverage(judged)}")
    for quantity in IRREGULAR_QUANTITIES:
        numbers = given(judged, quantity)
        missed = [each for each in numbers if each.error > each.bar]
        # 95 % of all: of so few one case may fail, with both its edges and some half cycles.
        allowed = max(4, round(0.05 * len(numbers)))
        assert len(missed) <= allowed, (SEED, held(numbers), [each.text for each in missed])
