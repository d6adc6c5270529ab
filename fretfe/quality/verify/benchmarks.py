# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table of benchmarks."""

from __future__ import annotations

from fretfe.quality.verify.classic import cylinder_on_block, fretting_specimens, two_cylinders
from fretfe.quality.verify.loops import loop_benchmarks
from fretfe.quality.verify.model import Benchmark
from fretfe.quality.verify.sliding import sliding_wedge
from fretfe.quality.verify.steady import cyclic_shear, rocking, varying_normal_load


def benchmarks() -> tuple[Benchmark, ...]:
    """All benchmarks, in the order in which they are run."""
    return (
        two_cylinders(),
        cylinder_on_block(),
        *fretting_specimens(),
        *loop_benchmarks(),
        *cyclic_shear(),
        *varying_normal_load(),
        rocking(),
        sliding_wedge(),
        _sphere("two spheres, normal", "Hertz 1882"),
        _sphere("sphere, tangential", "Mindlin 1949"),
    )


def _sphere(name: str, source: str) -> Benchmark:
    reason = "no backend solves three-dimensional contacts"
    return Benchmark(name, source, case=None, quantities=(), left_out=reason)
