# SPDX-License-Identifier: LGPL-3.0-or-later
"""Problems of a case file, in words for the person who wrote it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import Tag, ValidationError
from pydantic_core import ErrorDetails

from fretfe.case.base import TAG, Table
from fretfe.case.friction import VARYING
from fretfe.case.loads import LOADS
from fretfe.case.model import Case, Contradiction, Key, Problem
from fretfe.case.segments import KINDS

# Characters of a text, or digits of a number, that are shown.
LONGEST = 60
EXPECTED = {
    "float_type": "a number",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "finite_number": "a finite number",
    "string_type": "text",
    "string_too_short": "text that is not empty",
    "string_too_long": "a shorter text, of at most 100 characters in a name and 1000 elsewhere",
    "string_pattern_mismatch": "a name of letters, digits, '_' and '-' that starts with a letter "
    "or '_'",
    "model_type": "a table",
    "dict_type": "a table",
    "tuple_type": "a list",
}
MISSING = "expected a value (the key is required), found none"
# Why a limit is there, where the number alone does not say it.
REASONS = {
    ("poisson", "less_than"): " (0.5 is an incompressible material, for which the stresses do not "
    "follow from the displacements; take 0.49 for rubber)",
    ("degree", "less_than_equal"): " (1 or 2)",
    ("order", "less_than_equal"): " (1 or 2)",
    ("reference_temperature", "greater_than_equal"): " (absolute zero, in degrees Celsius)",
    ("value", "greater_than_equal"): " (absolute zero, in degrees Celsius)",
    ("steps_per_cycle", "greater_than_equal"): " (fewer cannot follow a wave)",
}
COMPARISONS = {
    "greater_than": ("gt", ">"),
    "greater_than_equal": ("ge", ">="),
    "less_than": ("lt", "<"),
    "less_than_equal": ("le", "<="),
}


def complaint(source: Path, key: Key, text: str) -> str:
    """One line for one problem: the file, the key as it stands in the file, the text."""
    place = key_path(key)
    return f"{source}: {place}: {text}" if place else f"{source}: {text}"


def key_path(key: Key) -> str:
    """A key in TOML terms, with items of lists counted from 1: ``loads.a.history[segment 1]``."""
    path = ""
    for before, part in zip(("", *key), key, strict=False):
        if isinstance(part, int):
            path += f"[{'segment' if before == 'history' else 'item'} {part + 1}]"
        else:
            bare = re.fullmatch(r"[A-Za-z0-9_-]+", part)
            name = shortened(part)
            path += ("." if path else "") + (name if bare else f'"{name}"')
    return path


def field_problems(error: ValidationError, top: type[Table] = Case) -> list[Problem]:
    """The problems that the validation found, contradictions between tables included.

    Args:
        error: of the validation.
        top: the table that the whole file is; the tables of another one than a case are its fields.
    """
    problems: list[Problem] = []
    details = error.errors(include_url=False)
    misspelt = _misspelt(details)
    for detail in details:
        cause = detail.get("ctx", {}).get("error")
        if isinstance(cause, Contradiction):
            problems += cause.problems
        elif detail["loc"] in misspelt:
            if wanted := misspelt[detail["loc"]]:
                text = f"unknown key; did you mean {wanted!r}, which is required?"
                problems.append(Problem(_key(detail["loc"]), text))
        elif not _consequence(detail):
            problems.append(_problem(detail, top))
    return problems


def _misspelt(details: Iterable[ErrorDetails]) -> dict[tuple[str | int, ...], str]:
    """Places of unknown keys that a missing one of the same table was meant by, with its name.

    The places of the missing ones are among them, with an empty name: one problem, not two.
    """
    places: dict[str, list[tuple[str | int, ...]]] = {"missing": [], "extra_forbidden": []}
    for detail in details:
        places.get(detail["type"], []).append(detail["loc"])
    found: dict[tuple[str | int, ...], str] = {}
    for *table, key in places["extra_forbidden"]:
        missing = [str(name) for *other, name in places["missing"] if other == table]
        for name in get_close_matches(str(key).lower(), missing, n=1):
            if (*table, name) not in found:
                found |= {(*table, key): name, (*table, name): ""}
    return found


def _consequence(detail: ErrorDetails) -> bool:
    """True if a list is too short only because its items are not valid: these are reported."""
    minimum = detail.get("ctx", {}).get("min_length", math.inf)
    return detail["type"] == "too_short" and len(detail["input"]) >= minimum


def _key(location: Iterable[str | int]) -> Key:
    parts = (part for part in location if not (isinstance(part, str) and part.startswith(TAG)))
    return tuple(part for part in parts if part != "[key]")


def _problem(detail: ErrorDetails, top: type[Table]) -> Problem:
    key = _key(detail["loc"])
    if not detail["type"].startswith("union_tag"):
        return Problem(key, _text(detail, top))
    if not isinstance(detail["input"], Mapping):
        return Problem(key, f"expected a table, found {found(detail['input'])}")
    if "history" in key[2:]:
        return Problem(key, _without("one of the keys", KINDS, detail["input"]))
    if key[0] == "contacts":
        return Problem(key, _without("a number or one of the keys", VARYING, detail["input"]))
    return Problem((*key, "type"), _no_load_type(detail["input"]))


def _text(detail: ErrorDetails, top: type[Table]) -> str:
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    match kind:
        case "missing":
            return MISSING
        case "extra_forbidden":
            return _unknown_key(detail["loc"], top)
        case "literal_error":
            also = ", or a list of numbers" if f"{TAG}name" in detail["loc"] else ""
            return _not_among(context["expected"] + also, value)
        case "value_error":
            return str(context["error"])
        case "too_short" | "too_long":
            return _wrong_length(kind, context, value)
    if kind in COMPARISONS:
        name, symbol = COMPARISONS[kind]
        reason = REASONS.get((str(detail["loc"][-1]), kind), "")
        return f"expected a number {symbol} {context[name]:g}, found {found(value)}{reason}"
    return f"expected {EXPECTED.get(kind, detail['msg'])}, found {found(value)}"


def shortened(text: str) -> str:
    """A text of a user, without its middle if it is long."""
    if len(text) <= LONGEST:
        return text
    return f"{text[:20]}... ({len(text)} characters)"


def found(value: Any) -> str:
    """A value of a case file, as a user would write or describe it."""
    match value:
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case str():
            return f"text {shortened(value)!r}"
        case int() if abs(value) > 10**LONGEST:
            return f"a whole number of more than {LONGEST} digits"
        case Mapping():
            return (
                f"a table with the keys {', '.join(map(shortened, map(str, value)))}"
                if value
                else "{}"
            )
        case list() | tuple():
            return "a list"
    return str(value)


def _unknown_key(location: tuple[str | int, ...], top: type[Table]) -> str:
    name = str(location[-1])
    valid = list(_fields(_table(location[:-1], top)))
    near = get_close_matches(name.lower(), valid, n=3, cutoff=0.6)
    if near:
        return f"unknown key; did you mean {' or '.join(map(repr, near))}?"
    return f"unknown key, expected one of {', '.join(map(repr, valid))}"


def _fields(table: type[Table]) -> dict[str, Any]:
    """Types of the values of a table, by their keys in the file."""
    return {field.alias or name: field.annotation for name, field in table.model_fields.items()}


def _table(location: Iterable[str | int], top: type[Table]) -> type[Table]:
    """The table at a location below another one."""
    kind: Any = top
    for part in location:
        kind = _inner(kind, part)
    return next(each for each, _ in _alternatives(kind) if _is_table(each))


def _inner(kind: Any, part: str | int) -> Any:
    """Type of what is below a value of a type: an alternative by its tag, a key, or an item."""
    known = list(_alternatives(kind))
    if tagged := [each for each, tag in known if tag == part]:
        return tagged[0]
    for each, _ in known:
        if _is_table(each) and part in _fields(each):
            return _fields(each)[str(part)]
    # Of a mapping by names, or a list.
    return next(
        get_args(each)[-1 if get_origin(each) is dict else 0] for each, _ in known if get_args(each)
    )


def _is_table(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, Table)


def _alternatives(kind: Any, tag: str = "") -> Iterator[tuple[Any, str]]:
    """The types of a union, each with its tag."""
    if get_origin(kind) is Annotated:
        inner, *more = get_args(kind)
        tags = [each.tag for each in more if isinstance(each, Tag)]
        yield from _alternatives(inner, tags[0] if tags else tag)
    elif get_origin(kind) in (Union, UnionType):
        for each in get_args(kind):
            yield from _alternatives(each, tag)
    else:
        yield kind, tag


def _no_load_type(load: Mapping[str, Any]) -> str:
    allowed = f"one of {', '.join(map(repr, LOADS))}"
    return (
        _not_among(allowed, load["type"]) if "type" in load else f"expected {allowed}, found none"
    )


def _without(expected: str, keys: Iterable[str], table: Mapping[str, Any]) -> str:
    """A table has none of the keys that tell of which kind it is."""
    near = [match for name in table for match in get_close_matches(name, keys, n=1)]
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"expected {expected} {', '.join(map(repr, keys))}, found {found(table)}{hint}"


def _not_among(expected: str, value: Any) -> str:
    allowed = expected.replace("True", "true")
    names = re.findall(r"'([^']*)'", expected)
    near = get_close_matches(value.lower(), names, n=1) if isinstance(value, str) else []
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"expected {allowed}, found {found(value)}{hint}"


def _wrong_length(kind: str, context: Mapping[str, Any], value: Any) -> str:
    bound = "at least" if kind == "too_short" else "at most"
    length = context["min_length" if kind == "too_short" else "max_length"]
    entries = "entry" if length == 1 else "entries"
    return f"expected {bound} {length} {entries}, found {len(value)}"
