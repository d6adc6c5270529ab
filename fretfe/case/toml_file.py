# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tables of TOML files, and what is wrong with files that have none, in words."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fretfe.errors import CaseError
from fretfe.files import require_file

# Tables and lists within one another; the deepest of a case are the points of a selector.
DEEPEST = 20
TOO_DEEP = f"expected tables and lists at most {DEEPEST} deep in one another, found deeper ones"
# Keys of all tables of a case: each of them is looked at, and may be a problem to be told.
MOST_KEYS = 1000 * DEEPEST
# What tomllib reads in a second; histories with so many values go into CSV files.
LARGEST_FILE = 50 * MOST_KEYS
TOO_MANY = (
    f"expected at most {MOST_KEYS} keys in all tables, found {{}}; long histories go into CSV files"
)


def read_tables(source: Path, what: str) -> dict[str, Any]:
    """Read the tables of a TOML file.

    Args:
        source: the file.
        what: it is expected to be, for messages.

    Raises:
        CaseError: if it cannot be read, or is not TOML.
    """
    text = _read(source, what)
    # To read them would take a minute.
    if (keys := text.count("=") + text.count("\n[")) > MOST_KEYS:
        raise CaseError(f"{source}: {TOO_MANY.format(keys)}")
    try:
        data: dict[str, Any] = plain_value(tomllib.loads(text))
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{source}: {_syntax_problem(str(error), text)}") from None
    except RecursionError:
        raise CaseError(f"{source}: {TOO_DEEP}") from None
    except ValueError as error:
        # A number with more digits than Python reads.
        raise CaseError(f"{source}: expected numbers that can be read, found: {error}") from None
    return data


def key_count(value: Any) -> int:
    """Number of keys of all tables in a value that a file or a program gives."""
    if isinstance(value, Mapping):
        return len(value) + sum(map(key_count, value.values()))
    return sum(map(key_count, value)) if isinstance(value, list | tuple) else 0


def plain_value(value: Any, depth: int = 0) -> Any:
    """A copy in the types that TOML has: numbers and arrays of NumPy as those of Python.

    Args:
        value: that a file or a program gives.
        depth: of tables and lists that it is in.

    Raises:
        RecursionError: where tables and lists are in one another deeper than any case has.
    """
    if depth > DEEPEST:
        raise RecursionError
    if isinstance(value, Mapping):
        return {key: plain_value(each, depth + 1) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain_value(each, depth + 1) for each in value]
    return value.tolist() if hasattr(value, "tolist") else value


def _read(source: Path, what: str) -> str:
    require_file(source, what, CaseError)
    try:
        if (size := source.stat().st_size) > LARGEST_FILE:
            text = f"of at most {LARGEST_FILE:g} bytes, found {size}; CSV files hold more"
            raise CaseError(f"{source}: expected {what} {text}")
        return source.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        found = f"bytes in line {line} that are not UTF-8 text"
    except OSError as error:
        found = f"a file that cannot be read ({error.strerror})"
    raise CaseError(f"{source}: expected {what}, found {found}")


def _syntax_problem(message: str, text: str) -> str:
    """Line, column and reason from the message of tomllib."""
    reason, _, place = message.rpartition(" (at ")
    numbers = re.findall(r"\d+", place)
    if not numbers:
        lines = text.split("\n")
        numbers = [str(len(lines)), str(len(lines[-1]) + 1)]
        reason += " (the file ends here)"
    hint = _comma_hint(text, *map(int, numbers[:2]))
    return f"line {numbers[0]}, column {numbers[1]}: not valid TOML: {reason}{hint}"


def _comma_hint(text: str, line: int, column: int) -> str:
    """Advice if the syntax is broken by the comma of a decimal number."""
    for match in re.finditer(r"=[ \t]*([-+]?\d+),(\d+)[ \t]*", text.split("\n")[line - 1]):
        if match.start() < column <= match.end() + 1:
            return f"; a decimal number is written with a point: {match[1]}.{match[2]}"
    return ""
