# SPDX-License-Identifier: LGPL-3.0-or-later
"""Texts that `fretfe match` prints."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.table import Table

from fretfe.errors import CaseError, ModelError
from fretfe.matching.agreement import Agreement, Reach, better
from fretfe.matching.choose import Choice
from fretfe.matching.files import write_match
from fretfe.matching.match import Comparison, Match, compare_tests, match_test
from fretfe.matching.rig import load_rig
from fretfe.matching.spreads import numbers_of
from fretfe.matching.target import Target
from fretfe.report.page.listings import plain_table, print_whole
from fretfe.report.texts import number, percent, with_error
from fretfe.results.reader import load_result

# Part of ΔK_T below which ΔK_I is none.
SMALL = 0.01


def report_match(
    directory: Path, edge: str, rig: Path, output: Path, against: tuple[Path, ...]
) -> None:
    """Find or compare tests, write their files, and print tables.

    Raises:
        FretfeError: if something is wrong; ModelError if the rig can do none of the tests.
    """
    for folder in (directory, *against):
        if output.resolve() == folder.resolve():
            raise CaseError(f"{output}: expected another folder than that of results")
    match = match_test(load_result(directory), edge, load_rig(rig))
    tests = [(str(folder), load_result(folder)) for folder in against]
    comparison = compare_tests(match, tests) if tests else None
    console = Console()
    for text in match.notes:
        console.print(f"note: {text}", highlight=False, soft_wrap=True)
    if comparison is None and not any(each.choices for each in match.shapes):
        reasons = "\n".join(f"{each.shape}: {text}" for each in match.shapes
                            for text in each.infeasible)  # fmt: skip
        raise ModelError(f"{rig}: expected bounds that a test can meet, found none\n{reasons}")
    cases = write_match(match, comparison, output)
    console.print(_component(match.target), highlight=False, soft_wrap=True)
    for table in (comparison_tables if comparison else choice_tables)(match, comparison):
        print_whole(table)
    for line in _remarks(match, comparison):
        console.print(line, highlight=False, soft_wrap=True)
    console.print(f"Cases {', '.join(map(str, cases))}", highlight=False, soft_wrap=True)


def _component(target: Target) -> str:
    return (
        f"Edge {target.name}: K_N {with_error(target.k_n, target.k_n_spread)}, "
        f"ΔK_T {with_error(target.k_t_range, target.k_t_range_spread)}, "
        f"ΔK_I {number(target.k_i_range)}, f {target.friction:g}"
    )


def choice_tables(match: Match, _: Comparison | None) -> Iterator[Table]:
    """One table for each shape with choices, which are its columns."""
    for each in match.shapes:
        if not each.choices:
            continue
        places = range(1, len(each.choices) + 1)
        headers = ["best" if n == each.best + 1 else str(n) for n in places]
        name = f"{each.shape} for edge {match.target.name}"
        table = plain_table(name, ("", *headers), text=1)
        columns = [dict(_numbers(choice, match)) for choice in each.choices]
        for label in columns[0]:
            table.add_row(label, *(column[label] for column in columns))
        yield table


def _numbers(choice: Choice, match: Match) -> Iterator[tuple[str, str]]:
    """Labels and numbers of a choice."""
    profile = choice.test.profile
    found = {
        name: _with_bar(value, choice.spreads[name])
        for name, value in numbers_of(choice.test, match.rig).items()
    }
    length, force = match.rig.units.length, match.rig.units.force
    if choice.shape == "wedge":
        angle = math.degrees(math.atan(getattr(profile, "slope", math.nan)))
        yield "angle, degrees", number(angle)
    else:
        yield f"radius, {length}", number(getattr(profile, "radius", math.nan))
    if choice.shape == "flat_rounded":
        yield f"half of the flat, {length}", number(profile.kinks[0])
    yield f"half-width a, {length}", found["half_width"]
    yield f"P, {force}/{length}", found["normal_force"]
    yield "  amplitude of P", found["normal_amplitude"]
    yield "Q, amplitude", found["shear_amplitude"]
    yield "Q/(f P), largest", found["shear_ratio"]
    yield f"d, {length}", found["slip_long"]
    yield "d/(a - b)" if choice.shape == "flat_rounded" else "d/a", found["slip_over_length"]
    yield "error of d by formula", percent(choice.test.asymptote_error, 0)
    yield "a/thickness", found["over_thickness"]
    yield f"largest p, {match.rig.units.stress}", found["peak_pressure"]
    yield "p differs by up to", percent(choice.misfit, 1)
    yield "d differs by about", percent(choice.slip_misfit, 0)


def _with_bar(value: float, spread: float) -> str:
    """A number with its error bar; four digits where there is none."""
    known = math.isfinite(spread) and spread > 0
    return with_error(value, spread) if known else number(value)


def comparison_tables(match: Match, comparison: Comparison | None) -> Iterator[Table]:
    """Factors of component and tests, and how far their tractions agree."""
    assert comparison is not None
    names = tuple(Path(each.name).name for each in comparison.agreements)
    table = plain_table(f"Edge {match.target.name} and tests", ("", "component", *names), text=1)
    tests = [each.test for each in comparison.agreements]
    rows = (("K_N", "k_n"), ("ΔK_T", "k_t_range"), ("ΔK_I", "k_i_range"))
    for label, key in rows:
        own = getattr(match.target, key)
        # Beside ΔK_T it does nothing; its relative change is noise.
        told = own if key != "k_i_range" or own > SMALL * match.target.k_t_range else 0.0
        cells = (f"{_factor(test, key)} ({_change(getattr(test, key), told)})" for test in tests)
        table.add_row(label, _factor(match.target, key), *cells)
    for n, label in enumerate(("longer slip zone", "shorter slip zone")):
        own, spread = _slip(match.target, n)
        cells = (f"{with_error(*_slip(test, n))} ({_change(_slip(test, n)[0], own)})"
                 for test in tests)  # fmt: skip
        table.add_row(label, with_error(own, spread), *cells)
    for label, name in (("p", "pressure_reach"), ("change of q", "shear_reach")):
        for n in range(2):
            reaches = [getattr(each, name)[n] for each in comparison.agreements]
            table.add_row(
                f"{label} agrees to {reaches[0].tolerance:.0%} up to", "",
                *(_reach(reach, match.target.longest_slip) for reach in reaches),
            )  # fmt: skip
    yield table


def _factor(target: Target, key: str) -> str:
    """A factor with its error bar, if it has one."""
    return _with_bar(getattr(target, key), getattr(target, f"{key}_spread", math.nan))


def _slip(target: Target, place: int) -> tuple[float, float]:
    """The longer or shorter one of the last two slip zones, and its error bar."""
    zones = sorted(zip(target.slip, target.slip_spread, strict=True), reverse=True)
    return zones[place] if all(math.isfinite(length) for length, _ in zones) else (
        target.slip[place], target.slip_spread[place]
    )  # fmt: skip


def _change(value: float, own: float) -> str:
    return f"{value / own - 1:+.1%}" if math.isfinite(value) and own else "-"


def _reach(reach: Reach, slip: float) -> str:
    whole = ", all compared" if reach.whole else ""
    return f"{number(reach.length, 3)} = {reach.length / slip:.1f} d{whole}"


def _remarks(match: Match, comparison: Comparison | None) -> Iterator[str]:
    if comparison is None:
        for each in match.shapes:
            yield from (f"{each.shape}: not possible, {text}" for text in each.infeasible)
            yield from (
                f"{each.shape}, a = {number(choice.test.half_width)}: bound by "
                f"{' and '.join(choice.binding)}"
                for choice in each.choices
                if choice.binding
            )
        return
    for agreement in comparison.agreements:
        yield from _about(agreement)
    if len(comparison.agreements) > 1:
        yield f"Nearest to the component: {Path(better(list(comparison.agreements)).name).name}"
    if match.rig.process_zone:
        yield f"Process zone: {match.rig.process_zone:g}"


def _about(agreement: Agreement) -> Iterator[str]:
    name = Path(agreement.name).name
    if agreement.remark:
        yield f"{name}: {agreement.remark}"
    yield from (f"{name}: {text}" for text in agreement.test.warnings)
