# SPDX-License-Identifier: LGPL-3.0-or-later
"""A digest among the numbers of a run, by which one sees that others were changed since.

It tells damage and mistakes, not malice: whoever changes numbers can change the digest.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

KEY = "digest"


def with_digest(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Numbers in plain types of JSON, and behind them the digest of all."""
    return {**numbers, KEY: _digest(numbers)}


def are_unchanged(numbers: Mapping[str, Any]) -> bool:
    """True if the digest among numbers is that of the others."""
    others = {name: value for name, value in numbers.items() if name != KEY}
    return bool(numbers.get(KEY) == _digest(others))


def _digest(numbers: Mapping[str, Any]) -> str:
    return sha256(json.dumps(numbers).encode()).hexdigest()
