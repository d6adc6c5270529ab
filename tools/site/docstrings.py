# SPDX-License-Identifier: LGPL-3.0-or-later
"""Docstrings as plain text: formulas in them are no markup of reStructuredText."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx

ALIAS = re.compile(r"TypeAliasForwardRef\('(\w+)'\)")
LITERAL = re.compile(r"(`[^`]*`)")
SPECIAL = re.compile(r"(?<!\*)([*|])(?!\*)|(?<=\w)(_)(?=[|^])")


def escaped(line: str) -> str:
    """A line in which E*, |Q| and int_|x| stay what they are."""
    parts = LITERAL.split(line)
    parts[::2] = [SPECIAL.sub(lambda found: "\\" + found[0], part) for part in parts[::2]]
    return "".join(parts)


def indent_of(line: str) -> int:
    """Number of spaces that a line begins with."""
    return len(line) - len(line.lstrip())


def plain(lines: list[str]) -> list[str]:
    """Lines in which paragraphs that are set in are formulas, to be shown as they are."""
    done: list[str] = []
    above, outer = "", -1
    for number, line in enumerate(lines):
        after_gap = number > 0 and not lines[number - 1].strip()
        inside = outer >= 0 and (not line.strip() or indent_of(line) > outer)
        if not inside:
            outer = -1
            if line.strip() and after_gap and indent_of(line) > indent_of(above) and above:
                outer = indent_of(above)
                done += [" " * outer + "::", ""]
        done.append(line if outer >= 0 else escaped(line))
        above = line if line.strip() else above
    return done


def rewrite(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Rewrite a docstring in place."""
    lines[:] = plain(lines)


def signature(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, arguments: str | None, returns: str
) -> tuple[str | None, str] | None:
    """Name the types inside of other types, as in Callable[[Array], Array]."""
    if arguments is None or "TypeAliasForwardRef" not in arguments:
        return None
    return ALIAS.sub(r"\1", arguments), returns


def setup(app: Sphinx) -> dict[str, bool]:
    """Come before napoleon, which works at priority 500."""
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", rewrite, priority=400)
    app.connect("autodoc-process-signature", signature)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
