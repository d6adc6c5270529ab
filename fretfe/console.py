# SPDX-License-Identifier: LGPL-3.0-or-later
"""The console of rich for texts that may be of others."""

from __future__ import annotations

from typing import IO, Any, cast

import rich.console
from rich.text import Text

from fretfe.terminal import shown


class Console(rich.console.Console):
    """Prints texts and tables; shows in them what a terminal would take for commands."""

    @property
    def file(self) -> IO[str]:
        """The stream itself: a bar at the bottom stands between, and `Shown` behind that."""
        found = rich.console.Console.file.fget(self)  # type: ignore[attr-defined]
        while (inner := getattr(found, "rich_proxied_file", found)) is not found:
            found = inner
        return cast("IO[str]", found)

    @file.setter
    def file(self, new: IO[str]) -> None:
        self._file = new

    def render_str(self, text: str, **options: Any) -> Text:
        """A text with its markup, through which all texts and cells of tables go."""
        return super().render_str(shown(text), **options)
