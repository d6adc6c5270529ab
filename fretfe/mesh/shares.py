# SPDX-License-Identifier: LGPL-3.0-or-later
"""Processes shared out to bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def share_out(work: Sequence[float], ranks: int) -> list[tuple[tuple[int, ...], int]]:
    """Bodies and number of ranks of each group, so that the busiest rank has as little as possible.

    Args:
        work: of each body.
        ranks: number of all ranks.
    """
    if ranks >= len(work):
        shares = np.ones(len(work), dtype=np.int64)
        for _ in range(ranks - len(work)):
            shares[np.argmax(np.array(work) / shares)] += 1
        return [((body,), int(share)) for body, share in enumerate(shares)]
    groups: list[list[int]] = [[] for _ in range(ranks)]
    for body in np.argsort(work, kind="stable")[::-1]:
        least = min(groups, key=lambda group: sum(work[each] for each in group))
        least.append(int(body))
    return [(tuple(sorted(group)), 1) for group in groups]
