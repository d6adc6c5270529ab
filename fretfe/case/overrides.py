# SPDX-License-Identifier: LGPL-3.0-or-later
"""Values of a case that are set from outside its file: ``loads.shear.amplitude=120``.

A path is the keys joined by dots; items of lists are numbered from 1, ``*`` stands for every key of
a table or item of a list. A key of a segment may be given as if it were one of the load, where only
one segment of its history has it.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from fretfe.case.base import TAG
from fretfe.case.loads import LOADS
from fretfe.case.model import Case
from fretfe.case.segments import KINDS, segment_kind
from fretfe.case.toml_file import MOST_KEYS, TOO_DEEP, TOO_MANY, key_count, plain_value
from fretfe.errors import CaseError

EVERY = "*"
# Tables that may be missing in a file: a value in them makes them.
MADE = {(name,) for name in Case.model_fields} | {("geometry", "parameters")}


def parse_assignments(texts: Iterable[str], option: str = "--set") -> dict[str, Any]:
    """Paths and values of texts like ``loads.shear.amplitude=120``.

    Args:
        texts: one assignment each.
        option: that they were given with, for messages.

    Raises:
        CaseError: a text is not of this form, or a key is there twice.
    """
    found: dict[str, Any] = {}
    for text in texts:
        path, value = split_assignment(text, option)
        if path in found:
            raise CaseError(f"{option}: expected each key once, found {path!r} twice")
        found[path] = parse_value(value)
    return found


def split_assignment(text: str, option: str) -> tuple[str, str]:
    """Path, and text of the value, of one assignment."""
    path, equals, value = text.partition("=")
    if not (equals and path.strip() and all(path.strip().split("."))):
        raise CaseError(
            f"{option}: expected KEY=VALUE with a key like contacts.main.friction, found {text!r}"
        )
    return path.strip(), value.strip()


def parse_value(text: str) -> Any:
    """A value as TOML has it: number, true, "text", list, table. What is no TOML is text."""
    try:
        data = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return data["value"] if len(data) == 1 else text


def with_overrides(
    data: Mapping[str, Any], overrides: Mapping[str, Any], source: Path
) -> dict[str, Any]:
    """The tables of a case file with values replaced or added.

    Args:
        data: tables and values as TOML has them; not changed.
        overrides: values by path.
        source: of the data, for messages.

    Raises:
        CaseError: a path leads through a key that is not there, leaves open which segment is
            meant, or replaces what another one has set; all such paths are listed. Whether keys and
            values are valid is not checked.
    """
    changed = _plain(data, source)
    problems = []
    before: dict[tuple[str, ...], str] = {}
    for path, value in overrides.items():
        try:
            for keys in _each(changed, tuple(path.split("."))):
                whole = _full_path(changed, keys)
                _require_new(whole, before)
                before[whole] = path
                _set(changed, whole, _plain(value, source))
        except _NoPlace as error:
            problems.append(f"{source}: {path}: {error}")
    if problems:
        raise CaseError("\n".join(problems))
    return changed


def _plain(value: Any, source: Path) -> Any:
    try:
        if (keys := key_count(value)) > MOST_KEYS:
            raise CaseError(f"{source}: {TOO_MANY.format(keys)}")
        return plain_value(value)
    except RecursionError:
        raise CaseError(f"{source}: {TOO_DEEP}") from None


def _require_new(path: tuple[str, ...], before: Mapping[tuple[str, ...], str]) -> None:
    """Raise if a value would replace one that was set before, or a table in which one was set."""
    for other, text in before.items():
        if other[: len(path)] == path:
            what = "" if other == path else ", which would replace it"
            raise _NoPlace(f"{text!r} sets the same value{what}; give only one of them")


class _NoPlace(Exception):
    """A path leads nowhere; says why."""


def _each(data: Any, path: tuple[str, ...], depth: int = 0) -> Iterator[tuple[str, ...]]:
    """The paths that a path with stars stands for; `data` is what its first parts lead to."""
    if EVERY not in path:
        yield path
        return
    if path[depth] != EVERY:
        yield from _each(data[_index(data, path[depth], path[:depth])], path, depth + 1)
        return
    if not (isinstance(data, dict | list) and data):
        raise _NoPlace(f"expected a table or a list for the {EVERY!r}, found {data!r}")
    for key in data if isinstance(data, dict) else range(1, len(data) + 1):
        whole = (*path[:depth], str(key), *path[depth + 1 :])
        yield from _each(data[_index(data, str(key), path[:depth])], whole, depth + 1)


def _set(data: dict[str, Any], keys: tuple[str, ...], value: Any) -> None:
    place: Any = data
    for depth, key in enumerate(keys[:-1]):
        if isinstance(place, dict) and key not in place and keys[: depth + 1] in MADE:
            place[key] = {}
        place = place[_index(place, key, keys[:depth])]
    last = keys[-1]
    if isinstance(place, dict):
        place[last] = value
    else:
        place[_index(place, last, keys[:-1])] = value


def _index(place: Any, key: str, before: tuple[str, ...]) -> Any:
    """The key of a table, or the index in a list, that a part of a path stands for."""
    where = ".".join(before) or "the file"
    if isinstance(place, dict):
        if key in place:
            return key
        known = list(place) if before else list(Case.model_fields)
        raise _NoPlace(f"there is no {key!r} in {where}{_hint(key, known)}")
    if isinstance(place, list):
        if key.isdecimal() and 1 <= int(key) <= len(place):
            return int(key) - 1
        raise _NoPlace(f"expected a number from 1 to {len(place)} after {where}, found {key!r}")
    raise _NoPlace(f"expected a table or a list at {where}, found {place!r}")


def _hint(key: str, known: list[str]) -> str:
    near = get_close_matches(key, known, n=3, cutoff=0.6)
    if near:
        return f"; did you mean {' or '.join(map(repr, near))}?"
    return f", expected one of {', '.join(map(repr, known))}" if known else ""


def _full_path(data: Mapping[str, Any], path: tuple[str, ...]) -> tuple[str, ...]:
    """The path through the segment that is meant by a key that no load has."""
    loads = data.get("loads")
    load = loads.get(path[1]) if isinstance(loads, dict) and len(path) == 3 else None
    if path[0] != "loads" or not isinstance(load, dict):
        return path
    kind = LOADS.get(str(load.get("type")))
    own = set(load) | (set(kind.model_fields) if kind else set())
    if path[2] in own:
        return path
    history = load.get("history")
    segments = [each for each in history if isinstance(each, dict)] if history else []
    number = _segment(segments, path[2], own, ".".join(path[:2]))
    return (*path[:2], "history", str(number), path[2])


def _segment(segments: list[dict[str, Any]], key: str, own: set[str], load: str) -> int:
    """Number of the only segment that has a key, or, if none has it, that could have it."""
    possible = [_keys(segment) for segment in segments]
    having = [n for n, segment in enumerate(segments, start=1) if key in segment]
    having = having or [n for n, keys in enumerate(possible, start=1) if key in keys]
    if len(having) == 1:
        return having[0]
    if having:
        paths = " or ".join(f"{load}.history.{number}.{key}" for number in having)
        raise _NoPlace(f"{len(having)} segments of the history have {key!r}; give {paths}")
    known = sorted(own | {name for keys in possible for name in keys})
    raise _NoPlace(f"no key of the load or of a segment of its history{_hint(key, known)}")


def _keys(segment: dict[str, Any]) -> set[str]:
    """Keys that a segment may have."""
    kind = (segment_kind(segment) or "").removeprefix(TAG)
    return set(KINDS[kind].model_fields) if kind else set(segment)


def by_key(value: Any, key: str = "") -> dict[str, Any]:
    """Single values by keys with dots; items of lists are numbered from 1, as with --set."""
    if isinstance(value, Mapping):
        items: Iterable[tuple[Any, Any]] = value.items()
    elif isinstance(value, list | tuple):
        items = enumerate(value, start=1)
    else:
        return {key: value}
    found: dict[str, Any] = {}
    for name, item in items:
        found |= by_key(item, f"{key}.{name}" if key else str(name))
    return found
