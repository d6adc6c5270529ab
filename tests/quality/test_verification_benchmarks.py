# SPDX-License-Identifier: LGPL-3.0-or-later
"""The benchmarks themselves; `cli/test_laboratory_verify` has half-planes solve them."""

from __future__ import annotations

import math
import runpy
from collections.abc import Callable
from pathlib import Path

import pytest
from scipy.integrate import quad

from fretfe.analytic.profiles import FlatRounded, Hertz, Profile, Wedge, edge_factor_k_n
from fretfe.backends import Installed, backend_names, find_backend
from fretfe.quality import pads
from fretfe.quality.comparison import Benchmark, Row
from fretfe.quality.cycles import LOOPS, SHORTEST
from fretfe.quality.loading import FRICTION, MESH, PLATE_MESH, SLOPE
from fretfe.quality.solids import PAD_MESH, hertz_ellipse
from fretfe.quality.verification import benchmarks, controls, run_benchmark

BENCHMARKS = {benchmark.name: benchmark for benchmark in benchmarks()}
# What half-planes do not take, with a word of the reason.
NOT_FOR_HALF_PLANES = {
    "sphere, cyclic shear": "found 'sphere'",
    "Cattaneo in space": "found 'sphere'",
    "sphere, cyclic twist": "found 'sphere'",
    "ellipse, cyclic shear": "found 'sphere'",
    "extruded pad, cyclic shear": "pad.msh",
    "sliding wedge block": "sliding_wedge.msh",
    "pushed plate": "plate.msh",
}


def run(benchmark: Benchmark) -> tuple[Row, ...]:
    installed = Installed("halfplane", "", find_backend("halfplane"))
    return run_benchmark(benchmark, installed)


@pytest.mark.parametrize("name", NOT_FOR_HALF_PLANES)
def test_what_is_left_out_has_a_reason(name: str) -> None:
    (row,) = run(BENCHMARKS[name])
    assert row.verdict == "skipped"
    assert NOT_FOR_HALF_PLANES[name] in row.reason


def test_names_are_different() -> None:
    table = (*benchmarks(), *controls())
    assert len({benchmark.name for benchmark in table}) == len(table)


@pytest.mark.parametrize("name", BENCHMARKS)
def test_every_benchmark_names_its_source(name: str) -> None:
    assert BENCHMARKS[name].source


@pytest.mark.parametrize("name", BENCHMARKS)
def test_tolerances_are_those_of_known_backends_and_useful(name: str) -> None:
    tolerances = [quantity.tolerances for quantity in BENCHMARKS[name].quantities]
    assert all(set(each) <= set(backend_names()) for each in tolerances)
    # the widest is the asymptote for slip zones of a fifth of a half-width
    assert all(0 < value <= 0.015 for each in tolerances for value in each.values())


Load = Callable[..., float]
# The closed forms of the known values were written down twice; here the two meet.
SHAPES: dict[str, tuple[Profile, Load, Load, tuple[float, ...]]] = {
    "Hertz": (Hertz(50.0, 100.0), pads.hertz_load, pads.hertz_k_n, (50.0,)),
    "wedge": (Wedge(0.01, 100.0), pads.wedge_load, pads.wedge_k_n, (0.01,)),
    "flat and rounded": (
        FlatRounded(0.5, 100.0, 100.0),
        pads.flat_rounded_load,
        pads.flat_rounded_k_n,
        (0.5, 100.0),
    ),
}


@pytest.mark.parametrize("half_width", [0.85, 1.0, 2.0])
@pytest.mark.parametrize("name", SHAPES)
def test_closed_forms_agree_with_the_library(name: str, half_width: float) -> None:
    profile, load, k_n, shape = SHAPES[name]
    assert load(half_width, *shape, 100.0) == pytest.approx(float(profile.load(half_width)))
    assert k_n(half_width, *shape, 100.0) == pytest.approx(
        float(edge_factor_k_n(profile, half_width))
    )


@pytest.mark.parametrize("lag", [0.0, 0.7, math.pi / 2, 2.5])
def test_ranges_of_k_t_are_those_of_the_history(lag: float) -> None:
    times = [2 * math.pi * i / 20000 for i in range(20000)]
    left, right = pads.k_t_ranges(0.3, 0.2, lag, 1.5)
    histories = {
        sign: [
            sign * pads.shear_part(0.3 * math.cos(t), 1.5)
            + pads.tension_part(0.2 * math.cos(t - lag), 1.5)
            for t in times
        ]
        for sign in (1, -1)
    }
    # sampling: 1 - cos(pi/20000)
    assert left == pytest.approx(max(histories[1]) - min(histories[1]), rel=1e-7)
    assert right == pytest.approx(max(histories[-1]) - min(histories[-1]), rel=1e-7)


def test_asymptotic_lengths_of_the_loops_follow_from_the_ranges() -> None:
    k_n = pads.hertz_k_n(1.0, 50.0, 100.0)
    for loop in LOOPS:
        force, tension = loop.shear * 0.5 * math.pi / 2, loop.tension * 0.5
        ranges = pads.k_t_ranges(force, tension, math.radians(loop.lag), 1.0)
        # four digits
        assert [r / (0.5 * k_n) for r in ranges] == pytest.approx(loop.asymptotic, abs=6e-5)


def test_shortest_slip_zone() -> None:
    assert pytest.approx(0.00305, abs=5e-6) == SHORTEST


@pytest.mark.parametrize("mesh", [MESH, PAD_MESH, PLATE_MESH], ids=["wedge", "pad", "plate"])
def test_mesh_is_what_the_tool_writes(mesh: Path) -> None:
    tool = Path(__file__).parents[2] / "tools" / "benchmark_meshes.py"
    tables = runpy.run_path(str(tool))
    assert tables["SLOPE"] == SLOPE
    blocks = tables["MESHES"][mesh.name]()
    assert tables["mesh_text"](blocks) == mesh.read_text(encoding="ascii")


@pytest.mark.parametrize("long", [1.001, 1.5, 3.0])
def test_hertz_on_an_ellipse(long: float) -> None:
    """Curvatures are integrals of the potential of an ellipsoidal pressure."""
    radius, e_star = 50.0, 1e5
    peak, radius_z = hertz_ellipse(1.0, long, radius, e_star)
    for axis, expected in ((1.0, radius), (long, radius_z)):

        def integrand(t: float, axis: float = axis) -> float:
            # w = t^2 in place of w, whose root is singular at 0.
            return 2 / ((axis**2 + t**2) * math.sqrt((1 + t**2) * (long**2 + t**2)))

        potential, _ = quad(integrand, 0.0, math.inf, epsrel=1e-10)
        curvature = peak * long * potential / e_star
        assert 1 / curvature == pytest.approx(expected, rel=1e-6)


def test_force_ratio_of_the_sliding_wedge() -> None:
    (quantity,) = BENCHMARKS["sliding wedge block"].quantities
    normal, shear = 1.0, FRICTION
    angle = math.atan(SLOPE)
    horizontal = normal * math.sin(angle) + shear * math.cos(angle)
    vertical = normal * math.cos(angle) - shear * math.sin(angle)
    assert quantity.reference == pytest.approx(horizontal / vertical)
    assert quantity.reference == pytest.approx(0.412371, abs=5e-7)


def test_published_slip_zones_of_the_unloaded_cylinder_are_mindlins() -> None:
    """Of Q = f P/2: a (1 - sqrt(1 - 1/2)), and half as far back a (1 - sqrt(1 - 1/4))."""
    half_width, loaded, unloaded = BENCHMARKS["cylinder, sheared and unloaded"].quantities
    a, e_star = half_width.reference, 200e3 / (2 * (1 - 0.3**2))
    assert pads.hertz_load(a, 6.0, e_star) == pytest.approx(120.0, rel=2e-5)
    assert loaded.reference == pytest.approx(a * (1 - math.sqrt(1 / 2)), abs=5e-6)
    assert unloaded.reference == pytest.approx(a * (1 - math.sqrt(3 / 4)), abs=5e-6)
