# SPDX-License-Identifier: LGPL-3.0-or-later
"""`PYTHONPATH=tests python -m campaign [solids] [COUNT]`: are numbers right, flagged or wrong?

Progress and each number that is wrong without a warning go to the standard error, the tables for
docs/validate.md to the standard output. One process for each processor.
"""

from __future__ import annotations

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from campaign.judge import QUANTITIES, Judged, judge_case
from campaign.judge_solids import SOLID_QUANTITIES, judge_solid
from campaign.tables import RESOLVED, RESOLVED_SOLIDS, tables

COUNT, SOLIDS = 300, 30


def main() -> None:
    """Judge the first cases, plane ones or solids, and print the tables."""
    words = sys.argv[1:]
    solids = words[:1] == ["solids"]
    count = int(words[-1]) if words[solids:] else SOLIDS if solids else COUNT
    judge = judge_solid if solids else judge_case
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    judged: list[Judged] = []
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for done, numbers in enumerate(pool.map(judge, range(count)), start=1):
            judged += numbers
            for each in numbers:
                if each.verdict == "wrong":
                    _tell(f"\n{each.text}\n")
            _tell(f"\r{done} of {count}")
    _tell("\n")
    kinds = (SOLID_QUANTITIES, RESOLVED_SOLIDS) if solids else (QUANTITIES, RESOLVED)
    print(tables(judged, *kinds))


def _tell(text: str) -> None:
    print(text, end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
