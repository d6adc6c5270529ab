# SPDX-License-Identifier: LGPL-3.0-or-later
"""The files of a match: cases of the tests, numbers, and pictures."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from fretfe.errors import CaseError, OutputError
from fretfe.matching.agreement import Agreement, Reach
from fretfe.matching.casefile import FIRST_LINE, case_file, pad_half_width
from fretfe.matching.choose import Choice, Choices, length_that_counts
from fretfe.matching.match import Comparison, Match
from fretfe.matching.pads import PadTest
from fretfe.matching.target import Target
from fretfe.results.files import disk_reason, replace_text
from fretfe.results.writer import prepare_other

NUMBERS, PICTURE = "match.json", "match.png"
SCHEMA = {"name": "fretfe-match", "version": 1}


def write_match(match: Match, comparison: Comparison | None, folder: Path) -> tuple[Path, ...]:
    """Write the case of the best test with each shape, or the corrected cases; numbers; a picture.

    Returns:
        The case files.

    Raises:
        CaseError: if the folder holds results of a run, or another file that would be replaced.
        OutputError: if that fails.
    """
    from fretfe.matching.figure import draw_agreement, draw_choices

    texts = _corrected_cases(match, comparison) if comparison else _cases(match)
    prepare_other(folder)
    cases = tuple(folder / f"{name}.toml" for name in texts)
    try:
        _require_replaceable(cases)
        (folder / PICTURE).unlink(missing_ok=True)  # of another match
        for path, text in zip(cases, texts.values(), strict=True):
            replace_text(path, text)
        numbers = json.dumps(_plain(match_numbers(match, comparison)), indent=1, allow_nan=False)
        replace_text(folder / NUMBERS, numbers + "\n")
        if comparison is not None:
            draw_agreement(match, comparison, folder / PICTURE)
        elif match.target.profile is not None:
            draw_choices(match, folder / PICTURE)
    except OSError as error:
        raise OutputError(f"{folder}: cannot write the match: {disk_reason(error)}") from error
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
    """All numbers, as docs/results.md has them; NaN where unknown."""
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
            _agreement(agreement, test)
            for agreement, test in zip(comparison.agreements, comparison.corrected, strict=True)
        ]
        if comparison
        else [],
    }


def _edge(target: Target) -> dict[str, Any]:
    left_out = ("profile", "warnings", "contact")
    numbers = {key: value for key, value in vars(target).items() if key not in left_out}
    peak = target.profile.peak if target.profile else math.nan
    return {**numbers, "edge": target.name, "peak": peak, "warnings": list(target.warnings)}


def _shape(choices: Choices, match: Match) -> dict[str, Any]:
    return {
        "shape": choices.shape,
        "best": choices.best if choices.choices else None,
        "infeasible": list(choices.infeasible),
        "choices": [_choice(each, match) for each in choices.choices],
    }


def _choice(choice: Choice, match: Match) -> dict[str, Any]:
    test = choice.test
    return {
        **_pad(test),
        "normal_force_spread": choice.force_spread,
        "shear_amplitude_spread": choice.shear_spread,
        "half_width": test.half_width,
        "peak_pressure": test.peak_pressure,
        "shear_ratio": test.shear_ratio,
        "slip": test.slip,
        "slip_over_length": test.slip[0] / test.governing_length,
        "asymptote_error": test.asymptote_error,
        "over_thickness": test.half_width / match.rig.specimen.thickness,
        "over_pad": test.half_width / pad_half_width(test, match.rig),
        "misfit": choice.misfit,
        "slip_misfit": choice.slip_misfit,
        "binding": list(choice.binding),
    }


def _pad(test: PadTest) -> dict[str, Any]:
    shape = {
        key: getattr(test.profile, key)
        for key in ("radius", "flat_half_width", "slope")
        if hasattr(test.profile, key)
    }
    return {
        **shape,
        "normal_force": test.normal_force,
        "normal_amplitude": test.normal_amplitude,
        "shear_amplitude": test.shear_amplitude,
    }


def _agreement(agreement: Agreement, test: PadTest) -> dict[str, Any]:
    return {
        "name": agreement.name,
        "edge": _edge(agreement.test),
        "pressure": _reaches(agreement.pressure_reach),
        "shear": _reaches(agreement.shear_reach),
        "remark": agreement.remark,
        "corrected": _pad(test),
    }


def _reaches(reaches: Iterable[Reach]) -> list[dict[str, Any]]:
    return [vars(each) for each in reaches]


def _plain(value: Any) -> Any:
    """Plain types of JSON; null for what is not known."""
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
