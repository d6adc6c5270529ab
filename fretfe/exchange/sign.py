# SPDX-License-Identifier: LGPL-3.0-or-later
"""The sign that a pressure has in a file of another program."""

from __future__ import annotations

from enum import StrEnum


class Sign(StrEnum):
    """Of a normal stress in compression."""

    POSITIVE = "positive"
    NEGATIVE = "negative"
