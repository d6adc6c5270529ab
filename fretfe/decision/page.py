# SPDX-License-Identifier: LGPL-3.0-or-later
"""An assessment as a page that is read in a minute, and as JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path

from fretfe.decision.assessment import Assessment, EdgeAssessment, Judgement
from fretfe.decision.record import SCHEMA, assessment_numbers
from fretfe.decision.short_cracks import Arrest
from fretfe.decision.texts import answer, details, known_criteria, margin_tables
from fretfe.errors import OutputError
from fretfe.files import replace_text, writing
from fretfe.report.page.html import render_page
from fretfe.report.plotting import Axes, Figure, NullFormatter
from fretfe.report.texts import rounded
from fretfe.report.theme import (
    BLUE,
    GREY,
    ORANGE,
    SINGLE,
    VERMILLION,
    Plot,
    legend_above,
    log_axis,
    make_plot,
)
from fretfe.results.quantities import unit
from fretfe.results.writer import prepare_other


def write_assessment(found: Assessment, folder: Path) -> tuple[Path, ...]:
    """Write `assessment.json` and `assessment.html` into a folder, made if missing.

    Raises:
        CaseError: if the folder holds results of a run.
        OutputError: if a file cannot be written, or the page would replace that of another.
    """
    prepare_other(folder)
    page, numbers = folder / "assessment.html", folder / "assessment.json"
    if page.exists() and not _is_assessment(numbers):
        raise OutputError(
            f"{page}: expected none, or one of fretfe with {numbers.name} beside it, found another "
            "file: name another folder"
        )
    with writing(folder, "the assessment"):
        text = json.dumps(assessment_numbers(found), indent=1, allow_nan=False)
        replace_text(numbers, text + "\n")
        replace_text(page, _page(found))
    return page, numbers


def _is_assessment(numbers: Path) -> bool:
    """True if a file has the numbers of an assessment, as a page of fretfe has them beside it."""
    try:
        schema = json.loads(numbers.read_text("utf-8"))["schema"]
        return bool(schema["name"] == SCHEMA["name"])
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _page(found: Assessment) -> str:
    plots: list[Plot] = []
    if found.worst is not None:
        edge = found.worst[0]
        plots.append(_margin_plot(found, edge))
        if edge.arrest is not None:
            plots.append(_crack_plot(found, edge, edge.arrest))
    return render_page(
        "assessment.html.j2",
        title=f"Assessment of {found.result}",
        material=str(found.material),
        source=found.source,
        sentences=list(answer(found)),
        margins=margin_tables(found),
        plots=plots,
        details=list(details(found)),
    )


def _name(edge: EdgeAssessment) -> str:
    return f"{edge.contact} {edge.edge}, {edge.body}"


def _margin_plot(found: Assessment, worst: EdgeAssessment) -> Plot:
    """Margins of the worst edge with their intervals, those of the others as dots."""
    shown = known_criteria(found)[::-1]
    own = [worst.of(each) for each in shown]
    others = [[edge.of(each).margin for edge in found.edges if edge is not worst] for each in shown]
    ranges = [found.range_of(worst, each) for each in shown]

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        known = [x for row in others for x in row]
        known += [x for pair in ranges for x in pair]
        known += [x for each in own for x in (each.margin, each.low, each.high)]
        finite = [x for x in known if math.isfinite(x) and x > 0]
        # Room for 1, and at the right for those that no factor breaks.
        axes.set_xlim(min(0.8, 0.9 * min(finite)), min(max(2, 1.3 * max(finite)), 100))
        axes.set_ylim(-0.6, len(shown) - 0.4)
        log_axis(axes, "x")
        axes.axvline(1, color=VERMILLION, lw=1.0, ls="--")
        for row, (judgement, dots, ends) in enumerate(zip(own, others, ranges, strict=True)):
            axes.plot(dots, [row] * len(dots), ".", color=GREY, ms=4, alpha=0.6)
            if math.isfinite(ends[0]):
                axes.plot(ends, [row - 0.22] * 2, color=ORANGE, lw=2.4, solid_capstyle="butt")
            _bar(axes, row, judgement)
        axes.set_yticks(range(len(shown)), [each.value for each in shown])
        axes.set_xlabel("margin: factor of all stresses")

    more = f"; orange: over {len(found.others) + 1} results" if found.others else ""
    return make_plot(
        "margins",
        f"Margins at {_name(worst)}",
        f"Blue: this edge with error bars{more}; grey: all other edges; at the right side and "
        "marked by an arrow: no factor breaks the criterion. Left of the dashed line a criterion "
        "is not kept.",
        SINGLE,
        draw,
    )


def _bar(axes: Axes, row: int, judgement: Judgement) -> None:
    """A margin with its interval; without an end, to the side of the panel."""
    if judgement.reason:
        return
    right = axes.get_xlim()[1]
    margin = min(judgement.margin, right)
    if math.isfinite(judgement.low):
        axes.plot([judgement.low, min(judgement.high, right)], [row] * 2, color=BLUE, lw=1.6)
    axes.plot(margin, row, "o" if margin < right else ">", color=BLUE, ms=5, clip_on=False)


def _crack_plot(found: Assessment, edge: EdgeAssessment, arrest: Arrest) -> Plot:
    """ΔK of the cracks that stop last and that set the margin, with their thresholds."""
    units, deepest, critical = found.units, arrest.deepest, arrest.critical
    shown = [deepest] if critical.angle == deepest.angle else [deepest, critical]

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for crack, color in zip(shown, (BLUE, ORANGE), strict=False):
            axes.plot(crack.lengths, crack.ranges, color=color, label=f"ΔK at {crack.angle:g}°")
            axes.plot(crack.lengths, crack.threshold, color=color, ls="--", label="threshold")
        if 0 < deepest.stop < math.inf:
            axes.axvline(deepest.stop, color=GREY, lw=0.8, ls=":", label="stops")
        axes.set_xlim(deepest.lengths[0], max(each.lengths[-1] for each in shown))
        values = [x for each in shown for x in (*each.ranges, *each.threshold) if x > 0]
        axes.set_ylim(max(0.8 * min(values), 1e-3 * max(values)), 1.2 * max(values))
        log_axis(axes, "x")
        log_axis(axes, "y")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.set_xlabel(f"length of the crack [{units.length}]")
        axes.set_ylabel(f"ΔK [{unit('k_t', units, solid=False)}]")
        legend_above(axes, 3)

    ends = "a crack grows where ΔK is above the threshold, and stops where it is below"
    angles = (
        f"At {deepest.angle:g}°, where cracks stop last, and {critical.angle:g}°, where they are "
        "the first to grow through as the stress rises"
        if len(shown) > 1
        else f"At {deepest.angle:g}°, the angle least likely to stop them"
    )
    return make_plot(
        "cracks",
        f"Cracks at {_name(edge)}",
        f"{angles}: {ends}. The threshold falls for cracks that are not long against a0 = "
        f"{rounded(arrest.a0)} {units.length}.",
        SINGLE,
        draw,
    )
