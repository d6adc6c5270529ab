# SPDX-License-Identifier: LGPL-3.0-or-later
"""`cd tests; python -m faults [WORD ...]`: what becomes of malformed and hostile inputs.

All inputs, or those with one of the words in their name. What is wrong goes to the standard error,
a table to the standard output. One process for each processor.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

from faults.every import all_faults
from faults.judge import BAD, GOOD, Verdict, judge_all
from faults.originals import write_originals


def main() -> int:
    """Judge them, print a table; the number of those that are wrong."""
    words = sys.argv[1:]
    faults = [
        (number, fault)
        for number, fault in enumerate(all_faults())
        if not words or any(word in fault.name for word in words)
    ]
    with tempfile.TemporaryDirectory(prefix="faults-") as name:
        good, arena = Path(name) / "good", Path(name) / "arena"
        good.mkdir()
        arena.mkdir()
        write_originals(good)
        verdicts = judge_all(good, arena, faults, _tell, len(os.sched_getaffinity(0)))
    _print(verdicts)
    return sum(each.kind in BAD for each in verdicts)


def _tell(verdict: Verdict) -> None:
    wrong = verdict.kind in BAD
    if wrong or verdict.seconds > 30:
        text = f"{verdict.kind}: {verdict.fault.name} ({verdict.seconds:.0f} s)\n"
        sys.stderr.write(text + (f"    {verdict.text}\n" if wrong else ""))


def _print(verdicts: list[Verdict]) -> None:
    kinds = (*GOOD, *BAD)
    print(f"| {'input':16} | {' | '.join(f'{kind:>9}' for kind in kinds)} |")
    print(f"|{'-' * 18}|{'|'.join('-' * 11 for _ in kinds)}|")
    counts: dict[str, Counter[str]] = {}
    for each in verdicts:
        source = each.fault.name.split("/")[0].split(" ")[0]
        counts.setdefault(source, Counter())[each.kind] += 1
    counts["all"] = sum(counts.values(), Counter())
    for source, found in counts.items():
        print(f"| {source:16} | {' | '.join(f'{found[kind]:9}' for kind in kinds)} |")
    slowest = max(verdicts, key=lambda each: each.seconds)
    print(f"\nslowest: {slowest.seconds:.0f} s, {slowest.fault.name}")


if __name__ == "__main__":
    sys.exit(min(main(), 1))
