# SPDX-License-Identifier: LGPL-3.0-or-later
"""A strength map as JSON and as a figure: tests and edges in the plane of K_N and ΔK_T."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fretfe.files import json_value, replace_text, writing
from fretfe.report.plotting import (
    Axes,
    Figure,
    FuncFormatter,
    LogNorm,
    MaxNLocator,
    NullLocator,
    mpl,
)
from fretfe.report.texts import number
from fretfe.report.theme import (
    COLOURS,
    GREY,
    PURPLE,
    STYLE,
    VERMILLION,
    WIDTH,
    log_axis,
    save_figure,
)
from fretfe.results.quantities import axis_label
from fretfe.results.writer import prepare_other
from fretfe.strength.fit import COVERAGE, LifeFit
from fretfe.strength.margins import Margin, StrengthMap

HEIGHT = 4.6
# Up to this number edges have a mark of their own each, else one for each result.
MOST_MARKS = 5
# Of edges; dots and upward triangles are those of tests.
MARKERS = "sDvPX"
# A logarithmic axis over less than this factor has the ticks of a linear one.
NARROW = 8
# Beside all points, as a factor.
MARGIN = 1.15
PALE_MARK = 0.4
POINTS = 60
SCHEMA = {"name": "fretfe-strength", "version": 1}
# Attributes of an edge and of its margin, which are keys of the file.
OF_EDGE = (
    "result", "contact", "edge", "station", "k_n", "k_n_spread", "k_t_range",
    "k_t_range_spread", "friction",
)  # fmt: skip
JUDGED = (
    "strength", "strength_spread", "margin", "low", "high", "fit_share", "scatter_share",
    "edge_share",
)  # fmt: skip
OF_FIT = ("scatter", "failures", "runouts", "quantile")
STRENGTH = "strength.json"
PICTURE = "strength.png"


def plot_strength(found: StrengthMap) -> Figure:
    """Failures and run-outs of the tests, the strength at the life, and the edges."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
        draw_strength(figure.subplots(), found)
    return figure


def draw_strength(axes: Axes, found: StrengthMap) -> None:
    """Draw a strength map, with its legend outside of the axes."""
    units = found.tests.units
    _draw_tests(axes, found)
    for fit in found.fits:
        _draw_fit(axes, found, fit)
    _draw_edges(axes, found)
    _limit(axes, found)
    axes.set_xlabel(axis_label("k_n", units, solid=False))
    axes.set_ylabel(axis_label("k_t_range", units, solid=False))
    handles, labels = axes.get_legend_handles_labels()
    axes.figure.legend(handles, labels, loc="outside upper center", ncols=2)


def write_strength(found: StrengthMap, path: Path) -> None:
    """Write the figure."""
    with mpl.rc_context(STYLE):
        save_figure(plot_strength(found), path)


def _draw_tests(axes: Axes, found: StrengthMap) -> None:
    tests = found.tests
    lives = LogNorm(tests.life.min(), max(tests.life.max(), 1.01 * tests.life.min()))
    failed, ended = ~tests.runout & tests.inside, tests.runout & tests.inside
    image = axes.scatter(
        tests.k_n[failed], tests.k_t_range[failed], c=tests.life[failed],
        s=26, cmap=COLOURS, norm=lives, label="test, failed", zorder=2,
    )  # fmt: skip
    if ended.any():
        axes.scatter(
            tests.k_n[ended], tests.k_t_range[ended], s=34, marker="^", facecolors="none",
            edgecolors=GREY, linewidths=1.1, label="test, run-out", zorder=2,
        )  # fmt: skip
    if not tests.inside.all():
        axes.scatter(
            tests.k_n[~tests.inside], tests.k_t_range[~tests.inside], s=26, marker="x", color=GREY,
            linewidths=1.1, label="test outside the edge formulas", zorder=2,
        )  # fmt: skip
    bar = axes.figure.colorbar(image, ax=axes, label="life of failed tests [cycles]", pad=0.02)
    bar.ax.yaxis.set_major_formatter(FuncFormatter(lambda life, _: number(life, 1)))
    bar.ax.yaxis.set_minor_formatter(FuncFormatter(lambda *_: ""))


def _draw_fit(axes: Axes, found: StrengthMap, fit: LifeFit) -> None:
    """The strength at the life and where 95 % of single specimens are, over its tested K_N."""
    own = [each for each in found.margins if each.fit is fit]
    if all(each.reason for each in own):
        return
    k_n = np.geomspace(*fit.tested, POINTS)
    strength = np.asarray(fit.strength(k_n, found.life))
    half = np.array([fit.quantile * np.sqrt(sum(fit.variances(x, found.life))) for x in k_n])
    label = f"strength at {number(found.life, 6)} cycles"
    axes.plot(k_n, strength, color=PURPLE, label=label, zorder=1)
    axes.fill_between(
        k_n, strength / 10**half, strength * 10**half, color=PURPLE, alpha=0.12, lw=0,
        label="95 % of single specimens", zorder=0,
    )  # fmt: skip


def _draw_edges(axes: Axes, found: StrengthMap) -> None:
    """A mark for each edge; for each front of solids at its worst station, with all in its bars.

    Those without a margin, as of another f or E*, are pale: the line is not theirs.
    """
    fronts: dict[str, list[Margin]] = {}
    for each in found.margins:
        if each.edge.k_t_range > 0 and each.edge.k_n > 0:
            fronts.setdefault(each.edge.name, []).append(each)
    by_edge = len(fronts) <= MOST_MARKS
    marks: dict[str, list[_Mark]] = {}
    for name, own in fronts.items():
        shown = name if by_edge else own[0].edge.result
        mark = _Mark.of(own)
        shown = shown if mark.judged else f"{shown}\nwithout a margin"
        marks.setdefault(shown, []).append(mark)
    for place, (name, those) in enumerate(marks.items()):
        axes.errorbar(
            [each.k_n for each in those],
            [each.k_t_range for each in those],
            xerr=np.transpose([each.k_n_bar for each in those]),
            yerr=np.transpose([each.k_t_bar for each in those]),
            # Edges often agree: the first one is seen around those that cover it.
            fmt=MARKERS[place % len(MARKERS)],
            ms=6 + 5 * (len(marks) - place - 1) / len(marks),
            mfc="none", mew=1.4, color=VERMILLION, ls="none", capsize=2, lw=1.0,
            alpha=1.0 if those[0].judged else PALE_MARK,
            label=name, zorder=3,
        )  # fmt: skip


@dataclass(frozen=True)
class _Mark:
    """Place of an edge in the map, how far its bars reach down and up, and if it has a margin."""

    k_n: float
    k_t_range: float
    k_n_bar: tuple[float, float]
    k_t_bar: tuple[float, float]
    judged: bool

    @classmethod
    def of(cls, own: Sequence[Margin]) -> _Mark:
        """That of an edge, or of the stations of a front: the worst of them and the range."""
        known = [each for each in own if np.isfinite(each.margin)]
        worst = min(known, key=lambda each: each.margin, default=None) or max(
            own, key=lambda each: each.edge.k_t_range
        )
        edge, edges = worst.edge, [each.edge for each in own]

        def bar(at: float, values: list[float], spread: float) -> tuple[float, float]:
            if len(values) == 1:
                return (spread, spread) if np.isfinite(spread) else (0.0, 0.0)
            return at - min(values), max(values) - at

        return cls(
            edge.k_n,
            edge.k_t_range,
            bar(edge.k_n, [each.k_n for each in edges], edge.k_n_spread),
            bar(edge.k_t_range, [each.k_t_range for each in edges], edge.k_t_range_spread),
            bool(known),
        )


def _limit(axes: Axes, found: StrengthMap) -> None:
    """Logarithmic axes around all points."""
    edges = [each.edge for each in found.margins]
    for which, tests, own in (
        ("x", found.tests.k_n, [each.k_n for each in edges]),
        ("y", found.tests.k_t_range, [each.k_t_range for each in edges]),
    ):
        values = np.concatenate([tests, [each for each in own if each > 0]])
        getattr(axes, f"set_{which}lim")(values.min() / MARGIN, values.max() * MARGIN)
        log_axis(axes, which)
        if values.max() < NARROW * values.min():
            axis = axes.xaxis if which == "x" else axes.yaxis
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
            axis.set_minor_locator(NullLocator())


def strength_numbers(found: StrengthMap) -> dict[str, Any]:
    """The map in the types of JSON; null for what is unknown."""
    fits = found.fits
    tests = found.tests
    return {
        "schema": SCHEMA,
        "tests": {
            "file": str(tests.path),
            "count": len(tests.life),
            "runouts": int(tests.runout.sum()),
            "outside": [
                {"line": line, "reason": reason}
                for line, reason in zip(tests.lines, tests.outside, strict=True)
                if reason
            ],
            "notes": list(tests.notes),
        },
        "units": {"length": tests.units.length, "stress": tests.units.stress},
        "life": found.life,
        "coverage": COVERAGE,
        "fits": [_fit(each) for each in fits],
        "edges": [_edge(each, fits) for each in found.margins],
        "without_edges": list(found.without_edges),
    }


def write_map(found: StrengthMap, folder: Path) -> tuple[Path, ...]:
    """Write `strength.json` and `strength.png` into a folder, made if missing.

    Raises:
        CaseError: if the folder holds results of a run.
        OutputError: if a file cannot be written.
    """
    prepare_other(folder)
    with writing(folder, "the map"):
        text = json.dumps(strength_numbers(found), indent=1, allow_nan=False)
        replace_text(folder / STRENGTH, text + "\n")
        write_strength(found, folder / PICTURE)
    return folder / STRENGTH, folder / PICTURE


def _fit(fit: LifeFit) -> dict[str, Any]:
    plane = {"coefficients": fit.coefficients.tolist(), "covariance": fit.covariance.tolist()}
    return {**plane, **{name: getattr(fit, name) for name in OF_FIT}}


def _edge(margin: Margin, fits: tuple[LifeFit, ...]) -> dict[str, Any]:
    edge = margin.edge
    place = next((n for n, each in enumerate(fits) if each is margin.fit), None)
    return {
        **{name: json_value(getattr(edge, name)) for name in OF_EDGE},
        "tests": margin.tests,
        "fit": place,
        **{name: json_value(getattr(margin, name)) for name in JUDGED},
        "survival": json_value(margin.survival and asdict(margin.survival)),
        "reason": margin.reason,
        "remarks": list(edge.remarks),
    }
