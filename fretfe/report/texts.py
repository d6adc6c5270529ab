# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers as text, with no more digits than they are worth, and empty tables for them.

Nothing that computes is imported: commands that compute nothing print with these too.
"""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

    from fretfe._typing import Array

# Stands for a number that does not exist.
MISSING = "-"
# Numbers below this are shown in smaller units, of lengths by thousands.
SMALL = 0.01
SMALLER = {"m": ("mm", "µm", "nm"), "mm": ("µm", "nm")}
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Characters in a line of a table, more than any has.
WIDEST = 1000


def number(value: float, digits: int = 4) -> str:
    """A number with so many significant digits, and an exponent as in 1.55e4."""
    # Without a minus before zero.
    return short(f"{value + 0.0:.{digits}g}") if math.isfinite(value) else MISSING


def short(text: str) -> str:
    """The text of a number without plus and zeros in its exponent."""
    return re.sub(r"e(-?)\+?0*", r"e\1", text)


def with_prefix(unit: str, largest: float) -> tuple[float, str]:
    """A divisor of numbers after which four digits need no exponent, and their unit.

    Args:
        unit: a label. Large numbers of units that begin with N, for newton, take a prefix; small
            ones that of a smaller length, or a power of ten.
        largest: of the numbers.
    """
    if 0.0 < largest < SMALL:
        thousands = math.floor(2 / 3 - math.log10(largest) / 3)
        smaller = SMALLER.get(unit, ())
        if thousands <= len(smaller):
            return 1e-3**thousands, smaller[thousands - 1]
        power = str(-3 * thousands).translate(RAISED)
        return 1e-3**thousands, f"10{power} {unit}"
    prefixes = {1e7: (1e6, "M"), 1e4: (1e3, "k")}
    if unit.partition("/")[0] == "N":
        for limit, (scale, prefix) in prefixes.items():
            if largest >= limit:
                return scale, prefix + unit
    return 1.0, unit


def percent(value: float, decimals: int = 2) -> str:
    """A fraction in per cent."""
    # Without a minus before zero.
    return f"{round(value, decimals + 2) + 0.0:.{decimals}%}" if math.isfinite(value) else MISSING


def with_error(value: float, spread: float) -> str:
    """Value and error, with two digits of the error: 0.5749 ± 0.0012.

    Six digits without an error if that is zero or not known; marked if it exceeds a value that is
    not zero.
    """
    if not math.isfinite(value):
        return MISSING
    if not (math.isfinite(spread) and spread > 0.0):
        return f"{value:.6g}"
    digits = 1 - math.floor(math.log10(spread))
    if digits < -3 or digits > 9:  # numbers with an exponent
        text = f"{short(f'{value:.6g}')} ± {short(f'{spread:.2g}')}"
    else:
        decimals = max(digits, 0)
        text = f"{value:.{decimals}f} ± {spread:.{decimals}f}"
    return marked(text, uncertain=spread > abs(value) > 0)


def marked(text: str, uncertain: bool) -> str:
    """A number with ~ before it if it is uncertain; what is missing carries no mark."""
    plain = text == MISSING or text.startswith("~")
    return f"~{text}" if uncertain and not plain else text


def rounded(value: float, digits: int = 3) -> str:
    """A number with so many significant digits; no exponent from 1e-4 to 1e7."""
    if not math.isfinite(value):
        return MISSING
    return short(f"{float(f'{value + 0.0:.{digits}g}'):.7g}")


def beyond(value: float, limit: float, digits: int = 2) -> str:
    """A number beyond a limit with so many digits, or as many as it takes to see that it is."""
    texts = (rounded(value, each) for each in range(digits, 7))
    return next((text for text in texts if text != rounded(limit, 7)), rounded(value, 7))


def direction_text(direction: Array) -> str:
    """A direction in words: an axis of the case, or its components."""
    place = int(abs(direction).argmax())
    if abs(direction[place]) > 1 - 1e-6:
        return f"{'' if direction[place] > 0 else '−'}{'xyz'[place]}"
    return "(" + ", ".join(f"{value + 0.0:.2f}" for value in direction.round(2)) + ")"


def plain_table(title: str, headers: tuple[str, ...], text: int) -> Table:
    """An empty table whose first `text` columns hold text and the others numbers."""
    from rich import box
    from rich.table import Table

    table = Table(title=title, title_justify="left", box=box.SIMPLE, title_style="bold")
    table.pad_edge = False
    table.padding = (0, 1, 0, 0)
    for place, header in enumerate(headers):
        table.add_column(header, justify="left" if place < text else "right", no_wrap=True)
    return table


def print_whole(table: Table) -> None:
    """Print a table as wide as it is: a narrow terminal wraps lines rather than cuts numbers."""
    from rich.measure import Measurement

    from fretfe.console import Console

    console = Console()
    width = Measurement.get(console, console.options.update(max_width=WIDEST), table).maximum
    Console(width=max(width, console.width)).print(table)
