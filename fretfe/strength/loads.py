# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edge factors of a laboratory test from its loads, between half-planes.

A pad is pressed on a flat specimen by a constant P; Q and a bulk stress of the specimen, in phase
or with a lag, swing about their means, which do not count in a steady cycle. Numbers in brackets
are those of docs/theory.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from fretfe.analytic.edges import mixed_asymptote_error, slip_length_cyclic, tangential_factor
from fretfe.analytic.profiles import FIRST_YIELD, edge_factor_k_n, peak_pressure
from fretfe.evaluate.verdicts import LARGEST_ERROR
from fretfe.idealise.bodies import Block, side_tension
from fretfe.idealise.case import SMALLEST_BODY
from fretfe.report.texts import rounded


@dataclass(frozen=True)
class PadLoads:
    """A test.

    Attributes:
        block: pad and specimen; infinite sizes where they are not known.
        normal_force: P per unit thickness.
        shear: amplitude of Q per unit thickness, positive away from the end that holds the
            specimen.
        bulk: amplitude of the stress at its other end; its angle is that by which it is ahead of Q.
        friction: coefficient.
        yield_stress: in tension; infinite if not known.
    """

    block: Block
    normal_force: float
    shear: float
    bulk: complex
    friction: float
    yield_stress: float

    @property
    def half_width(self) -> float:
        """Half-width a of the contact."""
        return float(self.block.profile.half_width(self.normal_force))

    @property
    def tension(self) -> complex:
        """Amplitude of the tension at the contact: the held end carries Q besides the bulk."""
        height, half_width = self.block.heights[1], self.block.half_widths[1]
        if math.isinf(height):
            return self.bulk
        return self.bulk + self.shear * side_tension(half_width, height, sliding=True)[0]


@dataclass(frozen=True)
class PadEdge:
    """The edge of a test with the larger range of K_T.

    Attributes:
        k_n: K_N.
        k_t_range: ΔK_T.
        slip: d by (9).
        share: of the tension in ΔK_T; above a half the edges slip in opposite directions.
        error: predicted/exact - 1 of d; NaN where it is not known.
        size_errors: relative errors of K_N and ΔK_T because the bodies are finite.
        outside: why the factors do not describe the edge; empty if they do.
    """

    k_n: float
    k_t_range: float
    slip: float
    share: float
    error: float
    size_errors: tuple[float, float]
    outside: str

    @property
    def reverses(self) -> bool:
        """True if the tension makes the edges slip in opposite directions."""
        return self.share > 0.5


def edge_of(test: PadLoads) -> PadEdge:
    """The edge of a test whose loads cycle, Q or bulk stress."""
    profile, a = test.block.profile, test.half_width
    k_n = float(edge_factor_k_n(profile, a))
    # (7) and (10): amplitudes of both parts, whose angles are those of Q and of the tension.
    shear, stretch = (
        part * float(tangential_factor(*unit, a, "left"))
        for part, unit in ((test.shear, (1.0, 0.0)), (test.tension, (0.0, 1.0)))
    )
    whole = max(stretch + shear, stretch - shear, key=abs)
    k_t_range = 2 * abs(whole)
    slip = float(slip_length_cyclic(k_t_range, k_n, test.friction))
    share = (stretch * whole.conjugate()).real / abs(whole) ** 2
    error = float(mixed_asymptote_error(profile, a, slip, share))
    edge = PadEdge(k_n, k_t_range, slip, share, error, test.block.size_errors(a), "")
    return replace(edge, outside=_outside(test, edge))


def _outside(test: PadLoads, edge: PadEdge) -> str:
    """The reason why factors do not describe an edge; empty if they do."""
    limit, a = test.friction * test.normal_force, test.half_width
    if test.shear >= limit:
        loads = f"Q = {rounded(test.shear, 4)}, f P = {rounded(limit, 4)}"
        return f"the contact slides as a whole: {loads}"
    if SMALLEST_BODY * a > test.block.smallest:
        return (
            f"it is no half-plane: the half-width of the contact is {rounded(a)}, and the height "
            f"or half-width of a body {rounded(test.block.smallest)}"
        )
    strength = FIRST_YIELD * test.yield_stress
    if (largest := peak_pressure(test.block.profile, a)) > strength:
        pressures = f"{rounded(largest, 4)}, and {rounded(strength, 4)} are elastic"
        return f"it yields: the largest pressure is {pressures}"
    if abs(test.tension) > test.yield_stress:
        return f"it yields: the bulk stress is {rounded(abs(test.tension), 4)}"
    if not abs(edge.error) <= LARGEST_ERROR:
        flat = max(test.block.profile.kinks, default=0.0)
        share = f"{rounded(edge.slip / (a - flat), 2)} of {'a − b' if flat else 'a'}"
        error = f"{edge.error:+.0%}".replace("%", " %") + " off"
        text = error if math.isfinite(edge.error) else "without meaning"
        turned = ", where the bulk stress reverses the slip of the other edge" * edge.reverses
        return f"the slip zone is too long: d is {share}, for which the formula is {text}{turned}"
    return ""
