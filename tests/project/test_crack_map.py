# SPDX-License-Identifier: LGPL-3.0-or-later
"""The map of cracks at an edge: its stress, short cracks, and cylinders, whose limit it is."""

from __future__ import annotations

import math
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from reference.elliptical_stress import elliptical_stress

from fretfe._typing import Array
from fretfe.analytic.cracks import EdgeCracks
from fretfe.decision.thresholds import opening_range


def load_map() -> ModuleType:
    path = Path(__file__).parents[2] / "tools" / "crack_map.py"
    spec = spec_from_file_location("crack_map", path)
    assert spec is not None and spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["crack_map"] = module
    spec.loader.exec_module(module)
    return module


crack_map = load_map()


@pytest.mark.parametrize("bulk", [0.0, 1.0])
def test_shortest_cracks_have_the_tension_of_the_edge(bulk: float) -> None:
    """1.1215 √(π c) times 2 f K_N √d (2 f p0 √(Q/(f P)) of a cylinder) and the bulk stress."""
    lengths = np.array([1e-6, 1e-5])
    found = crack_map.drive(bulk, 0.0, lengths) / np.sqrt(lengths)
    assert found == pytest.approx(1.12152 * (2 + bulk), rel=0.01)


def cylinder(share: float, lengths: Array) -> Array:
    """(C,) ΔK over f K_N d √π at both extremes of Cattaneo's shear that slips over d = share a."""
    core, friction = 1 - share, 0.5
    slip = (1 - core**2) / 2  # Of the edge formula.
    cracks = EdgeCracks.of([0.0])
    points = cracks.points(lengths * slip)
    x, depth = points[..., 0] - 1, -points[..., 1]
    pressed = elliptical_stress(x.ravel(), depth.ravel(), 1.0, 1.0, 0.0)
    sheared = elliptical_stress(x.ravel(), depth.ravel(), 1.0, 0.0, friction)
    sheared -= elliptical_stress(x.ravel(), depth.ravel(), core, 0.0, friction * core)
    stress = np.stack([pressed - sheared, pressed + sheared]).reshape(2, *points.shape[:-1], 3)
    k_1, k_2 = cracks.factors(lengths * slip, stress)
    scale = friction * math.sqrt(2) * slip * math.sqrt(math.pi)
    return np.asarray(opening_range(k_1[:, 0], k_2[:, 0])[0] / scale)


def test_the_map_is_the_limit_of_a_cylinder() -> None:
    lengths = np.array([0.01, 0.05, 0.15, 0.4])
    known = crack_map.drive(0.0, 0.0, lengths, 3)
    errors = [np.abs(cylinder(share, lengths) / known - 1) for share in (0.05, 2e-3, 1e-4)]
    assert (errors[0] < [0.01, 0.02, 0.08, 0.8]).all()
    assert (errors[2] < errors[1]).all() and (errors[1] < errors[0]).all()
    assert errors[2].max() < 0.04


def test_the_figure(tmp_path: Path) -> None:
    crack_map.draw(tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 20_000
