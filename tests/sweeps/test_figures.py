# SPDX-License-Identifier: LGPL-3.0-or-later
"""Effects of the keys of a sweep on made-up numbers that are linear in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.pad_cases import pad
from matplotlib.figure import Figure

import fretfe
from fretfe.case import parse_case
from fretfe.errors import OutputError
from fretfe.sweeps import Solved, Sweep, sample
from fretfe.sweeps.figures import write_sweep

KEYS = ("mu", "load")
POINTS = sample({"mu": (0.2, 0.6), "load": (10.0, 50.0)}, 8)


def linear(mu: float, load: float) -> float:
    return 100 + 50 * mu - 2 * load


def swept(points: Mapping[str, Sequence[Any]], curve: float = 0.0) -> Sweep:
    """Two edges; the right one is 7 lower, and its last number is unknown."""
    variants = []
    pairs = list(zip(*points.values(), strict=True))
    for each in pairs:
        mu, load = (value if isinstance(value, float) else 0.0 for value in each)
        top = linear(mu, load) + curve * (mu - 0.4) ** 2
        numbers = {"left": top, "right": float("nan") if each == pairs[-1] else top - 7}
        edges = tuple(
            {"contact": "main", "edge": name, "k_t_range": value, "k_t_range_spread": 0.5,
             "steady": True}
            for name, value in numbers.items()
        )  # fmt: skip
        variants.append(Solved(dict(zip(points, each, strict=True)), edges, "", (), (), 1.0))
    variants.append(Solved({"mu": 0.9, "load": 90.0}, (), "it slid", (), (), 1.0))
    return Sweep(tuple(points), parse_case(pad()).units, tuple(variants))


def test_bars_are_slopes_times_ranges_the_largest_on_top() -> None:
    panel = fretfe.plot_tornado(swept(POINTS), "k_t_range", Figure().subplots())
    (mu_low, mu_high), (low, high) = ((min(POINTS[key]), max(POINTS[key])) for key in KEYS)
    middle = (mu_low + mu_high) / 2, (low + high) / 2
    bars = [(each.get_x(), each.get_x() + each.get_width()) for each in panel.patches]  # type: ignore[attr-defined]
    np.testing.assert_allclose(bars[0], [linear(middle[0], low), linear(middle[0], high)])
    np.testing.assert_allclose(bars[1], [linear(mu_low, middle[1]), linear(mu_high, middle[1])])
    names = [each.get_text().split("\n")[0] for each in panel.get_yticklabels()]
    assert names == ["load", "mu"]
    assert panel.get_xlabel() == "largest k_t_range [MPa·√mm]"
    assert panel.get_title("left").endswith("linear part 100%")


def test_nothing_of_a_tornado_is_cut_off() -> None:
    keys = ("geometry.parameters.flank_angle", "loads.pull.mean")
    points = dict(zip(keys, POINTS.values(), strict=True))
    figure = fretfe.plot_tornado(swept(points), "k_t_range").figure
    assert isinstance(figure, Figure)
    figure.canvas.draw()
    drawn, whole = figure.get_tightbbox(), figure.bbox_inches
    assert 0 <= drawn.x0 < drawn.x1 <= whole.x1
    assert 0 <= drawn.y0 < drawn.y1 <= whole.y1


def test_what_is_not_linear_is_told() -> None:
    grid = {"mu": (0.2, 0.4, 0.6) * 2, "load": (10.0,) * 3 + (12.0,) * 3}
    panel = fretfe.plot_tornado(swept(grid, curve=500.0), "k_t_range", Figure().subplots())
    # Slopes 20 and -4 over the ranges, curvature 0, 20 in the middle: variances by hand.
    linear_part = 2 * 10**2 / 3 + 2**2
    curved = 2 * 20**2 / 9
    share = linear_part / (linear_part + curved)
    assert panel.get_title("left").endswith(f"linear part {share:.0%}")


def test_points_and_bars_of_all_edges() -> None:
    panels = fretfe.plot_scatter(swept(POINTS), "k_t_range", Figure().subplots(2))
    left, right = panels[0].containers
    expected = [linear(*each) for each in zip(*POINTS.values(), strict=True)]
    for drawn, values in ((left, expected), (right, [*np.array(expected[:-1]) - 7, np.nan])):
        x, y = drawn[0].get_data()
        np.testing.assert_array_equal(x, POINTS["mu"])
        np.testing.assert_allclose(np.asarray(y, dtype=float), values)
        ends = np.array(drawn[2][0].get_segments()[0])
        np.testing.assert_allclose(ends[:, 1], [y[0] - 0.5, y[0] + 0.5])
    assert [each.get_xlabel() for each in panels] == list(KEYS)


@pytest.mark.parametrize(
    ("points", "quantity", "text"),
    [
        (POINTS, "k_n", "expected one of k_t_range, k_t_range_spread, found 'k_n'"),
        (POINTS, "steady", "found 'steady'"),
        (
            {"mu": (0.2, 0.6), "load": (1.0, 2.0)},
            "k_t_range",
            "expected 3 cases or more .* found 2",
        ),
        ({"mu": (0.2, 0.4, 0.6), "load": (1.0, 2.0, 3.0)}, "k_t_range", "tell 2 keys apart"),
        ({"mu": (0.2, 0.4), "load": ("a", "b")}, "k_t_range", "expected numbers of all keys"),
        ({"mu": (), "load": ()}, "k_t_range", "expected one of .none., found 'k_t_range'"),
    ],
    ids=["other number", "no number", "few cases", "in a row", "texts", "nothing solved"],
)
def test_what_has_no_effects_says_why(points: Any, quantity: str, text: str) -> None:
    with pytest.raises(OutputError, match=text):
        fretfe.plot_tornado(swept(points), quantity)


@pytest.mark.parametrize("names", [("a",) * 3, (1.0, 3.0, 2.0)], ids=["texts", "numbers"])
def test_points_have_a_picture(tmp_path: Path, names: tuple[Any, ...]) -> None:
    sweep = swept({"mu": (0.2, 0.4, 0.6), "load": names})
    assert write_sweep(tmp_path / "sweep.png", sweep.keys, sweep.records(), sweep.units)
    assert (tmp_path / "sweep.png").stat().st_size > 10_000
