# SPDX-License-Identifier: LGPL-3.0-or-later
"""Commands about edges and what tests them: `fretfe match` and `strength`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fretfe.cli.options import AsJson, Results, examples, positive
from fretfe.environment import rank_from_environment
from fretfe.report.texts import (
    MISSING,
    number,
    percent,
    plain_table,
    print_whole,
    rounded,
    with_error,
)

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe.matching.agreement import Reach
    from fretfe.matching.choose import Choice
    from fretfe.matching.match import Comparison, Match
    from fretfe.matching.target import Target
    from fretfe.results.model import Result
    from fretfe.strength.lives import StrengthTests
    from fretfe.strength.margins import Margin, StrengthMap

# Part of ΔK_T below which ΔK_I is none.
SMALL = 0.01
# Tests that are listed with the reason why they are left out.
MOST_LEFT_OUT = 8

MATCH_EXAMPLES = examples(
    "fretfe match dovetail --edge left.right --rig rig.toml -o tests",
    "fretfe run tests/flat_rounded.toml -o flat",
    "fretfe match dovetail --edge left.right --rig rig.toml --against flat -o overlay",
)


def match(
    directory: Results,
    edge: Annotated[
        str,
        typer.Option(
            help="Edge of the component: CONTACT.left or CONTACT.right, of solids "
            "CONTACT.FRONT.STATION; CONTACT or CONTACT.FRONT for the worst one there."
        ),
    ],
    rig: Annotated[Path, typer.Option(help="Rig file (TOML): what the laboratory can do.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for cases and numbers.")],
    against: Annotated[
        list[Path] | None,
        typer.Option(
            help="Folder with results of a test to lay over the component; can be given several "
            "times.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Find laboratory tests with the edge factors of a component.

    With --against, compare solved tests with the component, and correct their loads.
    """
    if rank_from_environment() > 0:
        return

    from fretfe.errors import CaseError, ModelError
    from fretfe.matching.files import write_match
    from fretfe.matching.match import compare_tests, match_test
    from fretfe.matching.rig import load_rig
    from fretfe.results.reader import load_result

    for folder in (directory, *(against or ())):
        if output.resolve() == folder.resolve():
            raise CaseError(f"{output}: expected another folder than that of results")
    found = match_test(load_result(directory), edge, load_rig(rig))
    tests = [(str(folder), load_result(folder)) for folder in against or ()]
    comparison = compare_tests(found, tests) if tests else None
    for text in found.notes:
        print(f"note: {text}")
    if comparison is None and not any(each.choices for each in found.shapes):
        reasons = "\n".join(f"{each.shape}: {text}" for each in found.shapes
                            for text in each.infeasible)  # fmt: skip
        raise ModelError(f"{rig}: expected bounds that a test can meet, found none\n{reasons}")
    cases = write_match(found, comparison, output)
    print(_component(found.target))
    for table in (_comparison_tables if comparison else _choice_tables)(found, comparison):
        print_whole(table)
    for line in _match_remarks(found, comparison):
        print(line)
    print(f"Cases {', '.join(map(str, cases))}")


def _component(target: Target) -> str:
    return (
        f"Edge {target.name}: K_N {with_error(target.k_n, target.k_n_spread)}, "
        f"ΔK_T {with_error(target.k_t_range, target.k_t_range_spread)}, "
        f"ΔK_I {number(target.k_i_range)}, f {target.friction:g}"
    )


def _choice_tables(match: Match, _: Comparison | None) -> Iterator[Table]:
    """One table for each shape with choices, which are its columns."""
    for each in match.shapes:
        if not each.choices:
            continue
        places = range(1, len(each.choices) + 1)
        headers = ["best" if n == each.best + 1 else str(n) for n in places]
        name = f"{each.shape} for edge {match.target.name}"
        # Bars are nearly the same of all choices, in per cent: one column has them.
        table = plain_table(name, ("", *headers, "± best"), text=1)
        columns = [dict(_choice_numbers(choice, match)) for choice in each.choices]
        bars = dict(_choice_bars(each.choices[each.best], match))
        for label in columns[0]:
            table.add_row(label, *(column[label] for column in columns), bars.get(label, ""))
        yield table


# Numbers with error bars, and what the table calls them.
LABELS = {
    "half_width": "half-width a, {length}",
    "normal_force": "P, {force}/{length}",
    "normal_amplitude": "  amplitude of P",
    "shear_amplitude": "Q, amplitude",
    "shear_ratio": "Q/(f P), largest",
    "slip_long": "d, {length}",
    "slip_over_length": "d/{inner}",
    "over_thickness": "a/thickness",
    "peak_pressure": "largest p, {stress}",
}


# Of these a laboratory sets so many digits.
LOADS = ("normal_force", "normal_amplitude", "shear_amplitude")


def _label(name: str, choice: Choice, match: Match) -> str:
    inner = "(a - b)" if choice.shape == "flat_rounded" else "a"
    return LABELS[name].format(inner=inner, **match.rig.units.model_dump())


def _choice_bars(choice: Choice, match: Match) -> Iterator[tuple[str, str]]:
    """Error bars of a choice by labels, relative."""
    from fretfe.matching.spreads import numbers_of

    for name, value in numbers_of(choice.test, match.rig).items():
        if name in LABELS and choice.spreads[name] > 0 and value:
            yield _label(name, choice, match), percent(choice.spreads[name] / abs(value), 1)


def _choice_numbers(choice: Choice, match: Match) -> Iterator[tuple[str, str]]:
    """Labels and numbers of a choice."""
    from fretfe.matching.spreads import numbers_of

    profile, length = choice.test.profile, match.rig.units.length
    if choice.shape == "wedge":
        angle = math.degrees(math.atan(getattr(profile, "slope", math.nan)))
        yield "angle, degrees", number(angle)
    else:
        yield f"radius, {length}", number(getattr(profile, "radius", math.nan))
    if choice.shape == "flat_rounded":
        yield f"half flat, {length}", number(profile.kinks[0])
    for name, value in numbers_of(choice.test, match.rig).items():
        if name in LABELS:
            yield _label(name, choice, match), rounded(value, 4 if name in LOADS else 3)
    yield "error of d", percent(choice.test.asymptote_error, 0)
    yield "p differs by up to", percent(choice.misfit, 1)
    yield "d differs by about", percent(choice.slip_misfit, 0)


def _with_bar(value: float, spread: float) -> str:
    """A number with its error bar; four digits where there is none."""
    known = math.isfinite(spread) and spread > 0
    return with_error(value, spread) if known else number(value)


def _comparison_tables(match: Match, comparison: Comparison | None) -> Iterator[Table]:
    """Factors of component and test, and how far their tractions agree, for each test."""
    assert comparison is not None
    for agreement in comparison.agreements:
        title = f"Edge {match.target.name} and a test"
        table = plain_table(title, ("", "component", Path(agreement.name).name), text=1)
        test = agreement.test
        for label, key in (("K_N", "k_n"), ("ΔK_T", "k_t_range"), ("ΔK_I", "k_i_range")):
            own = getattr(match.target, key)
            # Beside ΔK_T it does nothing; its relative change is noise.
            told = own if key != "k_i_range" or own > SMALL * match.target.k_t_range else 0.0
            cell = f"{_factor(test, key)} ({_change(getattr(test, key), told)})"
            table.add_row(label, _factor(match.target, key), cell)
        for n, label in enumerate(("longer slip zone", "shorter slip zone")):
            own, spread = _slip(match.target, n)
            cell = f"{with_error(*_slip(test, n))} ({_change(_slip(test, n)[0], own)})"
            table.add_row(label, with_error(own, spread), cell)
        for label, reaches in (
            ("p", agreement.pressure_reach), ("change of q", agreement.shear_reach)
        ):  # fmt: skip
            for reach in reaches:
                text = f"{label} within {reach.tolerance:.0%} up to"
                table.add_row(text, "", _reach(reach, match.target.longest_slip))
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


def _match_remarks(match: Match, comparison: Comparison | None) -> Iterator[str]:
    from fretfe.caution import grouped
    from fretfe.matching.agreement import better

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
        warnings = (group.line for group in grouped(agreement.test.warnings))
        told = filter(None, (agreement.remark, *warnings))
        yield from (f"{Path(agreement.name).name}: {text}" for text in told)
    if len(comparison.agreements) > 1:
        yield f"Nearest to the component: {Path(better(list(comparison.agreements)).name).name}"
    if match.rig.process_zone:
        yield f"Process zone: {match.rig.process_zone:g}"


STRENGTH_EXAMPLES = examples(
    "fretfe strength tests.csv dovetail --life 1e6",
    "fretfe strength tests.csv dovetail pad --life 2e5 -o map",
)


def strength(
    tests: Annotated[
        Path, typer.Argument(metavar="TESTS", help="CSV file with tests.", show_default=False)
    ],
    results: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR...",
            help="Folders with results, or case files that half-planes can solve.",
            show_default=False,
        ),
    ],
    life: Annotated[
        float,
        typer.Option(parser=positive, help="Cycles that the component has to reach."),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Folder for figure and numbers; made if missing.",
            show_default=False,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:  # fmt: skip
    """Compare component edges with the strength of tests."""
    if rank_from_environment() > 0:
        return
    import json

    from fretfe.api import strength_map
    from fretfe.strength.files import strength_numbers, write_map

    found = strength_map(tests, [_component_result(each) for each in results], life)
    if as_json:
        print(json.dumps(strength_numbers(found), indent=1, allow_nan=False))
    else:
        shown = _shown(found)
        print_whole(_strength_table(found, shown))
        for text in _strength_texts(found, shown):
            print(text)
    if output is not None:
        files = write_map(found, output)
        if not as_json:
            names = " and ".join(path.name for path in files)
            print(f"{names} in {output}")


def _component_result(path: Path) -> Result:
    """The result in a folder, or that of a case by half-planes, which takes a second or two."""
    from fretfe.api import load_case, load_result, run

    return run(load_case(path), "halfplane") if path.suffix == ".toml" else load_result(path)


def _shown(found: StrengthMap) -> list[Margin]:
    """All edges; of a front of solids the station with the smallest margin or largest ΔK."""
    fronts: dict[str, list[Margin]] = {}
    for each in found.margins:
        fronts.setdefault(each.edge.name, []).append(each)
    return [
        min(own, key=lambda each: (bool(each.reason), each.margin, -each.edge.k_t_range))
        for own in fronts.values()
    ]


def _strength_table(found: StrengthMap, shown: Sequence[Margin]) -> Table:
    from rich.markup import escape

    from fretfe.results.quantities import unit

    k_n, k_t = (unit(kind, found.tests.units, solid=False) for kind in ("k_n", "k_t"))
    title = escape(f"Strength at {number(found.life, 6)} cycles, K_N in {k_n}, ΔK_T in {k_t}")
    headers = ("edge", "K_N", "ΔK_T", "strength", "margin", "95 % of parts")
    table = plain_table(title, headers, text=1)
    for each in shown:
        edge = each.edge
        interval = f"{rounded(each.low)} to {rounded(each.high)}" if not each.reason else MISSING
        station = f" {edge.station}" if len(found.margins) > len(shown) else ""
        table.add_row(
            escape(edge.name) + station,
            with_error(edge.k_n, edge.k_n_spread),
            with_error(edge.k_t_range, edge.k_t_range_spread),
            with_error(each.strength, each.strength_spread),
            rounded(each.margin),
            interval,
        )
    return table


def _strength_texts(found: StrengthMap, shown: Sequence[Margin]) -> list[str]:
    """Fits, what is unknown and why, remarks; what several edges share once."""
    from fretfe.strength.margins import survival_text

    texts = []
    for fit in found.fits:
        c0, c1, c2 = fit.coefficients
        texts.append(
            f"log10 N = {c0:.4g} {c1:+.3g} log10 ΔK_T {c2:+.3g} log10 K_N, scatter "
            f"{fit.scatter:.2g}, from {fit.failures} failures and {fit.runouts} run-outs"
        )
    texts += [*_outside_texts(found.tests), *(f"Note: {text}" for text in found.tests.notes)]
    count = int(found.tests.inside.sum())
    said: dict[str, list[str]] = {}
    for each in shown:
        if each.reason:
            counted = "" if each.survival is None else f"; {survival_text(each.survival)}"
            said.setdefault(f"unknown, because {each.reason}{counted}", []).append(each.edge.name)
        if each.tests and each.tests < count:
            text = f"{each.tests} of {count} tests have its friction and material"
            said.setdefault(text, []).append(each.edge.name)
        for remark in each.edge.remarks:
            said.setdefault(remark, []).append(each.edge.name)
    for result in found.without_edges:
        said.setdefault("the result has no edges whose factors are known", []).append(result)
    texts += [f"Note: {', '.join(names)}: {text}" for text, names in said.items()]
    known = [each for each in shown if not each.reason]
    for result in dict.fromkeys(each.edge.result for each in known):
        own = (each for each in known if each.edge.result == result)
        worst = min(own, key=lambda each: each.margin)
        texts.append(_expectation(worst, found.life))
        if worst.survival is not None:
            texts.append(f"{result}: {survival_text(worst.survival)}")
    return texts


def _outside_texts(tests: StrengthTests) -> Iterator[str]:
    """Tests that are left out, each with its reason."""
    left_out = [each for each in zip(tests.lines, tests.outside, strict=True) if each[1]]
    for line, reason in left_out[:MOST_LEFT_OUT]:
        yield f"Note: line {line} of {tests.path.name} is left out: {reason}"
    if len(left_out) > MOST_LEFT_OUT:
        yield f"Note: {len(left_out) - MOST_LEFT_OUT} more are left out: see strength.json"


def _expectation(worst: Margin, life: float) -> str:
    """Survival or failure that a component with this smallest margin may expect, and why."""
    edge = worst.edge
    expected = "may fail within or survive"
    if worst.low > 1:
        expected = "is expected to survive"
    elif worst.high < 1:
        expected = "is expected to fail within"
    return (
        f"{edge.result} {expected} {number(life, 6)} cycles, because at {edge.contact} "
        f"{edge.edge} ΔK_T is {rounded(edge.k_t_range)}, and half of all specimens reach them at "
        f"{rounded(worst.strength)} with this K_N, {rounded(edge.k_n)}: margin "
        f"{rounded(worst.margin)}, of 95 % of parts {rounded(worst.low)} to {rounded(worst.high)}"
    )
