# SPDX-License-Identifier: LGPL-3.0-or-later
"""The cases of a sweep: all combinations of the values of the keys that vary."""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fretfe.case import Case, changed
from fretfe.case.overrides import parse_value, plain_value, split_assignment
from fretfe.errors import CaseError
from fretfe.loads import build_history

MOST_VARIANTS = 10_000
# Values of a range are typed numbers: without the last digits of their round-off.
DIGITS = 12
OPTION = "--vary"


@dataclass(frozen=True)
class Variant:
    """One case of a sweep, and the values that distinguish it, by key."""

    values: Mapping[str, Any]
    case: Case


def parse_ranges(texts: Iterable[str]) -> dict[str, tuple[Any, ...]]:
    """Keys and values of texts like ``contacts.main.friction=0.1:0.6:11``.

    Args:
        texts: ``KEY=START:STOP:COUNT``, evenly spaced with both ends, or ``KEY=A,B,C``.

    Raises:
        CaseError: a text is not of this form, or a key is there twice.
    """
    ranges: dict[str, tuple[Any, ...]] = {}
    for text in texts:
        key, values = split_assignment(text, OPTION)
        if key in ranges:
            raise CaseError(f"{OPTION}: expected each key once, found {key!r} twice")
        ranges[key] = _values(key, values)
    return ranges


def _values(key: str, text: str) -> tuple[Any, ...]:
    if ":" in text and not re.search(r"""["'\[{]""", text):
        return _spaced(key, text)
    try:
        found = tuple(tomllib.loads(f"values = [{text}]")["values"])
    except tomllib.TOMLDecodeError:  # bare words
        found = tuple(parse_value(part.strip()) for part in text.split(","))
    if not found or "" in found:
        raise CaseError(f"{OPTION} {key}: expected A,B,C or START:STOP:COUNT, found {text!r}")
    return found


def _spaced(key: str, text: str) -> tuple[Any, ...]:
    parts = text.split(":")
    try:
        start, stop, count = float(parts[0]), float(parts[1]), int(parts[2])
        valid = len(parts) == 3 and count >= 2 and math.isfinite(start) and math.isfinite(stop)
    except (ValueError, IndexError):
        valid = False
    if not valid:
        raise CaseError(
            f"{OPTION} {key}: expected START:STOP:COUNT, two numbers and a count of 2 or more, "
            f"found {text!r}"
        )
    if count > MOST_VARIANTS:
        raise CaseError(_too_many(count))
    values = [float(f"{value:.{DIGITS}g}") for value in np.linspace(start, stop, count)]
    whole_numbers = all(re.fullmatch(r"[+-]?\d+", part) for part in parts)
    if whole_numbers and all(value.is_integer() for value in values):
        return tuple(int(value) for value in values)
    return tuple(values)


def make_variants(case: Case, ranges: Mapping[str, Sequence[Any]]) -> tuple[Variant, ...]:
    """All combinations, the last key varying fastest.

    Args:
        case: the case with all that does not vary.
        ranges: values by key.

    Raises:
        CaseError: nothing varies, there are too many combinations, or one of them is not a valid
            case with a valid load history.
    """
    values = {key: tuple(map(plain_value, sequence)) for key, sequence in ranges.items()}
    if not values or not all(values.values()):
        raise CaseError(f"{case.source}: a sweep needs a key that varies, and a value for each key")
    count = math.prod(len(each) for each in values.values())
    if count > MOST_VARIANTS:
        raise CaseError(_too_many(count))
    variants = []
    for combination in itertools.product(*values.values()):
        chosen = dict(zip(values, combination, strict=True))
        variant = Variant(chosen, changed(case, chosen))
        build_history(variant.case)
        variants.append(variant)
    return tuple(variants)


def _too_many(count: int) -> str:
    return f"{OPTION}: expected at most {MOST_VARIANTS} variants, found {count}"
