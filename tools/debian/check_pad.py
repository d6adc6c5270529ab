# SPDX-License-Identifier: LGPL-3.0-or-later
"""Compare results of the README's pad with half-planes, and those of other folders with them.

`python3 tools/debian/check_pad.py RESULTS OTHERS...`: ends with a message if they differ.
"""

from __future__ import annotations

import sys
from math import isclose

import fretfe

# K_N of two half-planes in MPa/√mm, as the README tells it; the pad is a body of finite size.
HALF_PLANES, DIFFERENCE = 1237.8, 5e-3
# Between numbers of processes only the order of sums differs.
ROUNDING = 1e-6


def k_n(folder: str) -> list[float]:
    """K_N at the edges of the pad, in MPa/√mm."""
    return [edge["k_n"] for edge in fretfe.load_result(folder).edges()]


def main() -> None:
    """Compare K_N at both edges."""
    first, *others = sys.argv[1:]
    found = k_n(first)
    if len(found) != 2 or not all(isclose(each, HALF_PLANES, rel_tol=DIFFERENCE) for each in found):
        sys.exit(
            f"{first}: expected K_N of about {HALF_PLANES} MPa/√mm at two edges, found {found}"
        )
    for folder in others:
        again = k_n(folder)
        if not all(isclose(*pair, rel_tol=ROUNDING) for pair in zip(found, again, strict=True)):
            sys.exit(f"{folder}: expected K_N as in {first}, {found}, found {again}")


if __name__ == "__main__":
    main()
