# SPDX-License-Identifier: LGPL-3.0-or-later
"""Verdicts of all comparisons: of a run, of `verify`, `validate`, `compare`, and of limits."""

from __future__ import annotations

from enum import StrEnum
from typing import Self


class Verdict(StrEnum):
    """Outcomes of comparisons: the word that is printed and written, and its meaning.

    Attributes:
        meaning: in words.
    """

    meaning: str

    def __new__(cls, word: str, meaning: str) -> Self:
        """A member, which is its word, with its meaning."""
        member = str.__new__(cls, word)
        member._value_, member.meaning = word, meaning
        return member

    AGREES = "agrees", "the difference is within the tolerance"
    DIFFERS = "differs", "the difference is larger than the tolerance"
    OUTSIDE = (
        "outside",
        "it is larger, but the formula is not meant for this: an answer, no failure",
    )
    DEPENDS = "depends", "the answer depends on how the cycle was reached"
    UNKNOWN = "unknown", "a number that matters is not known, or not well enough"
    NO_VERDICT = "no verdict", "there is nothing to compare"
    # Why there is nothing to compare at a slip zone.
    NOT_RESOLVED = "not resolved", "too few nodes slip, or the inner end cannot be located"
    GROSS = "gross", "the whole contact slips"
    END = "end", "too near a free end for the fields of an edge"
    NO_ZONE = "no slip zone", "nothing slips, and nothing could"
    # Of limits of the model.
    WITHIN = "within", "the limit is kept"
    EXCEEDED = "exceeded", "the limit is exceeded"
    NOT_MEASURED = "not measured", "there is nothing to compare with the limit"
    # Of benchmarks and of negative controls, which have to differ.
    SKIPPED = "skipped", "a backend cannot solve this"
    FAILED = "failed", "a backend should have solved this, and did not"
    CAUGHT = "caught", "the control differs, as it has to"
    NOT_CAUGHT = "not caught", "the control agrees, though it was spoilt on purpose"
