# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cost of the companions of a case, in words, estimated from what the case itself took."""

from __future__ import annotations

from collections.abc import Sequence

from fretfe.environment import peak_memory
from fretfe.quality.validate.variants import COARSER, MESH, Variant
from fretfe.results.model import Result

# Phases of a run that companions on the same mesh go through too.
REPEATED = ("steps", "edge integrals", "evaluation")
# Powers of the element size by which the time of a run falls on a coarser mesh.
POWERS = {False: 2, True: 4}


def plan(variants: Sequence[Variant], result: Result) -> str:
    """How many companions there are, about how long each takes, and the memory."""
    if not variants:
        return "no companions"
    seconds = [_seconds(variant, result) for variant in variants]
    each = ", ".join(
        f"{variant.name} {_time(time)}" for variant, time in zip(variants, seconds, strict=True)
    )
    total = f", {_time(sum(seconds))} together" if len(variants) > 1 else ""
    count = f"{len(variants)} companion{'s' if len(variants) > 1 else ''}"
    memory = f"{peak_memory() / 1e9:.1f} GB at most, what the case itself took"
    return f"{count}: {each}{total}, estimated; {memory}"


def _seconds(variant: Variant, result: Result) -> float:
    took = result.seconds
    if variant.name == MESH:
        return sum(took.values()) / COARSER ** POWERS[bool(result.areas)]
    share = 1.0
    if variant.history is not None:
        share = len(variant.history.times) / max(len(result.loads.times), 1)
    # Integrals do not depend on the number of steps.
    return sum(
        time * (share if phase == "steps" else 1.0)
        for phase, time in took.items()
        if phase in REPEATED
    )


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"
