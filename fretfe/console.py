# SPDX-License-Identifier: LGPL-3.0-or-later
"""The console of rich for texts that may be of others."""

from __future__ import annotations

from typing import Any

import rich.console
from rich.text import Text

from fretfe.terminal import shown


class Console(rich.console.Console):
    """Prints texts and tables; shows in them what a terminal would take for commands."""

    def render_str(self, text: str, **options: Any) -> Text:
        """A text with its markup, through which all texts and cells of tables go."""
        return super().render_str(shown(text), **options)
