# SPDX-License-Identifier: LGPL-3.0-or-later
"""`PYTHONPATH=tests python -m campaign [COUNT]`: how many numbers are right, flagged or wrong.

Progress and each number that is wrong without a warning go to the standard error, the tables for
docs/validate.md to the standard output.
"""

from __future__ import annotations

import sys

from campaign.draw import draw
from campaign.judge import Judged, judge, solve
from campaign.tables import tables

COUNT = 300


def main() -> None:
    """Judge the first cases and print the tables."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    judged: list[Judged] = []
    for number in range(count):
        numbers = list(judge(solve(draw(number))))
        judged += numbers
        for each in numbers:
            if each.verdict == "wrong":
                print(
                    f"wrong: case {number}, {each.edge} edge, {each.quantity} = {each.value:.5g} "
                    f"± {each.bar:.2g}, should be {each.truth:.5g} ± {each.allowance:.2g}",
                    file=sys.stderr,
                    flush=True,
                )
        print(f"\r{number + 1} of {count}", end="", file=sys.stderr, flush=True)
    print("\n" + tables(judged))


if __name__ == "__main__":
    main()
