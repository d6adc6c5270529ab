# SPDX-License-Identifier: LGPL-3.0-or-later
"""`PYTHONPATH=tests python -m campaign [moving] [solids] [unlike] [irregular] [elements] [COUNT]`.

Irregular histories are drawn from the seed of the week, or from FRETFE_CAMPAIGN_SEED.

Right or wrong? "irregular" judges half-planes, "irregular elements" finite elements.

Progress and each number that is wrong without a warning go to the standard error, the tables for
docs/validate.md to the standard output. One process for each processor.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

from campaign.extent import SEED
from campaign.irregular import judge_irregular, judge_irregular_elements
from campaign.irregular_tables import coverage
from campaign.judge import QUANTITIES, Judged, judge_case, judge_moving
from campaign.judge_solids import SOLID_QUANTITIES, judge_moving_solid, judge_solid
from campaign.tables import RESOLVED, RESOLVED_SOLIDS, kinds, tables
from campaign.unlike import UNLIKE_QUANTITIES, judge_moving_unlike, judge_unlike

# How many are judged if nothing is said, and by what, by the words.
COUNTS = {"": 300, "moving": 100, "solids": 30, "moving solids": 40, "unlike": 60}
COUNTS |= {"moving unlike": 40, "irregular": 400, "irregular elements": 400}
JUDGES: dict[str, Callable[[int], list[Judged]]] = {
    "": judge_case,
    "moving": judge_moving,
    "solids": judge_solid,
    "moving solids": judge_moving_solid,
    "unlike": judge_unlike,
    "moving unlike": judge_moving_unlike,
    "irregular": partial(judge_irregular, seed=SEED),
    "irregular elements": partial(judge_irregular_elements, seed=SEED),
}


def main() -> None:
    """Judge the first cases: plane ones, those with loads that move much, solids or half-planes."""
    words = sys.argv[1:]
    which = " ".join(word for word in words if not word.isdecimal())
    count = next((int(word) for word in words if word.isdecimal()), COUNTS[which])
    judge = JUDGES[which]
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
    if which.startswith("irregular"):
        print(coverage(judged))
        return
    of_solids, plane = (SOLID_QUANTITIES, RESOLVED_SOLIDS), (QUANTITIES, RESOLVED)
    unlike = (UNLIKE_QUANTITIES, RESOLVED)
    print(
        tables(
            judged, *(of_solids if "solids" in which else unlike if "unlike" in which else plane)
        )
    )
    if which == "moving":
        print(f"\n{kinds(judged)}")


def _tell(text: str) -> None:
    print(text, end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
