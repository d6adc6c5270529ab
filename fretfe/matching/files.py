# SPDX-License-Identifier: LGPL-3.0-or-later
"""The files of a match: cases of the tests, numbers, and pictures."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from fretfe._typing import Array
from fretfe.errors import CaseError
from fretfe.files import json_value, replace_text, writing
from fretfe.matching.agreement import Agreement, Reach
from fretfe.matching.casefile import FIRST_LINE, case_file
from fretfe.matching.choose import Choice, Choices, length_that_counts, pressure_of
from fretfe.matching.match import Comparison, Match
from fretfe.matching.pads import PadTest
from fretfe.matching.spreads import number_spreads, numbers_of, relative_bars
from fretfe.matching.target import Target
from fretfe.report.pictures.panels import save_png
from fretfe.report.plotting import Axes, Figure, mpl
from fretfe.report.theme import BLUE, FILE_DPI, GREEN, GREY, PALE, PURPLE, STYLE, VERMILLION
from fretfe.results.writer import prepare_other

# Inches; lengths shown over the one that counts; points of a curve.
SIZE = (6.4, 4.4)
PAIR = (6.4, 7.4)
SHOWN = 3.0
POINTS = 400
# Of tests; of more than three they begin again.
LOOKS = ((VERMILLION, "--"), (GREEN, "-."), (PURPLE, ":"))
NAMES = {"cylinder": "cylinder", "flat_rounded": "flat and rounded", "wedge": "wedge"}
NUMBERS = "match.json"
PICTURE = "match.png"
SCHEMA = {"name": "fretfe-match", "version": 2}
# Slip zones of a test, which stand in one list.
ZONES = ("slip_long", "slip_short")


@mpl.rc_context(STYLE)
def draw_choices(match: Match, path: Path) -> None:
    """Draw the pressure of the component's edge and of the best test with each shape."""
    figure = Figure(figsize=SIZE, dpi=FILE_DPI, layout="constrained")
    axes = figure.subplots()
    profile = match.target.profile
    assert profile is not None
    end = min(_shown(match), float(profile.s[-1]))
    s = np.linspace(end / POINTS, end, POINTS)
    inside = profile.s <= end
    axes.plot(profile.s[inside], profile.pressure[inside], color=BLUE, lw=2.2, label="component")
    axes.plot(s, match.target.k_n * np.sqrt(s), color=GREY, lw=0.8, label="K_N √s, common to all")
    low, high = match.target.k_n + np.array([-1.0, 1.0]) * match.target.k_n_spread
    axes.fill_between(s, low * np.sqrt(s), high * np.sqrt(s), color=PALE, lw=0.0, zorder=0)
    found = [each for each in match.shapes if each.choices]
    for each, (colour, style) in zip(found, LOOKS, strict=False):
        test = each.choices[each.best].test
        within = s < 2 * test.half_width
        axes.plot(
            s[within], pressure_of(test, s[within]), style, color=colour, label=NAMES[each.shape]
        )
    axes.set_ylim(0.0, 1.35 * float(profile.pressure[inside].max()))
    _finish(axes, match, f"p [{match.rig.units.stress}]")
    axes.set_title(f"Edge {match.target.name}: pressure, tests by closed form", loc="left")
    axes.set_xlabel(f"distance from the edge [{match.rig.units.length}]")
    figure.legend(loc="outside lower center", ncols=3)
    save_png(figure, path)


@mpl.rc_context(STYLE)
def draw_agreement(match: Match, comparison: Comparison, path: Path) -> None:
    """Draw pressure and change of shear of the component and of solved tests."""
    figure = Figure(figsize=PAIR, dpi=FILE_DPI, layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    end = _shown(match)
    profile = match.target.profile
    assert profile is not None
    for axes, values in ((upper, profile.pressure), (lower, profile.shear_change)):
        _curve(axes, profile.s, values, end, color=BLUE, lw=2.2, label="component")
    for n, each in enumerate(comparison.agreements):
        colour, style = LOOKS[n % len(LOOKS)]
        other = each.test.profile
        assert other is not None
        name = Path(each.name).name
        for axes, values, reach in (
            (upper, other.pressure, each.pressure_reach[0]),
            (lower, other.shear_change, each.shear_reach[0]),
        ):
            label = f"{name}: 5 % up to {reach.length:.3g}"
            _curve(axes, other.s, values, end, color=colour, ls=style, label=label)
            if 0 < reach.length <= end:
                height = np.interp(reach.length, other.s, values)
                axes.plot(reach.length, height, "o", ms=5, color=colour)
    _finish(upper, match, f"p [{match.rig.units.stress}]")
    _finish(lower, match, f"change of q in the cycle [{match.rig.units.stress}]")
    upper.set_title(f"Edge {match.target.name} and tests, all computed", loc="left")
    lower.set_xlabel(f"distance from the edge [{match.rig.units.length}]")
    for axes in (upper, lower):
        axes.legend(loc="lower right" if axes is upper else "upper right")
    save_png(figure, path)


def _curve(axes: Axes, s: Array, values: Array, end: float, **look: object) -> None:
    inside = s <= end
    axes.plot(s[inside], values[inside], **look)  # type: ignore[arg-type]


def _shown(match: Match) -> float:
    return SHOWN * length_that_counts(match.target, match.rig)


def _finish(axes: Axes, match: Match, label: str) -> None:
    """Slip zone shaded, process zone as a line."""
    axes.axvspan(0.0, match.target.longest_slip, color=PALE, lw=0.0, zorder=0, label="slip zone")
    if match.rig.process_zone:
        axes.axvline(match.rig.process_zone, color=GREY, lw=0.9, ls=":", label="process zone")
    axes.set_xlim(0.0, _shown(match))
    axes.set_ylim(bottom=0.0)
    axes.set_ylabel(label)


def write_match(match: Match, comparison: Comparison | None, folder: Path) -> tuple[Path, ...]:
    """Write the case of the best test with each shape, or the corrected cases; numbers; a picture.

    Returns:
        The case files.

    Raises:
        CaseError: if the folder holds results of a run, or another file that would be replaced.
        OutputError: if that fails.
    """
    texts = _corrected_cases(match, comparison) if comparison else _cases(match)
    prepare_other(folder)
    cases = tuple(folder / f"{name}.toml" for name in texts)
    with writing(folder, "the match"):
        _require_replaceable(cases)
        (folder / PICTURE).unlink(missing_ok=True)  # of another match
        for path, text in zip(cases, texts.values(), strict=True):
            replace_text(path, text)
        numbers = json.dumps(
            json_value(match_numbers(match, comparison)), indent=1, allow_nan=False
        )
        replace_text(folder / NUMBERS, numbers + "\n")
        if comparison is not None:
            draw_agreement(match, comparison, folder / PICTURE)
        elif match.target.profile is not None:
            draw_choices(match, folder / PICTURE)
    return cases


def _require_replaceable(paths: Iterable[Path]) -> None:
    """Check that files are not there, or that a match wrote them."""
    for path in paths:
        if path.exists() and not path.read_bytes().startswith(FIRST_LINE.encode()):
            raise CaseError(
                f"{path}: expected a folder in which no test would replace a file of others, found "
                f"one that does not begin with {FIRST_LINE!r}"
            )


def _cases(match: Match) -> dict[str, str]:
    return {
        each.shape: case_file(each.choices[each.best].test, match.rig, _title(match, each.shape))
        for each in match.shapes
        if each.choices
    }


def _corrected_cases(match: Match, comparison: Comparison) -> dict[str, str]:
    return {
        name: case_file(test, match.rig, _title(match, Path(agreement.name).name))
        for name, agreement, test in zip(
            corrected_names(comparison), comparison.agreements, comparison.corrected, strict=True
        )
    }


def corrected_names(comparison: Comparison) -> tuple[str, ...]:
    """Names of the corrected cases: those of the folders of the tests."""
    names = [Path(each.name).name for each in comparison.agreements]
    return tuple(
        f"{name}_corrected" if names.count(name) == 1 else f"{name}_corrected_{n + 1}"
        for n, name in enumerate(names)
    )


def _title(match: Match, what: str) -> str:
    return f"Test for edge {match.target.name}: {what}"


def match_numbers(match: Match, comparison: Comparison | None) -> dict[str, Any]:
    """All numbers, as docs/match.md has them; NaN where unknown."""
    length = length_that_counts(match.target, match.rig)
    return {
        "schema": SCHEMA,
        "units": match.rig.units.model_dump(),
        "component": _edge(match.target),
        "rig": match.rig.model_dump(mode="json"),
        "length_that_counts": length,
        "notes": list(match.notes),
        "shapes": [_shape(each, match) for each in match.shapes],
        "tests": [
            _agreement(agreement, test, match)
            for agreement, test in zip(comparison.agreements, comparison.corrected, strict=True)
        ]
        if comparison
        else [],
    }


def _edge(target: Target) -> dict[str, Any]:
    left_out = ("profile", "warnings", "contact")
    numbers = {key: value for key, value in vars(target).items() if key not in left_out}
    peak = target.profile.peak if target.profile else math.nan
    return {
        **numbers,
        "edge": target.name,
        "peak": peak,
        "warnings": [asdict(each) for each in target.warnings],
    }


def _shape(choices: Choices, match: Match) -> dict[str, Any]:
    return {
        "shape": choices.shape,
        "best": choices.best if choices.choices else None,
        "infeasible": list(choices.infeasible),
        "choices": [_choice(each, match) for each in choices.choices],
    }


def _choice(choice: Choice, match: Match) -> dict[str, Any]:
    return {
        **_pad(choice.test, choice.spreads, match),
        "misfit": choice.misfit,
        "slip_misfit": choice.slip_misfit,
        "binding": list(choice.binding),
    }


def _pad(test: PadTest, spreads: Mapping[str, float], match: Match) -> dict[str, Any]:
    """Dimensions of a pad, and the numbers of its test with their error bars."""
    shape = {
        key: getattr(test.profile, key)
        for key in ("radius", "flat_half_width", "slope")
        if hasattr(test.profile, key)
    }
    found: dict[str, Any] = dict(shape)
    for suffix, values in (("", numbers_of(test, match.rig)), ("_spread", spreads)):
        zones = [values[name] for name in ZONES]
        others = {name: each for name, each in values.items() if name not in ZONES}
        found |= {f"{name}{suffix}": each for name, each in others.items()}
        found[f"slip{suffix}"] = zones
    return found


def _agreement(agreement: Agreement, test: PadTest, match: Match) -> dict[str, Any]:
    # Corrected by wanted over found: both have error bars.
    bars = relative_bars(agreement.target, agreement.test)
    spreads = number_spreads(test, bars, match.rig)
    return {
        "name": agreement.name,
        "edge": _edge(agreement.test),
        "pressure": _reaches(agreement.pressure_reach),
        "shear": _reaches(agreement.shear_reach),
        "remark": agreement.remark,
        "corrected": _pad(test, spreads, match),
    }


def _reaches(reaches: Iterable[Reach]) -> list[dict[str, Any]]:
    return [vars(each) for each in reaches]
