# SPDX-License-Identifier: LGPL-3.0-or-later
"""`PYTHONPATH=tests python -m campaign [COUNT]`: how many numbers are right, flagged or wrong.

Progress and each number that is wrong without a warning go to the standard error, the tables for
docs/validate.md to the standard output. One process for each processor.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from campaign.judge import Judged, judge_case
from campaign.tables import tables

COUNT = 300


def main() -> None:
    """Judge the first cases and print the tables."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    judged: list[Judged] = []
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for done, numbers in enumerate(pool.map(judge_case, range(count)), start=1):
            judged += numbers
            for each in numbers:
                if each.verdict == "wrong":
                    _tell(f"\n{each.text}\n")
            _tell(f"\r{done} of {count}")
    _tell("\n")
    print(tables(judged))


def _tell(text: str) -> None:
    print(text, end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
